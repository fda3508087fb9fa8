//! Added mass: fluid that has to move with the rod makes it more inert, and not heavier.
//!
//! Law:      F = −μ ẍ   a metre of rod
//!
//!   F   force on the rod, a metre         N/m
//!   μ   mass that moves with it, a metre  kg/m
//!
//! Assumes:  Like the rod's own mass it is spread evenly over the active length at release, stays with
//!           the material, and follows it in every direction; the last half cell turns with the end
//!           body. Its weight is borne by the fluid around it. Mass damping acts on it too: what is
//!           lost is momentum, whose ever it is.
//! Off:      mass_per_length = 0.
//! Silent:   Rest.
//! Source:   Lamb (1932), Hydrodynamics, art. 68: a cylinder across the flow carries ρ π D²/4 a metre,
//!           0.7 g/m for 27 mm in air; air inside at 3 bar has some 2 g/m, but is weighed with the rod.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Rod, Separator};

/// Inertia without weight.
pub struct AddedMass;

impl Law for AddedMass {
    const ABOUT: About = About {
        name: "added_mass",
        meaning: "fluid that has to move with the rod makes it more inert, and not heavier",
        kind: Kind::Inertial,
        places: &[Place::Inertia],
        memory: false,
        timed: false,
        parameters: &[Parameter {
            name: "mass_per_length",
            meaning: "mass that moves with a metre of rod and is not weighed",
            unit: "kg/m",
            default: 7e-4,
            range: (0.0, 1e3),
            scale: 1e-3,
            off: Some(0.0),
            plausible: Some((0.0, 2e-3)),
            ..Parameter::PLAIN
        }],
        looks_like: "lowers the frequency and leaves the rest posture where it is",
        confounded_with: &["clock", "tip_offset", "tip_inertia"],
        separated_by: &[Separator::Payload, Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn inertia<T: Real>(_at_release: &Rod<T>, theta: &[T]) -> T {
        theta[0]
    }
}
