//! Rayleigh mass damping: everything that has mass loses velocity at one rate.
//!
//! Law:      F = −α m v,   M = −α J ω
//!
//!   F, M   force on a mass, moment on the end body      N, N m
//!   α      rate                                         1/s
//!   v, ω   velocity, angular velocity                   m/s, rad/s
//!
//! Assumes:  Nothing physical: a linear loss that is largest for slow modes, ζ = α / (2ω).
//! Off:      alpha = 0.
//! Silent:   Rest.
//! Source:   Rayleigh (1877), The Theory of Sound; Clough and Penzien (2003), section 12-3.

use super::{About, Kind, Law, Mass, MassLoad, Parameter, Place, Reach, Real, named};

/// Loss in proportion to momentum.
pub struct RayleighMass;

impl Law for RayleighMass {
    const ABOUT: About = About {
        name: "rayleigh_mass",
        meaning: "everything that has mass loses velocity at one rate",
        kind: Kind::Dissipative,
        places: &[Place::Mass],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "alpha",
            meaning: "rate at which velocity is lost",
            unit: "1/s",
            default: 0.0,
            range: (0.0, 1e6),
            scale: 1.0,
            null_value: Some(0.0),
            ..Parameter::PLAIN
        }],
        signature: "a straight line of log amplitude over time, of the same slope for every mode",
        confounded_with: &["rayleigh_stiffness"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn mass<T: Real>(&self, _at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        let [alpha] = named(theta);
        MassLoad { acceleration: [T::from(0.0); 2], rate: alpha }
    }
}
