//! The posterior of a calibration, by chains of a sampler.
//!
//! Its density is the cost of the fit, `exp(−cost)`, with the priors of the experiment, which are of the value. A parameter
//! without a prior is flat in its scaled variable, the logarithm or the value, within its bounds. The chains run on
//! coordinates that have no bounds, in which Laplace's approximation is a standard normal distribution.
//!
//! Residuals follow one another, so the curvature of the cost alone would give intervals that are too narrow. The draws are
//! stretched about the fit, so that their covariance is the one that the calibration states: the curvature adjustment of
//! Ribatet, Cooley and Davison (2012), Statistica Sinica 22, 813-845. The shape of the posterior is that of the cost.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use efam_core::loss::Huber;
use efam_core::quantile::quantile;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::calibration::Calibrated;
use super::numerics::correction;
use super::objective::Objective;
use super::outcome::CalibrationOutcome;
use super::prediction::{FIT, Slopes};
use super::unknowns::Unknown;
use super::view::{Series, View};
use super::{CalibrateError, CalibrationSettings, Listener, PartFit, Problem, fits, told};
use crate::convergence::convergence;
use crate::normal::{normal, uniform};
use crate::nuts::{Chain, chain};

/// How a posterior is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleSettings {
    /// Chains, which run side by side; at least two, or nothing shows whether they agree.
    pub chains: usize,
    /// Draws of each that are kept.
    pub draws: usize,
    /// Draws of each before that, in which the steps are tuned.
    pub warm_up: usize,
    /// Draws of each whose recordings are predicted, spread over all.
    pub predicted: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for SampleSettings {
    /// Four chains of 250 draws: an effective sample size of 400 with some to spare, as `convergence` needs for an R-hat that
    /// is known to a hundredth. In coordinates that are nearly normal, 50 draws tune the step.
    fn default() -> Self {
        Self { chains: 4, draws: 250, warm_up: 50, predicted: 10, seed: 1 }
    }
}

/// Draws of a posterior with what shows whether to trust them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Posterior {
    /// The parameters.
    pub parameters: Vec<Sampled>,
    /// Nuisance parameters, per recording.
    pub nuisances: Vec<Sampled>,
    /// Releases that were fitted.
    pub releases: Vec<String>,
    /// Logarithm of the likelihood of each release, up to a constant, shape `[releases][chains][draws]`.
    pub log_likelihood: Vec<Vec<Vec<f64>>>,
    /// Markers as recorded, and as some draws predict them.
    pub markers: Vec<PredictedMarker>,
    /// Draws whose trajectory was broken off.
    pub divergent: u64,
    /// Places at which all releases were simulated, in all chains.
    pub evaluations: u64,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// One number of a posterior; SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sampled {
    /// Name, and what it belongs to.
    pub name: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Mean of the draws.
    pub value: f64,
    /// Their standard deviation.
    pub standard_error: f64,
    /// Their 2.5 % and 97.5 % points.
    pub interval_95: [f64; 2],
    /// The same interval as the calibration states it.
    pub laplace_95: Option<[f64; 2]>,
    /// R-hat by ranks; chains agree below 1.01.
    pub r_hat: Option<f64>,
    /// Effective sample size, by ranks.
    pub effective_draws: Option<f64>,
    /// Shape `[chains][draws]`.
    pub draws: Vec<Vec<f64>>,
    /// As many draws from the prior; none where it is flat without a bound.
    pub prior: Option<Vec<Vec<f64>>>,
}

/// A marker of a release: what was recorded, and what would be recorded again; x and z from the clamp, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedMarker {
    /// The release.
    pub release: String,
    /// The marker.
    pub marker: String,
    /// Times of the samples that were fitted, s.
    pub time_s: Vec<f64>,
    /// Recorded positions, shape `[samples][x, z]`.
    pub recorded_m: Vec<[f64; 2]>,
    /// Predictions with white noise of the size of the residuals, shape `[chains][draws][samples][x, z]`.
    pub predicted_m: Vec<Vec<Vec<[f64; 2]>>>,
}

