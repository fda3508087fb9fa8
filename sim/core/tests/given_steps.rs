//! Runs on the steps of another run.

use std::ops::ControlFlow;

use efam_core::example::spec_at_15_psi;
use efam_core::forward::{Run, forward};
use efam_core::integrate::{Method, Steps};
use efam_core::models::model::Model;
use efam_core::trajectory::Trajectory;

/// A release whose rod is straight but not in line with its clamp, with a loss that grows with the third power of the
/// rate of bending: the kink takes some short steps.
fn with_a_kink(kink: f64, steps: Steps) -> Trajectory {
    let mut spec = spec_at_15_psi();
    (spec.rod.length, spec.rod.bending_stiffness) = (0.338836, 0.01436);
    (spec.rod.mass, spec.rod.axial_stiffness, spec.rod.diameter) = (0.02425, 469.33, 0.025146);
    (spec.base_angle, spec.release_angle) = (-0.43633231, -0.43633231 + kink);
    let losses = [("rayleigh_stiffness", "beta", 9.4e-3), ("strain_rate_cubed", "coefficient", 9.2e-7)];
    spec.effects.extend(losses.map(|(effect, name, value)| (effect.into(), vec![(name.into(), value)])));
    spec.effects.push(("gravity".into(), Vec::new()));
    let release = Run::release(8.0, 100.0);
    let run = Run { tolerance: 1e-4, method: Method::Rodas4, steps, keep_steps: true, ..release };
    forward(&Model::new(&spec).unwrap(), &run, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A given step that begins where only short ones can be made is not made of short ones to its end: that took 237 283
/// steps here for 221.
#[test]
fn a_given_step_that_is_divided_grows_again() {
    let own = with_a_kink(4.2e-3, Steps::Adaptive);
    let given = with_a_kink(4.3e-3, Steps::Given(own.steps.clone()));
    assert!(given.effort.rejected > 0, "a step is divided");
    assert!(given.steps.len() < own.steps.len() * 5 / 4, "{} for {}", given.steps.len(), own.steps.len());
}
