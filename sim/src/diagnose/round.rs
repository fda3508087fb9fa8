//! One round: score, fit the shortlist, choose.

use rayon::prelude::*;

use super::Settings;
use super::candidate::{Candidate, candidates};
use super::columns::{columns, predictions};
use super::judge::{Judgement, judge};
use super::localise::{Shape, shapes};
use super::refit::{Refit, Rough, refit, rough};
use super::score::{Score, Scores, Subject, distance, scores};
use super::verdict::{Evidence, Member};
use crate::calibrate::joint::Joint;
use crate::calibrate::{CalibrateError, Problem};

/// What a round found.
pub(super) struct Round {
    /// Score that had to be exceeded.
    pub threshold: f64,
    /// Every candidate, the best by each effect.
    pub evidence: Vec<Evidence>,
    /// What the residual looks like, whatever its cause.
    pub shapes: Vec<Shape>,
    /// Whether a candidate scores.
    pub is_heard: bool,
    /// The best, fitted; none where nothing scored.
    pub best: Option<Best>,
}

/// The effect that explains most, and those that explain as much.
pub(super) struct Best {
    pub candidate: Candidate,
    pub refit: Refit,
    /// How it meets what was locked away.
    pub judgement: Option<Judgement>,
    /// Variance of the noise over that of white noise as large as stated.
    pub widening: f64,
    /// Others that do as well, the nearest first; empty where the best stands alone.
    pub members: Vec<(Member, Candidate)>,
}

/// Candidates fitted in full, at most.
const SHORTLIST: usize = 8;
/// Share of the largest promised decrease from which on a candidate is fitted.
const WORTH_FITTING: f64 = 0.3;
/// Share of the false-alarm level that is left to shapes: they hear small errors of the setup, too, for
/// which the baseline has no unknown.
const RARER: f64 = 0.01;
/// Share of the best candidate's gain within which another, fitted roughly, is fitted in full.
const NEAR: f64 = 0.1;
/// χ² by which the best may lead without standing alone.
const LEAD: f64 = 12.0;
/// χ² by which an effect may worsen what was locked away before it is disbelieved.
const WORSE: f64 = 9.0;

