//! The fit to all samples, from the optimum of the features: values, intervals, and what is left.
//!
//! White noise σ of the camera in all N samples of a release, and beside it a misfit of root mean square m, of which a release shows
//! only n independent numbers. Each of these has the variance `σ² + m² N / n`. With the m that is most probable the logarithm
//! of the likelihood is `−n/2 ln(σ² + m² N / n)` and what all models share. So a model without misfit has the intervals of
//! its noise, and another one those of what it misses.

use std::sync::Arc;

use efam_core::levenberg_marquardt::{Evaluated, minimise};
use nalgebra::{DMatrix, DVector};

use super::data::Data;
use super::hypothesis::{Hypothesis, Simulated};
use super::likelihood::{Expanded, laplace};
use crate::calibrate::repeats::{grouped_trials, is_one_condition};
use crate::features::Plan;

/// Misfit beside the noise, over it, that is not worth another effect: the noise itself is known to a tenth.
const NOISE: f64 = 0.5;
/// Share of the first swing that does not repeat, where nothing else is known: two releases by hand differ by 1 to 3 %.
const REPEATS: f64 = 0.01;
/// Rounds in which the misfit follows the fit, and evaluations of each.
const ROUNDS: usize = 4;
const EVALUATIONS: usize = 10;
/// Predicted decrease of the cost that is not worth a step, nats.
const TOLERANCE: f64 = 0.02;
const LONGEST: f64 = 1.0;
/// Change of the misfit, as a logarithm, that is worth another round.
const SETTLED: f64 = 0.05;

/// Residuals of one release, recorded less simulated, m, and their slopes by all unknowns.
struct Residuals {
    residual: DVector<f64>,
    slopes: DMatrix<f64>,
}

/// A fit to all samples.
pub struct Sampled {
    pub z: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// Root mean square distance of simulated and recorded markers, m: two coordinates together.
    pub rms: f64,
    /// The same that noise alone leaves.
    pub noise: f64,
    /// Logarithm of the evidence by Laplace's method, up to what all models share.
    pub evidence: f64,
    /// Root mean square distance, m, beside the noise, of what repeats in the releases of each condition.
    misfit: f64,
}

impl Sampled {
    /// Whether what is left is small beside the noise, or beside what does not repeat of a first swing, m.
    pub fn is_little(&self, swing: f64) -> bool {
        self.misfit() <= NOISE * self.noise || self.misfit() <= REPEATS * swing
    }

    /// Root mean square misfit beside the noise, m. An effect acts in all releases of a condition: where there are several, this
    /// is the part of the residuals that they have in common.
    pub fn misfit(&self) -> f64 {
        self.misfit
    }
}

