//! Linear drag: the surroundings resist each piece of the body in proportion to its velocity.
//!
//! Law:      f = −c v
//!
//!   f   force per length, along and across alike    N/m
//!   c   drag per length and velocity                N s/m²
//!   v   velocity of an edge's midpoint              m/s
//!
//! Assumes:  One coefficient along and across. In creeping flow a slender body has about twice as
//!           much across; a swing moves across, so c is that one.
//! Off:      drag_per_length = 0.
//! Silent:   Rest. With a light end body it is mass damping of rate c over the mass per length.
//! Source:   Slender bodies in creeping flow: Batchelor (1970), J. Fluid Mech. 44, 419.

use super::{About, Flow, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// Drag in proportion to velocity.
pub struct LinearDrag;

impl Law for LinearDrag {
    const ABOUT: About = About {
        name: "linear_drag",
        meaning: "the surroundings resist each piece of the body in proportion to its velocity",
        kind: Kind::Dissipative,
        places: &[Place::Flow],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "drag_per_length",
            meaning: "force per velocity and length",
            unit: "N s/m^2",
            default: 0.01,
            range: (0.0, 1e4),
            scale: 0.01,
            null_value: Some(0.0),
            plausible: Some((0.0, 0.03)),
            ..Parameter::PLAIN
        }],
        signature: "a straight line of log amplitude over time, less steep with a payload",
        confounded_with: &["rayleigh_mass"],
        separated_by: &[Separator::Payload],
        reach: Reach::Muscle,
    };

    fn flow<T: Real>(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        let [drag_per_length] = named(theta);
        [at.tangential_velocity, at.normal_velocity].map(|velocity| -drag_per_length * velocity)
    }
}
