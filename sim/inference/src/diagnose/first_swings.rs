//! The first swings before the rest, where a model does not even meet those.
//!
//! A score takes the residual to grow in proportion to what is missing. A model that is a quarter of a swing behind
//! after the first one has lost the phase, and its residual says no more than that. So each candidate is fitted to
//! the first swings instead, from its typical size and within what is believed of the setup: they cost little, and
//! in them no phase is lost by a whole turn. Those that bring the model to meet them are fitted to the whole
//! recordings, and the search goes on from the best.

use std::collections::HashSet;

use rayon::prelude::*;

use super::Course;
use super::before::Before;
use super::candidate::{Candidate, candidates};
use super::mesh_check::{self, LAW, Numerics};
use super::refit::{Refit, most_steps, penalty, within_steps};
use super::round::NO_MORE;
use super::shortlist::{Best, LEAD, falls_behind};
use super::stop::{CUT_SHORT, ending_by, is_over, not_run};
use super::validation::{HeldOut, set};
use super::verdict::{Evidence, Member};
use super::warnings::is_strained;
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::prediction::{FIT, Slopes};
use crate::calibrate::search::Meeting;
use crate::calibrate::uncertainty::uncertainty;
use crate::calibrate::{CalibrateError, Problem};
use crate::ordered::in_order;

/// Swings that are looked at.
const SWINGS: f64 = 2.0;
/// Residuals of this share of the motion, over all of these swings, are those of a phase that is lost.
const LOST: f64 = 0.2;
/// Those that leave more than so many times the least are not fitted to the whole recordings.
const WORSE: f64 = 3.0;

/// What should be known where they were asked first.
pub(super) const WARNING: &str = "the baseline misses even the first swings; its results are from a fit to these alone, and candidates were fitted to them first";

/// The first swings of a problem, which its model does not meet.
#[derive(Clone)]
pub(super) struct FirstSwings {
    /// The problem, kept near what is believed.
    problem: Problem,
    /// Samples of each release that belong to them.
    counts: Vec<usize>,
    cost: f64,
    known: Vec<Estimate>,
}

/// A candidate at the first swings.
struct Met {
    candidate: Candidate,
    /// What it costs there with all else fitted, and where that is; none where it cannot be run.
    end: Option<(f64, Vec<Estimate>)>,
}

/// The first swings, if the model cannot be brought to meet them.
fn lost(problem: &Problem) -> Result<Option<FirstSwings>, CalibrateError> {
    let counts = Joint::first_swings(problem, SWINGS)?;
    let mut meeting = Joint::meeting(problem, &counts)?;
    meeting.go_on(usize::MAX);
    if meeting.missed <= LOST {
        return Ok(None);
    }
    let Some(fit) = Joint::met(problem, meeting) else { return Ok(None) };
    let problem = within_steps(problem, most_steps(&fit));
    let (cost, known) = (fit.cost(), fit.known());
    Ok(Some(FirstSwings { problem, counts, cost, known }))
}

/// How the model that comes nearest to the first swings meets the whole recordings, if it does not even meet those.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense.
pub(super) fn before(problem: &Problem) -> Result<Option<Before>, CalibrateError> {
    let Some(first_swings) = lost(problem)? else { return Ok(None) };
    let mut problem = problem.clone();
    set(&mut problem, &first_swings.known);
    let fit = Joint::at(&problem, &first_swings.known, Slopes::Variational, FIT);
    let Some(fit) = CalibrateError::if_run(fit)? else { return Ok(None) };
    Before::of(fit, HeldOut::as_predicted, Some(first_swings)).map(Some)
}

impl FirstSwings {
    /// Each candidate at the first swings, from its typical size and the start that is best by the first swing. If one meets
    /// the swings, other starts are tried only for those that come near it, else for all: of 36 effects on a strong push of the
    /// hand, other starts lowered the cost of none by more than 3 %.
    fn with_each(
        &self,
        candidates: Vec<Candidate>,
        tell: &(dyn Fn(&Candidate) + Sync),
    ) -> Result<Vec<Met>, CalibrateError> {
        let begin = |candidate: Candidate| {
            tell(&candidate);
            let Ok(problem) = candidate.added_to(&self.problem, candidate.strength.default) else {
                return Ok((candidate, None));
            };
            let mut meeting = Joint::meeting(&problem, &self.counts)?;
            meeting.go_on(1);
            Ok((candidate, Some((problem, meeting))))
        };
        let begun = in_order::<_, Result<Vec<_>, CalibrateError>>(candidates.into_par_iter().map(begin));
        let mut all = begun?;
        let meetings = || all.iter().filter_map(|(_, begun)| Some(&begun.as_ref()?.1));
        if is_over(&self.problem) {
            return Ok(all.into_iter().map(Met::of).collect());
        }
        let is_met_by_one = meetings().any(Meeting::is_met);
        let least = meetings().map(Meeting::cost).fold(f64::INFINITY, f64::min);
        let goes_on =
            |meeting: &Meeting| !meeting.is_over && (!is_met_by_one || meeting.cost() <= WORSE * least);
        all.par_iter_mut().for_each(|(candidate, begun)| {
            if let Some((_, meeting)) = begun.as_mut().filter(|(_, meeting)| goes_on(meeting)) {
                tell(candidate);
                meeting.go_on(usize::MAX);
            }
        });
        Ok(all.into_iter().map(Met::of).collect())
    }

