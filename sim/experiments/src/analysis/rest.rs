//! Where a tip that still swings will come to rest, and how well that is known.
//!
//! The mean of the last second is not it: a recording rarely ends after a whole period, and a large swing is not
//! centred on its rest. So the decay itself is fitted to the last three periods, both coordinates together:
//!
//! ```text
//! r + a e(t) + b e(t)²,   a: cos ωt, sin ωt;   b: 1, cos 2ωt, sin 2ωt;   e(t) = exp(−δt)
//! ```
//!
//! The terms in e² are those of any smooth path and any quadratic nonlinearity: a second harmonic, and a mean that
//! moves with the square of the amplitude. What the next order, e³, would change is part of the error.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::nelder_mead::minimize;

/// Periods at the end that are fitted.
const PERIODS: f64 = 3.0;
/// Share of the first excursion below which a swing is over: the usual 2 % of settling times.
pub const SETTLED: f64 = 0.02;
/// Factors by which frequency and decay rate may move from their start.
const ROOM: [[f64; 2]; 2] = [[0.8, 1.25], [0.0, 5.0]];

/// A rest that was estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestEstimate {
    /// Position in W, m.
    pub position: [f64; 2],
    /// Standard error of each coordinate, m: noise, and what higher orders of the swing may change.
    pub error: [f64; 2],
    /// Amplitude of the swing that is left at the end, m.
    pub swing_left: f64,
}

impl RestEstimate {
    /// Whether the swing is over, by the first excursion, m.
    pub fn is_settled(&self, first: f64) -> bool {
        self.swing_left <= SETTLED * first
    }

    /// The larger of both standard errors, m.
    pub fn largest_error(&self) -> f64 {
        self.error[0].max(self.error[1])
    }
}

/// The rest of a path up to a time, s; damped frequency, rad/s, and rate of decay, 1/s, are where the fit begins.
///
/// None where fewer than three samples for each term are seen in the last three periods, and where these do not
/// determine the rest: without a decay no constant is distinguished from another, and the answer is anywhere.
pub fn estimate(
    time: &[f64],
    position: &[Option<[f64; 2]>],
    until: f64,
    damped_frequency: f64,
    decay_rate: f64,
) -> Option<RestEstimate> {
    let from = (until - PERIODS * TAU / damped_frequency).max(0.0);
    let is_late = |t: f64| (from..=until).contains(&t);
    let seen: Vec<(f64, [f64; 2])> =
        time.iter().zip(position).filter_map(|(t, at)| Some((*t - until, (*at)?))).collect();
    let seen: Vec<_> = seen.into_iter().filter(|(t, _)| is_late(t + until)).collect();
    if seen.len() < 3 * terms(2) {
        return None;
    }
    let times: Vec<f64> = seen.iter().map(|(t, _)| *t).collect();
    let right = DMatrix::from_fn(seen.len(), 2, |i, k| seen[i].1[k]);
    // A decay rate that is not there yet is looked for from a hundredth of the frequency on.
    let start = [damped_frequency, decay_rate.max(0.01 * damped_frequency)];
    let at = |p: &[f64]| [start[0] * p[0], start[1] * p[1]];
    let scale = right.row_iter().map(|row| (row - right.row(0)).norm_squared()).sum::<f64>();
    let cost = |p: &[f64]| {
        let is_inside = p.iter().zip(ROOM).all(|(p, [low, high])| (low..=high).contains(p));
        let fit = is_inside.then(|| Fit::new(&times, &right, at(p), 2)).flatten();
        fit.map_or(f64::INFINITY, |fit| fit.residual.norm_squared() / scale.max(f64::MIN_POSITIVE))
    };
    // Where nothing swings any more there is no minimum, and any frequency will do.
    let found = minimize(&[1.0, 1.0], cost).map_or(start, |minimum| at(&minimum.parameters));
    let fit = Fit::new(&times, &right, found, 2)?;
    let next = Fit::new(&times, &right, found, 3)?;
    let noise = fit.standard_errors(&times, found)?;
    let (position, of_next) = (fit.rest(), next.rest());
    let error = [0, 1].map(|k| noise[k].hypot(of_next[k] - position[k]));
    // A swing passes its rest. So it lies in what is seen of the path, within its error, and an error as large as that
    // says less than the mean does.
    let is_told = (0..2).all(|k| {
        let column = right.column(k);
        let (low, high) = (column.min(), column.max());
        let outside = (low - position[k]).max(position[k] - high).max(0.0);
        error[k] <= high - low && outside <= 3.0 * error[k]
    });
    is_told.then_some(RestEstimate {
        position,
        error,
        swing_left: [0, 1]
            .map(|k| fit.terms[(1, k)].hypot(fit.terms[(2, k)]))
            .iter()
            .fold(0.0, |a, b| a.hypot(*b)),
    })
}

