//! The errors that a page gets when its request cannot be answered.

use efam_core::forward::ForwardError;
use efam_core::integrate::IntegrateError;
use efam_core::models::error::ModelError;
use efam_core::models::muscle::MuscleError;
use efam_core::stepper::ChangeError;
use thiserror::Error;

/// A request that cannot be answered.
#[derive(Debug, Error)]
pub enum PlaygroundError {
    /// A text that is no request.
    #[error("the request cannot be read: {0}")]
    Request(#[from] serde_json::Error),
    /// A muscle that is not built in, or a pressure outside its table.
    #[error(transparent)]
    Muscle(#[from] MuscleError),
    /// A rod that cannot be.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A change that cannot be.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// A step that cannot be made.
    #[error(transparent)]
    Integrate(#[from] IntegrateError),
    /// A run that cannot be made.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// A rod without a muscle that lacks a number.
    #[error("rod.{key} is missing: a rod without a muscle needs length, mass and bending_stiffness")]
    Missing {
        /// The key.
        key: &'static str,
    },
    /// A key that a rod does not have.
    #[error("rod.{key} is unknown; known are {known}")]
    UnknownKey {
        /// The key.
        key: String,
        /// Those that there are.
        known: String,
    },
    /// A duration that is none.
    #[error("{name} = {value}: must lie in {low}..={high}")]
    OutOfRange {
        /// What it is.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// A step of a rod that was never let go.
    #[error("rod {rod} was not let go")]
    NoRod {
        /// Its number.
        rod: u32,
    },
    /// A path that does not determine a fit.
    #[error("the path has {samples} samples after the release, and {unknowns} parameters are to be fitted")]
    TooShort {
        /// Samples.
        samples: usize,
        /// Parameters.
        unknowns: usize,
    },
    /// Times that do not ascend, or positions that are no numbers.
    #[error("sample {sample} of the path has a time that does not ascend, or a number that is none")]
    BadSample {
        /// From 1.
        sample: usize,
    },
    /// A start that cannot be simulated.
    #[error("the simulation fails with the first values: set sliders nearer to the recording")]
    NoStart,
}
