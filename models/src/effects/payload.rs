//! Payload: a rigid body is carried at the tip.
//!
//! Law:      m ẍ = F at its centre of mass, J φ̈ = M about it; fixed to the end of the active
//!           length, with no bend between, so it turns with the rod's end.
//!
//!   m   mass                                                   kg
//!   c   centre of mass beyond the end of the active length     m
//!   J   rotary inertia about its centre of mass                kg m²
//!   φ   angle of the end fitting                               rad
//!
//! Assumes:  Rigid; its centre of mass lies on the rod's axis. J = 0 is a point mass.
//! Off:      mass = 0, if rotary_inertia = 0 as well.
//! Silent:   No motion of the tip is without it.
//! Source:   A rigid body fixed to the end fitting: Newton and Euler.

use super::{About, BODY_PARAMETERS, Body, Kind, Law, Place, Reach, Real};

/// The rigid body of the payload.
pub struct Payload;

impl Law for Payload {
    const ABOUT: About = About {
        name: "payload",
        meaning: "a rigid body is carried at the tip",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: BODY_PARAMETERS,
        looks_like: "lowers frequency and rest posture together",
        confounded_with: &["bend"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(theta: &[T]) -> Body<T> {
        Body::of(theta)
    }
}