/// R-hat up to which chains agree. Source: Vehtari et al. (2021), section 4.
const AGREES: f64 = 1.01;
/// Effective draws from which on R-hat and the ends of intervals are known. Source: Vehtari et al. (2021), section 4.
const ENOUGH: f64 = 400.0;
/// Draws from a prior until one is within the bounds; a prior that is a thousandth within them is none.
const MOST_TRIES: usize = 10_000;

/// Calibrates a problem, and samples its posterior.
/// # Errors
/// [`CalibrateError`] as of a calibration, and for a posterior that cannot be sampled.
pub fn sample(
    problem: &Problem,
    settings: &CalibrationSettings,
    sampling: &SampleSettings,
    listener: &dyn Listener,
) -> Result<(CalibrationOutcome, Posterior), CalibrateError> {
    let fitted = fits(problem, settings, listener)?;
    let outcome = told(&fitted);
    let names: Vec<_> =
        (outcome.calibration.parameters.iter().chain(&outcome.calibration.nuisances)).collect();
    let mut posterior = Posterior::default();
    let mut all: Vec<Option<Drawn>> = vec![None; names.len()];
    let is_nuisance: Vec<bool> = fitted.unknowns.list.iter().map(Unknown::is_nuisance).collect();
    for (k, fit) in fitted.each.iter().enumerate() {
        let keep_mesh = !settings.remove_mesh;
        // Parts share no unknown, and no random number.
        let seed = sampling.seed.wrapping_add(k as u64);
        let found = sample_part(fit, keep_mesh, &SampleSettings { seed, ..*sampling }, listener).ok_or_else(
            || CalibrateError::NotSampled { release: fit.objective.part.members[0].release.name.clone() },
        )?;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        for (u, place) in fit.objective.part.places.iter().enumerate() {
            let draws: Vec<Vec<f64>> =
                found.values.iter().map(|chain| chain.iter().map(|own| own[u]).collect()).collect();
            let unknown = &fit.objective.part.unknowns[u];
            let own = || -> Option<Vec<f64>> {
                (0..sampling.draws).map(|_| prior_draw(unknown, &mut random)).collect()
            };
            let prior = std::iter::repeat_with(own).take(sampling.chains).collect();
            all[*place] = Some((draws, prior));
        }
        posterior.markers.extend(found.markers);
        posterior.releases.extend(fit.objective.part.members.iter().map(|trial| trial.release.name.clone()));
        for r in 0..fit.objective.part.members.len() {
            let of = |chain: &Vec<Vec<f64>>| chain.iter().map(|own| own[r]).collect();
            posterior.log_likelihood.push(found.likelihoods.iter().map(of).collect());
        }
        posterior.divergent += found.divergent;
        posterior.evaluations += found.evaluations;
    }
    // The calibration lists parameters first, then nuisances, each in the order of the unknowns.
    let order = (0..all.len()).filter(|u| !is_nuisance[*u]).chain((0..all.len()).filter(|u| is_nuisance[*u]));
    for (u, calibrated) in order.zip(names) {
        let own = sampled(calibrated, all[u].take().unwrap_or_default());
        let list = if is_nuisance[u] { &mut posterior.nuisances } else { &mut posterior.parameters };
        list.push(own);
    }
    posterior.warnings = warnings(&posterior);
    Ok((outcome, posterior))
}

/// Draws of an unknown from the posterior and from its prior, shape `[chains][draws]`.
type Drawn = (Vec<Vec<f64>>, Option<Vec<Vec<f64>>>);

/// A value from the prior of an unknown, within its bounds; none where it is flat without a bound.
fn prior_draw(unknown: &Unknown, random: &mut Xoshiro256PlusPlus) -> Option<f64> {
    let (low, high) = unknown.bounds;
    match unknown.prior {
        Some(prior) => {
            let draws = std::iter::repeat_with(|| prior.mean + prior.deviation * normal(random));
            let is_within = |value: &f64| (low..=high).contains(&unknown.scaled.variable(*value));
            draws.take(MOST_TRIES).find(is_within)
        }
        None if low.is_finite() && high.is_finite() => {
            Some(unknown.scaled.value(low + (high - low) * uniform(random)))
        }
        None => None,
    }
}

