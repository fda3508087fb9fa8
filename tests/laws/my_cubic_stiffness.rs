//! my cubic stiffness: a law as text.
//!
//! Law:      moment = bending_stiffness * coefficient * kappa^3
//!
//!   moment              resisting moment of a bend       N m
//!   coefficient                                          m^2
//!   kappa               curvature, positive towards +z   1/m
//!   bending_stiffness   bending stiffness EI             N m^2
//!
//! Assumes:  Its author does not say.
//! Off:      coefficient = 0.
//! Silent:   Its author does not say.
//! Source:   Its author does not say.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};
use crate::written::integral;

/// A law as text.
pub struct MyCubicStiffness;

impl Law for MyCubicStiffness {
    const ABOUT: About = About {
        name: "my_cubic_stiffness",
        meaning: "a law as text",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "coefficient",
            meaning: "",
            unit: "m^2",
            default: 0.001,
            range: (-1.0, 1.0),
            scale: 0.001,
            null_value: Some(0.0),
            plausible: Some((-0.003, 0.003)),
            ..Parameter::PLAIN
        }],
        signature: "",
        confounded_with: &["pressure_volume", "quadratic_stiffness", "dahl"],
        separated_by: &[Separator::Angles, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [coefficient] = named(theta);
        Moment::of(at.rod.bending_stiffness * coefficient * at.kappa.powi(3))
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        // What it takes to bend or stretch it to there at rest.
        integral(at.kappa, |kappa| self.bend(&Bend { kappa, kappa_rate: T::from(0.0), ..*at }, theta).moment)
    }
}
