//! A search that ends early: its budget is spent, or the user interrupts it.
//!
//! Fits of candidates end with the run that they are in. What is fitted by then is compared, and the answer says that
//! it was cut short. What an answer needs of the models that were fitted is still done.

use efam_core::forward::Cancel;

use super::Course;
use super::verdict::Diagnosis;
use crate::calibrate::joint::Joint;
use crate::calibrate::{CalibrateError, Problem};

/// Why a candidate has no answer where the search was cut short.
pub(super) const CUT_SHORT: &str = "the search was cut short before it was fitted";

/// Whether what is done with a problem was asked to end.
pub(super) fn is_stopped(problem: &Problem) -> bool {
    problem.trials.iter().any(|trial| trial.run.cancel.is_requested())
}

/// Why a candidate has no fit.
pub(super) fn not_run(problem: &Problem) -> &'static str {
    if is_stopped(problem) { CUT_SHORT } else { "a model with it cannot be simulated" }
}

/// The same problem, whose runs end when a request says so.
pub(super) fn ending_by(problem: &Problem, stop: &Cancel) -> Problem {
    let mut problem = problem.clone();
    problem.trials_mut().for_each(|trial| trial.run.cancel = stop.clone());
    problem
}

impl Course<'_> {
    /// Whether the search was asked to end.
    pub(super) fn is_stopped(&self) -> bool {
        self.listener.stop().is_requested()
    }

    /// The model as it is, whose runs end when the search is asked to.
    pub(super) fn ending(&self) -> Result<Joint, CalibrateError> {
        self.model.clone().with_problem(ending_by(&self.model.problem, &self.listener.stop()))
    }
}

impl Diagnosis {
    /// Notes that the search was cut short in a round.
    pub(super) fn cut_short(&mut self, round: usize) {
        self.cut_short_in_round.get_or_insert(round);
    }
}

/// What should be known of a search that was cut short.
pub(super) fn warning(diagnosis: &Diagnosis) -> Option<String> {
    let round = diagnosis.cut_short_in_round?;
    let left = diagnosis.evidence.iter().filter(|own| own.rejected.as_deref() == Some(CUT_SHORT)).count();
    Some(format!(
        "the search was cut short in round {round}: {left} candidates were not fitted, so the answer is not final; give a longer --budget, or leave out candidates with --without"
    ))
}
