//! Stiffness drift: the bending stiffness changes during the recording, as the pressure leaks.
//!
//! Law:      M = −λ t EI κ
//!
//!   M    moment beside that of the stiffness at release   N m
//!   λ    share of the stiffness that is lost in a time    1/s
//!   t    time since release                               s
//!   EI   bending stiffness, `rod.bending_stiffness`        N m²
//!   κ    curvature                                        1/m
//!
//! Assumes:  A loss in proportion to time; λ t well below one, at one nothing would be left. Length
//!           and mass stay. A leak may stiffen: below some 25 psi the paper's muscle is the stiffer
//!           the lower its pressure.
//! Off:      rate = 0.
//! Silent:   The start, and any motion that keeps the rod straight in line with the clamp.
//! Source:   First order in time of any slow change of stiffness.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A bending stiffness that drifts.
pub struct StiffnessDrift;

impl Law for StiffnessDrift {
    const ABOUT: About = About {
        name: "stiffness_drift",
        meaning: "the bending stiffness changes during the recording, as the pressure leaks",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: true,
        parameters: &[Parameter {
            name: "rate",
            meaning: "share of the bending stiffness that is lost in a second",
            unit: "1/s",
            default: 1e-3,
            range: (-0.1, 0.1),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((-0.01, 0.01)),
            ..Parameter::PLAIN
        }],
        signature: "frequency and mean drift with time, whatever the amplitude",
        confounded_with: &["creep"],
        separated_by: &[Separator::LongRecord],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [drift] = named(theta);
        Moment::of(-drift * at.time * at.rod.bending_stiffness * at.kappa)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [drift] = named(theta);
        -drift * at.time * at.rod.bending_stiffness * at.kappa * at.kappa * 0.5
    }
}
