//! The fit to all samples, from the optimum of the features: values, intervals, and what is left.
//!
//! White noise of the camera, and a misfit of which a release shows only a few independent numbers: the variance of a sample is
//! `σ² + m² N / n`, N samples of a release, n numbers, m the misfit beside the noise. So a model without misfit has the
//! intervals of its noise, and another one those of what it misses.

use std::sync::Arc;

use efam_core::levenberg_marquardt::{Evaluated, minimise};
use nalgebra::{DMatrix, DVector};

use super::data::Data;
use super::hypothesis::{Hypothesis, Simulated};
use crate::features::Plan;

/// Independent numbers that the misfit of a release is worth: size, phase and rest of its swing early and late, in two coordinates.
pub const NUMBERS: f64 = 10.0;
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
    /// Mean square of the residuals of each release beside its noise, of a coordinate, m².
    pub misfits: Vec<f64>,
}

impl Sampled {
    /// Whether what is left is small beside the noise, or beside what does not repeat of a first swing, m.
    pub fn is_little(&self, swing: f64) -> bool {
        self.misfit() <= NOISE * self.noise || self.misfit() <= REPEATS * swing
    }

    /// Root mean square misfit beside the noise, m.
    pub fn misfit(&self) -> f64 {
        (self.rms * self.rms - self.noise * self.noise).max(0.0).sqrt()
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
    let covariance = expanded(data, &seen, &z, &misfits).2.cholesky()?.inverse();
    let count: f64 = data.plans.iter().map(|plan| sampled(plan) as f64).sum();
    let noise = (2.0 * data.plans.iter().map(|plan| sampled(plan) as f64 * plan.noise.powi(2)).sum::<f64>()
        / count)
        .sqrt();
    Some(Sampled { z, covariance, rms: rms(&seen), noise, misfits })
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
        let share = (own.residual.len() as f64 / NUMBERS).max(1.0);
        let weight = (plan.noise.powi(2) + misfit * share).recip();
        cost += 0.5 * weight * own.residual.norm_squared();
        if own.slopes.ncols() == n {
            gradient -= weight * own.slopes.tr_mul(&own.residual);
            hessian += weight * own.slopes.tr_mul(&own.slopes);
        }
    }
    (cost, gradient, hessian)
}

/// Root mean square distance of all markers.
fn rms(seen: &[Residuals]) -> f64 {
    let (sum, count) = seen
        .iter()
        .fold((0.0, 0), |(sum, count), own| (sum + own.residual.norm_squared(), count + own.residual.len()));
    (2.0 * sum / count.max(1) as f64).sqrt()
}