/// Terms of a fit up to an order.
fn terms(order: i32) -> usize {
    if order == 2 { 6 } else { 10 }
}

/// The terms at a time, with frequency and decay rate.
fn row(t: f64, [omega, delta]: [f64; 2], order: i32) -> Vec<f64> {
    let wave = |k: f64| (k * omega * t).sin_cos();
    let ((s1, c1), (s2, c2), (s3, c3)) = (wave(1.0), wave(2.0), wave(3.0));
    let e = (-delta * t).exp();
    let mut all = vec![1.0, e * c1, e * s1, e * e, e * e * c2, e * e * s2];
    if order > 2 {
        all.extend([c3, s3, c1, s1].map(|wave| e.powi(3) * wave));
    }
    all
}

/// A linear least-squares fit at a frequency and a decay rate.
struct Fit {
    matrix: DMatrix<f64>,
    /// Coefficients, a column for each coordinate.
    terms: DMatrix<f64>,
    residual: DMatrix<f64>,
}

impl Fit {
    fn new(times: &[f64], right: &DMatrix<f64>, at: [f64; 2], order: i32) -> Option<Self> {
        let rows: Vec<f64> = times.iter().flat_map(|t| row(*t, at, order)).collect();
        let matrix = DMatrix::from_row_slice(times.len(), terms(order), &rows);
        let terms = matrix.clone().svd(true, true).solve(right, 1e-10).ok()?;
        let residual = right - &matrix * &terms;
        Some(Self { matrix, terms, residual })
    }

    fn rest(&self) -> [f64; 2] {
        [self.terms[(0, 0)], self.terms[(0, 1)]]
    }

