//! The posterior of a calibration, by chains of a sampler.
//!
//! Its density is the cost of the fit, `exp(−cost)`, with the priors of the experiment, which are of the value. A parameter
//! without a prior is flat in its scaled variable, the logarithm or the value, within its bounds. The chains run on
//! coordinates that have no bounds, in which Laplace's approximation is a standard normal distribution.
//!
//! Residuals follow one another, so the curvature of the cost alone would give intervals that are too narrow. The draws are
//! stretched about the fit, so that their covariance is the one that the calibration states: the curvature adjustment of
//! Ribatet, Cooley and Davison (2012), Statistica Sinica 22, 813-845. The shape of the posterior is that of the cost.

mod density;

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use efam_core::quantile::quantile;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use density::PartDensity;

use super::calibration::Calibrated;
use super::outcome::CalibrationOutcome;
use super::unknowns::Unknown;
use super::{CalibrateError, CalibrationSettings, Listener, PartFit, Problem, fits, outcome_of};
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
    /// Four chains of 225 draws: an effective sample size of 400 with some to spare, as `convergence` needs for an R-hat that
    /// is known to a hundredth. In coordinates that are nearly normal, 50 draws tune the step.
    fn default() -> Self {
        Self { chains: 4, draws: 225, warm_up: 50, predicted: 10, seed: 1 }
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
    let outcome = outcome_of(&fitted);
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