fn sampled(calibrated: &Calibrated, (draws, prior): Drawn) -> Sampled {
    let all: Vec<f64> = draws.iter().flatten().copied().collect();
    let count = all.len() as f64;
    let value = all.iter().sum::<f64>() / count;
    let variance = all.iter().map(|own| (own - value).powi(2)).sum::<f64>() / (count - 1.0);
    let at = |share: f64| quantile(all.clone(), share).unwrap_or(f64::NAN);
    let found = convergence(&draws);
    Sampled {
        name: calibrated.label(),
        unit: calibrated.unit.clone(),
        value,
        standard_error: variance.sqrt(),
        interval_95: [at(0.025), at(0.975)],
        laplace_95: calibrated.interval_95,
        r_hat: found.map(|[r_hat, _]| r_hat),
        effective_draws: found.map(|[_, size]| size),
        draws,
        prior,
    }
}

fn warnings(posterior: &Posterior) -> Vec<String> {
    let mut warnings = Vec::new();
    let all = || posterior.parameters.iter().chain(&posterior.nuisances);
    let worst = |of: fn(&Sampled) -> Option<f64>, sign: f64| {
        let values = all().filter_map(|own| Some((of(own)?, &own.name)));
        values.max_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)))
    };
    if let Some((r_hat, name)) = worst(|own| own.r_hat, 1.0).filter(|(r_hat, _)| *r_hat > AGREES) {
        warnings.push(format!(
            "chains do not agree about {name}: R-hat is {r_hat:.3}, above {AGREES}; sample more draws"
        ));
    }
    if let Some((size, name)) = worst(|own| own.effective_draws, -1.0).filter(|(size, _)| *size < ENOUGH) {
        warnings.push(format!(
            "the draws of {name} are worth {size:.0} independent ones, fewer than {ENOUGH}; sample more draws"
        ));
    }
    if posterior.divergent > 0 {
        warnings.push(format!(
            "{} draws had a trajectory that was broken off: the posterior may reach where no draw came",
            posterior.divergent
        ));
    }
    warnings
}

/// Draws of one part.
#[derive(Default)]
struct PartDraws {
    /// Values, shape `[chains][draws][unknowns]`.
    values: Vec<Vec<Vec<f64>>>,
    /// Shape `[chains][draws][releases]`.
    likelihoods: Vec<Vec<Vec<f64>>>,
    markers: Vec<PredictedMarker>,
    divergent: u64,
    evaluations: u64,
}

fn sample_part(
    fit: &PartFit,
    keep_mesh: bool,
    sampling: &SampleSettings,
    listener: &dyn Listener,
) -> Option<PartDraws> {
    let density = PartDensity::of(fit, keep_mesh)?;
    let size = fit.found.x.len();
    let (done, is_ended) = (AtomicUsize::new(0), AtomicBool::new(false));
    let whole = sampling.chains * (sampling.warm_up + sampling.draws);
    let tell = || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of((whole / 20).max(1)) {
            listener.doing(&format!("sampling: {done} of {whole} draws"));
        }
        !is_ended.load(Ordering::Relaxed)
    };
    let one = |number: usize| -> Option<(Chain, Vec<Vec<f64>>)> {
        // Each draw is a place that the chain has been at.
        let seen: Mutex<HashMap<Vec<u64>, Vec<f64>>> = Mutex::default();
        let key = |u: &[f64]| u.iter().map(|own| own.to_bits()).collect::<Vec<u64>>();
        let of = |u: &[f64], force: &mut [f64]| {
            let (logarithm, likelihoods) = density.at(u, force)?;
            seen.lock().unwrap_or_else(PoisonError::into_inner).insert(key(u), likelihoods);
            Some(logarithm)
        };
        let counts = (sampling.warm_up, sampling.draws);
        let found = chain(&of, size, counts, (sampling.seed, number as u64), &tell);
        is_ended.fetch_or(found.is_none(), Ordering::Relaxed);
        let (found, seen) = (found?, seen.into_inner().unwrap_or_else(PoisonError::into_inner));
        let again = |u: &[f64]| density.at(u, &mut vec![0.0; size]).map(|(_, likelihoods)| likelihoods);
        let likelihoods = |u: &Vec<f64>| seen.get(&key(u)).cloned().or_else(|| again(u));
        let likelihoods = found.draws.iter().map(likelihoods).collect::<Option<_>>()?;
        Some((found, likelihoods))
    };
    let chains: Vec<(Chain, Vec<Vec<f64>>)> = (0..sampling.chains)
        .into_par_iter()
        .map(one)
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Option<_>>()?;
    let mut draws = PartDraws::default();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(!sampling.seed);
    draws.markers = density.markers(&chains, sampling.predicted.min(sampling.draws), &mut random)?;
    for (chain, likelihoods) in chains {
        draws.values.push(chain.draws.iter().map(|u| density.values(u)).collect());
        draws.likelihoods.push(likelihoods);
        draws.divergent += chain.divergent;
        draws.evaluations += chain.evaluations;
    }
    Some(draws)
}

