//! Latent moment: what a moment of unknown cause would have to look like, as a sum of simple terms.
//!
//! Law:      M = EI (c₀ + c₁ κ + c₂ κ² + c₃ κ³ + d₂ |κ̇| κ̇ + d₀ s + d₁ κ² κ̇ + e t),   s = κ̇ / √(κ̇² + κ̇₀²)
//!
//!   M           moment beside all others                              N m
//!   EI          bending stiffness, `rod.bending_stiffness`            N m²
//!   κ           curvature                                             1/m
//!   κ̇           its rate                                              1/(m s)
//!   s           sign of that, which turns round over κ̇₀ = 0.5 1/(m s)   –
//!   t           time since release                                    s
//!   c₀ to c₃    constant, linear, square, cube                        1/m, –, m, m²
//!   d₂, d₀, d₁  rate_square, rate_sign, square_rate                   m s², 1/m, m² s
//!   e           drift                                                 1/(m s)
//!
//! Assumes:  A description, and not a cause. The same law at every bend, so that on the first mode, where
//!           the curvature is q(t) times a shape, it is a force in the first modal coordinate q.
//! Off:      All eight at 0.
//! Silent:   c₀, c₁ and e in swings, the others in small ones, but for d₀.
//! Source:   Terms as in sparse identification: Brunton, Proctor and Kutz (2016), PNAS 113, 3932; an
//!           unknown force on modal coordinates: Rogers and Friis (2022), Mech. Syst. Signal Process. 166.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, named};

/// Rate of curvature over which the sign turns round, 1/(m s): a fiftieth of what a release reaches.
const SIGN_RATE: f64 = 0.5;

/// A moment that is described and not explained.
pub struct LatentMoment;

/// A term, off at 0; a typical size makes a hundredth of the moment of a bend of 3/m that turns at 20/(m s).
const fn term(name: &'static str, meaning: &'static str, unit: &'static str, scale: f64) -> Parameter {
    let (default, range) = (scale, (-1e3 * scale, 1e3 * scale));
    let null_value = Some(0.0);
    Parameter { name, meaning, unit, default, range, scale, null_value, is_part: true, ..Parameter::PLAIN }
}

impl Law for LatentMoment {
    const ABOUT: About = About {
        name: "latent_moment",
        meaning: "what a moment of unknown cause would have to look like; a description, not a cause",
        kind: Kind::Description,
        places: &[Place::Bend],
        memory: 0,
        timed: true,
        parameters: &[
            term("constant", "constant", "1/m", 0.03),
            term("linear", "in proportion to the curvature", "", 0.01),
            term("square", "with the square of the curvature", "m", 3e-3),
            term("cube", "with the cube of the curvature", "m^2", 1e-3),
            term("rate_square", "with the square of the rate of curvature and its sign", "s^2 m", 1e-4),
            term("rate_sign", "with the sign of the rate of curvature", "1/m", 0.03),
            term("square_rate", "with the rate of curvature and the square of the curvature", "m^2 s", 2e-4),
            term("drift", "growing with the time", "1/(m s)", 3e-3),
        ],
        signature: "whatever it is given to look like",
        confounded_with: &["cubic_stiffness", "quadratic_stiffness", "set_curvature", "braid_friction"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [constant, linear, square, cube, rate_square, rate_sign, square_rate, drift] = named(theta);
        let (kappa, rate) = (at.kappa, at.kappa_rate);
        let elastic = constant + (linear + (square + cube * kappa) * kappa) * kappa;
        let pace = if rate.re() < 0.0 { -rate } else { rate };
        let lossy = rate_square * pace * rate
            + rate_sign * rate / (rate * rate + SIGN_RATE * SIGN_RATE).sqrt()
            + square_rate * kappa * kappa * rate;
        Moment::of(at.rod.bending_stiffness * (elastic + lossy + drift * at.time))
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let kappa = at.kappa;
        let [constant, linear, square, cube, .., drift] = named::<T, 8>(theta);
        let terms = cube * 0.25 * kappa + square / 3.0;
        let terms = (terms * kappa + linear * 0.5) * kappa + constant + drift * at.time;
        at.rod.bending_stiffness * terms * kappa
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::cubic_stiffness::CubicStiffness;
    use crate::effects::tests::rod_with;

    /// A description of one term is the effect that has it.
    #[test]
    fn its_cube_is_cubic_stiffness() {
        let rod = rod_with(&[]).rod();
        let at = Bend {
            kappa: 2.0,
            kappa_rate: -7.0,
            mean_square_curvature: 0.0,
            branch: 0,
            memory: 0.0,
            position: 0.3,
            time: 1.2,
            rod: &rod,
        };
        let mut theta = [0.0; 8];
        theta[3] = 2e-3;
        let (found, due) = (LatentMoment.bend(&at, &theta), CubicStiffness.bend(&at, &[2e-3]));
        assert!((found.moment - due.moment).abs() < 1e-15 * due.moment.abs());
        let energy = LatentMoment.bend_energy(&at, &theta) - CubicStiffness.bend_energy(&at, &[2e-3]);
        assert!(energy.abs() < 1e-15, "{energy} J/m");
        theta[4] = 1e-3;
        let lost = LatentMoment.bend(&at, &theta).moment - found.moment;
        assert!((lost + 49e-3 * rod.bending_stiffness).abs() < 1e-12, "{lost} N m");
    }
}