/// Looks for one effect beside those that the problem's models have. `before` is how they meet what was
/// locked away.
pub(super) fn round(
    fit: &Joint,
    problem: &Problem,
    before: Option<&Judgement>,
    number: usize,
    settings: &Settings,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Round, CalibrateError> {
    let Some(off) = predictions(fit) else {
        let nothing = Round {
            threshold: f64::INFINITY,
            evidence: Vec::new(),
            shapes: Vec::new(),
            is_heard: false,
            best: None,
        };
        return Ok(nothing);
    };
    let shapes = shapes(fit, &off, number, RARER * settings.false_alarm);
    let candidates = candidates(problem, &settings.excluded);
    let columns = columns(fit, &off, &candidates, &|name| tell(&format!("round {number}: score of {name}")));
    let subjects: Vec<Subject> = candidates.iter().map(Candidate::subject).collect();
    let scores = scores(fit, &subjects, &columns, settings.false_alarm);
    let order = best_tries(&candidates, &scores);
    let mut evidence: Vec<Evidence> =
        order.iter().map(|c| evidence(number, &candidates[*c], &scores.each[*c])).collect();
    let is_heard = order.iter().any(|c| scores.each[*c].size > scores.threshold);
    let of = |evidence, best| Ok(Round { threshold: scores.threshold, evidence, shapes, is_heard, best });
    let reject = |evidence: &mut Evidence, why: &str| {
        if evidence.rejected.is_none() {
            evidence.rejected = Some(why.to_owned());
        }
    };
    if !is_heard {
        evidence.iter_mut().for_each(|evidence| reject(evidence, "its score is within what noise gives"));
        return of(evidence, None);
    }
    let most = order.iter().map(|c| scores.each[*c].decrease).fold(0.0, f64::max);
    let is_worth = |k: &usize| {
        let score = &scores.each[order[*k]];
        score.is_admissible && score.decrease >= WORTH_FITTING * most
    };
    let shortlist: Vec<usize> = (0..order.len()).filter(is_worth).take(SHORTLIST).collect();
    let roughs: Vec<Option<Rough>> = shortlist
        .par_iter()
        .map(|k| {
            let c = order[*k];
            tell(&format!("round {number}: fit of {}", candidates[c].name()));
            rough(problem, &candidates[c], scores.each[c].estimate, fit)
        })
        .collect::<Result<_, _>>()?;
    let least = roughs.iter().flatten().map(|rough| rough.cost).fold(f64::INFINITY, f64::min);
    let room = (NEAR * (fit.cost() - least)).max(5.0 * LEAD * scores.widening);
    let fitted: Vec<Option<Refit>> = shortlist
        .par_iter()
        .zip(&roughs)
        .map(|(k, rough)| match rough {
            Some(rough) if rough.cost < least + room => refit(rough, &candidates[order[*k]]),
            _ => Ok(None),
        })
        .collect::<Result<_, _>>()?;
    let cheapest = (0..shortlist.len())
        .filter_map(|place| Some((place, fitted[place].as_ref()?.cost)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((lead, _)) = cheapest else {
        for k in shortlist {
            evidence[k].rejected = Some("a model with it cannot be run".to_owned());
        }
        evidence.iter_mut().for_each(|evidence| reject(evidence, "it promises less than others"));
        return of(evidence, None);
    };
    let best = fitted[lead].clone().expect("it was fitted");
    // The null may have a better minimum where the effect has led.
    let again = Joint::follow(problem, &best.known, &|_| ())?;
    let null = again.map_or(f64::INFINITY, |again| again.cost()).min(fit.cost());
    let decrease = |refit: &Refit| 2.0 * (null - refit.cost) / scores.widening;
    let best_decrease = decrease(&best);
    let chosen = order[shortlist[lead]];
    let mut members = Vec::new();
    for (place, (k, refit)) in shortlist.iter().zip(&fitted).enumerate() {
        let (candidate, evidence) = (&candidates[order[*k]], &mut evidence[*k]);
        let Some(refit) = refit else {
            let why = match &roughs[place] {
                None => "a model with it cannot be run".to_owned(),
                Some(rough) => {
                    let behind = 2.0 * (rough.cost - least) / scores.widening;
                    format!("it explains {behind:.0} less of χ² than {}", candidates[chosen].name())
                }
            };
            evidence.rejected = Some(why);
            continue;
        };
        evidence.realised_decrease = Some(decrease(refit));
        if let Some(value) = refit.values.first() {
            evidence.strength = value.value;
        }
        if place == lead {
            continue;
        }
        let behind = best_decrease - decrease(refit);
        if refit.values.first().is_none_or(|value| value.value == candidate.off) {
            evidence.rejected = Some("fitted in full it vanishes".to_owned());
        } else if behind >= LEAD {
            evidence.rejected =
                Some(format!("it explains {behind:.0} less of χ² than {}", candidates[chosen].name()));
        } else {
            let (own, other) = (&scores.each[chosen], &scores.each[order[*k]]);
            let strengths = match best.values.first() {
                Some(value) if own.columns.len() == 1 => vec![value.value - candidates[chosen].off],
                _ => own.estimates.clone(),
            };
            let distance = distance(&scores.gram, &own.columns, &other.columns, &strengths);
            let distance = distance / scores.widening.sqrt();
            let effect = candidate.name().to_owned();
            members.push((Member { effect, behind, distance }, candidate.clone()));
        }
    }
    members.sort_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
    for (_, evidence) in evidence.iter_mut().enumerate().filter(|(k, _)| !shortlist.contains(k)) {
        reject(evidence, "it promises less than others");
    }
    let lead = &mut evidence[shortlist[lead]];
    let noise = scores.threshold.powi(2);
    if best_decrease < noise {
        lead.rejected =
            Some(format!("fitted in full it explains {best_decrease:.1} of χ², and noise {noise:.1}"));
        let mut quiet = of(evidence, None)?;
        quiet.is_heard = false;
        return Ok(quiet);
    }
    let judgement = judge(&best.problem, &best.known, tell)?;
    let held_out = match (before, &judgement) {
        (Some(before), Some(after)) => Some(2.0 * (before.cost - after.cost) / scores.widening),
        _ => None,
    };
    lead.held_out_decrease = held_out;
    if held_out.is_some_and(|decrease| decrease < -WORSE) {
        lead.rejected = Some("what was locked away is worse off with it".to_owned());
        return of(evidence, None);
    }
    let candidate = candidates[chosen].clone();
    let widening = scores.widening;
    of(evidence, Some(Best { candidate, refit: best, judgement, widening, members }))
}

/// Of each effect the try that promises most, largest score first.
fn best_tries(candidates: &[Candidate], scores: &Scores) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    for c in 0..candidates.len() {
        match order.iter_mut().find(|other| candidates[**other].name() == candidates[c].name()) {
            Some(other) if scores.each[c].size > scores.each[*other].size => *other = c,
            Some(_) => {}
            None => order.push(c),
        }
    }
    order.sort_by(|a, b| scores.each[*b].size.total_cmp(&scores.each[*a].size));
    order
}

fn evidence(round: usize, candidate: &Candidate, score: &Score) -> Evidence {
    Evidence {
        round,
        effect: candidate.name().to_owned(),
        tried: candidate.tried.iter().map(|(parameter, value)| (parameter.name.to_owned(), *value)).collect(),
        score: score.size,
        predicted_decrease: score.decrease,
        realised_decrease: None,
        strength: score.estimate,
        held_out_decrease: None,
        rejected: (!score.is_admissible).then(|| "it would need the wrong sign".to_owned()),
    }
}
