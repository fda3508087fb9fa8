//! Effects that became idle: what stood in for another one is not needed beside it.

use super::candidate::Candidate;
use super::judge::{Judgement, judgement};
use super::round::Best;
use super::verdict::Added;
use crate::calibrate::joint::{Fitted, Joint, Known};
use crate::calibrate::{CalibrateError, Problem};

/// A model without an idle effect, fitted.
pub(super) struct Lean {
    /// Place of the effect among those that were added.
    pub left_out: usize,
    pub fitted: Fitted,
    pub known: Vec<Known>,
    pub cost: f64,
    /// How it meets what it was fitted to.
    pub judgement: Judgement,
    /// The effects that are left, as they are now.
    pub effects: Vec<Added>,
}

/// The model without the first effect that is not worth its unknowns beside the others, if there is one; the
/// last one has just shown that it is. `problem` has none of them, `known` and `cost` are of all together.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense.
pub(super) fn without_idle(
    problem: &Problem,
    added: &[Best],
    known: &[Known],
    cost: f64,
) -> Result<Option<Lean>, CalibrateError> {
    for left_out in 0..added.len().saturating_sub(1) {
        let others = || (0..added.len()).filter(|k| *k != left_out).map(|k| &added[k].candidate);
        let with = |problem: Problem, other: &Candidate| other.added_to(&problem, other.off);
        let Ok(lean) = others().try_fold(problem.clone(), with) else { continue };
        let Some(fit) = Joint::follow(&lean, known, &|_| ())? else { continue };
        let loss = 2.0 * (fit.cost() - cost) / added[left_out].widening;
        if loss < added[left_out].price {
            let effects = others().map(|candidate| Added::of(&fit, candidate)).collect();
            let (known, cost, judgement) = (fit.known(), fit.cost(), judgement(&fit));
            let found = fit.found;
            let fitted = Fitted::new(lean, found);
            return Ok(Some(Lean { left_out, fitted, known, cost, judgement, effects }));
        }
    }
    Ok(None)
}
