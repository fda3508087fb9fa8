//! What a diagnosis takes from an experiment: the problem of its calibration, with losses that all
//! pressures share, and something held out.

use std::sync::Arc;

use efam_experiments::cleaning::Cleaned;
use efam_experiments::experiment::{Experiment, ExperimentError};
use models::effects::Catalogue;
use models::nearest::{nearest, offer};

use crate::calibrate::problem::is_same_pressure;
use crate::calibrate::unknowns::{ALPHA, FARTHEST};
use crate::calibrate::waves::{BETA, damp_waves};
use crate::calibrate::{
    FittedParameter, Prior, Problem, Scope, SectionError, problem as calibration_problem,
};

/// Losses that all pressures share unless the experiment says otherwise: one for each would hide how a
/// missing effect grows with the pressure.
pub(super) const SHARED: [&str; 2] = [ALPHA, BETA];

/// The problem of an experiment.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub fn problem(experiment: &Experiment, cleaned: &Cleaned) -> Result<Problem, SectionError> {
    let mut problem = parameters(experiment, cleaned)?;
    let tracks = problem.trials_mut().flat_map(|trial| &mut trial.release.tracks);
    tracks.for_each(|track| track.noise = track.noise.max(LEAST_NOISE));
    admit_tilt(&mut problem, USUAL_TILT);
    lock_away(&mut problem);
    Ok(problem)
}

/// The problem of a calibration; unless the experiment lists its parameters, all pressures share the losses, and a stated
/// stiffness has a prior.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub(crate) fn parameters(experiment: &Experiment, cleaned: &Cleaned) -> Result<Problem, SectionError> {
    let (mut problem, _) = calibration_problem(experiment, cleaned)?;
    let section = experiment.section("calibrate")?;
    if section.tables("parameter").map_err(ExperimentError::from)?.is_empty() {
        for parameter in problem.parameters.iter_mut().filter(|own| SHARED.contains(&own.path.as_str())) {
            parameter.scope = Scope::Shared;
        }
        believe_stiffness(&mut problem, experiment);
    }
    Ok(problem)
}

/// What every diagnosis keeps to, whoever posed the problem: a setup within what is stated of it, and waves that are
/// damped.
pub(super) fn limit(problem: &mut Problem) {
    problem.nuisances.farthest = FARTHEST;
    limit_beliefs(problem);
    damp_waves(problem);
}

/// Noise below which a difference of fit and recording says nothing, m: what is left of mesh and step.
pub(super) const LEAST_NOISE: f64 = 1e-5;

/// Share of the stated bending stiffness of a rod that is no muscle of a table to which it is believed: as a bending
/// test has it.
const STIFFNESS: f64 = 0.05;

/// Makes what [rod] says of its bending stiffness a belief. Where it is free, a mass at the tip and a softer rod do the
/// same. An experiment that lists its parameters says of each what is believed.
pub(crate) fn believe_stiffness(problem: &mut Problem, experiment: &Experiment) {
    let Some(stated) = problem.trials.first().map(|trial| trial.model.rod().bending_stiffness) else {
        return;
    };
    if experiment.muscle().is_some() {
        return;
    }
    let is_stiffness = |own: &&mut FittedParameter| own.path == "rod.bending_stiffness";
    if let Some(own) = problem.parameters.iter_mut().find(is_stiffness) {
        own.prior = Some(Prior { mean: stated, deviation: STIFFNESS * stated });
    }
}

/// Keeps every belief of a parameter within its limit, where no bounds are given.
fn limit_beliefs(problem: &mut Problem) {
    let Some(trial) = problem.trials.first() else { return };
    let range = |path: &str| {
        trial
            .model
            .index(path)
            .map_or((f64::NEG_INFINITY, f64::INFINITY), |k| trial.model.parameters[k].range)
    };
    for own in problem.parameters.iter_mut().filter(|own| own.bounds.is_none()) {
        let Some(prior) = own.prior else { continue };
        let (least, most) = range(&own.path);
        let room = FARTHEST * prior.deviation;
        own.bounds = Some(((prior.mean - room).max(least), (prior.mean + room).min(most)));
    }
}

/// Standard deviation of what is believed of the cameras' vertical, rad: a third of a degree, as a calibration frame on a
/// floor has it.
pub(super) const USUAL_TILT: f64 = 5e-3;

/// Makes the tilt of the recordings' frame, one for each pressure, an unknown of no interest with a prior
/// about zero: a deviation in rad. Left out it would be taken for an effect of the muscle. Models that have
/// `frame_tilt` already stay as they are.
pub fn admit_tilt(problem: &mut Problem, deviation: f64) {
    let is_known = problem.trials.iter().all(|trial| trial.release.pressure.is_some());
    let scope = if is_known { Scope::PerPressure } else { Scope::Shared };
    if let Some(tilted) = problem.with_nuisance(TILT, "angle", scope, deviation) {
        *problem = tilted;
    }
}

/// The effect of a frame that is not level.
pub(super) const TILT: &str = "frame_tilt";

/// Locks releases away if the experiment has not: of three pressures or more the middle one, and of what is
/// left the last release, if two others stay.
fn lock_away(problem: &mut Problem) {
    if problem.trials.iter().any(|trial| trial.release.held_out) {
        return;
    }
    let pressures = problem.fitted_pressures();
    if pressures.len() >= 3 {
        let middle = pressures[pressures.len() / 2];
        for trial in problem.trials_mut() {
            let own = trial.release.pressure;
            trial.release.held_out = own.is_some_and(|own| is_same_pressure(own, middle));
        }
    }
    let left: Vec<usize> =
        (0..problem.trials.len()).filter(|t| !problem.trials[*t].release.held_out).collect();
    if left.len() >= 3 {
        Arc::make_mut(&mut problem.trials[left[left.len() - 1]]).release.held_out = true;
    }
}

/// Whether all effects that are to be left out are in the catalogue.
/// # Errors
/// The first that is not, and the name that may be meant.
pub fn known_effects(names: &[String], catalogue: &Catalogue) -> Result<(), String> {
    let Some(name) = names.iter().find(|name| catalogue.by_name(name).is_none()) else { return Ok(()) };
    let near = offer(nearest(name, catalogue.iter().map(|effect| effect.about().name)));
    Err(format!("there is no effect `{name}`{near}; `efam effects` lists all"))
}
