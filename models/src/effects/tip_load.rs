//! Tip load: a dead force and moment act on the end of the active length.
//!
//! Law:      F = (F_x, F_z),   M
//!
//!   F_x, F_z   force at the last node, fixed in direction    N
//!   M          moment on the end fitting, from x towards z   N m
//!
//! Assumes:  Neither turns with the rod nor changes with time.
//! Off:      Each of the three at 0.
//! Silent:   Never.
//! Source:   The load cases of the closed forms: pure bending, and Bisshopp and Drucker (1945).

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Tip, TipLoad, named};

/// A dead load at the tip.
pub struct TipForce;

/// A component of a load, of either sign.
pub(super) const fn component(
    name: &'static str,
    meaning: &'static str,
    unit: &'static str,
    scale: f64,
) -> Parameter {
    Parameter { name, meaning, unit, default: 0.0, range: (-1e6, 1e6), scale, ..Parameter::PLAIN }
}

impl Law for TipForce {
    const ABOUT: About = About {
        name: "tip_load",
        meaning: "a dead force and moment act on the end of the active length",
        kind: Kind::Load,
        places: &[Place::Tip],
        memory: 0,
        timed: false,
        parameters: &[
            component("force_x", "force along x", "N", 0.1),
            component("force_z", "force along z, up", "N", 0.1),
            component("moment", "moment on the end fitting, from x towards z", "N m", 0.01),
        ],
        signature: "shifts the rest posture; leaves no loss",
        confounded_with: &["payload"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn tip<T: Real>(&self, _at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let [x, z, moment] = named(theta);
        TipLoad { force: [x, z], moment }
    }

    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        let [x, z, moment] = named(theta);
        -(x * at.position[0] + z * at.position[1] + moment * at.angle)
    }
}
