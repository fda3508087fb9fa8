//! What a diagnosis takes from an experiment: the problem of its calibration, with losses that all pressures share, and something
//! held out.

use std::sync::Arc;

use efam_experiments::cleaning::Cleaned;
use efam_experiments::experiment::{Experiment, ExperimentError};
use models::effects::Catalogue;
use models::nearest::{nearest, offer};

use crate::calibrate::unknowns::ALPHA;
use crate::calibrate::waves::BETA;
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
    hold_out(&mut problem);
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

/// Noise below which a difference of fit and recording says nothing, m: what is left of mesh and step.
pub(super) const LEAST_NOISE: f64 = 1e-5;

/// Standard deviation of the prior of a bending stiffness, over its stated value, of a rod that is no muscle of a
/// table: as a bending test has it.
const STIFFNESS: f64 = 0.05;

/// Makes what [rod] says of its bending stiffness a prior. Where it is free, a mass at the tip and a softer rod do the
/// same. An experiment that lists its parameters states the prior of each.
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

/// Releases from which on one is held out: with fewer it is worth more in the fit.
const MANY: usize = 5;

/// Holds the last release out if the experiment holds none out, and has many.
fn hold_out(problem: &mut Problem) {
    let is_held_out = problem.trials.iter().any(|trial| trial.release.held_out);
    if let (false, MANY.., Some(last)) = (is_held_out, problem.trials.len(), problem.trials.last_mut()) {
        Arc::make_mut(last).release.held_out = true;
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
