//! Viscoelastic bending: a spring and a dashpot in series, parallel to the bending stiffness.
//!
//! Law:      M = g EI (κ − z),   ż = (κ − z) / τ
//!
//!   M    moment of the Maxwell branch                           N m
//!   g    its stiffness over the static one                      –
//!   EI   bending stiffness at rest, `rod.bending_stiffness`      N m²
//!   κ    curvature                                              1/m
//!   z    curvature to which the dashpot has crept               1/m
//!   τ    relaxation time                                        s
//!
//! Assumes:  One relaxation time; for a range of times take `relaxation`. The branch is relaxed in the
//!           posture of release, unless `[release] history` says otherwise.
//! Off:      branch_stiffness = 0.
//! Silent:   Motion much slower than τ. Much faster than τ it only stiffens: EI (1 + g).
//! Source:   Zener's standard linear solid: Christensen (2003), Theory of Viscoelasticity, ch. 1. Sizes:
//!           some 0.1 in rubber; at 40 and 100 psi g = 2 gives the spread of frequencies of Garbulinski
//!           and Wereley (2022) on their static EI.

use super::memory::{maxwell, maxwell_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A Maxwell branch in bending.
pub struct Viscoelastic;

impl Law for Viscoelastic {
    const ABOUT: About = About {
        name: "viscoelastic",
        meaning: "a spring and a dashpot in series stand beside the bending stiffness",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            Parameter {
                name: "branch_stiffness",
                meaning: "stiffness of the branch over the static bending stiffness",
                unit: "",
                default: 0.1,
                range: (0.0, 100.0),
                scale: 0.1,
                null_value: Some(0.0),
                plausible: Some((0.0, 3.0)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "relaxation_time",
                meaning: "relaxation time of the branch",
                unit: "s",
                default: 0.2,
                range: (1e-4, 1e4),
                scale: 0.1,
                plausible: Some((0.01, 5.0)),
                tries: &[0.05, 0.2, 1.0],
                ..Parameter::PLAIN
            },
        ],
        signature: "the rod is stiffer in motion than at rest, and loses most at frequencies near 1/τ",
        confounded_with: &["rayleigh_stiffness", "bend", "relaxation"],
        separated_by: &[Separator::Pressures, Separator::Payload],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [branch_stiffness, relaxation_time] = named(theta);
        maxwell(at, branch_stiffness, relaxation_time)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [branch_stiffness] = named(theta);
        maxwell_energy(at, branch_stiffness)
    }
}
