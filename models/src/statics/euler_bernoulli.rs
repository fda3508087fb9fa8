//! The Euler-Bernoulli beam of the paper: small-deflection z over x, walked along x until the
//! curve is as long as the muscle.
//!
//! ```text
//! z(x) = −q x² (x² + 6 L² − 4 L x) / (24 EI) − P x² (3 (L + ΔL) − x) / (6 EI)       eq. 1-3
//! ∫₀^x_end √(1 + z'²) dx = L
//! ```
//!
//! | symbol | code | unit |
//! |---|---|---|
//! | EI | `bending_stiffness` | N m² |
//! | L, ΔL | `length`, `tip_offset` | m |
//! | q | `weight_per_length` | N/m |
//! | P | `tip_weight` | N |
//!
//! Weights are positive numbers and pull towards −z: the equations contain the minus signs. The
//! curvature is `z''` and the lever arms are those of the undeformed beam, so the curve is too steep
//! where slopes pass one; the walk only mends its length.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Modeling, eqs. 1-3.

use crate::{
    analytical::{
        Pose,
        cantilever::{Cantilever, Deflection},
    },
    root::bisect,
};

/// The muscle as an Euler-Bernoulli beam under its own weight and that of its end fitting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerBernoulli {
    /// EI, N m², positive. It belongs to this model: the rod needs another for the same tip.
    pub bending_stiffness: f64,
    /// Active length, m, positive.
    pub length: f64,
    /// Weight of bladder and braid per length, N/m; positive pulls towards −z.
    pub weight_per_length: f64,
    /// Weight of end fitting and marker cap, N; positive pulls towards −z.
    pub tip_weight: f64,
    /// From the end of the active length to the end fitting's centre of mass, m.
    pub tip_offset: f64,
}

impl EulerBernoulli {
    /// Deflection at `x`, m, in `0 <= x <= length`: eq. 3.
    pub fn deflection(&self, x: f64) -> Deflection {
        let Self { bending_stiffness, length, .. } = *self;
        let active = Cantilever { bending_stiffness, length };
        // Eq. 2 puts the weight beyond the end, at L + ΔL.
        let with_fitting = Cantilever { length: length + self.tip_offset, ..active };
        active.uniform_load(-self.weight_per_length, x) + with_fitting.tip_load(-self.tip_weight, x)
    }

    /// Length of the curve from the clamp to `x`, m; good to 1e-13 of it.
    /// # Panics
    /// If the bending stiffness is not positive, or a number of the beam or `x` is not finite.
    pub fn arc_length(&self, x: f64) -> f64 {
        let stretch = |x: f64| self.deflection(x).slope.hypot(1.0);
        let whole = gauss(&stretch, 0.0, x);
        assert!(self.bending_stiffness > 0.0 && whole.is_finite(), "no curve up to {x} m: {self:?}");
        adaptive_gauss(&stretch, 0.0, x, whole)
    }

    /// The point at arc length `s`, m, in `0 <= s <= length`, found by walking along x.
    pub fn at(&self, s: f64) -> Pose {
        let x = if s == 0.0 { 0.0 } else { bisect(0.0, s, |x| self.arc_length(x) - s) };
        let Deflection { z, slope } = self.deflection(x);
        Pose { position: [x, z], angle: slope.atan() }
    }

    /// End of the active length: the paper's modified tip.
    pub fn end(&self) -> Pose {
        self.at(self.length)
    }

    /// Centre of mass of the end fitting, which the cameras track: `tip_offset` beyond the end
    /// along its tangent.
    pub fn tip(&self) -> Pose {
        let Pose { position: [x, z], angle } = self.end();
        let position = [x + self.tip_offset * angle.cos(), z + self.tip_offset * angle.sin()];
        Pose { position, angle }
    }

    /// A point `reach` beyond the end, m, without the walk: the active length ends at `x = length`, so that the curve is
    /// too long. The paper shows this unmodified tip beside the walked one, and discards it for its error.
    pub fn unmodified(&self, reach: f64) -> [f64; 2] {
        let Deflection { z, slope } = self.deflection(self.length);
        [self.length + reach, z + reach * slope]
    }

    /// Points at even arc length from the clamp to the end, shape `[pieces + 1]`.
    pub fn shape(&self, pieces: usize) -> Vec<Pose> {
        (0..=pieces).map(|i| self.at(self.length * i as f64 / pieces as f64)).collect()
    }
}

/// Integral of `f` from `a` to `b`, halving where eight points a panel and eight a half disagree
/// with `whole`, the integral over one panel.
fn adaptive_gauss(f: &impl Fn(f64) -> f64, a: f64, b: f64, whole: f64) -> f64 {
    let middle = a + 0.5 * (b - a);
    let (left, right) = (gauss(f, a, middle), gauss(f, middle, b));
    // Halving a panel of sixteenth order gains four digits and more: if the two agree to ten, the
    // halves are exact to rounding.
    if (left + right - whole).abs() <= 1e-11 * whole.abs() {
        return left + right;
    }
    adaptive_gauss(f, a, middle, left) + adaptive_gauss(f, middle, b, right)
}

