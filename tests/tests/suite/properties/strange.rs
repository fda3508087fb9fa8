//! Goal: whatever a stranger requests converges, or stops with its time, its node and a next move.
//! Setup: stiffnesses of bending over six decades and of the axis over four about those of the muscle, 0.1 to 5 m, up
//! to 5 kg at the tip, no losses and many times critical ones, no weight and ten times it, let go straight at any
//! angle or folded by up to 170°; 1 s with 12 nodes, 50 000 steps at most. The same ones each time, drawn from
//! `PROPTEST_RNG_SEED` for others.
//! Expected: the tip stays where a rod can reach, no energy appears unless the check of the steps warns, a stop says
//! where. A rod that is at rest stays.

use std::ops::ControlFlow;

use efam_core::accuracy::{Goal, settle};
use efam_core::forward::{ForwardError, Initial, Run, forward};
use efam_core::integrate::Steps;
use models::effects::Rod;
use models::model::{Model, ModelSpec};
use models::posture::Posture;
use models::snapshot::Energy;
use proptest::prelude::*;
use tests::{paper_spec, simulate};

use super::cases;

const NODES: usize = 12;

/// Powers of ten by which the rod is other than the muscle, and what else it is.
#[derive(Clone, Debug)]
struct Strange {
    bending: f64,
    axial: f64,
    length: f64,
    payload: f64,
    alpha: f64,
    beta: f64,
    gravity: f64,
    angle: f64,
    fold: f64,
}

fn strange() -> impl Strategy<Value = Strange> {
    let off_or = |range: std::ops::Range<f64>| prop_oneof![Just(0.0), range];
    (
        (-3.0..3.0f64, -2.0..2.0f64, -1.0..0.7f64),
        off_or(0.0..5.0),
        (off_or(0.0..100.0), off_or(0.0..1.0)),
        prop_oneof![Just(0.0), Just(9.81), Just(98.1)],
        (-3.0..3.0f64, off_or(-170.0..170.0)),
    )
        .prop_map(|((bending, axial, length), payload, (alpha, beta), gravity, (angle, fold))| Strange {
            bending: 10f64.powf(bending),
            axial: 10f64.powf(axial),
            length: 10f64.powf(length),
            payload,
            alpha,
            beta,
            gravity,
            angle,
            fold: f64::to_radians(fold),
        })
}

fn model(drawn: &Strange) -> Model {
    let mut spec: ModelSpec = paper_spec(40.0, NODES, &[]);
    spec.effects.retain(|(name, _)| name == "end_fitting");
    let mut add = |name: &str, values: &[(&str, f64)]| {
        let values = values.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect();
        spec.effects.push((name.to_owned(), values));
    };
    add("gravity", &[("acceleration", drawn.gravity)]);
    add("rayleigh_mass", &[("alpha", drawn.alpha)]);
    add("rayleigh_stiffness", &[("beta", drawn.beta)]);
    add("payload", &[("mass", drawn.payload), ("center_of_mass", 0.03)]);
    spec.rod = Rod {
        length: drawn.length,
        bending_stiffness: drawn.bending * spec.rod.bending_stiffness,
        axial_stiffness: drawn.axial * spec.rod.axial_stiffness,
        ..spec.rod
    };
    spec.release_angle = drawn.angle;
    Model::new(&spec).expect("within their ranges")
}

/// Straight, and from its middle on turned by an angle.
fn folded(length: f64, count: usize, fold: f64) -> Posture<f64> {
    let edge = length / (count - 1) as f64;
    let mut nodes = vec![[0.0, 0.0]];
    for k in 1..count {
        let angle = if 2 * k > count { fold } else { 0.0 };
        let [x, z] = nodes[k - 1];
        nodes.push([x + edge * angle.cos(), z + edge * angle.sin()]);
    }
    Posture { velocities: vec![[0.0; 2]; nodes.len()], nodes, angle: fold, rate: 0.0 }
}

