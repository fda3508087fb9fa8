//! Strain rate cubed: a loss in bending that grows faster than the rate of bending.
//!
//! Law:      M = EI c₃ κ̇³
//!
//!   M    moment                                        N m
//!   EI   bending stiffness, `rod.bending_stiffness`     N m²
//!   c₃   coefficient                                   m² s³
//!   κ̇    rate of curvature                             1/(m s)
//!
//! Assumes:  The next odd term beside stiffness damping, for a loss that knows no direction.
//! Off:      coefficient = 0.
//! Silent:   Any rigid motion; in the limit, small swings.
//! Source:   Odd powers of velocity as damping: Elliott et al. (2015), Phil. Trans. R. Soc. A 373,
//!           20140402.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// Loss with the third power of the rate of bending.
pub struct StrainRateCubed;

impl Law for StrainRateCubed {
    const ABOUT: About = About {
        name: "strain_rate_cubed",
        meaning: "a loss in bending that grows faster than the rate of bending",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "coefficient",
            meaning: "moment over bending stiffness at a rate of curvature of 1/(m s)",
            unit: "m^2 s^3",
            default: 1e-7,
            range: (0.0, 1.0),
            scale: 1e-7,
            null_value: Some(0.0),
            plausible: Some((0.0, 1e-6)),
            ..Parameter::PLAIN
        }],
        signature: "the first large swings lose much more than the later ones: loss per cycle with the square of amplitude",
        confounded_with: &["air_drag", "tip_drag"],
        separated_by: &[Separator::Angles],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [coefficient] = named(theta);
        Moment::of(at.rod.bending_stiffness * coefficient * at.kappa_rate.powi(3))
    }
}
