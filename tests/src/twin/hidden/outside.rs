//! Forces from outside: on what moves through the air, and on the fitting at the tip.

use super::AIR;
use super::Hidden::{self, *};
use crate::twin::element::{Real, cross, dot};

/// Motion of a point of the rod relative to the air.
#[derive(Clone, Copy, Debug)]
pub struct Gust<T> {
    /// Gradient of the axis.
    pub gradient: [T; 2],
    /// m/s.
    pub velocity: [T; 2],
    /// m/s².
    pub acceleration: [T; 2],
    /// Outer diameter, m.
    pub diameter: f64,
}

/// The fitting's centre of mass, in W.
#[derive(Clone, Copy, Debug)]
pub struct TipState<T> {
    /// m.
    pub position: [T; 2],
    /// m/s.
    pub velocity: [T; 2],
    /// After the release, s.
    pub time: f64,
}

/// The sloshing mass within an implicit step of reach `h`: `y = y₀ + h w`, `w = w₀ + h ẇ`.
#[derive(Clone, Copy, Debug)]
pub struct Slosh {
    /// `y₀` and `w₀`, in W, m and m/s.
    pub known: [[f64; 2]; 2],
    /// `h`, s.
    pub reach: f64,
    /// m/s².
    pub gravity: f64,
}

impl Hidden {
    /// Whether it acts along the whole rod from outside.
    pub fn flows(&self) -> bool {
        matches!(self, AirDrag { .. } | LinearDrag { .. } | AddedMass { .. })
    }

    /// Force on the rod per length, N/m.
    pub fn force_per_length<T: Real>(&self, at: &Gust<T>) -> [T; 2] {
        match *self {
            AirDrag { drag_coefficient } => {
                let [tx, tz] = at.gradient;
                let length = dot(at.gradient, at.gradient).sqrt();
                let across = cross(at.gradient, at.velocity) / length;
                let force = -across * across.abs() * (0.5 * AIR * drag_coefficient * at.diameter);
                [-tz * force / length, tx * force / length]
            }
            LinearDrag { coefficient } => at.velocity.map(|v| -v * coefficient),
            AddedMass { mass_per_length } => at.acceleration.map(|a| -a * mass_per_length),
            _ => [T::from(0.0); 2],
        }
    }

    /// Whether it pulls at the tip.
    pub fn pulls(&self) -> bool {
        matches!(self, TipDrag { .. } | Hose { .. } | HandRelease { .. } | Wall { .. } | Sloshing { .. })
    }

    /// Force on the fitting's centre of mass, N, in W.
    pub fn force_at_tip<T: Real>(&self, at: &TipState<T>, slosh: &Slosh) -> [T; 2] {
        match *self {
            TipDrag { drag_area } => {
                // The root of zero has no derivative; a micrometre a second is no speed.
                let speed = (dot(at.velocity, at.velocity) + 1e-12).sqrt();
                at.velocity.map(|v| -v * speed * (0.5 * AIR * drag_area))
            }
            Hose { stiffness, damping, anchor } => {
                [0, 1].map(|k| -(at.position[k] - anchor[k]) * stiffness - at.velocity[k] * damping)
            }
            HandRelease { force, time } => [T::from(0.0), T::from(force * (-at.time / time).exp())],
            Wall { stiffness, angle } => {
                let normal = [-angle.sin(), angle.cos()];
                let height = at.position[0] * normal[0] + at.position[1] * normal[1];
                let depth = if height.re() < 0.0 { -height } else { T::from(0.0) };
                normal.map(|n| depth * n * stiffness)
            }
            Sloshing { mass, frequency, damping } => {
                let [y, w] = self.slosh(at, slosh);
                let (spring, dashpot) = (mass * frequency * frequency, 2.0 * mass * damping * frequency);
                [0, 1].map(|k| (y[k] - at.position[k]) * spring + (w[k] - at.velocity[k]) * dashpot)
            }
            _ => [T::from(0.0); 2],
        }
    }

    /// Position and velocity of the sloshing mass at the end of the implicit step; they are linear
    /// in those of the tip.
    pub fn slosh<T: Real>(&self, at: &TipState<T>, step: &Slosh) -> [[T; 2]; 2] {
        let Sloshing { frequency, damping, .. } = *self else { return [[T::from(0.0); 2]; 2] };
        let (h, [y, w]) = (step.reach, step.known);
        let (square, rate) = (frequency * frequency, 2.0 * damping * frequency);
        let w = [0, 1].map(|k| {
            let fall = if k == 1 { step.gravity } else { 0.0 };
            let pull = (at.position[k] - y[k]) * square + at.velocity[k] * rate - fall;
            (pull * h + w[k]) / (1.0 + h * rate + h * h * square)
        });
        [[0, 1].map(|k| w[k] * h + y[k]), w]
    }
}
