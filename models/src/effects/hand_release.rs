//! Hand release: the hand lets go gradually.
//!
//! Law:      F = F₀ exp(−t / τ)
//!
//!   F    force on the last node, along z          N
//!   F₀   the same at the release, positive up     N
//!   t    time since release                       s
//!   τ    time in which the hand lets go           s
//!
//! Assumes:  A vertical force without a moment. A rest at the time of release has it in full: it is
//!           the rest in the hand.
//! Off:      force = 0.
//! Silent:   All that comes much later than τ, but for what the start has left.
//! Source:   The simplest force that ends: one size, one time.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Tip, TipLoad, named};

/// A force of the hand that dies away.
pub struct HandRelease;

/// Upward force at a time, N.
fn force<T: Real>(at: &Tip<T>, theta: &[T]) -> T {
    let [force, release_time] = named(theta);
    force * (-at.time / release_time).exp()
}

impl Law for HandRelease {
    const ABOUT: About = About {
        name: "hand_release",
        meaning: "the hand lets go gradually",
        kind: Kind::Load,
        places: &[Place::Tip],
        memory: 0,
        timed: true,
        parameters: &[
            Parameter {
                name: "force",
                meaning: "force of the hand at the release, along z, up",
                unit: "N",
                default: 0.05,
                range: (-1e3, 1e3),
                scale: 0.05,
                null_value: Some(0.0),
                plausible: Some((-0.5, 0.5)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "release_time",
                meaning: "time in which the hand lets go",
                unit: "s",
                default: 0.03,
                range: (1e-4, 1e6),
                scale: 0.03,
                plausible: Some((0.0, 0.1)),
                tries: &[0.01, 0.03, 0.1],
                ..Parameter::PLAIN
            },
        ],
        signature: "the first quarter of the first swing is late; from there on all is shifted in time",
        confounded_with: &["initial_velocity"],
        separated_by: &[Separator::Video, Separator::Repeats],
        reach: Reach::Release,
    };

    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let zero = T::from(0.0);
        TipLoad { force: [zero, force(at, theta)], moment: zero }
    }

    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        -force(at, theta) * at.position[1]
    }
}
