//! What makes the program fail: its exit code, and its message on stderr.

use std::io;
use std::process::ExitCode;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};
use models::error::ModelError;
use sim::calibrate::{CalibrateError, SectionError};
use sim::escape::{escaped, escaped_lines};
use sim::experiment::ExperimentError;
use sim::recording::RecordingError;
use sim::results::ResultsError;
use sim::scenario::ScenarioError;
use sim::sweep::SweepError;

use super::interrupt;
use super::terminal::{is_watched, say_coloured};

/// Why a command ended before its time.
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

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Failure::Diverged(error.to_string())
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Failure::Data(error.to_string())
    }
}

impl From<ResultsError> for Failure {
    fn from(error: ResultsError) -> Self {
        match error {
            ResultsError::Write { .. }
            | ResultsError::FileName { .. }
            | ResultsError::Kept { .. }
            | ResultsError::Late { .. } => Failure::Output(error.to_string()),
            _ => Failure::Usage(error.to_string()),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Scenario(error) => error.into(),
            SweepError::Results(error) => error.into(),
            SweepError::NoShard { .. } | SweepError::Foreign { .. } => Failure::Usage(error.to_string()),
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
    fn code(&self) -> u8 {
        match self {
            Failure::Unread => 0,
            Failure::Output(_) => 1,
            Failure::Scenario(error) if error.is_data() => 3,
            Failure::Data(_) => 3,
            Failure::Scenario(_) | Failure::Usage(_) => 2,
            Failure::Diverged(_) => 4,
            Failure::Interrupted => interrupt::exit_code(),
        }
    }

    /// Prints the message, with an excerpt of the scenario on a terminal or where colours are asked for.
    pub fn report(&self, is_colored: bool) -> ExitCode {
        let text = match self {
            Failure::Unread => String::new(),
            Failure::Interrupted => "interrupted: nothing was saved\n".to_owned(),
            Failure::Scenario(error) if is_colored || is_watched() => excerpt(error, is_colored),
            Failure::Scenario(error) => line(&error.to_string()),
            Failure::Usage(text) | Failure::Diverged(text) | Failure::Data(text) | Failure::Output(text) => {
                line(text)
            }
        };
        say_coloured(&text);
        ExitCode::from(self.code())
    }
}

/// A message is one line, whatever the names and values in it hold.
fn line(message: &str) -> String {
    format!("error: {}\n", escaped(message))
}

/// The message with the line at fault and a mark under it.
fn excerpt(error: &ScenarioError, is_colored: bool) -> String {
    let plain = || line(&error.to_string());
    let Some(at) = error.at.as_ref().filter(|at| !at.text.is_empty()) else { return plain() };
    let shown = |text: &str| escaped_lines(&text.replace("\r\n", "\n")).into_owned();
    // Where the place is in the text as it is shown.
    let ends = [at.span.start, at.span.end].map(|end| at.text.get(..end).map(|before| shown(before).len()));
    let [Some(start), Some(end)] = ends else { return plain() };
    let label = LabeledSpan::new_with_span(Some("here".to_owned()), start..end);
    let diagnostic = MietteDiagnostic::new(escaped(&error.message())).with_label(label);
    let source = NamedSource::new(escaped(&at.file), shown(&at.text));
    let report = Report::new(diagnostic).with_source_code(source);
    let theme = if is_colored { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut text = String::new();
    match GraphicalReportHandler::new_themed(theme).render_report(&mut text, report.as_ref()) {
        Ok(()) => text,
        Err(_) => plain(),
    }
}
