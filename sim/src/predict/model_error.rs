//! What the model itself may be off by in a predicted number, by how far it was off where it was calibrated.
//!
//! - Distances grow with the excursion: the law that is missing or wrong is taken to be so by the same share.
//! - Frequencies and damping ratios are off by the same share.
//! - Damping at another frequency depends on the law of the loss. The ratio goes with the frequency to a power: −1 for
//!   mass damping, 0 for a material whose loss does not depend on the rate, 1 for stiffness damping (Crandall 1970,
//!   Journal of Sound and Vibration 11, 3-18). Where both of Rayleigh's were fitted their errors say how well the power
//!   is known; otherwise it is believed to one half.

use models::muscle::{Known, Misfit};

use super::interval::NORMAL_95;
use super::simulated::Simulated;
use crate::scenario::Case;

/// Standard deviation of what is believed of the power with which a damping ratio goes with the frequency.
const POWER: f64 = 0.5;
/// Angle at the end of a cantilever under a load there, over its deflection a length.
const END_ANGLE: f64 = 1.5;

/// What a number is, as far as errors of the model go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Off {
    /// A position or height while the rod swings, m.
    Swing,
    /// A position at rest, m.
    Rest,
    /// An angle while it swings, rad.
    SwingAngle,
    /// An angle at rest, rad.
    RestAngle,
    /// A moment or a speed of the swing: the share of the distance.
    Share,
    /// A frequency of the first mode.
    Frequency,
    /// A damping ratio of the first mode, or a time in which it acts.
    Damping,
    /// What no recording of a swing tells.
    Untold,
}

/// What a calibration's model missed, and where it is asked.
pub(super) struct ModelError {
    pub misfit: Misfit,
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
    /// Length of the rod, m.
    pub length: f64,
    /// Frequency of the swing, Hz.
    pub frequency_hz: Option<f64>,
    /// Whether the calibration fitted how damping goes with the frequency.
    pub is_power_fitted: bool,
}

/// Laws of a loss between whose powers of the frequency all others lie.
const BOTH: [&str; 2] = ["effects.rayleigh_mass.alpha", "effects.rayleigh_stiffness.beta"];

impl ModelError {
    /// That of a case; none where the calibration does not say what its model missed.
    pub fn of(known: &Known, case: &Case, own: &Simulated) -> Option<Self> {
        Some(Self {
            misfit: known.misfit?,
            excursion: own.excursion,
            length: case.model.rod().length,
            frequency_hz: own.cycles.first().map(|cycle| cycle.damped_frequency_hz),
            is_power_fitted: BOTH.iter().all(|path| known.parameter.iter().any(|own| own.path == *path)),
        })
    }

    /// Standard deviation of a number.
    fn deviation(&self, off: Off, value: f64) -> f64 {
        let Misfit { distance, rest, frequency, .. } = self.misfit;
        let angle = END_ANGLE * self.excursion / self.length;
        match off {
            Off::Swing => distance * self.excursion,
            Off::Rest => rest * self.excursion,
            Off::SwingAngle => distance * angle,
            Off::RestAngle => rest * angle,
            Off::Share => distance * value.abs(),
            Off::Frequency => frequency * value.abs(),
            Off::Damping => self.of_damping() * value.abs(),
            Off::Untold => 0.0,
        }
    }

    /// Of the logarithm of a damping ratio.
    fn of_damping(&self) -> f64 {
        let away = self
            .frequency_hz
            .zip(self.misfit.frequency_hz)
            .map_or(0.0, |(here, [low, high])| (here / here.clamp(low, high)).ln().abs());
        let power = if self.is_power_fitted { 0.0 } else { POWER };
        self.misfit.damping_ratio.hypot(power * away)
    }

    /// An interval of a number with the error of the model in it.
    pub fn widened(&self, off: Off, value: f64, [low, high]: [f64; 2]) -> [f64; 2] {
        match off {
            // A ratio is positive: errors of its logarithm.
            Off::Damping if value > 0.0 && low > 0.0 => {
                let own = self.of_damping();
                let end = |end: f64| (end / value).ln().hypot(NORMAL_95 * own);
                [value * (-end(low)).exp(), value * end(high).exp()]
            }
            _ => {
                let own = NORMAL_95 * self.deviation(off, value);
                [value - (value - low).hypot(own), value + (high - value).hypot(own)]
            }
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
        ModelError { misfit, excursion: 0.1, length: 0.3, frequency_hz: Some(6.0), is_power_fitted: false }
    }

    #[test]
    fn distances_grow_with_the_excursion() {
        let [low, high] = error().widened(Off::Rest, -0.05, [-0.05, -0.05]);
        assert!((high - low - 2.0 * NORMAL_95 * 0.001).abs() < 1e-12);
        let [low, high] = error().widened(Off::Swing, -0.05, [-0.05, -0.05]);
        assert!((high - low - 2.0 * NORMAL_95 * 0.002).abs() < 1e-12);
    }

    /// With half the frequency a ratio is half or twice as large by one of Rayleigh's laws and the same by no law of the
    /// rate: two standard deviations hold both.
    #[test]
    fn damping_at_another_frequency_is_known_to_its_law() {
        let away = ModelError {
            misfit: Misfit { damping_ratio: 0.0, ..error().misfit },
            frequency_hz: Some(2.0),
            ..error()
        };
        let [low, high] = away.widened(Off::Damping, 0.05, [0.05, 0.05]);
        let half = 2f64.powf(0.5 * NORMAL_95);
        assert!((low / (0.05 / half) - 1.0).abs() < 1e-12 && (high / (0.05 * half) - 1.0).abs() < 1e-12);
        assert_eq!(ModelError { is_power_fitted: true, ..away }.of_damping(), 0.0);
        let inside = ModelError { frequency_hz: Some(6.0), ..away };
        assert_eq!(inside.of_damping(), 0.0);
    }
}
