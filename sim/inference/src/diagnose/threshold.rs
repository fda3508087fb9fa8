//! The threshold of scores: the quantile of the largest one where nothing is missing, from draws.

use nalgebra::{DMatrix, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;

use super::score::{Score, Subject, Weight, pick};
use crate::normal::{normal, root};

/// Draws of the law of the largest score.
const DRAWS: usize = 20_000;
/// Blocks that they are made in, each with its own seed.
const BLOCKS: usize = 20;
const SEED: u64 = 20_220_517;

/// The quantile of the largest score where nothing is missing.
pub(super) fn threshold(
    subjects: &[Subject],
    scores: &[Score],
    weights: &[Weight],
    variance: &DMatrix<f64>,
    false_alarm: f64,
) -> f64 {
    // Of a column that is not scored, next to nothing is left beside the fit, and its correlations are rounding.
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
            if !subjects[c].admits(&own, &weights[c]) {
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

    /// Two columns of which one is 1e12 times as large: the threshold is that of two normal numbers, of which one exceeds
    /// 2.806 once in a hundred.
    #[test]
    fn a_column_of_another_size_sets_no_threshold() {
        // Another column is nearly the large one: the covariance then has an eigenvalue of nearly zero.
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
