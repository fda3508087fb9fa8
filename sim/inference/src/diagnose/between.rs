//! How much the parameters of an effect differ between releases, and what that adds to their errors.
//!
//! Let a parameter have the value θ + δ_r in release r, with independent δ_r of standard deviation τ. A fit of one value to
//! all releases then has the variance `c τ²` beside that of the noise. c is the sum of the squared weights of the releases in
//! that value: 1/n for n releases of equal weight.
//!
//! τ follows from the score vector of the releases' own values at the fit. Along the eigenvectors of its Gram matrix, in units
//! of the noise, the components y_k of the score vector are independent and have the variances `1 + τ² λ_k`, with λ_k the
//! eigenvalues over the noise. The prior of τ is uniform up to the share of the size beyond which an effect is not believed
//! (`constancy.rs`), and the posterior mean of τ² is taken. With one release nothing is known of τ, and the interval is that
//! of this release.
//!
//! Source: Harville (1977), Journal of the American Statistical Association 72, 320-338, for the variance beside a fitted
//! mean; Gelman (2006), Bayesian Analysis 1, 515-534, for the uniform prior.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::candidate::Candidate;
use super::constancy::UNLIKE;
use super::design_matrix::of_releases;
use super::refit::places_of;
use super::score::{Pulls, RESOLVED, followed, pick};
use crate::calibrate::joint::Joint;
use crate::calibrate::unknowns::Group;

/// Standard error of each scaled unknown of a fit that comes from differences between releases, beside that of the noise. It is
/// zero except for parameters of the candidates' effects. `all` is a fit of the same model to these releases and any held-out
/// ones.
pub(super) fn between_releases<'a>(
    fit: &Joint,
    all: &Joint,
    candidates: impl IntoIterator<Item = &'a Candidate>,
) -> Vec<f64> {
    let known = all.known();
    let mut errors = vec![0.0; fit.found.x.len()];
    for candidate in candidates {
        for place in places_of(fit, candidate) {
            let own = &fit.objective.part.unknowns[place];
            if matches!(own.group, Group::Release(_)) {
                continue;
            }
            let null_value = if own.name == candidate.path() { candidate.null_value } else { 0.0 };
            let size = (own.scaled.value(fit.found.x[place]) - null_value).abs();
            let there = known.iter().position(|known| known.is(own));
            if let Some(variance) = there.and_then(|there| variance(all, there, UNLIKE * size)) {
                let weights = followed(fit, &of_releases(fit, place, 0));
                errors[place] = (weights.row(place).norm_squared() * variance).sqrt();
            }
        }
    }
    errors
}

/// The posterior mean of τ² of an unknown in units of its value, with τ up to `most`; none where only one release has it.
fn variance(fit: &Joint, place: usize, most: f64) -> Option<f64> {
    let columns = of_releases(fit, place, 0);
    if columns.len() < 2 {
        return None;
    }
    let pulls = Pulls::of(fit, &columns, |_| RESOLVED);
    let own = pulls.own(0..columns.len());
    let score_vector = DVector::from_fn(own.len(), |k, _| pulls.score_vector[own[k]]);
    let parts = parts(pick(&pulls.gram, &own, &own), &score_vector, pulls.variance_inflation);
    Some(mean_square(&parts, most))
}

/// y² and λ of each independent component of a score vector; none where no release shows its own value.
fn parts(gram: DMatrix<f64>, score_vector: &DVector<f64>, noise: f64) -> Vec<(f64, f64)> {
    if gram.is_empty() {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(gram);
    let largest = eigen.eigenvalues.amax();
    let parts = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    // Along the mean, which is fitted, there are only errors of slopes.
    let parts = parts.filter(|(value, _)| **value > RESOLVED * largest);
    let part = |(value, vector): (&f64, _)| {
        let pull: f64 = score_vector.dot(&vector);
        (pull * pull / (noise * value), value / noise)
    };
    parts.map(part).collect()
}

/// Points at which the probability density of τ is summed.
const POINTS: usize = 200;

/// Posterior mean of τ² from components with such y² and λ, with a uniform prior of τ up to `most`.
fn mean_square(parts: &[(f64, f64)], most: f64) -> f64 {
    let squares = (0..POINTS).map(|k| (most * (k as f64 + 0.5) / POINTS as f64).powi(2));
    let logarithm = |square: f64| {
        let of_part = |(y, lambda): &(f64, f64)| {
            let variance = 1.0 + square * lambda;
            variance.ln() + y / variance
        };
        -0.5 * parts.iter().map(of_part).sum::<f64>()
    };
    let of_each: Vec<(f64, f64)> = squares.map(|square| (square, logarithm(square))).collect();
    let likeliest = of_each.iter().map(|own| own.1).fold(f64::NEG_INFINITY, f64::max);
    let sum = |of: fn(f64) -> f64| -> f64 {
        of_each.iter().map(|(square, logarithm)| of(*square) * (logarithm - likeliest).exp()).sum()
    };
    sum(|square| square) / sum(|_| 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::constancy::tests::fitted;

    /// With a scale of 0.01 τ is at most 0.002. Three releases that differ by 0.005 give nearly that over the root of three; three
    /// equal ones give less than the prior alone.
    #[test]
    fn the_mean_of_three_is_as_well_known_as_they_are_alike() {
        let error = |scales| {
            let (fit, scale) = fitted(scales);
            let place = fit.known().iter().position(|own| own.unknown.name == scale.path()).unwrap();
            let own = &fit.known()[place];
            between_releases(&fit, &fit, [&scale])[place] * own.unknown.scaled.slope(own.x)
        };
        let (alike, unlike) = (error([0.01; 3]), error([0.005, 0.01, 0.015]));
        let most = 0.002 / 3f64.sqrt();
        assert!((0.85 * most..1.01 * most).contains(&unlike), "{unlike} of {most}");
        assert!(alike < most / 3f64.sqrt(), "{alike} of {most}");
    }

    /// Two releases, 1 above and 1 below their mean, have one component: their difference. An empty matrix has none.
    #[test]
    fn two_releases_have_one_component() {
        let gram = DMatrix::from_row_slice(2, 2, &[0.5, -0.5, -0.5, 0.5]);
        let score_vector = &gram * DVector::from_column_slice(&[1.0, -1.0]);
        let found = parts(gram, &score_vector, 2.0);
        assert_eq!(found.len(), 1);
        assert!((found[0].0 - 1.0).abs() < 1e-12 && (found[0].1 - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(parts(DMatrix::zeros(0, 0), &DVector::zeros(0), 1.0), []);
    }

    /// Components without information leave the prior, a third of the square of its end. Many components tell 0.1 from zero.
    #[test]
    fn many_components_determine_the_spread() {
        assert!((mean_square(&[], 0.2) - 0.04 / 3.0).abs() < 1e-6);
        assert!((mean_square(&[(1.0, 1e-6)], 0.2) - 0.04 / 3.0).abs() < 1e-6);
        let (found, none) = (mean_square(&[(101.0, 1e4); 100], 0.3), mean_square(&[(1.0, 1e4); 100], 0.3));
        assert!((found - 0.01).abs() < 1e-3, "{found}");
        assert!(none < 1e-4, "{none}");
    }
}
