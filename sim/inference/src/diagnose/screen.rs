//! The screen: which candidates are worth a fit, and where it begins.
//!
//! How the recordings begin to move with the strength of each effect comes from one run of each release: a model that has all
//! effects, off, and slopes by their strengths. From there the other unknowns respond by the slopes of the model before. The
//! evidence of that linearised model ranks the candidates, by features and by all samples: features lead a model that is far off,
//! and samples see what is small.
//!
//! Where the model before leaves more than noise, strengths are large, and friction, drag and memory are not linear in theirs.
//! Then the strengths to which this leads are tried, each by one run of the releases, from which on the secant from zero takes the
//! place of the slope; and so on.
//!
//! A model without an effect may bend what is stated far, a stiffness by 70 % where a mass is missing. The way back from there is
//! long, so tries also begin at the priors' means.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Compared, Comparison, Data, Squares};
use super::equations::{Equations, Normal, Slow, parts};
use super::extension::{Extension, Group, all_off};
use super::hypothesis::Hypothesis;
use super::likelihood::{evidence, expand};
use super::samples::{Sampled, linearised};
use super::search::Point;
use super::unknown::Unknown;
use crate::features::Plan;

/// Strengths that are tried, prior standard deviations: one that is usual, and a small one where slopes at zero cannot be had.
const USUAL: f64 = 1.0;
const SMALL: f64 = 0.1;
/// By how much the next strength may differ: a secant is no guide over more than a decade.
const FACTOR: f64 = 10.0;
/// A strength within this factor of one that was tried needs no try of its own.
const SAME: f64 = 2.0;
/// Tries of a candidate from one origin.
const TRIES: usize = 4;
/// Longest step of an unknown, prior standard deviations.
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
    /// Zero: the secant is the slope there.
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

/// How features and samples of each release move with a strength.
#[derive(Clone)]
struct Secants {
    features: Vec<DVector<f64>>,
    samples: Vec<DVector<f64>>,
}

/// Where tries begin.
struct Origin<'a> {
    at: &'a Point,
    /// Slopes at zero of the strength of each group; none of a statement, and where they cannot be had.
    slopes: Vec<Option<Secants>>,
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

/// Screens extensions of a fit; tries begin at the fit and at other origins.
pub fn screen(data: &Data, base: &Sampled, others: &[Point], groups: Vec<Group>) -> Vec<Screened> {
    let origins: Vec<Origin> = std::iter::once(&base.fit.at)
        .chain(others)
        .map(|at| Origin::of(data, &base.fit.hypothesis, at, &groups))
        .collect();
    let screened = |(g, group): (usize, Group)| {
        let mut runs = Runs::default();
        let each =
            group.extensions.into_iter().map(|own| Screened::of(own, data, base, &origins, g, &mut runs));
        each.collect::<Vec<_>>()
    };
    groups.into_par_iter().enumerate().flat_map_iter(screened).collect()
}

impl<'a> Origin<'a> {
    /// Two tries of one effect cannot be in one model: there are as many models as an effect has tries at most. Frictions are in none:
    /// what their memory does moves nothing while they are off, so no step of the integrator is short enough for it.
    fn of(data: &Data, before: &Hypothesis, at: &'a Point, groups: &[Group]) -> Self {
        let mut models: Vec<Vec<usize>> = Vec::new();
        for (g, group) in groups.iter().enumerate() {
            let candidate = group.candidate.as_ref().filter(|own| !own.strength.is_friction);
            let Some(candidate) = candidate else { continue };
            let has = |model: &[usize]| {
                let names = model.iter().filter_map(|own| groups[*own].candidate.as_ref());
                names.map(|own| own.name()).any(|name| name == candidate.name())
            };
            match models.iter_mut().find(|model| !has(model)) {
                Some(model) => model.push(g),
                None => models.push(vec![g]),
            }
        }
        let (first, mut slopes) = (at.z.len(), vec![None; groups.len()]);
        let of = |model: &Vec<usize>| {
            let own: Vec<&Group> = model.iter().map(|g| &groups[*g]).collect();
            let all = all_off(before, &own).ok()?;
            let z = at.z.clone().resize_vertically(all.unknowns.len(), 0.0);
            data.compare_by(&all, &z, &(first..z.len()))
        };
        for (model, seen) in models.iter().zip(models.par_iter().map(of).collect::<Vec<_>>()) {
            let Some(seen) = seen else { continue };
            for (k, g) in model.iter().enumerate() {
                let of =
                    |by: &Compared| by.slopes.iter().map(|own| own.by(first + k)).collect::<Option<Vec<_>>>();
                let both = of(&seen.features).zip(of(&seen.samples));
                slopes[*g] = both.map(|(features, samples)| Secants { features, samples });
            }
        }
        Self { at, slopes }
    }
}

