//! The fit to all samples, from the optimum of the features: values, intervals, and what is left.
//!
//! Noise σ of the camera in all N samples of a release, whose density at the frequencies of a swing is κ times the mean, and beside it
//! a misfit of root mean square m, of which a release shows only n independent numbers. Each of these has the variance
//! `v = κ σ² + m² N / n`. With d the differences of all samples the squares of the independent numbers add up to
//! `q = |d|² − (N − n κ) σ²`, and the logarithm of the likelihood is `−n/2 ln v − q / 2v` and what all models share. The v of each
//! release is the one for which the evidence is largest. With C the covariance of the unknowns and J the slopes it is
//! `(q + tr C JᵀJ) / n`, and κ σ² at least: what the unknowns take up is no sign of a small misfit. So a model without misfit has the intervals of
//! its noise, and another one those of what it misses.
//!
//! Wander adds a variance S² to each of its parts x of the residuals, which lose the share `l = S² / (v + S²)`: q has `−l x²`, the logarithm of
//! the likelihood `ln(1 − l) / 2`, and the v of largest likelihood counts `1 − l` numbers, each with `(1 − l)² x²`.

use nalgebra::{DMatrix, DVector};

use super::data::{Comparison, Data};
use super::equations::{Normal, normals};
use super::hypothesis::Hypothesis;
use super::likelihood::{Expanded, Fit, laplace};
use super::search::{EFFORT, Likelihood, search};
use super::slopes::{add, add_square, trace_of_product};
use super::unknown::Unknown;
use crate::calibrate::repeats::{grouped_trials, is_one_condition};
use crate::features::Plan;

/// Misfit beside the noise, over it, that may be noise: the noise itself is known to a tenth.
const NOISE: f64 = 0.5;
/// Change of a deviation, as a logarithm, that is worth another round.
const SETTLED: f64 = 0.05;
/// Rounds in which the deviations of a linearised model follow its optimum.
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
    /// The same of what does not repeat in them; none where each is made once.
    unrepeated: Option<f64>,
}

impl Sampled {
    /// Whether what is left may be noise, or what does not repeat, m.
    pub fn may_be_noise(&self, repeats: f64) -> bool {
        self.misfit() <= (NOISE * self.noise).max(repeats)
    }

    /// How well releases repeat, m, as far as their misfit does not determine it: as stated, or else as releases by hand do.
    pub fn repeats(&self, data: &Data) -> f64 {
        if self.unrepeated.is_some() { data.stated_repeats() } else { data.repeats() }
    }

    /// How well they repeat, m: the same, or what those of one condition do not have in common, if that is more.
    pub fn repeated_within(&self, data: &Data) -> f64 {
        self.repeats(data).max(self.unrepeated.unwrap_or(0.0))
    }

    /// Root mean square misfit beside the noise, m. An effect acts in all releases of a condition: where there are several, this
    /// is the part of the residuals that they have in common.
    pub fn misfit(&self) -> f64 {
        self.misfit
    }

    /// The optimum of all samples, from a fit that has its own slopes; none where the model cannot be run.
    pub fn from(data: &Data, start: &Fit) -> Option<Self> {
        let hypothesis = &start.hypothesis;
        let variances = Samples::variances(data, &start.at.seen);
        let (at, variances) = search(&Samples, data, hypothesis, start.at.clone(), variances, EFFORT)?;
        let (z, seen) = (&at.z, &at.seen);
        let normals = normals(&data.plans, seen);
        let expansion = expanded(&normals, z, &variances);
        let covariance = expansion.hessian.clone().cholesky()?.inverse();
        let cost = 0.5 * z.norm_squared() - likelihood(&data.plans, &normals, &variances);
        let is_half = halves(&hypothesis.unknowns);
        // What a search that was cut short has not found is no evidence; at a bound the cost rises.
        let held = |u: usize, _| if expansion.is_held(u, z, &is_half) { expansion.gradient[u] } else { 0.0 };
        let gradient = DVector::from_fn(z.len(), held);
        let evidence = laplace(&Expanded { cost, gradient, ..expansion }, z, &is_half);
        let differences = &seen.samples.differences;
        let rests: Vec<f64> =
            normals.iter().zip(&variances).map(|(own, variance)| own.beside_wander(*variance).dd).collect();
        let (misfit, unrepeated) = misfit(data, hypothesis, differences, &rests);
        let count: f64 = data.plans.iter().map(|plan| sampled(plan) as f64).sum();
        let of = |plan: &Plan| sampled(plan) as f64 * plan.noise.deviation.powi(2);
        let noise = (2.0 * data.plans.iter().map(of).sum::<f64>() / count).sqrt();
        let rms = rms(differences);
        Some(Self {
            fit: Fit::at(data, hypothesis, at, start.share),
            covariance,
            rms,
            noise,
            evidence,
            misfit,
            unrepeated,
        })
    }
}

