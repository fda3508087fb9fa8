//! What is stated of the rod and of the setup competes with the effects.
//!
//! In a search no belief gives way by more than [`FARTHEST`] deviations. Without that limit a model that lacks an effect
//! takes an impossible setup instead, and from there a fit with the effect finds no way back. Where the baseline or the
//! answer needs a belief at its limit, that belief alone is lifted in the model without any effect. Where it is one of the
//! setup, such as an angle, and nothing is missing then, the statement is wrong, and no effect is looked for. If a lifted
//! belief does as well for its unknowns as the effects that were found, either may be the answer, and the statement is
//! said first. If it leads by what names an effect, the effects are no answer.

use rayon::prelude::*;

use super::Course;
use super::refit::{penalty, prefix};
use super::round::RoundRequest;
use super::section::TILT;
use super::shortlist::{Best, LEAD, RoundOutcome};
use super::stop::ending_by;
use super::validation::{HeldOut, agreement};
use super::verdict::{Contradiction, Verdict};
use super::warnings::{contradictions, deviations_off};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::refine::RESOLUTION_FITTED;
use crate::calibrate::stage::STAGE_SHARE;
use crate::calibrate::unknowns::{CLAMP_ANGLE, Group, Unknown, UnknownKind};
use crate::calibrate::{CalibrateError, Problem};
use crate::ordered::in_order;

/// Standard deviation of what is believed of a clamp's angle where nothing is said of it, rad: set by eye, or with a
/// protractor.
const USUAL_CLAMP: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// How much less is believed of a marker's place or of an angle that is lifted.
const LIFTED: f64 = 25.0;

/// The problem with one of its beliefs lifted.
fn lifted(problem: &Problem, known: &Estimate) -> Problem {
    let mut problem = problem.clone();
    match known.unknown.kind {
        UnknownKind::ClampAngle => problem.nuisances.clamp_angle = Some(LIFTED * USUAL_CLAMP),
        UnknownKind::HoldAngle => problem.nuisances.hold_angle.iter_mut().for_each(|own| *own *= LIFTED),
        UnknownKind::Offset { .. } => problem.nuisances.offset.iter_mut().for_each(|own| *own *= LIFTED),
        _ => {
            for own in problem.parameters.iter_mut().filter(|own| own.path == known.unknown.name) {
                (own.prior, own.bounds) = (None, None);
            }
        }
    }
    problem
}

/// A model without any effect and with one belief lifted.
#[derive(Clone)]
pub(super) struct Lift {
    /// The belief.
    own: Estimate,
    /// What the model costs; infinite where it cannot be run.
    cost: f64,
    known: Vec<Estimate>,
}

impl Lift {
    /// What was believed to be otherwise, as it is found: an unknown for each release or pressure that has its own.
    fn freed(&self) -> impl Iterator<Item = &Estimate> {
        self.known.iter().filter(|found| found.unknown.name == self.own.unknown.name)
    }

    /// What it costs: a belief that is lifted is as free as what an effect brings.
    fn worth(&self, each: f64) -> f64 {
        worth(self.cost, self.freed().count(), each)
    }

    /// What it says of the parameter that was believed to be otherwise.
    fn contradictions(&self) -> Vec<Contradiction> {
        contradictions(self.freed().map(|found| (found, &self.own)))
    }
}

/// A cost with what each of the unknowns takes that are free in a model, and not in the baseline.
fn worth(cost: f64, free: usize, each: f64) -> f64 {
    cost + 0.5 * each * free as f64
}

/// A statement that may be wrong in the place of what was found.
pub(super) struct Misstated {
    pub values: Vec<Contradiction>,
    /// Whether it leads by what names an effect.
    pub leads: bool,
}

/// What of the beliefs stands at its limit, each name once.
fn at_limit<'a>(known: impl Iterator<Item = &'a Estimate>) -> Vec<&'a Estimate> {
    let mut all: Vec<&Estimate> = known.filter(|own| deviations_off(own, own).is_some()).collect();
    all.sort_by(|a, b| a.unknown.name.cmp(&b.unknown.name));
    all.dedup_by_key(|own| &own.unknown.name);
    all
}

