//! The fit to all samples, from the optimum of the features: values, intervals, and what is left.
//!
//! White noise σ of the camera in all N samples of a release, and beside it a misfit of root mean square m, of which a release shows
//! only n independent numbers. Each of these has the variance `σ² + m² N / n`. With the m that is most probable the logarithm
//! of the likelihood is `−n/2 ln(σ² + m² N / n)` and what all models share. So a model without misfit has the intervals of
//! its noise, and another one those of what it misses.

use nalgebra::{DMatrix, DVector};

use super::data::{Comparison, Data};
use super::hypothesis::Hypothesis;
use super::likelihood::{Expanded, Fit, laplace};
use super::search::{EFFORT, Likelihood, search};
use super::unknown::Unknown;
use crate::calibrate::repeats::{grouped_trials, is_one_condition};
use crate::features::Plan;

/// Misfit beside the noise, over it, that is not worth another effect: the noise itself is known to a tenth.
const NOISE: f64 = 0.5;
/// Misfit beside the noise, over it, that may be noise as well: noise is measured from neighbours, which see little of what is slow
/// in it. Both together are then at most twice what was measured.
const SLOW: f64 = 1.732_050_807_568_877_2;
/// Change of the misfit, as a logarithm, that is worth another round.
const SETTLED: f64 = 0.05;
/// Rounds in which the misfit of a linearised model follows its optimum.
const LINEAR_ROUNDS: usize = 8;

/// A fit to all samples.
pub struct Sampled {
    /// Where it ended, weighed by features.
    pub fit: Fit,
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
    /// Whether what is left is small beside the noise, or beside what does not repeat, m, so that another round is worth nothing.
    pub fn is_little(&self, repeats: f64) -> bool {
        self.misfit() <= (NOISE * self.noise).max(repeats)
    }

    /// Whether what is left may be noise, or what does not repeat, m.
    pub fn may_be_noise(&self, repeats: f64) -> bool {
        self.misfit() <= (SLOW * self.noise).max(repeats)
    }

    /// Root mean square misfit beside the noise, m. An effect acts in all releases of a condition: where there are several, this
    /// is the part of the residuals that they have in common.
    pub fn misfit(&self) -> f64 {
        self.misfit
    }

    /// The optimum of all samples, from a fit that has its own slopes; none where the model cannot be run.
    pub fn from(data: &Data, start: &Fit) -> Option<Self> {
        let hypothesis = &start.hypothesis;
        let misfits = Samples::misfits(data, &start.at.seen);
        let (at, misfits) = search(&Samples, data, hypothesis, start.at.clone(), misfits, EFFORT)?;
        let (z, seen) = (&at.z, &at.seen);
        let expansion = expanded(&data.plans, &normals(seen), z, &misfits);
        let covariance = expansion.hessian.clone().cholesky()?.inverse();
        let cost = 0.5 * z.norm_squared() - likelihood(&data.plans, &misfits);
        let evidence = laplace(&Expanded { cost, ..expansion }, z, &halves(&hypothesis.unknowns));
        let differences = &seen.samples.differences;
        let misfit = misfit(data, hypothesis, differences, &misfits);
        let count: f64 = data.plans.iter().map(|plan| sampled(plan) as f64).sum();
        let of = |plan: &Plan| sampled(plan) as f64 * plan.noise.powi(2);
        let noise = (2.0 * data.plans.iter().map(of).sum::<f64>() / count).sqrt();
        let rms = rms(differences);
        Some(Self {
            fit: Fit::at(data, hypothesis, at, start.share),
            covariance,
            rms,
            noise,
            evidence,
            misfit,
        })
    }
}

/// All samples as what a search compares; the scale is the mean square of the misfit of each release.
pub struct Samples;

impl Likelihood for Samples {
    type Scale = Vec<f64>;
    const LONGEST: f64 = 1.0;

    fn expanded(&self, data: &Data, seen: &Comparison, z: &DVector<f64>, misfits: &Vec<f64>) -> Expanded {
        expanded(&data.plans, &normals(seen), z, misfits)
    }

