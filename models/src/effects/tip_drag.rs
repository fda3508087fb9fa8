//! Tip drag: the air resists whatever sits at the tip, with the square of its speed.
//!
//! Law:      F = −½ ρ C_d A |v| v
//!
//!   F       force at the centre of mass of what sits there   N
//!   ρ       density of the air                               kg/m³
//!   C_d A   drag coefficient times frontal area              m²
//!   v       velocity of that centre of mass                  m/s
//!
//! Assumes:  Still air, quasi-steady flow, and the same area from all sides. Force and velocity are
//!           those of the common centre of mass of end fitting, payload and other bodies at the tip.
//! Off:      drag_area = 0.
//! Silent:   In the limit, small swings: the loss is of third order.
//! Source:   Morison's drag term, Morison et al. (1950); coefficients of blunt bodies, 0.4 to 1.2 on
//!           the frontal area: Hoerner (1965), Fluid-Dynamic Drag, ch. 3.

use super::air_drag::AIR_DENSITY;
use super::{About, Kind, Law, Parameter, Per, Place, Reach, Real, Separator, Tip, TipLoad, named};

/// Quadratic drag of a blunt body at the tip.
pub struct TipDrag;

impl Law for TipDrag {
    const ABOUT: About = About {
        name: "tip_drag",
        meaning: "the air resists whatever sits at the tip, with the square of its speed",
        kind: Kind::Dissipative,
        places: &[Place::Tip],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "drag_area",
                meaning: "drag coefficient times frontal area of what sits at the tip",
                unit: "m^2",
                default: 1e-3,
                range: (0.0, 10.0),
                scale: 1e-3,
                null_value: Some(0.0),
                plausible: Some((0.0, 0.1)),
                per: Per::LengthSquared,
                ..Parameter::PLAIN
            },
            AIR_DENSITY,
        ],
        signature: "the first large swings lose more than the later ones: one over the amplitude grows on a straight line",
        confounded_with: &["air_drag", "strain_rate_cubed"],
        separated_by: &[Separator::TipPlate],
        reach: Reach::Muscle,
    };

    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let [drag_area, density] = named(theta);
        let (arm, arm_rate) = at.arm();
        let [x, z] = [0, 1].map(|k| at.velocity[k] + arm_rate[k]);
        let square = x * x + z * z;
        // At rest the root has no slope, but the force, of second order, has: zero.
        let speed = if square.re() > 0.0 { square.sqrt() } else { T::from(0.0) };
        let resistance = drag_area * density * speed * 0.5;
        TipLoad::of_force_at(arm, [-resistance * x, -resistance * z])
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::system::System;

    /// The straight rod turns rigidly about its clamp at the rate ω. The fitting's centre of mass, a
    /// distance c beyond the rod's end, is as fast as `(L + c) ω`, and the drag there takes the power
    /// `½ ρ C_d A ((L + c) ω)³`.
    #[test]
    fn it_acts_at_the_fitting() {
        let (center, rate, area, density) = (0.017, 3.0, 2e-3, 1.2);
        let fitting: (&str, &[(&str, f64)]) = ("end_fitting", &[("mass", 0.05), ("center_of_mass", center)]);
        let power = |area: f64| {
            let model = rod_with(&[fitting, ("tip_drag", &[("drag_area", area), ("air_density", density)])]);
            let mut system = System::new(&model);
            let (q, v) = system.assembly.straight(0.1, rate);
            let mut force = vec![0.0; q.len()];
            system.force(0.0, &q, &v, &[], &mut force, &mut []);
            force.iter().zip(&v).map(|(f, v)| f * v).sum::<f64>()
        };
        let found = power(area) - power(0.0);
        let due = -0.5 * density * area * ((0.3 + center) * rate).powi(3);
        assert!((found / due - 1.0).abs() < 1e-10, "{found} W, due {due}");
    }
}