    /// What a candidate has to explain, as a score: all but the error of a law.
    fn threshold(&self) -> f64 {
        (2.0 * (1.0 - LAW) * self.cost).sqrt()
    }
}

impl Met {
    /// A candidate with its search, if that could begin.
    fn of((candidate, begun): (Candidate, Option<(Problem, Meeting)>)) -> Self {
        let fit = begun.and_then(|(problem, meeting)| Joint::met(&problem, meeting));
        Self { candidate, end: fit.map(|fit| (fit.cost(), fit.known())) }
    }

    fn cost(&self) -> f64 {
        self.end.as_ref().map_or(f64::INFINITY, |(cost, _)| *cost)
    }

    fn evidence(&self, first_swings: &FirstSwings, round: usize) -> Evidence {
        let path = self.candidate.path();
        let known = self.end.iter().flat_map(|(_, known)| known);
        let strengths: Vec<f64> =
            known.filter(|known| known.unknown.name == path).map(Estimate::value).collect();
        let decrease = 2.0 * (first_swings.cost - self.cost()).max(0.0);
        Evidence {
            round,
            effect: self.candidate.name().to_owned(),
            of_each_pressure: self.candidate.is_widened(),
            of_first_swings: true,
            tried: Vec::new(),
            score: decrease.sqrt(),
            predicted_decrease: decrease,
            realised_decrease: None,
            strength: strengths.iter().sum::<f64>() / strengths.len().max(1) as f64,
            held_out_decrease: None,
            rejected: None,
        }
    }

    /// The whole recordings with it, from where the first swings lead. None where that cannot be run.
    fn whole(
        &self,
        problem: &Problem,
        without: usize,
        tell: &(dyn Fn(&str) + Sync),
    ) -> Result<Option<Whole>, CalibrateError> {
        let typical = self.candidate.strength.default;
        let (Some((_, known)), Ok(mut with)) = (&self.end, self.candidate.added_to(problem, typical)) else {
            return Ok(None);
        };
        set(&mut with, known);
        // Each begins where the models are now.
        with.parameters.iter_mut().for_each(|parameter| parameter.start = None);
        let found = self.candidate.within_ranges(with, |problem| {
            let found = CalibrateError::if_run(mesh_check::on_fine_mesh(problem, tell))?;
            Ok(found.map(|(fitted, numerics)| {
                let known = fitted.known();
                ((fitted, numerics), known)
            }))
        })?;
        let Some((fitted, numerics)) = found else { return Ok(None) };
        let refit = Refit::of(fitted, &self.candidate, without);
        let fit = &refit.fitted;
        let path = self.candidate.path();
        let strength = fit.objective.part.unknowns.iter().position(|unknown| unknown.name == path);
        let of = uncertainty(&fit.objective, &fit.found);
        let variance_inflation = strength.map_or(1.0, |k| of.variance_inflation(k));
        let variance_inflation =
            if variance_inflation.is_finite() { variance_inflation.max(1.0) } else { 1.0 };
        let penalty = refit.unknowns as f64 * penalty(fit, variance_inflation);
        Ok(Some(Whole { candidate: self.candidate.clone(), refit, numerics, variance_inflation, penalty }))
    }
}

/// A candidate fitted to the whole recordings.
struct Whole {
    candidate: Candidate,
    refit: Refit,
    numerics: Numerics,
    /// Variance of the noise over that of white noise as large as stated.
    variance_inflation: f64,
    /// χ² that its unknowns have to be worth.
    penalty: f64,
}

impl Whole {
    /// What it leaves of χ², and what its unknowns have to be worth.
    fn worth(&self) -> f64 {
        2.0 * self.refit.cost / self.variance_inflation + self.penalty
    }
}