    fn scale(
        &self,
        data: &Data,
        _: &Hypothesis,
        seen: &Comparison,
        _: &DVector<f64>,
        _: &Vec<f64>,
    ) -> Vec<f64> {
        Self::misfits(data, seen)
    }

    fn is_settled(&self, before: &Vec<f64>, after: &Vec<f64>) -> bool {
        before.iter().zip(after).all(|(a, b)| (0.5 * (a / b).ln()).abs() <= SETTLED)
    }
}

impl Samples {
    /// The misfits at a point.
    pub fn misfits(data: &Data, seen: &Comparison) -> Vec<f64> {
        misfits_of(&data.plans, &squares(&seen.samples.differences))
    }
}

/// The normal equations of one release: with differences d and slopes J, `JᵀJ`, `Jᵀd` and `dᵀd`.
pub struct Normal {
    pub jj: DMatrix<f64>,
    pub jd: DVector<f64>,
    pub dd: f64,
}

fn normals(seen: &Comparison) -> Vec<Normal> {
    let of = |r: usize| {
        let difference = &seen.samples.differences[r];
        Normal {
            jj: seen.squares[r].clone(),
            jd: seen.samples.slopes[r].tr_mul(difference),
            dd: difference.norm_squared(),
        }
    };
    (0..seen.squares.len()).map(of).collect()
}

/// Optimum, covariance and evidence of the model that is linear about `z`, with the misfit that it then has.
pub fn linearised(
    plans: &[Plan],
    unknowns: &[Unknown],
    normals: &[Normal],
    z: &DVector<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>, f64)> {
    let squares = |step: &DVector<f64>| -> Vec<f64> {
        let of = |own: &Normal| (own.dd + 2.0 * step.dot(&own.jd) + step.dot(&(&own.jj * step))).max(0.0);
        normals.iter().map(of).collect()
    };
    let mut step = DVector::zeros(z.len());
    let mut covariance = None;
    let mut misfits = misfits_of(plans, &squares(&step));
    for _ in 0..LINEAR_ROUNDS {
        let at = expanded(plans, normals, z, &misfits);
        let factors = at.hessian.cholesky()?;
        step = -factors.solve(&at.gradient);
        covariance = Some(factors.inverse());
        let next = misfits_of(plans, &squares(&step));
        let is_settled = Samples.is_settled(&misfits, &next);
        misfits = next;
        if is_settled {
            break;
        }
    }
    let (optimum, rests) = (z + &step, squares(&step));
    let rest =
        |(own, dd): (&Normal, &f64)| Normal { jj: own.jj.clone(), jd: &own.jd + &own.jj * &step, dd: *dd };
    let there: Vec<Normal> = normals.iter().zip(&rests).map(rest).collect();
    let at = expanded(plans, &there, &optimum, &misfits);
    let cost = 0.5 * optimum.norm_squared() - likelihood(plans, &misfits);
    let evidence = laplace(&Expanded { cost, ..at }, &optimum, &halves(unknowns));
    Some((optimum, covariance?, evidence))
}

fn halves(unknowns: &[Unknown]) -> Vec<bool> {
    unknowns.iter().map(|own| own.is_half).collect()
}

/// Independent numbers that the misfit of a release is worth: as many as describe its swing.
pub fn numbers(plan: &Plan) -> f64 {
    plan.features.len() as f64
}

/// Marker positions of a release.
fn sampled(plan: &Plan) -> usize {
    plan.samples.len() * plan.tracks.len()
}

/// Recorded numbers of a release.
fn coordinates(plan: &Plan) -> f64 {
    (plan.samples.len() * plan.recorded.len()) as f64
}

fn squares(differences: &[DVector<f64>]) -> Vec<f64> {
    differences.iter().map(DVector::norm_squared).collect()
}

/// Mean square misfit of each release beside its noise, a little of that at least, from the sums of its squares.
fn misfits_of(plans: &[Plan], squares: &[f64]) -> Vec<f64> {
    let of = |(square, plan): (&f64, &Plan)| {
        (square / coordinates(plan) - plan.noise.powi(2)).max(1e-3 * plan.noise.powi(2))
    };
    squares.iter().zip(plans).map(of).collect()
}

