//! Small free vibration of an Euler-Bernoulli cantilever with a rigid body at its tip; no weight.
//!
//! With `λ = β L`, `ω² = λ⁴ EI / (m' L⁴)`, `μ = m / (m' L)`, `γ = c / L`, `ι = J / (m' L³)` and
//! `c s ch sh` the cosine, sine, hyperbolic cosine and sine of `λ`, the frequency equation is
//!
//! ```text
//! 1 + c ch − μ λ (s ch − c sh) − 2 γ μ λ² s sh − (ι + μ γ²) λ³ (s ch + c sh) + μ ι λ⁴ (1 − c ch) = 0
//! ```
//!
//! from `w(0) = w'(0) = 0`, `EI w'' = ω² ((J + m c²) w' + m c w)` and `EI w''' = −ω² m (w + c w')`
//! at `L`. Its roots are not hunted for along `λ`, where two close ones hide: the number of natural
//! frequencies below any `λ` is known exactly, and halving an interval on that count finds the
//! `n`-th, whatever its neighbours.
//!
//! Source: equation: To (1982), Vibration of a cantilever beam with a base excitation and tip mass,
//! Journal of Sound and Vibration 83; count: Wittrick and Williams (1971), A general algorithm for
//! computing natural frequencies of elastic structures, Quarterly Journal of Mechanics and Applied
//! Mathematics 24.

use std::f64::consts::PI;

/// A cantilever with mass and a rigid body at its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipBodyBeam {
    /// EI, N m², positive.
    pub bending_stiffness: f64,
    /// Mass per length, kg/m, positive.
    pub mass_per_length: f64,
    /// Length of the beam, m, positive.
    pub length: f64,
    /// Mass of the body, kg, at least 0; up to 1e9 masses of the beam the lowest frequency is good
    /// to 1e-11.
    pub body_mass: f64,
    /// From the beam's end to the body's centre of mass, m, along the beam.
    pub center_offset: f64,
    /// Rotary inertia of the body about its centre of mass, kg m², at least 0.
    pub rotary_inertia: f64,
}

impl TipBodyBeam {
    /// The lowest `count` natural angular frequencies, rad/s, ascending.
    pub fn natural_frequencies(&self, count: usize) -> Vec<f64> {
        let Self { bending_stiffness, mass_per_length, length, .. } = *self;
        let scale = (bending_stiffness / mass_per_length).sqrt() / (length * length);
        (1..=count).map(|n| scale * self.wave_number(n).powi(2)).collect()
    }

    /// `β L` of the `n`-th mode, `n` from 1.
    fn wave_number(&self, n: usize) -> f64 {
        let (mut below, mut above) = (0.0, n as f64 * PI); // a body only lowers what a free end has
        loop {
            let middle = 0.5 * (below + above);
            if middle <= below || middle >= above {
                return middle;
            }
            if self.modes_below(middle) < n { below = middle } else { above = middle }
        }
    }

