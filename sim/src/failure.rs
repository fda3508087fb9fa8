//! Why a command or a call ends before its time: by what is at fault, for the command line and for Python.

use std::fmt::{self, Display};
use std::io;

use efam_core::forward::ForwardError;
use efam_core::linear::LinearError;
use efam_experiments::experiment::ExperimentError;
use efam_experiments::scenario::ScenarioError;
use efam_inference::calibrate::{CalibrateError, SectionError};
use efam_inference::predict::check::CheckError;
use efam_recordings::RecordingError;
use efam_store::StoreError;
use efam_sweeps::SweepError;
use models::error::ModelError;

/// Why a command ended before its time.
#[derive(Debug)]
pub enum Failure {
    /// The scenario.
    Scenario(Box<ScenarioError>),
    /// The command line.
    Usage(String),
    /// The model: a rest posture that was not found, an integration that gave up.
    Diverged(String),
    /// Recordings or other data.
    Data(String),
    /// Results that could not be written or shown.
    Output(String),
    /// Ctrl-C, where nothing of what was begun is worth keeping.
    Interrupted,
    /// Nobody reads stdout any longer, as behind `| head`: no failure at all.
    Unread,
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        Failure::Scenario(Box::new(error))
    }
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        match error {
            ExperimentError::Document(error) => error.into(),
            error => Failure::Data(error.to_string()),
        }
    }
}

impl From<CalibrateError> for Failure {
    fn from(error: CalibrateError) -> Self {
        match error {
            CalibrateError::Forward { .. } | CalibrateError::NoFit { .. } => {
                Failure::Diverged(error.to_string())
            }
            CalibrateError::TooFewSamples { .. } => Failure::Data(error.to_string()),
            error => Failure::Usage(error.to_string()),
        }
    }
}

impl From<SectionError> for Failure {
    fn from(error: SectionError) -> Self {
        match error {
            SectionError::Experiment(error) => error.into(),
            SectionError::Calibrate(error) => error.into(),
            error => Failure::Usage(error.to_string()),
        }
    }
}

impl From<CheckError> for Failure {
    fn from(error: CheckError) -> Self {
        match error {
            CheckError::Experiment(error) => error.into(),
            CheckError::Calibrate(error) => error.into(),
            CheckError::Section(error) => error.into(),
            CheckError::Predict(error) => Failure::Diverged(error.to_string()),
            CheckError::NoModel { .. } => Failure::Usage(error.to_string()),
        }
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Failure::Diverged(error.to_string())
    }
}

/// What the user can change in the call is a matter of usage.
impl From<LinearError> for Failure {
    fn from(error: LinearError) -> Self {
        match error {
            LinearError::Model(error) if !matches!(error, ModelError::NoInput { .. }) => error.into(),
            LinearError::PoleAtZero | LinearError::Defective => Failure::Diverged(error.to_string()),
            error => Failure::Usage(error.to_string()),
        }
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Failure::Data(error.to_string())
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Write { .. }
            | StoreError::FileName { .. }
            | StoreError::Kept { .. }
            | StoreError::Late { .. } => Failure::Output(error.to_string()),
            _ => Failure::Usage(error.to_string()),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Scenario(error) => error.into(),
            SweepError::Results(error) => error.into(),
            SweepError::NoShard { .. } | SweepError::Foreign { .. } | SweepError::OtherPlan { .. } => {
                Failure::Usage(error.to_string())
            }
            SweepError::Unwritten { .. } => Failure::Output(error.to_string()),
            error => Failure::Data(error.to_string()),
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Failure::Unread;
        }
        Failure::Output(format!("stdout: cannot be written ({error}); check where it is piped to"))
    }
}

impl Failure {
    /// What a simulation says of the case of that name.
    pub fn of_simulation(case: &str, error: ForwardError) -> Self {
        match error {
            ForwardError::Model(error) => error.into(),
            error => Failure::Usage(format!("{case}: {error}")),
        }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Scenario(error) => error.fmt(f),
            Failure::Usage(text) | Failure::Diverged(text) | Failure::Data(text) | Failure::Output(text) => {
                f.write_str(text)
            }
            Failure::Interrupted => f.write_str("interrupted: nothing was saved"),
            Failure::Unread => Ok(()),
        }
    }
}

impl std::error::Error for Failure {}
