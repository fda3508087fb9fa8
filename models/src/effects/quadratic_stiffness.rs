//! Quadratic stiffness: the rod is stiffer one way than the other.
//!
//! Law:      M = EI k₂ κ²
//!
//!   M    moment beside the linear one; it always bends downwards if k₂ > 0   N m
//!   EI   bending stiffness, `rod.bending_stiffness`                          N m²
//!   k₂   positive: stiffer when bent upwards, softer when bent downwards     m
//!   κ    curvature                                                           1/m
//!
//! Assumes:  Elastic; trusted while 2 |k₂ κ| stays below one.
//! Off:      coefficient = 0.
//! Silent:   In the limit, small bending.
//! Source:   First term beyond the linear one of a law that is not odd in κ; drift and second
//!           harmonic: Nayfeh and Mook (1979), Nonlinear Oscillations, ch. 2.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A moment of the square of the curvature.
pub struct QuadraticStiffness;

impl Law for QuadraticStiffness {
    const ABOUT: About = About {
        name: "quadratic_stiffness",
        meaning: "the rod is stiffer one way than the other",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "coefficient",
            meaning: "moment over the linear one at a curvature of 1/m; positive is stiffer when bent upwards",
            unit: "m",
            default: 5e-3,
            range: (-10.0, 10.0),
            scale: 5e-3,
            null_value: Some(0.0),
            plausible: Some((-0.02, 0.02)),
            ..Parameter::PLAIN
        }],
        signature: "the swing has a mean that moves with its amplitude, and a second harmonic",
        confounded_with: &["pressure_volume", "cubic_stiffness"],
        separated_by: &[Separator::Angles, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [coefficient] = named(theta);
        Moment::of(at.rod.bending_stiffness * coefficient * at.kappa.powi(2))
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [coefficient] = named(theta);
        at.rod.bending_stiffness * coefficient * at.kappa.powi(3) / 3.0
    }
}
