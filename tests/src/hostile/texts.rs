//! Scenarios, experiments, muscles, and what is set over them.

use std::path::Path;

use efam_experiments::cleaning::{CleanRelease, Cleaned, Statistics};
use efam_experiments::experiment::Experiment;
use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use efam_experiments::scenario::{Scenario, ScenarioError};
use efam_inference::diagnose::problem;
use models::muscle::{Extrapolation, Here, Known, Muscle};

use super::is_message;

const SCENARIO: &str = include_str!("../../../scenarios/release-15psi.toml");
const EXPERIMENT: &str = include_str!("../../../scenarios/diagnosis/nothing/experiment.toml");

/// Lines that are looked at of what is set.
const LINES: usize = 20;
/// Recordings of an experiment, and rows of a muscle, whose models are built.
const BUILT: usize = 3;

/// A scenario: what it says is a case, or has a place and a reason; a case is what its own text says.
pub fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    cases(Scenario::parse(Path::new("a.toml"), text, &[]));
}

fn cases(read: Result<Scenario, ScenarioError>) {
    let cases = read.and_then(|scenario| {
        scenario.without_files();
        scenario.cases()
    });
    match cases {
        Err(error) => refused(&error),
        Ok(cases) => {
            for case in cases.iter().take(BUILT) {
                let again = Scenario::parse(Path::new("a.toml"), &case.resolved(), &[]);
                let again = again.and_then(|scenario| scenario.cases());
                let again = again.unwrap_or_else(|error| panic!("{error}\n{}", case.resolved()));
                let bits = |theta: &[f64]| theta.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&again[0].model.theta), bits(&case.model.theta), "{}", case.resolved());
            }
        }
    }
}

fn refused(error: &ScenarioError) {
    is_message(&error.message());
    // The whole of a `--set` is said.
    if error.at.as_ref().is_none_or(|at| at.file != "--set") {
        is_message(&error.to_string());
    }
}

/// An experiment, likewise; short recordings replace its own.
pub fn experiment(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    models(Experiment::parse(Path::new("a.toml"), text, &[]));
}

fn models(read: Result<Experiment, efam_experiments::experiment::ExperimentError>) {
    match read {
        Err(error) => is_message(&error.to_string()),
        Ok(experiment) => {
            for recording in 0..experiment.recordings.len().min(BUILT) {
                if let Err(error) = experiment.case(recording, None) {
                    is_message(&error.to_string());
                }
            }
            // The diagnosis requires all that the calibration does.
            if let Err(error) = problem(&experiment, &short(&experiment)) {
                is_message(&error.to_string());
            }
        }
    }
}

/// What a cleaned experiment looks like: two releases of each of its first recordings, and next to nothing in them.
fn short(experiment: &Experiment) -> Cleaned {
    let of = |recording: usize| {
        let entry = &experiment.recordings[recording];
        [1, 2].map(|number| CleanRelease {
            release: Release {
                name: format!("{recording}#{number}"),
                time: vec![0.0, 0.01, 0.02],
                release_uncertainty: 1e-3,
                tracks: vec![Track {
                    marker: "tip".to_owned(),
                    at: Point::Tip,
                    position: vec![Some([0.2, 0.0]), None, Some([0.2, -1e-3])],
                    noise: 3e-4,
                    discrepancy: 0.0,
                }],
                pressure: entry.pressure,
                payload: 0.0,
                held_out: entry.is_held_out(number),
                out_of_plane: OutOfPlane::default(),
            },
            recording,
            number,
            instant: 1.0,
            swings_until: 0.02,
            angle: None,
            dropped: None,
            representative: false,
            statistics: Statistics::default(),
        })
    };
    let releases = (0..experiment.recordings.len().min(BUILT)).flat_map(of).collect();
    Cleaned { recordings: Vec::new(), releases, decisions: Vec::new() }
}

/// Lines that are set over a scenario and over an experiment.
pub fn set(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let lines: Vec<String> = text.lines().take(LINES).map(str::to_owned).collect();
    cases(Scenario::parse(Path::new("a.toml"), SCENARIO, &lines));
    match Experiment::parse(Path::new("a.toml"), EXPERIMENT, &lines) {
        Err(efam_experiments::experiment::ExperimentError::Document(error)) => refused(&error),
        read => models(read),
    }
}

/// A muscle: at any pressure it has finite numbers, or says why not.
pub fn muscle(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let muscle = match Muscle::from_toml(text) {
        Ok(muscle) => muscle,
        Err(error) => return is_message(&error.to_string()),
    };
    let (low, high) = muscle.pressure_range();
    let sources: Vec<&str> = muscle.stiffness_sources().take(BUILT).collect();
    for pressure in [low, 0.5 * low + 0.5 * high, high, 2.0 * high - low] {
        for source in &sources {
            match muscle.at(pressure, source, Extrapolation::Allowed) {
                Err(error) => is_message(&error.to_string()),
                Ok(at) => assert!(at.length > 0.0 && at.bending_stiffness.is_finite(), "{at:?}"),
            }
        }
    }
    if let Some(known) = &muscle.known {
        let at = known.at(0.5 * low + 0.5 * high, &|_| Here { value: 1.0, scale: 1.0 });
        assert_eq!(at.covariance.len(), at.paths.len());
        let again = Known::read(&known.section());
        assert_eq!(again.expect("what was written is read").as_ref(), Some(known));
    }
}