/// Gauss-Legendre quadrature with eight points; abscissae and weights from Abramowitz and Stegun (1964), Table 25.4.
fn gauss(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    const POINTS: [(f64, f64); 4] = [
        (0.1834346424956498, 0.362683783378362),
        (0.525532409916329, 0.3137066458778873),
        (0.7966664774136267, 0.2223810344533745),
        (0.9602898564975363, 0.1012285362903763),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let pair = |(x, weight): (f64, f64)| weight * (f(middle - half * x) + f(middle + half * x));
    half * POINTS.map(pair).iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row of 15 psi in Table 2, with the mass per length kept at its resting value.
    const AT_15_PSI: EulerBernoulli = EulerBernoulli {
        bending_stiffness: 0.00667,
        length: 7.99 * 0.0254,
        weight_per_length: 0.14227 * 9.81,
        tip_weight: 0.05492 * 9.81,
        tip_offset: 0.662 * 0.0254,
    };

    #[test]
    fn deflection_is_that_of_equations_1_to_3() {
        let EulerBernoulli { bending_stiffness: ei, length: l, .. } = AT_15_PSI;
        let (q, p, dl, x) = (0.14227 * 9.81, 0.05492 * 9.81, 0.662 * 0.0254, 0.12);
        let weight = -q * x * x / (24.0 * ei) * (x * x + 6.0 * l * l - 4.0 * l * x);
        let point = -p * x * x / (6.0 * ei) * (3.0 * (l + dl) - x);
        assert!((AT_15_PSI.deflection(x).z - (weight + point)).abs() < 1e-16);
        assert!(AT_15_PSI.deflection(x).z < 0.0, "weight pulls down");
    }

    /// A weight far beyond the end is a pure moment `M`: the curve is the parabola
    /// `z = −M x² / (2 EI)`, whose length has a closed form.
    #[test]
    fn arc_length_of_a_parabola_is_known() {
        for curvature in [1e-3, 1.0, 30.0, 1e4] {
            let far = 1e9;
            let beam = EulerBernoulli {
                bending_stiffness: 1.0,
                length: 1.0,
                weight_per_length: 0.0,
                tip_weight: curvature / far,
                tip_offset: far - 1.0,
            };
            let x = 0.7;
            let slope: f64 = curvature * x;
            let expected = 0.5 * (x * slope.hypot(1.0) + slope.asinh() / curvature);
            let tolerance = 2.0 / far; // the lever shortens by x on the way
            assert!((beam.arc_length(x) / expected - 1.0).abs() < tolerance, "{curvature}");
        }
    }

    /// Very many straight chords, extrapolated once: shares nothing with the quadrature.
    #[test]
    fn the_walk_ends_where_the_curve_is_as_long_as_the_muscle() {
        let end = AT_15_PSI.end();
        let chords = |n: usize| -> f64 {
            let x = |i: usize| end.position[0] * i as f64 / n as f64;
            let z = |i| AT_15_PSI.deflection(x(i)).z;
            (0..n).map(|i| (x(i + 1) - x(i)).hypot(z(i + 1) - z(i))).sum()
        };
        let length = (4.0 * chords(4000) - chords(2000)) / 3.0;
        assert!((length / AT_15_PSI.length - 1.0).abs() < 1e-12, "{length}");
        assert_eq!(end.position[1], AT_15_PSI.deflection(end.position[0]).z);
    }

    #[test]
    fn the_tip_lies_beyond_the_end_along_its_tangent() {
        let (end, tip) = (AT_15_PSI.end(), AT_15_PSI.tip());
        let step = [tip.position[0] - end.position[0], tip.position[1] - end.position[1]];
        assert!((step[0].hypot(step[1]) - AT_15_PSI.tip_offset).abs() < 1e-16);
        assert!((step[1].atan2(step[0]) - AT_15_PSI.deflection(end.position[0]).slope.atan()).abs() < 1e-14);
        assert!(step[1] < 0.0);
    }

    #[test]
    fn a_shape_runs_from_clamp_to_end_at_even_arc_length() {
        let shape = AT_15_PSI.shape(16);
        assert_eq!(shape[0], Pose { position: [0.0, 0.0], angle: 0.0 });
        assert_eq!(shape[16], AT_15_PSI.end());
        for (i, pose) in shape.iter().enumerate() {
            let s = AT_15_PSI.arc_length(pose.position[0]);
            assert!((s - AT_15_PSI.length * i as f64 / 16.0).abs() < 1e-14);
        }
    }

    /// Equations 1 to 3 at `x = L`, by hand, and the tangent from there on.
    #[test]
    fn the_unmodified_tip_is_that_of_the_equations() {
        let EulerBernoulli { bending_stiffness: ei, length: l, .. } = AT_15_PSI;
        let (q, p, dl) = (0.14227 * 9.81, 0.05492 * 9.81, 0.662 * 0.0254);
        let z = -q * l.powi(4) / (8.0 * ei) - p * l * l * (2.0 * l + 3.0 * dl) / (6.0 * ei);
        let slope = -q * l.powi(3) / (6.0 * ei) - p * l * (l + 2.0 * dl) / (2.0 * ei);
        let [x, tip] = AT_15_PSI.unmodified(dl);
        assert!((x - l - dl).abs() < 1e-15 && (tip - z - dl * slope).abs() < 1e-14, "{x} {tip}");
        // It hangs below the walked one, which is as long as the muscle.
        assert!(tip < AT_15_PSI.tip().position[1] - 0.05, "{tip}");
    }

    /// A stiff beam deflects little: then the walk changes nothing, and the handbook holds.
    #[test]
    fn a_stiff_beam_ends_at_its_length() {
        let beam = EulerBernoulli { bending_stiffness: 1e4, tip_offset: 0.0, ..AT_15_PSI };
        let EulerBernoulli { length: l, weight_per_length: q, tip_weight: p, .. } = beam;
        let expected = -(q * l.powi(4) / 8.0 + p * l.powi(3) / 3.0) / 1e4;
        assert!((beam.end().position[0] - l).abs() < 1e-12);
        assert!((beam.end().position[1] / expected - 1.0).abs() < 1e-8);
    }
}
