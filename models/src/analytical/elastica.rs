//! The elastica: an inextensible cantilever bent as far as it likes by a force at its tip.
//!
//! The force P keeps its direction along z. With `θ0` the tip angle, `s = sin θ0` and
//! `α² = P L² / EI`, moment equilibrium `EI θ'' + P cos θ = 0`, `θ(0) = 0`, `θ'(L) = 0` gives
//!
//! - `α = √(2s) R_F(1−s, 1−s², 1+s)`, to be solved for the tip angle,
//! - `x_tip / L = √(2s) / α`,
//! - `z_tip / L = s − (1−s²) (2s)^{3/2} R_D(1−s, 1+s, 1−s²) / (6α)`.
//!
//! Source: Bisshopp and Drucker (1945), Large deflection of cantilever beams, Quarterly of Applied
//! Mathematics 3, their equations for `α`, `(L−Δ)/L` and `δ/L`. They are written here in Carlson's
//! symmetric forms instead of `K(k) − F(k, φ1)` and `E(k) − E(k, φ1)`, `k² = (1+s)/2`: those
//! differences lose their digits under a small load, these do not. `z_tip` follows from
//! `s − z_tip/L = ∫ θ'² dσ L / (2α²)`, the first integral taken along the rod.

use super::{
    Pose,
    cantilever::Cantilever,
    elliptic::{carlson_rd, carlson_rf},
};
use crate::root::bisect;

/// Largest `P L² / EI`; the tip is then vertical to within 1e-40 rad.
const LARGEST_LOAD: f64 = 1e4;

/// Where the tip is under a force at the tip, N, positive towards +z; good to 1e-14 lengths.
///
/// # Panics
/// If `|P| L² / EI` exceeds 1e4: by then the rod is a hair hanging from a bend at the clamp.
pub fn tip(beam: &Cantilever, force: f64) -> Pose {
    let Cantilever { bending_stiffness, length } = *beam;
    let load = force.abs() * length * length / bending_stiffness;
    assert!(load <= LARGEST_LOAD, "P L^2 / EI = {load} exceeds {LARGEST_LOAD}");
    if load == 0.0 {
        return Pose { position: [length, 0.0], angle: 0.0 };
    }
    let alpha = load.sqrt();
    // The logarithm of the tip's slope resolves small loads and tips near the vertical alike.
    // Its bounds: alpha is `√(2 slope)` for a small slope and near `ln(8 slope)` for a large one.
    let rough = load.min(1.0).ln();
    let slope = bisect(rough - 2.0, 2.0 * alpha + 2.0, |slope| Tip::at(slope.exp()).alpha() - alpha);
    let tip = Tip::at(slope.exp());
    let sign = force.signum();
    Pose { position: [length * tip.root / alpha, sign * length * tip.height(alpha)], angle: sign * tip.angle }
}

/// The tip over its angle, with the combinations of `s = sin θ0` that cancel nowhere.
struct Tip {
    angle: f64,
    /// `s`.
    sine: f64,
    /// `√(2s)`.
    root: f64,
    /// `1 − s`.
    below_one: f64,
    /// `1 − s²`.
    cosine_squared: f64,
}

impl Tip {
    fn at(slope: f64) -> Self {
        let secant = slope.hypot(1.0);
        let sine = slope / secant;
        Self {
            angle: slope.atan(),
            sine,
            root: (2.0 * sine).sqrt(),
            below_one: 1.0 / (secant * (secant + slope)),
            cosine_squared: 1.0 / (secant * secant),
        }
    }

    fn alpha(&self) -> f64 {
        self.root * carlson_rf(self.below_one, self.cosine_squared, 1.0 + self.sine)
    }

