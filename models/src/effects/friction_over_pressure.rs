//! Friction over pressure: strands that rub on one another slide at a moment that grows with the pressure.
//!
//! Law:      M = M_p p̂ z,   ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_b,   p̂ = max(p, 0) / p_ref
//!
//!   M       moment                                                N m
//!   M_p     friction moment that p_ref adds                       N m
//!   p       pressure inside above ambient, `rod.pressure`         Pa
//!   p_ref   pressure at which M_p is given                        Pa
//!   z       memory: share of the friction moment, −1 to 1         –
//!   κ̇       rate of curvature                                     1/(m s)
//!   κ̇₀      rate below which what sticks creeps                   1/(m s)
//!   κ_b     curvature over which friction turns round, 0.01 1/m
//!
//! Assumes:  Friction in proportion to the contact force of the strands, and that in proportion to the
//!           pressure. It adds to `braid_friction`, whose moment does not depend on the pressure:
//!           M_f + M_p p̂ in all. The same moment in every section. When the rod is let go z = 0, unless
//!           `[release] history` says otherwise.
//! Off:      friction_moment = 0.
//! Silent:   Rest, and rigid motion. At one pressure it is `braid_friction`.
//! Source:   Tondu (2012), J. Intell. Mater. Syst. Struct. 23, 225: friction of the strands in a braided
//!           muscle is Coulomb's, with the contact pressure that the inner pressure makes; Chou and
//!           Hannaford (1996), IEEE Trans. Robot. Autom. 12, 90; memory as in Dahl (1976), AIAA J. 14,
//!           1675, with |κ̇| made smooth.

use super::memory::{BRISTLE, CREEP_RATE, FRICTION_MOMENT, friction, friction_energy};
use super::{
    About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named, relative_pressure,
};

/// Coulomb's friction that grows with the pressure.
pub struct FrictionOverPressure;

/// Moment at which a section slides, N m.
fn sliding_moment<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
    let [friction_moment, _, reference] = named(theta);
    friction_moment * relative_pressure(at.rod, reference)
}

impl Law for FrictionOverPressure {
    const ABOUT: About = About {
        name: "friction_over_pressure",
        meaning: "strands that rub on one another slide at a moment that grows with the pressure",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            // Not tried by diagnoses on its own: over few pressures it cannot be distinguished from `braid_friction`, whose moment a
            // fit finds at each pressure anyway.
            Parameter {
                meaning: "friction moment that the reference pressure adds",
                plausible: None,
                ..FRICTION_MOMENT
            },
            CREEP_RATE,
            Parameter {
                name: "reference_pressure",
                meaning: "pressure at which the friction moment is given",
                unit: "Pa",
                default: 1e5,
                range: (1.0, 1e9),
                scale: 1e5,
                ..Parameter::PLAIN
            },
        ],
        signature: "amplitude falls on a straight line to an early stop, the steeper the higher the pressure",
        confounded_with: &["braid_friction", "damping_over_pressure", "dahl"],
        separated_by: &[Separator::Pressures],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [_, creep_rate] = named(theta);
        friction(at, sliding_moment(at, theta), creep_rate, BRISTLE.into())
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        friction_energy(at, sliding_moment(at, theta), BRISTLE.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::braid_friction::BraidFriction;
    use crate::effects::tests::rod_with;

    /// At the reference pressure it is braid friction, at twice that twice as much, and below ambient none.
    #[test]
    fn the_moment_is_in_proportion_to_the_pressure() {
        let moments = |pressure: f64| {
            let rod = crate::effects::Rod { pressure, ..rod_with(&[]).rod() };
            let at = Bend {
                kappa: 3.0,
                kappa_rate: 20.0,
                mean_square_curvature: 0.0,
                branch: 0,
                memory: 0.7,
                position: 0.5,
                time: 0.0,
                rod: &rod,
            };
            let own = FrictionOverPressure.bend(&at, &[5e-4, 0.02, 1e5]);
            let braid = BraidFriction.bend(&at, &[5e-4, 0.02]);
            assert_eq!(own.memory_rate, braid.memory_rate);
            [own.moment, braid.moment]
        };
        let [own, braid] = moments(1e5);
        assert_eq!(own, braid);
        assert_eq!(moments(2e5)[0], 2.0 * braid);
        assert_eq!(moments(-2e4)[0], 0.0);
    }
}