/// Fits all samples; none where the model cannot be run at the start.
pub fn fit(data: &Data, hypothesis: &Arc<Hypothesis>, start: &DVector<f64>) -> Option<Sampled> {
    let mut z = start.clone();
    let mut seen: Option<Arc<Vec<Residuals>>> = None;
    let mut misfits = Vec::new();
    for _ in 0..ROUNDS {
        let first = match seen.take() {
            Some(seen) => seen,
            None => see(data, hypothesis, &z, true)?.into(),
        };
        let now = misfits_of(data, &first);
        let changed =
            misfits.iter().zip(&now).any(|(a, b): (&f64, &f64)| (0.5 * (a / b).ln()).abs() > SETTLED);
        let is_first = misfits.is_empty();
        if !is_first && !changed {
            seen = Some(first);
            break;
        }
        misfits = now;
        let search = hypothesis.search(LONGEST, TOLERANCE, EVALUATIONS);
        let begin = z.clone();
        let mut evaluate = |x: &DVector<f64>, reused: Option<&Arc<Vec<Residuals>>>| {
            let residuals: Arc<Vec<Residuals>> = match (reused, *x == begin) {
                (None, true) => first.clone(),
                (None, false) => see(data, hypothesis, x, true)?.into(),
                (Some(reused), _) => {
                    let here = see(data, hypothesis, x, false)?;
                    let both = here.into_iter().zip(reused.iter());
                    let joined = both.map(|(here, other)| Residuals { slopes: other.slopes.clone(), ..here });
                    Arc::new(joined.collect())
                }
            };
            let (cost, gradient, hessian) = expanded(data, &residuals, x, &misfits);
            Some(Evaluated { cost, gradient, hessian, carried: residuals })
        };
        let found = minimise(&z, None, &search, &mut evaluate)?;
        z = found.x;
        seen = Some(if found.home == Some(z.clone()) {
            found.at.carried
        } else {
            see(data, hypothesis, &z, true)?.into()
        });
    }
    let seen = seen?;
    let misfits = misfits_of(data, &seen);
    let (_, gradient, hessian) = expanded(data, &seen, &z, &misfits);
    let covariance = hessian.clone().cholesky()?.inverse();
    let of = |((own, plan), misfit): ((&Residuals, &Plan), &f64)| {
        -0.5 * numbers(plan) * variance(own, plan, *misfit).ln()
    };
    let likelihood: f64 = seen.iter().zip(&data.plans).zip(&misfits).map(of).sum();
    let is_half: Vec<bool> = hypothesis.unknowns.iter().map(|own| own.is_half).collect();
    let cost = 0.5 * z.norm_squared() - likelihood;
    let evidence = laplace(&Expanded { cost, gradient, hessian }, &z, &is_half);
    let misfit = misfit(data, hypothesis, &seen, &misfits);
    let count: f64 = data.plans.iter().map(|plan| sampled(plan) as f64).sum();
    let noise = (2.0 * data.plans.iter().map(|plan| sampled(plan) as f64 * plan.noise.powi(2)).sum::<f64>()
        / count)
        .sqrt();
    Some(Sampled { z, covariance, rms: rms(&seen), noise, evidence, misfit })
}

/// Independent numbers that the misfit of a release is worth: as many as describe its swing.
pub fn numbers(plan: &Plan) -> f64 {
    plan.features.len() as f64
}

/// Marker positions of a release.
fn sampled(plan: &Plan) -> usize {
    plan.samples.len() * plan.tracks.len()
}

fn see(data: &Data, hypothesis: &Arc<Hypothesis>, z: &DVector<f64>, slopes: bool) -> Option<Vec<Residuals>> {
    let n = hypothesis.unknowns.len();
    let of = |_: usize, plan: &Plan, simulated: Simulated| {
        let count = plan.samples.len();
        let coordinates = plan.recorded.len();
        let flat = |q: &[Vec<f64>], c: usize, k: usize| q[c][k];
        let residual = DVector::from_fn(count * coordinates, |i, _| {
            let (c, k) = (i / count, i % count);
            flat(&plan.recorded, c, k) - flat(&simulated.coordinates, c, k)
        });
        let mut by = DMatrix::zeros(if slopes { residual.len() } else { 0 }, if slopes { n } else { 0 });
        for (u, moved) in simulated.slopes.iter().filter(|_| slopes) {
            for (c, q) in moved.iter().enumerate() {
                by.view_mut((c * count, *u), (count, 1)).copy_from_slice(&q[..count]);
            }
        }
        Residuals { residual, slopes: by }
    };
    data.simulate(hypothesis, z, &|_| slopes, of)
}

/// Mean square of the residuals of each release beside its noise, a little of that at least.
fn misfits_of(data: &Data, seen: &[Residuals]) -> Vec<f64> {
    let of = |(own, plan): (&Residuals, &Plan)| {
        let square = own.residual.norm_squared() / own.residual.len() as f64;
        (square - plan.noise.powi(2)).max(1e-3 * plan.noise.powi(2))
    };
    seen.iter().zip(&data.plans).map(of).collect()
}

fn expanded(
    data: &Data,
    seen: &[Residuals],
    z: &DVector<f64>,
    misfits: &[f64],
) -> (f64, DVector<f64>, DMatrix<f64>) {
    let n = z.len();
    let (mut cost, mut gradient, mut hessian) = (0.5 * z.norm_squared(), z.clone(), DMatrix::identity(n, n));
    for ((own, plan), misfit) in seen.iter().zip(&data.plans).zip(misfits) {
        let weight = variance(own, plan, *misfit).recip();
        cost += 0.5 * weight * own.residual.norm_squared();
        if own.slopes.ncols() == n {
            gradient -= weight * own.slopes.tr_mul(&own.residual);
            hessian += weight * own.slopes.tr_mul(&own.slopes);
        }
    }
    (cost, gradient, hessian)
}