fn run(drawn: &Strange) -> Run {
    let initial = match drawn.fold {
        0.0 => Initial::Straight,
        fold => Initial::Posture(folded(drawn.length, NODES, fold)),
    };
    Run { initial, most_steps: 50_000, tolerance: 1e-5, energy: true, ..Run::release(1.0, 100.0) }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn what_is_asked_for_is_simulated_or_stops_with_a_next_move(drawn in strange()) {
        let (model, run) = (model(&drawn), run(&drawn));
        let path = match forward(&model, &run, &mut |_| ControlFlow::Continue(())) {
            Ok(path) => path,
            Err(ForwardError::Integrate { error, trajectory }) => {
                let text = error.to_string();
                let has_move = text.contains("; try ") || text.contains("; raise ");
                prop_assert!(text.contains("t = ") && has_move, "{}", text);
                *trajectory
            }
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        let total = |e: &Energy| e.kinetic + e.elastic + e.potential + e.dissipated + e.supplied;
        let moved = path.energy.iter().map(|e| e.kinetic + e.elastic).fold(0.0, f64::max);
        let Rod { length, mass, axial_stiffness, .. } = model.rod();
        // What hangs on a thread of rubber falls freely for that second, or is flung as far as that gives.
        let reach = length + drawn.gravity + (2.0 * moved * length / axial_stiffness).sqrt();
        prop_assert!(path.tip.iter().flatten().all(|x| x.abs() < 2.0 * reach), "{:?}", path.tip.last());
        // Errors of a step are shares of the length and of the speed of a fall.
        let fall = 9.81 * (mass + drawn.payload) * length;
        let first = path.energy.first().map_or(0.0, total);
        let appeared = path.energy.iter().map(|e| total(e) - first).fold(0.0, f64::max);
        let kept = Goal { accuracy: None, chooses_mesh: false, chooses_tolerance: false };
        let errors = settle(&model, &run, &kept, &mut |_| ControlFlow::Continue(())).expect("it can be run").errors;
        let is_warned = errors.is_none_or(|errors| !errors.warnings(&run, &model, &kept).is_empty());
        let is_small = appeared < 0.05 * moved + 1e-4 * fall;
        prop_assert!(is_small || is_warned, "{} J of {} J appear", appeared, moved);
    }

    #[test]
    fn a_rod_at_rest_stays(drawn in strange()) {
        let model = model(&drawn);
        let hold = Box::new(model.clone());
        let run = Run {
            initial: Initial::Equilibrium { hold, own: Vec::new() },
            most_steps: 50_000,
            ..Run::release(0.5, 20.0)
        };
        // A rod too soft for its weight may have no rest that is found; that says so.
        let Ok(path) = forward(&model, &run, &mut |_| ControlFlow::Continue(())) else { return Ok(()) };
        let moved = |at: &[f64; 2]| (at[0] - path.tip[0][0]).hypot(at[1] - path.tip[0][1]);
        let farthest = path.tip.iter().map(moved).fold(0.0, f64::max);
        prop_assert!(farthest < 1e-5 * drawn.length, "{} m", farthest);
    }
}

/// The path of the tip of the paper's muscle at 40 psi on a mesh, from a start.
fn path(start: &Start, edges: usize) -> Vec<[f64; 2]> {
    let mut spec = paper_spec(start.psi, edges + 1, &[("rayleigh_stiffness.beta", 2e-3)]);
    spec.base_angle = start.clamp;
    spec.release_angle = start.angle;
    spec.release_rate = start.rate;
    if start.payload > 0.0 {
        let values = [("mass", start.payload), ("center_of_mass", 0.03)];
        let values = values.map(|(key, value)| (key.to_owned(), value)).to_vec();
        spec.effects.push(("payload".to_owned(), values));
    }
    let model = Model::new(&spec).expect("the paper's muscle");
    let initial = match start.fold {
        0.0 => Initial::Straight,
        fold => Initial::Posture(folded(model.rod().length, edges + 1, fold)),
    };
    let run = Run { initial, tolerance: 1e-9, ..Run::release(0.6, 100.0) };
    simulate(&model, &run).tip
}

/// How a muscle is let go; angles in rad.
#[derive(Clone, Copy, Debug)]
struct Start {
    psi: f64,
    clamp: f64,
    angle: f64,
    rate: f64,
    fold: f64,
    payload: f64,
}

/// Straight, raised with its clamp, raised while the clamp stays level (a kink at the clamp), folded in its middle, set
/// in motion, loaded, soft: each halving of the edge length moves the path less. In the end it moves it by about an eighth
/// (0.136 was measured), as the third power of the edge length has it. A kink is no curve: there it is a third at most,
/// an order of 1.6. With the soft rod it is a quarter, the second power, at any tolerance of the steps; why is not known.
#[test]
fn finer_meshes_move_towards_one_answer_from_any_start() {
    let straight = Start { psi: 40.0, clamp: 0.0, angle: 0.0, rate: 0.0, fold: 0.0, payload: 0.0 };
    for start in [
        straight,
        Start { clamp: 0.6, angle: 0.6, ..straight },
        Start { angle: 0.44, ..straight },
        Start { fold: 1.5, ..straight },
        Start { rate: 3.0, ..straight },
        Start { payload: 0.1, ..straight },
        Start { psi: 5.0, ..straight },
    ] {
        let paths = [8, 16, 32, 64, 128].map(|edges| path(&start, edges));
        let square = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        let change = |pair: &[Vec<[f64; 2]>]| {
            pair[0].iter().zip(&pair[1]).map(|(a, b)| square(a, b)).sum::<f64>().sqrt()
        };
        let changes: Vec<f64> = paths.windows(2).map(change).collect();
        let ratios: Vec<f64> = changes.windows(2).map(|pair| pair[1] / pair[0]).collect();
        assert!(ratios.iter().all(|ratio| *ratio < 0.5), "{start:?}: {ratios:?}");
        let is_smooth = start.fold == 0.0 && start.angle == start.clamp;
        let most = match is_smooth {
            true if start.psi > 5.0 => 0.15,
            true => 0.25,
            false => 0.33,
        };
        assert!(ratios[2] < most, "{start:?}: {ratios:?}");
    }
}

/// Finer steps move towards one answer, each change being less than the one before.
#[test]
fn finer_steps_move_towards_one_answer() {
    let lowest = |step: f64| {
        let model = Model::new(&paper_spec(40.0, 16, &[("rayleigh_stiffness.beta", 2e-3)]))
            .expect("the paper's muscle");
        let run = Run { steps: Steps::Fixed(step), ..Run::release(0.6, 500.0) };
        simulate(&model, &run).tip.iter().map(|at| at[1]).fold(f64::INFINITY, f64::min)
    };
    let all = [8.0, 4.0, 2.0, 1.0].map(|ms| lowest(1e-3 * ms));
    let changes: Vec<f64> = all.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    assert!(changes.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{all:?}");
}