/// The posterior of a part in whitened coordinates.
struct PartDensity<'a> {
    fit: &'a PartFit,
    objective: &'a Objective,
    view: View,
    /// Coordinates without bounds at the fit.
    center: DVector<f64>,
    /// From whitened coordinates to those without bounds, by the curvature of the cost.
    root: DMatrix<f64>,
    /// The same by the covariance that the calibration states.
    stated: DMatrix<f64>,
    /// Slopes of the fit in units of the noise, of each release, shape `[samples of all tracks, x and z][locals]`.
    slopes: Vec<DMatrix<f64>>,
}

impl<'a> PartDensity<'a> {
    fn of(fit: &'a PartFit, keep_mesh: bool) -> Option<Self> {
        let PartFit { objective, found, uncertainty, .. } = fit;
        let hessian = &found.at.hessian;
        let coordinates = || objective.part.unknowns.iter().map(Coordinate::of);
        // A fit at a bound has no coordinate: the center is one standard error inside.
        let center = DVector::from_iterator(
            found.x.len(),
            coordinates().enumerate().map(|(k, own)| {
                let deviation = hessian[(k, k)].sqrt().recip();
                own.inside(found.x[k], if deviation.is_finite() { deviation } else { f64::INFINITY })
            }),
        );
        let slopes = DVector::from_iterator(
            center.len(),
            coordinates().zip(center.iter()).map(|(own, y)| own.slope(*y)),
        );
        let bends = DVector::from_iterator(
            center.len(),
            coordinates().zip(center.iter()).map(|(own, y)| own.bend(*y)),
        );
        let by_slopes = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(center.len(), center.len(), |a, b| slopes[a] * matrix[(a, b)] * slopes[b])
        };
        let bends = DMatrix::from_diagonal(&bends);
        let factor = Cholesky::new(by_slopes(hessian) + &bends)?.l();
        let root = factor.transpose().try_inverse()?;
        // In whitened coordinates the cost has the covariance one; the calibration states another one there.
        let spread = hessian * &uncertainty.covariance * hessian;
        let stated = root.transpose() * (by_slopes(&spread) + &bends) * &root;
        let eigen = SymmetricEigen::new(stated);
        let roots = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
        let stated = &root * (&eigen.eigenvectors * roots * eigen.eigenvectors.transpose());
        let view = View { fidelity: FIT, steps: None, slopes: Slopes::Variational, ..found.view.clone() };
        let view = match &found.view.corrections {
            // What finer meshes and steps add to the coarse runs of the sampler, at the fit.
            Some(_) => {
                let finer = correction(objective, &found.x, &view, keep_mesh)?;
                View { steps: Some(finer.own_steps), corrections: Some(finer.corrections), ..view }
            }
            None => View { steps: Some(objective.see(&found.x, &view, None)?.steps), ..view },
        };
        let slopes = found.at.carried.blocks.iter().map(|block| {
            let rows = || block.iter().flat_map(|series| &series.slopes);
            let columns = rows().next().map_or(0, Vec::len);
            let values = rows().flat_map(|own| (0..2).flat_map(move |axis| own.iter().map(move |s| s[axis])));
            DMatrix::from_row_iterator(2 * rows().count(), columns, values)
        });
        let slopes = slopes.collect();
        Some(Self { fit, objective, view, center, root, stated, slopes })
    }

    fn coordinates(&self) -> impl Iterator<Item = Coordinate> {
        self.objective.part.unknowns.iter().map(Coordinate::of)
    }

    /// Scaled unknowns at coordinates without bounds.
    fn unknowns(&self, y: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(y.len(), self.coordinates().zip(y.iter()).map(|(own, y)| own.variable(*y)))
    }

    /// Logarithms of the density and of the likelihood of each release, with a force by the slopes of the fit: the prediction is
    /// simulated at each place, and its slopes are those of the fit, which are a run for each unknown.
    fn at(&self, u: &[f64], force: &mut [f64]) -> Option<(f64, Vec<f64>)> {
        let y = &self.center + &self.root * DVector::from_column_slice(u);
        let x = self.unknowns(&y);
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let seen = self.objective.see(&x, &self.view, None)?;
        let likelihood = |(block, loss): (&Vec<Series>, &Huber)| {
            -block.iter().flat_map(Series::lengths).map(|length| loss.cost(length)).sum::<f64>()
        };
        let likelihoods: Vec<f64> = seen.blocks.iter().zip(&self.view.loss).map(likelihood).collect();
        let mut logarithm: f64 = likelihoods.iter().sum();
        let mut by_x = DVector::<f64>::zeros(x.len());
        for (r, block) in seen.blocks.iter().enumerate() {
            let weighted = |residual: &[f64; 2]| {
                let weight = self.view.loss[r].weight(residual[0].hypot(residual[1]));
                residual.map(|own| weight * own)
            };
            let residuals = block.iter().flat_map(|series| series.residual.iter().flat_map(weighted));
            let residuals = DVector::from_iterator(self.slopes[r].nrows(), residuals);
            let own = self.slopes[r].tr_mul(&residuals);
            self.objective.places(r, 0).iter().zip(own.iter()).for_each(|(place, own)| by_x[*place] += own);
        }
        for (k, residual, slope) in self.objective.prior_residuals(&x) {
            // A prior is one of the value.
            let (by_value, by_logarithm) = self.objective.part.unknowns[k].scaled.logarithm_of_slope(x[k]);
            logarithm += by_value - 0.5 * residual * residual;
            by_x[k] += by_logarithm + residual * slope;
        }
        logarithm += self.coordinates().zip(y.iter()).map(|(own, y)| own.logarithm(*y)).sum::<f64>();
        let by_y = self.coordinates().zip(y.iter()).zip(by_x.iter());
        let by_y = by_y.map(|((own, y), by_x)| own.logarithm_slope(*y) + by_x * own.slope(*y));
        force.copy_from_slice((self.root.transpose() * DVector::from_iterator(y.len(), by_y)).as_slice());
        Some((logarithm, likelihoods))
    }

    /// Scaled unknowns of a draw, with the covariance that the calibration states.
    fn drawn(&self, u: &[f64]) -> DVector<f64> {
        self.unknowns(&(&self.center + &self.stated * DVector::from_column_slice(u)))
    }

    /// Their values.
    fn values(&self, u: &[f64]) -> Vec<f64> {
        let x = self.drawn(u);
        let unknowns = self.objective.part.unknowns.iter().zip(x.iter());
        unknowns.map(|(unknown, x)| unknown.scaled.value(*x)).collect()
    }

    /// What some draws of each chain predict.
    fn markers(
        &self,
        chains: &[(Chain, Vec<Vec<f64>>)],
        count: usize,
        random: &mut Xoshiro256PlusPlus,
    ) -> Option<Vec<PredictedMarker>> {
        let mut markers = Vec::new();
        for (r, trial) in self.objective.part.members.iter().enumerate() {
            for track in &trial.release.tracks {
                let samples = self.objective.measured[r].samples.iter().take(self.view.counts[r]);
                let seen = samples.filter_map(|k| Some((trial.release.time[*k], track.position[*k]?)));
                let (time_s, recorded_m) = seen.unzip();
                let (release, marker) = (trial.release.name.clone(), track.marker.clone());
                let predicted_m = vec![Vec::new(); chains.len()];
                markers.push(PredictedMarker { release, marker, time_s, recorded_m, predicted_m });
            }
        }
        for (c, (chain, _)) in chains.iter().enumerate() {
            for k in 0..count {
                let x = self.drawn(&chain.draws[k * chain.draws.len() / count]);
                let seen = self.objective.see(&x, &self.view, None)?;
                let tracks = self.fit.uncertainty.tracks.iter().flatten();
                let noise = self.objective.measured.iter().flat_map(|measured| &measured.noise);
                let series = seen.blocks.iter().flatten().zip(noise).zip(tracks);
                for (marker, ((series, noise), track)) in markers.iter_mut().zip(series) {
                    let mut again = |(recorded, residual): (&[f64; 2], &[f64; 2])| {
                        let one = |axis: usize| {
                            recorded[axis] - noise * residual[axis] + track.noise * normal(random)
                        };
                        [0, 1].map(one)
                    };
                    let own = marker.recorded_m.iter().zip(&series.residual).map(&mut again).collect();
                    marker.predicted_m[c].push(own);
                }
            }
        }
        Some(markers)
    }
}

