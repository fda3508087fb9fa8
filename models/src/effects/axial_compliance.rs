//! Axial compliance: the muscle gives way along itself more than its axial stiffness says.
//!
//! Law:      T = [1 / (1/EA + c) − EA] ε = −EA ε · c EA / (1 + c EA)
//!
//!   T    tension beside that of the rod, which it lowers   N
//!   EA   axial stiffness, `rod.axial_stiffness`             N
//!   c    strain per tension, in series with 1/EA           1/N
//!   ε    stretch                                           –
//!
//! Assumes:  Elastic and without mass, spread along the rod. What damps the stretch in proportion to
//!           EA is left as it is.
//! Off:      compliance = 0.
//! Silent:   Any motion without tension.
//! Source:   Two springs in series.

use super::{About, Edge, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// A spring in series with the axial stiffness.
pub struct AxialCompliance;

/// What the spring in series adds to the axial stiffness, N: less than zero.
fn added_stiffness<T: Real>(at: &Edge<T>, theta: &[T]) -> T {
    let [compliance] = named(theta);
    let ratio = compliance * at.rod.axial_stiffness;
    -at.rod.axial_stiffness * ratio / (ratio + 1.0)
}

impl Law for AxialCompliance {
    const ABOUT: About = About {
        name: "axial_compliance",
        meaning: "the muscle gives way along itself more than its axial stiffness says",
        kind: Kind::Elastic,
        places: &[Place::Edge],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "compliance",
            meaning: "strain per tension, beside that of the axial stiffness",
            unit: "1/N",
            default: 1e-3,
            range: (0.0, 1e3),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((0.0, 0.01)),
            ..Parameter::PLAIN
        }],
        signature: "the tip swings on a wider path at the bottom of the swing, where the pull is largest",
        confounded_with: &["stretch", "tip_offset"],
        separated_by: &[Separator::BodyMarkers, Separator::ThirdAxis],
        reach: Reach::Muscle,
    };

    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        added_stiffness(at, theta) * at.stretch
    }

    fn edge_energy<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        added_stiffness(at, theta) * at.stretch * at.stretch * 0.5
    }
}
