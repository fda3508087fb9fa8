//! Tip inertia: the end body resists turning more than its masses say.
//!
//! Law:      J φ̈ = M
//!
//!   J   rotary inertia beside that of fitting and payload    kg m²
//!   φ   angle of the end body                                rad
//!   M   moment on it                                         N m
//!
//! Assumes:  Rigid; it adds no mass, and moves no centre of mass.
//! Off:      rotary_inertia = 0.
//! Silent:   Any motion in which the end body does not turn; rest.
//! Source:   Euler's equation of a rigid body in the plane.

use super::{About, Body, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// Rotary inertia at the tip.
pub struct TipInertia;

impl Law for TipInertia {
    const ABOUT: About = About {
        name: "tip_inertia",
        meaning: "the end body resists turning more than its masses say",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "rotary_inertia",
            meaning: "rotary inertia beside that of fitting and payload",
            unit: "kg m^2",
            default: 2e-5,
            range: (0.0, 100.0),
            scale: 1e-5,
            null_value: Some(0.0),
            plausible: Some((0.0, 1e-4)),
            ..Parameter::PLAIN
        }],
        signature: "the frequency falls and the rest stays; the second mode falls more",
        confounded_with: &["added_mass", "tip_mass", "end_fitting"],
        separated_by: &[Separator::Payload, Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(&self, theta: &[T]) -> Body<T> {
        let [rotary_inertia] = named(theta);
        Body::of(&[T::from(0.0), T::from(0.0), rotary_inertia])
    }
}
