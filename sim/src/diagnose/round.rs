//! One round: score, fit the shortlist, choose.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Settings;
use super::candidate::{Candidate, candidates};
use super::columns::columns;
use super::judge::judge;
use super::refit::{Refit, refit};
use super::score::{Score, Scores, scores};
use super::verdict::{Evidence, Member};
use crate::calibrate::joint::Joint;
use crate::calibrate::{CalibrateError, Problem};

/// What a round found.
pub(super) struct Round {
    /// Score that had to be exceeded.
    pub threshold: f64,
    /// Every candidate, the best by each effect.
    pub evidence: Vec<Evidence>,
    /// The best, fitted; none where nothing scored.
    pub best: Option<Best>,
}

/// The effect that explains most, and those that explain as much.
pub(super) struct Best {
    pub candidate: Candidate,
    pub refit: Refit,
    /// Decrease on what was locked away.
    pub held_out: Option<f64>,
    /// Others that do as well; empty where the best stands alone.
    pub members: Vec<Member>,
}

/// Candidates fitted in full, at most.
const SHORTLIST: usize = 8;
/// Share of the largest promised decrease from which on a candidate is fitted.
const WORTH_FITTING: f64 = 0.3;
/// χ² by which the best may lead without standing alone.
const LEAD: f64 = 12.0;

/// Looks for one effect beside those that the problem's models have.
pub(super) fn round(
    fit: &Joint,
    problem: &Problem,
    number: usize,
    settings: &Settings,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Round, CalibrateError> {
    let candidates = candidates(problem, &settings.excluded);
    let columns = columns(fit, &candidates, &|name| tell(&format!("round {number}: score of {name}")));
    let scores = scores(fit, &candidates, &columns, settings.false_alarm);
    let order = best_tries(&candidates, &scores);
    let mut evidence: Vec<Evidence> =
        order.iter().map(|c| evidence(number, &candidates[*c], &scores.each[*c])).collect();
    let mut round = Round { threshold: scores.threshold, evidence: Vec::new(), best: None };
    let is_found = |c: &usize| scores.each[*c].size > scores.threshold;
    if !order.iter().any(is_found) {
        for evidence in &mut evidence {
            evidence.rejected = Some("its score is within what noise gives".to_owned());
        }
        round.evidence = evidence;
        return Ok(round);
    }
    let most = order.iter().map(|c| scores.each[*c].decrease).fold(0.0, f64::max);
    let shortlist: Vec<usize> = (0..order.len())
        .filter(|k| {
            scores.each[order[*k]].is_admissible && scores.each[order[*k]].decrease >= WORTH_FITTING * most
        })
        .take(SHORTLIST)
        .collect();
    let known = fit.known();
    let fitted: Vec<Option<Refit>> = shortlist
        .par_iter()
        .map(|k| {
            let c = order[*k];
            tell(&format!("round {number}: fit of {}", candidates[c].name()));
            refit(problem, &candidates[c], scores.each[c].estimate, &known)
        })
        .collect::<Result<_, _>>()?;
    let null = fit.cost();
    let decrease = |refit: &Refit| 2.0 * (null - refit.cost) / scores.widening;
    for evidence in &mut evidence {
        evidence.rejected = Some("it promises less than others".to_owned());
    }
    for (k, refit) in shortlist.iter().zip(&fitted) {
        let Some(refit) = refit else {
            evidence[*k].rejected = Some("a model with it cannot be run".to_owned());
            continue;
        };
        evidence[*k].realised_decrease = Some(decrease(refit));
        if let Some(value) = refit.values.first() {
            evidence[*k].strength = value.value;
        }
    }
    let Some((lead, _)) = shortlist
        .iter()
        .zip(&fitted)
        .enumerate()
        .filter_map(|(place, (_, refit))| Some((place, decrease(refit.as_ref()?))))
        .max_by(|a, b| a.1.total_cmp(&b.1))
    else {
        round.evidence = evidence;
        return Ok(round);
    };
    let best = fitted[lead].clone().expect("it was fitted");
    let best_decrease = decrease(&best);
    let mut members = Vec::new();
    for (place, (k, refit)) in shortlist.iter().zip(&fitted).enumerate() {
        let Some(refit) = refit else { continue };
        let behind = best_decrease - decrease(refit);
        evidence[*k].rejected = Some(format!(
            "it explains {behind:.0} less of χ² than {}",
            candidates[order[shortlist[lead]]].name()
        ));
        if place == lead {
            evidence[*k].rejected = None;
        } else if refit.is_at_bound
            && behind > 0.0
            && refit.values.first().is_none_or(|value| value.value == 0.0)
        {
            evidence[*k].rejected = Some("fitted in full it vanishes".to_owned());
        } else if behind < LEAD {
            evidence[*k].rejected = None;
            let distance = distance(&scores, order[shortlist[lead]], order[*k]);
            members.push(Member { effect: candidates[order[*k]].name().to_owned(), behind, distance });
        }
    }
    let before = judge(problem, &known, tell)?;
    let after = judge(&best.problem, &best.known, tell)?;
    let held_out = match (before, after) {
        (Some(before), Some(after)) => Some(2.0 * (before.cost - after.cost) / scores.widening),
        _ => None,
    };
    evidence[shortlist[lead]].held_out_decrease = held_out;
    round.evidence = evidence;
    round.best =
        Some(Best { candidate: candidates[order[shortlist[lead]]].clone(), refit: best, held_out, members });
    Ok(round)
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

/// How far apart the traces of two candidates are at the strength of the first, when all else is fitted:
/// `|s⊥| θ √(1 − cos²)`, standard deviations.
fn distance(scores: &Scores, best: usize, other: usize) -> f64 {
    let pick =
        |a: &[usize], b: &[usize]| DMatrix::from_fn(a.len(), b.len(), |i, j| scores.gram[(a[i], b[j])]);
    let (a, b) = (&scores.each[best].columns, &scores.each[other].columns);
    let [Some(first), Some(second)] = [a.first(), b.first()] else { return 0.0 };
    let (own, cross, theirs) =
        (pick(a, a)[(0, 0)], scores.gram[(*first, *second)], scores.gram[(*second, *second)]);
    let cosine = cross / (own * theirs).sqrt().max(f64::MIN_POSITIVE);
    (scores.each[best].decrease.max(0.0) * (1.0 - cosine * cosine).max(0.0)).sqrt()
}
