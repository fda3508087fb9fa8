//! Cubic stiffness: strong bending is resisted more, or less, than in proportion.
//!
//! Law:      M = EI k₃ κ³
//!
//!   M    moment beside the linear one                 N m
//!   EI   bending stiffness, `rod.bending_stiffness`   N m²
//!   k₃   hardening if positive, softening if negative  m²
//!   κ    curvature                                    1/m
//!
//! Assumes:  Elastic, and the same in both directions. Softening is trusted while 3 |k₃| κ² stays
//!           below one; beyond, the rod yields ever more.
//! Off:      coefficient = 0.
//! Silent:   In the limit, small bending.
//! Source:   Duffing's restoring force for each section; frequency over amplitude: Nayfeh and Mook
//!           (1979), Nonlinear Oscillations, ch. 2.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A moment of the third power of the curvature.
pub struct CubicStiffness;

impl Law for CubicStiffness {
    const ABOUT: About = About {
        name: "cubic_stiffness",
        meaning: "strong bending is resisted more, or less, than in proportion",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "coefficient",
            meaning: "moment over the linear one at a curvature of 1/m; positive hardens",
            unit: "m^2",
            default: 1e-3,
            range: (-1.0, 1.0),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((-3e-3, 3e-3)),
            ..Parameter::PLAIN
        }],
        signature: "the frequency depends on the amplitude, and the rest posture on another stiffness than the swing",
        confounded_with: &["pressure_volume", "quadratic_stiffness", "dahl"],
        separated_by: &[Separator::Angles, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [coefficient] = named(theta);
        Moment::of(at.rod.bending_stiffness * coefficient * at.kappa.powi(3))
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [coefficient] = named(theta);
        at.rod.bending_stiffness * coefficient * at.kappa.powi(4) * 0.25
    }
}