impl Screened {
    fn of(
        extension: Extension,
        data: &Data,
        base: &Sampled,
        origins: &[Origin],
        group: usize,
        runs: &mut Runs,
    ) -> Self {
        let mut best = Self { extension, by_features: None, by_samples: None };
        let has_strength = !best.extension.strengths.is_empty();
        let is_noise = base.may_be_noise(data.stated_repeats());
        for (number, origin) in origins.iter().enumerate() {
            let (mut made, mut wanted) = (Vec::<f64>::new(), VecDeque::new());
            match &origin.slopes[group] {
                Some(slopes) => {
                    let seen = Comparison::clone(&origin.at.seen);
                    let next = best.improve(data, base, origin.at, 0.0, seen, slopes.clone());
                    wanted.extend(next.into_iter().flatten().chain([USUAL]).filter(|_| !is_noise));
                }
                None if has_strength => wanted.extend([SMALL, USUAL]),
                None => {
                    let seen = Comparison::clone(&origin.at.seen);
                    let none = Secants::between(&seen, &seen, 1.0);
                    best.improve(data, base, origin.at, 0.0, seen, none);
                }
            }
            // The next are where features or samples lead to, unless one was there.
            while let Some(next) = wanted.pop_front().filter(|_| made.len() < TRIES) {
                if made.iter().any(|own| (1.0 / SAME..SAME).contains(&(next / own))) {
                    continue;
                }
                made.push(next);
                let own = &best.extension;
                let run = || {
                    data.compare_with(
                        &own.hypothesis,
                        &at_strength(base, origin.at, own, next),
                        &origin.at.seen,
                    )
                };
                match runs.at(number, next, run) {
                    Some(here) => {
                        let secants = Secants::between(&origin.at.seen, &here, next);
                        wanted.extend(
                            best.improve(data, base, origin.at, next, here, secants).into_iter().flatten(),
                        );
                    }
                    None if next >= SMALL => wanted.push_back(next / FACTOR),
                    None => {}
                }
            }
        }
        best
    }

    /// Tries a strength, and keeps what is better; the strengths that features and samples want then, if that promises anything: a power
    /// of two, for extensions of a group share their runs.
    fn improve(
        &mut self,
        data: &Data,
        base: &Sampled,
        origin: &Point,
        strength: f64,
        here: Comparison,
        secants: Secants,
    ) -> [Option<f64>; 2] {
        let tried = Try::of(data, base, origin, &self.extension, strength, here, secants);
        let (tried, extension) = (Arc::new(tried), &self.extension);
        let promises = [tried.by_features(data, base, extension), tried.by_samples(data, base, extension)];
        let power = |strength: f64| strength.signum() * strength.abs().log2().round().exp2();
        let is_hopeful = |own: &&Promise| own.odds > 0.0;
        let wanted =
            promises.each_ref().map(|own| own.as_ref().filter(is_hopeful).map(|own| power(own.strength)));
        for (best, own) in [&mut self.by_features, &mut self.by_samples].into_iter().zip(promises) {
            if own.as_ref().is_some_and(|own| best.as_ref().is_none_or(|best| own.odds > best.odds)) {
                *best = own;
            }
        }
        wanted
    }
}

impl Secants {
    /// Between a model without a strength and with it.
    fn between(before: &Comparison, here: &Comparison, strength: f64) -> Self {
        let of = |before: &Compared, here: &Compared| {
            let both = here.differences.iter().zip(&before.differences);
            both.map(|(here, before)| (here - before) / strength).collect()
        };
        Self { features: of(&before.features, &here.features), samples: of(&before.samples, &here.samples) }
    }
}

impl Promise {
    /// How it compares at the try, with slopes in the places of the extension.
    pub fn slopes(&self) -> Comparison {
        let Try { here, wider, secants, normals, places, .. } = &*self.tried;
        let both = here.samples.slopes.iter().zip(secants).zip(places);
        let slopes: Vec<_> = both
            .map(|((slopes, secant), place)| slopes.extended(wider, place.map(|place| (place, secant))))
            .collect();
        Comparison {
            features: here.features.clone(),
            samples: Compared { differences: here.samples.differences.clone(), slopes: slopes.into() },
            squares: normals
                .iter()
                .map(|own| Squares { jj: own.all.jj.clone(), slow: own.slow.slopes.clone() })
                .collect::<Vec<_>>()
                .into(),
        }
    }
}

