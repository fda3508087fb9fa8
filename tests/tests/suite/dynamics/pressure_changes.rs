//! A pressure that changes: the rod follows its table, and the regulator's work closes the budget.

use std::sync::Arc;

use efam_core::forward::Run;
use efam_core::rest::rest;
use efam_core::trajectory::Trajectory;
use models::model::{Model, ModelSpec};
use models::muscle::{Extrapolation, Muscle};
use models::pressure::PressureSchedule;
use models::statics::equilibrium;
use models::system::System;
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
    let rows = [(0.0, 15.0 * PSI), (1.0, 15.0 * PSI), (3.0, 60.0 * PSI)];
    let off = |nodes: usize| {
        let mut model = drifting(&rows, 4.0, &OVER_PRESSURE);
        model = model.with_nodes(nodes).expect("a mesh");
        let path = simulate(&model, &Run::release(20.0, 10.0));
        let last = paper(60.0, nodes, &OVER_PRESSURE);
        let rest = equilibrium(&last, None).expect("it hangs");
        let tip = System::new(&last).observed_tip(&rest.q, &vec![0.0; rest.q.len()]).0;
        let end = path.tip[path.tip.len() - 1];
        (tip[0] - end[0]).hypot(tip[1] - end[1])
    };
    // The centre of mass of the last half cell stays where it is at release, a share of an edge before the end: what
    // that changes goes with the mass of the half cell and that share, so with the square of the edge length.
    let [coarse, fine] = [24, 47].map(off);
    assert!(coarse < 4e-6 && fine < 0.4 * coarse, "{coarse:e} and {fine:e} m");
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

/// What is dissipated in a fast ramp never comes back, and what damping resists is paid by the regulator.
#[test]
fn a_fast_ramp_dissipates_and_closes_the_budget() {
    let rows = [(0.0, 15.0 * PSI), (0.3, 15.0 * PSI), (0.32, 20.0 * PSI)];
    let model = drifting(&rows, 1.0, &[("rayleigh_stiffness.beta", 8e-3)]);
    let path = simulate(&model, &Run { energy: true, tolerance: 1e-8, ..Run::release(1.0, 1000.0) });
    closes(&path);
    for (before, after) in path.energy.iter().zip(&path.energy[1..]) {
        assert!(after.dissipated >= before.dissipated - 1e-12, "{} J come back", before.dissipated);
    }
}

/// Goal: stiffness damping in a ramp, against one equation. Setup: a rod of hardly any mass in line with
/// its clamp, without weight, with the end fitting on it; from 15 to 20 psi in 20 ms. Expected:
/// `m ẍ = −EA ε − β EA ε̇` with `ε = x/L − 1` and `L` and `EA` of the table, by Runge and Kutta's
/// fourth-order method; the rod's own 1e-6 of the mass moves the end by as much of the ramp's 22 mm.
#[test]
fn a_ramp_stretches_a_mass_as_one_equation_says() {
    let rows = [(0.0, 15.0 * PSI), (0.01, 15.0 * PSI), (0.03, 20.0 * PSI)];
    let beta = 8e-3;
    let mut model = drifting(&rows, 0.0, &[("rayleigh_stiffness.beta", beta), ("gravity.acceleration", 0.0)]);
    let mass = model.value("effects.end_fitting.mass").expect("baseline");
    model.set("rod.mass", 1e-6 * mass).expect("positive");
    let arm = model.tip_distance;
    let path = simulate(&model, &Run { tolerance: 1e-7, ..Run::release(0.2, 1000.0) });
    let schedule = model.schedule.clone().expect("it has one");
    let rod = model.rod();
    let acceleration = |time: f64, since: f64, x: f64, v: f64| {
        let [[length, rate, _], _, [axial, ..], _] = schedule.factors(time, since);
        let (length, rate) = (rod.length * length, rod.length * rate);
        let (strain, strain_rate) = (x / length - 1.0, (v - x * rate / length) / length);
        -rod.axial_stiffness * axial * (strain + beta * strain_rate) / mass
    };
    let (mut x, mut v, step) = (rod.length, 0.0, 1e-6);
    let mut worst: f64 = 0.0;
    for k in 0..200_000 {
        let time = step * f64::from(k);
        if k % 1000 == 0 {
            worst = worst.max((path.tip[k as usize / 1000][0] - arm - x).abs());
        }
        // A step lies on one side of a kink.
        let since = time + 1e-9 * step;
        let of = |share: f64, x: f64, v: f64| [v, acceleration(time + share * step, since, x, v)];
        let a = of(0.0, x, v);
        let b = of(0.5, x + 0.5 * step * a[0], v + 0.5 * step * a[1]);
        let c = of(0.5, x + 0.5 * step * b[0], v + 0.5 * step * b[1]);
        let d = of(1.0, x + step * c[0], v + step * c[1]);
        x += step / 6.0 * (a[0] + 2.0 * (b[0] + c[0]) + d[0]);
        v += step / 6.0 * (a[1] + 2.0 * (b[1] + c[1]) + d[1]);
    }
    assert!(worst < 2e-7, "{worst} m");
}

/// Length and stiffness of the rest come from the pressure of its time, once.
#[test]
fn the_rest_is_the_end_of_the_path() {
    for [from, to] in [[15.0, 60.0], [60.0, 15.0]] {
        let model = drifting(&[(0.0, from * PSI), (1.0, from * PSI), (1.5, to * PSI)], 6.0, &[]);
        let path = simulate(&model, &Run { tolerance: 1e-8, ..Run::release(25.0, 10.0) });
        let [x, z] = rest(&model, 25.0, 1).expect("it hangs").tip;
        let end = path.tip[path.tip.len() - 1];
        let off = (x - end[0]).hypot(z - end[1]);
        assert!(off < 2e-7, "{from} to {to} psi: {off:e} m");
    }
}
