//! Relaxation: part of the bending stiffness relaxes over a range of times, as in real elastomers.
//!
//! Law:      M = (g/4) EI Σ (κ − z_k),   ż_k = (κ − z_k) / τ_k,   k = 1 … 4
//!
//!   M     moment of the part that relaxes                         N m
//!   g     its stiffness over the one that stays                   –
//!   EI    bending stiffness that stays, `rod.bending_stiffness`    N m²
//!   κ     curvature                                               1/m
//!   z_k   memory: curvature to which branch k has relaxed         1/m
//!   τ_k   τ_s (τ_l/τ_s)^((k − ½)/4)                               s
//!   τ_s   shortest time                                           s
//!   τ_l   longest time                                            s
//!
//! Assumes:  The relaxation spectrum is constant over log time from τ_s to τ_l: at a curvature that
//!           stays, the moment falls by the same amount in each decade between them. The four
//!           branches follow that within 1 % of g for τ_l/τ_s up to 1000. All are relaxed in the
//!           posture of release, unless `[release] history` says otherwise. With τ_s = τ_l it is
//!           one branch: `viscoelastic` or `creep`.
//! Off:      relaxing_stiffness = 0.
//! Silent:   Motion much slower than τ_l. Much faster than τ_s it only stiffens: EI (1 + g).
//! Source:   Generalised Maxwell solid and the box spectrum: Tobolsky (1960), Properties and Structure
//!           of Polymers; Ferry (1980), Viscoelastic Properties of Polymers, ch. 3. In soft tissue
//!           and elastomers: Fung (1993), Biomechanics, sec. 7.6.

use super::memory::{maxwell, maxwell_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A box spectrum of relaxation times in bending.
pub struct Relaxation;

/// Stiffness of branch `k` over the static one, and its relaxation time, s.
fn branch<T: Real>(k: usize, theta: &[T]) -> [T; 2] {
    let [stiffness, shortest, longest] = named(theta);
    let eighth = (longest / shortest).sqrt().sqrt().sqrt();
    [stiffness * 0.25, shortest * eighth.powi(2 * k as i32 + 1)]
}

impl Law for Relaxation {
    const ABOUT: About = About {
        name: "relaxation",
        meaning: "part of the bending stiffness relaxes over a range of times",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 4,
        timed: false,
        parameters: &[
            Parameter {
                name: "relaxing_stiffness",
                meaning: "stiffness that relaxes over the one that stays",
                unit: "",
                default: 0.1,
                range: (0.0, 100.0),
                scale: 0.1,
                null_value: Some(0.0),
                plausible: Some((0.0, 3.0)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "shortest_time",
                meaning: "time at which relaxation begins",
                unit: "s",
                default: 0.05,
                range: (1e-4, 1e6),
                scale: 0.05,
                plausible: Some((0.01, 1.0)),
                tries: &[0.05],
                ..Parameter::PLAIN
            },
            Parameter {
                name: "longest_time",
                meaning: "time at which it ends",
                unit: "s",
                default: 10.0,
                range: (1e-4, 1e6),
                scale: 10.0,
                plausible: Some((1.0, 300.0)),
                tries: &[3.0, 30.0],
                ..Parameter::PLAIN
            },
        ],
        signature: "the rod is stiffer in motion than at rest, loses energy at every frequency, and its mean sinks long after the release",
        confounded_with: &["viscoelastic", "creep", "structural_damping"],
        separated_by: &[Separator::LongRecord, Separator::Payload],
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
