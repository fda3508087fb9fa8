//! Clamp compliance: the clamp gives way in rotation.
//!
//! Law:      φ_c = C M
//!
//!   φ_c   rotation of the clamp         rad
//!   C     rotational compliance         rad/(N m)
//!   M     moment at the root            N m
//!
//! Assumes:  Elastic and without mass. Clamp and root bend are in series: they share the root's
//!           rotation in the ratio of their elastic stiffnesses, and that share is kept for all
//!           that acts in the root bend, damping included.
//! Off:      compliance = 0.
//! Silent:   Any motion without a moment at the root.
//! Source:   Two springs in series.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// A clamp that gives way.
pub struct ClampCompliance;

impl Law for ClampCompliance {
    const ABOUT: About = About {
        name: "clamp_compliance",
        meaning: "the clamp gives way in rotation",
        kind: Kind::Elastic,
        places: &[Place::Clamp],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "compliance",
            meaning: "rotation of the clamp per moment",
            unit: "rad/(N m)",
            default: 0.1,
            range: (0.0, 1e6),
            scale: 0.1,
            null_value: Some(0.0),
            plausible: Some((0.0, 1.0)),
            ..Parameter::PLAIN
        }],
        signature: "the whole rod turns about the clamp as if it were hinged: markers near the root move too much",
        confounded_with: &["bend"],
        separated_by: &[Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn clamp<T: Real>(&self, theta: &[T]) -> T {
        let [compliance] = named(theta);
        compliance
    }
}
