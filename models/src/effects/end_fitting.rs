//! End fitting: a rigid body closes the rod, and whatever marks its tip sits on it.
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
//! Source:   Garbulinski and Wereley (2022), Table 1: 54.92 g, 0.662 in beyond the active length.

use super::{About, BODY_PARAMETERS, Body, Kind, Law, Place, Reach, Real};

/// The rigid body of the fitting and marker cap.
pub struct EndFitting;

impl Law for EndFitting {
    const ABOUT: About = About {
        name: "end_fitting",
        meaning: "a rigid body closes the rod and carries the tip marker",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: BODY_PARAMETERS,
        signature: "lowers frequency and rest posture together",
        confounded_with: &["bend"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(&self, theta: &[T]) -> Body<T> {
        Body::of(theta)
    }
}
