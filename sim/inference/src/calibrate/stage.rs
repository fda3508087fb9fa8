//! Stages of a search: what is reported of one, and when it ends.

use schemars::JsonSchema;

/// A stretch of the recordings that was fitted.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, JsonSchema)]
pub struct Stage {
    /// Start from which it came, the best by the first swing being 0.
    pub start: usize,
    /// How much of each recording, in swings; none for all of it.
    pub swings: Option<f64>,
    /// Evaluations of all releases with their sensitivities.
    pub evaluations: usize,
    /// Largest robust spread of the residuals of a release, in units of the noise.
    pub spread: f64,
    /// Whether the search found its minimum.
    pub converged: bool,
}

/// Predicted decrease, for residuals of unit spread, at which a stage stops.
pub(super) const STAGE_TOLERANCE: f64 = 5e-2;
/// The same as a share of the cost.
pub(crate) const STAGE_SHARE: f64 = 3e-3;
/// Evaluations after which a search is given up.
pub(super) const MOST_EVALUATIONS: usize = 30;
