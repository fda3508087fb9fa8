//! What is stated of the rod and of the setup competes with the effects.
//!
//! In a search no belief gives way by more than [`FARTHEST`] deviations. Without that limit a model that lacks an effect
//! takes an impossible setup instead, and from there a fit with the effect finds no way back. Where the baseline or the
//! answer needs a belief at its limit, that belief alone is lifted in the model without any effect. If that does as well
//! for its unknowns, what is stated is wrong, or nobody can tell.

use super::Course;
use super::section::FARTHEST;
use super::stop::ending_by;
use super::verdict::Contradiction;
use super::warnings::{contradictions, deviations_off};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::search::STAGE_SHARE;
use crate::calibrate::unknowns::Kind;
use crate::calibrate::{CalibrateError, Problem};

/// How much less is believed of a marker's place or of an angle that is lifted.
const LIFTED: f64 = 25.0;

/// Keeps every belief of a parameter within its limit, where no bounds are given.
pub(super) fn limit_beliefs(problem: &mut Problem) {
    let Some(trial) = problem.trials.first() else { return };
    let range = |path: &str| {
        trial
            .model
            .index(path)
            .map_or((f64::NEG_INFINITY, f64::INFINITY), |k| trial.model.parameters[k].range)
    };
    for own in problem.parameters.iter_mut().filter(|own| own.bounds.is_none()) {
        let Some(prior) = own.prior else { continue };
        let (least, most) = range(&own.path);
        let room = FARTHEST * prior.deviation;
        own.bounds = Some(((prior.mean - room).max(least), (prior.mean + room).min(most)));
    }
}

/// The problem with one of its beliefs lifted.
fn lifted(problem: &Problem, known: &Estimate) -> Problem {
    let mut problem = problem.clone();
    match known.unknown.kind {
        Kind::HoldAngle => problem.nuisances.hold_angle.iter_mut().for_each(|own| *own *= LIFTED),
        Kind::Offset { .. } => problem.nuisances.offset.iter_mut().for_each(|own| *own *= LIFTED),
        _ => {
            for own in problem.parameters.iter_mut().filter(|own| own.path == known.unknown.name) {
                (own.prior, own.bounds) = (None, None);
            }
        }
    }
    problem
}

impl Course<'_> {
    /// What alone would have to be otherwise than stated, if that does as well as what was added; empty where nothing does.
    pub(super) fn misstated(&self) -> Result<Vec<Contradiction>, CalibrateError> {
        if self.added.is_empty() || self.is_stopped() {
            return Ok(Vec::new());
        }
        // What stood at its limit before an effect gave way may be what the effect stands in for.
        let known = self.model.fit()?.known();
        let all = self.before.known.iter().chain(&known);
        let mut at_limit: Vec<&Estimate> = all.filter(|own| deviations_off(own, own).is_some()).collect();
        at_limit.sort_by(|a, b| a.unknown.name.cmp(&b.unknown.name));
        at_limit.dedup_by_key(|own| &own.unknown.name);
        let variance_inflation = self.added.iter().map(|best| best.variance_inflation).fold(1.0, f64::max);
        let penalty: f64 = self.added.iter().map(|best| best.penalty).sum();
        let mut least = self.cost + 0.5 * variance_inflation * penalty;
        let (baseline, stop) = (self.before.model.fit()?, self.listener.stop());
        // From the start, since a belief at its limit may have lost the phase of the swing. What mesh and step do is known
        // from the baseline, unless that misses the first swings.
        let view = &baseline.found.view;
        let without = |problem: Problem, share: f64| {
            let problem = ending_by(&problem, &stop);
            let fit = match view.corrections {
                Some(_) => Joint::search_like(&problem, view, share),
                None => Joint::search(&problem, &|_| ()).map(Some),
            };
            match fit {
                Err(CalibrateError::NoFit { .. } | CalibrateError::Forward { .. }) => Ok(None),
                fit => Ok(fit?.map(|fit| (fit.cost(), fit.known()))),
            }
        };
        // Where all of them together do less well, none of them does as well alone.
        if at_limit.len() > 1 {
            self.listener.doing("test of what is stated");
            let all = at_limit.iter().fold(self.problem.clone(), |problem, own| lifted(&problem, own));
            if without(all, STAGE_SHARE)?.is_some_and(|(cost, _)| (1.0 - STAGE_SHARE) * cost >= least) {
                return Ok(Vec::new());
            }
        }
        let mut misstated = Vec::new();
        for own in at_limit {
            self.listener.doing(&format!("test of the stated {}", own.unknown.name));
            let Some((cost, found)) = without(lifted(&self.problem, own), 0.0)? else { continue };
            if cost < least {
                least = cost;
                let of_it = found.iter().filter(|other| other.unknown.name == own.unknown.name);
                misstated = contradictions(of_it.map(|other| (other, own)));
            }
        }
        Ok(misstated)
    }
}
