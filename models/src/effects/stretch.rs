//! Stretch: each edge resists a change of its length in proportion to its stretch.
//!
//! Law:      T = EA (‖e‖ / ℓ − 1)
//!
//!   T    tension of an edge                     N
//!   EA   axial stiffness, `rod.axial_stiffness`  N
//!   ‖e‖  current length of the edge             m
//!   ℓ    its rest length, L/N                   m
//!
//! Assumes:  Small strain; EA is the same along the rod.
//! Off:      Never: without it the rod would come apart.
//! Silent:   Any motion that keeps every edge at its rest length.
//! Source:   Garbulinski and Wereley (2022), eq. 5, E_s; EA by their eq. 8.

use super::{About, Edge, Kind, Law, Place, Reach, Real};

/// Resistance to stretch.
pub struct Stretch;

impl Law for Stretch {
    const ABOUT: About = About {
        name: "stretch",
        meaning: "each edge resists a change of its length in proportion to its stretch",
        kind: Kind::Elastic,
        places: &[Place::Edge],
        memory: 0,
        timed: false,
        parameters: &[],
        signature: "the tip swings on a slightly wider path at the bottom of the swing, where the pull is largest",
        confounded_with: &[],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn edge<T: Real>(&self, at: &Edge<T>, _theta: &[T]) -> T {
        at.rod.axial_stiffness * at.stretch
    }

    fn edge_energy<T: Real>(&self, at: &Edge<T>, _theta: &[T]) -> T {
        at.rod.axial_stiffness * at.stretch * at.stretch * 0.5
    }
}
