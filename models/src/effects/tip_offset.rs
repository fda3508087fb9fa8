//! Tip offset: what is fixed to the end of the rod lies further out than was measured.
//!
//! Law:      c_i → c_i + d   for every body i at the end
//!
//!   c_i   centre of mass of a body beyond the end of the active length    m
//!   d     how much further out all of them lie                            m
//!
//! Assumes:  One error for all bodies, such as of the length from which they were measured: the end
//!           fitting moves by d, and a payload with it. Each keeps its rotary inertia about its own
//!           centre of mass. The observed tip stays where it is.
//! Off:      distance = 0.
//! Silent:   Never, while there is a body.
//! Source:   Parallel axes.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// Bodies that lie further out.
pub struct TipOffset;

impl Law for TipOffset {
    const ABOUT: About = About {
        name: "tip_offset",
        meaning: "what is fixed to the end of the rod lies further out than was measured",
        kind: Kind::Inertial,
        places: &[Place::Body],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "distance",
            meaning: "how much further out the centres of mass lie, along the end fitting's axis",
            unit: "m",
            default: 1e-3,
            range: (-1.0, 1.0),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((-5e-3, 5e-3)),
            ..Parameter::PLAIN
        }],
        signature: "lowers the frequency and the rest posture a little; the second mode moves most",
        confounded_with: &["tip_inertia", "added_mass", "clock", "bend"],
        separated_by: &[Separator::Payload, Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn shift<T: Real>(&self, theta: &[T]) -> T {
        let [distance] = named(theta);
        distance
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::system::System;

    /// As if both bodies had been measured further out.
    #[test]
    fn fitting_and_payload_move_together() {
        let bodies = |d: f64, offset: f64| {
            rod_with(&[
                ("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017 + d), ("rotary_inertia", 1e-5)]),
                ("payload", &[("mass", 0.02), ("center_of_mass", 0.03 + d)]),
                ("tip_offset", &[("distance", offset)]),
            ])
        };
        let (due, found) = (bodies(0.004, 0.0), bodies(0.0, 0.004));
        let body = |model| System::new(model).assembly.context.body;
        let (due, found) = (body(&due), body(&found));
        assert_eq!(found.mass, due.mass);
        assert!((found.center_of_mass - due.center_of_mass).abs() < 1e-16);
        assert!((found.rotary_inertia - due.rotary_inertia).abs() < 1e-18);
    }
}
