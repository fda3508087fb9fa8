//! What can be wrong with a scenario, and where.

use std::fmt::{self, Display};
use std::ops::Range;
use std::sync::Arc;

use models::error::ModelError;
use models::muscle::MuscleError;
use models::nearest::offer;
use models::quantity::QuantityError;
use models::written::LawProblem;
use thiserror::Error;

/// A scenario that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenarioError {
    /// Where; none if there is no text to point to.
    pub at: Option<At>,
    /// What.
    pub problem: Box<ScenarioProblem>,
}

/// A place in the text of a scenario, or of a `--set`.
#[derive(Clone, Debug, PartialEq)]
pub struct At {
    /// Name of the file, or `--set`.
    pub file: String,
    /// The whole text; empty if the value is not there.
    pub text: Arc<str>,
    /// The bytes at fault.
    pub span: Range<usize>,
    /// Path of the key, such as `effects.payload.mass`; empty where it is unknown.
    pub key: String,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ScenarioProblem {
    /// The scenario, or a file that it names, cannot be read.
    #[error("{file}: cannot be read ({reason}); check the path")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// The text is no TOML.
    #[error("{}; see https://toml.io for the form", .message.trim_end().replace('\n', ", "))]
    Toml {
        /// What the reader said.
        message: String,
    },
    /// A `--set` that is none.
    #[error("write --set path=value, such as --set effects.payload.mass=\"50 g\"")]
    Override,
    /// A key that nothing reads.
    #[error("unknown key{}; known here {}", did_you_mean(.nearest), are(.known))]
    UnknownKey {
        /// What was most likely meant.
        nearest: Option<String>,
        /// Keys that there are.
        known: Vec<String>,
    },
    /// A key is missing.
    #[error("is missing; write {example}")]
    Missing {
        /// How to write it.
        example: &'static str,
    },
    /// A word that is none of those that there are.
    #[error("unknown{}; known here {}", did_you_mean(.nearest), are(.known))]
    UnknownWord {
        /// What was most likely meant.
        nearest: Option<String>,
        /// Words that there are.
        known: Vec<String>,
    },
    /// A value of another type.
    #[error("{due} is due")]
    WrongType {
        /// What is due.
        due: &'static str,
    },
    /// A quantity that is none, or of another kind.
    #[error(transparent)]
    Quantity(QuantityError),
    /// A value that cannot be.
    #[error("must {must}")]
    Must {
        /// What is admissible.
        must: &'static str,
    },
    /// A parameter outside its range.
    #[error("must lie in {range}")]
    OutOfRange {
        /// The range with its unit.
        range: String,
    },
    /// What the muscle says of a request.
    #[error(transparent)]
    Muscle(MuscleError),
    /// A muscle file that cannot be used.
    #[error("{file}: {error}")]
    MuscleFile {
        /// The file.
        file: String,
        /// What is wrong in it.
        error: MuscleError,
    },
    /// A posture file that cannot be used.
    #[error(
        "{file}:{line}: {message}; the form is x_m,z_m or x_m,z_m,vx_m_s,vz_m_s, one point a line from the clamp"
    )]
    PostureFile {
        /// The file.
        file: String,
        /// The line, from one.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A law as text that cannot be used.
    #[error(transparent)]
    Law(LawProblem),
    /// What the model says of what it is built from.
    #[error(transparent)]
    Model(ModelError),
    /// What is said best in its own words.
    #[error("{message}")]
    Other {
        /// The words.
        message: String,
    },
}

impl ScenarioError {
    /// Whether data are at fault, and not the scenario.
    pub fn is_data(&self) -> bool {
        matches!(*self.problem, ScenarioProblem::MuscleFile { .. } | ScenarioProblem::PostureFile { .. })
    }

    /// The message without its place.
    pub fn message(&self) -> String {
        let problem = self.problem.to_string();
        let Some(at) = self.at.as_ref().filter(|at| !at.key.is_empty()) else { return problem };
        let key = &at.key;
        match &*self.problem {
            ScenarioProblem::UnknownKey { .. }
            | ScenarioProblem::Missing { .. }
            | ScenarioProblem::Quantity(_)
            | ScenarioProblem::Law(_)
            | ScenarioProblem::Unreadable { .. }
            | ScenarioProblem::MuscleFile { .. }
            | ScenarioProblem::PostureFile { .. } => format!("{key}: {problem}"),
            ScenarioProblem::Model(error) => match problem.strip_prefix(key.as_str()) {
                Some(_) => error.to_string(),
                None => format!("{key}: {problem}"),
            },
            // A muscle names its pressure itself.
            ScenarioProblem::Muscle(_) => match problem.strip_prefix("pressure = ") {
                Some(rest) => format!("{key} = {rest}"),
                None => format!("{key}: {problem}"),
            },
            _ => match at.text.get(at.span.clone()).map(str::trim).filter(|value| !value.is_empty()) {
                Some(value) if value.len() <= 60 => format!("{key} = {value}: {problem}"),
                _ => format!("{key}: {problem}"),
            },
        }
    }
}

impl At {
    /// Line and column, from one; none if the value is not in the text.
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        let before = self.text.get(..self.span.start).filter(|_| !self.text.is_empty())?;
        let line = before.rsplit('\n').next().unwrap_or_default();
        Some((before.matches('\n').count() + 1, line.chars().count() + 1))
    }
}

impl Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line_and_column() {
            Some(_) if self.file == "--set" => write!(f, "--set {}", self.text),
            Some((line, column)) => write!(f, "{}:{line}:{column}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

impl Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.at {
            Some(at) => write!(f, "{at}: {}", self.message()),
            None => f.write_str(&self.message()),
        }
    }
}

impl std::error::Error for ScenarioError {}

fn did_you_mean(nearest: &Option<String>) -> String {
    offer(nearest.as_deref())
}

fn are(known: &[String]) -> String {
    match known {
        [only] => format!("is {only}"),
        known => format!("are {}", known.join(", ")),
    }
}
