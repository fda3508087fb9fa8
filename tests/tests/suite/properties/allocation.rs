//! The step allocates nothing: twice as many steps take as many allocations.

use std::ops::ControlFlow;

use efam_core::forward::{Initial, Run, forward};
use efam_core::integrate::{Method, Steps};
use efam_core::stepper::Stepper;
use tests::paper;

fn allocations(method: Method, duration: f64, sensitivities: Vec<usize>) -> u64 {
    let effects = [
        ("rayleigh_mass.alpha", 1.0),
        ("rayleigh_stiffness.beta", 0.001),
        ("air_drag.drag_coefficient", 1.2),
        ("viscoelastic.branch_stiffness", 0.2),
        ("clamp_compliance.compliance", 1.0),
        ("pressure_volume.stiffening", 1e-3),
    ];
    let model = paper(15.0, 32, if method == Method::Verlet { &[] } else { &effects });
    let run = Run {
        method,
        sensitivities,
        samples: vec![],
        tolerance: 1e-5,
        steps: if method == Method::Verlet { Steps::Fixed(2e-5) } else { Steps::Adaptive },
        ..Run::release(duration, 1.0)
    };
    let info = allocation_counter::measure(|| {
        forward(&model, &run, &mut |_| ControlFlow::Continue(())).expect("it runs");
    });
    info.count_total
}

#[test]
fn in_the_step_of_our_integrators_there_is_none() {
    for method in [Method::Rodas4, Method::Verlet] {
        assert_eq!(allocations(method, 0.5, vec![]), allocations(method, 1.0, vec![]), "{method:?}");
    }
}

#[test]
fn a_stepper_allocates_nothing_between_changes() {
    let model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0), ("viscoelastic.branch_stiffness", 0.2)]);
    let mut stepper =
        Stepper::new(&model, Initial::Straight.state(&model).expect("a start")).expect("it starts");
    let info = allocation_counter::measure(|| {
        for _ in 0..50 {
            stepper.step(0.01).expect("it goes on");
            assert!(stepper.tip().position[1] < 0.0 && stepper.nodes().len() == 32);
        }
    });
    assert_eq!(info.count_total, 0);
}

#[test]
fn in_the_step_of_sensitivities_there_is_none() {
    let ten = || (0..10).collect();
    assert_eq!(allocations(Method::Rodas4, 0.5, ten()), allocations(Method::Rodas4, 1.0, ten()));
}

/// The times of the samples are given; what is seen at them is let go.
#[test]
fn a_run_that_is_only_watched_keeps_nothing() {
    let model = paper(15.0, 12, &[("rayleigh_mass.alpha", 1.0)]);
    let most = |duration: f64, keep_samples: bool| {
        let run = Run { keep_samples, trace_step: None, ..Run::release(duration, 1000.0) };
        let watch = || {
            forward(&model, &run, &mut |sample| {
                sample.snapshot();
                ControlFlow::Continue(())
            })
        };
        allocation_counter::measure(|| drop(watch().expect("it runs"))).bytes_max
    };
    assert_eq!(most(0.5, false), most(1.0, false));
    assert!(most(1.0, true) > most(0.5, true) + 400 * 8 * 40, "what is kept is seen");
}
