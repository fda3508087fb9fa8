//! Calibration: parameters of a model from measured releases, with their uncertainty.
//!
//! Nonlinear least squares on the paths of the markers themselves. [`Problem`] says which releases
//! and which parameters, [`calibrate()`] finds them, [`Calibration`] is what is written. Where the data
//! cannot separate parameters, a warning says so and names the experiment that would.

mod autocorrelation;
pub mod calibration;
pub(crate) mod discrepancy;
mod error;
pub(crate) mod ghosts;
pub(crate) mod hold;
mod identifiability;
pub(crate) mod marker;
pub mod misfit;
pub(crate) mod numerics;
pub(crate) mod objective;
mod outcome;
pub(crate) mod part;
#[cfg(feature = "posterior")]
pub mod posterior;
pub(crate) mod prediction;
pub mod problem;
pub(crate) mod profile;
mod pure_error;
pub(crate) mod refine;
pub mod repeats;
pub mod residuals;
pub(crate) mod search;
mod section;
pub(crate) mod stage;
mod starts;
pub(crate) mod uncertainty;
pub mod unknowns;
pub(crate) mod view;
pub(crate) mod warnings;
pub mod waves;

use nalgebra::DVector;
use rayon::prelude::*;

pub use calibration::Calibration;
pub use error::CalibrateError;
pub use misfit::Curve;
pub use outcome::CalibrationOutcome;
pub use problem::{FittedParameter, Nuisances, Prior, Problem, Scale, Scope, Trial};
pub use section::{SectionError, problem, repeatability};
pub(crate) use section::{marker_error, trial};
pub use stage::Stage;

use numerics::Correction;
use objective::Objective;
use part::{Part, parts};
use prediction::FIT;
use pure_error::differences;
use refine::{MOST_ROUNDS, RESOLUTION, refine, shift};
use repeats::{Repeats, conditions};
use search::{Found, go_on, search};
use uncertainty::{Uncertainty, uncertainty};
use unknowns::Unknowns;

use crate::ordered::in_order;

/// What is done beside the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationSettings {
    /// Whether the errors of mesh and step are removed; without that the parameters belong to the
    /// mesh of the models.
    pub remove_mesh: bool,
    /// Whether to find intervals by the profile of the likelihood as well.
    pub profile: bool,
    /// How well the experiment repeats, where that is stated: root mean square distance, m.
    pub repeatability: Option<f64>,
}

impl Default for CalibrationSettings {
    fn default() -> Self {
        Self { remove_mesh: true, profile: false, repeatability: None }
    }
}

/// One part of a problem, fitted.
pub(crate) struct PartFit {
    objective: Objective,
    found: Found,
    uncertainty: Uncertainty,
    numerics: Option<Correction>,
    /// By how many standard errors the numerics would move each unknown.
    shift: DVector<f64>,
    /// Evaluations of all releases, and steps of the integrator in all runs.
    effort: [usize; 2],
    /// By unknown, scaled.
    profiles: Vec<Option<[f64; 2]>>,
}

/// Receives the progress of a calibration, from any thread. A closure receives what is being done.
pub trait Listener: Sync {
    /// What is being done.
    fn doing(&self, what: &str);

    /// A stretch of the recordings was fitted.
    fn fitted(&self, _progress: &Progress) {}
}

impl<F: Fn(&str) + Sync> Listener for F {
    fn doing(&self, what: &str) {
        self(what);
    }
}

/// How far a search has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The releases that are fitted together, in words.
    pub part: String,
    /// Largest robust spread of the residuals of a release, in units of the noise.
    pub spread: f64,
    /// Each parameter: what it is, its value, its SI unit.
    pub parameters: Vec<(String, f64, &'static str)>,
}

/// Finds the parameters of a problem; `listener` receives what is being done.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where no start leads to a fit.
pub fn calibrate(
    problem: &Problem,
    settings: &CalibrationSettings,
    listener: &dyn Listener,
) -> Result<CalibrationOutcome, CalibrateError> {
    Ok(outcome_of(&fits(problem, settings, listener)?))
}

