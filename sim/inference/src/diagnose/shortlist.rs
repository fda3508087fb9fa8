//! The few candidates of a round that are worth a fit: fitted, compared, and one chosen.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::curve::is_noise;
use super::mesh_check::LAW;
use super::refit::{Refit, Rough, penalised, penalty, refit, rough, rough_from};
use super::score::{APART, ONE, Score, Scores, distance};
use super::stop::{CUT_SHORT, is_over, not_run};
use super::validation::{HeldOut, agreement};
use super::verdict::{Evidence, Member};
use crate::calibrate::CalibrateError;
use crate::calibrate::joint::Joint;
use crate::calibrate::stage::STAGE_SHARE;
use crate::calibrate::uncertainty::uncertainty;
use crate::ordered::in_order;

/// Candidates fitted at once. Others follow while the best leaves more than noise: scores may put the gain of the right one too
/// low. The number is a matter of time, not of statistics.
const AT_ONCE: usize = 6;
/// Share of the largest promised decrease from which on a candidate is fitted.
const WORTH_FITTING: f64 = 0.3;
/// χ² by which the best may lead without standing alone.
pub(super) const LEAD: f64 = 12.0;
/// χ² that an unknown takes away where it means nothing, and as much again: Akaike (1974), IEEE Transactions on
/// Automatic Control 19, 716-723.
const FAIR: f64 = 2.0;
/// χ², in what noise gives, below which effects of which none is believed are not there at all.
const CHANCE: f64 = 3.0;
/// Why one is not fitted.
const SMALLER: &str = "its predicted gain is smaller than that of others";
/// Why one is not named that is too small beside what was found.
pub(super) const LITTLE: &str =
    "it is smaller than a tenth of what was found, which is within the error of a law";

/// An effect on its way through a round.
pub(super) struct Entry {
    pub candidate: Candidate,
    pub score: Score,
    /// The model with it, near its fit.
    rough: Option<Rough>,
    refit: Option<Refit>,
    /// Decrease of χ² when fitted, if only roughly.
    pub realised: Option<f64>,
    held_out: Option<f64>,
    rejected: Option<String>,
}

impl Entry {
    fn new(candidate: Candidate, score: Score) -> Self {
        let mut entry = Self {
            candidate,
            score,
            rough: None,
            refit: None,
            realised: None,
            held_out: None,
            rejected: None,
        };
        if entry.score.columns.is_empty() {
            entry.reject("the model already covers it, or cannot be simulated with it");
        } else if !entry.score.is_admissible {
            entry.reject("it would need the wrong sign");
        }
        entry
    }

    /// Says why it is not the answer; the first reason stands.
    pub fn reject(&mut self, why: impl Into<String>) {
        self.rejected.get_or_insert_with(|| why.into());
    }

    /// Says that it was not asked.
    pub fn cut_short(&mut self) {
        self.rejected = Some(CUT_SHORT.to_owned());
    }

    fn falls_behind(&mut self, by: f64, leader: &str) {
        self.reject(falls_behind(by, leader));
    }

    /// What the fit found of its strength.
    fn strength(&self) -> Option<f64> {
        Some(self.refit.as_ref()?.values.first()?.value)
    }

    /// Whether what it leaves may be noise.
    fn leaves_noise(&self) -> bool {
        self.refit.as_ref().is_some_and(|refit| is_noise(&agreement(&refit.fitted), 0.0))
    }

    fn is_beyond_belief(&self) -> bool {
        self.refit.as_ref().is_some_and(|refit| self.candidate.is_beyond_belief(&refit.values))
    }

    pub fn evidence(&self, round: usize) -> Evidence {
        let tried = self.candidate.tried.iter();
        Evidence {
            round,
            effect: self.candidate.name().to_owned(),
            of_each_pressure: self.candidate.is_widened(),
            of_first_swings: false,
            tried: tried.map(|(parameter, value)| (parameter.name.to_owned(), *value)).collect(),
            score: self.score.size,
            predicted_decrease: self.score.decrease,
            realised_decrease: self.realised,
            strength: self.strength().unwrap_or(self.score.estimate),
            held_out_decrease: self.held_out,
            rejected: self.rejected.clone(),
        }
    }
}

