//! Gravity: everything that has mass is pulled down.
//!
//! Law:      F = −m g ẑ
//!
//!   F   force on a mass m            N
//!   g   acceleration of free fall    m/s²
//!
//! Assumes:  Uniform; z points up. A clamp that is not level is `rod.base_angle`.
//! Off:      acceleration = 0.
//! Silent:   Never, while there is mass.
//! Source:   Garbulinski and Wereley (2022), Table 1: 9.81 m/s².

use super::about::STANDARD_GRAVITY;
use super::{About, Kind, Law, Mass, MassLoad, Parameter, Place, Reach, Real, named};

/// Weight.
pub struct Gravity;

impl Law for Gravity {
    const ABOUT: About = About {
        name: "gravity",
        meaning: "everything that has mass is pulled down",
        kind: Kind::Load,
        places: &[Place::Mass],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "acceleration",
            meaning: "acceleration of free fall",
            unit: "m/s^2",
            default: STANDARD_GRAVITY,
            range: (0.0, 1000.0),
            scale: STANDARD_GRAVITY,
            null_value: Some(0.0),
            ..Parameter::PLAIN
        }],
        signature: "the rod sags, and swings about the sagged posture",
        confounded_with: &["bend"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn mass<T: Real>(&self, _at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        let [acceleration] = named(theta);
        let zero = T::from(0.0);
        MassLoad { acceleration: [zero, -acceleration], rate: zero }
    }
}
