//! Goal: a calibration does not hang on how its recording is written.
//! Setup: one recording at 15 psi, with noise, losses and ghosts, as tables in millimetres, metres and inches, with
//! markers in the order of the cameras, backwards and mixed, in the file and in the experiment.
//! Expected: EI, alpha and beta to twice a fiftieth of their standard errors.

use std::fmt::Write;
use std::path::Path;

use efam_experiments::cleaning::clean_all;
use efam_inference::calibrate::Calibration;
use efam_recordings::{Length, ReadOptions, Recording, parse};
use tests::twin::random::Random;
use tests::twin::sensor::Cameras;
use tests::twin::study::{PATHS, damped_muscle, experiment, fit, session, truth};

const PSI: f64 = 15.0;
/// Share of a standard error by which two answers may differ: each search takes itself to have arrived within a
/// fiftieth.
const MOVED: f64 = 2.0 * 0.02;

/// A recording as a table in some unit, with its markers in some order.
fn table(recording: &Recording, unit: Length, order: &[usize]) -> String {
    let mut text = "t_s".to_owned();
    for k in order {
        for axis in ["x", "y", "z"] {
            let _ = write!(text, ",{}_{axis}_{}", recording.markers[*k].name, unit.symbol());
        }
    }
    for (row, time) in recording.time.iter().enumerate() {
        let _ = write!(text, "\n{time:?}");
        for k in order {
            match recording.markers[*k].position[row] {
                Some(at) => at.iter().for_each(|at| {
                    let _ = write!(text, ",{:?}", at / unit.metres());
                }),
                None => text.push_str(",,,"),
            }
        }
    }
    text + "\n"
}

fn calibrated(recording: &Recording, unit: Length, order: &[usize]) -> Calibration {
    let text = table(recording, unit, order).into_bytes();
    let read = parse(text, Path::new("twin.csv"), &ReadOptions::default()).expect("a tidy table");
    let of_experiment = experiment(PSI, read.markers.iter().rev().map(|marker| &marker.name[..]));
    let cleaned = clean_all(&of_experiment, vec![read]);
    let releases = cleaned.expect("six releases").releases.into_iter().map(|own| own.release).collect();
    let truth = truth(&damped_muscle(PSI));
    fit(PSI, releases, [0.9 * truth[0], 1.2 * truth[1], 1.2 * truth[2]])
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn units_and_the_order_of_markers_change_nothing() {
    let mut random = Random::new(55);
    let session = session(PSI, 6.0, &mut random);
    let beam = &session.beam;
    let recording =
        Cameras::usual(0.3e-3, beam.length, beam.bodies[0].center, &[]).record(&session, &mut random);
    let forwards: Vec<usize> = (0..recording.markers.len()).collect();
    let backwards: Vec<usize> = forwards.iter().rev().copied().collect();
    let mixed: Vec<usize> = forwards.iter().map(|k| (3 * k + 2) % forwards.len()).collect();
    let first = calibrated(&recording, Length::Millimetre, &forwards);
    for (unit, order) in [(Length::Metre, backwards), (Length::Inch, mixed)] {
        let other = calibrated(&recording, unit, &order);
        for path in PATHS {
            let [a, b] = [&first, &other].map(|found| found.of(path)[0].clone());
            let error = a.standard_error.expect("it is determined");
            println!("{path}: {} and {} ± {error}", a.value, b.value);
            assert!(
                (a.value - b.value).abs() < MOVED * error,
                "{path}: {} and {} ± {error}",
                a.value,
                b.value
            );
        }
    }
}
