//! What can keep a calibration from being done.

use efam_core::forward::ForwardError;
use models::error::ModelError;
use thiserror::Error;

/// A calibration that could not be done.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrateError {
    /// Nothing to fit to.
    #[error("no release to calibrate with; every release is held out or there is none; free one at least")]
    NoTrials,
    /// Nothing to find.
    #[error("no parameter to calibrate; name one at least, such as rod.bending_stiffness")]
    NoParameters,
    /// A parameter twice.
    #[error("{path} is to be calibrated twice; name it once")]
    Twice {
        /// Its path.
        path: String,
    },
    /// A parameter that a model does not have.
    #[error("release {release}: {error}")]
    Model {
        /// Name of the release.
        release: String,
        /// What the model says.
        error: ModelError,
    },
    /// A rod that cannot be held as its markers show it.
    #[error(
        "release {release}: no load at its end holds the rod where the markers are ({error}); check the rod's data and \
         rod.base_angle, or give the angle at which it is held straight"
    )]
    Held {
        /// Name of the release.
        release: String,
        /// What happened.
        error: Box<ForwardError>,
    },
    /// A value for each pressure, and a release without one.
    #[error(
        "release {release} has no pressure, so {path} cannot be one for each pressure; give its pressure, or make the parameter shared or per release"
    )]
    NoPressure {
        /// Name of the release.
        release: String,
        /// Path of the parameter.
        path: String,
    },
    /// A posterior without draws.
    #[error(
        "release {release}: its posterior cannot be sampled, since the model cannot be simulated near the fit; read the \
         warnings of `efam calibrate` first"
    )]
    NotSampled {
        /// Name of the release.
        release: String,
    },
    /// Bounds that hold nothing.
    #[error("{path}: bounds {low} to {high} must be finite, ascending and within {least} to {most} {unit}")]
    Bounds {
        /// Path of the parameter.
        path: String,
        /// Lower bound found, SI.
        low: f64,
        /// Upper bound found, SI.
        high: f64,
        /// Smallest admissible.
        least: f64,
        /// Largest admissible.
        most: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A start that is not admissible.
    #[error("{path}: the start {start} {unit} must lie within the bounds {low} to {high}")]
    Start {
        /// Path of the parameter.
        path: String,
        /// Value found, SI.
        start: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A logarithmic scale for what may be zero or negative.
    #[error("{path}: a logarithmic scale needs a positive lower bound or start; it has {low}")]
    Logarithm {
        /// Path of the parameter.
        path: String,
        /// What it has.
        low: f64,
    },
    /// A prior that says nothing.
    #[error("{path}: a prior needs a finite mean and a positive deviation; it has {mean} and {deviation}")]
    Prior {
        /// Path of the parameter.
        path: String,
        /// Mean found.
        mean: f64,
        /// Deviation found.
        deviation: f64,
    },
    /// A marker that is not on the rod.
    #[error("release {release}: marker {marker} at {share} of the active length; must lie in 0..=1")]
    OffTheRod {
        /// Name of the release.
        release: String,
        /// Name of the marker.
        marker: String,
        /// Share found.
        share: f64,
    },
    /// A release without a sample to fit.
    #[error(
        "release {release}: {samples} samples of its tracks lie after the release, and {least} at least are needed; check its cut and what was masked"
    )]
    TooFewSamples {
        /// Name of the release.
        release: String,
        /// Samples there are.
        samples: usize,
        /// How many would do.
        least: usize,
    },
    /// Not one start from which the model could be simulated.
    #[error("release {release}: the model cannot be simulated at the start of the fit: {error}")]
    Forward {
        /// Name of the release.
        release: String,
        /// What happened.
        error: Box<ForwardError>,
    },
    /// The search gave up at once.
    #[error(
        "release {release}: no fit was found from any start; check start and bounds of the parameters, and the model by `efam simulate`"
    )]
    NoFit {
        /// Name of the first release that was fitted together with others.
        release: String,
    },
}
