//! Creep: part of the bending stiffness gives way over seconds to minutes.
//!
//! Law:      M = g EI (κ − z),   ż = (κ − z) / τ
//!
//!   M    moment of the part that gives way                      N m
//!   g    its stiffness over the one that stays                  –
//!   EI   bending stiffness that stays, `rod.bending_stiffness`   N m²
//!   κ    curvature                                              1/m
//!   z    memory: curvature to which it has crept                1/m
//!   τ    creep time                                             s
//!
//! Assumes:  One creep time; for a range of times take `relaxation`. Under a load that stays the
//!           curvature goes from M / (EI (1 + g)) to M / EI as exp(−t / (τ (1 + g))). When the rod is
//!           let go it has crept to the end in the posture of release, unless `[release] history`
//!           says otherwise.
//! Off:      creep_stiffness = 0.
//! Silent:   Motion much faster than τ, of which it sees the mean; it only stiffens: EI (1 + g).
//! Source:   Zener's standard linear solid: Christensen (2003), Theory of Viscoelasticity, ch. 1.

use super::memory::{maxwell, maxwell_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A slow Maxwell branch in bending.
pub struct Creep;

impl Law for Creep {
    const ABOUT: About = About {
        name: "creep",
        meaning: "part of the bending stiffness gives way over seconds to minutes",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            Parameter {
                name: "creep_stiffness",
                meaning: "stiffness that gives way over the one that stays",
                unit: "",
                default: 0.05,
                range: (0.0, 100.0),
                scale: 0.05,
                null_value: Some(0.0),
                plausible: Some((0.0, 0.15)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "creep_time",
                meaning: "time in which it gives way",
                unit: "s",
                default: 30.0,
                range: (1e-3, 1e6),
                scale: 10.0,
                plausible: Some((2.0, 300.0)),
                tries: &[5.0, 30.0, 150.0],
                ..Parameter::PLAIN
            },
        ],
        signature: "the mean of the swing sinks slowly, long after the release and after the swing",
        confounded_with: &["set_curvature", "viscoelastic", "relaxation", "stiffness_drift"],
        separated_by: &[Separator::LongRecord],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [creep_stiffness, creep_time] = named(theta);
        maxwell(at, creep_stiffness, creep_time)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [creep_stiffness] = named(theta);
        maxwell_energy(at, creep_stiffness)
    }
}
