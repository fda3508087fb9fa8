//! Calibration: parameters of a model from measured releases, with their uncertainty.
//!
//! Nonlinear least squares on the paths of the markers themselves. [`Problem`] says which releases
//! and which parameters, [`calibrate()`] finds them, [`Calibration`] is what is written. Where the data
//! cannot tell parameters apart it is said in words, with the experiment that would.

mod autocorrelation;
pub mod calibration;
mod error;
mod identifiability;
mod levenberg_marquardt;
mod loss;
mod numerics;
mod objective;
mod outcome;
mod part;
mod prediction;
mod problem;
mod profile;
mod search;
mod section;
mod starts;
mod uncertainty;
mod unknowns;
mod warnings;

use rayon::prelude::*;

pub use calibration::Calibration;
pub use error::CalibrateError;
pub use outcome::{Curve, Outcome};
pub use problem::{Nuisances, Parameter, Prior, Problem, Scale, Scope, Trial};
pub use search::Stage;
pub use section::{SectionError, problem};

use numerics::{Correction, correction};
use objective::Objective;
use part::{Part, parts};
use prediction::Measured;
use search::{Found, search, settle};
use uncertainty::{Uncertainty, uncertainty};
use unknowns::Unknowns;

/// What is done beside the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Whether the errors of mesh and step are removed; without that the parameters belong to the
    /// mesh of the models.
    pub remove_mesh: bool,
    /// Whether to find intervals by the profile of the likelihood as well.
    pub profile: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { remove_mesh: true, profile: false }
    }
}

/// One part of a problem, fitted.
pub(crate) struct Fitted<'a> {
    part: Part<'a>,
    measured: Vec<&'a Measured>,
    found: Found,
    uncertainty: Uncertainty,
    numerics: Option<Correction>,
    /// By how many standard errors the numerics had moved each unknown.
    shift: Vec<f64>,
    /// By unknown, scaled.
    profiles: Vec<Option<[f64; 2]>>,
}

/// Finds the parameters of a problem; `tell` hears what is being done, from any thread.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where no start leads to a fit.
pub fn calibrate(
    problem: &Problem,
    settings: &Settings,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Outcome, CalibrateError> {
    let unknowns = Unknowns::of(problem)?;
    let measured: Vec<Measured> = problem.trials.iter().map(Measured::of).collect::<Result<_, _>>()?;
    let parts = parts(problem, &unknowns);
    let fitted: Vec<Fitted> = parts
        .into_par_iter()
        .map(|part| fit(part, &measured, settings, tell))
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    Ok(outcome::outcome(problem, &unknowns, &measured, &fitted))
}

/// Standard errors of shift by the numerics above which it is found again after the fit has moved.
const FAR: f64 = 3.0;

fn fit<'a>(
    part: Part<'a>,
    measured: &'a [Measured],
    settings: &Settings,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Fitted<'a>, CalibrateError> {
    let measured: Vec<&Measured> = part.trials.iter().map(|t| &measured[*t]).collect();
    let objective = Objective { part: &part, measured: measured.clone() };
    let start = objective.start();
    let name = match &part.members[..] {
        [only] => only.release.name.clone(),
        [first, rest @ ..] => format!("{} and {} more", first.release.name, rest.len()),
        [] => String::new(),
    };
    let say = |stage: &Stage| {
        let stretch = stage.swings.map_or("all of it".to_owned(), |swings| format!("{swings:.2} swings"));
        tell(&format!("{name}: {stretch}, residuals {:.2} times the noise", stage.spread));
    };
    let Some(mut found) = search(&objective, &start, &say) else {
        return Err(objective.refusal(&start));
    };
    let (mut numerics, mut shift) = (None, vec![0.0; start.len()]);
    loop {
        if !settings.remove_mesh {
            break;
        }
        tell(&format!("{name}: a finer mesh and step"));
        let is_first = numerics.is_none();
        let Some(finer) = correction(&objective, &found.x, &found.view) else { break };
        found.steps += finer.steps;
        found.view.corrections = Some(finer.corrections.clone());
        numerics.get_or_insert(finer);
        let Some(better) = settle(&objective, &found.x, &mut found.view) else { break };
        let errors = uncertainty::pseudo_inverse(&better.at.hessian).0.diagonal();
        let moved = (&better.x - &found.x).zip_map(&errors, |x, error| x / error.max(1e-300).sqrt());
        shift.iter_mut().zip(moved.iter()).for_each(|(shift, moved)| *shift += moved);
        found.evaluations += better.evaluations;
        found.steps += better.evaluations * better.at.carried.step_count();
        (found.x, found.at, found.converged) = (better.x, better.at, better.converged);
        found.predicted = better.predicted;
        if !is_first || moved.amax() < FAR {
            break;
        }
    }
    let uncertainty = uncertainty(&objective, &found);
    let is_wanted = |k: &usize| settings.profile && !part.unknowns[*k].is_nuisance();
    let profiles = (0..start.len())
        .into_par_iter()
        .map(|k| {
            Some(k).filter(is_wanted).and_then(|k| profile::profile(&objective, &found, &uncertainty, k))
        })
        .collect();
    drop(objective);
    Ok(Fitted { part, measured, found, uncertainty, numerics, shift, profiles })
}

#[cfg(test)]
pub(crate) mod tests {
    use rand_xoshiro::rand_core::RngCore;

    /// A standard normal number. Source: Box and Muller (1958).
    pub fn normal(random: &mut impl RngCore) -> f64 {
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let (u, v) = (1.0 - uniform(), uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}
