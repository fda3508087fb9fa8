//! Hose: the air supply pulls on the end fitting, as a spring and a dashpot.
//!
//! Law:      F = −k (r − r₀) − k τ v
//!
//!   F    force at the last node                               N
//!   k    stiffness of the hose                                N/m
//!   r    position of the last node                            m
//!   r₀   where the hose would leave it                        m
//!   τ    the dashpot over the spring                          s
//!   v    velocity of the last node                            m/s
//!
//! Assumes:  The same stiffness in all directions, no mass, no moment.
//! Off:      stiffness = 0; it takes the dashpot with it.
//! Silent:   Rest at r₀.
//! Source:   Kelvin and Voigt's solid, as a point support.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Tip, TipLoad, named};

/// A supply line that holds the tip back.
pub struct Hose;

const fn anchor(name: &'static str, meaning: &'static str, default: f64, tries: &'static [f64]) -> Parameter {
    Parameter {
        name,
        meaning,
        unit: "m",
        default,
        range: (-100.0, 100.0),
        scale: 0.1,
        plausible: Some((-0.5, 0.5)),
        tries,
        ..Parameter::PLAIN
    }
}

impl Law for Hose {
    const ABOUT: About = About {
        name: "hose",
        meaning: "the air supply pulls on the end fitting, as a spring and a dashpot",
        kind: Kind::Dissipative,
        places: &[Place::Tip],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "stiffness",
                meaning: "force of the hose per displacement of the last node",
                unit: "N/m",
                default: 0.1,
                range: (0.0, 1e6),
                scale: 0.1,
                null_value: Some(0.0),
                plausible: Some((0.0, 0.3)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "damping_time",
                meaning: "dashpot of the hose over its stiffness",
                unit: "s",
                default: 0.0,
                range: (0.0, 1e3),
                scale: 0.1,
                plausible: Some((0.0, 1.0)),
                tries: &[0.02],
                ..Parameter::PLAIN
            },
            anchor("anchor_x", "where the hose would leave the last node, along x", 0.2, &[0.2]),
            anchor(
                "anchor_z",
                "where the hose would leave the last node, along z, up",
                0.0,
                &[-0.3, 0.0, 0.3],
            ),
        ],
        signature: "a frequency and a rest that no stiffness and mass explain together, the same pull at every pressure",
        confounded_with: &["pressure_volume", "tip_inertia", "tip_load"],
        separated_by: &[Separator::Hose],
        reach: Reach::Muscle,
    };

    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let [stiffness, damping_time, x, z] = named(theta);
        let rest = [x, z];
        let pull = |k: usize| stiffness * (rest[k] - at.position[k] - damping_time * at.velocity[k]);
        TipLoad { force: [pull(0), pull(1)], moment: T::from(0.0) }
    }

    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        let [stiffness, _, x, z] = named(theta);
        let [x, z] = [at.position[0] - x, at.position[1] - z];
        stiffness * (x * x + z * z) * 0.5
    }
}
