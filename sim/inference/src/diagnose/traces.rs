//! Traces of effects: how far each would move what is recorded, beside all that the model without it may still adjust.
//!
//! In units of the noise, with slopes J of the model by its unknowns, which have standard normal priors, and columns C, what is
//! left of the columns is `S = CᵀC − CᵀJ (I + JᵀJ)⁻¹ JᵀC`. An effect is seen from `√S_kk` standard deviations on, and separated
//! from another, whose strength is free, by `√(S_kk − S_kj² / S_jj)`.
//! Source: Silvey (1980), Optimal design, chapter 2.

use nalgebra::{DMatrix, DVector};

use super::data::Data;
use super::hypothesis::Hypothesis;
use super::samples::variance;
use super::search::Point;
use super::slopes::add_square;

/// Standard deviations by which two traces are separated, and from which on one is seen.
pub const APART: f64 = 5.0;

/// The difference that an effect makes at a place of its unknowns, over a number, by release, m; none where it cannot be run.
pub fn trace(
    data: &Data,
    at: &Point,
    of: &Hypothesis,
    z: &DVector<f64>,
    over: f64,
) -> Option<Vec<DVector<f64>>> {
    let there = data.compare_with(of, z, &at.seen)?.samples.differences;
    let both = there.iter().zip(&at.seen.samples.differences);
    Some(both.map(|(there, here)| (there - here) / over).collect())
}

/// How much of each trace is left.
pub struct Traces(DMatrix<f64>);

impl Traces {
    /// Of traces beside a model, in releases each of which counts for some alike, all recorded some `times`. `misfit` is the mean
    /// square of each coordinate that does not repeat, m². None where the model's own slopes are none.
    pub fn of(
        data: &Data,
        at: &Point,
        of: &Hypothesis,
        columns: &[Vec<DVector<f64>>],
        (counts, times): (&[usize], u32),
        misfit: f64,
    ) -> Option<Self> {
        let (n, m) = (at.z.len(), columns.len());
        // One release counts for some alike, each with a setup of its own; what all share is shared by all times.
        let prior = |u: usize| {
            let unknown = &of.unknowns[u];
            let count = || unknown.acts.first().and_then(|(r, _)| counts.get(*r));
            if unknown.is_own { count().map_or(1.0, |count| *count as f64) } else { f64::from(times).recip() }
        };
        let mut square = DMatrix::from_diagonal(&DVector::from_fn(n, |u, _| prior(u)));
        let (mut mixed, mut own) = (DMatrix::zeros(n, m), DMatrix::zeros(m, m));
        for (r, plan) in data.plans.iter().enumerate() {
            let weight = counts[r] as f64 / variance(plan, misfit);
            let slopes = &at.seen.samples.slopes[r];
            add_square(&mut square, &slopes.places, weight, &at.seen.squares[r].jj);
            for (k, column) in columns.iter().enumerate() {
                let moved = slopes.matrix.tr_mul(&column[r]);
                slopes.places.iter().zip(&moved).for_each(|(place, own)| mixed[(*place, k)] += weight * own);
                for (l, other) in columns.iter().enumerate().take(k + 1) {
                    own[(k, l)] += weight * column[r].dot(&other[r]);
                    own[(l, k)] = own[(k, l)];
                }
            }
        }
        let left = own - mixed.tr_mul(&square.cholesky()?.solve(&mixed));
        Some(Self(left * f64::from(times)))
    }

    /// Size of a trace, standard deviations.
    pub fn size(&self, k: usize) -> f64 {
        self.0[(k, k)].max(0.0).sqrt()
    }

    /// The same beside another one, whose strength is free.
    pub fn apart(&self, k: usize, other: usize) -> f64 {
        let shared = self.0[(k, other)].powi(2) / self.0[(other, other)].max(f64::MIN_POSITIVE);
        (self.0[(k, k)] - shared).max(0.0).sqrt()
    }
}
