//! The clamp: a spring and friction in its rotation.

use super::Hidden::{self, *};
use super::{TURNS_OVER_AT_ROOT, sign};
use crate::twin::element::Real;

impl Hidden {
    /// Compliance of the clamp, rad/(N m).
    pub fn clamp_compliance(&self) -> f64 {
        if let ClampCompliance { compliance } = *self { compliance } else { 0.0 }
    }

    /// Whether it rubs at the clamp.
    pub fn rubs(&self) -> bool {
        matches!(self, ClampFriction { .. })
    }

    /// Moment that resists the turning of the rod where it leaves the clamp, N m, at a rate in rad/s.
    pub fn clamp_moment<T: Real>(&self, rate: T) -> T {
        match *self {
            ClampFriction { moment } => sign(rate, TURNS_OVER_AT_ROOT) * moment,
            _ => T::from(0.0),
        }
    }
}