fn expanded(plans: &[Plan], normals: &[Normal], z: &DVector<f64>, misfits: &[f64]) -> Expanded {
    let n = z.len();
    let (mut cost, mut gradient, mut hessian) = (0.5 * z.norm_squared(), z.clone(), DMatrix::identity(n, n));
    for ((own, plan), misfit) in normals.iter().zip(plans).zip(misfits) {
        let weight = variance(plan, *misfit).recip();
        cost += 0.5 * weight * own.dd;
        gradient += weight * &own.jd;
        hessian += weight * &own.jj;
    }
    Expanded { cost, gradient, hessian }
}

/// Logarithm of the likelihood at the most probable misfits, up to what all models share.
fn likelihood(plans: &[Plan], misfits: &[f64]) -> f64 {
    let of = |(plan, misfit): (&Plan, &f64)| -0.5 * numbers(plan) * variance(plan, *misfit).ln();
    plans.iter().zip(misfits).map(of).sum()
}

/// Variance of each of the independent numbers of a release, m²; `misfit` is a mean square beside the noise.
pub fn variance(plan: &Plan, misfit: f64) -> f64 {
    plan.noise.powi(2) + misfit * (coordinates(plan) / numbers(plan)).max(1.0)
}

/// Root mean square distance beside the noise, m, of what releases of one condition have in common: the mean product of the
/// residuals of two of them, in which noise and what does not repeat cancel. Of a release alone it is all beside the noise.
fn misfit(data: &Data, hypothesis: &Hypothesis, seen: &[DVector<f64>], misfits: &[f64]) -> f64 {
    let mut square = 0.0;
    for group in grouped_trials(hypothesis.trials.iter(), |trial| !trial.release.held_out, is_one_condition) {
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
fn product(data: &Data, seen: &[DVector<f64>], a: usize, b: usize) -> f64 {
    let [first, second] = [a, b].map(|r| (data.plans[r].samples.len(), &data.plans[r], &seen[r]));
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
fn rms(seen: &[DVector<f64>]) -> f64 {
    let count: usize = seen.iter().map(DVector::len).sum();
    (2.0 * squares(seen).iter().sum::<f64>() / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::unknown::Scaled;
    use super::*;
    use crate::features::tests::swing;

    /// A linear model has one optimum and one evidence, wherever it is expanded; at the optimum the gradient of the cost is zero.
    #[test]
    fn a_linear_model_is_the_same_from_each_point() {
        let plans = [Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap()];
        let plan = &plans[0];
        let rows = plan.samples.len() * plan.recorded.len();
        let size = 1e-3;
        let slopes = DMatrix::from_fn(rows, 2, |k, u| size * (0.03 * (k as f64) * (1.0 + u as f64)).sin());
        let own = |z: &DVector<f64>| {
            let aside = DVector::from_fn(rows, |k, _| 2.0 * size * (0.011 * k as f64).cos());
            let difference = aside + &slopes * (z - DVector::from_vec(vec![0.7, -0.4]));
            Normal {
                jj: slopes.tr_mul(&slopes),
                jd: slopes.tr_mul(&difference),
                dd: difference.norm_squared(),
            }
        };
        let unknown = Unknown::setup("", "", "", Scaled::Normal(0.0, 1.0));
        let unknowns = [unknown.clone(), unknown];
        let from = |z: [f64; 2]| {
            let z = DVector::from_column_slice(&z);
            linearised(&plans, &unknowns, &[own(&z)], &z).unwrap()
        };
        let ((optimum, _, evidence), (other, _, value)) = (from([0.0, 0.0]), from([-2.0, 1.5]));
        assert!((&optimum - &other).norm() < 0.01, "{optimum} {other}");
        assert!((evidence - value).abs() < 0.01, "{evidence} {value}");
        let there = [own(&optimum)];
        let misfits = misfits_of(&plans, &[there[0].dd]);
        let gradient = expanded(&plans, &there, &optimum, &misfits).gradient;
        assert!(gradient.norm() < 0.01 && optimum.norm() > 0.1, "{gradient} {optimum}");
    }

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
