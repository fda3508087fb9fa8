//! What a model misses of a recording, beside the camera's noise.
//!
//! Noise is fresh in each sample; what a model misses goes on to the next. So the autocovariance of the residuals at one
//! sample is the variance d² of what is missed, whatever the noise and single ghosts are, and by how the residuals
//! resemble each other further on, w samples share one number of it:
//!
//! ```text
//! w = 1 + 2 Σ (c_k / c_1)²,   c_k the autocovariance at k samples
//! ```
//!
//! A fit then weighs each sample by `σ² + w d²` instead of the noise's σ² alone: N samples know as much of the model as
//! N/w that miss by d. Beliefs of the setup and of the material count against that, and no sample is held back because
//! the model misses it. Where nothing is missed, nothing changes.
//!
//! Source: Kennedy and O'Hagan (2001), Journal of the Royal Statistical Society B 63, 425-464, for a discrepancy beside
//! the noise; Bayley and Hammersley (1946), Supplement to the same, 8, 184-197, for w.

use super::autocorrelation::Autocovariance;
use super::objective::{Objective, Series};
use super::search::Found;

/// Change of the deviation of a track's samples that is worth another fit.
const CHANGED: f64 = 0.1;

/// What a fit misses of a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Missed {
    /// Standard deviation of a coordinate, m; zero where residuals do not go on.
    pub deviation: f64,
    /// Samples that share a number of it.
    pub shared: f64,
}

/// What a fit misses of a track with the noise of its residuals' unit, m; `samples` are their places in the recording.
pub(super) fn missed(series: &Series, samples: &[usize], noise: f64) -> Missed {
    let (Some(first), Some(last)) = (series.samples.first(), series.samples.last()) else {
        return Missed::default();
    };
    let mut grid = vec![None; samples[*last] + 1 - samples[*first]];
    for (k, residual) in series.samples.iter().zip(&series.residual) {
        grid[samples[*k] - samples[*first]] = Some(*residual);
    }
    let found = Autocovariance::of(&grid);
    let Some(next) = found.by_lag.get(1).copied().filter(|next| *next > 0.0) else {
        return Missed::default();
    };
    let shared = 1.0 + 2.0 * found.by_lag.iter().skip(1).map(|own| (own / next).powi(2)).sum::<f64>();
    Missed { deviation: noise * next.sqrt(), shared }
}

/// Weighs the samples of an objective by what a fit of it misses, or by what its releases do not repeat where that is
/// more; whether that changes it.
pub(super) fn hear(objective: &mut Objective, found: &Found) -> bool {
    let mut has_changed = false;
    let releases = objective.part.members.iter().zip(&mut objective.measured);
    for (block, (trial, measured)) in found.at.carried.blocks.iter().zip(releases) {
        for ((t, series), track) in block.iter().enumerate().zip(&trial.release.tracks) {
            let before = measured.noise[t];
            let missed = missed(series, &measured.samples, before);
            let beyond = (missed.deviation * missed.shared.sqrt()).max(track.discrepancy);
            measured.noise[t] = measured.camera_noise[t].hypot(beyond);
            has_changed |= (measured.noise[t] / before).ln().abs() > CHANGED;
        }
    }
    has_changed
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

    /// `c_k / c_1 = ρ^(k−1)`, so that `w = 1 + 2 / (1 − ρ²)`; 21.5 for ρ = 0.95.
    #[test]
    fn samples_share_what_goes_on() {
        let found = missed(&residuals(0.95, 2.0), &all(), 1e-3);
        let due = 1.0 + 2.0 / (1.0 - 0.95f64 * 0.95);
        assert!((found.deviation / 2e-3 - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.shared / due - 1.0).abs() < 0.3, "{found:?}, due {due}");
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
