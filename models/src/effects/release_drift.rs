//! Release drift: the bending stiffness differs a little from one release to the next.
//!
//! Law:      M = δ EI κ
//!
//!   M    moment beside that of the common stiffness      N m
//!   δ    this release's stiffness over it, less one      –
//!   EI   bending stiffness, `rod.bending_stiffness`       N m²
//!   κ    curvature                                       1/m
//!
//! Assumes:  Constant within a release: pressure, temperature, how the braid came to lie.
//! Off:      share = 0.
//! Silent:   Any motion that keeps the rod straight in line with the clamp.
//! Source:   A stiffness of its own for each release.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A bending stiffness of one release.
pub struct ReleaseDrift;

impl Law for ReleaseDrift {
    const ABOUT: About = About {
        name: "release_drift",
        meaning: "the bending stiffness differs a little from one release to the next",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "share",
            meaning: "bending stiffness of this release over the common one, less one",
            unit: "",
            default: 0.01,
            range: (-0.9, 100.0),
            scale: 0.01,
            null_value: Some(0.0),
            plausible: Some((-0.03, 0.03)),
            ..Parameter::PLAIN
        }],
        signature: "releases that should be equal differ in frequency and rest, each constant in itself",
        confounded_with: &["bend"],
        separated_by: &[Separator::Repeats],
        reach: Reach::Release,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [share] = named(theta);
        Moment::of(share * at.rod.bending_stiffness * at.kappa)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [share] = named(theta);
        share * at.rod.bending_stiffness * at.kappa * at.kappa * 0.5
    }
}