/// Why one is not the answer that fits less well than another.
pub(super) fn falls_behind(by: f64, leader: &str) -> String {
    format!("fits worse than {leader} by {by:.0} in χ², after the penalty for parameters")
}

/// Of each effect the try that promises most, largest score first.
pub(super) fn best_tries(candidates: Vec<Candidate>, scores: &Scores) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for (candidate, score) in candidates.into_iter().zip(&scores.each) {
        let entry = Entry::new(candidate, score.clone());
        match entries.iter_mut().find(|other| other.candidate.name() == entry.candidate.name()) {
            Some(other) if entry.score.size > other.score.size => *other = entry,
            Some(_) => {}
            None => entries.push(entry),
        }
    }
    entries.sort_by(|a, b| b.score.size.total_cmp(&a.score.size));
    entries
}

/// Result of the round.
pub(super) enum RoundOutcome {
    /// No candidate.
    Nothing,
    /// A candidate scores, and none of them can be the answer.
    Unexplained,
    /// An effect of the catalogue.
    Effect(Box<Best>),
    /// One more, of which only the score is known, where no more may be added.
    LimitReached(&'static str),
}

/// The effect that explains most, and those that explain as much.
pub(super) struct Best {
    pub candidate: Candidate,
    pub refit: Refit,
    /// How it meets held-out releases.
    pub held_out: Option<HeldOut>,
    /// Variance of the noise over that of white noise as large as stated.
    pub variance_inflation: f64,
    /// χ² that its unknowns have to be worth.
    pub penalty: f64,
    /// Decrease of χ² that it brought.
    pub gain: f64,
    /// Others that do as well, the nearest first; empty where the best stands alone.
    pub members: Vec<(Member, Candidate)>,
}

impl Best {
    /// Takes the place of the same effect with one strength for all pressures.
    pub fn widen(&mut self, narrow: Self) {
        self.gain += narrow.gain;
        self.penalty += narrow.penalty;
        if self.members.is_empty() {
            self.members = narrow.members;
        }
    }
}

/// Those that are worth a fit, and the others.
fn shortlist(entries: &mut [Entry]) -> (&mut [Entry], &mut [Entry]) {
    let possible = entries.iter().filter(|entry| entry.rejected.is_none());
    let most = possible.map(|entry| entry.score.decrease).fold(0.0, f64::max);
    let is_worth = |entry: &Entry| entry.rejected.is_none() && entry.score.decrease >= WORTH_FITTING * most;
    entries.sort_by_key(|entry| !is_worth(entry));
    let count = entries.iter().filter(|entry| is_worth(entry)).count();
    entries.split_at_mut(count)
}

/// Fits those that are worth a fit, some at once, until the best leaves no more than noise. Gives those that were fitted, and
/// says of the others why they were not; `tell` hears of each before its fit and after.
pub(super) fn fit_best<'a>(
    entries: &'a mut [Entry],
    fit: &Joint,
    scores: &Scores,
    tell: &(dyn Fn(&Entry) + Sync),
) -> Result<&'a mut [Entry], CalibrateError> {
    let (worth, others) = shortlist(entries);
    let mut fitted = 0;
    while fitted < worth.len() && !worth[..fitted].iter().any(Entry::leaves_noise) {
        if is_over(&fit.problem) {
            worth[fitted..].iter_mut().for_each(Entry::cut_short);
            break;
        }
        let next = (fitted + AT_ONCE).min(worth.len());
        fit_all(&mut worth[..next], fitted, fit, scores, tell)?;
        fitted = next;
    }
    let (fitted, rest) = worth.split_at_mut(fitted);
    rest.iter_mut().chain(others).for_each(|entry| entry.reject(SMALLER));
    Ok(fitted)
}

