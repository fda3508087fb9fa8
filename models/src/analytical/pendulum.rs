//! A rigid body that swings about a fixed pivot under gravity, without friction.
//!
//! `I φ'' = −m g d sin φ` with `φ` the angle from hanging straight down. Source: Landau and
//! Lifshitz, Mechanics, section 11, problem 1: `T = 4 K(sin(φ0/2)) / ω`.

use super::elliptic::complete_first;

/// A rigid body on a pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pendulum {
    /// Mass, kg, positive.
    pub mass: f64,
    /// From the pivot to the centre of mass, m, positive.
    pub center_distance: f64,
    /// Rotary inertia about the centre of mass, kg m².
    pub rotary_inertia: f64,
    /// Acceleration of gravity, m/s², positive.
    pub gravity: f64,
}

impl Pendulum {
    /// Angular frequency of a swing of vanishing amplitude, rad/s: `√(m g d / (J + m d²))`.
    pub fn small_swing_frequency(&self) -> f64 {
        let Self { mass, center_distance, rotary_inertia, gravity } = *self;
        let about_pivot = rotary_inertia + mass * center_distance * center_distance;
        (mass * gravity * center_distance / about_pivot).sqrt()
    }

    /// Time from one turning point until the body is back there, s.
    ///
    /// `amplitude`: largest angle from hanging straight down, rad, in `−π < amplitude < π`.
    /// # Panics
    /// If the amplitude is outside of that range: the body would be upside down, or rotate.
    pub fn period(&self, amplitude: f64) -> f64 {
        assert!(amplitude.abs() < std::f64::consts::PI, "amplitude {amplitude} rad");
        4.0 * complete_first((0.5 * amplitude).cos()) / self.small_swing_frequency()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use super::*;

    const ROD: Pendulum =
        Pendulum { mass: 0.3, center_distance: 0.5, rotary_inertia: 0.3 / 12.0, gravity: 9.81 };

    #[test]
    fn a_rod_of_a_metre_swings_as_a_point_two_thirds_of_a_metre_down() {
        assert!((ROD.small_swing_frequency() - (9.81f64 / (2.0 / 3.0)).sqrt()).abs() < 1e-15);
    }

    /// At 90° the period is `Γ(1/4)² / (2π)^{3/2}` = 1.1803405990160962 times that of small swings.
    #[test]
    fn large_swings_take_longer() {
        let small = TAU / ROD.small_swing_frequency();
        assert!((ROD.period(0.0) / small - 1.0).abs() < 1e-15);
        assert!((ROD.period(-FRAC_PI_2) / small - 1.1803405990160962).abs() < 1e-14);
    }

    /// Verlet from the turning point; a quarter of the period leads to the lowest point.
    #[test]
    fn an_integration_in_time_agrees() {
        let (amplitude, steps) = (0.9 * PI, 200_000);
        let h = 0.25 * ROD.period(amplitude) / steps as f64;
        let squared = ROD.small_swing_frequency().powi(2);
        let (mut angle, mut rate) = (amplitude, 0.0);
        for _ in 0..steps {
            rate -= 0.5 * h * squared * angle.sin();
            angle += h * rate;
            rate -= 0.5 * h * squared * angle.sin();
        }
        let tolerance = 100.0 * h * h * squared; // second order; the start near the top amplifies
        assert!(angle.abs() < tolerance, "{angle} rad after a quarter period");
    }
}
