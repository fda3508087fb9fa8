//! Braid friction: strands that rub on one another resist bending with a moment of fixed size.
//!
//! Law:      M = M_f z,   ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_b
//!
//!   M     moment                                                N m
//!   M_f   friction moment of a cross-section                    N m
//!   z     memory: share of that moment, between −1 and 1        –
//!   κ̇     rate of curvature                                     1/(m s)
//!   κ̇₀    rate below which what sticks creeps                   1/(m s)
//!   κ_b   curvature over which friction turns round, 0.01 1/m
//!
//! Assumes:  The same moment in every section, whatever the load. In steady motion the moment is the
//!           smooth step M_f κ̇/√(κ̇² + κ̇₀²). It is reached over κ_b, which moves the tip by less than
//!           cameras see: the step itself, as a function of κ̇, changes its slope faster than an
//!           integrator can follow. An offset that friction holds creeps back within some
//!           M_f / (EI κ̇₀). When the rod is let go z = 0, unless
//!           `[release] history` says otherwise.
//! Off:      friction_moment = 0.
//! Silent:   Rest, and rigid motion.
//! Source:   Strand on strand in braided muscles: Tondu (2012), J. Intell. Mater. Syst. Struct. 23,
//!           225; the straight envelope: Feeny and Liang (1996), J. Sound Vib. 195, 149; memory as in
//!           Dahl (1976), AIAA J. 14, 1675, with |κ̇| made smooth.

use super::memory::{BRISTLE, CREEP_RATE, FRICTION_MOMENT, friction, friction_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// Coulomb's friction in every cross-section.
pub struct BraidFriction;

impl Law for BraidFriction {
    const ABOUT: About = About {
        name: "braid_friction",
        meaning: "strands that rub on one another resist bending with a moment of fixed size",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            Parameter { meaning: "friction moment of a cross-section", ..FRICTION_MOMENT },
            CREEP_RATE,
        ],
        signature: "amplitude falls on a straight line to an early stop, away from the rest that weight alone would give",
        confounded_with: &["hysteresis", "clamp_friction", "dahl"],
        separated_by: &[Separator::Angles, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [friction_moment, creep_rate] = named(theta);
        friction(at, friction_moment, creep_rate, BRISTLE.into())
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [friction_moment] = named(theta);
        friction_energy(at, friction_moment, BRISTLE.into())
    }
}