/// Fits those `from` a place on roughly, and in full those of them that come near the best of all.
fn fit_all(
    shortlist: &mut [Entry],
    from: usize,
    fit: &Joint,
    scores: &Scores,
    tell: &(dyn Fn(&Entry) + Sync),
) -> Result<(), CalibrateError> {
    let hear = |entry: &mut Entry, rough: Rough| {
        entry.realised = Some(2.0 * (fit.cost() - rough.cost) / scores.variance_inflation);
        entry.rough = Some(rough);
        tell(entry);
    };
    in_order::<_, Result<(), CalibrateError>>(shortlist[from..].par_iter_mut().map(|entry| {
        tell(entry);
        match rough(&entry.candidate, entry.score.estimate, fit)? {
            Some(rough) => hear(entry, rough),
            None => entry.reject(not_run(&fit.problem)),
        }
        Ok(())
    }))?;
    let by_cost = |a: &(&Entry, &Rough), b: &(&Entry, &Rough)| a.1.cost.total_cmp(&b.1.cost);
    let run = || shortlist.iter().filter_map(|entry| Some((entry, entry.rough.as_ref()?)));
    let Some((best, rough)) = run().min_by(by_cost) else { return Ok(()) };
    let (least, led, is_explained) = (rough.cost, rough.known.clone(), rough.is_explained);
    let distances: Vec<f64> = shortlist[from..].iter().map(|entry| apart(best, entry, scores)).collect();
    // χ² behind the best, as [`choose`] counts it.
    let variance_inflation = scores.variance_inflation;
    let each = [penalty(fit, variance_inflation), FAIR];
    let worth = |own: &Rough| each.map(|each| penalised(own.cost, own.unknowns(), each, variance_inflation));
    let lower = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].min(b[1])];
    let Some(least_worth) = run().map(|(_, own)| worth(own)).reduce(lower) else { return Ok(()) };
    let behind = |own: &Rough| {
        let own = worth(own);
        (own[0] - least_worth[0]).min(own[1] - least_worth[1])
    };
    // A search near its end was seen to gain up to a quarter of what it is behind, and by half it would not catch up.
    let near = 2.0 * (STAGE_SHARE * least / variance_inflation + LEAD);
    let farther = near.max(2.0 * LAW * (fit.cost() - least) / variance_inflation);
    // Far from its fit, a search that begins without the candidate may end beside the minimum. Those that the best leads by
    // no more than the error of a law begin once more, from where the best has ended.
    let is_led = |rough: &&Rough| (near..farther).contains(&behind(rough));
    in_order::<_, Result<(), CalibrateError>>(shortlist[from..].par_iter_mut().map(|entry| {
        let Some(own) = entry.rough.as_ref().filter(is_led).map(|own| own.cost) else { return Ok(()) };
        let found = rough_from(&entry.candidate, entry.candidate.null_value, &led, fit)?;
        found.into_iter().filter(|found| found.cost < own).for_each(|found| hear(entry, found));
        Ok(())
    }))?;
    in_order(shortlist[from..].par_iter_mut().zip(distances).map(|(entry, distance)| {
        let room = |rough: &Rough| if rough.is_near { near } else { farther };
        let is_worth = |rough: &&Rough| behind(rough) < room(rough) || distance < ONE;
        if let Some(rough) = entry.rough.as_ref().filter(is_worth) {
            let is_surpassed = is_explained && behind(rough) >= near;
            entry.refit = refit(rough, &entry.candidate, is_surpassed)?;
            if entry.refit.is_none() {
                entry.reject(not_run(&fit.problem));
            }
        }
        Ok(())
    }))
}

