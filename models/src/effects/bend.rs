//! Bending: each bend resists curvature in proportion to it.
//!
//! Law:      M = EI κ,   κ = 2 tan(φ/2) / ℓ
//!
//!   M    bending moment                               N m
//!   EI   bending stiffness, `rod.bending_stiffness`    N m²
//!   κ    curvature                                    1/m
//!   φ    turning angle from one edge to the next      rad
//!   ℓ    Voronoi length of the bend                   m
//!
//! Assumes:  The unloaded rod is straight; EI is the same along the rod, and in motion as at rest.
//! Off:      rod.bending_stiffness = 0.
//! Silent:   Any motion that keeps the rod straight in line with the clamp.
//! Source:   Garbulinski and Wereley (2022), eq. 4 and 5, E_b; Goldberg et al. (2019).

use super::{About, Bend, Kind, Law, Moment, Place, Reach, Real};

/// Resistance to bending.
pub struct Bending;

impl Law for Bending {
    const ABOUT: About = About {
        name: "bend",
        meaning: "each bend resists curvature in proportion to it",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[],
        signature: "sets the rest posture and, with the masses, the frequency of the swing",
        confounded_with: &["end_fitting", "payload"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, _theta: &[T]) -> Moment<T> {
        Moment::of(at.rod.bending_stiffness * at.kappa)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, _theta: &[T]) -> T {
        at.rod.bending_stiffness * at.kappa * at.kappa * 0.5
    }
}
