//! Pressure and volume: bending the sealed muscle anywhere stiffens it everywhere.
//!
//! Law:      M = EI c ⟨κ²⟩ κ
//!
//!   M      moment beside the linear one                         N m
//!   EI     bending stiffness, `rod.bending_stiffness`            N m²
//!   c      how much a mean square curvature of 1/m² stiffens    m²
//!   ⟨κ²⟩   mean square curvature over the rod                   1/m²
//!   κ      curvature                                            1/m
//!
//! Assumes:  The valve is shut, and bending takes volume from the gas in proportion to ⟨κ²⟩, so that its
//!           pressure rises in proportion to it, in all of the muscle at once and without loss.
//!           Elastic, with the energy ¼ EI c L ⟨κ²⟩² in all, L the active length.
//! Off:      stiffening = 0.
//! Silent:   Small bending.
//! Source:   Boyle's law to first order in the change of volume, and the volume of a tube to second
//!           order in its curvature.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator};

/// A bending stiffness that follows the shape of the whole rod.
pub struct PressureVolume;

impl Law for PressureVolume {
    const ABOUT: About = About {
        name: "pressure_volume",
        meaning: "bending the sealed muscle anywhere stiffens it everywhere",
        kind: Kind::Elastic,
        places: &[Place::Bend, Place::Whole],
        memory: false,
        timed: false,
        parameters: &[Parameter {
            name: "stiffening",
            meaning: "share of the linear moment at a mean square curvature of 1/m^2",
            unit: "m^2",
            default: 1e-3,
            range: (-1.0, 1.0),
            scale: 1e-3,
            off: Some(0.0),
            plausible: Some((-3e-3, 3e-3)),
            ..Parameter::PLAIN
        }],
        looks_like: "large swings are faster than small ones, by the same share all along the rod",
        confounded_with: &["cubic_stiffness", "hose"],
        separated_by: &[Separator::Valve, Separator::Pressures],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(at: &Bend<T>, theta: &[T]) -> Moment<T> {
        Moment::of(theta[0] * at.rod.bending_stiffness * at.mean_square_curvature * at.kappa)
    }

    fn bend_energy<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
        theta[0] * at.rod.bending_stiffness * at.mean_square_curvature * at.kappa * at.kappa * 0.25
    }
}
