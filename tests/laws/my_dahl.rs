//! my dahl: a law as text.
//!
//! Law:      moment = friction_moment * memory
//!           energy = friction_moment * yield_curvature * memory * memory * 0.5
//!           memory rate = (kappa_rate - abs(memory)^(exponent - 1) * (loop_shape * memory * sqrt(kappa_rate * kappa_rate + creep_rate * creep_rate) - (loop_shape - 1) * abs(memory) * kappa_rate)) / yield_curvature
//!
//!   moment            resisting moment of a bend            N m
//!   energy            energy stored at a bend, per length   J/m
//!   friction_moment                                         N m
//!   yield_curvature                                         1/m
//!   creep_rate                                              1/(m s)
//!   exponent                                                –
//!   loop_shape                                              –
//!   kappa_rate        rate of the curvature                 1/(m s)
//!   memory            memory of the law at this bend        –
//!
//! Assumes:  Its author does not say.
//! Off:      friction_moment = 0.
//! Silent:   Its author does not say.
//! Source:   Its author does not say.

use super::{About, Bend, Kind, Law, Moment, Parameter, Per, Place, Reach, Real, Separator, named};
use crate::formula::{power, root};

/// A law as text.
pub struct MyDahl;

impl Law for MyDahl {
    const ABOUT: About = About {
        name: "my_dahl",
        meaning: "a law as text",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            Parameter {
                name: "friction_moment",
                meaning: "",
                unit: "N m",
                default: 0.0005,
                range: (0.0, 100.0),
                scale: 0.0005,
                null_value: Some(0.0),
                is_friction: true,
                plausible: Some((0.0, 0.1)),
                per: Per::WeightMoment,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "yield_curvature",
                meaning: "",
                unit: "1/m",
                default: 0.5,
                range: (0.0001, 10000.0),
                scale: 0.5,
                plausible: Some((0.006, 1.5)),
                per: Per::Curvature,
                tries: &[0.02, 0.1, 0.4],
                ..Parameter::PLAIN
            },
            Parameter {
                name: "creep_rate",
                meaning: "",
                unit: "1/(m s)",
                default: 0.02,
                range: (1e-6, 1000.0),
                scale: 0.02,
                plausible: Some((0.001, 1.0)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "exponent",
                meaning: "",
                unit: "",
                default: 1.0,
                range: (1.0, 20.0),
                scale: 2.0,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "loop_shape",
                meaning: "",
                unit: "",
                default: 1.0,
                range: (0.5, 10.0),
                scale: 2.0,
                ..Parameter::PLAIN
            },
        ],
        signature: "",
        confounded_with: &["braid_friction", "clamp_friction", "cubic_stiffness"],
        separated_by: &[Separator::Angles],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [friction_moment, yield_curvature, creep_rate, exponent, loop_shape] = named(theta);
        Moment {
            moment: friction_moment * at.memory,
            memory_rate: (at.kappa_rate
                - power(at.memory.abs(), exponent - 1.0)
                    * (loop_shape
                        * at.memory
                        * root(at.kappa_rate * at.kappa_rate + creep_rate * creep_rate)
                        - (loop_shape - 1.0) * at.memory.abs() * at.kappa_rate))
                / yield_curvature,
        }
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [friction_moment, yield_curvature] = named(theta);
        friction_moment * yield_curvature * at.memory * at.memory * 0.5
    }
}
