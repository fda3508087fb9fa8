//! Where a model is not valid: strains that its linear laws do not reach, loads that nobody measured, and
//! rests that do not hold.

use models::digits::significant;
use models::model::{AxialSource, Model};
use models::quantity::format_si;
use models::system::System;

use crate::rest::Rest;
use crate::trajectory::Trajectory;

/// Stretch beyond which a tension that is linear in it means little: there strain over the rest length and strain
/// over the current length differ by a twentieth.
const STRETCH: f64 = 0.1;
/// Stretch beyond which a rod without a known axial stiffness must have one: it lowers the frequency of a hanging rod by a
/// thousandth.
const UNKNOWN_STRETCH: f64 = 2e-3;
/// Bending moment at rest, over that of the muscle under its own end fitting, beyond which its table says nothing. The
/// table was fitted to that rest, and a release, which the paper made too, doubles the moment of its rest.
const MOMENT: f64 = 2.0;

/// What to know of a run before it is used. `own` is the root moment, N m, of the muscle under its end fitting alone,
/// if the rod is one.
pub fn warnings(
    model: &Model,
    trajectory: &Trajectory,
    rest: Option<&Rest>,
    own: Option<f64>,
) -> Vec<String> {
    let mut warnings: Vec<String> = of_stretch(model, trajectory).into_iter().collect();
    warnings.extend(fed(trajectory));
    let Some(rest) = rest else { return warnings };
    if let Some(own) = own.filter(|own| rest.root_moment.abs() > MOMENT * own.abs()) {
        warnings.push(format!(
            "at rest the root carries {} times the moment under which the muscle's stiffness was measured: the \
             table says nothing of such loads",
            significant(rest.root_moment / own, 2)
        ));
    }
    if !rest.stable {
        warnings.push(
            "the rest is not stable: pushed, the rod leaves it; frequencies about it mean nothing".to_owned(),
        );
    }
    let growing = rest.modes.iter().flatten().find(|(_, damping_ratio)| *damping_ratio < 0.0);
    if let Some((frequency, damping_ratio)) = growing {
        warnings.push(format!(
            "small vibrations of {} Hz about the rest grow: their damping ratio is {}; an effect feeds energy to the rod",
            significant(*frequency, 3),
            significant(*damping_ratio, 3)
        ));
    }
    warnings
}

/// What to know of the stretch of a rod that stretches far, or whose axial stiffness is not known.
fn of_stretch(model: &Model, trajectory: &Trajectory) -> Option<String> {
    let is_unknown = model.axial_source == AxialSource::Unstretched;
    let (stretch, time) = largest_stretch(model, trajectory);
    let limit = if is_unknown { UNKNOWN_STRETCH } else { STRETCH };
    if stretch.abs() <= limit {
        return None;
    }
    let what = if stretch > 0.0 { "stretches" } else { "shortens" };
    let why = if is_unknown {
        "no axial stiffness is given, and the rod would hardly stretch under the load at its release; give \
         rod.axial_stiffness"
    } else {
        "its tension is linear in the stretch, which holds for some per cent; check rod.axial_stiffness and what \
         hangs on the rod"
    };
    let percent = significant(100.0 * stretch.abs(), 2);
    Some(format!("the rod {what} by {percent} % at {time:.2} s: {why}"))
}

/// Share of the energy of a motion that a law may feed without a warning: frequencies and damping ratios are printed to
/// three digits.
const FED: f64 = 1e-3;

/// Laws as text that feed energy, though their kind says that they do not.
fn fed(trajectory: &Trajectory) -> impl Iterator<Item = String> {
    let moved = trajectory.motion_energy().unwrap_or_default();
    trajectory.fed.iter().filter(move |fed| fed.energy > FED * moved).map(move |fed| {
        format!(
            "laws.{} feeds energy to the rod, {} from {:.2} s on, {} % of that of the motion: turn its sign, \
             or give kind = \"load\" if it acts from outside; `efam effects --check` tests it",
            fed.law,
            format_si(fed.energy, "J"),
            fed.since.unwrap_or_default(),
            significant(100.0 * fed.energy / moved, 2)
        )
    })
}

/// The stretch of an edge that is farthest from zero at any sample, and when, s.
fn largest_stretch(model: &Model, trajectory: &Trajectory) -> (f64, f64) {
    let mut system = System::new(model);
    let (mut largest, mut at): (f64, f64) = (0.0, 0.0);
    for sample in 0..trajectory.times.len() {
        let state = trajectory.state(sample);
        system.assembly.place(model, state.time, &state.q, &state.v);
        for stretch in &system.assembly.fields.stretch {
            if stretch.abs() > largest.abs() {
                (largest, at) = (*stretch, state.time);
            }
        }
    }
    (largest, at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forward::{Run, forward};
    use crate::rest::rest;
    use models::effects::Rod;
    use models::model::ModelSpec;
    use std::ops::ControlFlow;

    /// Rests as they may be found: that hangs, that falls when it is pushed, about which vibrations grow.
    #[test]
    fn a_rest_that_does_not_hold_is_said() {
        let rod = Rod {
            length: 0.3,
            mass: 0.03,
            bending_stiffness: 1.0,
            axial_stiffness: 1e4,
            diameter: f64::NAN,
            pressure: 0.0,
        };
        let model = Model::new(&ModelSpec { nodes: 8, ..ModelSpec::of(rod) }).unwrap();
        let run = Run { tolerance: 1e-5, ..Run::release(0.1, 100.0) };
        let trajectory = forward(&model, &run, &mut |_| ControlFlow::Continue(())).unwrap();
        let told = |rest: Rest| warnings(&model, &trajectory, Some(&rest), None).join("; ");
        let hangs = || rest(&model, 0.0, 2).unwrap();
        assert_eq!(told(hangs()), "");
        assert!(told(Rest { stable: false, ..hangs() }).contains("not stable"));
        let grows = told(Rest { modes: Ok(vec![(3.0, 0.1), (40.0, -147.0)]), ..hangs() });
        assert!(grows.contains("40.0 Hz") && grows.contains("-147"), "{grows}");
    }
}
