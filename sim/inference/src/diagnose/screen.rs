//! The screen: which candidates are worth a fit, and where it begins.
//!
//! A candidate is tried at a few strengths: friction, drag and memory are not linear in theirs, and a small one says little of a
//! large one. The next tries are made where these lead to. Each is one run of the releases. From there the other unknowns
//! respond by the slopes of the model before, and the strength by the secant from zero. The evidence of that linearised model
//! ranks the candidates, by features and by all samples: features lead a model that is far off, and samples see what is small.
//!
//! A model without an effect may bend what is stated far, a stiffness by 70 % where a mass is missing. The way back from there is
//! long, so tries also begin at the priors' means.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Compared, Comparison, Data};
use super::extension::Extension;
use super::likelihood::{evidence, expand};
use super::samples::{Normal, Sampled, linearised};
use super::search::Point;
use super::unknown::Unknown;

/// Strengths that are tried first, prior standard deviations: a small one and one that is usual.
const TRIED: [f64; 2] = [0.1, 1.0];
/// By how much the next strength may differ: a secant is no guide over more than a decade.
const FACTOR: f64 = 10.0;
/// A strength within this factor of one that was tried needs no try of its own.
const SAME: f64 = 2.0;
/// Tries of a candidate from one origin.
const TRIES: usize = 4;
/// Longest step of another unknown, prior standard deviations.
const LONGEST: f64 = 2.0;
/// Strength from which a fit begins again, prior standard deviations.
const LITTLE: f64 = 0.02;
/// Factor of the share within which the linearised model finds its own.
const REACH: f64 = 20.0;

/// A candidate, and where its fits begin: by features, and by all samples.
pub struct Screened {
    pub extension: Extension,
    pub by_features: Option<Promise>,
    pub by_samples: Option<Promise>,
}

/// Where a fit begins, and what it promises.
#[derive(Clone)]
pub struct Promise {
    pub start: DVector<f64>,
    /// Share by features there.
    pub share: f64,
    /// Logarithm of the odds over the model before, by the linearised model.
    pub odds: f64,
    /// The try that it comes from.
    tried: Arc<Try>,
    /// Strength that the linearised model wants, within a factor of the one that was tried.
    strength: f64,
}

/// One strength of a candidate from one origin: how it compares, with the slopes of the origin in the places of the extension
/// and the secant of the strength, in each release in the place of the strength that acts on it.
struct Try {
    strength: f64,
    /// Place of the strength of each release; none of a freed statement.
    places: Vec<Option<usize>>,
    z: DVector<f64>,
    /// Features have the slopes in the places of the extension, all samples those of the origin: the others follow from how
    /// much wider each prior is, and from secants.
    here: Comparison,
    wider: Vec<f64>,
    secants: Vec<DVector<f64>>,
    normals: Vec<Normal>,
}

/// Runs of one model at several strengths, each from one of the origins.
#[derive(Default)]
struct Runs(Vec<(usize, f64, Comparison)>);

impl Runs {
    /// How the model compares at a strength from an origin; it is run where it was not yet.
    fn at(
        &mut self,
        origin: usize,
        strength: f64,
        run: impl FnOnce() -> Option<Comparison>,
    ) -> Option<Comparison> {
        if let Some((.., own)) = self.0.iter().find(|(from, at, _)| (*from, *at) == (origin, strength)) {
            return Some(own.clone());
        }
        let own = run()?;
        self.0.push((origin, strength, own.clone()));
        Some(own)
    }
}

/// Screens extensions of a fit, of which those of a group are one model at equal strengths; tries begin at the fit and at other
/// origins.
pub fn screen(data: &Data, base: &Sampled, others: &[Point], groups: Vec<Vec<Extension>>) -> Vec<Screened> {
    let screened = |group: Vec<Extension>| {
        let mut runs = Runs::default();
        let each = group.into_iter().map(|own| Screened::of(own, data, base, others, &mut runs));
        each.collect::<Vec<_>>()
    };
    groups.into_par_iter().flat_map_iter(screened).collect()
}

impl Screened {
    fn of(extension: Extension, data: &Data, base: &Sampled, others: &[Point], runs: &mut Runs) -> Self {
        let mut best = Self { extension, by_features: None, by_samples: None };
        for origin in std::iter::once(&base.fit.at).chain(others).enumerate() {
            if best.extension.strengths.is_empty() {
                best.improve(data, base, origin, 0.0, runs);
                continue;
            }
            // The next are where features or samples lead to, unless one was there.
            let (mut made, mut wanted) = (Vec::<f64>::new(), VecDeque::from(TRIED));
            while let Some(next) = wanted.pop_front().filter(|_| made.len() < TRIES) {
                if !made.iter().any(|own| (1.0 / SAME..SAME).contains(&(next / own))) {
                    made.push(next);
                    wanted.extend(best.improve(data, base, origin, next, runs).into_iter().flatten());
                }
            }
        }
        best
    }

