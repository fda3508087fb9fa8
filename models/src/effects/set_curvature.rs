//! Set curvature: the rod is bent when nothing loads it, and more so under pressure.
//!
//! Law:      M = −EI (κ₀ + κ_p p + κ_s (s − ½)),   beside EI κ
//!
//!   M     moment beside the linear one                                N m
//!   EI    bending stiffness, `rod.bending_stiffness`                   N m²
//!   κ₀    natural curvature without pressure, positive towards +z     1/m
//!   κ_p   what a pressure adds to it                                  1/(m Pa)
//!   p     pressure inside above ambient, `rod.pressure`               Pa
//!   κ_s   natural curvature at the end less that at the clamp         1/m
//!   s     place along the rod, 0 at the clamp and 1 at its end        –
//!
//! Assumes:  Linear along the rod, and elastic: with κ_n = κ₀ + κ_p p + κ_s (s − ½) its energy is
//!           ½ EI κ_n² − EI κ_n κ a metre, with which that of bending becomes ½ EI (κ − κ_n)².
//! Off:      natural_curvature = 0, if curvature_over_pressure = 0 and taper = 0 as well.
//! Silent:   Never; it turns the rest posture, and a swing about that hardly differs.
//! Source:   The natural curvature of a discrete elastic rod: Bergou et al. (2008), Discrete Elastic
//!           Rods, section 4.2; a braid whose fibres are not laid alike bends under pressure.

use super::{About, Bend, Kind, Law, Moment, Parameter, Per, Place, Reach, Real, Separator, named};

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
            Parameter {
                name: "taper",
                meaning: "curvature of the unloaded rod at its end, less that at the clamp",
                unit: "1/m",
                default: 0.0,
                range: (-200.0, 200.0),
                scale: 0.1,
                null_value: Some(0.0),
                is_part: true,
                ..Parameter::PLAIN
            },
        ],
        signature: "the rod hangs higher or lower than its stiffness says, and swings as if it did not",
        confounded_with: &["creep", "quadratic_stiffness", "stiffness_taper", "frame_tilt"],
        separated_by: &[Separator::Pressures, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        Moment::of(-at.rod.bending_stiffness * natural(at, theta))
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let natural = natural(at, theta);
        at.rod.bending_stiffness * natural * (natural * 0.5 - at.kappa)
    }
}

/// Curvature of the unloaded rod, 1/m.
fn natural<T: Real>(at: &Bend<T>, theta: &[T]) -> T {
    let [natural_curvature, over_pressure, taper] = named(theta);
    natural_curvature + over_pressure * at.rod.pressure + taper * (at.position - 0.5)
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

    /// A taper alone bends half of the rod to each side: the end points where the clamp does, and the middle is turned by an
    /// eighth of taper and length.
    #[test]
    fn a_tapered_rod_bends_to_both_sides() {
        let model = rod_with(&[
            ("gravity", &[("acceleration", 0.0)]),
            ("set_curvature", &[("natural_curvature", 0.0), ("taper", 2.0)]),
        ]);
        let rest = equilibrium(&model, None).unwrap();
        let turn = rest.q[model.dof() - 1] - 0.1;
        let due = 2.0 * model.rod().length / 8.0;
        let node = |k: usize| [rest.q[2 * k], rest.q[2 * k + 1]];
        let middle = model.edges / 2;
        let (before, after) = (node(middle - 2), node(middle));
        let angle = (after[1] - before[1]).atan2(after[0] - before[0]) - 0.1;
        assert!(turn.abs() < 0.02 * due, "{turn}");
        assert!((angle / -due - 1.0).abs() < 0.1, "{angle}, due {}", -due);
    }
}
