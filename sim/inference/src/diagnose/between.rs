//! By how much a parameter of an effect differs from release to release, and what that adds to the error of their mean.
//!
//! In release r let it be θ + δ_r, with independent δ_r of standard deviation τ. One value for all, fitted, has the
//! error `c τ²` beside that of the noise. c is the sum of the squares of the releases' weights in it: 1/n where n
//! releases say as much.
//!
//! What the residuals ask for in each release, while the fit and its one value have had their way, says how large τ may be.
//! Along the eigenvectors of its Gram matrix, and in units of the noise, the score vector has components y_k. They are
//! independent with variances `1 + τ² λ_k`, with λ_k the eigenvalues over that noise. Before them, τ may be anything up to the
//! share of the size from which on an effect is not believed (`constancy.rs`); its mean square after them is what counts.
//! Of a parameter in one release alone nothing is known: its interval is that of this release.
//!
//! Source: Harville (1977), Journal of the American Statistical Association 72, 320-338, for what is left beside the
//! mean; Gelman (2006), Bayesian Analysis 1, 515-534, for a uniform belief of τ.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::candidate::Candidate;
use super::constancy::UNLIKE;
use super::design_matrix::of_releases;
use super::refit::prefix;
use super::score::{Pulls, RESOLVED, pick};
use crate::calibrate::joint::Joint;
use crate::calibrate::unknowns::Group;

/// Standard error of each scaled unknown of a fit because it differs between releases, beside that of the noise: 0 but for
/// parameters of the effects of candidates. `all` is a fit of the same model to these releases and, where there are any, to
/// held-out ones.
pub(super) fn between_releases<'a>(
    fit: &Joint,
    all: &Joint,
    candidates: impl IntoIterator<Item = &'a Candidate>,
) -> Vec<f64> {
    let mut errors = vec![0.0; fit.found.x.len()];
    for candidate in candidates {
        let prefix = prefix(candidate.name());
        for (place, own) in fit.objective.part.unknowns.iter().enumerate() {
            let is_asked = own.name.starts_with(&prefix) && !matches!(own.group, Group::Release(_));
            if !is_asked {
                continue;
            }
            let null_value = if own.name == candidate.path() { candidate.null_value } else { 0.0 };
            let size = (own.scaled.value(fit.found.x[place]) - null_value).abs();
            let unknowns = &all.objective.part.unknowns;
            let there =
                unknowns.iter().position(|other| (&other.name, other.group) == (&own.name, own.group));
            if let Some(variance) = there.and_then(|there| variance(all, there, UNLIKE * size)) {
                errors[place] = (squared_weights(fit, place) * variance).sqrt();
            }
        }
    }
    errors
}

/// Sum of the squares of what each release adds to the scaled unknown with a unit of its own value.
fn squared_weights(fit: &Joint, place: usize) -> f64 {
    let columns = of_releases(fit, place, 0);
    Pulls::of(fit, &columns, |_| RESOLVED).followed.row(place).norm_squared()
}

/// τ² of an unknown, where τ may be so large at most, both in units of its value; none where one release has it.
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

/// Of each independent part of a score vector: y², and λ. None where no release shows anything by itself.
fn parts(gram: DMatrix<f64>, score_vector: &DVector<f64>, noise: f64) -> Vec<(f64, f64)> {
    if gram.is_empty() {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(gram);
    let largest = eigen.eigenvalues.amax();
    let parts = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    // The mean is fitted, and what is left along it are errors of slopes.
    let parts = parts.filter(|(value, _)| **value > RESOLVED * largest);
    let part = |(value, vector): (&f64, _)| {
        let pull: f64 = score_vector.dot(&vector);
        (pull * pull / (noise * value), value / noise)
    };
    parts.map(part).collect()
}

/// Points at which the probability of τ is taken.
const POINTS: usize = 200;

/// Mean square of τ, uniform up to the most before, after parts with squares y² and their λ.
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

    /// Of a scale of 0.01, τ is 0.002 at most: releases that differ by 0.005 leave nearly that, over the root of three; releases
    /// that are alike leave less than τ has before them.
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

    /// Two releases whose sizes are 1 and -1 from their mean: their difference is one part, with twice the square of that. Nothing
    /// has no part.
    #[test]
    fn two_releases_have_one_part() {
        let gram = DMatrix::from_row_slice(2, 2, &[0.5, -0.5, -0.5, 0.5]);
        let score_vector = &gram * DVector::from_column_slice(&[1.0, -1.0]);
        let found = parts(gram, &score_vector, 2.0);
        assert_eq!(found.len(), 1);
        assert!((found[0].0 - 1.0).abs() < 1e-12 && (found[0].1 - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(parts(DMatrix::zeros(0, 0), &DVector::zeros(0), 1.0), []);
    }

    /// Parts that say nothing leave a third of the square of the most; many that agree on 0.1 leave that; many without
    /// any leave nothing.
    #[test]
    fn parts_say_how_large_it_is() {
        assert!((mean_square(&[], 0.2) - 0.04 / 3.0).abs() < 1e-6);
        assert!((mean_square(&[(1.0, 1e-6)], 0.2) - 0.04 / 3.0).abs() < 1e-6);
        let (found, none) = (mean_square(&[(101.0, 1e4); 100], 0.3), mean_square(&[(1.0, 1e4); 100], 0.3));
        assert!((found - 0.01).abs() < 1e-3, "{found}");
        assert!(none < 1e-4, "{none}");
    }
}