    /// Tries a strength, and keeps what is better; the strengths that features and samples want then.
    fn improve(
        &mut self,
        data: &Data,
        base: &Sampled,
        origin: (usize, &Point),
        strength: f64,
        runs: &mut Runs,
    ) -> [Option<f64>; 2] {
        let Some(tried) = Try::of(data, base, origin, &self.extension, strength, runs) else {
            return [(strength >= TRIED[0]).then_some(strength / FACTOR), None];
        };
        let (tried, extension) = (Arc::new(tried), &self.extension);
        let promises = [tried.by_features(data, base, extension), tried.by_samples(data, base, extension)];
        let wanted = promises.each_ref().map(|own| own.as_ref().map(|own| own.strength));
        for (best, own) in [&mut self.by_features, &mut self.by_samples].into_iter().zip(promises) {
            if own.as_ref().is_some_and(|own| best.as_ref().is_none_or(|best| own.odds > best.odds)) {
                *best = own;
            }
        }
        wanted
    }
}

impl Promise {
    /// How it compares at the try, with slopes in the places of the extension.
    pub fn slopes(&self) -> Comparison {
        let Try { here, wider, secants, normals, places, z, .. } = &*self.tried;
        let both = here.samples.slopes.iter().zip(secants).zip(places);
        let slopes: Vec<_> =
            both.map(|((slopes, secant), place)| extended(slopes, wider, *place, secant, z.len())).collect();
        Comparison {
            features: here.features.clone(),
            samples: Compared { differences: here.samples.differences.clone(), slopes: slopes.into() },
            squares: normals.iter().map(|own| own.jj.clone()).collect::<Vec<_>>().into(),
        }
    }
}

impl Try {
    fn of(
        data: &Data,
        base: &Sampled,
        (number, origin): (usize, &Point),
        extension: &Extension,
        strength: f64,
        runs: &mut Runs,
    ) -> Option<Self> {
        let mut z = beside(base, &origin.z, extension);
        extension.strengths.iter().for_each(|place| z[*place] = strength);
        let has_strength = !extension.strengths.is_empty();
        let acts_on =
            |u: &usize, r: usize| extension.hypothesis.unknowns[*u].acts.iter().any(|(own, _)| *own == r);
        let place = |r: usize| extension.strengths.iter().copied().find(|u| acts_on(u, r));
        let places: Vec<_> = (0..data.plans.len()).map(place).collect();
        let mut here = if has_strength {
            let run = || data.compare_with(&extension.hypothesis, &z, &origin.seen);
            runs.at(number, strength, run)?
        } else {
            Comparison::clone(&origin.seen)
        };
        let wider = wider(base, extension);
        let secants = |before: &Compared, here: &Compared| -> Vec<DVector<f64>> {
            let both = here.differences.iter().zip(&before.differences);
            both.map(|(here, before)| if has_strength { (here - before) / strength } else { here * 0.0 })
                .collect()
        };
        let slopes = here.features.slopes.iter().zip(secants(&origin.seen.features, &here.features));
        let slopes: Vec<_> = slopes
            .zip(&places)
            .map(|((slopes, secant), place)| extended(slopes, &wider, *place, &secant, z.len()))
            .collect();
        here.features.slopes = slopes.into();
        let secants = secants(&origin.seen.samples, &here.samples);
        let normal = |r: usize| normal(&here, r, &wider, places[r], &secants[r], z.len());
        let normals = (0..secants.len()).map(normal).collect();
        Some(Self { strength, places, z, here, wider, secants, normals })
    }

    fn by_features(self: &Arc<Self>, data: &Data, base: &Sampled, extension: &Extension) -> Option<Promise> {
        let (before, unknowns) = (&base.fit, &extension.hypothesis.unknowns);
        let (value, share) =
            evidence(&self.here.features, &data.weights, unknowns, &self.z, before.share, REACH);
        let expanded = expand(&self.here.features, &data.weights, &self.z, share);
        let factors = expanded.hessian.cholesky()?;
        let optimum = &self.z - factors.solve(&expanded.gradient);
        self.promise(value - before.evidence, share, optimum, &factors.inverse(), extension)
    }

    fn by_samples(self: &Arc<Self>, data: &Data, base: &Sampled, extension: &Extension) -> Option<Promise> {
        let (optimum, covariance, value) =
            linearised(&data.plans, &extension.hypothesis.unknowns, &self.normals, &self.z)?;
        self.promise(value - base.evidence, base.fit.share, optimum, &covariance, extension)
    }

