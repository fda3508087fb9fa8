//! Stiffness taper: the rod is stiffer at one end than at the other.
//!
//! Law:      M = EI e (s/L − ½) κ
//!
//!   M     moment beside that of the mean stiffness        N m
//!   EI    bending stiffness, `rod.bending_stiffness`       N m²
//!   e     change of stiffness from clamp to tip, over EI  –
//!   s/L   place along the rod, 0 at the clamp             –
//!   κ     curvature                                       1/m
//!
//! Assumes:  Linear along the rod; `rod.bending_stiffness` is the mean.
//! Off:      taper = 0.
//! Silent:   Any motion that keeps the rod straight in line with the clamp.
//! Source:   Euler and Bernoulli's beam with a stiffness that varies along it.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A bending stiffness that changes along the rod.
pub struct StiffnessTaper;

impl Law for StiffnessTaper {
    const ABOUT: About = About {
        name: "stiffness_taper",
        meaning: "the rod is stiffer at one end than at the other",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "taper",
            meaning: "stiffness at the tip less that at the clamp, over the mean",
            unit: "",
            default: 0.1,
            // At two the softer end would have none left.
            range: (-1.9, 1.9),
            scale: 0.1,
            null_value: Some(0.0),
            plausible: Some((-0.3, 0.3)),
            ..Parameter::PLAIN
        }],
        signature: "the shape of rest and swing differs: more of the bending sits near one end",
        confounded_with: &["clamp_compliance", "bend"],
        separated_by: &[Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [taper] = named(theta);
        Moment::of(at.rod.bending_stiffness * taper * (at.position - 0.5) * at.kappa)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [taper] = named(theta);
        at.rod.bending_stiffness * taper * (at.position - 0.5) * at.kappa * at.kappa * 0.5
    }
}
