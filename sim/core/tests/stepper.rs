//! Steps one after another are those of a whole run, and what is changed between them is felt from then on alone.

use std::ops::ControlFlow;
use std::sync::Arc;

use efam_core::forward::{Run, forward};
use efam_core::initial::Initial;
use efam_core::integrate::{Control, IntegrateError, Method, Steps};
use efam_core::models::effects::Rod;
use efam_core::models::model::{Model, ModelSpec};
use efam_core::models::muscle::{Extrapolation, Muscle};
use efam_core::models::pressure::PressureSchedule;
use efam_core::models::statics::equilibrium;
use efam_core::stepper::{ChangeError, Stepper};

const LOSSES: [(&str, f64); 3] =
    [("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 2e-3), ("viscoelastic.branch_stiffness", 0.2)];

fn spec() -> ModelSpec {
    let rod = Rod {
        length: 0.2,
        mass: 0.03,
        bending_stiffness: 5e-3,
        axial_stiffness: 500.0,
        diameter: 0.03,
        pressure: 0.0,
    };
    ModelSpec { nodes: 12, ..ModelSpec::of(rod) }
}

fn at_release(model: &Model) -> Stepper {
    Stepper::new(model, Initial::Straight.state(model).expect("a start")).expect("a stepper")
}

/// In fixed steps both are the same run, bit by bit, with loss and without.
#[test]
fn fixed_steps_are_those_of_a_run() {
    for (losses, step) in [(&LOSSES[..], 1e-3), (&[], 2e-5)] {
        let model = Model::new(&spec().with(losses)).unwrap();
        let run = Run { steps: Steps::Fixed(step), ..Run::release(0.2, 100.0) };
        let whole = forward(&model, &run, &mut |_| ControlFlow::Continue(())).unwrap();
        let control = Control { steps: Steps::Fixed(step), ..Control::default() };
        let start = Initial::Straight.state(&model).unwrap();
        let mut stepper = Stepper::with(&model, start, Method::Auto, control).unwrap();
        stepper.step_to(0.2).unwrap();
        assert_eq!(stepper.state(), &whole.state(20));
        assert_eq!(stepper.effort(), whole.effort);
    }
}

/// Short steps, and a state that is taken out and put in again, stay within some dozen times the error that is admitted in a
/// step, 1e-6 of the length.
#[test]
fn adaptive_steps_follow_the_run() {
    let model = Model::new(&spec().with(&LOSSES)).unwrap();
    let whole = forward(&model, &Run::release(1.0, 100.0), &mut |_| ControlFlow::Continue(())).unwrap();
    let mut stepper = at_release(&model);
    for k in 1..=100 {
        stepper.step_to(0.01 * f64::from(k)).unwrap();
        if k == 50 {
            let state = stepper.state().clone();
            stepper.step(0.3).unwrap();
            stepper.set_state(state);
        }
        let [x, z] = whole.tip[k as usize];
        let position = stepper.tip().position;
        assert!((position[0] - x).hypot(position[1] - z) < 1e-5, "{k}: {position:?}, due [{x}, {z}]");
    }
}

/// Where pressure steps with the commands, small commands come to what a pressure that changes all the time does.
#[test]
fn a_pressure_in_small_steps_is_a_pressure_that_changes() {
    let muscle = Muscle::built_in("garbulinski-2022").unwrap();
    let at = |pressure: f64| muscle.at(pressure, "pder_32", Extrapolation::Refused).unwrap();
    let damped = [("rayleigh_mass.alpha", 2.0), ("rayleigh_stiffness.beta", 1e-4)];
    let spec = ModelSpec { nodes: 12, ..muscle.spec(&at(100e3)) }.with(&damped);
    let pressure = |time: f64| 100e3 + 200e3 * time.clamp(0.0, 1.0);
    let rows = [(0.0, pressure(0.0)), (1.0, pressure(1.0))];
    let schedule = PressureSchedule::new(muscle.clone(), "pder_32", Extrapolation::Refused, &rows).unwrap();
    let changing = Model::new(&ModelSpec { schedule: Some(Arc::new(schedule)), ..spec.clone() }).unwrap();
    let due = forward(&changing, &Run::release(1.5, 10.0), &mut |_| ControlFlow::Continue(())).unwrap();
    let miss = |commands: u32| {
        let mut stepper = at_release(&Model::new(&spec).unwrap());
        for k in 0..commands {
            let [begin, end] = [k, k + 1].map(|k| 1.5 * f64::from(k) / f64::from(commands));
            stepper.set_rod(&muscle.rod(&at(pressure(0.5 * (begin + end))))).unwrap();
            stepper.step_to(end).unwrap();
        }
        let ([x, z], [a, b]) = (stepper.tip().position, due.tip[15]);
        (x - a).hypot(z - b)
    };
    let [coarse, fine] = [75, 300].map(miss);
    assert!(coarse < 2e-3 && fine < 0.3 * coarse, "{coarse} m, then {fine} m");
    // A stepper knows pressures that change by themselves, too.
    let mut stepper = at_release(&changing);
    stepper.step_to(1.5).unwrap();
    let ([x, z], [a, b]) = (stepper.tip().position, due.tip[15]);
    assert!((x - a).hypot(z - b) < 1e-5, "{x} {z}, due {a} {b}");
}

/// A payload that is picked up moves no node, and is what the rod hangs from in the end.
#[test]
fn a_payload_is_carried_from_then_on() {
    let model = Model::new(&spec().with(&[("rayleigh_mass.alpha", 20.0), ("rayleigh_stiffness.beta", 0.02)]))
        .unwrap();
    let mut stepper = at_release(&model);
    stepper.step(0.1).unwrap();
    let (nodes, effort) = (stepper.nodes().to_vec(), stepper.effort());
    stepper.set_all(&[("payload.mass", 0.02), ("payload.center_of_mass", 0.03)]).unwrap();
    let moved = nodes.iter().zip(stepper.nodes()).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
    assert!(moved.fold(0.0, f64::max) < 1e-15);
    stepper.step(5.0).unwrap();
    assert!(stepper.effort().steps > effort.steps, "effort is counted on");
    let rest = equilibrium(stepper.model(), None).unwrap();
    let moved = stepper.state().q.iter().zip(&rest.q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(moved < 1e-5, "{moved} m from the rest with the payload");
}

#[test]
fn a_change_that_cannot_be_changes_nothing() {
    let model = Model::new(&spec()).unwrap();
    let mut stepper = at_release(&model);
    let bad = stepper.set_all(&[("payload.mass", 0.02), ("payload.mas", 0.02)]);
    assert!(matches!(bad, Err(ChangeError::Model(_))), "{bad:?}");
    assert_eq!(stepper.model().theta, model.theta);
    // Without any loss Verlet is taken; with some it cannot be.
    let start = Initial::Straight.state(&model).unwrap();
    let mut verlet = Stepper::with(&model, start.clone(), Method::Verlet, Control::default()).unwrap();
    assert_eq!(verlet.set("rayleigh_mass.alpha", 1.0), Err(ChangeError::Method(IntegrateError::Explicit)));
    verlet.step(0.01).unwrap();
    stepper.set("rayleigh_mass.alpha", 1.0).unwrap();
    stepper.step(0.01).unwrap();
    let few = Control { most_steps: 2, ..Control::default() };
    let mut stepper = Stepper::with(&model, start, Method::Rodas4, few).unwrap();
    assert!(matches!(stepper.step(1.0), Err(IntegrateError::TooManySteps { steps: 2, .. })));
}

#[test]
fn a_stepper_may_go_to_another_thread() {
    fn may_go<T: Send>(_: &T) {}
    may_go(&at_release(&Model::new(&spec()).unwrap()));
}
