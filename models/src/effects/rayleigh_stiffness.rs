//! Rayleigh stiffness damping: stretch and bending resist their rates as they resist themselves.
//!
//! Law:      T = β EA ε̇,   M = β EI κ̇
//!
//!   T, M     tension of an edge, moment of a bend                  N, N m
//!   β        time                                                  s
//!   EA, EI   `rod.axial_stiffness`, `rod.bending_stiffness`          N, N m²
//!   ε̇, κ̇     rates of stretch and of curvature                     1/s, 1/(m s)
//!
//! Assumes:  Kelvin and Voigt's solid. In generalised coordinates the force is −β Gᵀ C G v, with G
//!           the strain-displacement matrix of the present posture and C the material stiffness:
//!           the material part of the tangent, so that a rigid rotation is never damped.
//!           Strains are measured against the rest length ℓ. Where the pressure changes ℓ, their rates
//!           include its rate: ε̇ = (e/ℓ)˙ and κ̇ = (K/ℓ)˙, with e the length of an edge and K the
//!           integrated curvature of a bend. So a rod that grows as its rest length does feels no
//!           force, and one that is held back feels β EA ℓ̇/ℓ. The regulator pays for that. Left out is
//!           how fast a compliant clamp's share of the root's rotation changes with EI.
//! Off:      beta = 0.
//! Silent:   Any rigid motion.
//! Source:   Clough and Penzien (2003), section 12-3, ζ = β ω / 2; rate form as in
//!           Garbulinski and Wereley's (2022) eq. 5 with strains replaced by their rates.

use super::{About, Bend, Edge, Kind, Law, Moment, Parameter, Place, Reach, Real, named};

/// Loss in proportion to strain rate.
pub struct RayleighStiffness;

impl Law for RayleighStiffness {
    const ABOUT: About = About {
        name: "rayleigh_stiffness",
        meaning: "stretch and bending resist their rates as they resist themselves",
        kind: Kind::Dissipative,
        places: &[Place::Bend, Place::Edge],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "beta",
            meaning: "time that turns stiffness into damping",
            unit: "s",
            default: 0.0,
            range: (0.0, 1e3),
            scale: 0.01,
            null_value: Some(0.0),
            ..Parameter::PLAIN
        }],
        signature: "higher modes die first; log amplitude falls on a straight line, steeper the faster the mode",
        confounded_with: &["rayleigh_mass", "viscoelastic"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [beta] = named(theta);
        Moment::of(beta * at.rod.bending_stiffness * at.kappa_rate)
    }

    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        let [beta] = named(theta);
        beta * at.rod.axial_stiffness * at.stretch_rate
    }
}
