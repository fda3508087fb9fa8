//! What a model misses of a recording, beside the camera's noise.
//!
//! Noise is fresh in each sample; what a model misses goes on to the next. So the autocovariance of the residuals at one
//! sample is the variance d² of what is missed, whatever the noise and single ghosts are. How much of a parameter it
//! takes away depends on how the parameter moves the samples, its slopes s: the pull `Σ s r` of residuals on it has w
//! times the variance that fresh residuals of the same size would give it,
//!
//! ```text
//! w = 1 + 2 Σ (c_k / c_1) (s_k / s_0),   c_k and s_k the autocovariances of residuals and slopes at k samples
//! ```
//!
//! What swings as the slopes do counts many times over; a marker that drifts slowly hardly touches a damping. A fit
//! weighs each sample by `σ² + w d²` instead of the noise's σ² alone, with the largest w of the parameters that are
//! sought. Priors of the setup and of the material count against that, and no sample is held back because the model
//! misses it. Where nothing is missed, nothing changes.
//!
//! Source: Kennedy and O'Hagan (2001), Journal of the Royal Statistical Society B 63, 425-464, for a discrepancy beside
//! the noise; Bayley and Hammersley (1946), Supplement to the same, 8, 184-197, for w.

use efam_experiments::release::Track;

use super::autocorrelation::{Autocovariance, products};
use super::objective::Objective;
use super::refine::CHANGED;
use super::search::Found;
use super::view::Series;

/// What a fit misses of a track.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Missed {
    /// Standard deviation of a coordinate, m; zero where residuals do not go on.
    pub deviation: f64,
    /// Correlation of what is missed at two samples, by their distance from 0 on; zero beyond the last.
    correlation: Vec<f64>,
}

impl Missed {
    /// Samples that share a number of it, for one who moves them by `slopes`.
    fn shared(&self, slopes: &[Option<[f64; 2]>]) -> f64 {
        let at = |lag: usize| products(slopes, lag).0;
        let own = at(0);
        if own <= 0.0 {
            return 0.0;
        }
        let beyond = self.correlation.iter().enumerate().skip(1).map(|(lag, value)| value * at(lag) / own);
        (1.0 + 2.0 * beyond.sum::<f64>()).max(0.0)
    }
}

/// What a fit misses of a track with the noise of its residuals' unit, m; `samples` are their places in the recording.
pub(super) fn missed(series: &Series, samples: &[usize], noise: f64) -> Missed {
    let found = Autocovariance::of(&on_grid(series, samples, |k| series.residual[k]));
    let Some(next) = found.by_lag.get(1).copied().filter(|next| *next > 0.0) else {
        return Missed::default();
    };
    let beyond = found.by_lag.iter().skip(1).map(|own| own / next);
    Missed { deviation: noise * next.sqrt(), correlation: std::iter::once(1.0).chain(beyond).collect() }
}

/// Values of a series at their places; lost samples are gaps.
fn on_grid(series: &Series, samples: &[usize], value: impl Fn(usize) -> [f64; 2]) -> Vec<Option<[f64; 2]>> {
    let place = |k: &usize| samples[*k];
    let (Some(first), Some(last)) = (series.samples.first().map(place), series.samples.last().map(place))
    else {
        return Vec::new();
    };
    let mut grid = vec![None; last + 1 - first];
    for (k, sample) in series.samples.iter().enumerate() {
        grid[samples[*sample] - first] = Some(value(k));
    }
    grid
}

/// Weighs the samples of an objective by what a fit of it misses, or by what its releases do not repeat where that is
/// more; whether that changes it.
pub(super) fn hear(objective: &mut Objective, found: &Found) -> bool {
    let mut has_changed = false;
    for r in 0..objective.measured.len() {
        let beyond = beyond(objective, found, r);
        let measured = &mut objective.measured[r];
        for (t, beyond) in beyond.into_iter().enumerate() {
            let before = std::mem::replace(&mut measured.noise[t], measured.camera_noise[t].hypot(beyond));
            has_changed |= (measured.noise[t] / before).ln().abs() > CHANGED;
        }
    }
    has_changed
}

/// Standard deviation of a coordinate of each track of a release beside the camera's noise, as a sample of its own has it,
/// m.
fn beyond(objective: &Objective, found: &Found, r: usize) -> Vec<f64> {
    let places = objective.places(r, 0);
    let is_sought = |column: &usize| !objective.part.unknowns[places[*column]].is_nuisance();
    let sought: Vec<usize> = (0..places.len()).filter(is_sought).collect();
    let (trial, measured) = (&objective.part.members[r], &objective.measured[r]);
    let tracks = found.at.carried.blocks[r].iter().enumerate().zip(&trial.release.tracks);
    let of_track = |((t, series), track): ((usize, &Series), &Track)| {
        let missed = missed(series, &measured.samples, measured.noise[t]);
        let of_slopes = |column: &usize| {
            missed.shared(&on_grid(series, &measured.samples, |k| series.slopes[k][*column]))
        };
        let shared = sought.iter().map(of_slopes).fold(0.0, f64::max);
        (missed.deviation * shared.sqrt()).max(track.discrepancy)
    };
    tracks.map(of_track).collect()
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    use super::*;
    use crate::normal::normal;

    const COUNT: usize = 4000;

    /// Noise of unit deviation, and what goes on with a memory of `ρ` a sample.
    fn residuals(memory: f64, deviation: f64) -> Series {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut at = [0.0; 2];
        let fresh = deviation * (1.0 - memory * memory).sqrt();
        let residual = (0..COUNT).map(|_| {
            at = at.map(|at| memory * at + fresh * normal(&mut random));
            at.map(|at| at + normal(&mut random))
        });
        Series { samples: (0..COUNT).collect(), residual: residual.collect(), slopes: Vec::new() }
    }

    fn all() -> Vec<usize> {
        (0..COUNT).collect()
    }

    #[test]
    fn noise_alone_misses_nothing() {
        assert_eq!(missed(&residuals(0.0, 0.0), &all(), 1e-3), Missed::default());
    }

    /// `c_k / c_1 = ρ^(k−1)`: for slopes that do not change, `w = 1 + 2 / (1 − ρ)`, 41 for ρ = 0.95; for slopes that
    /// swing with a period of 20 samples, the sum is `Re e^{iω} / (1 − ρ e^{iω})`.
    #[test]
    fn what_goes_on_counts_as_it_moves_the_parameter() {
        let found = missed(&residuals(0.95, 2.0), &all(), 1e-3);
        assert!((found.deviation / 2e-3 - 1.0).abs() < 0.1, "{found:?}");
        let omega = std::f64::consts::TAU / 20.0;
        let steady: Vec<_> = (0..COUNT).map(|_| Some([1.0; 2])).collect();
        let swinging: Vec<_> = (0..COUNT).map(|k| Some([(omega * k as f64).sin(); 2])).collect();
        let memory: f64 = 0.95;
        let sum = (omega.cos() - memory) / (1.0 - 2.0 * memory * omega.cos() + memory * memory);
        for (slopes, due) in [(steady, 1.0 + 2.0 / (1.0 - memory)), (swinging, 1.0 + 2.0 * sum)] {
            let shared = found.shared(&slopes);
            assert!((shared / due - 1.0).abs() < 0.3, "{shared}, due {due}");
        }
    }

    #[test]
    fn single_ghosts_are_not_missed() {
        let mut with_ghosts = residuals(0.0, 0.0);
        for k in (50..COUNT).step_by(400) {
            with_ghosts.residual[k] = [300.0, -200.0];
        }
        assert_eq!(missed(&with_ghosts, &all(), 1e-3), Missed::default());
    }
}
