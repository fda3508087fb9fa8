//! Dahl and Bouc-Wen friction: friction that remembers; it yields as a spring before it slides.
//!
//! Law:      M = M_f z,   ż = (κ̇ − σ |z|ⁿ⁻¹ z √(κ̇² + κ̇₀²) + (σ − 1) |z|ⁿ κ̇) / κ_y
//!
//!   M     moment                                             N m
//!   M_f   moment at which the section slides                 N m
//!   z     memory: share of that moment, between −1 and 1     –
//!   κ̇     rate of curvature                                  1/(m s)
//!   κ̇₀    rate below which what sticks creeps                1/(m s)
//!   κ_y   curvature over which friction builds up            1/m
//!   n     exponent: how sharply it yields                    –
//!   σ     loop shape: 1 is a loop that unloads as it loads;  –
//!         more unloads stiffer, less unloads softer
//!
//! Assumes:  The path counts, and hardly its speed: what sticks creeps only within κ_y / κ̇₀. With n = 1 and
//!           σ = 1, the defaults, it is Dahl's friction; others are Bouc and Wen's in its normalised form,
//!           β/(β + γ) = σ. It stores ½ M_f κ_y z² and loses M_f |z|ⁿ⁺¹ (σ √(κ̇² + κ̇₀²) − (σ − 1) κ̇ sgn z),
//!           which is not negative, for σ is at least ½. When the rod is let go nothing is strained, z = 0,
//!           unless `[release] history` says otherwise.
//! Off:      friction_moment = 0.
//! Silent:   Rest; much less motion than κ_y only stiffens, EI + M_f / κ_y.
//! Source:   Dahl (1976), AIAA J. 14, 1675, with his exponent one; Bouc (1967), Proc. 4th Conf. Nonlinear
//!           Oscill.; Wen (1976), J. Eng. Mech. Div. ASCE 102, 249; normalised by Ikhouane and Rodellar
//!           (2007), Systems with Hysteresis, ch. 4; survey: Ismail, Ikhouane and Rodellar (2009), Arch.
//!           Comput. Methods Eng. 16, 161. |κ̇| is made smooth in the term of σ.

use super::memory::{CREEP_RATE, FRICTION_MOMENT, friction_energy};
use super::{About, Bend, Kind, Law, Moment, Parameter, Per, Place, Reach, Real, Separator, named};
use crate::formula::power;

/// Friction of Dahl, and of Bouc and Wen, in every cross-section.
pub struct Dahl;

impl Law for Dahl {
    const ABOUT: About = About {
        name: "dahl",
        meaning: "friction that remembers: it yields as a spring before it slides; Bouc-Wen with other shapes",
        kind: Kind::Dissipative,
        places: &[Place::Bend],
        memory: 1,
        timed: false,
        parameters: &[
            FRICTION_MOMENT,
            Parameter {
                name: "yield_curvature",
                meaning: "curvature over which friction builds up",
                unit: "1/m",
                default: 0.5,
                range: (1e-4, 1e4),
                scale: 0.5,
                plausible: Some((0.006, 1.5)),
                per: Per::Curvature,
                tries: &[0.02, 0.1, 0.4],
                ..Parameter::PLAIN
            },
            Parameter { tries: &[], ..CREEP_RATE },
            Parameter {
                name: "exponent",
                meaning: "Bouc-Wen exponent: how sharply it yields",
                unit: "",
                default: 1.0,
                range: (1.0, 20.0),
                scale: 2.0,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "loop_shape",
                meaning: "Bouc-Wen shape of the loop: 1 unloads as it loads, more unloads stiffer",
                unit: "",
                default: 1.0,
                range: (0.5, 10.0),
                scale: 2.0,
                ..Parameter::PLAIN
            },
        ],
        signature: "small swings are faster and lose less than friction would; the rest depends on where the swing came from",
        confounded_with: &["braid_friction", "clamp_friction", "cubic_stiffness"],
        separated_by: &[Separator::Angles],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [sliding, yielding, creep_rate, exponent, shape] = named(theta);
        let (z, kappa_rate) = (at.memory, at.kappa_rate);
        let pace = (kappa_rate * kappa_rate + creep_rate * creep_rate).sqrt();
        // `|z|ᵖ⁻¹ z` has the limit 0.
        let is_limit = z.re() == 0.0 && exponent.re() < 1.0;
        let slope = if is_limit { T::from(0.0) } else { power(z.abs(), exponent - 1.0) };
        let used = slope * (shape * z * pace - (shape - 1.0) * z.abs() * kappa_rate);
        Moment { moment: sliding * z, memory_rate: (kappa_rate - used) / yielding }
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [sliding, yielding] = named(theta);
        friction_energy(at, sliding, yielding)
    }
}
