//! Structural damping: each cycle loses the same share of the elastic energy, fast or slow, large or small.
//!
//! Law:      M = EI Σ g_k (κ − z_k),   ż_k = (κ − z_k) / τ_k,   k = 1 … 4
//!
//!   M     moment of the four Maxwell branches                     N m
//!   EI    bending stiffness at rest, `rod.bending_stiffness`       N m²
//!   κ     curvature                                               1/m
//!   z_k   memory: curvature to which branch k has relaxed         1/m
//!   τ_k   20.6, 2.62, 1/2.62 and 1/20.6 times 1/(2π f_m)          s
//!   f_m   middle of the frequency band                            Hz
//!   g_k   stiffness of branch k over EI: η (a_k + b_k η + c_k η²)  –
//!   η     loss factor                                             –
//!
//! Assumes:  The loss modulus of bending is η times its storage modulus, within 3 %, for frequencies
//!           from f_m / 17.8 to 17.8 f_m: 0.17 to 53 Hz by default. The law is linear, so this holds
//!           at every amplitude and about every rest, bent or straight. A mode has the damping ratio
//!           η/2 times the share of bending in its stiffness; weight adds stiffness without loss.
//!           At rest the branches are relaxed and the stiffness is EI. In motion it is higher, as for
//!           every linear solid with such a loss: by 0.6 η per factor of e in frequency.
//! Off:      loss_factor = 0.
//! Silent:   Rest, and rigid motion.
//! Source:   Loss independent of frequency: Kimball and Lovell (1927), Phys. Rev. 30, 948; Bishop
//!           (1955), J. R. Aeronaut. Soc. 59, 738. A power law (spring-pot) has a constant loss factor:
//!           Nutting (1921), J. Franklin Inst. 191, 679. Here a, b and c minimise the largest
//!           deviation from η in the band for η up to 0.3.

use super::memory::{maxwell, maxwell_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// Relaxation times over that of the middle of the band.
const TIMES: [f64; 4] = [20.6, 2.62, 1.0 / 2.62, 1.0 / 20.6];
/// Stiffness of a branch over the static one and over the loss factor: its powers from zero up.
const STIFFNESS: [[f64; 3]; 4] =
    [[1.609, 1.579, -1.906], [1.233, 2.728, 3.088], [1.231, 4.401, 6.385], [1.645, 6.211, 38.77]];

/// A loss factor that does not depend on the frequency.
pub struct StructuralDamping;

/// Stiffness of branch `k` over the static one, and its relaxation time, s.
fn branch<T: Real>(k: usize, theta: &[T]) -> [T; 2] {
    let [loss, middle_frequency] = named(theta);
    let [a, b, c] = STIFFNESS[k];
    let middle = (middle_frequency * std::f64::consts::TAU).recip();
    [loss * ((loss * c + b) * loss + a), middle * TIMES[k]]
}

impl Law for StructuralDamping {
    const ABOUT: About = About {
        name: "structural_damping",
        meaning: "each cycle loses the same share of the elastic energy, fast or slow, large or small",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 4,
        timed: false,
        parameters: &[
            Parameter {
                name: "loss_factor",
                meaning: "loss modulus of bending over its storage modulus",
                unit: "",
                default: 0.05,
                range: (0.0, 0.3),
                scale: 0.05,
                null_value: Some(0.0),
                plausible: Some((0.0, 0.3)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "middle_frequency",
                meaning: "middle of the band of constant loss, which reaches 17.8 times down and up",
                unit: "Hz",
                default: 3.0,
                range: (1e-4, 1e5),
                scale: 3.0,
                ..Parameter::PLAIN
            },
        ],
        signature: "log amplitude falls by the same amount in each cycle, at every amplitude, and by the same share at every frequency",
        confounded_with: &["rayleigh_mass", "rayleigh_stiffness", "viscoelastic", "relaxation"],
        separated_by: &[Separator::Pressures, Separator::Payload],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [share, time] = branch(at.branch, theta);
        maxwell(at, share, time)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [share, _time] = branch(at.branch, theta);
        maxwell_energy(at, share)
    }
}
