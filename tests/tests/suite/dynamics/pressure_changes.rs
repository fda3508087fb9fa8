//! A pressure that changes: the rod follows its table, and the regulator's work closes the budget.

use std::sync::Arc;

use models::model::{Model, ModelSpec};
use models::muscle::{Extrapolation, Muscle};
use models::pressure::PressureSchedule;
use models::statics::equilibrium;
use models::system::System;
use sim::forward::Run;
use sim::trajectory::Trajectory;
use tests::{PSI, paper, paper_spec, simulate};

/// Effects that see the pressure itself.
const OVER_PRESSURE: [(&str, f64); 3] = [
    ("set_curvature.curvature_over_pressure", 1e-6),
    ("damping_over_pressure.mass_rate", 0.1),
    ("damping_over_pressure.stiffness_time", 1e-3),
];

fn drifting(rows: &[(f64, f64)], damping: f64, effects: &[(&str, f64)]) -> Model {
    let muscle = Muscle::built_in("garbulinski-2022").expect("built in");
    let schedule =
        PressureSchedule::new(muscle, "pder_32", Extrapolation::Refused, rows).expect("in the table");
    let effects = [effects, &[("rayleigh_mass.alpha", damping)]].concat();
    let spec = paper_spec(rows[0].1 / PSI, 24, &effects);
    Model::new(&ModelSpec { schedule: Some(Arc::new(schedule)), ..spec }).expect("valid")
}

#[test]
fn ends_at_the_rest_posture_of_the_last_pressure() {
    let model = drifting(&[(0.0, 15.0 * PSI), (1.0, 15.0 * PSI), (3.0, 60.0 * PSI)], 4.0, &OVER_PRESSURE);
    let path = simulate(&model, &Run::release(20.0, 10.0));
    let last = paper(60.0, 24, &OVER_PRESSURE);
    let rest = equilibrium(&last, None).expect("it hangs");
    let tip = sim::forward::tip(&System::new(&last), &rest.q, &vec![0.0; rest.q.len()]).0;
    let end = path.tip[path.tip.len() - 1];
    assert!((tip[0] - end[0]).hypot(tip[1] - end[1]) < 1e-6, "{end:?} against {tip:?}");
}

#[test]
fn the_work_of_the_regulator_closes_the_budget() {
    // With stiffness damping the budget closes to ten times the tolerance, as without a schedule.
    for (effects, tolerance) in [(&OVER_PRESSURE[..0], 1e-6), (&OVER_PRESSURE[..], 1e-8)] {
        let model = drifting(&[(0.0, 15.0 * PSI), (0.5, 15.0 * PSI), (2.0, 40.0 * PSI)], 1.0, effects);
        closes(&simulate(&model, &Run { energy: true, tolerance, ..Run::release(5.0, 100.0) }));
    }
}

fn closes(path: &Trajectory) {
    let total = |k: usize| {
        let e = path.energy[k];
        e.kinetic + e.elastic + e.potential + e.dissipated + e.supplied
    };
    let released = path.energy.iter().map(|e| path.energy[0].potential - e.potential).fold(0.0, f64::max);
    let worst = (0..path.energy.len()).map(|k| (total(k) - total(0)).abs()).fold(0.0, f64::max) / released;
    assert!(worst < 1e-6, "{worst:e}");
    let work = path.energy[path.energy.len() - 1].supplied.abs();
    assert!(work > 1e-3 * released, "there is work to account for: {work} J");
}
