//! Why an experiment has no releases.

use crate::cleaning::CleaningError;
use crate::recording::RecordingError;
use crate::scenario::ScenarioError;

/// An experiment that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// Its file.
    #[error(transparent)]
    Document(#[from] ScenarioError),
    /// A recording that cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording that can be read, and has not in it what is due.
    #[error(transparent)]
    Cleaning(#[from] CleaningError),
}