    fn height(&self, alpha: f64) -> f64 {
        let rd = carlson_rd(self.below_one, 1.0 + self.sine, self.cosine_squared);
        self.sine - self.cosine_squared * self.root.powi(3) * rd / (6.0 * alpha)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Cantilever = Cantilever { bending_stiffness: 1.0, length: 1.0 };

    /// Mattiasson (1981), Numerical results from large deflection beam and frame problems analysed
    /// by means of elliptic integrals: `P L²/EI`, `w/L`, `u/L`, `θ0`; five digits.
    #[test]
    fn published_values_come_out() {
        for (load, w, u, angle) in [
            (1.0, 0.30172, 0.05643, 0.46135),
            (2.0, 0.49346, 0.16064, 0.78175),
            (5.0, 0.71379, 0.38763, 1.21537),
            (10.0, 0.81061, 0.55500, 1.43029),
        ] {
            let tip = tip(&UNIT, load);
            let error = [tip.position[1] - w, 1.0 - tip.position[0] - u, tip.angle - angle];
            assert!(error.iter().all(|e| e.abs() < 0.6e-5), "load {load}: {error:?}");
        }
    }

    /// Runge-Kutta on `θ'' = −load cos θ`, shooting for `θ'(1) = 0`: shares nothing with the
    /// elliptic integrals.
    #[test]
    fn an_integration_along_the_rod_agrees() {
        let steps = 4000;
        let h = 1.0 / steps as f64;
        let shoot = |load: f64, root_curvature: f64| -> [f64; 4] {
            let rate = |[angle, curvature, _, _]: [f64; 4]| {
                [curvature, -load * angle.cos(), angle.cos(), angle.sin()]
            };
            let along = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
            (0..steps).fold([0.0, root_curvature, 0.0, 0.0], |y, _| {
                let k1 = rate(y);
                let k2 = rate(along(y, k1, 0.5 * h));
                let k3 = rate(along(y, k2, 0.5 * h));
                let k4 = rate(along(y, k3, h));
                std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
            })
        };
        for load in [1e-3, 0.3, 1.0, 2.0, 10.0, 30.0] {
            // Of many equilibria the one that bends once: the lever is one at most, and the first
            // integral gives `θ'(0)² <= 2 load`.
            let largest = f64::min(load, (2.0 * load).sqrt());
            let curvatures = (0.8 * largest, 1.0001 * largest);
            let root = bisect(curvatures.0, curvatures.1, |curvature| shoot(load, curvature)[1]);
            let [angle, _, x, z] = shoot(load, root);
            let tip = tip(&UNIT, load);
            let error = [tip.position[0] - x, tip.position[1] - z, tip.angle - angle];
            // Fourth order with alpha up to 5.5 a length: (5.5/4000)^4 = 4e-12, far less as a rule.
            assert!(error.iter().all(|e| e.abs() < 2e-12), "load {load}: {error:?}");
        }
    }

    #[test]
    fn small_loads_deflect_as_the_linear_beam_and_downward_loads_mirror() {
        let (load, tip) = (1e-9, |load| tip(&UNIT, load));
        let linear = UNIT.tip_load(load, 1.0);
        assert!((tip(load).position[1] / linear.z - 1.0).abs() < 1e-13);
        assert!((tip(load).angle / linear.slope - 1.0).abs() < 1e-13);
        assert!((1.0 - tip(load).position[0]).abs() < 1e-15);
        assert_eq!(tip(-3.0).position[1], -tip(3.0).position[1]);
        assert_eq!(tip(-3.0).angle, -tip(3.0).angle);
        assert_eq!(tip(0.0).position, [1.0, 0.0]);
    }

    /// A long soft rod hangs down from a bend near the clamp: `x = √(2 EI / P)`, and the arc
    /// that the bend takes from the height is `(2 − √2) √(EI / P)`.
    #[test]
    fn heavy_loads_leave_a_bend_at_the_clamp() {
        let alpha = LARGEST_LOAD.sqrt();
        let tip = tip(&UNIT, LARGEST_LOAD);
        assert!((tip.position[0] - 2f64.sqrt() / alpha).abs() < 1e-15);
        assert!((tip.position[1] - (1.0 - (2.0 - 2f64.sqrt()) / alpha)).abs() < 1e-14);
    }
}
