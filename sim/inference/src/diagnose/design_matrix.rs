//! How the predictions of a fit would move with a candidate's strength, at the value where it is off.

use rayon::prelude::*;

use super::candidate::Candidate;
use crate::calibrate::joint::Joint;
use crate::calibrate::objective::Series;
use crate::calibrate::prediction::{Prediction, predict};
use crate::calibrate::problem::is_same_pressure;
use crate::calibrate::{Scope, Trial};

/// Derivatives of the predictions by one strength, in units of the noise, shape
/// `[release][track][sample]` of the samples that are fitted.
#[derive(Clone)]
pub(super) struct Column {
    /// Place of what it belongs to among all that is scored.
    pub of: usize,
    /// Its place among those of the same.
    pub part: usize,
    pub slopes: Vec<Vec<Vec<[f64; 2]>>>,
}

/// What a run's rounding leaves of a position, m, and the movement that is aimed at: in between,
/// rounding and curvature are both a small part of a difference.
const ROUNDING: f64 = 1e-11;
const WANTED: f64 = 1e-6;
const LARGEST: f64 = 3e-5;
/// Share of the believed range with which to begin.
const FIRST: f64 = 1e-4;

/// The columns of all candidates: one, or one a release or a pressure where each has its own value. A candidate
/// whose models cannot be run has none; one whose strength is fitted already has none for the first pressure.
/// `off` is what the fit predicts: an effect that is off leaves a run as it is.
pub(super) fn columns(
    fit: &Joint,
    off: &[Prediction],
    candidates: &[Candidate],
    tell: &(dyn Fn(&str) + Sync),
) -> Vec<Column> {
    let of_candidate = |(c, candidate): (usize, &Candidate)| {
        if let Some(place) = fit.objective.part.unknowns.iter().position(|own| own.name == candidate.path()) {
            return Some(of_pressures(fit, &fitted(fit, place), c).into_iter().skip(1).collect());
        }
        // The step that suits one release suits the others, or nearly.
        let (first, step) = movement(fit, candidate, 0, off.first()?, first_step(candidate))?;
        let of_other = |r: usize| Some(movement(fit, candidate, r, &off[r], step)?.0);
        let others: Option<Vec<_>> = (1..off.len()).into_par_iter().map(of_other).collect();
        let all = [vec![first], others?].concat();
        tell(candidate.name());
        Some(match candidate.scope {
            Scope::PerRelease => {
                (0..all.len()).map(|own| Column::only(c, own, &all, |release| release == own)).collect()
            }
            _ if candidate.is_widened() => of_pressures(fit, &all, c),
            Scope::Shared | Scope::PerPressure => vec![Column { of: c, part: 0, slopes: all }],
        })
    };
    candidates.par_iter().enumerate().filter_map(of_candidate).collect::<Vec<Vec<Column>>>().concat()
}

impl Column {
    /// What moves in some of the releases alone.
    fn only(of: usize, part: usize, all: &[Vec<Vec<[f64; 2]>>], is_own: impl Fn(usize) -> bool) -> Self {
        let still = |track: &Vec<[f64; 2]>| vec![[0.0; 2]; track.len()];
        let slopes = all.iter().enumerate().map(|(r, release)| match is_own(r) {
            true => release.clone(),
            false => release.iter().map(still).collect(),
        });
        Self { of, part, slopes: slopes.collect() }
    }
}

/// The columns of unknowns that are fitted, for each release beyond the first that has its value from the same: how the
/// predictions would move if these had another one than the first.
pub(super) fn of_releases(fit: &Joint, is_asked: impl Fn(&str) -> bool, of: usize) -> Vec<Column> {
    let part = &fit.objective.part;
    let mut columns = Vec::new();
    for place in (0..part.unknowns.len()).filter(|place| is_asked(&part.unknowns[*place].name)) {
        let all = fitted(fit, place);
        let has_it = |r: &usize| part.locals[*r].iter().any(|local| local.unknown == place);
        for own in (0..all.len()).filter(has_it).skip(1) {
            columns.push(Column::only(of, columns.len(), &all, |release| release == own));
        }
    }
    columns
}

/// Of what moves in all releases a column for each pressure.
fn of_pressures(fit: &Joint, all: &[Vec<Vec<[f64; 2]>>], of: usize) -> Vec<Column> {
    let pressure = |trial: &&Trial| trial.release.pressure;
    let members = &fit.objective.part.members;
    let mut pressures: Vec<f64> = members.iter().filter_map(pressure).collect();
    pressures.sort_by(f64::total_cmp);
    pressures.dedup_by(|a, b| is_same_pressure(*a, *b));
    let column = |(number, own): (usize, &f64)| {
        Column::only(of, number, all, |r| {
            pressure(&members[r]).is_some_and(|there| is_same_pressure(there, *own))
        })
    };
    pressures.iter().enumerate().map(column).collect()
}

