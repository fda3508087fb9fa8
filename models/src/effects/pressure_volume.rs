//! Pressure and volume: bending the sealed muscle anywhere stiffens it everywhere.
//!
//! Law:      M = EI c ⟨κ²⟩ κ
//!
//!   M      moment beside the linear one                         N m
//!   EI     bending stiffness, `rod.bending_stiffness`            N m²
//!   c      how much a mean square curvature of 1/m² stiffens    m²
//!   ⟨κ²⟩   mean square curvature over the rod                   1/m²
//!   κ      curvature                                            1/m
//!
//! Assumes:  The valve is shut. Bending makes the braid take volume from the gas in proportion to ⟨κ²⟩,
//!           so that its pressure rises in proportion to it, in all of the muscle at once and without loss.
//!           Elastic, with the energy ¼ EI c L ⟨κ²⟩² in all, L the active length.
//! Off:      stiffening = 0.
//! Silent:   Small bending.
//! Source:   Boyle's law to first order in the change of volume. That bending changes the volume is the
//!           braid's doing: a smooth tube of constant section keeps its volume, to second order in the
//!           curvature, because the outside gains what the inside loses (Pappus's theorem). No measured
//!           value of c is known to us: take it as a coefficient to be fitted.

use super::{About, Bend, Kind, Law, Moment, Parameter, Place, Reach, Real, Separator, named};

/// A bending stiffness that follows the shape of the whole rod.
pub struct PressureVolume;

impl Law for PressureVolume {
    const ABOUT: About = About {
        name: "pressure_volume",
        meaning: "bending the sealed muscle anywhere stiffens it everywhere",
        kind: Kind::Elastic,
        places: &[Place::Bend, Place::Whole],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "stiffening",
            meaning: "share of the linear moment at a mean square curvature of 1/m^2",
            unit: "m^2",
            default: 1e-3,
            range: (-1.0, 1.0),
            scale: 1e-3,
            null_value: Some(0.0),
            plausible: Some((-3e-3, 3e-3)),
            ..Parameter::PLAIN
        }],
        signature: "large swings are faster than small ones, by the same share all along the rod",
        confounded_with: &["cubic_stiffness", "hose"],
        separated_by: &[Separator::Valve, Separator::Pressures],
        reach: Reach::Muscle,
    };

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let [stiffening] = named(theta);
        Moment::of(stiffening * at.rod.bending_stiffness * at.mean_square_curvature * at.kappa)
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        let [stiffening] = named(theta);
        stiffening * at.rod.bending_stiffness * at.mean_square_curvature * at.kappa * at.kappa * 0.25
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::rod_with;
    use crate::statics::equilibrium;

    /// A moment at the tip bends the weightless rod evenly, so that its mean square curvature is that of
    /// each bend: `M = EI (κ + c κ³)`. A discrete bend of the integrated curvature K turns by K (1 − K²/12),
    /// and its moment turns it with 1 + K²/4, so that the end is off by a third of K² at most. Newton's
    /// steps know the whole tangent: as many as for a rod without the effect, and a few for the cubic.
    #[test]
    fn a_moment_at_the_tip_bends_it_evenly() {
        let (curvature, stiffening): (f64, f64) = (4.0, 0.05);
        let moment = 0.01 * (curvature + stiffening * curvature.powi(3));
        let with = |stiffening: f64| {
            rod_with(&[
                ("gravity", &[("acceleration", 0.0)]),
                ("tip_load", &[("moment", moment)]),
                ("pressure_volume", &[("stiffening", stiffening)]),
            ])
        };
        let model = with(stiffening);
        let rest = equilibrium(&model, None).unwrap();
        let turn = rest.q[model.dof() - 1] - 0.1;
        let due = curvature * model.rod().length;
        let chords = (due / model.edges as f64).powi(2) / 3.0;
        assert!((turn / due - 1.0).abs() < chords, "{turn} rad, due {due}");
        let plain = equilibrium(&with(0.0), None).unwrap();
        assert!(rest.iterations <= plain.iterations + 4, "{} and {}", rest.iterations, plain.iterations);
        assert!(rest.stable);
    }
}
