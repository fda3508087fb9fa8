//! Enclosed air: the compressed air inside the muscle has to be moved, and weighs.
//!
//! Law:      F = −μ ẍ + (μ − ρ₀ A) g   a metre of rod,   μ = ρ A,   ρ = (p₀ + p) / (R T),   A = π d²/4
//!
//!   F    force on the rod, a metre                      N/m
//!   μ    mass of the air in a metre                     kg/m
//!   ρ    its density;  ρ₀ that at p = 0                 kg/m³
//!   p    pressure inside above ambient, `rod.pressure`  Pa
//!   p₀   ambient pressure, 101 325 Pa                   Pa
//!   R    gas constant of dry air, 287.05 J/(kg K)       J/(kg K)
//!   T    temperature, 293.15 K                          K
//!   d    inner diameter of the bladder                  m
//!
//! Assumes:  Ideal gas at 20 °C and at the pressure of the release, spread evenly over the active length;
//!           under a pressure that changes its mass stays. It moves with the rod, across and along. The
//!           ambient air that the bladder keeps out bears ρ₀ A g of its weight. A built-in or given
//!           muscle has it, with the inner diameter of its table; with `mass = "per_length"`, the
//!           paper's way, it is left out.
//! Off:      inner_diameter = 0, or the effect left out. Nothing of it is fitted.
//! Silent:   No motion is without it.
//! Source:   The gas law. For the muscle of Garbulinski and Wereley (2022), who weighed bladder and
//!           braid: 0.24, 0.62 and 1.48 g at 15, 40 and 100 psi, beside 24 g of rod.

use std::f64::consts::PI;

use super::{About, Kind, Law, LineMass, Parameter, Place, Reach, Real, Rod, Separator, named};

/// Ambient pressure, Pa.
const AMBIENT: f64 = 101_325.0;
/// Gas constant of dry air times 20 °C, J/kg.
const GAS: f64 = 287.05 * 293.15;

/// The mass of the air inside.
pub struct EnclosedAir;

impl Law for EnclosedAir {
    const ABOUT: About = About {
        name: "enclosed_air",
        meaning: "the compressed air inside the muscle has to be moved, and weighs",
        kind: Kind::Inertial,
        places: &[Place::Inertia],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "inner_diameter",
            meaning: "inner diameter of the bladder",
            unit: "m",
            default: 0.025,
            range: (0.0, 10.0),
            scale: 0.01,
            ..Parameter::PLAIN
        }],
        signature: "lowers the frequency and the rest posture a little, more at higher pressures",
        confounded_with: &["bend", "added_mass"],
        separated_by: &[Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn inertia<T: Real>(&self, at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
        let [diameter] = named(theta);
        let area = diameter * diameter * (PI / 4.0);
        let gauge = at_release.pressure;
        // No bladder holds less than nothing.
        let absolute = if gauge.re() > -AMBIENT { gauge + AMBIENT } else { T::from(0.0) };
        LineMass { inert: area * absolute / GAS, heavy: area * (absolute - AMBIENT) / GAS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::rod_with;
    use crate::statics::equilibrium;
    use crate::system::System;

    const PSI: f64 = 6_894.757_293_168_361;
    const INCH: f64 = 0.0254;

    /// The muscle of the paper at three rows of its Table 2: inner diameter and length in inches, and
    /// the mass of the air by the gas law, reckoned by hand, g.
    #[test]
    fn the_air_in_the_papers_muscle() {
        for (psi, diameter, length, due) in
            [(15.0, 0.98, 7.99, 0.240), (40.0, 0.96, 11.59, 0.616), (100.0, 0.93, 14.13, 1.478)]
        {
            let rod = Rod { pressure: psi * PSI, ..rod_with(&[]).rod() };
            let found = EnclosedAir.inertia(&rod, &[diameter * INCH]);
            let grams = 1e3 * found.inert * length * INCH;
            assert!((grams - due).abs() < 5e-4, "{grams} g at {psi} psi");
            // What weighs is in proportion to the gauge pressure.
            let share = psi * PSI / (psi * PSI + AMBIENT);
            assert!((found.heavy / found.inert - share).abs() < 1e-12);
        }
    }

    /// As inert as a rod with all of the air's mass, and hanging as one with the part that weighs.
    #[test]
    fn it_is_inert_and_heavy() {
        let fitting: (&str, &[(&str, f64)]) = ("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017)]);
        let plain = rod_with(&[fitting]);
        let model = rod_with(&[fitting, ("enclosed_air", &[("inner_diameter", 0.02)])]);
        let air = EnclosedAir.inertia(&plain.rod(), &[0.02]);
        let with = |mass: f64| {
            let mut model = plain.clone();
            model.set("rod.mass", 0.03 + 0.3 * mass).unwrap();
            model
        };
        let (inert, heavy) = (with(air.inert), with(air.heavy));
        for (found, due) in System::new(&model).mass.iter().zip(&System::new(&inert).mass) {
            assert!((found / due - 1.0).abs() < 1e-14, "{found} kg, due {due}");
        }
        let nodes = |model| {
            let rest = equilibrium(model, None).unwrap();
            System::new(model).assembly.posture(&rest.q, &vec![0.0; rest.q.len()]).nodes
        };
        for (found, due) in nodes(&model).iter().zip(nodes(&heavy)) {
            // Both to an imbalance of 1e-10 of the weight.
            assert!((found[0] - due[0]).hypot(found[1] - due[1]) < 1e-8, "{found:?}, due {due:?}");
        }
    }
}