/// Takes the one that fits best for its unknowns, and those that fit as well, if that is more than noise would
/// give and held-out releases does not speak against it.
pub(super) fn choose(
    shortlist: &mut [Entry],
    fit: &Joint,
    scores: &Scores,
    before: Option<&HeldOut>,
    negligible: f64,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<RoundOutcome, CalibrateError> {
    let variance_inflation = least_inflation(shortlist, scores.variance_inflation)?;
    let each = penalty(fit, variance_inflation);
    let penalty = |refit: &Refit| refit.unknowns as f64 * each;
    let worth = |refit: &Refit| penalised(refit.cost, refit.unknowns, each, variance_inflation);
    // An unknown less is a reason to be asked first, and none to stand alone.
    let fair = |refit: &Refit| penalised(refit.cost, refit.unknowns, FAIR, variance_inflation);
    let of = |entry: &Entry| entry.refit.as_ref().map_or(f64::INFINITY, worth);
    shortlist.sort_by(|a, b| of(a).total_cmp(&of(b)));
    let Some(best) = shortlist.first().and_then(|entry| entry.refit.as_ref()) else {
        return Ok(RoundOutcome::Unexplained);
    };
    // The null may have a better minimum where the effect has led.
    let again = Joint::approach(&fit.problem, &best.known, &fit.found.view, false, 0.0)?;
    let null = again.map_or(f64::INFINITY, |again| again.cost()).min(fit.cost());
    let (least, fairest, leader) = (worth(best), fair(best), shortlist[0].candidate.name());
    let most = 2.0 * (null - best.cost) / variance_inflation;
    // What cannot be told apart by its trace, no lead tells apart: it would come from an error of a law.
    let distances: Vec<f64> = shortlist.iter().map(|entry| apart(&shortlist[0], entry, scores)).collect();
    let roughs = shortlist.iter().filter_map(|entry| Some(entry.rough.as_ref()?.cost));
    let roughest = roughs.fold(f64::INFINITY, f64::min);
    for (entry, distance) in shortlist.iter_mut().zip(distances) {
        let Some(refit) = &entry.refit else {
            let behind = entry.rough.as_ref().map(|rough| 2.0 * (rough.cost - roughest) / variance_inflation);
            entry.realised = behind.map(|behind| most - behind);
            let behind = behind.unwrap_or(f64::INFINITY);
            entry.falls_behind(behind, leader);
            continue;
        };
        let behind = worth(refit) - least;
        entry.realised = Some(2.0 * (null - refit.cost) / variance_inflation);
        let vanishes =
            |strength: f64| strength == entry.candidate.null_value && !entry.candidate.is_widened();
        if entry.strength().is_none_or(vanishes) {
            entry.reject("its strength is zero in the full fit");
        } else if behind.min(fair(refit) - fairest) >= LEAD && distance >= ONE {
            entry.falls_behind(behind, leader);
        }
    }
    let noise = scores.threshold.powi(2);
    if most < noise {
        let words = format!("in the full fit the best lowers χ² by {most:.1}, and noise by {noise:.1}");
        shortlist.iter_mut().for_each(|entry| entry.reject(words.clone()));
        return Ok(RoundOutcome::Nothing);
    }
    if most < negligible {
        shortlist.iter_mut().for_each(|entry| entry.reject(LITTLE));
        return Ok(RoundOutcome::Nothing);
    }
    // Of those that fit alike those come first whose parameters are where they are believed to be: two laws may be one with
    // other times.
    let alike = shortlist.iter().take_while(|entry| of(entry) - least < LEAD).count();
    shortlist[..alike].sort_by_key(Entry::is_beyond_belief);
    // Equals are validated in turn until one stands.
    for lead in 0..shortlist.len() {
        let entry = &mut shortlist[lead];
        let Some(refit) = entry.refit.clone().filter(|_| entry.rejected.is_none()) else { continue };
        let own = entry.realised.unwrap_or(0.0);
        let noise = entry.score.decrease_at(scores.threshold);
        if own < noise {
            entry.reject(format!("in the full fit it lowers χ² by {own:.1}, and noise by {noise:.1}"));
            continue;
        }
        let refit = refit.finished(&entry.candidate);
        tell("validation on held-out releases");
        let held_out = HeldOut::meet(&refit.fitted.problem, &refit.known)?;
        if let (Some(before), Some(after)) = (before, &held_out) {
            let (before, after) = (before.cost(fit)?, after.cost(&refit.fitted)?);
            let pair = before.zip(after);
            entry.held_out = pair.map(|(before, after)| 2.0 * (before - after) / variance_inflation);
        }
        if entry.held_out.is_some_and(|decrease| decrease < noise.min(LAW * own)) {
            entry.reject("held-out releases do not agree");
            continue;
        }
        let lead = &shortlist[lead];
        let equals = shortlist.iter().filter(|entry| entry.rejected.is_none());
        let others = equals.filter(|entry| entry.candidate.name() != lead.candidate.name());
        let member = |other: &Entry| {
            let effect = other.candidate.name().to_owned();
            let behind = of(other) - worth(&refit);
            // Of laws that turn round, traces tell little: fitted side by side, what is left between them is how far
            // they are apart.
            let distance = Some(apart(lead, other, scores)).filter(|trace| *trace < APART);
            let distance = distance.unwrap_or(behind.max(0.0).sqrt());
            (Member { effect, behind, distance }, other.candidate.clone())
        };
        let mut members: Vec<(Member, Candidate)> = others.map(member).collect();
        members.sort_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
        let (candidate, penalty) = (lead.candidate.clone(), penalty(&refit));
        return Ok(RoundOutcome::Effect(Box::new(Best {
            candidate,
            refit,
            held_out,
            variance_inflation,
            penalty,
            gain: most,
            members,
        })));
    }
    Ok(if most < CHANCE * noise { RoundOutcome::Nothing } else { RoundOutcome::Unexplained })
}

/// Variance of the noise over that of white noise as large as stated, as the best candidate leaves it: as in any F test,
/// the larger model says what noise is. What a linear step leaves of a large effect would pass for noise.
fn least_inflation(shortlist: &[Entry], linear: f64) -> Result<f64, CalibrateError> {
    let refits = shortlist.iter().filter_map(|entry| Some((entry.refit.as_ref()?, &entry.candidate)));
    let Some((best, candidate)) = refits.min_by(|(a, _), (b, _)| a.cost.total_cmp(&b.cost)) else {
        return Ok(linear);
    };
    let of = uncertainty(&best.fitted.objective, &best.fitted.found);
    let path = candidate.path();
    let own =
        best.known.iter().enumerate().filter(|(k, known)| known.unknown.name == path && of.is_determined[*k]);
    let own = own.map(|(k, _)| of.variance_inflation(k)).filter(|own| own.is_finite()).fold(0.0, f64::max);
    Ok(if own > 0.0 { own.clamp(1.0, linear.max(1.0)) } else { linear })
}

/// Distance of two traces at the strength of the first, standard deviations of the noise as it is.
fn apart(first: &Entry, second: &Entry, scores: &Scores) -> f64 {
    let strengths = match first.strength() {
        Some(strength) if first.score.columns.len() == 1 && !first.candidate.is_widened() => {
            vec![strength - first.candidate.null_value]
        }
        _ => first.score.estimates.clone(),
    };
    let distance = distance(&scores.gram, &first.score.columns, &second.score.columns, &strengths);
    distance / scores.variance_inflation.sqrt()
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::Run;

    use super::*;
    use crate::calibrate::{Nuisances, Problem, Trial};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::example::release;

    /// One that cannot be the answer says nothing of what the others are worth.
    #[test]
    fn a_candidate_of_the_wrong_sign_sets_no_bar() {
        let trial = Trial {
            release: release(Vec::new(), Vec::new()),
            model: muscle_at_15_psi(),
            run: Run::release(1.0, 10.0),
        };
        let problem =
            Problem { trials: vec![trial.into()], parameters: Vec::new(), nuisances: Nuisances::default() };
        let score = |(decrease, is_admissible)| Score {
            columns: vec![0],
            size: 5.0,
            decrease,
            is_admissible,
            ..Score::default()
        };
        let scores = [(800.0, false), (100.0, true), (20.0, true)].map(score);
        let pairs = candidates(&problem, &DiagnosisSettings::default()).into_iter().zip(scores);
        let mut entries: Vec<Entry> = pairs.map(|(candidate, score)| Entry::new(candidate, score)).collect();
        let (worth, others) = shortlist(&mut entries);
        let decreases = |entries: &[Entry]| entries.iter().map(|e| e.score.decrease).collect::<Vec<_>>();
        assert_eq!((decreases(worth), decreases(others)), (vec![100.0], vec![800.0, 20.0]));
    }
}
