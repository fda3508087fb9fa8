//! Goal: every method converges with the order that it declares.
//! Setup: a soft rod of 5 nodes with drag and memory, whose fastest mode all steps resolve, 0.4 s.
//! Expected: slope of log error over log step within 0.2 of the order, over five halvings, against a
//! run of RODAS4 with steps of 50 µs, whose own error is below 1e-14 m (that RODAS4 converges to
//! what the other families converge to is the suite `dynamics::methods_agree`).

use std::ops::ControlFlow;

use efam_core::forward::{Run, forward};
use efam_core::integrate::{Method, Steps};
use models::effects::Rod;
use models::model::{Model, ModelSpec, Scheme};
use tests::{order, paper_spec, simulate};

fn soft(lossy: bool) -> Model {
    let value = |name: &str, key: &str, value: f64| (name.to_owned(), vec![(key.to_owned(), value)]);
    let mut effects = vec![value("end_fitting", "mass", 0.1)];
    if lossy {
        effects.extend([
            value("rayleigh_mass", "alpha", 0.5),
            value("rayleigh_stiffness", "beta", 0.003),
            value("viscoelastic", "relaxation_time", 0.1),
        ]);
    }
    Model::new(&ModelSpec {
        nodes: 5,
        rod: Rod {
            length: 0.5,
            mass: 0.2,
            bending_stiffness: 0.02,
            axial_stiffness: 20.0,
            diameter: 0.02,
            pressure: 0.0,
        },
        base_angle: 0.0,
        release_angle: 0.3,
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: 0.0,
        effects,
        catalogue: Default::default(),
        schedule: None,
    })
    .expect("valid")
}

fn order_of(method: Method, steps: [f64; 5], lossy: bool) -> f64 {
    let model = soft(lossy);
    let run = Run { samples: vec![0.4], method, tolerance: 1e-13, ..Run::release(0.4, 1.0) };
    let end = |run: &Run| simulate(&model, run).tip[0];
    let exact = end(&Run { method: Method::Rodas4, steps: Steps::Fixed(5e-5), ..run.clone() });
    let errors = steps.map(|h| {
        let found = end(&Run { steps: Steps::Fixed(h), ..run.clone() });
        (found[0] - exact[0]).hypot(found[1] - exact[1])
    });
    order(&steps, &errors)
}

fn halved(first: f64) -> [f64; 5] {
    std::array::from_fn(|k| first / 2.0_f64.powi(k as i32))
}

#[test]
fn rodas4_has_order_four() {
    let found = order_of(Method::Rodas4, halved(8e-3), true);
    assert!((found - 4.0).abs() < 0.2, "{found}");
}

#[test]
fn verlet_has_order_two() {
    let found = order_of(Method::Verlet, halved(1e-3), false);
    assert!((found - 2.0).abs() < 0.2, "{found}");
}

/// A fit compares models on the steps of one of them. A loss that bends the path more sharply than those steps
/// were made for has them halved, down to where it is resolved: until it was, such a fit ended where it began.
#[test]
fn given_steps_are_halved_where_another_model_needs_it() {
    let with = |coefficient: f64| {
        let effects = [("rayleigh_stiffness.beta", 2e-3), ("strain_rate_cubed.coefficient", coefficient)];
        Model::new(&paper_spec(40.0, 32, &effects)).expect("the paper's muscle")
    };
    let own = Run { tolerance: 2e-5, keep_steps: true, ..Run::release(2.0, 100.0) };
    let given = simulate(&with(1e-8), &own).steps;
    let model = with(4e-7);
    let on = Run { steps: Steps::Given(given), ..own.clone() };
    let exact = simulate(&model, &Run { tolerance: 1e-7, ..own });
    let found = simulate(&model, &on);
    let miss = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
    let worst = found.tip.iter().zip(&exact.tip).map(miss).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst} m");
}

/// A difference of two runs is one of two models only on the same steps: none of them is halved, though the error calls
/// for it.
#[test]
fn repeated_steps_are_those_of_the_other_run() {
    let model =
        Model::new(&paper_spec(40.0, 32, &[("rayleigh_stiffness.beta", 2e-3)])).expect("the paper's muscle");
    let rough = Run { tolerance: 1e-4, keep_steps: true, ..Run::release(1.0, 100.0) };
    let given = simulate(&model, &rough).steps;
    let strict = |steps: Steps| simulate(&model, &Run { tolerance: 1e-7, steps, ..rough.clone() }).steps;
    assert_eq!(strict(Steps::Repeated(given.clone())), given);
    assert!(strict(Steps::Given(given.clone())).len() > given.len());
}

/// After a step whose error is as large as the rod, a run means nothing: a fit was seen with one that grew to 1e54 m.
#[test]
fn a_step_with_an_error_as_large_as_the_rod_is_refused() {
    let model =
        Model::new(&paper_spec(40.0, 32, &[("rayleigh_stiffness.beta", 2e-3)])).expect("the paper's muscle");
    for steps in [Steps::Repeated(Vec::new()), Steps::Fixed(2.0)] {
        let run = Run { steps, ..Run::release(2.0, 1.0) };
        let refused = forward(&model, &run, &mut |_| ControlFlow::Continue(())).expect_err("a step of 2 s");
        assert!(refused.to_string().contains("too long"), "{refused}");
    }
}
