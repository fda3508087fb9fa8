//! The likelihood of features, and the evidence of a hypothesis by Laplace's method.
//!
//! The differences of features are normal with covariance `C + s² D²`: C from the noise, D the scale of each feature, s one
//! share for the whole experiment, which holds what does not repeat and what no model has. In the eigenvectors of
//! `D⁻¹ C D⁻¹` the covariance is diagonal for every s.
//!
//! The evidence is `∫ p(features | z) p(z) dz` with the exponent expanded to the second order; a half-normal unknown cuts off
//! half of the space. Its factor is taken for each such unknown by itself.
//! Sources: Wood (2010), Nature 466, 1102-1104; MacKay (2003), chapter 28; Kass and Raftery (1995).

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::data::{Compared, Comparison, Data};
use super::hypothesis::Hypothesis;
use super::search::{Effort, Likelihood, Point, search};
use super::slopes::{add, add_square};
use super::unknown::Unknown;
use crate::features::Plan;

/// Median of the share s: a good laboratory repeats to half a per cent. Logarithmic deviation: a factor of three.
const SHARE: f64 = 0.005;
const SHARE_FACTOR: f64 = 3.0;
/// Smallest and largest share.
const SHARES: [f64; 2] = [2e-4, 0.5];
/// A feature that a simulated track lacks counts as so many standard deviations.
const LACKING: f64 = 5.0;
/// Points of a search for the share, and the factor between them from which on a parabola leads to the best, within a third of a nat
/// for two hundred features.
const POINTS: usize = 9;
const NEAR: f64 = 1.35;
/// Share with which a search from the priors' means begins: first tracks are off by several per cent.
pub const FIRST_SHARE: f64 = 0.05;
/// Change of the share in one round, at most: a factor.
const SHARE_STEP: f64 = 3.0;
/// Factor of the share within which a round has not changed it.
const SETTLED: f64 = 1.05;

/// What features of one release are weighed by.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Rows are eigenvectors of the scaled covariance; its eigenvalues; its diagonal.
    rotation: DMatrix<f64>,
    variances: DVector<f64>,
    own: DVector<f64>,
}

impl Weights {
    /// From the covariance of the features of a plan.
    pub fn of(plan: &Plan, covariance: &DMatrix<f64>) -> Self {
        let n = plan.features.len();
        let scaled = |a: usize, b: usize| {
            let value = covariance[(a, b)] / (plan.scales[a] * plan.scales[b]);
            if value.is_finite() { value } else { 0.0 }
        };
        let scaled = DMatrix::from_fn(n, n, scaled);
        let own = scaled.diagonal();
        let eigen = SymmetricEigen::new(scaled);
        let variances = eigen.eigenvalues.map(|value| value.max(0.0));
        Self { rotation: eigen.eigenvectors.transpose(), variances, own }
    }

    /// Standard deviation of a feature over its scale, of its noise and a share together.
    pub fn deviation(&self, f: usize, share: f64) -> f64 {
        (self.own[f] + share * share).sqrt()
    }
}

/// Differences and slopes of one release in the eigenvectors of the noise.
struct Rotated<'a> {
    difference: DVector<f64>,
    places: &'a [usize],
    slopes: DMatrix<f64>,
    weights: &'a Weights,
}

/// A hypothesis at one point, weighed by features.
#[derive(Clone)]
pub struct Fit {
    pub hypothesis: Arc<Hypothesis>,
    /// Where, and how it compares there.
    pub at: Point,
    pub share: f64,
    /// Logarithm of the evidence by features.
    pub evidence: f64,
}

impl Fit {
    /// At a point, with the best share near another one.
    pub fn at(data: &Data, hypothesis: &Arc<Hypothesis>, at: Point, near: f64) -> Self {
        let unknowns = &hypothesis.unknowns;
        let (evidence, share) = evidence(&at.seen.features, &data.weights, unknowns, &at.z, near, SHARE_STEP);
        Self { hypothesis: hypothesis.clone(), at, share, evidence }
    }