/// Whether it says how something stands: the clamp, a camera, a marker. What is stated of the rod, of its masses and of its start
/// competes with effects, such as a weight that nobody told of, or a hand that pushes: a rod that is pushed upwards swings
/// as one that was held higher.
fn is_of_setup(own: &Estimate) -> bool {
    matches!(own.unknown.kind, UnknownKind::ClampAngle | UnknownKind::Offset { .. })
        || own.unknown.name.starts_with(&prefix(TILT))
}

/// The clamp's angle as it is stated, where nothing is said of its error.
fn stated_clamp(problem: &Problem) -> Option<Estimate> {
    let is_believed = problem.nuisances.clamp_angle.is_some();
    let unknown = Unknown::nuisance(
        UnknownKind::ClampAngle,
        CLAMP_ANGLE,
        "rad",
        Group::All,
        USUAL_CLAMP,
        f64::INFINITY,
    );
    (!is_believed).then_some(Estimate { unknown, x: 0.0 })
}

impl<'a> Course<'a> {
    /// The course on which nothing is missing but one statement of the setup is wrong, if there is one. It is asked before any
    /// effect, since a search beside a wrong statement names what stands in for it.
    pub(super) fn misstated_alone(&mut self) -> Result<Option<Self>, CalibrateError> {
        let clamp = stated_clamp(&self.problem);
        let mut asked = at_limit(self.before.known.iter());
        if !asked.is_empty() {
            asked.extend(&clamp);
        }
        asked.retain(|own| is_of_setup(own));
        if !asked.is_empty() && !self.may_search("a test of the stated setup") {
            return Ok(None);
        }
        self.lifts = in_order::<_, Result<_, _>>(asked.into_par_iter().map(|own| self.lift(own)))?;
        let each = penalty(&self.before.model, 1.0);
        let best = self.lifts.iter().min_by(|a, b| a.worth(each).total_cmp(&b.worth(each)));
        // A belief at its limit that hardly costs anything is a caveat, and no answer.
        let leads = |best: &&Lift| 2.0 * (self.cost - best.worth(each)) >= LEAD;
        let Some(best) = best.filter(leads).cloned() else { return Ok(None) };
        if self.is_explained_by_an_effect(best.worth(each), each)? {
            return Ok(None);
        }
        let problem = lifted(&self.problem, &best.own);
        let stopped = ending_by(&problem, &self.listener.stop());
        let Some(fit) = Joint::follow(&stopped, &best.known, RESOLUTION_FITTED)? else { return Ok(None) };
        let mut alone = Self::new(self.before, self.settings, self.listener, self.diagnosis.clone());
        (alone.after, alone.cost) = (agreement(&fit), fit.cost());
        if !alone.is_within_noise() {
            return Ok(None);
        }
        alone.lifted_held_out = HeldOut::meet(&problem, &fit.known())?;
        (alone.model, alone.problem) = (fit.with_problem(problem.clone())?, problem);
        let is_all = alone.add_all()?.is_none()
            && alone.added.is_empty()
            && alone.diagnosis.verdict == Verdict::NothingMissing;
        if !is_all || alone.diagnosis.cut_short.is_some() || alone.is_astray()? {
            return Ok(None);
        }
        alone.diagnosis.verdict = Verdict::Misstated;
        alone.diagnosis.contradictions = Lift { known: alone.model.known(), ..best }.contradictions();
        Ok(Some(alone))
    }

    /// Whether the best effect beside what is stated costs less than a wrong statement: angles of many releases describe
    /// what one effect does as well. A baseline that misses the first swings has no scores, and is not asked.
    fn is_explained_by_an_effect(&mut self, statement: f64, each: f64) -> Result<bool, CalibrateError> {
        if self.before.first_swings.is_some() || self.is_stopped() {
            return Ok(false);
        }
        let request = RoundRequest { number: 1, is_last: self.settings.most_effects == 0, is_widened: false };
        let Some(round) = self.round(request)? else { return Ok(false) };
        let of = |effect: &Best| worth(effect.refit.cost, self.free(&effect.refit.known), each);
        let is_explained = matches!(&round.outcome, RoundOutcome::Effect(effect) if of(effect) < statement);
        // The search goes on from here.
        self.first_round = Some(round);
        Ok(is_explained)
    }

