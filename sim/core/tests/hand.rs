//! A rod that starts in a hand: with the velocity of its equilibrium, and with derivatives of all that moves the start.

use std::ops::ControlFlow;

use efam_core::forward::{Run, forward};
use efam_core::initial::Initial;
use efam_core::models::effects::Rod;
use efam_core::models::effects::tip_hold::{HELD, PULL};
use efam_core::models::model::{Model, ModelSpec};
use efam_core::point::Point;
use efam_core::trajectory::Trajectory;

/// A rod with a hand of 30 mN upwards, which changes at the rates given, N/s along x and z, and of a moment, N m/s.
fn model(rates: [f64; 3]) -> Model {
    let rod = Rod {
        length: 0.2,
        mass: 0.03,
        bending_stiffness: 5e-3,
        axial_stiffness: 500.0,
        diameter: 0.03,
        pressure: 0.0,
    };
    let values = [
        ("tip_hold.force_z", 0.03),
        ("tip_hold.rate_x", rates[0]),
        ("tip_hold.rate_z", rates[1]),
        ("tip_hold.rate_moment", rates[2]),
        ("rayleigh_stiffness.beta", 5e-3),
    ];
    Model::new(&ModelSpec { nodes: 12, ..ModelSpec::of(rod) }.with(&values)).unwrap()
}

/// What a release of a model shows at some times, with derivatives by parameters.
fn released(model: &Model, sensitivities: Vec<usize>) -> Trajectory {
    let mut hold = model.clone();
    hold.set(HELD, 1.0).unwrap();
    let own = vec![hold.index(HELD).unwrap()];
    let run = Run {
        initial: Initial::Equilibrium { hold: Box::new(hold), own },
        sensitivities,
        points: vec![Point::Tip, Point::Along(0.5)],
        tolerance: 1e-9,
        ..Run::release(0.2, 20.0)
    };
    forward(model, &run, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Where a model starts: both points.
fn start(model: &Model) -> Vec<[f64; 2]> {
    released(model, Vec::new()).points[0].clone()
}

#[test]
fn a_hand_that_moves_lets_go_with_the_velocity_of_the_rest() {
    let rates = [0.2, -0.5, 0.04];
    let seen = released(&model(rates), Vec::new()).point_velocities[0].clone();
    let aside = |time: f64| {
        let mut model = model(rates);
        let [x, z, _, _, moment, _] = PULL;
        for (path, rate) in [x, z, moment].into_iter().zip(rates) {
            let k = model.index(path).unwrap();
            model.theta[k] += rate * time;
        }
        start(&model)
    };
    let (after, before) = (aside(1e-3), aside(-1e-3));
    for (point, seen) in seen.iter().enumerate() {
        for axis in 0..2 {
            let due = (after[point][axis] - before[point][axis]) / 2e-3;
            assert!((seen[axis] - due).abs() < 1e-4 * (1e-2 + due.abs()), "{point}: {seen:?}, due {due}");
        }
    }
    assert_eq!(released(&model([0.0; 3]), Vec::new()).point_velocities[0], [[0.0; 2]; 2]);
}

#[test]
fn derivatives_of_a_start_in_a_hand_match_differences() {
    let model = model([0.2, -0.5, 0.04]);
    let paths = [PULL.as_slice(), &["rod.bending_stiffness", "rod.mass"]].concat();
    let indices: Vec<usize> = paths.iter().map(|path| model.index(path).unwrap()).collect();
    let found = released(&model, indices.clone());
    for (lane, (path, k)) in paths.iter().zip(&indices).enumerate() {
        let step = 1e-4 * model.theta[*k].abs().max(1e-2 * model.parameters[*k].scale);
        let [plus, minus] = [step, -step].map(|step| {
            let mut model = model.clone();
            model.theta[*k] += step;
            released(&model, Vec::new()).points
        });
        let due =
            |sample: usize, axis: usize| (plus[sample][0][axis] - minus[sample][0][axis]) / (2.0 * step);
        let all = || (0..plus.len()).flat_map(|sample| [(sample, 0), (sample, 1)]);
        let most = all().map(|(sample, axis)| due(sample, axis).abs()).fold(0.0, f64::max);
        for (sample, axis) in all() {
            let (seen, due) = (found.points_by_parameters[sample][0][lane][axis], due(sample, axis));
            assert!((seen - due).abs() < 2e-3 * most, "{path}, sample {sample}: {seen}, due {due} of {most}");
        }
    }
}
