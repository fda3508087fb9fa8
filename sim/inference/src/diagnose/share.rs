//! How much of what was missing is explained, of all samples, in mm, without the noise of the camera; and whether an answer is
//! believed.

use super::constancy::{INCONSTANT, inconstant};
use super::curve::{Agreement, is_noise, mean_square, of_all};
use super::validation::{is_astray, is_missed};
use super::verdict::{Added, Evidence, Gap, Shares, Verdict};
use super::{Best, Course};
use crate::calibrate::CalibrateError;
use crate::calibrate::joint::Joint;

impl Shares {
    /// Of the gaps of all releases.
    pub(super) fn of(gaps: &[Gap]) -> Self {
        let of = |held_out: bool, own: fn(&Gap) -> [f64; 2]| {
            let own: Vec<[f64; 2]> = gaps.iter().filter(|gap| gap.held_out == held_out).map(own).collect();
            mean_square(own.into_iter())
        };
        let [first, left] = [of(false, before), of(false, after)];
        let share = |held_out: bool| removed(of(held_out, before), of(held_out, after));
        Self {
            before_mm: first[0].sqrt(),
            left_mm: left[0].sqrt(),
            removed: share(false),
            removed_held_out: share(true),
        }
    }
}

fn before(gap: &Gap) -> [f64; 2] {
    [gap.before_mm, gap.noise_mm]
}

fn after(gap: &Gap) -> [f64; 2] {
    [gap.after_mm, gap.noise_mm]
}

/// Share of the square of the noise below which what is beyond it is nothing: a hundred samples know their mean square to
/// a tenth, thousands to this.
const NOTHING: f64 = 0.02;

/// Share of the square beyond the noise that is gone; none where there was none.
fn removed([before, noise]: [f64; 2], [after, _]: [f64; 2]) -> Option<f64> {
    (before > (1.0 + NOTHING) * noise).then(|| (before - after) / (before - noise))
}

/// Whether a model misses at most half of what another one misses, of the squares beyond the noise.
fn most(before: &Agreement, after: &Agreement) -> bool {
    removed(of_all(before), of_all(after)).is_none_or(|share| share >= 0.5)
}

/// A model on the way.
pub(super) struct Step {
    pub model: Joint,
    pub after: Agreement,
    pub held_out: Option<Agreement>,
}

impl Course<'_> {
    /// Keeps the model as it is now.
    pub(super) fn remember(&mut self) {
        self.steps.truncate(self.added.len() - 1);
        self.steps.push(Step {
            model: self.model.clone(),
            after: self.after.clone(),
            held_out: self.held_out().map(|held_out| held_out.agreement.clone()),
        });
    }

    /// Whether what the model misses of all releases together is no more than what two of them differ by. Before anything
    /// is added that is asked only where the experiment itself tells how well it repeats.
    pub(super) fn is_within_repeats(&self) -> Result<bool, CalibrateError> {
        let Some(repeats) = &self.diagnosis.repeats else { return Ok(false) };
        if !repeats.is_known() && self.added.is_empty() {
            return Ok(false);
        }
        let is_within = |met: &Agreement| of_all(met)[0].sqrt() <= repeats.largest_mm(met.gaps.len());
        if !is_within(&self.after) {
            return Ok(false);
        }
        let Some(held_out) = self.held_out() else { return Ok(true) };
        let met = held_out.met_together(&self.model)?;
        Ok(is_within(&met.unwrap_or_else(|| held_out.agreement.clone())))
    }

    /// Whether what was added is as strong in one release as in another, and meets held-out releases.
    pub(super) fn is_believed(&mut self) -> Result<bool, CalibrateError> {
        let all = self.held_out().map(|held_out| held_out.together(&self.model)).transpose()?.flatten();
        let inconstant = inconstant(all.unwrap_or(&self.model), &self.added, self.settings.false_alarm);
        let is_inconstant = |own: &&mut Evidence| inconstant.contains(&own.effect.as_str());
        for evidence in self.diagnosis.evidence.iter_mut().filter(is_inconstant) {
            evidence.reject(INCONSTANT);
        }
        let warning = |effect| format!("{effect} fits, but {INCONSTANT}: it stands in for another effect");
        self.diagnosis.warnings.extend(inconstant.iter().map(warning));
        Ok(inconstant.is_empty() && !self.is_astray()?)
    }

    /// Whether held-out releases are missed by more than the model that is right would miss.
    pub(super) fn is_astray(&self) -> Result<bool, CalibrateError> {
        let Some(held_out) = self.held_out() else { return Ok(false) };
        let squares = held_out.mean_squares(&self.model)?;
        Ok(squares.is_some_and(is_astray))
    }

    /// Whether the residuals of held-out releases are larger than those of fitted ones.
    pub(super) fn is_missed(&self) -> bool {
        let squares = |met: &Agreement| met.gaps.iter().map(|(_, _, own, _)| own * own).collect::<Vec<f64>>();
        let held_out = self.held_out();
        held_out.is_some_and(|own| is_missed(&squares(&self.after), &squares(&own.agreement)))
    }

    /// Whether what the model misses of what it was fitted to is noise, or no more than what two releases differ by.
    pub(super) fn is_within_noise(&self) -> bool {
        let repeats = self.diagnosis.repeats.as_ref();
        is_noise(&self.after, repeats.map_or(0.0, |repeats| repeats.largest_mm(self.after.gaps.len())))
    }

    /// Where something is left that has no name: of what was added, the first effects of which each explains most of what
    /// was missing before it, in what was fitted and in held-out releases. The others may stand in for anything.
    pub(super) fn keep_what_explains_most(&mut self) -> Result<(), CalibrateError> {
        let is_misstated = !self.diagnosis.contradictions.is_empty();
        let is_open = self.diagnosis.verdict == Verdict::Unknown && !is_misstated;
        if !is_open || self.added.is_empty() || self.before.first_swings.is_some() {
            return Ok(());
        }
        let (mut fitted, mut held_out) =
            (&self.before.fitted, self.before.held_out.as_ref().map(|own| &own.agreement));
        let mut kept = 0;
        for step in &self.steps {
            let explains = most(fitted, &step.after)
                && held_out.zip(step.held_out.as_ref()).is_none_or(|(before, after)| most(before, after));
            if !explains {
                break;
            }
            (fitted, held_out) = (&step.after, step.held_out.as_ref());
            kept += 1;
        }
        if kept == 0 {
            return Ok(());
        }
        self.diagnosis.verdict = Verdict::Incomplete;
        let left_out: Vec<&'static str> =
            self.added[kept..].iter().map(|best| best.candidate.name()).collect();
        let is_left_out = |own: &&mut Evidence| left_out.contains(&own.effect.as_str());
        for evidence in self.diagnosis.evidence.iter_mut().filter(is_left_out) {
            evidence.reject("it explains less than half of the remaining residual");
        }
        if kept < self.added.len() {
            self.added.truncate(kept);
            let Step { model, after, .. } = self.steps.swap_remove(kept - 1);
            (self.model, self.after) = (model, after);
            let of = |best: &Best| Added::of(&self.model, &best.candidate);
            self.diagnosis.effects = self.added.iter().map(of).collect();
        }
        Ok(())
    }
}
