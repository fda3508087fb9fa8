//! A point of a sweep, and the row that comes of it.

use efam_store::columns::{Cell, Column, Holds};

/// A value of a parameter: SI, or a word.
#[derive(Clone, Debug, PartialEq)]
pub enum DesignValue {
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
}

/// One point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its number, from zero.
    pub index: usize,
    /// Of its own random numbers, below 2⁵³; 0 where there is nothing random.
    pub seed: u64,
    /// What differs from point to point, in the order of the plan.
    pub values: Vec<DesignValue>,
}

/// What came of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Why there is no answer.
    pub(super) failed: Option<String>,
    /// The answers, in the order of their columns.
    pub(super) answers: Vec<Cell>,
}

/// Words of the column `status`.
pub const OK: &str = "ok";
/// The other one.
pub const FAILED: &str = "failed";

impl Row {
    /// With all answers.
    pub(super) fn whole(answers: Vec<Cell>) -> Self {
        Self { failed: None, answers }
    }

    /// Without any.
    pub(super) fn failed(why: String, answers: &[Column]) -> Self {
        let none = |column: &Column| match column.holds {
            Holds::Texts => Cell::Text(None),
            _ => Cell::Number(f64::NAN),
        };
        Self { failed: Some(why), answers: answers.iter().map(none).collect() }
    }

    /// Whether there is no answer.
    pub fn is_failed(&self) -> bool {
        self.failed.is_some()
    }
}

/// Words as one text; none of none.
pub(super) fn joined(words: Vec<String>, between: &str) -> Option<String> {
    (!words.is_empty()).then(|| words.join(between))
}

/// A fault of the program's own has been reported on stderr; it must not take the other points with it.
pub(super) fn fault() -> String {
    "the program itself failed; please report it".to_owned()
}
