//! Runs side by side against each alone: goal, the same bits whatever is beside a run; setup, drawn models of many kinds in
//! one batch; expected, equal trajectories, for every operation on a rod of a pack is the one that is done on it alone.

use std::ops::ControlFlow;

use efam_core::example::spec_at_15_psi;
use efam_core::forward::{ForwardError, Job, Run, forward, forward_many};
use efam_core::integrate::Steps;
use efam_core::trajectory::{Status, Trajectory};
use models::model::Model;
use models::pack::RODS;

/// Laws with memory, friction and branches, of the whole rod, of its clamp and of its tip.
const KINDS: [&[(&str, f64)]; 9] = [
    &[],
    &[("rayleigh_stiffness.beta", 0.01)],
    &[("air_drag.drag_coefficient", 1.1), ("rayleigh_stiffness.beta", 0.002)],
    &[("dahl.friction_moment", 1e-4), ("rayleigh_stiffness.beta", 0.002)],
    &[("viscoelastic.branch_stiffness", 1e-3)],
    &[("pressure_volume.stiffening", 0.1), ("rayleigh_stiffness.beta", 0.002)],
    &[("tip_drag.drag_area", 1e-3), ("rayleigh_stiffness.beta", 0.002)],
    &[("clamp_compliance.compliance", 0.2), ("rayleigh_stiffness.beta", 0.002)],
    &[("clamp_friction.friction_moment", 1e-4), ("rayleigh_stiffness.beta", 0.002)],
];

/// A number between 0 and 1 of a sequence that always is the same.
fn drawn(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// Models of a kind with payloads and stiffnesses of their own.
fn models(kind: &[(&str, f64)], count: usize, seed: &mut u64) -> Vec<Model> {
    let one = |_| {
        let mut spec = spec_at_15_psi();
        spec.nodes = 12;
        spec.rod.bending_stiffness *= 0.6 + 0.8 * drawn(seed);
        spec.rod.length *= 0.95 + 0.1 * drawn(seed);
        let mut values: Vec<(&str, f64)> =
            kind.iter().map(|(path, value)| (*path, value * (0.5 + drawn(seed)))).collect();
        values.push(("payload.mass", 0.002 + 0.1 * drawn(seed)));
        Model::new(&spec.with(&values)).expect("a rod with a payload")
    };
    (0..count).map(one).collect()
}

fn run() -> Run {
    Run { tolerance: 3e-5, ..Run::release(1.0, 100.0) }
}

type Done = Result<Trajectory, ForwardError>;

fn together(jobs: &[Job]) -> Vec<Done> {
    let mut all: Vec<Option<Done>> = jobs.iter().map(|_| None).collect();
    forward_many(jobs, &mut |_, _| ControlFlow::Continue(()), &mut |place, done| {
        assert!(all[place].replace(done).is_none(), "each job is done once");
    });
    all.into_iter().map(|done| done.expect("each job is done")).collect()
}

fn alone(job: &Job) -> Done {
    forward(job.model, job.run, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn each_run_has_the_bits_that_it_has_alone() {
    let mut seed = 61;
    let of_kinds: Vec<Vec<Model>> = KINDS.iter().map(|kind| models(kind, RODS + 3, &mut seed)).collect();
    // Kinds by turns, so that they are grouped.
    let all: Vec<&Model> = (0..RODS + 3).flat_map(|k| of_kinds.iter().map(move |own| &own[k])).collect();
    let run = Run { keep_steps: true, energy: true, ..run() };
    let jobs: Vec<Job> = all.iter().map(|model| Job { model, run: &run }).collect();
    for (place, (job, packed)) in jobs.iter().zip(together(&jobs)).enumerate() {
        assert_eq!(packed, alone(job), "job {place}, kind {}", place % KINDS.len());
    }
}

#[test]
fn neighbours_with_runs_of_their_own_change_nothing() {
    let mut seed = 7;
    let all = models(KINDS[2], 2 * RODS, &mut seed);
    let ends = |run: &Run| alone(&Job { model: &all[0], run }).unwrap().steps;
    let given = ends(&Run { keep_steps: true, ..run() });
    let runs = [
        run(),
        Run { steps: Steps::Fixed(2e-3), ..run() },
        Run { steps: Steps::Given(given.clone()), ..run() },
        Run { steps: Steps::Repeated(given), ..run() },
        Run { tolerance: 1e-6, ..Run::release(0.3, 50.0) },
        // These come to no end.
        Run { most_steps: 20, ..run() },
        Run { steps: Steps::Fixed(0.5), ..run() },
    ];
    let jobs: Vec<Job> = all.iter().zip(runs.iter().cycle()).map(|(model, run)| Job { model, run }).collect();
    let done = together(&jobs);
    for (place, (job, packed)) in jobs.iter().zip(&done).enumerate() {
        assert_eq!(packed, &alone(job), "job {place}");
    }
    assert!(done[5].is_err() && done[6].is_err() && done[12].is_err(), "too few, and too long steps");
}

#[test]
fn an_observer_breaks_off_its_own_run() {
    let mut seed = 3;
    let all = models(KINDS[1], RODS + 1, &mut seed);
    let run = run();
    let jobs: Vec<Job> = all.iter().map(|model| Job { model, run: &run }).collect();
    let is_over = |place: usize, index: usize| place % 2 == 1 && index == 10 * place;
    let mut seen = vec![0; jobs.len()];
    let mut done = Vec::new();
    let observe = &mut |place: usize, sample: &mut efam_core::forward::Sample| {
        seen[place] += 1;
        if is_over(place, sample.index) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    forward_many(&jobs, observe, &mut |place, path| done.push((place, path.unwrap().status)));
    done.sort_by_key(|(place, _)| *place);
    for (place, status) in done {
        let due = if place % 2 == 1 {
            Status::CutShort { time: run.samples[10 * place] }
        } else {
            Status::Complete
        };
        assert_eq!(status, due, "job {place}");
        assert_eq!(seen[place], if place % 2 == 1 { 10 * place + 1 } else { 101 });
    }
}

/// No loss takes Verlet, sensitivities take the variational equations, and a start that cannot be is an error of its own.
#[test]
fn what_cannot_be_packed_is_simulated_all_the_same() {
    let mut seed = 5;
    let damped = models(KINDS[1], 3, &mut seed);
    let mut spec = spec_at_15_psi();
    spec.nodes = 12;
    spec.effects.retain(|(name, _)| name != "rayleigh_mass");
    let undamped = Model::new(&spec).unwrap();
    let plain = run();
    let slopes = Run { sensitivities: vec![2], ..Run::release(0.2, 50.0) };
    let mut jobs = vec![Job { model: &undamped, run: &plain }; 3];
    jobs.extend(damped.iter().map(|model| Job { model, run: &slopes }));
    for (place, (job, packed)) in jobs.iter().zip(together(&jobs)).enumerate() {
        assert_eq!(packed, alone(job), "job {place}");
    }
    assert!(together(&[]).is_empty());
}