    /// Number of modes with `β L` below `lambda`: those with the tip clamped, plus the negative
    /// eigenvalues of the stiffness that the vibrating beam and body offer at the tip.
    fn modes_below(&self, lambda: f64) -> usize {
        let beam_mass = self.mass_per_length * self.length;
        let mass = self.body_mass / beam_mass;
        let offset = self.center_offset / self.length;
        let inertia = self.rotary_inertia / (beam_mass * self.length * self.length);

        // All over cosh(lambda), which overflows.
        let (s, c, sh, one) = (lambda.sin(), lambda.cos(), lambda.tanh(), lambda.cosh().recip());
        let clamped = one - c;
        let equation = one + c
            - mass * lambda * (s - c * sh)
            - 2.0 * offset * mass * lambda.powi(2) * s * sh
            - (inertia + mass * offset * offset) * lambda.powi(3) * (s + c * sh)
            + mass * inertia * lambda.powi(4) * clamped;

        let turns = (lambda / PI).floor() as usize;
        let even = if turns.is_multiple_of(2) { 1.0 } else { -1.0 };
        // Below one half turn nothing is there to count, and `1 − c ch` there is all rounding.
        let with_tip_clamped = if turns == 0 || even * clamped > 0.0 { turns } else { turns - 1 };

        // Determinant and first diagonal element of the tip stiffness, up to positive factors.
        let determinant = equation / clamped;
        let against_shift = (s + c * sh) / clamped - lambda * mass;
        let negative = match (determinant < 0.0, against_shift < 0.0) {
            (true, _) => 1,
            (false, true) => 2,
            (false, false) => 0,
        };
        with_tip_clamped + negative
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    const FREE: TipBodyBeam = TipBodyBeam {
        bending_stiffness: 1.0,
        mass_per_length: 1.0,
        length: 1.0,
        body_mass: 0.0,
        center_offset: 0.0,
        rotary_inertia: 0.0,
    };

    /// Without a body the equation is `c ch = −1`; its roots are in every handbook.
    #[test]
    fn a_free_end_has_the_handbook_frequencies() {
        let expected = [1.8751040687119611, 4.694091132974174, 7.854757438237613];
        for (omega, beta) in FREE.natural_frequencies(3).into_iter().zip(expected) {
            assert!((omega.sqrt() / beta - 1.0).abs() < 1e-14, "{omega} is not {beta} squared");
        }
        let scaled = TipBodyBeam { bending_stiffness: 8.0, mass_per_length: 2.0, length: 3.0, ..FREE };
        let ratio = scaled.natural_frequencies(1)[0] / FREE.natural_frequencies(1)[0];
        assert!((ratio - 2.0 / 9.0).abs() < 1e-15);
    }

    /// A beam without mass is a spring of two degrees of freedom: deflection and slope of its end.
    #[test]
    fn a_heavy_body_swings_on_a_massless_beam() {
        let heavy = |c, j| TipBodyBeam { body_mass: 1e6, center_offset: c, rotary_inertia: j * 1e6, ..FREE };
        // A third of a millionth of the body's mass is the beam's; so much is neglected.
        let tolerance = 1e-6;
        let point = heavy(0.0, 0.0).natural_frequencies(1)[0];
        assert!((point / (3.0 / 1e6f64).sqrt() - 1.0).abs() < tolerance);

        let (m, c, j) = (1e6, 0.3, 0.2);
        let [m11, m12, m22]: [f64; 3] = [m, m * c, j * m + m * c * c];
        let quadratic: [f64; 3] = [m11 * m22 - m12 * m12, -(12.0 * m22 + 4.0 * m11 + 12.0 * m12), 12.0];
        let root = (quadratic[1].powi(2) - 4.0 * quadratic[0] * quadratic[2]).sqrt();
        let squares = [-root, root].map(|root| (-quadratic[1] + root) / (2.0 * quadratic[0]));
        for (omega, square) in heavy(c, j).natural_frequencies(2).into_iter().zip(squares) {
            assert!((omega / square.sqrt() - 1.0).abs() < tolerance, "{omega}, {square}");
        }
    }

    /// Finite elements with cubic shape functions, consistent mass, and the body on the last node.
    fn by_finite_elements(beam: &TipBodyBeam, elements: usize, count: usize) -> Vec<f64> {
        let h = beam.length / elements as f64;
        let size = 2 * elements;
        let mut k = DMatrix::<f64>::zeros(size + 2, size + 2);
        let mut m = k.clone();
        let stiffness = [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
        ];
        let mass = [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
        ];
        for element in 0..elements {
            for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                let at = (2 * element + i, 2 * element + j);
                k[at] += beam.bending_stiffness / h.powi(3) * stiffness[i][j];
                m[at] += beam.mass_per_length * h / 420.0 * mass[i][j];
            }
        }
        let TipBodyBeam { body_mass, center_offset, rotary_inertia, .. } = *beam;
        m[(size, size)] += body_mass;
        m[(size, size + 1)] += body_mass * center_offset;
        m[(size + 1, size)] += body_mass * center_offset;
        m[(size + 1, size + 1)] += rotary_inertia + body_mass * center_offset.powi(2);

        // Over the inverse stiffness, so that the low modes are the large, exact eigenvalues.
        let lower = k.view((2, 2), (size, size)).into_owned().cholesky().unwrap().l();
        let half = lower.solve_lower_triangular(&m.view((2, 2), (size, size)).into_owned()).unwrap();
        let whole = lower.solve_lower_triangular(&half.transpose()).unwrap();
        let mut squares: Vec<f64> = whole.symmetric_eigenvalues().iter().copied().collect();
        squares.sort_by(|a, b| b.total_cmp(a));
        squares.iter().take(count).map(|square| square.sqrt().recip()).collect()
    }

    #[test]
    fn finite_elements_agree_for_light_heavy_offset_and_spinning_bodies() {
        let (elements, count) = (40, 7);
        let bodies = [
            (0.0, 0.0, 0.0),
            (0.3, 0.0, 0.0),
            (2.3, 0.08, 0.003), // about the muscle of the paper at 5 psi
            (0.5, -0.4, 0.0),   // centre of mass behind the end
            (0.0, 0.0, 0.7),    // a flywheel
            (40.0, 0.7, 9.0),
            (1e-3, 3.0, 5.0),
        ];
        for (body_mass, center_offset, rotary_inertia) in bodies {
            let beam = TipBodyBeam { body_mass, center_offset, rotary_inertia, ..FREE };
            let approximate = by_finite_elements(&beam, elements, count);
            for (exact, approximate) in beam.natural_frequencies(count).iter().zip(approximate) {
                // Fourth order in element length, by the coefficient of the consistent mass:
                // omega is too high by (beta h)^4 / 1440; the rest is rounding of the stiffness.
                let error = (exact.sqrt() / elements as f64).powi(4) / 1440.0;
                let measured = approximate / exact - 1.0;
                assert!(
                    (-1e-8..3.0 * error + 1e-8).contains(&measured),
                    "{beam:?}: {exact} rad/s, finite elements are off by {measured:e}"
                );
            }
        }
    }
}
