//! Dahl friction: friction that remembers; it yields as a spring before it slides.
//!
//! Law:      M = M_f z,   ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_y
//!
//!   M     moment                                             N m
//!   M_f   moment at which the section slides                 N m
//!   z     memory: share of that moment, between −1 and 1     –
//!   κ̇     rate of curvature                                  1/(m s)
//!   κ̇₀    rate below which what sticks creeps                1/(m s)
//!   κ_y   curvature over which friction builds up            1/m
//!
//! Assumes:  The path counts, and hardly its speed: what sticks creeps only within κ_y / κ̇₀. It stores
//!           ½ M_f κ_y z² and loses M_f z² √(κ̇² + κ̇₀²). When the rod is let go nothing is strained:
//!           z = 0.
//! Off:      friction_moment = 0.
//! Silent:   Rest; much less motion than κ_y only stiffens, EI + M_f / κ_y.
//! Source:   Dahl (1976), AIAA J. 14, 1675, with exponent one and |κ̇| made smooth.

use super::memory::{CREEP_RATE, FRICTION_MOMENT, friction, friction_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator};

/// Dahl's friction in every cross-section.
pub struct Dahl;

impl Law for Dahl {
    const ABOUT: About = About {
        name: "dahl",
        meaning: "friction that remembers: it yields as a spring before it slides",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            FRICTION_MOMENT,
            Parameter {
                name: "yield_curvature",
                meaning: "curvature over which friction builds up",
                unit: "1/m",
                default: 0.5,
                range: (1e-4, 1e4),
                scale: 0.5,
                plausible: Some((0.02, 5.0)),
                tries: &[0.1, 0.5, 2.0],
                ..Parameter::PLAIN
            },
            Parameter { tries: &[], ..CREEP_RATE },
        ],
        looks_like: "small swings are faster and lose less than friction would; the rest depends on where the swing came from",
        confounded_with: &["braid_friction", "clamp_friction", "cubic_stiffness"],
        separated_by: &[Separator::Angles],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(at: &Bend<T>, theta: &[T]) -> Moment<T> {
        friction(at, theta[0], theta[2], theta[1])
    }

    fn bend_energy<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
        friction_energy(at, theta[0], theta[1])
    }
}
