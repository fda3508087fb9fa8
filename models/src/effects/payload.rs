//! Payload: a rigid body is carried at the tip.
//!
//! Law:      m ẍ = F at its centre of mass, J φ̈ = M about it; fixed to the end of the active
//!           length, with no bend between, so it turns with the rod's end.
//!
//!   m   mass                                                   kg
//!   c   centre of mass beyond the end of the active length     m
//!   b   centre of mass beside the axis of the end fitting,     m
//!       positive to the left when looking outwards: up, if
//!       the rod is level
//!   J   rotary inertia about its centre of mass                kg m²
//!   φ   angle of the end fitting                               rad
//!
//! Assumes:  Rigid. J = 0 is a point mass; a prediction takes it as a compact body of unknown size.
//! Off:      mass = 0, if rotary_inertia = 0 as well.
//! Silent:   No motion of the tip is without it.
//! Source:   A rigid body fixed to the end fitting: Newton and Euler.

use super::{About, BODY_PARAMETERS, Body, Kind, Law, Parameter, Place, Reach, Real, named};

/// The rigid body of the payload.
pub struct Payload;

impl Law for Payload {
    const ABOUT: About = About {
        name: "payload",
        meaning: "a rigid body is carried at the tip",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: &[
            BODY_PARAMETERS[0],
            BODY_PARAMETERS[1],
            BODY_PARAMETERS[2],
            Parameter {
                name: "offset",
                meaning: "its centre of mass beside the axis of the end fitting, positive to the left looking outwards",
                unit: "m",
                default: 0.0,
                range: (-10.0, 10.0),
                scale: 0.01,
                ..Parameter::PLAIN
            },
        ],
        signature: "lowers frequency and rest posture together",
        confounded_with: &["bend"],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn body<T: Real>(&self, theta: &[T]) -> Body<T> {
        let [.., offset] = named::<T, 4>(theta);
        Body { offset, ..Body::of(theta) }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::system::System;

    /// The straight rod turns rigidly about its clamp at the rate ω: the payload, at `(L + c, b)` in the
    /// rod's frame, has the kinetic energy `½ (m ((L + c)² + b²) + J) ω²`, and its weight the power
    /// `−m g ω x`, with x its horizontal distance from the clamp.
    #[test]
    fn beside_the_axis_it_swings_and_weighs_where_it_is() {
        let (mass, center, offset, inertia) = (0.08, 0.03, -0.02, 2e-5);
        let payload: (&str, &[(&str, f64)]) = (
            "payload",
            &[("mass", mass), ("center_of_mass", center), ("offset", offset), ("rotary_inertia", inertia)],
        );
        let fitting: (&str, &[(&str, f64)]) = ("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017)]);
        let (angle, rate): (f64, f64) = (0.1, 3.0);
        let look = |effects: &[(&str, &[(&str, f64)])]| {
            let model = rod_with(effects);
            let mut system = System::new(&model);
            let (q, v) = system.assembly.straight(angle, rate);
            let (kinetic, _, potential) = system.energy(0.0, &q, &v, &[]);
            let mut force = vec![0.0; q.len()];
            system.force(0.0, &q, &v, &[], &mut force, &mut []);
            let power: f64 = force.iter().zip(&v).map(|(f, v)| f * v).sum();
            [kinetic, potential, power]
        };
        let (with, without) = (look(&[fitting, payload]), look(&[fitting]));
        let reach = 0.3 + center;
        let x = reach * angle.cos() - offset * angle.sin();
        let z = reach * angle.sin() + offset * angle.cos();
        let square = mass * (reach * reach + offset * offset) + inertia;
        let due = [0.5 * square * rate * rate, mass * 9.81 * z, -mass * 9.81 * rate * x];
        for k in 0..3 {
            let found = with[k] - without[k];
            assert!((found / due[k] - 1.0).abs() < 1e-9, "{k}: {found}, due {}", due[k]);
        }
    }
}
