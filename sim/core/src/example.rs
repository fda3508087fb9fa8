//! The muscle of the paper, for examples and tests.

use std::ops::ControlFlow;

use models::effects::Rod;
use models::model::{Model, ModelSpec, Scheme};

use crate::forward::{FAST_TOLERANCE, Run, forward};
use crate::trajectory::Trajectory;

/// Table 1 and the 15 psi row of Table 2 of Garbulinski & Wereley 2022, with 1/s of mass damping.
/// # Panics
/// Never: the values make a model.
pub fn muscle_at_15_psi() -> Model {
    Model::new(&spec_at_15_psi()).expect("a rod with a fitting")
}

/// What [`muscle_at_15_psi`] is built from.
pub fn spec_at_15_psi() -> ModelSpec {
    let end_fitting = vec![("mass".to_owned(), 0.05492), ("center_of_mass".to_owned(), 0.0168)];
    ModelSpec {
        nodes: 32,
        rod: Rod {
            length: 0.20295,
            mass: 0.02418,
            bending_stiffness: 0.00709,
            axial_stiffness: 325.0,
            diameter: 0.0269,
            pressure: 103_421.0,
        },
        base_angle: 0.0,
        release_angle: 0.0,
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: 0.0168,
        effects: vec![
            ("end_fitting".to_owned(), end_fitting),
            ("rayleigh_mass".to_owned(), vec![("alpha".to_owned(), 1.0)]),
        ],
        catalogue: Default::default(),
        schedule: None,
    }
}

/// A straight release of so many seconds, sampled a hundred times a second, with its energy.
/// # Panics
/// Where the model cannot be simulated.
pub fn released(model: &Model, duration: f64) -> (Run, Trajectory) {
    let run = Run { energy: true, tolerance: FAST_TOLERANCE, ..Run::release(duration, 100.0) };
    let trajectory = forward(model, &run, &mut |_| ControlFlow::Continue(())).expect("a release");
    (run, trajectory)
}
