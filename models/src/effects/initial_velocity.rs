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
//! Source:   Rotation about a fixed point. Plausible are 1.5 rad/s, which is 0.3 m/s at the tip of a
//!           rod of 0.2 m: a judgement, not a measurement.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Release, Separator};

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
            plausible: Some((-1.5, 1.5)),
            ..Parameter::PLAIN
        }],
        signature: "the first quarter of the first swing runs ahead or behind; later only the phase shows it",
        confounded_with: &["hand_release", "clock"],
        separated_by: &[Separator::Video, Separator::Repeats],
        reach: Reach::Release,
    };

    fn release<T: Real>(theta: &[T]) -> Release<T> {
        Release { angle: T::from(0.0), angular_velocity: theta[0] }
    }
}
