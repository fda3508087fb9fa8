//! Moments by curvature and its rate, at the points where the beam's strain energy is summed.

use super::Hidden::{self, *};
use super::{CLAMP_RUBS, TURNS_OVER, sign};
use crate::twin::element::Real;

/// What a law of bending may know of a point of the rod.
#[derive(Clone, Copy, Debug)]
pub struct Strain<T> {
    /// Curvature by rest arc length, 1/m.
    pub kappa: T,
    /// Its rate, 1/(m s).
    pub kappa_rate: T,
    /// Distance from the clamp over the length.
    pub share: f64,
    /// Length of the rod, m.
    pub length: f64,
    /// Mean square of the curvature over the rod, 1/m².
    pub mean_square: f64,
    /// After the release, s.
    pub time: f64,
    /// Inside above ambient, Pa.
    pub pressure: f64,
    /// EI of the beam, N m².
    pub bending_stiffness: f64,
}

impl Hidden {
    /// Whether the effect gives a moment of bending.
    pub fn bends(&self) -> bool {
        self.remembers()
            || matches!(
                self,
                BraidFriction { .. }
                    | ClampFriction { .. }
                    | Hysteresis { .. }
                    | CubicStiffness { .. }
                    | QuadraticStiffness { .. }
                    | SetCurvature { .. }
                    | StiffnessTaper { .. }
                    | PressureVolume { .. }
                    | StiffnessDrift { .. }
                    | StrainRateCubed { .. }
                    | Ripple { .. }
            )
    }

    /// Whether its moment has a memory at each point.
    pub fn remembers(&self) -> bool {
        matches!(self, Dahl { .. } | Viscoelastic { .. } | Creep { .. })
    }

    /// Moment that resists, N m; `memory` is that of the point.
    pub fn moment<T: Real>(&self, at: &Strain<T>, memory: T) -> T {
        let Strain { kappa, kappa_rate, bending_stiffness: ei, .. } = *at;
        match *self {
            BraidFriction { moment } => sign(kappa_rate, TURNS_OVER) * moment,
            ClampFriction { moment } => {
                let fades = (1.0 - at.share * at.length / CLAMP_RUBS).max(0.0);
                sign(kappa_rate, TURNS_OVER) * (0.5 * moment * fades * fades)
            }
            Hysteresis { loss_factor } => kappa.abs() * sign(kappa_rate, TURNS_OVER) * (loss_factor * ei),
            Dahl { moment, .. } => memory * moment,
            Viscoelastic { branch_stiffness, .. } | Creep { branch_stiffness, .. } => {
                (kappa - memory) * (branch_stiffness * ei)
            }
            CubicStiffness { coefficient } => kappa * kappa * kappa * (coefficient * ei),
            QuadraticStiffness { coefficient } => kappa * kappa * (coefficient * ei),
            SetCurvature { curvature, by_pressure } => T::from(-ei * (curvature + by_pressure * at.pressure)),
            StiffnessTaper { taper } => kappa * (taper * (at.share - 0.5) * ei),
            PressureVolume { coefficient } => kappa * (coefficient * at.mean_square * ei),
            StiffnessDrift { rate } => -kappa * (rate * at.time * ei),
            StrainRateCubed { coefficient } => kappa_rate * kappa_rate * kappa_rate * (coefficient * ei),
            Ripple { share, frequency } => kappa * (share * (frequency * at.time).sin() * ei),
            _ => T::from(0.0),
        }
    }

    /// `a` and `b` of the memory's rate `ż = a − b z`.
    pub fn memory_rate<T: Real>(&self, at: &Strain<T>) -> [T; 2] {
        match *self {
            Dahl { yield_curvature, .. } => [at.kappa_rate, at.kappa_rate.abs()].map(|x| x / yield_curvature),
            Viscoelastic { relaxation_time, .. } | Creep { relaxation_time, .. } => {
                [at.kappa / relaxation_time, T::from(relaxation_time.recip())]
            }
            _ => [T::from(0.0); 2],
        }
    }

    /// Change of curvature that a unit of its memory represents, 1/m: what an error of the memory
    /// weighs.
    pub fn weight_of_memory(&self, bending_stiffness: f64) -> f64 {
        match *self {
            Dahl { moment, .. } => moment / bending_stiffness,
            Viscoelastic { branch_stiffness, .. } | Creep { branch_stiffness, .. } => branch_stiffness,
            _ => 0.0,
        }
    }
}
