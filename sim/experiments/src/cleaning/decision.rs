//! What was decided in cleaning, in plain words, and how to decide otherwise.

use schemars::JsonSchema;
use serde::Serialize;

/// One decision.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Decision {
    /// Recording, such as `15psi.csv`, or release of it, such as `15psi.csv#3`.
    pub about: String,
    /// The decision, with the numbers behind it.
    pub what: String,
    /// The key of the experiment file that decides otherwise.
    pub key: &'static str,
}

/// The decisions about one recording or release.
pub(super) struct Log<'a> {
    about: String,
    decisions: &'a mut Vec<Decision>,
}

impl<'a> Log<'a> {
    pub fn new(about: impl Into<String>, decisions: &'a mut Vec<Decision>) -> Self {
        Self { about: about.into(), decisions }
    }

    pub fn say(&mut self, key: &'static str, what: impl Into<String>) {
        self.decisions.push(Decision { about: self.about.clone(), what: what.into(), key });
    }

    /// The same for a release of the recording.
    pub fn release(&mut self, number: usize) -> Log<'_> {
        Log { about: format!("{}#{number}", self.about), decisions: self.decisions }
    }
}

/// A length in millimetres, for people.
pub fn mm(length: f64) -> String {
    format!("{} mm", models::digits::significant(1e3 * length, 3))
}
