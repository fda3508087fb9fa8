//! What a diagnosis takes from an experiment: the problem of its calibration, with losses that all
//! pressures share, and something locked away.

use crate::calibrate::problem::is_same_pressure;
use crate::calibrate::{Problem, Scope, SectionError, problem as calibration_problem};
use crate::cleaning::Cleaned;
use crate::experiment::{Experiment, ExperimentError};

/// Losses that all pressures share unless the experiment says otherwise: one for each would hide how a
/// missing effect grows with the pressure.
const SHARED: [&str; 2] = ["effects.rayleigh_mass.alpha", "effects.rayleigh_stiffness.beta"];

/// The problem of an experiment.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub fn problem(experiment: &Experiment, cleaned: &Cleaned) -> Result<Problem, SectionError> {
    let (mut problem, _) = calibration_problem(experiment, cleaned)?;
    let section = experiment.section("calibrate")?;
    if section.tables("parameter").map_err(ExperimentError::from)?.is_empty() {
        for parameter in problem.parameters.iter_mut().filter(|own| SHARED.contains(&own.path.as_str())) {
            parameter.scope = Scope::Shared;
        }
    }
    lock_away(&mut problem);
    Ok(problem)
}

/// Locks releases away if the experiment has not: of three pressures or more the middle one, and of what is
/// left the last release, if two others stay.
fn lock_away(problem: &mut Problem) {
    if problem.trials.iter().any(|trial| trial.release.held_out) {
        return;
    }
    let pressures = problem.fitted_pressures();
    if pressures.len() >= 3 {
        let middle = pressures[pressures.len() / 2];
        for trial in &mut problem.trials {
            let own = trial.release.pressure;
            trial.release.held_out = own.is_some_and(|own| is_same_pressure(own, middle));
        }
    }
    let left: Vec<usize> =
        (0..problem.trials.len()).filter(|t| !problem.trials[*t].release.held_out).collect();
    if left.len() >= 3 {
        problem.trials[left[left.len() - 1]].release.held_out = true;
    }
}
