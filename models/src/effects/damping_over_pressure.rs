//! Damping over pressure: both of Rayleigh's losses grow in proportion to the pressure.
//!
//! Law:      F = −a p̂ m v,   T = b p̂ EA ε̇,   M = b p̂ EI κ̇,   p̂ = max(p, 0) / p_ref
//!
//!   F        force on a mass                                       N
//!   T, M     tension of an edge, moment of a bend                  N, N m
//!   a        rate of mass damping that p_ref adds                  1/s
//!   b        time of stiffness damping that p_ref adds             s
//!   p        pressure inside above ambient, `rod.pressure`         Pa
//!   p_ref    pressure at which a and b are given                   Pa
//!   EA, EI   `rod.axial_stiffness`, `rod.bending_stiffness`         N, N m²
//!
//! Assumes:  A straight line over pressure. It adds to `rayleigh_mass` and `rayleigh_stiffness`,
//!           whose rates become those without pressure: α + a p̂ and β + b p̂ in all. With a and b from
//!           zero up it takes energy at every pressure; a loss that falls with pressure it cannot
//!           give, because such a line would feed energy somewhere.
//! Off:      mass_rate = 0, if stiffness_time = 0 as well.
//! Silent:   Rest, and any motion at one pressure only: there it is Rayleigh's damping.
//! Source:   First terms over pressure of Rayleigh's rates; Garbulinski and Wereley (2022) measured a
//!           damping ratio that grows 4.5 times from 5 to 100 psi.

use super::{
    About, Bend, Edge, Kind, Law, Mass, MassLoad, Moment, Parameter, Place, Reach, Real, Separator, named,
    relative_pressure,
};

/// Losses that grow with the pressure.
pub struct DampingOverPressure;

impl Law for DampingOverPressure {
    const ABOUT: About = About {
        name: "damping_over_pressure",
        meaning: "both of Rayleigh's losses grow in proportion to the pressure",
        kind: Kind::Dissipative,
        places: &[Place::Bend, Place::Edge, Place::Mass],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "stiffness_time",
                meaning: "time of stiffness damping that the reference pressure adds",
                unit: "s",
                default: 1e-3,
                range: (0.0, 1e3),
                scale: 1e-3,
                null_value: Some(0.0),
                is_part: true,
                plausible: Some((0.0, 0.05)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "mass_rate",
                meaning: "rate of mass damping that the reference pressure adds",
                unit: "1/s",
                default: 0.0,
                range: (0.0, 1e6),
                scale: 0.5,
                null_value: Some(0.0),
                is_part: true,
                plausible: Some((0.0, 5.0)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "reference_pressure",
                meaning: "pressure at which the other two are given",
                unit: "Pa",
                default: 1e5,
                range: (1.0, 1e9),
                scale: 1e5,
                ..Parameter::PLAIN
            },
        ],
        signature: "the damping ratio rises with the pressure, along a straight line",
        confounded_with: &["rayleigh_stiffness", "rayleigh_mass", "braid_friction"],
        separated_by: &[Separator::Pressures],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [stiffness_time, _, reference] = named(theta);
        Moment::of(
            stiffness_time * relative_pressure(at.rod, reference) * at.rod.bending_stiffness * at.kappa_rate,
        )
    }

    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        let [stiffness_time, _, reference] = named(theta);
        stiffness_time * relative_pressure(at.rod, reference) * at.rod.axial_stiffness * at.stretch_rate
    }

    fn mass<T: Real>(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        let [_, mass_rate, reference] = named(theta);
        let zero = T::from(0.0);
        MassLoad { acceleration: [zero; 2], rate: mass_rate * relative_pressure(at.rod, reference) }
    }
}

#[cfg(test)]
mod tests {
    use super::DampingOverPressure as Effect;
    use super::*;
    use crate::effects::Rod;
    use crate::effects::rayleigh_stiffness::RayleighStiffness;

    /// At the reference pressure it is Rayleigh's loss, at twice that twice as much, and below ambient
    /// nothing.
    #[test]
    fn the_loss_is_in_proportion_to_the_pressure() {
        let moment = |pressure: f64| {
            let rod = Rod {
                length: 0.2,
                mass: 0.02,
                bending_stiffness: 0.007,
                axial_stiffness: 300.0,
                diameter: 0.03,
                pressure,
            };
            let bend = Bend {
                kappa: 3.0,
                kappa_rate: 20.0,
                mean_square_curvature: 0.0,
                branch: 0,
                memory: 0.0,
                position: 0.5,
                time: 0.0,
                rod: &rod,
            };
            [
                Effect.bend(&bend, &[4e-3, 0.5, 1e5]).moment,
                RayleighStiffness.bend(&bend, &[4e-3]).moment,
                Effect.mass(&Mass { time: 0.0, rod: &rod }, &[4e-3, 0.5, 1e5]).rate,
            ]
        };
        let [at_reference, rayleigh, rate] = moment(1e5);
        assert_eq!((at_reference, rate), (rayleigh, 0.5));
        assert_eq!((moment(2e5)[0], moment(2e5)[2]), (2.0 * rayleigh, 1.0));
        assert_eq!((moment(-2e4)[0], moment(-2e4)[2]), (0.0, 0.0));
    }
}
