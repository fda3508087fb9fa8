//! The paper's Figures 4 to 9 from our own runs or from recordings, as the program and the Python package draw them.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::analyse::{Analysed, analyse};
use efam_experiments::analysis::static_stiffness::NODES;
use efam_experiments::cleaning::Cleaned;
use efam_experiments::experiment::Experiment;
use efam_experiments::scenario::{Case, Scenario};
use efam_report::Request;
use efam_report::figures::Words;
use efam_report::paper::{self, FiguresError, MUSCLE, Pressure, SCENARIO};
use rayon::prelude::*;

use crate::failure::Failure;

/// Runs of the paper's muscle at every pressure of its table.
pub struct Runs {
    /// Each of them.
    pub cases: Vec<Case>,
    /// What the folder says of their making.
    pub request: Request,
}

impl Runs {
    /// Those of the figures' scenario, with what is set over it.
    /// # Errors
    /// [`Failure`] for a scenario that cannot be, or is of another muscle.
    pub fn new(set: &[String]) -> Result<Self, Failure> {
        let scenario = Scenario::parse(Path::new("efam-figures.toml"), SCENARIO, set)?;
        if !scenario.is_all_rows() || scenario.muscle_name() != Some(MUSCLE) {
            let message = format!(
                "--set: the figures are those of {MUSCLE} at every pressure of its table; leave muscle.name, muscle.file and muscle.pressure as they are, or use efam simulate"
            );
            return Err(Failure::Usage(message));
        }
        let cases = scenario.cases()?;
        let mut warnings: Vec<String> = cases.iter().flat_map(|case| case.warnings.clone()).collect();
        warnings.dedup();
        let hash = |text: &str| efam_store::sha::sha256(text.as_bytes());
        let set: Vec<String> = set.iter().map(|set| format!("--set {set}")).collect();
        let mut input_hashes = BTreeMap::from([(efam_report::figures::SCENARIO.to_owned(), hash(SCENARIO))]);
        input_hashes.extend(set.iter().map(|set| (set.clone(), hash(set))));
        let request = Request {
            name: scenario.name.clone(),
            resolved_scenario: set.iter().map(|set| format!("# with {set}\n")).collect::<String>() + SCENARIO,
            warnings,
            input_hashes,
            ..Request::default()
        };
        Ok(Self { cases, request })
    }

    /// What the figures show of each, simulated by `follow`.
    /// # Errors
    /// [`Failure`] of the first case, in their order, that cannot be simulated; [`Failure::Interrupted`] for one that was
    /// cut short.
    pub fn pressures(
        &self,
        follow: &(dyn Fn(&Case) -> Result<Trajectory, Failure> + Sync),
    ) -> Result<Vec<Pressure>, Failure> {
        let one = |case: &Case| {
            let trajectory = follow(case)?;
            match &trajectory.status {
                Status::Failed { reason, .. } => Err(Failure::Diverged(format!("{}: {reason}", case.name))),
                Status::CutShort { .. } => Err(Failure::Interrupted),
                Status::Complete => {
                    Pressure::simulated(case, trajectory).map_err(|error| Failure::Usage(error.to_string()))
                }
            }
        };
        self.cases.par_iter().map(one).collect::<Vec<_>>().into_iter().collect()
    }
}

/// Refuses an experiment whose figures cannot be drawn, before it is analysed.
/// # Errors
/// [`Failure`].
pub fn admit(experiment: &Experiment) -> Result<(), Failure> {
    paper::admit(experiment).map_err(refused)
}

/// What the figures show of the releases of an experiment, and warnings.
/// # Errors
/// [`Failure`] for releases that cannot be analysed or shown.
pub fn of_recordings(
    experiment: &Experiment,
    cleaned: &Cleaned,
) -> Result<(Vec<Pressure>, Vec<String>), Failure> {
    let analysed = analyse(experiment, cleaned, &NODES)?;
    let all = paper::of_experiment(experiment, &analysed).map_err(refused)?;
    let shown = |one: &&Analysed| all.iter().any(|of| of.name == one.of.release.name);
    let of_releases = analysed.iter().filter(shown).flat_map(Analysed::warnings);
    let warnings = cleaned.warnings().into_iter().chain(of_releases).collect();
    Ok((all, warnings))
}

fn refused(error: FiguresError) -> Failure {
    match error {
        FiguresError::Experiment(error) => error.into(),
        FiguresError::Incomplete { .. } => Failure::Usage(error.to_string()),
    }
}

/// The figures in words.
pub fn table(words: &[Words]) -> String {
    let mut text = String::new();
    for of in words {
        let _ = writeln!(text, "Figure {}\n  paper: {}\n  ours:  {}", of.number, of.paper, of.ours);
    }
    text
}