    /// The optimum by features from a point that has its own slopes.
    pub fn by_features(
        data: &Data,
        hypothesis: &Arc<Hypothesis>,
        start: Point,
        share: f64,
        effort: Effort,
    ) -> Option<Self> {
        let (at, share) = search(&Features, data, hypothesis, start, share, effort)?;
        Some(Self::at(data, hypothesis, at, share))
    }
}

/// Features as what a search compares; the scale is the share.
pub struct Features;

impl Likelihood for Features {
    type Scale = f64;
    const LONGEST: f64 = 2.0;

    fn expanded(&self, data: &Data, seen: &Comparison, z: &DVector<f64>, share: &f64) -> Expanded {
        expand(&seen.features, &data.weights, z, *share)
    }

    fn scale(
        &self,
        data: &Data,
        hypothesis: &Hypothesis,
        seen: &Comparison,
        z: &DVector<f64>,
        near: &f64,
    ) -> f64 {
        evidence(&seen.features, &data.weights, &hypothesis.unknowns, z, *near, SHARE_STEP).1
    }

    fn is_settled(&self, before: &f64, after: &f64) -> bool {
        (after / before).ln().abs() < SETTLED.ln()
    }
}

/// A quadratic expansion of the exponent at one point and one share.
pub struct Expanded {
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

fn rotated<'a>(compared: &'a Compared, weights: &'a [Weights], share: f64) -> Vec<Rotated<'a>> {
    let of = |(r, weights): (usize, &'a Weights)| {
        let places = &compared.slopes[r].places;
        let (mut difference, mut slopes) =
            (compared.differences[r].clone(), compared.slopes[r].matrix.clone());
        for f in 0..difference.len() {
            if !difference[f].is_finite() {
                difference[f] = LACKING * weights.deviation(f, share);
                slopes.row_mut(f).fill(0.0);
            }
            // A slope that cannot be had says nothing.
            slopes.row_mut(f).iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
        }
        let (difference, slopes) = (&weights.rotation * difference, &weights.rotation * slopes);
        Rotated { difference, places, slopes, weights }
    };
    weights.iter().enumerate().map(of).collect()
}

fn expanded(rotated: &[Rotated], z: &DVector<f64>, share: f64) -> Expanded {
    let n = z.len();
    let (mut cost, mut gradient) = (0.5 * z.norm_squared(), z.clone());
    let mut hessian = DMatrix::identity(n, n);
    for own in rotated {
        let weight = own.weights.variances.map(|variance| (variance + share * share).recip());
        let weighted = own.difference.component_mul(&weight);
        cost += 0.5 * own.difference.dot(&weighted);
        add(&mut gradient, own.places, 1.0, &own.slopes.tr_mul(&weighted));
        let mut rows = own.slopes.clone();
        rows.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weight));
        add_square(&mut hessian, own.places, 1.0, &(own.slopes.transpose() * rows));
    }
    Expanded { cost, gradient, hessian }
}

/// Cost and derivatives at `z` for a share.
pub fn expand(compared: &Compared, weights: &[Weights], z: &DVector<f64>, share: f64) -> Expanded {
    expanded(&rotated(compared, weights, share), z, share)
}

/// What the share costs by itself: its prior, and the volume of the likelihood.
fn volume(weights: &[Weights], share: f64) -> f64 {
    let deviations = (share / SHARE).ln() / SHARE_FACTOR.ln();
    let logarithms = weights.iter().flat_map(|own| own.variances.iter()).map(|v| (v + share * share).ln());
    -0.5 * logarithms.sum::<f64>() - 0.5 * deviations * deviations
}