impl Try {
    fn of(
        data: &Data,
        base: &Sampled,
        origin: &Point,
        extension: &Extension,
        strength: f64,
        mut here: Comparison,
        secants: Secants,
    ) -> Self {
        let z = at_strength(base, origin, extension, strength);
        let acts_on =
            |u: &usize, r: usize| extension.hypothesis.unknowns[*u].acts.iter().any(|(own, _)| *own == r);
        let place = |r: usize| extension.strengths.iter().copied().find(|u| acts_on(u, r));
        let places: Vec<_> = (0..secants.samples.len()).map(place).collect();
        let wider = wider(base, extension);
        let slopes = here.features.slopes.iter().zip(&secants.features);
        let slopes: Vec<_> = slopes
            .zip(&places)
            .map(|((slopes, secant), place)| slopes.extended(&wider, place.map(|place| (place, secant))))
            .collect();
        here.features.slopes = slopes.into();
        let secants = secants.samples;
        let normal = |r: usize| normal(&data.plans[r], &here, r, &wider, places[r], &secants[r]);
        let normals = (0..secants.len()).map(normal).collect();
        Self { strength, places, z, here, wider, secants, normals }
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

    /// The secant is good for strengths about its own, the slope at zero for those near zero: strengths stay there, and the others
    /// follow them.
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
        let [least, most] = if size > 0.0 { [size / FACTOR, size * FACTOR] } else { [LITTLE, LONGEST] };
        let near = |place: usize| {
            let sign = if unknowns[place].is_half || optimum[place] > 0.0 { 1.0 } else { -1.0 };
            sign * (optimum[place] * sign).clamp(least, most)
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

/// By how much the prior of each unknown of the model before is wider in an extension.
fn wider(base: &Sampled, extension: &Extension) -> Vec<f64> {
    let both = base.fit.hypothesis.unknowns.iter().zip(&extension.hypothesis.unknowns);
    both.map(|(before, own)| if before.scaled == own.scaled { 1.0 } else { extension.wider }).collect()
}

/// Normal equations of all samples of a release in the places of an extension, with the secant of its strength.
fn normal(
    plan: &Plan,
    here: &Comparison,
    r: usize,
    wider: &[f64],
    place: Option<usize>,
    secant: &DVector<f64>,
) -> Normal {
    let (slopes, difference) = (&here.samples.slopes[r], &here.samples.differences[r]);
    let mut places = slopes.places.clone();
    let wider = DVector::from_iterator(places.len(), places.iter().map(|place| wider[*place]));
    let mut jj = here.squares[r].jj.component_mul(&(&wider * wider.transpose()));
    let mut jd = slopes.matrix.tr_mul(difference).component_mul(&wider);
    let mut slow = here.squares[r].slow.clone() * DMatrix::from_diagonal(&wider);
    if let Some(place) = place {
        let n = places.len();
        let aside = slopes.matrix.tr_mul(secant).component_mul(&wider);
        (jj, jd) = (
            jj.resize(n + 1, n + 1, secant.norm_squared()),
            jd.resize_vertically(n + 1, secant.dot(difference)),
        );
        jj.view_mut((0, n), (n, 1)).copy_from(&aside);
        jj.view_mut((n, 0), (1, n)).copy_from(&aside.transpose());
        slow = slow.resize_horizontally(n + 1, 0.0);
        slow.column_mut(n).copy_from(&parts(plan, secant));
        places.push(place);
    }
    let all = Equations { jj, jd, dd: difference.norm_squared() };
    Normal { places, all, slow: Slow::of(plan, slow, difference) }
}

/// A point on the way from one to another, no unknown farther than the longest step, none of one sign below zero.
fn nearer(from: &DVector<f64>, to: &DVector<f64>, unknowns: &[Unknown]) -> DVector<f64> {
    DVector::from_fn(from.len(), |u, _| {
        let step = (to[u] - from[u]).clamp(-LONGEST, LONGEST);
        if unknowns[u].is_half { (from[u] + step).max(0.0) } else { from[u] + step }
    })
}

/// A place of the model before, with the strengths of an extension.
fn at_strength(base: &Sampled, origin: &Point, extension: &Extension, strength: f64) -> DVector<f64> {
    let mut z = beside(base, &origin.z, extension);
    extension.strengths.iter().for_each(|place| z[*place] = strength);
    z
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

#[cfg(test)]
mod tests;
