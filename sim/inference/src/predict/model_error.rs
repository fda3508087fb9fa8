//! What the model itself may be off by in a predicted number, by how far it was off where it was calibrated.
//!
//! - Distances grow with the excursion: the law that is missing or wrong is taken to be so by the same share.
//! - Frequencies and damping ratios are off by the same share. What a loss may be at another frequency is among the errors
//!   of the parameters (`loss.rs`).

use efam_experiments::scenario::Case;
use models::muscle::{Known, Misfit};

use super::interval::with_error;
use super::quantity::Off;
use super::simulated::Simulated;
use crate::normal::NORMAL_95;

/// Angle at the end of a cantilever under a load there, over its deflection a length.
const END_ANGLE: f64 = 1.5;

/// What a calibration's model missed, and the run to which it applies.
pub(super) struct ModelError {
    pub misfit: Misfit,
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
    /// Length of the rod, m.
    pub length: f64,
}

impl ModelError {
    /// That of a case; none where the calibration does not say what its model missed.
    pub fn of(known: &Known, case: &Case, own: &Simulated) -> Option<Self> {
        Some(Self { misfit: known.misfit?, excursion: own.excursion, length: case.model.rod().length })
    }

    /// Standard deviation of a number.
    fn deviation(&self, off: Off, value: f64) -> f64 {
        let Misfit { distance, rest, frequency, damping_ratio, .. } = self.misfit;
        let angle = END_ANGLE * self.excursion / self.length;
        match off {
            Off::Swing => distance * self.excursion,
            Off::Rest => rest * self.excursion,
            Off::SwingAngle => distance * angle,
            Off::RestAngle => rest * angle,
            Off::Share => distance * value.abs(),
            Off::Frequency => frequency * value.abs(),
            Off::Damping => damping_ratio * value.abs(),
            Off::Untold => 0.0,
        }
    }

    /// An interval of a number with the error of the model in it.
    pub fn widened(&self, off: Off, value: f64, [low, high]: [f64; 2]) -> [f64; 2] {
        match off {
            // A ratio is positive: errors of its logarithm.
            Off::Damping if value > 0.0 && low > 0.0 => {
                let own = self.misfit.damping_ratio;
                let end = |end: f64| (end / value).ln().hypot(NORMAL_95 * own);
                [value * (-end(low)).exp(), value * end(high).exp()]
            }
            _ => with_error(value, [low, high], NORMAL_95 * self.deviation(off, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error() -> ModelError {
        let misfit = Misfit {
            distance: 0.02,
            rest: 0.01,
            frequency: 0.003,
            damping_ratio: 0.1,
            frequency_hz: Some([4.0, 8.0]),
        };
        ModelError { misfit, excursion: 0.1, length: 0.3 }
    }

    #[test]
    fn distances_grow_with_the_excursion() {
        let [low, high] = error().widened(Off::Rest, -0.05, [-0.05, -0.05]);
        assert!((high - low - 2.0 * NORMAL_95 * 0.001).abs() < 1e-12);
        let [low, high] = error().widened(Off::Swing, -0.05, [-0.05, -0.05]);
        assert!((high - low - 2.0 * NORMAL_95 * 0.002).abs() < 1e-12);
    }
}
