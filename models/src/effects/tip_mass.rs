//! Tip mass: a point mass sits somewhere beyond the end of the rod.
//!
//! Law:      m ẍ = F
//!
//!   m   mass                                                      kg
//!   w   fraction of its weight m g that acts                      –
//!   d   its place beyond the end of the active length, on the     m
//!       axis of the end fitting with which it turns
//!   x   its position                                              m
//!   F   force that the end fitting exerts on it                   N
//!
//! Assumes:  A point; other bodies have a centre of mass and rotary inertia: see payload.
//! Off:      mass = 0.
//! Silent:   No motion of the tip is without it.
//! Source:   Newton's second law.

use super::{About, Body, Kind, Law, Parameter, Per, Place, Reach, Real, Separator, named};

/// A point mass on the end body.
pub struct TipMass;

impl Law for TipMass {
    const ABOUT: About = About {
        name: "tip_mass",
        meaning: "a point mass sits somewhere beyond the end of the rod",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "mass",
                meaning: "mass of the point",
                unit: "kg",
                default: 5e-3,
                range: (0.0, 100.0),
                scale: 5e-3,
                null_value: Some(0.0),
                plausible: Some((0.0, 1.0)),
                per: Per::Mass,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "distance",
                meaning: "its place beyond the end of the active length",
                unit: "m",
                default: 0.02,
                range: (-1.0, 10.0),
                scale: 0.01,
                plausible: Some((0.0, 0.2)),
                per: Per::Length,
                tries: &[0.0, 0.1, 0.2],
                ..Parameter::PLAIN
            },
            Parameter {
                name: "weight",
                meaning: "fraction of its weight that acts: 0 if a tip load already holds the weight",
                unit: "",
                default: 1.0,
                range: (0.0, 1.0),
                scale: 1.0,
                tries: &[1.0, 0.0],
                tries_beside: Some("tip_load"),
                ..Parameter::PLAIN
            },
        ],
        signature: "lowers frequency and rest posture together, as a softer rod would",
        confounded_with: &["bend", "end_fitting", "payload", "tip_inertia"],
        separated_by: &[Separator::Metrology, Separator::Payload],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(&self, theta: &[T]) -> Body<T> {
        let [mass, distance, weight] = named(theta);
        Body { heavy: mass * weight, ..Body::of(&[mass, distance, T::from(0.0)]) }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::model::Model;
    use crate::system::System;

    const MASS: f64 = 0.05;

    /// Forces on a swinging rod and its energy of weight, with gravity.
    fn forces(model: &Model) -> (Vec<f64>, f64) {
        let mut system = System::new(model);
        let (q, v) = system.assembly.straight(0.3, 2.0);
        let mut force = vec![0.0; q.len()];
        system.force(0.0, &q, &v, &[], &mut force, &mut []);
        (force, system.energy(0.0, &q, &v, &[]).2)
    }

    fn with(distance: f64, weight: f64, load: f64) -> Model {
        let gravity: (&str, &[(&str, f64)]) = ("gravity", &[("acceleration", 9.81)]);
        let mass = [("mass", MASS), ("distance", distance), ("weight", weight)];
        rod_with(&[gravity, ("tip_mass", &mass), ("tip_load", &[("force_z", load)])])
    }

    /// A weight stated as a dead load gives the same forces as the mass itself.
    #[test]
    fn its_weight_may_be_told_as_a_load() {
        let (weighed, told) = (forces(&with(0.0, 1.0, 0.0)).0, forces(&with(0.0, 0.0, -MASS * 9.81)).0);
        for (a, b) in weighed.iter().zip(&told) {
            assert!((a - b).abs() < 1e-12, "{a} N, {b} N");
        }
    }

    /// Without weight it moves no potential energy, wherever it sits; with half of it, half.
    #[test]
    fn its_share_of_weight_has_its_energy() {
        let [none, half, all] = [0.0, 0.5, 1.0].map(|weight| forces(&with(0.04, weight, 0.0)).1);
        let (distance, angle) = (0.3 + 0.04, 0.3f64);
        let due = MASS * 9.81 * distance * angle.sin();
        assert!((all - none - due).abs() < 1e-12, "{all} − {none} J, due {due} J");
        assert!((half - none - 0.5 * due).abs() < 1e-12);
    }
}