/// Logarithm of the evidence at a point near the optimum, and the share for which it is largest, within a factor of `reach`
/// of a share.
pub fn evidence(
    compared: &Compared,
    weights: &[Weights],
    unknowns: &[Unknown],
    z: &DVector<f64>,
    near: f64,
    reach: f64,
) -> (f64, f64) {
    let rotated = rotated(compared, weights, near);
    let is_half: Vec<bool> = unknowns.iter().map(|own| own.is_half).collect();
    let of = |share: f64| laplace(&expanded(&rotated, z, share), z, &is_half) + volume(weights, share);
    best_share(near, reach, &of)
}

/// The largest value over shares about one, and that share.
fn best_share(near: f64, reach: f64, of: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let (low, high) = ((near / reach).max(SHARES[0]), (near * reach).min(SHARES[1]));
    if low >= high || near.is_nan() {
        return (of(near), near);
    }
    let step = (high / low).ln() / (POINTS - 1) as f64;
    if step > NEAR.ln() {
        let coarse = (0..POINTS).map(|k| low * (k as f64 * step).exp());
        let (_, best) = coarse
            .map(|share| (of(share), share))
            .fold((f64::NEG_INFINITY, near), |best, own| if own.0 > best.0 { own } else { best });
        return best_share(best, step.exp(), of);
    }
    let at = |k: f64| low * (k * step).exp();
    let values: Vec<f64> = (0..POINTS).map(|k| of(at(k as f64))).collect();
    let better = |best: usize, k: usize| if values[k] > values[best] { k } else { best };
    let k = (1..POINTS).fold(0, better);
    if k == 0 || k == POINTS - 1 {
        return (values[k], at(k as f64));
    }
    // The vertex of the parabola through three points.
    let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
    let bend = a - 2.0 * b + c;
    let aside = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    (b - 0.25 * (a - c) * aside, at(k as f64 + aside))
}

impl Expanded {
    /// Whether an unknown of one sign is held at zero, where the exponent rises.
    pub fn is_held(&self, k: usize, z: &DVector<f64>, is_half: &[bool]) -> bool {
        is_half[k] && z[k] <= 0.0 && self.gradient[k] > 0.0
    }
}

/// Laplace's approximation of `ln ∫ exp(−exponent) dz` over `(2π)^(n/2)`, twice that for each half-normal unknown, from the
/// expansion of the exponent at `z`. An unknown that is held at its bound has an integral of its own, given the others. Very low where
/// the curvature is no maximum.
pub fn laplace(at: &Expanded, z: &DVector<f64>, is_half: &[bool]) -> f64 {
    let (held, free): (Vec<usize>, Vec<usize>) = (0..z.len()).partition(|k| at.is_held(*k, z, is_half));
    let columns = at.hessian.select_columns(&free);
    let Some(factors) = columns.select_rows(&free).cholesky() else { return f64::NEG_INFINITY };
    let gradient = at.gradient.select_rows(&free);
    let step = factors.solve(&gradient);
    let half_logarithm: f64 = factors.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
    let mut value = -at.cost + 0.5 * gradient.dot(&step) - half_logarithm;
    for k in held {
        let coupled = columns.row(k).transpose();
        let bend = at.hessian[(k, k)] - coupled.dot(&factors.solve(&coupled));
        let slope = at.gradient[k] - coupled.dot(&step);
        value += 2f64.ln() - 0.5 * bend.ln() + 0.5 * slope * slope / bend + ln_normal(-slope / bend.sqrt());
    }
    for (place, k) in free.iter().enumerate().filter(|(_, k)| is_half[**k]) {
        let mut own = DVector::zeros(free.len());
        own[place] = 1.0;
        let deviation = factors.l_dirty().solve_lower_triangular(&own).map_or(f64::NAN, |own| own.norm());
        value += 2f64.ln() + ln_normal((z[*k] - step[place]) / deviation);
    }
    value
}

