//! What makes the program fail: its exit code, and its message on stderr.

use std::path::Path;
use std::process::ExitCode;

use efam_experiments::kind::FileKind;
use efam_experiments::scenario::ScenarioError;
use efam_store::escape::{escaped, escaped_lines};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};

use super::signals;
use super::terminal::{is_watched, say_coloured};

pub use crate::failure::Failure;

/// The exit code of a failure.
fn code(failure: &Failure) -> u8 {
    match failure {
        Failure::Unread => 0,
        Failure::Output(_) => 1,
        Failure::Scenario(error) if error.is_data() => 3,
        Failure::Data(_) => 3,
        Failure::Scenario(_) | Failure::Usage(_) => 2,
        Failure::Diverged(_) => 4,
        Failure::Interrupted => signals::exit_code(),
    }
}

/// What was read; or else, if the file is plainly of another kind than the one that is due, that it is, and the command
/// that takes it.
pub fn of_kind<T, E>(due: FileKind, file: &Path, read: Result<T, E>) -> Result<T, Failure>
where
    Failure: From<E>,
{
    read.map_err(|error| match FileKind::of(file).filter(|found| *found != due) {
        Some(found) if due == FileKind::Recording => Failure::Data(found.instead_of(due, file)),
        Some(found) => Failure::Usage(found.instead_of(due, file)),
        None => error.into(),
    })
}

/// Prints the message, with an excerpt of the scenario on a terminal or where colours are requested.
pub fn report(failure: &Failure, is_colored: bool) -> ExitCode {
    let text = match failure {
        Failure::Unread => String::new(),
        Failure::Interrupted => format!("{failure}\n"),
        Failure::Scenario(error) if is_colored || is_watched() => excerpt(error, is_colored),
        _ => line(&failure.to_string()),
    };
    say_coloured(&text);
    ExitCode::from(code(failure))
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
