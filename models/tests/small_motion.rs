//! Goal: the linear equations of motion about a rest are the derivatives of the nonlinear ones.
//! Setup: a bent muscle with every kind of law that has a derivative at rest: weight, damping, drag, two memories.
//! Expected: central differences of the right side agree to 1e-5 of each row's largest entry.

use models::effects::Rod;
use models::model::{Model, ModelSpec};
use models::statics::{Equilibrium, SmallMotion, equilibrium, modes};
use models::system::System;
use nalgebra::DVector;

fn rod() -> Rod<f64> {
    Rod {
        length: 0.2,
        mass: 0.03,
        bending_stiffness: 8e-3,
        axial_stiffness: 400.0,
        diameter: 0.027,
        pressure: 1e5,
    }
}

fn model(values: &[(&str, f64)]) -> Model {
    let spec = ModelSpec { nodes: 8, base_angle: 0.2, tip_distance: 0.01, ..ModelSpec::of(rod()) };
    let spec = spec.with(&[
        ("gravity.acceleration", 9.81),
        ("payload.mass", 0.01),
        ("payload.center_of_mass", 0.02),
        ("rayleigh_mass.alpha", 0.4),
        ("rayleigh_stiffness.beta", 1e-3),
        ("linear_drag.drag_per_length", 0.01),
    ]);
    Model::new(&spec.with(values)).unwrap()
}

/// Rates of `[q, v, z]` at a state.
fn rates(system: &mut System, x: &DVector<f64>) -> DVector<f64> {
    let (n, m) = (system.model.dof(), system.model.memory());
    let (q, v, z) = (&x.as_slice()[..n], &x.as_slice()[n..2 * n], &x.as_slice()[2 * n..]);
    let (mut force, mut z_rate) = (vec![0.0; n], vec![0.0; m]);
    system.force(0.0, q, v, z, &mut force, &mut z_rate);
    let accelerations = force.iter().zip(&system.mass).map(|(force, mass)| force / mass);
    DVector::from_iterator(2 * n + m, v.iter().copied().chain(accelerations).chain(z_rate))
}

fn state(rest: &Equilibrium) -> DVector<f64> {
    let zero = vec![0.0; rest.q.len()];
    DVector::from([rest.q.clone(), zero, rest.z.clone()].concat())
}

#[test]
fn the_state_matrix_matches_differences() {
    let model = model(&[
        ("viscoelastic.branch_stiffness", 0.3),
        ("viscoelastic.relaxation_time", 0.2),
        ("creep.creep_stiffness", 0.2),
    ]);
    let rest = equilibrium(&model, None).unwrap();
    let a = SmallMotion::about(&model, &rest).state_matrix();
    let x = state(&rest);
    assert_eq!(a.nrows(), x.len());
    assert!(model.memory() > 0);
    let mut system = System::at_rest(&model);
    let step = 1e-6;
    let mut differences = a.clone();
    for k in 0..x.len() {
        let at = |system: &mut System, by: f64| {
            let mut moved = x.clone();
            moved[k] += by;
            rates(system, &moved)
        };
        let difference = (at(&mut system, step) - at(&mut system, -step)) / (2.0 * step);
        differences.column_mut(k).copy_from(&difference);
    }
    for (row, (own, due)) in a.row_iter().zip(differences.row_iter()).enumerate() {
        let error = (own - due).amax() / due.amax();
        assert!(error < 1e-5, "row {row}: {error:.1e}");
    }
}
