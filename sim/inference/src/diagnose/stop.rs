//! A search that ends early: its budget is spent, or it was interrupted from outside.
//!
//! The budget counts work ([`efam_core::work`]), and is looked at between the parts of the search that run in parallel.
//! A part that has begun is completed, so no clock or load changes the answer. An interruption, by the user or by a
//! time limit, ends fits with the run that they are in. Candidates that were fitted by then are compared, and the answer
//! lists what was left out.

use efam_core::forward::Cancel;
use efam_core::work::{Work, written};

use super::Course;
use super::candidate::candidates;
use super::verdict::{CutBy, CutShort, Diagnosis, Evidence};
use crate::calibrate::joint::Joint;
use crate::calibrate::{CalibrateError, Problem};
use crate::listed::listed;

/// Why a candidate has no fit where the search was cut short.
pub(super) const CUT_SHORT: &str = "the search was cut short before it was fitted";

/// Whether runs of a problem were asked to end from outside.
pub(super) fn is_interrupted(problem: &Problem) -> bool {
    problem.trials.iter().any(|trial| trial.run.cancel.is_requested())
}

/// Whether no further part of a search may begin. Only where no part is in progress: see [`Work::is_spent`].
pub(super) fn is_over(problem: &Problem) -> bool {
    is_interrupted(problem) || is_spent(problem)
}

fn is_spent(problem: &Problem) -> bool {
    problem.trials.iter().any(|trial| trial.run.work.is_spent())
}

/// Why a candidate has no fit.
pub(super) fn not_run(problem: &Problem) -> &'static str {
    if is_interrupted(problem) { CUT_SHORT } else { "a model with it cannot be simulated" }
}

/// The same problem, whose runs end when a request says so.
pub(super) fn ending_by(problem: &Problem, stop: &Cancel) -> Problem {
    let mut problem = problem.clone();
    problem.trials_mut().for_each(|trial| trial.run.cancel = stop.clone());
    problem
}

/// The same problem, whose runs count their work together.
pub(super) fn counted(problem: &Problem, work: &Work) -> Problem {
    let mut problem = problem.clone();
    problem.trials_mut().for_each(|trial| trial.run.work = work.clone());
    problem
}

impl Course<'_> {
    /// Whether no further part of the search may begin. Only where no part is in progress, as [`is_over`].
    pub(super) fn is_stopped(&self) -> bool {
        self.is_interrupted() || is_spent(&self.problem)
    }

    /// Whether the search was asked to end from outside.
    pub(super) fn is_interrupted(&self) -> bool {
        self.listener.stop().is_requested()
    }

    /// Whether a part of the search may begin; if not, the answer lists it as left out and is not final.
    pub(super) fn may_search(&mut self, part: &str) -> bool {
        let is_over = self.is_stopped();
        if is_over {
            self.cut_short(self.diagnosis.thresholds.len().max(1)).left_out.push(part.to_owned());
        }
        !is_over
    }

    /// Whether a part of the answer may begin once the search is over; if not, the answer lists it as left out.
    pub(super) fn may_add_to_answer(&mut self, part: &str) -> bool {
        let is_over = self.is_stopped();
        if is_over {
            let by = self.cut_by();
            self.diagnosis.cut_short.get_or_insert_with(|| CutShort::by(by)).left_out.push(part.to_owned());
        }
        !is_over
    }

    /// Notes that the search was cut short in a round, which may be known already.
    pub(super) fn cut_short(&mut self, round: usize) -> &mut CutShort {
        let by = self.cut_by();
        let cut = self.diagnosis.cut_short.get_or_insert_with(|| CutShort::by(by));
        cut.round.get_or_insert(round);
        cut
    }

    /// Notes that the search was cut short before a round, of which no candidate was fitted.
    pub(super) fn cut_short_before(&mut self, round: usize) {
        let mut names: Vec<String> = Vec::new();
        for candidate in candidates(&self.model.problem, self.settings) {
            if names.iter().all(|name| name != candidate.name()) {
                names.push(candidate.name().to_owned());
            }
        }
        self.cut_short(round).not_fitted.extend(names);
    }

    /// Notes that the search was cut short in a round, if candidates of its evidence were not fitted for that, or if it
    /// was interrupted.
    pub(super) fn cut_short_in(&mut self, round: usize, evidence: &[Evidence]) {
        let is_cut = |own: &&Evidence| own.rejected.as_deref() == Some(CUT_SHORT);
        let names: Vec<String> = evidence.iter().filter(is_cut).map(Evidence::label).collect();
        if !names.is_empty() || self.is_interrupted() {
            self.cut_short(round).not_fitted.extend(names);
        }
    }

    fn cut_by(&self) -> CutBy {
        if self.is_interrupted() { CutBy::Interruption } else { CutBy::Budget }
    }

    /// The model as it is, whose runs end when the search is interrupted.
    pub(super) fn ending(&self) -> Result<Joint, CalibrateError> {
        self.model.clone().with_problem(ending_by(&self.model.problem, &self.listener.stop()))
    }
}

