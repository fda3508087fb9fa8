//! What many diagnoses say: how often what, and of which experiment.

use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};

use efam_store::columns::{Cells, Column, read};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::diagnosed::Answer;
use super::plan::Plan;
use super::shard::seconds;
use super::status::{SWEEP, is_merged};

/// Answers and how often each was given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Answers {
    /// Verdicts, the most frequent first: `named`, `incomplete`, `class`, `misstated`, `nothing_missing`, `unknown`.
    pub verdicts: Vec<Often>,
    /// Answers, likewise: names, a class, nothing, unknown.
    pub said: Vec<Often>,
    /// Each experiment's.
    pub experiments: Vec<Answer>,
}

/// Number of equal answers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Often {
    /// What.
    pub what: String,
    /// How often.
    pub points: usize,
}

impl Answers {
    /// What the table of a merged plan says; nothing if its table is not there, or it diagnoses nothing.
    pub fn read(plan: &Plan) -> Option<Self> {
        let columns = plan.head.work.columns();
        let cells = read(&plan.folder.join(SWEEP), &columns).ok().filter(|_| is_merged(plan))?;
        let mut answers = Self { experiments: Answer::of_rows(&columns, &cells)?, ..Self::default() };
        answers.finish(plan);
        Some(answers)
    }

    /// Takes in the answers of some rows.
    pub(super) fn see(&mut self, columns: &[Column], cells: &[Cells]) {
        self.experiments.extend(Answer::of_rows(columns, cells).unwrap_or_default());
    }

    /// Counts them, when all are seen, and reads from the shards how long they took.
    pub(super) fn finish(&mut self, plan: &Plan) {
        let seconds: HashMap<usize, f64> =
            (0..plan.head.shards()).flat_map(|shard| seconds(&plan.folder, shard)).collect();
        self.experiments.iter_mut().for_each(|own| own.seconds = seconds.get(&own.point).copied());
        let verdict = |own: &Answer| serde_json::to_value(own.verdict?).ok()?.as_str().map(str::to_owned);
        self.verdicts = counted(self.experiments.iter().filter_map(verdict));
        let answered = self.experiments.iter().filter(|own| own.verdict.is_some());
        self.said = counted(answered.map(Answer::said));
    }
}

fn counted(all: impl Iterator<Item = String>) -> Vec<Often> {
    let mut counts = BTreeMap::new();
    all.for_each(|what| *counts.entry(what).or_insert(0) += 1);
    let mut counts: Vec<Often> = counts.into_iter().map(|(what, points)| Often { what, points }).collect();
    counts.sort_by_key(|own| Reverse(own.points));
    counts
}