/// All parts of a problem, fitted.
pub(crate) struct Fits {
    problem: Problem,
    unknowns: Unknowns,
    each: Vec<PartFit>,
    /// How well the experiment repeats, where that is stated.
    stated: Option<Repeats>,
}

fn fits(
    problem: &Problem,
    settings: &CalibrationSettings,
    listener: &dyn Listener,
) -> Result<Fits, CalibrateError> {
    if problem.parameters.is_empty() {
        return Err(CalibrateError::NoParameters);
    }
    // What releases of one condition differ by is in the residuals of their fit, but for what angles and instants of
    // their own explain.
    let stated = settings.repeatability.map(|distance| Repeats::stated(problem, distance));
    let problem = stated.as_ref().map_or_else(|| problem.clone(), |repeats| repeats.beside_noise(problem));
    let unknowns = Unknowns::of(&problem)?;
    let each = parts(&problem, &unknowns).into_par_iter().map(|part| fit(part, settings, listener));
    let each = in_order::<_, Result<Vec<PartFit>, CalibrateError>>(each)?;
    Ok(Fits { problem, unknowns, each, stated })
}

fn outcome_of(fits: &Fits) -> CalibrationOutcome {
    let Fits { problem, unknowns, each, stated } = fits;
    let mut outcome = outcome::outcome(problem, unknowns, each);
    let found: Vec<_> = each.iter().map(|fit| (&fit.objective, &fit.found)).collect();
    let measured = || Repeats::measured(problem, &differences(&found, &conditions(problem)));
    outcome.calibration.repeats = stated.clone().or_else(measured);
    outcome
}

fn fit(
    part: Part,
    settings: &CalibrationSettings,
    listener: &dyn Listener,
) -> Result<PartFit, CalibrateError> {
    let mut objective = Objective::new(part)?;
    let start = objective.start();
    let name = match &objective.part.members[..] {
        [only] => only.release.name.clone(),
        [first, rest @ ..] => format!("{} and {} more", first.release.name, rest.len()),
        [] => String::new(),
    };
    let say = |part: &Part, stage: &Stage, x: &DVector<f64>| {
        let stretch = stage.swings.map_or("all of it".to_owned(), |swings| format!("{swings:.2} swings"));
        listener.doing(&format!("{name}: {stretch}, residuals {:.2} times the noise", stage.spread));
        let parameters = part.unknowns.iter().zip(x.iter()).filter(|(unknown, _)| !unknown.is_nuisance());
        listener.fitted(&Progress {
            part: name.clone(),
            spread: stage.spread,
            parameters: parameters
                .map(|(unknown, x)| (unknown.label(), unknown.scaled.value(*x), unknown.unit))
                .collect(),
        });
    };
    let Some(mut found) = search(&objective, &start, &|stage, x| say(&objective.part, stage, x)) else {
        return Err(objective.refusal(&start));
    };
    let refined = |objective: &Objective, found: &mut Found| {
        refine(objective, found, !settings.remove_mesh, RESOLUTION, &|what| {
            listener.doing(&format!("{name}: {what}"))
        })
    };
    // Mesh and step swing as the rod does: what a model misses is only seen without them.
    let mut numerics = refined(&objective, &mut found);
    for _ in 0..MOST_ROUNDS {
        if !discrepancy::hear(&mut objective, &found) {
            break;
        }
        if go_on(&objective, &mut found, FIT).is_none() {
            return Err(objective.refusal(&found.x));
        }
        numerics = refined(&objective, &mut found);
    }
    let shift = shift(&objective, &found);
    let effort = objective.effort();
    let uncertainty = uncertainty(&objective, &found);
    let is_wanted = |k: &usize| settings.profile && !objective.part.unknowns[*k].is_nuisance();
    let profiles = (0..start.len())
        .into_par_iter()
        .map(|k| {
            Some(k).filter(is_wanted).and_then(|k| profile::profile(&objective, &found, &uncertainty, k))
        })
        .collect();
    Ok(PartFit { objective, found, uncertainty, numerics, shift, effort, profiles })
}