/// How the predictions move with the value of an unknown that is fitted.
fn fitted(fit: &Joint, place: usize) -> Vec<Vec<Vec<[f64; 2]>>> {
    let part = &fit.objective.part;
    let per = part.unknowns[place].scaled.slope(fit.found.x[place]).recip();
    let of_release = |(r, block): (usize, &Vec<Series>)| {
        let local = part.locals[r].iter().position(|local| local.unknown == place);
        let of_sample =
            |slopes: &Vec<[f64; 2]>| local.map_or([0.0; 2], |k| slopes[k].map(|slope| per * slope));
        block.iter().map(|series| series.slopes.iter().map(of_sample).collect()).collect()
    };
    fit.found.at.carried.blocks.iter().enumerate().map(of_release).collect()
}

/// What a fit predicts of all its releases; none where it cannot be run.
pub(super) fn predictions(fit: &Joint) -> Option<Vec<Prediction>> {
    let members = &fit.objective.part.members;
    members.par_iter().enumerate().map(|(r, trial)| run(fit, trial, r, None)).collect()
}

/// A step with which to begin.
fn first_step(candidate: &Candidate) -> f64 {
    let room = room(candidate);
    FIRST * if room.is_finite() { room } else { candidate.strength.scale }
}

/// How far the strength may go from off, with its sign.
fn room(candidate: &Candidate) -> f64 {
    let (low, high) = candidate.believed();
    if high > candidate.null_value { high - candidate.null_value } else { low - candidate.null_value }
}

/// Derivatives of what is seen of a release by the strength, in units of the noise, and the step that they were
/// taken with; `step` is where to begin.
fn movement(
    fit: &Joint,
    candidate: &Candidate,
    r: usize,
    off: &Prediction,
    mut step: f64,
) -> Option<(Vec<Vec<[f64; 2]>>, f64)> {
    let member = fit.objective.part.members[r];
    let on = |step: f64| candidate.on(member, candidate.null_value + step).ok();
    let mut aside = run(fit, &on(step)?, r, None)?;
    // A memory that turns round within a step halves it: what it is compared with takes the same steps.
    let is_halved = aside.steps.len() != off.steps.len();
    let halved = if is_halved { Some(run(fit, member, r, Some(&aside.steps))?) } else { None };
    let (off, steps) = (halved.as_ref().unwrap_or(off), aside.steps.clone());
    let steps = is_halved.then_some(&steps[..]);
    // The second try has the size that the first one asks for.
    let moved = farthest(off, &aside);
    if !(WANTED / 30.0..LARGEST).contains(&moved) {
        step *= WANTED / moved.max(ROUNDING);
        step = step.signum() * step.abs().min(room(candidate).abs());
        aside = run(fit, &on(step)?, r, steps)?;
    }
    Some((slopes(fit, r, step, off, &aside), step))
}

/// Derivatives by the strength in units of the noise.
fn slopes(fit: &Joint, r: usize, step: f64, off: &Prediction, aside: &Prediction) -> Vec<Vec<[f64; 2]>> {
    in_noise(fit, r, |t, k| {
        let (aside, off) = (aside.position[t][k], off.position[t][k]);
        [0, 1].map(|axis| (aside[axis] - off[axis]) / step)
    })
}

/// Movements of the points of a release by track and place among its samples, m, in units of the noise
/// where they are fitted.
pub(super) fn in_noise(
    fit: &Joint,
    r: usize,
    moved: impl Fn(usize, usize) -> [f64; 2],
) -> Vec<Vec<[f64; 2]>> {
    let of_track = |(t, series): (usize, &Series)| {
        let per = fit.objective.measured[r].noise[t].recip();
        series.samples.iter().map(|k| moved(t, *k).map(|moved| per * moved)).collect()
    };
    fit.found.at.carried.blocks[r].iter().enumerate().map(of_track).collect()
}

/// The prediction of the `r`-th release by a trial, on the steps that are given, or else on those of the fit.
fn run(fit: &Joint, trial: &Trial, r: usize, steps: Option<&[f64]>) -> Option<Prediction> {
    let (part, view) = (&fit.objective.part, &fit.found.view);
    let steps = steps.or(view.steps.as_ref().map(|steps| &steps[r][..]));
    let measured = &fit.objective.measured[r];
    let (locals, count) = (&part.locals[r], view.counts[r]);
    predict(trial, measured, locals, &part.unknowns, &fit.found.x, count, view.fidelity, steps, None).ok()
}

/// The largest distance of two predictions, m.
fn farthest(a: &Prediction, b: &Prediction) -> f64 {
    let pairs = a.position.iter().flatten().zip(b.position.iter().flatten());
    pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
}