/// All samples as what a search compares; the scale is the variance of the independent numbers of each release.
pub struct Samples;

impl Likelihood for Samples {
    type Scale = Vec<f64>;
    const LONGEST: f64 = 1.0;

    fn expanded(&self, data: &Data, seen: &Comparison, z: &DVector<f64>, variances: &Vec<f64>) -> Expanded {
        expanded(&normals(&data.plans, seen), z, variances)
    }

    fn scale(
        &self,
        data: &Data,
        _: &Hypothesis,
        seen: &Comparison,
        z: &DVector<f64>,
        near: &Vec<f64>,
    ) -> Vec<f64> {
        let normals = normals(&data.plans, seen);
        let covariance = expanded(&normals, z, near).hessian.cholesky().map(|factors| factors.inverse());
        variances(&data.plans, &normals, near, covariance.as_ref())
    }

    fn is_settled(&self, before: &Vec<f64>, after: &Vec<f64>) -> bool {
        before.iter().zip(after).all(|(a, b)| (0.5 * (a / b).ln()).abs() <= SETTLED)
    }
}

impl Samples {
    /// The variances at a point where all unknowns are known.
    pub fn variances(data: &Data, seen: &Comparison) -> Vec<f64> {
        known_variances(&data.plans, &normals(&data.plans, seen))
    }
}

/// Logarithm of the evidence that a fit promises by the slopes that it has.
pub fn promised(data: &Data, fit: &Fit) -> Option<f64> {
    let linear =
        linearised(&data.plans, &fit.hypothesis.unknowns, &normals(&data.plans, &fit.at.seen), &fit.at.z);
    linear.map(|(_, _, evidence)| evidence)
}

