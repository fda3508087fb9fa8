//! Tip mass: a point mass sits somewhere beyond the end of the rod.
//!
//! Law:      m ẍ = F
//!
//!   m   mass                                                      kg
//!   d   its place beyond the end of the active length, on the     m
//!       axis of the end fitting with which it turns
//!   x   its position                                              m
//!   F   force that the end fitting exerts on it                   N
//!
//! Assumes:  A point; other bodies have a centre of mass and rotary inertia: see payload.
//! Off:      mass = 0.
//! Silent:   No motion of the tip is without it.
//! Source:   Newton's second law.

use super::{About, Body, Kind, Law, Parameter, Per, Place, Reach, Real, Separator};

/// A point mass on the end body.
pub struct TipMass;

impl Law for TipMass {
    const ABOUT: About = About {
        name: "tip_mass",
        meaning: "a point mass sits somewhere beyond the end of the rod",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "mass",
                meaning: "mass of the point",
                unit: "kg",
                default: 5e-3,
                range: (0.0, 100.0),
                scale: 5e-3,
                off: Some(0.0),
                plausible: Some((0.0, 1.0)),
                per: Per::Mass,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "distance",
                meaning: "its place beyond the end of the active length",
                unit: "m",
                default: 0.02,
                range: (-1.0, 10.0),
                scale: 0.01,
                plausible: Some((0.0, 0.1)),
                tries: &[0.0, 0.02, 0.06],
                ..Parameter::PLAIN
            },
        ],
        looks_like: "lowers frequency and rest posture together, as a softer rod would",
        confounded_with: &["bend", "end_fitting", "payload", "tip_inertia"],
        separated_by: &[Separator::Metrology, Separator::Payload],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(theta: &[T]) -> Body<T> {
        Body::of(&[theta[0], theta[1], T::from(0.0)])
    }
}
