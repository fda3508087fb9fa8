//! Effects that became idle: what stood in for another one is not needed beside it.

use super::Course;
use super::candidate::Candidate;
use super::judge::{Judgement, Locked, judgement};
use super::round::Best;
use super::verdict::{Added, Evidence};
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

impl Course<'_> {
    /// Leaves out again what is not needed beside what came later.
    pub(super) fn leave_out_idle(&mut self) -> Result<(), CalibrateError> {
        let mut known = self.model.fit()?.known();
        while let Some(lean) = without_idle(&self.problem, &self.added, &known, self.cost)? {
            let idle = self.added.remove(lean.left_out);
            self.listener.doing(&format!("{} became idle", idle.candidate.name()));
            let of_idle = |evidence: &&mut Evidence| evidence.effect == idle.candidate.name();
            for evidence in self.diagnosis.evidence.iter_mut().filter(of_idle) {
                evidence.rejected.get_or_insert_with(|| "it became idle beside the others".to_owned());
            }
            self.added.last_mut().expect("one is left").locked =
                Locked::meet(&lean.fitted.problem, &lean.known)?;
            self.after = lean.judgement;
            (self.diagnosis.effects, self.cost) = (lean.effects, lean.cost);
            (self.model, known) = (lean.fitted, lean.known);
            self.steps.truncate(lean.left_out);
            self.remember();
        }
        Ok(())
    }
}