/// Variance of each of the independent numbers of a release, m²; `misfit` is a mean square beside the noise.
fn variance(own: &Residuals, plan: &Plan, misfit: f64) -> f64 {
    plan.noise.powi(2) + misfit * (own.residual.len() as f64 / numbers(plan)).max(1.0)
}

/// Root mean square distance beside the noise, m, of what releases of one condition have in common: the mean product of the
/// residuals of two of them, in which noise and what does not repeat cancel. Of a release alone it is all beside the noise.
fn misfit(data: &Data, hypothesis: &Hypothesis, seen: &[Residuals], misfits: &[f64]) -> f64 {
    let mut square = 0.0;
    for group in grouped_trials(hypothesis.trials.iter(), |_| true, is_one_condition) {
        let pairs = group.iter().enumerate().flat_map(|(k, a)| group[k + 1..].iter().map(move |b| (*a, *b)));
        let products: Vec<f64> = pairs.map(|(a, b)| product(data, seen, a, b)).collect();
        let own = match products.len() {
            0 => misfits[group[0]],
            count => (products.iter().sum::<f64>() / count as f64).max(0.0),
        };
        square += own * group.len() as f64;
    }
    (2.0 * square / seen.len().max(1) as f64).sqrt()
}

/// Mean product of the residuals of two releases at the same times, m².
fn product(data: &Data, seen: &[Residuals], a: usize, b: usize) -> f64 {
    let [first, second] = [a, b].map(|r| (data.plans[r].samples.len(), &data.plans[r], &seen[r].residual));
    let (mut sum, mut count) = (0.0, 0);
    for c in 0..first.1.recorded.len().min(second.1.recorded.len()) {
        let path = |(n, plan, residual): (usize, &Plan, &DVector<f64>)| {
            let values = residual.as_slice()[c * n..(c + 1) * n].to_vec();
            plan.time[..n].iter().copied().zip(values).collect::<Vec<_>>()
        };
        let (own, together) = products(&path(first), &path(second));
        sum += own;
        count += together;
    }
    sum / count.max(1) as f64
}

/// Sum of the products of two paths of time and value, the second interpolated at the times of the first, and their number.
fn products(first: &[(f64, f64)], second: &[(f64, f64)]) -> (f64, usize) {
    let of = |&(time, value): &(f64, f64)| {
        let next = second.partition_point(|(t, _)| *t < time);
        let ((t0, before), (t1, after)) = (second.get(next.checked_sub(1)?)?, second.get(next)?);
        Some(value * (before + (time - t0) / (t1 - t0) * (after - before)))
    };
    first.iter().filter_map(of).fold((0.0, 0), |(sum, count), own| (sum + own, count + 1))
}

/// Root mean square distance of all markers.
fn rms(seen: &[Residuals]) -> f64 {
    let (sum, count) = seen
        .iter()
        .fold((0.0, 0), |(sum, count), own| (sum + own.residual.norm_squared(), count + own.residual.len()));
    (2.0 * sum / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What two releases have in common has the mean square of a sine, at other times as well; what only one of them has
    /// cancels: sines of different frequencies over whole periods.
    #[test]
    fn only_what_repeats_has_a_product() {
        let path = |rate: f64, shift: f64| -> Vec<(f64, f64)> {
            (0..1000).map(|k| 0.01 * f64::from(k) + shift).map(|t| (t, (rate * t).sin())).collect()
        };
        let mean = |a: &[(f64, f64)], b: &[(f64, f64)]| {
            let (sum, count) = products(a, b);
            assert!(count > 990);
            sum / count as f64
        };
        let tau = std::f64::consts::TAU;
        assert!((mean(&path(tau, 0.0), &path(tau, 0.004)) - 0.5).abs() < 2e-3);
        assert!(mean(&path(tau, 0.0), &path(2.0 * tau, 0.004)).abs() < 2e-3);
        assert_eq!(products(&path(tau, 0.0), &[]), (0.0, 0));
    }
}
