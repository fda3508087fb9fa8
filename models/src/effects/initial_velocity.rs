//! Initial velocity: the hand lets the rod go while it moves.
//!
//! Law:      v(0) = v₀(0) + Ω × r,   ω(0) = ω₀(0) + Ω
//!
//!   v₀, ω₀   velocities with which the release would let it go         m/s, rad/s
//!   Ω        angular velocity about the clamp, from x towards z        rad/s
//!   r        place from the clamp                                      m
//!
//! Assumes:  The rod moves as one about the clamp, and keeps the posture in which it is let go.
//!           It adds to `release.angular_velocity`, and acts on every start: straight, held, or a
//!           posture.
//! Off:      angular_velocity = 0.
//! Silent:   Never; but what is left of it after the first swings is a shift in time.
//! Source:   Rotation about a fixed point. Plausible is a push with up to a tenth of the energy of the
//!           fall: 0.32 √(3 g / L), 3.1 rad/s for a rod of 0.3 m. A judgement, not a measurement.

use super::{About, Kind, Law, Parameter, Per, Place, Reach, Real, Release, Separator, named};

/// An angular velocity at release.
pub struct InitialVelocity;

impl Law for InitialVelocity {
    const ABOUT: About = About {
        name: "initial_velocity",
        meaning: "the hand lets the rod go while it moves about the clamp",
        kind: Kind::Load,
        places: &[Place::Release],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "angular_velocity",
            meaning: "angular velocity about the clamp at release, from x towards z",
            unit: "rad/s",
            default: 0.5,
            range: (-1e3, 1e3),
            scale: 0.5,
            null_value: Some(0.0),
            plausible: Some((-0.32, 0.32)),
            per: Per::Fall,
            ..Parameter::PLAIN
        }],
        signature: "the first quarter of the first swing runs ahead or behind; later only the phase shows it",
        confounded_with: &["hand_release", "clock"],
        separated_by: &[Separator::Video, Separator::Repeats],
        reach: Reach::Release,
    };

    fn release<T: Real>(&self, theta: &[T]) -> Release<T> {
        let [angular_velocity] = named(theta);
        Release { angle: T::from(0.0), angular_velocity }
    }
}