impl Course<'_> {
    /// Adds the effect with which the model meets the first swings and fits the whole recordings best. False where
    /// none does.
    pub(super) fn add_by_first_swings(&mut self, first_swings: &FirstSwings) -> Result<bool, CalibrateError> {
        let number = self.diagnosis.thresholds.len() + 1;
        if self.is_stopped() {
            self.cut_short_before(number);
            return Ok(false);
        }
        let listener = self.listener;
        let stop = listener.stop();
        let first_swings =
            &FirstSwings { problem: ending_by(&first_swings.problem, &stop), ..first_swings.clone() };
        let problem = ending_by(&self.problem, &stop);
        let tell = |what: &str| listener.doing(&format!("round {number}: {what}"));
        let tell_first = |candidate: &Candidate| tell(&format!("first swings with {}", candidate.name()));
        let mut met = first_swings.with_each(self.candidates_of_first_swings(first_swings), &tell_first)?;
        // Then other starts were left out.
        let is_cut = is_over(&problem);
        met.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        let mut seen = HashSet::new();
        met.retain(|met| seen.insert(met.candidate.name()));
        let mut evidence: Vec<Evidence> = met.iter().map(|met| met.evidence(first_swings, number)).collect();
        let threshold = first_swings.threshold();
        listener.ranked(threshold, &evidence);
        let least = met.first().map_or(f64::INFINITY, Met::cost);
        let mut found: Vec<(usize, Whole)> = Vec::new();
        for (k, (met, evidence)) in met.iter().zip(&mut evidence).enumerate() {
            if is_cut && (met.end.is_none() || evidence.score < threshold) {
                evidence.reject(CUT_SHORT);
            } else if evidence.score < threshold {
                evidence.reject("with it the model does not fit the first swings either");
            } else if self.settings.most_effects == 0 {
                evidence.reject(NO_MORE);
            } else if met.cost() > WORSE * least {
                evidence.reject("it fits the first swings less well than others");
            } else if is_over(&problem) {
                evidence.reject(CUT_SHORT);
            } else {
                let name = met.candidate.name();
                let whole =
                    met.whole(&problem, first_swings.known.len(), &|what| tell(&format!("{name}: {what}")))?;
                match whole {
                    Some(whole) => found.push((k, whole)),
                    None => evidence.reject(not_run(&problem)),
                }
            }
        }
        found.sort_by(|a, b| a.1.worth().total_cmp(&b.1.worth()));
        // What contradicts the rod or the setup as they are stated comes after what does not.
        found.sort_by_key(|(_, whole)| is_strained(&whole.refit.known));
        let best = self.best_of(found, &mut evidence);
        self.diagnosis.thresholds.push(threshold);
        listener.ranked(threshold, &evidence);
        self.cut_short_in(number, &evidence);
        self.diagnosis.evidence.extend(evidence);
        let Some((best, numerics)) = best else { return Ok(false) };
        self.take_mesh(&numerics);
        tell("validation on held-out releases");
        let best = self.lasting(Box::new(best))?;
        let held_out = HeldOut::meet(&best.refit.fitted.problem, &best.refit.known)?;
        self.add(Box::new(Best { held_out, ..*best }))?;
        Ok(true)
    }

    /// Values that are tried are starts here, of which the best of each effect counts.
    fn candidates_of_first_swings(&self, first_swings: &FirstSwings) -> Vec<Candidate> {
        let mut all = candidates(&first_swings.problem, self.settings);
        if self.is_widened {
            all = all.iter().filter_map(Candidate::of_each_pressure).collect();
        }
        all
    }

    /// The first of those that fit the whole recordings, and the others that do as well.
    fn best_of(&self, found: Vec<(usize, Whole)>, evidence: &mut [Evidence]) -> Option<(Best, Numerics)> {
        let mut found = found.into_iter();
        let (first, best) = found.next()?;
        let (gain, least) = (2.0 * (self.cost - best.refit.cost) / best.variance_inflation, best.worth());
        evidence[first].realised_decrease = Some(gain);
        let mut members = Vec::new();
        for (k, other) in found {
            let behind = other.worth() - least;
            evidence[k].realised_decrease =
                Some(2.0 * (self.cost - other.refit.cost) / best.variance_inflation);
            if behind >= LEAD {
                evidence[k].reject(&falls_behind(behind, best.candidate.name()));
                continue;
            }
            let effect = other.candidate.name().to_owned();
            // Fitted side by side: what is left between them is how far they are apart.
            let distance = behind.max(0.0).sqrt();
            members.push((Member { effect, behind, distance }, other.candidate));
        }
        let Whole { candidate, refit, numerics, variance_inflation, penalty } = best;
        Some((
            Best { candidate, refit, held_out: None, variance_inflation, penalty, gain, members },
            numerics,
        ))
    }

    /// Gives the model without anything added the mesh on which that was fitted.
    fn take_mesh(&mut self, numerics: &Numerics) {
        let factor = (numerics.nodes - 1) / (numerics.nodes_given - 1).max(1);
        if factor > 1 {
            let mut finer = self.problem.clone();
            if finer.trials_mut().try_for_each(|trial| trial.refine(factor)).is_ok() {
                self.problem = finer;
                // They were fitted on the mesh before.
                self.lifts.clear();
            }
        }
        self.diagnosis.numerics = numerics.clone();
    }
}
