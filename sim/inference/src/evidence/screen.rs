//! The screen: which candidates are worth a fit, and where it begins.
//!
//! A candidate is tried at a few strengths: friction, drag and memory are not linear in theirs, and a small one says little of a
//! large one. Each try is one run of the releases. From there the other unknowns respond by the slopes of the model before,
//! and the strength by the secant from zero. The evidence of that linearised model ranks the candidates.
//!
//! A model without an effect may bend what is stated far, a stiffness by 70 % where a mass is missing. The way back from there is
//! long, so tries also begin at the priors' means.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidates::Extension;
use super::data::Data;
use super::likelihood::{Compared, evidence, expand};
use super::search::Fit;
use super::unknown::Unknown;

/// Strengths that are tried, prior standard deviations: together they cover three decades.
const TRIED: [f64; 3] = [0.02, 0.14, 1.0];
/// Factor between these strengths.
const FACTOR: f64 = 7.0;
/// Longest step of another unknown, prior standard deviations.
const LONGEST: f64 = 2.0;
/// Strength from which a fit begins again, prior standard deviations.
const LITTLE: f64 = TRIED[0];
/// Factor of the share within which the linearised model finds its own.
const REACH: f64 = 20.0;

/// A candidate and where its fit begins.
pub struct Screened {
    pub extension: Extension,
    pub start: DVector<f64>,
    pub share: f64,
    /// Logarithm of the odds over the model before, by the linearised model.
    pub promise: f64,
}

/// Where tries begin: a place of the model before, with differences and slopes there.
pub struct Origin<'a> {
    pub z: &'a DVector<f64>,
    pub compared: &'a Compared,
}

/// Screens extensions of a fit, the most promising first; tries begin at the fit and at other origins.
pub fn screen(data: &Data, base: &Fit, others: &[Origin], extensions: Vec<Extension>) -> Vec<Screened> {
    let own = Origin { z: &base.z, compared: &base.compared };
    let screened = |extension: Extension| {
        let tries = if extension.strengths.is_empty() { vec![0.0] } else { tries(&extension) };
        let from = |origin: &Origin| {
            let found =
                tries.iter().filter_map(|strength| linearised(data, base, origin, &extension, *strength));
            found.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let found = std::iter::once(&own).chain(others).filter_map(from);
        let (promise, share, start) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Screened { promise: promise - base.evidence + extension.odds, share, start, extension })
    };
    let mut all: Vec<Screened> =
        extensions.into_par_iter().map(screened).collect::<Vec<_>>().into_iter().flatten().collect();
    all.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    all
}

/// Strengths at which an extension is tried, of both signs if it may have both.
fn tries(extension: &Extension) -> Vec<f64> {
    let is_half = extension.hypothesis.unknowns[extension.strengths[0]].is_half;
    let signs: &[f64] = if is_half { &[1.0] } else { &[1.0, -1.0] };
    signs.iter().flat_map(|sign| TRIED.map(|strength| sign * strength)).collect()
}

/// Evidence of the model that is linearised about one strength, its share, and its optimum.
fn linearised(
    data: &Data,
    base: &Fit,
    origin: &Origin,
    extension: &Extension,
    strength: f64,
) -> Option<(f64, f64, DVector<f64>)> {
    let unknowns = &extension.hypothesis.unknowns;
    let mut z = beside(base, origin.z, extension);
    extension.strengths.iter().for_each(|place| z[*place] = strength);
    let here = match extension.strengths.first() {
        Some(_) => data.compare(&extension.hypothesis, &z, &|_| false)?.differences,
        None => origin.compared.differences.clone(),
    };
    let compared = Compared { slopes: slopes(base, origin, extension, &here, strength), differences: here };
    let (value, share) = evidence(&compared, &data.weights, unknowns, &z, base.share, REACH);
    let expanded = expand(&compared, &data.weights, &z, share);
    let factors = expanded.hessian.cholesky()?;
    let optimum = &z - factors.solve(&expanded.gradient);
    let Some(place) = extension.strengths.first().copied() else {
        return Some((value, share, nearer(&z, &optimum, unknowns)));
    };
    // The secant is good for strengths about its own.
    let covariance = factors.inverse();
    let size = (optimum[place] * strength.signum()).clamp(strength.abs() / FACTOR, strength.abs() * FACTOR);
    let aside = size * strength.signum() - optimum[place];
    let variance = covariance[(place, place)];
    let mut start = nearer(&z, &(optimum + covariance.column(place) * (aside / variance)), unknowns);
    extension.strengths.iter().for_each(|place| start[*place] = size * strength.signum());
    Some((value - 0.5 * aside * aside / variance, share, start))
}

/// Slopes of the model before in the places of an extension, and the secant of its strengths in that of the first.
fn slopes(
    base: &Fit,
    origin: &Origin,
    extension: &Extension,
    here: &[DVector<f64>],
    strength: f64,
) -> Vec<DMatrix<f64>> {
    let unknowns = &extension.hypothesis.unknowns;
    let wider = |u: usize| {
        if base.hypothesis.unknowns[u].scaled == unknowns[u].scaled { 1.0 } else { extension.wider }
    };
    let first = extension.strengths.first();
    let before = origin.compared.slopes.iter().zip(&origin.compared.differences);
    let of_release = |((slopes, before), here): ((&DMatrix<f64>, &DVector<f64>), &DVector<f64>)| {
        DMatrix::from_fn(slopes.nrows(), unknowns.len(), |f, u| match u {
            u if u < slopes.ncols() => wider(u) * slopes[(f, u)],
            u if Some(&u) == first => (here[f] - before[f]) / strength,
            _ => 0.0,
        })
    };
    before.zip(here).map(of_release).collect()
}

/// A point on the way from one to another, no unknown farther than the longest step, none of one sign below zero.
fn nearer(from: &DVector<f64>, to: &DVector<f64>, unknowns: &[Unknown]) -> DVector<f64> {
    DVector::from_fn(from.len(), |u, _| {
        let step = (to[u] - from[u]).clamp(-LONGEST, LONGEST);
        if unknowns[u].is_half { (from[u] + step).max(0.0) } else { from[u] + step }
    })
}

/// A place of the model before, with a little of the strengths.
pub fn beside(base: &Fit, at: &DVector<f64>, extension: &Extension) -> DVector<f64> {
    let unknowns = &extension.hypothesis.unknowns;
    DVector::from_fn(unknowns.len(), |u, _| match base.hypothesis.unknowns.get(u) {
        Some(before) if before.scaled != unknowns[u].scaled => at[u] / extension.wider,
        Some(_) => at[u],
        None if extension.strengths.contains(&u) => LITTLE,
        None => unknowns[u].start,
    })
}