    /// The secant is good for strengths about its own: strengths stay near, and the others follow them.
    fn promise(
        self: &Arc<Self>,
        odds: f64,
        share: f64,
        optimum: DVector<f64>,
        covariance: &DMatrix<f64>,
        extension: &Extension,
    ) -> Option<Promise> {
        let (odds, unknowns) = (odds + extension.odds, &extension.hypothesis.unknowns);
        let (tried, strengths) = (self.clone(), &extension.strengths);
        if strengths.is_empty() {
            let start = nearer(&self.z, &optimum, unknowns);
            return Some(Promise { start, share, odds, tried, strength: 0.0 });
        }
        let size = self.strength.abs();
        let near = |place: usize| {
            let sign = if unknowns[place].is_half || optimum[place] > 0.0 { 1.0 } else { -1.0 };
            sign * (optimum[place] * sign).clamp(size / FACTOR, size * FACTOR)
        };
        let sizes: Vec<f64> = strengths.iter().map(|place| near(*place)).collect();
        let aside = DVector::from_fn(sizes.len(), |k, _| sizes[k] - optimum[strengths[k]]);
        let columns = covariance.select_columns(strengths);
        let pull = columns.select_rows(strengths).cholesky()?.solve(&aside);
        let there = optimum + columns * &pull;
        let mut start = nearer(&self.z, &there, unknowns);
        strengths.iter().zip(&sizes).for_each(|(place, size)| start[*place] = *size);
        let largest = sizes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some(Promise { start, share, odds: odds - 0.5 * aside.dot(&pull), tried, strength: largest })
    }
}

/// Slopes of the model before in the places of an extension, with a secant in that of a strength.
fn extended(
    slopes: &DMatrix<f64>,
    wider: &[f64],
    place: Option<usize>,
    secant: &DVector<f64>,
    count: usize,
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(slopes.nrows(), count);
    for (u, wider) in wider.iter().enumerate() {
        all.column_mut(u).axpy(*wider, &slopes.column(u), 0.0);
    }
    if let Some(place) = place {
        all.column_mut(place).copy_from(secant);
    }
    all
}

/// By how much the prior of each unknown of the model before is wider in an extension.
fn wider(base: &Sampled, extension: &Extension) -> Vec<f64> {
    let both = base.fit.hypothesis.unknowns.iter().zip(&extension.hypothesis.unknowns);
    both.map(|(before, own)| if before.scaled == own.scaled { 1.0 } else { extension.wider }).collect()
}

/// Normal equations of all samples of a release in the places of an extension, with the secant of its strength.
fn normal(
    here: &Comparison,
    r: usize,
    wider: &[f64],
    place: Option<usize>,
    secant: &DVector<f64>,
    count: usize,
) -> Normal {
    let (slopes, difference) = (&here.samples.slopes[r], &here.samples.differences[r]);
    let wider = DVector::from_column_slice(wider);
    let n = wider.len();
    let (mut jj, mut jd) = (DMatrix::zeros(count, count), DVector::zeros(count));
    let square = here.squares[r].component_mul(&(&wider * wider.transpose()));
    jj.view_mut((0, 0), (n, n)).copy_from(&square);
    jd.rows_mut(0, n).copy_from(&slopes.tr_mul(difference).component_mul(&wider));
    if let Some(place) = place {
        let aside = slopes.tr_mul(secant).component_mul(&wider);
        jj.view_mut((0, place), (n, 1)).copy_from(&aside);
        jj.view_mut((place, 0), (1, n)).copy_from(&aside.transpose());
        jj[(place, place)] = secant.norm_squared();
        jd[place] = secant.dot(difference);
    }
    Normal { jj, jd, dd: difference.norm_squared() }
}

/// A point on the way from one to another, no unknown farther than the longest step, none of one sign below zero.
fn nearer(from: &DVector<f64>, to: &DVector<f64>, unknowns: &[Unknown]) -> DVector<f64> {
    DVector::from_fn(from.len(), |u, _| {
        let step = (to[u] - from[u]).clamp(-LONGEST, LONGEST);
        if unknowns[u].is_half { (from[u] + step).max(0.0) } else { from[u] + step }
    })
}

/// A place of the model before, with a little of the strengths.
pub fn beside(base: &Sampled, at: &DVector<f64>, extension: &Extension) -> DVector<f64> {
    let (unknowns, before) = (&extension.hypothesis.unknowns, wider(base, extension));
    DVector::from_fn(unknowns.len(), |u, _| match before.get(u) {
        Some(wider) => at[u] / wider,
        None if extension.strengths.contains(&u) => LITTLE,
        None => unknowns[u].start,
    })
}