/// Optimum, covariance and evidence of the model that is linear about `z`, with the misfit that it then has.
pub fn linearised(
    plans: &[Plan],
    unknowns: &[Unknown],
    normals: &[Normal],
    z: &DVector<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>, f64)> {
    let mut step = DVector::zeros(z.len());
    let mut covariance = None;
    let mut variances = known_variances(plans, normals);
    for _ in 0..LINEAR_ROUNDS {
        let at = expanded(normals, z, &variances);
        let factors = at.hessian.cholesky()?;
        step = -factors.solve(&at.gradient);
        let own = factors.inverse();
        let there: Vec<Normal> = normals.iter().map(|own| own.after(&step)).collect();
        let next = self::variances(plans, &there, &variances, Some(&own));
        covariance = Some(own);
        let is_settled = Samples.is_settled(&variances, &next);
        variances = next;
        if is_settled {
            break;
        }
    }
    let optimum = z + &step;
    let there: Vec<Normal> = normals.iter().map(|own| own.after(&step)).collect();
    let at = expanded(&there, &optimum, &variances);
    let cost = 0.5 * optimum.norm_squared() - likelihood(plans, &there, &variances);
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

/// Mean square misfit of a release beside its noise, m², from the sum of its squares.
fn beside_noise(plan: &Plan, square: f64) -> f64 {
    (square / coordinates(plan) - plan.noise.deviation.powi(2)).max(0.0)
}

/// Sum of the squares of the independent numbers of a release, from that of all its samples.
fn of_numbers(plan: &Plan, square: f64) -> f64 {
    square - (coordinates(plan) - numbers(plan) * plan.noise.slow) * plan.noise.deviation.powi(2)
}

/// The variance of the independent numbers of each release for which the evidence is largest, from variances near it; what unknowns of
/// a covariance C take up of the squares is `tr C JᵀJ` with the slopes J of the release.
/// Source: MacKay (1992), Neural Computation 4, 415-447.
fn variances(
    plans: &[Plan],
    normals: &[Normal],
    near: &[f64],
    covariance: Option<&DMatrix<f64>>,
) -> Vec<f64> {
    let of = |((plan, own), near): ((&Plan, &Normal), &f64)| {
        let lost = own.slow.lost(*near);
        let rest = own.without(&lost.map(|lost| lost * (2.0 - lost)));
        let taken = covariance.map_or(0.0, |all| trace_of_product(all, &own.places, &rest.jj));
        let count = (numbers(plan) - lost.sum()).max(1.0);
        ((of_numbers(plan, rest.dd) + taken) / count).max(variance(plan, 0.0))
    };
    plans.iter().zip(normals).zip(near).map(of).collect()
}

/// The same where all unknowns are known; first as if there were no wander.
fn known_variances(plans: &[Plan], normals: &[Normal]) -> Vec<f64> {
    let most = vec![f64::MAX; plans.len()];
    (0..LINEAR_ROUNDS).fold(most, |near, _| variances(plans, normals, &near, None))
}

fn expanded(normals: &[Normal], z: &DVector<f64>, variances: &[f64]) -> Expanded {
    let n = z.len();
    let (mut cost, mut gradient, mut hessian) = (0.5 * z.norm_squared(), z.clone(), DMatrix::identity(n, n));
    for (own, variance) in normals.iter().zip(variances) {
        let (weight, rest) = (variance.recip(), own.beside_wander(*variance));
        cost += 0.5 * weight * rest.dd;
        add(&mut gradient, &own.places, weight, &rest.jd);
        add_square(&mut hessian, &own.places, weight, &rest.jj);
    }
    Expanded { cost, gradient, hessian }
}

/// Logarithm of the likelihood, up to what all models share.
fn likelihood(plans: &[Plan], normals: &[Normal], variances: &[f64]) -> f64 {
    let of = |((plan, own), variance): ((&Plan, &Normal), &f64)| {
        let lost = own.slow.lost(*variance);
        let wander: f64 = lost.iter().map(|lost| (1.0 - lost).ln()).sum();
        let square = of_numbers(plan, own.without(&lost).dd);
        0.5 * wander - 0.5 * (numbers(plan) * variance.ln() + square / variance)
    };
    plans.iter().zip(normals).zip(variances).map(of).sum()
}

/// Variance of each of the independent numbers of a release, m²; `misfit` is a mean square beside the noise.
pub fn variance(plan: &Plan, misfit: f64) -> f64 {
    plan.noise.slow * plan.noise.deviation.powi(2) + misfit * (coordinates(plan) / numbers(plan)).max(1.0)
}

/// Root mean square distance beside the noise, m, of what releases of one condition have in common: the mean product of the
/// residuals of two of them, in which noise and what does not repeat cancel. A release alone has as much beside its first swing that
/// does not repeat as those have, or none where there are none. The same of what does not repeat comes second.
fn misfit(
    data: &Data,
    hypothesis: &Hypothesis,
    seen: &[DVector<f64>],
    squares: &[f64],
) -> (f64, Option<f64>) {
    let groups = grouped_trials(hypothesis.trials.iter(), |trial| !trial.release.held_out, is_one_condition);
    let swing = |r: usize| data.plans[r].first_swing.powi(2);
    let beside_noise = |r: usize| beside_noise(&data.plans[r], squares[r]);
    let (mut common, mut unrepeated, mut swings) = (0.0, 0.0, 0.0);
    for group in groups.iter().filter(|group| group.len() > 1) {
        let pairs = group.iter().enumerate().flat_map(|(k, a)| group[k + 1..].iter().map(move |b| (*a, *b)));
        let products: Vec<f64> = pairs.map(|(a, b)| product(data, seen, a, b)).collect();
        let own = (products.iter().sum::<f64>() / products.len() as f64).max(0.0);
        common += own * group.len() as f64;
        unrepeated += group.iter().map(|r| beside_noise(*r) - own).sum::<f64>();
        swings += group.iter().map(|r| swing(*r)).sum::<f64>();
    }
    let share = if swings > 0.0 { (unrepeated / swings).max(0.0) } else { 0.0 };
    let alone = groups.iter().filter(|group| group.len() == 1).map(|group| group[0]);
    common += alone.map(|r| (beside_noise(r) - share * swing(r)).max(0.0)).sum::<f64>();
    let all = (0..seen.len()).map(swing).sum::<f64>();
    let mean = |square: f64| (2.0 * square / seen.len().max(1) as f64).sqrt();
    (mean(common), (swings > 0.0).then(|| mean(share * all)))
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
    use super::super::equations::{Equations, Slow};
    use super::super::unknown::Scaled;
    use super::*;
    use crate::features::tests::swing;

    /// A sum of squares, of no wander.
    fn of_square(dd: f64) -> Normal {
        let none = DVector::zeros(0);
        let slow = Slow { slopes: DMatrix::zeros(0, 0), differences: none.clone(), variances: none.clone() };
        Normal { places: Vec::new(), all: Equations { jj: DMatrix::zeros(0, 0), jd: none, dd }, slow }
    }

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
                places: vec![0, 1],
                all: Equations {
                    jj: slopes.tr_mul(&slopes),
                    jd: slopes.tr_mul(&difference),
                    dd: difference.norm_squared(),
                },
                slow: Slow::of(plan, plan.wander.parts(&slopes), &difference),
            }
        };
        let unknown = Unknown::setup("", "", "", Scaled::Normal(0.0, 1.0));
        let unknowns = [unknown.clone(), unknown];
        let from = |z: [f64; 2]| {
            let z = DVector::from_column_slice(&z);
            linearised(&plans, &unknowns, &[own(&z)], &z).unwrap()
        };
        let ((optimum, covariance, evidence), (other, _, value)) = (from([0.0, 0.0]), from([-2.0, 1.5]));
        assert!((&optimum - &other).norm() < 0.01, "{optimum} {other}");
        assert!((evidence - value).abs() < 0.01, "{evidence} {value}");
        let there = [own(&optimum)];
        // The variance that belongs to the covariance: `C⁻¹ = I + JᵀJ / v`.
        let curvature = covariance.try_inverse().unwrap();
        let variance = there[0].all.jj[(0, 0)] / (curvature[(0, 0)] - 1.0);
        let gradient = expanded(&there, &optimum, &[variance]).gradient;
        assert!(gradient.norm() < 0.01 && optimum.norm() > 0.1, "{gradient} {optimum}");
    }

    /// Below the noise two sums of squares differ by `Δ / 2κσ²`, as for noise of that density; far above it by `n/2` times the
    /// logarithm of their misfits.
    #[test]
    fn the_likelihood_is_that_of_noise_and_of_misfit() {
        let plans = [Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap()];
        let plan = &plans[0];
        let noise = plan.noise.deviation.powi(2);
        let of = |square: f64| {
            let normals = [of_square(square)];
            likelihood(&plans, &normals, &known_variances(&plans, &normals))
        };
        let all = noise * coordinates(plan);
        let due = 0.05 * all / (2.0 * plan.noise.slow * noise);
        assert!(((of(0.9 * all) - of(0.95 * all)) / due - 1.0).abs() < 1e-9);
        let due = 0.5 * numbers(plan) * 4f64.ln();
        assert!(((of(1e4 * all) - of(4e4 * all)) / due - 1.0).abs() < 1e-3);
        // There is no jump between.
        assert!((of((1.0 - 1e-9) * all) - of((1.0 + 1e-9) * all)).abs() < 1e-4);
    }

    /// The variance is the one for which the evidence is largest: with one number a release of which most is misfit, a little more or
    /// less of it lowers `−n/2 ln v − q / 2v − ln|H| / 2`.
    #[test]
    fn the_variance_has_the_largest_evidence() {
        let plans = [Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap()];
        let plan = &plans[0];
        let square = 100.0 * coordinates(plan) * plan.noise.deviation.powi(2);
        let own = Normal {
            places: vec![0, 1, 2],
            all: Equations { jj: DMatrix::identity(3, 3) * 1e-3, jd: DVector::zeros(3), dd: square },
            slow: Slow { slopes: DMatrix::zeros(0, 3), ..of_square(square).slow },
        };
        let z = DVector::zeros(3);
        let normals = [own];
        let known = known_variances(&plans, &normals);
        let next = |own: Vec<f64>, _| {
            let covariance = expanded(&normals, &z, &own).hessian.try_inverse().unwrap();
            variances(&plans, &normals, &own, Some(&covariance))
        };
        let settled = (0..50).fold(known.clone(), next);
        let evidence = |factor: f64| {
            let own = [factor * settled[0]];
            likelihood(&plans, &normals, &own) - 0.5 * expanded(&normals, &z, &own).hessian.determinant().ln()
        };
        assert!(settled[0] > 1.05 * known[0]);
        assert!(evidence(1.0) > evidence(1.02) && evidence(1.0) > evidence(0.98));
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
