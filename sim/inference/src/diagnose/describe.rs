//! What no effect explains, described: as the moment that it would take, a sum of few simple terms.
//!
//! The terms of `latent_moment` are scored as candidates are, and added one by one, of those that score most
//! the one that fits best, while each takes away a good part of what is there. What comes out says how the
//! missing force looks, and not what makes it.

use models::effects::{Parameter, by_name};
use rayon::prelude::*;

use super::candidate::Candidate;
use super::curve::Agreement;
use super::design_matrix::predictions;
use super::mesh_check::LAW;
use super::refit::{Rough, rough};
use super::score::{Score, scores_of};
use super::validation::agreement;
use super::verdict::{Added, Description};
use crate::calibrate::joint::Joint;
use crate::calibrate::refine::RESOLUTION_FITTED;
use crate::calibrate::{CalibrateError, Problem, Scope};
use crate::ordered::in_order;

const MOMENT: &str = "latent_moment";
/// Terms at most, and those that are fitted before the best of them is taken, which promise most: what is large scores as
/// similar terms do.
const MOST_TERMS: usize = 3;

/// Describes what is left at a fit; nothing where no term scores.
pub(super) fn describe(
    fit: &Joint,
    false_alarm: f64,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Option<Description>, CalibrateError> {
    let whole = Left { share: 1.0, gap: beyond(&agreement(fit)), cost: fit.cost() };
    with_another(fit, &mut Vec::new(), &whole, false_alarm, tell)
}

/// What there was to describe before any term, and the share of it that is left.
struct Left {
    share: f64,
    gap: f64,
    cost: f64,
}

/// Adds terms to those that a fit has, while they are worth it.
fn with_another(
    fit: &Joint,
    terms: &mut Vec<&'static str>,
    left: &Left,
    false_alarm: f64,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Option<Description>, CalibrateError> {
    let Some(off) = predictions(fit).filter(|_| terms.len() < MOST_TERMS) else { return Ok(None) };
    let candidates = others(terms, &fit.problem);
    let scores = scores_of(&candidates, fit, &off, false_alarm, &|_| ());
    let loud = |(_, score): &(&Candidate, &Score)| score.size > scores.threshold;
    let mut each: Vec<(&Candidate, &Score)> = candidates.iter().zip(&scores.each).filter(loud).collect();
    each.sort_by(|a, b| b.1.decrease.total_cmp(&a.1.decrease));
    each.truncate(MOST_TERMS);
    tell(&format!("description: a moment of {} terms", terms.len() + 1));
    let roughly = each.par_iter().map(|(candidate, score)| rough(candidate, score.estimate, fit));
    let tried = in_order::<_, Result<Vec<Option<Rough>>, CalibrateError>>(roughly)?;
    let tried = each.iter().zip(tried).filter_map(|((candidate, _), rough)| Some((*candidate, rough?)));
    let best = tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let Some((candidate, rough)) = best else { return Ok(None) };
    let Some(fit) = Joint::follow(&rough.problem, &rough.known, RESOLUTION_FITTED)? else { return Ok(None) };
    let share = beyond(&agreement(&fit)) / left.gap;
    if left.share - share < LAW {
        return Ok(None);
    }
    let mut moment = Added::of(&fit, candidate);
    moment.parameters.retain(|value| value.interval_95.is_some());
    let decrease = 2.0 * (left.cost - fit.cost()) / scores.variance_inflation;
    terms.push(candidate.strength.name);
    let left = Left { share, ..*left };
    let more = with_another(&fit, terms, &left, false_alarm, tell)?;
    Ok(more.or(Some(Description { moment, share: 1.0 - share, decrease })))
}

/// The terms that are not there yet, each with the others at 0.
fn others(terms: &[&str], problem: &Problem) -> Vec<Candidate> {
    let Some(rod) = problem.trials.first().map(|trial| trial.model.rod()) else { return Vec::new() };
    let effect = by_name(MOMENT).expect("the catalogue has it");
    let all = || effect.about().parameters.iter();
    let is_new = |term: &&'static Parameter| !terms.contains(&term.name);
    let of = |strength: &'static Parameter| {
        let rest = all().filter(is_new).filter(|term| term.name != strength.name);
        let tried = rest.map(|term| (term, 0.0)).collect();
        Candidate { effect, strength, null_value: 0.0, tried, scope: Scope::Shared, rod, stated: Vec::new() }
    };
    all().filter(is_new).map(of).collect()
}

/// Square of the gap beyond the noise, in units of the noise, over all releases.
fn beyond(agreement: &Agreement) -> f64 {
    agreement.gaps.iter().map(|(_, _, over, _)| over * over - 1.0).sum::<f64>().max(f64::MIN_POSITIVE)
}
