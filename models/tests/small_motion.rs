//! Goal: the linear equations of motion about a rest are the derivatives of the nonlinear ones.
//! Setup: a bent muscle with every kind of law that has a derivative at rest: weight, damping, drag, two memories.
//! Expected: central differences of the right side agree to 1e-5 of each row's largest entry.

use std::sync::Arc;

use models::effects::Rod;
use models::model::{Model, ModelSpec};
use models::muscle::{Extrapolation, Muscle};
use models::pressure::PressureSchedule;
use models::statics::{Equilibrium, SmallMotion, equilibrium};
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
    rates_at(system, 0.0, x)
}

fn rates_at(system: &mut System, time: f64, x: &DVector<f64>) -> DVector<f64> {
    let (n, m) = (system.model.dof(), system.model.memory());
    let (q, v, z) = (&x.as_slice()[..n], &x.as_slice()[n..2 * n], &x.as_slice()[2 * n..]);
    let (mut force, mut z_rate) = (vec![0.0; n], vec![0.0; m]);
    system.force(time, q, v, z, &mut force, &mut z_rate);
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

/// By the pressure at a rate of zero, and by the rate, which damping and memory see through the length.
#[test]
fn derivatives_by_pressure_match_differences() {
    let muscle = Muscle::built_in("garbulinski-2022").unwrap();
    let pressure = 2.3e5;
    let at = muscle.at(pressure, "pder_32", Extrapolation::Refused).unwrap();
    let spec = muscle.spec(&at).with(&[
        ("rayleigh_stiffness.beta", 2e-3),
        ("viscoelastic.branch_stiffness", 0.3),
        ("set_curvature.curvature_over_pressure", 1e-6),
        ("damping_over_pressure.stiffness_time", 1e-3),
    ]);
    let under = |change: f64| {
        let rows = [(0.0, pressure), (1.0, pressure + change)];
        let schedule =
            PressureSchedule::new(muscle.clone(), "pder_32", Extrapolation::Refused, &rows).unwrap();
        let spec = ModelSpec { nodes: 8, schedule: Some(Arc::new(schedule)), ..spec.clone() };
        Model::new(&spec).unwrap()
    };
    let rest = equilibrium(&under(0.0), None).unwrap();
    let motion = SmallMotion::about(&under(0.0), &rest);
    let slopes = muscle.rod_slopes(pressure, "pder_32", Extrapolation::Refused).unwrap();
    let x = state(&rest);
    let differences = [
        |model: &Model, x: &DVector<f64>| rates_at(&mut System::at_rest(model), 1.0, x),
        |model: &Model, x: &DVector<f64>| rates_at(&mut System::new(model), 0.0, x),
    ]
    .map(|of| (of(&under(20.0), &x) - of(&under(-20.0), &x)) / 40.0);
    for (own, due) in motion.by_pressure(slopes).into_iter().zip(differences) {
        let n = motion.dof();
        for part in [n..2 * n, 2 * n..x.len()] {
            let [own, due] = [&own, &due].map(|all| all.rows(part.start, part.len()).into_owned());
            // Of second order in 20 Pa, and rounding of the forces over 20 Pa.
            assert!((&own - &due).amax() <= 1e-5 * due.amax(), "{part:?}: {own} due {due}");
        }
    } // Linear in the slopes, as it is only at a rate of zero.
    let value = |scale: f64| motion.by_pressure(slopes.map(|slope| scale * slope))[0].clone();
    let (small, large) = (value(1.0) - value(0.0), value(1e7) - value(0.0));
    assert!((large - 1e7 * &small).amax() < 1e-8 * 1e7 * small.amax());
}
