//! Added mass: fluid that has to move with the rod makes it more inert, and not heavier.
//!
//! Law:      F = −μ ẍ   a metre of rod
//!
//!   F   force on the rod, a metre         N/m
//!   μ   mass that moves with it, a metre  kg/m
//!
//! Assumes:  Like the rod's own mass it is spread evenly over the active length at release, stays with
//!           the material, and follows it in every direction; the last half cell turns with the end
//!           body. Its weight is borne by the fluid around it. Mass damping acts on it too: what is
//!           lost is momentum, whose ever it is.
//! Off:      mass_per_length = 0.
//! Silent:   Rest.
//! Source:   Lamb (1932), Hydrodynamics, art. 68: a cylinder across the flow carries ρ π D²/4 a metre,
//!           0.7 g/m for 27 mm in air. The air inside a muscle is `enclosed_air`: it weighs.

use super::{About, Kind, Law, LineMass, Parameter, Place, Reach, Real, Rod, Separator, named};

/// Inertia without weight.
pub struct AddedMass;

impl Law for AddedMass {
    const ABOUT: About = About {
        name: "added_mass",
        meaning: "fluid that has to move with the rod makes it more inert, and not heavier",
        kind: Kind::Inertial,
        places: &[Place::Inertia],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "mass_per_length",
            meaning: "mass that moves with a metre of rod and is not weighed",
            unit: "kg/m",
            default: 7e-4,
            range: (0.0, 1e3),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((0.0, 2e-3)),
            ..Parameter::PLAIN
        }],
        signature: "lowers the frequency and leaves the rest posture where it is",
        confounded_with: &["clock", "tip_offset", "tip_inertia"],
        separated_by: &[Separator::Payload, Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn inertia<T: Real>(&self, _at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
        let [mass_per_length] = named(theta);
        LineMass { inert: mass_per_length, heavy: T::from(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::model::Model;
    use crate::statics::equilibrium;
    use crate::system::System;

    const FITTING: (&str, &[(&str, f64)]) = ("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017)]);

    /// Twenty grams on the rod's thirty: it is as inert as a rod of fifty, the end body included, and
    /// hangs as one of thirty.
    #[test]
    fn it_is_inert_and_not_heavy() {
        let light = rod_with(&[FITTING]);
        let model = rod_with(&[FITTING, ("added_mass", &[("mass_per_length", 0.02 / 0.3)])]);
        let mut heavy = light.clone();
        heavy.set("rod.mass", 0.05).unwrap();
        let (found, due) = (System::new(&model), System::new(&heavy));
        for (found, due) in found.mass.iter().zip(&due.mass) {
            assert!((found / due - 1.0).abs() < 1e-14, "{found} kg, due {due}");
        }
        let nodes = |model: &Model| {
            let rest = equilibrium(model, None).unwrap();
            System::new(model).assembly.posture(&rest.q, &vec![0.0; rest.q.len()]).nodes
        };
        for (found, due) in nodes(&model).iter().zip(nodes(&light)) {
            // Both to an imbalance of 1e-10 of the weight.
            assert!((found[0] - due[0]).hypot(found[1] - due[1]) < 1e-8, "{found:?}, due {due:?}");
        }
    }
}