    /// Standard errors of the rest, frequency and decay rate being fitted as well; residuals that follow one another
    /// count as fewer.
    fn standard_errors(&self, times: &[f64], at: [f64; 2]) -> Option<[f64; 2]> {
        let (n, k) = self.matrix.shape();
        let mut slopes = DMatrix::zeros(2 * n, 2 * k + 2);
        for axis in 0..2 {
            slopes.view_mut((axis * n, axis * k), (n, k)).copy_from(&self.matrix);
        }
        for (which, value) in at.iter().enumerate() {
            let step = 1e-6 * value.abs().max(1e-3);
            let mut moved = at;
            moved[which] += step;
            for (i, t) in times.iter().enumerate() {
                let change = DVector::from_vec(row(*t, moved, 2)) - self.matrix.row(i).transpose();
                for axis in 0..2 {
                    slopes[(axis * n + i, 2 * k + which)] = change.dot(&self.terms.column(axis)) / step;
                }
            }
        }
        let freedom = (2 * n).checked_sub(2 * k + 2).filter(|left| *left > 0)? as f64;
        let square = self.residual.norm_squared();
        let together: f64 = (0..2)
            .map(|axis| {
                let column = self.residual.column(axis);
                column.rows(0, n - 1).dot(&column.rows(1, n - 1))
            })
            .sum();
        let correlation = if square > 0.0 { (together / square).clamp(0.0, 0.9) } else { 0.0 };
        let variance = square / freedom * (1.0 + correlation) / (1.0 - correlation);
        // Columns of very different size, and none where nothing swings: the pseudo-inverse of what is scaled.
        let size: Vec<f64> = slopes.column_iter().map(|column| column.norm()).collect();
        let unit = |k: usize| if size[k] > 0.0 { size[k].recip() } else { 0.0 };
        let scaled = DMatrix::from_fn(2 * n, 2 * k + 2, |i, j| slopes[(i, j)] * unit(j));
        let inverse = (scaled.transpose() * scaled).pseudo_inverse(1e-10).ok()?;
        let of = |column: usize| (variance * inverse[(column, column)]).max(0.0).sqrt() * unit(column);
        Some([of(0), of(k)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::tests::Noise;

    /// A tip on an arc of 250 mm whose angle decays about −72°: the path is bent, so its mean moves with the square of
    /// the amplitude. Noise of 0.3 mm.
    fn swing(seconds: f64, seed: u64) -> (Vec<f64>, Vec<Option<[f64; 2]>>, [f64; 2]) {
        let mut noise = Noise::new(seed);
        let angle = |t: f64| -1.257 + 0.9 * (-0.32 * t).exp() * (7.1 * t).cos();
        let on_arc = |angle: f64| [0.25 * angle.cos(), 0.25 * angle.sin()];
        let time: Vec<f64> = (0..(100.0 * seconds) as usize).map(|i| 0.01 * i as f64).collect();
        let position = time
            .iter()
            .enumerate()
            .map(|(i, t)| (i % 40 > 3).then(|| on_arc(angle(*t)).map(|at| at + 3e-4 * noise.normal())));
        let position = position.collect();
        (time, position, on_arc(-1.257))
    }

    /// After 8 s it swings by 17 mm still: the mean of the last 0.75 s is millimetres off, the estimate is right within
    /// its errors, and these are small.
    #[test]
    fn a_rest_is_found_while_the_tip_still_swings() {
        let mut within = 0;
        for seed in 1..=20 {
            let (time, position, truth) = swing(8.0, seed);
            let found = estimate(&time, &position, 8.0, 7.2, 0.3).unwrap();
            assert!(!found.is_settled(0.2) && (found.swing_left / 0.0174 - 1.0).abs() < 0.05, "{found:?}");
            assert!(found.largest_error() < 2e-4, "{found:?}");
            within += [0, 1]
                .iter()
                .filter(|k| (found.position[**k] - truth[**k]).abs() < 2.0 * found.error[**k])
                .count();
            let late = position[725..].iter().flatten();
            let count = late.clone().count() as f64;
            let mean = [0, 1].map(|k| late.clone().map(|at| at[k]).sum::<f64>() / count);
            assert!((mean[0] - truth[0]).hypot(mean[1] - truth[1]) > 1e-3, "{mean:?} for {truth:?}");
        }
        // Of 40 numbers two standard errors hold 38 in the mean, and fewer than 34 in one of a hundred trials.
        assert!(within >= 34, "{within} of 40");
    }

    /// A hand, or a valve, that moves all the time makes no decay; neither does a swing that grows.
    #[test]
    fn what_does_not_decay_tells_no_rest() {
        let time: Vec<f64> = (0..291).map(|i| 0.01 * f64::from(i)).collect();
        let path = |growth: f64| -> Vec<_> {
            let at =
                |t: f64| [0.2 + 1e-4 * t, -0.05 + 4e-4 * t + 2e-5 * (growth * t).exp() * (16.9 * t).cos()];
            time.iter().map(|t| Some(at(*t))).collect()
        };
        for growth in [0.0, 0.2] {
            if let Some(found) = estimate(&time, &path(growth), 2.9, 16.9, 0.0) {
                let off = (found.position[1] + 0.0488).abs();
                assert!(off < 1e-3 && found.largest_error() < 1e-3, "{growth}: {found:?}");
            }
        }
    }

    /// Long after the swing is over nothing is left but noise.
    #[test]
    fn a_tip_at_rest_is_settled_and_known_to_its_noise() {
        let (time, position, truth) = swing(30.0, 3);
        let found = estimate(&time, &position, 30.0, 7.2, 0.3).unwrap();
        assert!(found.is_settled(0.2) && found.largest_error() < 2e-4, "{found:?}");
        let off = (found.position[0] - truth[0]).hypot(found.position[1] - truth[1]);
        assert!(off < 3.0 * found.error[0].hypot(found.error[1]), "{found:?} for {truth:?}");
        assert_eq!(estimate(&time[..10], &position[..10], 0.1, 7.2, 0.3), None);
    }
}