/// A coordinate without bounds of an unknown that has some.
#[derive(Clone, Copy, Debug)]
enum Coordinate {
    Free,
    /// Above or below a bound, by `exp`.
    Above(f64),
    Below(f64),
    /// Between two, by the logistic function.
    Between(f64, f64),
}

impl Coordinate {
    fn of(unknown: &Unknown) -> Self {
        match unknown.bounds {
            (low, high) if low.is_finite() && high.is_finite() => Self::Between(low, high),
            (low, _) if low.is_finite() => Self::Above(low),
            (_, high) if high.is_finite() => Self::Below(high),
            _ => Self::Free,
        }
    }

    /// Of a scaled unknown, moved so far inside that it has a distance from its bounds; half-way between two at most.
    fn inside(self, x: f64, distance: f64) -> f64 {
        match self {
            Self::Free => x,
            Self::Above(low) => (x - low).max(distance.min(1.0)).ln(),
            Self::Below(high) => (high - x).max(distance.min(1.0)).ln(),
            Self::Between(low, high) => {
                let width = high - low;
                let distance = distance.min(0.5 * width);
                let share = ((x - low).clamp(distance, width - distance)) / width;
                (share / (1.0 - share)).ln()
            }
        }
    }

    fn variable(self, y: f64) -> f64 {
        match self {
            Self::Free => y,
            Self::Above(low) => low + y.exp(),
            Self::Below(high) => high - y.exp(),
            Self::Between(low, high) => low + (high - low) * logistic(y),
        }
    }

    /// Derivative of the scaled unknown.
    fn slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 1.0,
            Self::Above(_) => y.exp(),
            Self::Below(_) => -y.exp(),
            Self::Between(low, high) => (high - low) * logistic(y) * logistic(-y),
        }
    }

    /// Logarithm of the size of that, which makes a density flat in the unknown.
    fn logarithm(self, y: f64) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::Above(_) | Self::Below(_) => y,
            Self::Between(low, high) => (high - low).ln() + logistic(y).ln() + logistic(-y).ln(),
        }
    }

    fn logarithm_slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::Above(_) | Self::Below(_) => 1.0,
            Self::Between(..) => 1.0 - 2.0 * logistic(y),
        }
    }

    /// Curvature of its negative.
    fn bend(self, y: f64) -> f64 {
        match self {
            Self::Between(..) => 2.0 * logistic(y) * logistic(-y),
            _ => 0.0,
        }
    }
}

fn logistic(y: f64) -> f64 {
    (1.0 + (-y).exp()).recip()
}
