//! Recordings made up for the tests of cleaning.

use std::path::{Path, PathBuf};

use super::*;

/// Reproducible noise.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f64 + 0.5) / (1u64 << 31) as f64
    }

    /// Of a normal distribution, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

type Seen = Vec<Option<[f64; 3]>>;

/// Where the tip is, from its hold, 0, over its rest, 1, to beyond.
fn along(u: f64, length: f64) -> [f64; 3] {
    [length - 0.05 * u * u, 0.0, -0.12 * u]
}

/// A swing from rest at 0 about 1.
fn swing(t: f64, omega: f64) -> f64 {
    let zeta: f64 = 0.05;
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    1.0 - (-zeta * omega * t).exp() * ((damped * t).cos() + zeta * omega / damped * (damped * t).sin())
}

/// A tip that is held level at `length` until `instant`, and swings about 12 cm below.
pub fn falling_swing(instant: f64, duration: f64, length: f64, omega: f64, step: f64) -> (Vec<f64>, Seen) {
    let time: Vec<f64> = (0..(duration / step) as usize).map(|i| step * i as f64).collect();
    let u = |t: f64| if t < instant { 0.0 } else { swing(t - instant, omega) };
    let path = time.iter().map(|t| Some(along(u(*t), length))).collect();
    (time, path)
}

/// The same raised by hand and let go several times; with each the instant of release, and that at
/// which it is raised again or the recording ends.
pub fn raised_and_released(cycles: usize) -> (Vec<f64>, Seen, Vec<(f64, f64)>) {
    const REST: f64 = 1.0;
    const RAISE: f64 = 1.4;
    const HOLD: f64 = 0.8;
    const SWING: f64 = 9.003;
    let whole = REST + RAISE + HOLD + SWING;
    let time: Vec<f64> = (0..(whole * cycles as f64 / 0.01) as usize).map(|i| 0.01 * i as f64).collect();
    let u = |t: f64| {
        let phase = t % whole;
        if phase < REST {
            1.0
        } else if phase < REST + RAISE {
            0.5 + 0.5 * (std::f64::consts::PI * (phase - REST) / RAISE).cos()
        } else if phase < REST + RAISE + HOLD {
            0.0
        } else {
            swing(phase - REST - RAISE - HOLD, 8.0)
        }
    };
    let path = time.iter().map(|t| Some(along(u(*t), 0.2))).collect();
    let instants = (0..cycles).map(|k| {
        let instant = whole * k as f64 + REST + RAISE + HOLD;
        (instant, instant + SWING + if k + 1 < cycles { REST } else { 0.0 })
    });
    (time, path, instants.collect())
}
