//! Set curvature: the rod is bent when nothing loads it, and more so under pressure.
//!
//! Law:      M = −EI (κ₀ + κ_p p),   beside EI κ
//!
//!   M     moment beside the linear one                                N m
//!   EI    bending stiffness, `rod.bending_stiffness`                   N m²
//!   κ₀    natural curvature without pressure, positive towards +z     1/m
//!   κ_p   what a pressure adds to it                                  1/(m Pa)
//!   p     pressure inside above ambient, `rod.pressure`               Pa
//!
//! Assumes:  The same along the rod, and elastic: its energy is ½ EI (κ₀ + κ_p p)² − EI (κ₀ + κ_p p) κ a
//!           metre, with which that of bending becomes ½ EI (κ − κ₀ − κ_p p)².
//! Off:      natural_curvature = 0, if curvature_over_pressure = 0 as well.
//! Silent:   Never; it turns the rest posture, and a swing about that hardly differs.
//! Source:   The natural curvature of a discrete elastic rod: Bergou et al. (2008), Discrete Elastic
//!           Rods, section 4.2; a braid whose fibres are not laid alike bends under pressure.

use super::{About, Bend, Kind, Law, Moment, Parameter, Per, Place, Reach, Real, Rod, Separator};

/// A natural curvature.
pub struct SetCurvature;

impl Law for SetCurvature {
    const ABOUT: About = About {
        name: "set_curvature",
        meaning: "the rod is bent when nothing loads it, and more so under pressure",
        kind: Kind::Elastic,
        places: &[Place::Bend],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "natural_curvature",
                meaning: "curvature of the unloaded rod without pressure, positive towards +z",
                unit: "1/m",
                default: 0.1,
                range: (-100.0, 100.0),
                scale: 0.1,
                null_value: Some(0.0),
                is_part: true,
                plausible: Some((-0.15, 0.15)),
                per: Per::Curvature,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "curvature_over_pressure",
                meaning: "what a pressure adds to that curvature",
                unit: "1/(m Pa)",
                default: 0.0,
                range: (-1e-3, 1e-3),
                scale: 1e-6,
                null_value: Some(0.0),
                is_part: true,
                plausible: Some((-1e-6, 1e-6)),
                ..Parameter::PLAIN
            },
        ],
        signature: "the rod hangs higher or lower than its stiffness says, and swings as if it did not",
        confounded_with: &["creep", "quadratic_stiffness", "stiffness_taper", "frame_tilt"],
        separated_by: &[Separator::Pressures, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(at: &Bend<T>, theta: &[T]) -> Moment<T> {
        Moment::of(-at.rod.bending_stiffness * natural(at.rod, theta))
    }

    fn bend_energy<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
        let natural = natural(at.rod, theta);
        at.rod.bending_stiffness * natural * (natural * 0.5 - at.kappa)
    }
}

/// Curvature of the unloaded rod, 1/m.
fn natural<T: Real>(rod: &Rod<T>, theta: &[T]) -> T {
    theta[0] + theta[1] * rod.pressure
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::statics::equilibrium;

    /// Without weight every bend rests at the natural curvature, half of it from the pressure here: the
    /// end turns by its share of a circle, up to the chords of the bends, of second order.
    #[test]
    fn an_unloaded_rod_rests_on_a_circle() {
        let model = rod_with(&[
            ("gravity", &[("acceleration", 0.0)]),
            ("set_curvature", &[("natural_curvature", 2.0), ("curvature_over_pressure", 1e-5)]),
        ]);
        let rest = equilibrium(&model, None).unwrap();
        let curvature = 2.0 + 1e-5 * model.rod().pressure;
        let turn = rest.q[model.dof() - 1] - 0.1;
        let due = curvature * model.rod().length;
        let chord = (due / model.edges as f64).powi(2) / 12.0;
        assert!((turn / due - 1.0).abs() < 1.1 * chord, "{turn} rad, due {due}");
    }
}
