//! The threshold of scores: the quantile of the largest one where nothing is missing, from draws.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;

use super::score::{Score, Subject, Weight, pick};
use crate::normal::normal;

/// Draws of the law of the largest score.
const DRAWS: usize = 20_000;
/// Blocks that they are made in, each with its own seed.
const BLOCKS: usize = 20;
const SEED: u64 = 20_220_517;

/// What takes independent normal numbers to ones of this covariance. It is taken of the correlations: columns have very
/// different sizes, and of the covariance itself the small ones would be drawn with the rounding of the large ones.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let deviations = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let correlation = |a: usize, b: usize| match deviations[a] * deviations[b] {
        // Rounding has left nothing of it.
        0.0 => 0.0,
        both => (covariance[(a, b)] / both).clamp(-1.0, 1.0),
    };
    let correlations = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), correlation);
    let eigen = SymmetricEigen::new(correlations);
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    DMatrix::from_diagonal(&deviations) * &eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}

/// The quantile of the largest score where nothing is missing.
pub(super) fn threshold(
    subjects: &[Subject],
    scores: &[Score],
    weights: &[Weight],
    variance: &DMatrix<f64>,
    false_alarm: f64,
) -> f64 {
    // Of the columns that are scored alone: of another next to nothing is left beside the fit, and its correlations are
    // rounding.
    let scored: Vec<usize> = scores.iter().flat_map(|score| score.columns.iter().copied()).collect();
    let root = root(&pick(variance, &scored, &scored));
    let begins: Vec<usize> = scores
        .iter()
        .scan(0, |next, score| Some(std::mem::replace(next, *next + score.columns.len())))
        .collect();
    let draw = |random: &mut Xoshiro256PlusPlus| {
        let score_vector = &root * DVector::from_fn(scored.len(), |_, _| normal(random));
        let of = |(c, score): (usize, &Score)| {
            let own = score_vector.rows(begins[c], score.columns.len()).into_owned();
            let estimate = subjects[c].null_value + own.iter().next().copied().unwrap_or(0.0);
            if !subjects[c].admits(own.len(), estimate) {
                return 0.0;
            }
            weights[c].size(&own)
        };
        scores.iter().enumerate().map(of).fold(0.0, f64::max)
    };
    let block = |block: usize| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED + block as u64);
        (0..DRAWS / BLOCKS).map(|_| draw(&mut random)).collect::<Vec<f64>>()
    };
    let mut largest: Vec<f64> = (0..BLOCKS).into_par_iter().flat_map_iter(block).collect();
    largest.sort_by(f64::total_cmp);
    let place = ((1.0 - false_alarm) * DRAWS as f64) as usize;
    largest[place.min(DRAWS - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns of which one is 1e12 times as large: the threshold is that of two normal numbers, which exceed
    /// 2.806 once in a hundred.
    #[test]
    fn a_column_of_another_size_sets_no_threshold() {
        // Nearly one with the large one, as two columns of a model are: their small ones come from rounding.
        let variance = DMatrix::from_row_slice(
            3,
            3,
            &[1.0, 1.0 - 1e-9, 1e-13, 1.0 - 1e-9, 1.0, 1e-13, 1e-13, 1e-13, 1e-24],
        );
        let score = |k: usize| Score { columns: vec![k], degrees: 1.0, ..Score::default() };
        let (subjects, each) = ([Subject::default(); 2], [0, 2].map(score));
        let weights = [0, 2]
            .map(|k| subjects[0].weight(&pick(&variance, &[k], &[k]), &pick(&variance, &[k], &[k]), 1.0));
        let found = threshold(&subjects, &each, &weights, &variance, 0.01);
        assert!((found - 2.806).abs() < 0.05, "{found}");
    }
}