impl CutShort {
    fn by(by: CutBy) -> Self {
        Self { round: None, by, not_fitted: Vec::new(), left_out: Vec::new() }
    }
}

impl Diagnosis {
    /// The round in which the search was cut short, if its answer is not final.
    pub fn cut_short_in_round(&self) -> Option<usize> {
        self.cut_short.as_ref()?.round
    }
}

/// Names in a sentence, at most.
const NAMED: usize = 5;

/// What should be known of a search that was cut short.
pub(super) fn warning(diagnosis: &Diagnosis) -> Option<String> {
    let CutShort { round, by, not_fitted, left_out } = diagnosis.cut_short.as_ref()?;
    let reason = match by {
        CutBy::Budget => format!("its budget of {} node steps", written(diagnosis.budget)),
        CutBy::Interruption => {
            "a time limit or an interruption, so another machine may give another answer".to_owned()
        }
    };
    let first = &not_fitted[..not_fitted.len().min(NAMED)];
    let candidates = match (not_fitted.len(), not_fitted.len() - first.len()) {
        (0, _) => None,
        (1, _) => Some(format!("1 candidate was not fitted ({})", first[0])),
        (all, 0) => Some(format!("{all} candidates were not fitted ({})", listed(first))),
        (all, more) => {
            Some(format!("{all} candidates were not fitted ({} and {more} more)", first.join(", ")))
        }
    };
    let left_out = (!left_out.is_empty()).then(|| format!("left out: {}", left_out.join("; ")));
    let parts: Vec<String> = candidates.into_iter().chain(left_out).collect();
    let parts = if parts.is_empty() { "fits in progress were ended".to_owned() } else { parts.join("; ") };
    let begin = match round {
        Some(round) => format!("the search was cut short in round {round}"),
        None => "the search was completed, and its answer cut short".to_owned(),
    };
    let final_answer = if round.is_some() { "so the answer is not final; " } else { "" };
    Some(format!(
        "{begin} by {reason}. {parts}; {final_answer}give a larger --budget, or leave out candidates with --without"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(round: Option<usize>, by: CutBy, not_fitted: usize, left_out: &[&str]) -> String {
        let not_fitted = (1..=not_fitted).map(|k| format!("effect_{k}")).collect();
        let left_out = left_out.iter().map(|part| (*part).to_owned()).collect();
        let cut_short = Some(CutShort { round, by, not_fitted, left_out });
        warning(&Diagnosis { cut_short, budget: 2_500_000, ..Diagnosis::default() }).unwrap()
    }

    /// What was left out is named, whatever it is; no count is zero.
    #[test]
    fn the_warning_names_what_was_not_tried() {
        assert_eq!(warning(&Diagnosis::default()), None);
        let one = words(Some(1), CutBy::Budget, 1, &[]);
        assert!(one.contains("in round 1 by its budget of 2.50e6 node steps. 1 candidate was not"), "{one}");
        let many = words(Some(2), CutBy::Budget, 7, &["intervals"]);
        assert!(many.contains("7 candidates were not fitted (effect_1, effect_2"), "{many}");
        assert!(many.contains("and 2 more); left out: intervals; so the answer is not final"), "{many}");
        let answer = words(None, CutBy::Budget, 0, &["intervals"]);
        assert!(answer.contains("the search was completed") && !answer.contains("not final"), "{answer}");
        let interrupted = words(Some(1), CutBy::Interruption, 0, &[]);
        assert!(interrupted.contains("another machine may give another answer. fits in progress"));
        for own in [one, many, answer, interrupted] {
            assert!(!own.contains(" 0 "), "{own}");
        }
    }
}
