//! Tip hold: a hand holds the end of the active length until the release.
//!
//! Law:      F = h (F_x, F_z),   M = h M_h
//!
//!   F          force at the last node, fixed in direction    N
//!   M          moment on the end fitting, from x towards z   N m
//!   h          1 while the rod is held, 0 once it is let go  –
//!   F_x, F_z   force of the hand                             N
//!   M_h        moment of the hand                            N m
//!
//! A hand that moves changes its force and moment at the rates `rate_x` and `rate_z`, N/s, and `rate_moment`, N m/s: the
//! rod follows from rest to rest, and is let go with that velocity.
//!
//! Assumes:  The rod is in equilibrium in the hand, and the hand lets go at once.
//!           A start from equilibrium sets `held` to 1 in the model that holds the rod, and leaves it
//!           at 0 in the model that swings. So force and moment move the start alone, and a fit finds
//!           them like any other parameter.
//! Off:      held = 0.
//! Silent:   After the release, but for the posture in which it leaves the rod.
//! Source:   The static equilibrium of a cantilever under a dead load at its end.

use super::tip_load::component;
use super::{About, Kind, Law, Parameter, Place, Reach, Real, Tip, TipLoad, named};

/// A hand that holds the end.
pub struct TipHold;

/// Name of the effect.
pub const NAME: &str = "tip_hold";
/// Path of the parameter that says whether the rod is held.
pub const HELD: &str = "effects.tip_hold.held";
/// Paths of what the hand does: force along x and z, their rates, the moment, and its rate.
pub const PULL: [&str; 6] = [
    "effects.tip_hold.force_x",
    "effects.tip_hold.force_z",
    "effects.tip_hold.rate_x",
    "effects.tip_hold.rate_z",
    "effects.tip_hold.moment",
    "effects.tip_hold.rate_moment",
];

impl Law for TipHold {
    const ABOUT: About = About {
        name: NAME,
        meaning: "a hand holds the end of the active length until the release",
        kind: Kind::Load,
        places: &[Place::Tip],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "held",
                meaning: "1 in the model that holds the rod before the release, 0 in the one that swings",
                unit: "",
                default: 0.0,
                range: (0.0, 1.0),
                scale: 1.0,
                null_value: None,
                ..Parameter::PLAIN
            },
            component("force_x", "force of the hand along x", "N", 0.1),
            component("force_z", "force of the hand along z, up", "N", 0.1),
            component("moment", "moment of the hand, from x towards z", "N m", 0.01),
            component("rate_x", "rate of the force along x at the release", "N/s", 1.0),
            component("rate_z", "rate of the force along z at the release", "N/s", 1.0),
            component("rate_moment", "rate of the moment at the release", "N m/s", 0.1),
        ],
        signature: "a bent posture at the release",
        confounded_with: &["set_curvature"],
        separated_by: &[],
        reach: Reach::Release,
    };

    fn tip<T: Real>(&self, _at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let [held, x, z, moment] = named(theta);
        TipLoad { force: [held * x, held * z], moment: held * moment }
    }

    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        let [held, x, z, moment] = named(theta);
        -held * (x * at.position[0] + z * at.position[1] + moment * at.angle)
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::statics::equilibrium;

    /// Of small bending a force at the end moves it by `F L³/3 EI`, and a moment turns it by `M L/EI`.
    #[test]
    fn a_hand_bends_the_rod_as_a_beam() {
        let rest = |held: f64, force: f64, moment: f64| {
            let hand = [("held", held), ("force_z", force), ("moment", moment)];
            let mut model = rod_with(&[("gravity", &[("acceleration", 0.0)]), ("tip_hold", &hand)]);
            model.set("rod.base_angle", 0.0).unwrap();
            let q = equilibrium(&model, None).unwrap().q;
            (q[q.len() - 2], q[q.len() - 1], model.rod())
        };
        let (height, _, rod) = rest(1.0, 1e-4, 0.0);
        let due = 1e-4 * rod.length.powi(3) / (3.0 * rod.bending_stiffness);
        assert!((height / due - 1.0).abs() < 0.01, "{height} m, due {due} m");
        let (_, angle, rod) = rest(1.0, 0.0, 1e-5);
        let due = 1e-5 * rod.length / rod.bending_stiffness;
        assert!((angle / due - 1.0).abs() < 0.01, "{angle}, due {due}");
        assert!(rest(0.0, 1.0, 1.0).0.abs() < 1e-12, "it has let go");
    }
}
