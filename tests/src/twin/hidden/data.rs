//! Effects that are other data: of the beam, of its clamp, or of how it is let go.

use super::Hidden::{self, *};
use crate::twin::beam::{Beam, Body};

/// What distinguishes one release of an experiment from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occasion {
    /// Inside above ambient, Pa.
    pub pressure: f64,
    /// Outer diameter at it, m.
    pub diameter: f64,
    /// Place of the release in a drift between releases, −1 to 1.
    pub drift: f64,
}

impl Hidden {
    /// Changes the beam's data; its first body is the fitting.
    pub fn alter(&self, beam: &mut Beam, occasion: &Occasion) {
        match *self {
            TipInertia { inertia } => beam.bodies[0].inertia += inertia,
            TipOffset { along } => beam.bodies[0].center += along,
            TipMass { mass } => {
                beam.bodies.push(Body { mass, center: beam.bodies[0].center, inertia: 0.0 });
            }
            AxialCompliance { compliance } => beam.axial_compliance += compliance,
            ClampTilt { angle } => beam.incline += angle,
            ReleaseDrift { change } => beam.bending_stiffness *= 1.0 + change * occasion.drift,
            DampingOverPressure { beta, alpha, reference } => {
                beam.alpha += alpha * occasion.pressure / reference;
                beam.beta += beta * occasion.pressure / reference;
            }
            // The fluid is weighed with the fitting that holds it.
            Sloshing { mass, .. } => beam.bodies[0].mass -= mass,
            _ => {}
        }
    }

    /// Compliance of the clamp, rad/(N m).
    pub fn clamp_compliance(&self) -> f64 {
        if let ClampCompliance { compliance } = *self { compliance } else { 0.0 }
    }

    /// How far the clamp is turned, rad.
    pub fn clamp_tilt(&self) -> f64 {
        if let ClampTilt { angle } = *self { angle } else { 0.0 }
    }

    /// Angular velocity with which the straight rod is let go, rad/s.
    pub fn initial_rate(&self) -> f64 {
        if let InitialVelocity { rate } = *self { rate } else { 0.0 }
    }
}