    /// How many unknowns a model has that the baseline has not.
    fn free(&self, known: &[Estimate]) -> usize {
        known.len().saturating_sub(self.before.known.len())
    }

    /// The model without any effect and with a belief lifted. From the baseline where that meets the recordings, or else from
    /// the start, since a belief at its limit may have lost the phase of the swing. What mesh and step do is known from the
    /// baseline, unless that misses the first swings.
    fn lift(&self, own: &Estimate) -> Result<Lift, CalibrateError> {
        self.listener.doing(&format!("test of the stated {}", own.unknown.name));
        let problem = ending_by(&lifted(&self.problem, own), &self.listener.stop());
        let baseline = &self.before.model;
        let view = &baseline.found.view;
        let fit = match view.corrections {
            Some(_) if baseline.is_met() => {
                Joint::approach(&problem, &self.before.known, view, true, STAGE_SHARE)
            }
            Some(_) => Joint::search_like(&problem, view),
            None => Joint::search(&problem, &|_| ()).map(Some),
        };
        let fit = CalibrateError::if_run(fit)?.flatten().map(|fit| (fit.cost(), fit.known()));
        let (cost, known) = fit.unwrap_or((f64::INFINITY, Vec::new()));
        Ok(Lift { own: own.clone(), cost, known })
    }

    /// What alone would have to be otherwise than stated, unless what was added leads it by as much as names an effect; and
    /// whether it leads as much itself.
    pub(super) fn misstated(&mut self) -> Result<Option<Misstated>, CalibrateError> {
        if self.added.is_empty() {
            return Ok(None);
        }
        let variance_inflation = self.added.iter().map(|best| best.variance_inflation).fold(1.0, f64::max);
        let known = self.model.known();
        let each = variance_inflation * penalty(&self.model, variance_inflation);
        let least = worth(self.cost, self.free(&known), each);
        // What stood at its limit before an effect gave way may be what the effect stands in for.
        let known = self.before.known.iter().chain(&known);
        let is_new =
            |own: &&Estimate| self.lifts.iter().all(|lift| lift.own.unknown.name != own.unknown.name);
        let new: Vec<&Estimate> = at_limit(known).into_iter().filter(is_new).collect();
        if !new.is_empty() && !self.may_search("a test of the stated setup beside the effects") {
            return Ok(None);
        }
        let new: Vec<Lift> = in_order::<_, Result<_, _>>(new.into_par_iter().map(|own| self.lift(own)))?;
        let lifts = [self.lifts.clone(), new].concat();
        let ahead = |lift: &Lift| 2.0 * (least - lift.worth(each)) / variance_inflation;
        let best =
            lifts.iter().max_by(|a, b| ahead(a).total_cmp(&ahead(b))).filter(|best| ahead(best) > -LEAD);
        Ok(best.map(|best| Misstated { values: best.contradictions(), leads: ahead(best) >= LEAD }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rod that a hand has pushed upwards swings as one that was held higher: such a start is no wrong statement.
    #[test]
    fn the_start_and_the_rod_are_not_asked_before_the_effects() {
        let of = |kind: UnknownKind, name: &str| {
            let unknown = Unknown::nuisance(kind, name, "", Group::All, 1.0, f64::INFINITY);
            is_of_setup(&Estimate { unknown, x: 0.0 })
        };
        assert!(
            of(UnknownKind::ClampAngle, CLAMP_ANGLE)
                && of(UnknownKind::Offset { track: 0, axis: 1 }, "offset")
        );
        assert!(of(UnknownKind::Parameter(0), "effects.frame_tilt.angle"));
        for (kind, name) in [
            (UnknownKind::HoldAngle, "hold angle"),
            (UnknownKind::Instant, "release instant"),
            (UnknownKind::Parameter(0), "rod.mass"),
            (UnknownKind::Parameter(0), "effects.tip_mass.mass"),
        ] {
            assert!(!of(kind, name), "{name}");
        }
    }
}
