//! Removes effects that became unnecessary: one that stood in for another is not needed beside it.

use super::Course;
use super::candidate::Candidate;
use super::curve::Agreement;
use super::shortlist::Best;
use super::validation::{HeldOut, agreement};
use super::verdict::{Added, Evidence};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::refine::RESOLUTION_FITTED;
use crate::calibrate::{CalibrateError, Problem};

/// A model without an unnecessary effect, fitted.
pub(super) struct Lean {
    /// Place of the effect among those that were added.
    pub left_out: usize,
    pub fitted: Joint,
    pub known: Vec<Estimate>,
    pub cost: f64,
    /// How it meets what it was fitted to.
    pub agreement: Agreement,
    /// The effects that are left, as they are now.
    pub effects: Vec<Added>,
}

/// The model without the first effect that is not worth its unknowns beside the others, if there is one; the
/// last one has just shown that it is. `problem` has none of them, `known` and `cost` are of all together.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense.
pub(super) fn pruned(
    problem: &Problem,
    added: &[Best],
    known: &[Estimate],
    cost: f64,
) -> Result<Option<Lean>, CalibrateError> {
    let Some(last) = added.last() else { return Ok(None) };
    for left_out in 0..added.len() - 1 {
        let others = || (0..added.len()).filter(|k| *k != left_out).map(|k| &added[k].candidate);
        let with = |problem: Problem, other: &Candidate| other.added_to(&problem, other.null_value);
        let Ok(mut lean) = others().try_fold(problem.clone(), with) else { continue };
        // A range that was widened stays so.
        let all = &last.refit.fitted.problem.parameters;
        for own in &mut lean.parameters {
            if let Some(fitted) = all.iter().find(|fitted| fitted.path == own.path) {
                own.bounds = fitted.bounds;
            }
        }
        let Some(fit) = Joint::follow(&lean, known, RESOLUTION_FITTED)? else { continue };
        let loss = 2.0 * (fit.cost() - cost) / added[left_out].variance_inflation;
        if loss < added[left_out].penalty {
            let effects = others().map(|candidate| Added::of(&fit, candidate)).collect();
            let (known, cost, agreement) = (fit.known(), fit.cost(), agreement(&fit));
            return Ok(Some(Lean { left_out, fitted: fit, known, cost, agreement, effects }));
        }
    }
    Ok(None)
}

impl Course<'_> {
    /// Leaves out again what is not needed beside what came later.
    pub(super) fn prune(&mut self) -> Result<(), CalibrateError> {
        let mut known = self.model.known();
        while let Some(lean) = pruned(&self.problem, &self.added, &known, self.cost)? {
            let pruned_effect = self.added.remove(lean.left_out);
            self.listener.doing(&format!("{} is unnecessary", pruned_effect.candidate.name()));
            let of_pruned = |evidence: &&mut Evidence| evidence.effect == pruned_effect.candidate.name();
            for evidence in self.diagnosis.evidence.iter_mut().filter(of_pruned) {
                evidence.rejected.get_or_insert_with(|| "it is unnecessary beside the others".to_owned());
            }
            self.added.last_mut().expect("one is left").held_out =
                HeldOut::meet(&lean.fitted.problem, &lean.known)?;
            self.after = lean.agreement;
            (self.diagnosis.effects, self.cost) = (lean.effects, lean.cost);
            (self.model, known) = (lean.fitted, lean.known);
            self.steps.truncate(lean.left_out);
            self.remember();
        }
        Ok(())
    }
}
