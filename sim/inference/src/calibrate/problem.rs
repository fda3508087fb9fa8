//! What is to be calibrated: measured releases, their models, and which parameters are unknown.

use std::sync::Arc;

use efam_core::forward::{Initial, Run};
use efam_experiments::release::Release;
use models::error::ModelError;
use models::model::Model;
use schemars::JsonSchema;

use super::error::CalibrateError;

/// Several measured releases and the parameters that they share or have of their own.
#[derive(Clone)]
pub struct Problem {
    /// The releases; those held out only validate.
    pub trials: Vec<Arc<Trial>>,
    /// What is to be found.
    pub parameters: Vec<FittedParameter>,
    /// Nuisance parameters, per recording.
    pub nuisances: Nuisances,
}

/// One measured release with its own model.
#[derive(Clone)]
pub struct Trial {
    /// What was measured.
    pub release: Release,
    /// The model at the start of the fit, at the release's pressure and with its payload.
    pub model: Model,
    /// Where it starts and how it is run; duration, samples, points and sensitivities are the
    /// fit's own.
    pub run: Run,
}

/// A parameter to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedParameter {
    /// Its path in the model, such as `rod.bending_stiffness`.
    pub path: String,
    /// What shares one value.
    pub scope: Scope,
    /// Where the search starts, SI; the model's own value, or the registry's typical size where
    /// that is zero.
    pub start: Option<f64>,
    /// Admissible values, SI; the registry's range.
    pub bounds: Option<(f64, f64)>,
    /// What is known beforehand.
    pub prior: Option<Prior>,
    /// How it is scaled; logarithmic where only positive values are admissible, unless it is the
    /// parameter of an effect that may vanish.
    pub scale: Option<Scale>,
}

/// The releases that share one value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// All releases.
    Shared,
    /// All releases at one pressure, to a thousandth.
    PerPressure,
    /// Each release has its own.
    PerRelease,
}

/// Knowledge of a parameter from elsewhere: a normal distribution of its value, SI.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, JsonSchema)]
pub struct Prior {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// How a parameter is scaled in the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// By its typical size.
    Linear,
    /// Logarithmically.
    Logarithmic,
}

/// What is unknown of each recording: fitted with it, under a prior about zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Nuisances {
    /// The instant of release, under the release's own uncertainty.
    pub release_instant: bool,
    /// Standard deviation of the angle at which the straight rod is held, rad, about the model's.
    pub hold_angle: Option<f64>,
    /// Standard deviation of the clamp's angle, rad, about the model's.
    pub clamp_angle: Option<f64>,
    /// Standard deviation of a constant offset of each track in x and z, m.
    pub offset: Option<f64>,
    /// Standard deviations by which each may be off at most.
    pub farthest: f64,
}

impl Default for Nuisances {
    /// Instant, half a degree of the held angle, half a millimetre of offset.
    fn default() -> Self {
        Self {
            release_instant: true,
            hold_angle: Some(0.5f64.to_radians()),
            clamp_angle: None,
            offset: Some(5e-4),
            farthest: f64::INFINITY,
        }
    }
}

impl Problem {
    /// The trials.
    pub fn trials(&self) -> impl ExactSizeIterator<Item = &Trial> {
        self.trials.iter().map(Arc::as_ref)
    }

    /// The trials, each to be changed: one that another problem has as well becomes this one's own.
    pub fn trials_mut(&mut self) -> impl Iterator<Item = &mut Trial> {
        self.trials.iter_mut().map(Arc::make_mut)
    }

    /// Name of its first release; empty where there is none.
    pub(crate) fn first_name(&self) -> String {
        self.trials.first().map_or(String::new(), |trial| trial.release.name.clone())
    }

    /// That a model of it is refused.
    pub(crate) fn refused(&self, error: ModelError) -> CalibrateError {
        CalibrateError::Model { release: self.first_name(), error }
    }

    /// Whether the model of a trial has an effect.
    pub(crate) fn has(&self, effect: &str) -> bool {
        self.trials.iter().any(|trial| trial.model.effect(effect).is_some())
    }

    /// Different pressures of the releases that are fitted, Pa, ascending.
    pub fn fitted_pressures(&self) -> Vec<f64> {
        let fitted = self.trials.iter().filter(|trial| !trial.release.held_out);
        let mut pressures: Vec<f64> = fitted.filter_map(|trial| trial.release.pressure).collect();
        pressures.sort_by(f64::total_cmp);
        pressures.dedup_by(|a, b| is_same_pressure(*a, *b));
        pressures
    }
}

/// Stated numbers this close to one another, relative, are one.
const SAME: f64 = 1e-3;

/// Whether two stated numbers are one.
pub(crate) fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// Whether two pressures, Pa, are one.
pub fn is_same_pressure(a: f64, b: f64) -> bool {
    is_same(a, b)
}

/// Whether what belongs to a pressure, or to all, belongs to a release at another, Pa.
pub fn is_of_pressure(own: Option<f64>, pressure: Option<f64>) -> bool {
    own.is_none_or(|own| pressure.is_some_and(|pressure| is_same_pressure(own, pressure)))
}

impl FittedParameter {
    /// A parameter with the registry's start, bounds and scale, and no prior.
    pub fn new(path: &str, scope: Scope) -> Self {
        Self { path: path.to_owned(), scope, start: None, bounds: None, prior: None, scale: None }
    }
}

impl Trial {
    /// Whether the release is a straight one, so that its angle matters.
    pub fn is_straight(&self) -> bool {
        matches!(self.run.initial, Initial::Straight)
    }

    /// Whether a load sets the posture of the start: of a hand that holds the rod bent, or of a start in motion.
    pub fn is_held(&self) -> bool {
        self.run.initial.is_in_a_hand()
    }

    /// Whether the recording begins in mid-swing. Its first sample is the start, so no instant is unknown.
    pub fn is_in_motion(&self) -> bool {
        self.is_held() && self.release.release_uncertainty == 0.0
    }

    /// The same with an effect at these parameters, also in what holds the rod.
    pub(crate) fn with_effect(&self, name: &str, values: &[(&str, f64)]) -> Result<Self, ModelError> {
        let mut trial = self.clone();
        trial.model = trial.model.with_effect(name, values)?;
        if let Initial::Equilibrium { hold, .. } = &mut trial.run.initial {
            **hold = hold.with_effect(name, values)?;
        }
        Ok(trial)
    }

    /// The model and the start of a run with parameters set, `(index in theta, value)`; what holds
    /// the rod has them as well, but for those of its own.
    pub(crate) fn with(&self, values: &[(usize, f64)]) -> (Model, Initial) {
        let mut model = self.model.clone();
        let mut initial = self.run.initial.clone();
        for &(k, value) in values {
            model.theta[k] = value;
            if let Initial::Equilibrium { hold, own } = &mut initial
                && !own.contains(&k)
            {
                hold.theta[k] = value;
            }
        }
        (model, initial)
    }
}

/// Divides each edge of a model, and of what holds it, into `factor` of them.
pub(crate) fn refine(model: &mut Model, initial: &mut Initial, factor: usize) -> Result<(), ModelError> {
    let nodes = model.edges * factor + 1;
    *initial = initial.on_mesh(nodes)?;
    *model = model.with_nodes(nodes)?;
    Ok(())
}
