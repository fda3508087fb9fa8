//! Hysteresis: a loss in each cycle that does not depend on how fast the cycle is.
//!
//! Law:      M = η EI √(κ² + κ_b²) z,   ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_b
//!
//!   M     moment                                                  N m
//!   η     friction moment over the elastic one                    –
//!   EI    bending stiffness, `rod.bending_stiffness`               N m²
//!   κ     curvature                                               1/m
//!   z     memory: share of the friction moment, between −1 and 1  –
//!   κ̇     rate of curvature                                       1/(m s)
//!   κ̇₀    rate below which what sticks creeps                     1/(m s)
//!   κ_b   curvature over which friction turns round, 0.01 1/m
//!
//! Assumes:  η EI |κ| sgn κ̇, friction in proportion to the present curvature, but for κ_b, which
//!           moves the tip by less than cameras see. A cycle about the straight rod loses 2 η EI κ_a²
//!           per length, so amplitudes fall by exp(−2η) a cycle. About a bent rest it acts as
//!           friction of the moment η EI |κ| there.
//! Off:      loss_coefficient = 0.
//! Silent:   Rest, and rigid motion.
//! Source:   Reid (1956), J. R. Aeronaut. Soc. 60, 283: internal friction with the displacement's
//!           size and the velocity's sign; losses of solids that do not depend on frequency: Kimball
//!           and Lovell (1927), Phys. Rev. 30, 948; memory as in Dahl (1976), AIAA J. 14, 1675, with
//!           |κ̇| made smooth.

use super::memory::{BRISTLE, CREEP_RATE, friction, friction_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator};

/// Moment at which a section slides, N m. Without the bristle's share under the root, what a bent
/// bristle stores would grow faster than it is paid for where a section passes through straight.
fn sliding_moment<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
    theta[0] * at.rod.bending_stiffness * (at.kappa * at.kappa + BRISTLE * BRISTLE).sqrt()
}

/// Loss of the same size at all frequencies.
pub struct Hysteresis;

impl Law for Hysteresis {
    const ABOUT: About = About {
        name: "hysteresis",
        meaning: "a loss in each cycle that does not depend on how fast the cycle is",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: true,
        timed: false,
        parameters: &[
            Parameter {
                name: "loss_coefficient",
                meaning: "friction moment over the elastic moment",
                unit: "",
                default: 0.03,
                range: (0.0, 1.0),
                scale: 0.03,
                off: Some(0.0),
                plausible: Some((0.0, 0.1)),
                ..Parameter::PLAIN
            },
            CREEP_RATE,
        ],
        looks_like: "a straight line of log amplitude over the number of cycles, the same at every pressure and payload",
        confounded_with: &["rayleigh_stiffness", "braid_friction"],
        separated_by: &[Separator::Pressures, Separator::Payload],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(at: &Bend<T>, theta: &[T]) -> Moment<T> {
        friction(at, sliding_moment(at, theta), theta[1], BRISTLE.into())
    }

    fn bend_energy<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
        friction_energy(at, sliding_moment(at, theta), BRISTLE.into())
    }
}
