//! Clamp friction: the muscle rubs in its clamp where the root bends.
//!
//! Law:      M = M_c exp(−x / λ) z,   ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_b
//!
//!   M     moment                                                N m
//!   M_c   friction moment at the clamp                          N m
//!   x     distance from the clamp along the rod without load    m
//!   λ     length over which the grip of the clamp is felt       m
//!   z     memory: share of the friction moment, between −1 and 1  –
//!   κ̇     rate of curvature                                     1/(m s)
//!   κ̇₀    rate below which what sticks creeps                   1/(m s)
//!   κ_b   curvature over which friction turns round, 0.01 1/m
//!
//! Assumes:  A grip that dies away over λ. Friction of a single cross-section would do no work: a
//!           root bend of no length takes no rotation, and on a mesh the loss would go with the edge
//!           length. In the swing of a rod much longer than λ only M_c λ counts. κ_b moves the tip by
//!           less than cameras see. When the rod is let go z = 0, unless
//!           `[release] history` says otherwise.
//! Off:      friction_moment = 0.
//! Silent:   Any motion in which the root does not bend.
//! Source:   Slip damping at a clamped root: Goodman and Klumpp (1956), J. Appl. Mech. 23, 421; memory
//!           as in Dahl (1976), AIAA J. 14, 1675, with |κ̇| made smooth.

use super::memory::{BRISTLE, CREEP_RATE, FRICTION_MOMENT, friction, friction_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Per, Place, Reach, Real, Separator, named};

/// Moment at which a section slides, N m.
fn sliding_moment<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
    let [friction_moment, grip_length] = named(theta);
    friction_moment * (-at.rod.length * at.position / grip_length).exp()
}

/// Coulomb's friction at the root.
pub struct ClampFriction;

impl Law for ClampFriction {
    const ABOUT: About = About {
        name: "clamp_friction",
        meaning: "the muscle rubs in its clamp where the root bends",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            Parameter {
                meaning: "friction moment at the clamp",
                default: 2e-3,
                scale: 2e-3,
                plausible: Some((0.0, 0.2)),
                per: Per::WeightMoment,
                ..FRICTION_MOMENT
            },
            Parameter {
                name: "grip_length",
                meaning: "length over which the grip of the clamp is felt",
                unit: "m",
                default: 0.02,
                range: (1e-4, 100.0),
                scale: 0.02,
                ..Parameter::PLAIN
            },
            CREEP_RATE,
        ],
        signature: "amplitude falls on a straight line to an early stop, with an offset that sits at the root",
        confounded_with: &["braid_friction", "dahl"],
        separated_by: &[Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [_, _, creep_rate] = named(theta);
        friction(at, sliding_moment(at, theta), creep_rate, BRISTLE.into())
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        friction_energy(at, sliding_moment(at, theta), BRISTLE.into())
    }
}