/// Logarithm of the normal distribution function. Source: Press et al., Numerical Recipes, `erfcc`: 1.2e-7 relative.
pub fn ln_normal(x: f64) -> f64 {
    const TERMS: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let y = x.abs() / 2f64.sqrt();
    let t = 1.0 / (1.0 + 0.5 * y);
    let polynomial = TERMS.iter().rev().fold(0.0, |sum, term| sum * t + term);
    // Logarithm of half of erfc(y).
    let tail = t.ln() - y * y + polynomial - 2f64.ln();
    if x < 0.0 { tail } else { (-tail.exp()).ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::super::slopes::Slopes;
    use super::*;

    /// `∫ N(y; x, σ²) N(x; 0, 1) dx = N(y; 0, 1 + σ²)`, and twice the share of the posterior above zero over half a normal
    /// prior: against a sum over a fine grid.
    #[test]
    fn evidence_of_a_linear_model_is_the_integral() {
        let slopes = [[1.3, -0.4], [0.2, 0.9], [-0.7, 0.5]];
        let data = [0.8, -1.9, 0.3];
        let variance = 0.3;
        let cost = |z: &[f64; 2]| {
            let misses = slopes.iter().zip(&data).map(|(s, y)| s[0] * z[0] + s[1] * z[1] - y);
            misses.map(|miss| 0.5 * miss * miss / variance).sum::<f64>() + 0.5 * (z[0] * z[0] + z[1] * z[1])
        };
        for is_half in [[false, false], [false, true]] {
            let step = 0.02;
            let grid = |k: i32| step * (f64::from(k) + 0.5);
            let mut sum = 0.0;
            for a in -400..400 {
                for b in (if is_half[1] { 0 } else { -400 })..400 {
                    sum += (-cost(&[grid(a), grid(b)])).exp() * step * step;
                }
            }
            let due = (sum / std::f64::consts::TAU * if is_half[1] { 2.0 } else { 1.0 }).ln();
            // From a point that is not the optimum, the expansion of a quadratic is the same; at a bound as well.
            for z in [[0.1, 0.0], [2.0, 0.0], [0.5, 0.4]] {
                let jacobian = DMatrix::from_fn(3, 2, |r, c| slopes[r][c]);
                let at = DVector::from_column_slice(&z);
                let miss = &jacobian * &at - DVector::from_column_slice(&data);
                let expanded = Expanded {
                    cost: cost(&z),
                    gradient: jacobian.tr_mul(&miss) / variance + &at,
                    hessian: jacobian.tr_mul(&jacobian) / variance + DMatrix::identity(2, 2),
                };
                let found = laplace(&expanded, &at, &is_half);
                assert!((found - due).abs() < 1e-3, "{found}, due {due}");
            }
        }
    }

    #[test]
    fn the_normal_distribution_has_its_tails() {
        for (x, due) in
            [(0.0, -std::f64::consts::LN_2), (-3.0, -6.607_726_2), (-10.0, -53.231_285), (2.0, -0.023_012_9)]
        {
            assert!((ln_normal(x) / due - 1.0).abs() < 1e-5, "{x}: {}", ln_normal(x));
        }
    }

    /// With one number for all, the share whose prior and likelihood are largest lies at the spread of the differences, pulled
    /// by the prior; the covariance is diagonal in the eigenvectors for any share.
    #[test]
    fn the_share_follows_the_misfit() {
        let n = 400;
        let weights = Weights {
            rotation: DMatrix::identity(n, n),
            variances: DVector::zeros(n),
            own: DVector::zeros(n),
        };
        let sign = |k: usize| if k.is_multiple_of(2) { 0.02 } else { -0.02 };
        let compared = Compared {
            differences: vec![DVector::from_fn(n, |k, _| sign(k))],
            slopes: vec![Slopes { places: Vec::new(), matrix: DMatrix::zeros(n, 0) }].into(),
        };
        let (_, share) = evidence(&compared, &[weights], &[], &DVector::zeros(0), 0.01, 30.0);
        assert!((share - 0.02).abs() < 5e-4, "{share}");
    }
}
