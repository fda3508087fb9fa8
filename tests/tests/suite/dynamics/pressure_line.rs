//! Goal: a pressure line delays a commanded pressure as its closed form says, in a simulation and in a linear model.
//! Setup: the paper's muscle with damping and memory at 30 psi; commands that step to 36 psi within a millisecond.
//! Expected: the run under a pressure that is tabulated from the closed form; a pole at −1/τ; the response of the rod times
//! 1/(1 + sτ); slopes by the parameters that are those of differences. Each tolerance is written beside its test.

use std::f64::consts::TAU;

use efam_core::forward::{Initial, Run};
use efam_core::linear::Complex;
use efam_core::trajectory::Trajectory;
use models::line::RodPressure;
use models::model::Model;
use models::statics::equilibrium;
use models::system::System;
use tests::{PSI, paper, simulate};

use super::linear_model::{DAMPING, NODES, VISCOELASTIC, linear, swept, under};

const LAG: f64 = 0.15;
const DEAD: f64 = 0.04;
/// From when to when the command steps, s.
const STEP: [f64; 2] = [0.2, 0.201];

fn effects(line: &[(&'static str, f64)]) -> Vec<(&'static str, f64)> {
    [&DAMPING[..], &VISCOELASTIC, line].concat()
}

fn stepped(line: &[(&'static str, f64)]) -> Model {
    under(&[(0.0, 30.0 * PSI), (STEP[0], 30.0 * PSI), (STEP[1], 36.0 * PSI)], &effects(line))
}

fn run(model: &Model, sensitivities: &[usize]) -> Trajectory {
    let hold = paper(30.0, NODES, &effects(&[]));
    let rest = equilibrium(&hold, None).expect("it hangs");
    let posture = System::new(&hold).assembly.posture(&rest.q, &vec![0.0; rest.q.len()]);
    let sensitivities = sensitivities.to_vec();
    simulate(
        model,
        &Run {
            initial: Initial::Posture(posture),
            tolerance: 1e-9,
            sensitivities,
            ..Run::release(1.2, 50.0)
        },
    )
}

/// Largest distance of two paths of the tip, over how far the first goes.
fn apart(one: &Trajectory, other: &Trajectory) -> f64 {
    let far = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let most = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
    let way = most(&mut one.tip.iter().map(|tip| far(tip, &one.tip[0])));
    most(&mut one.tip.iter().zip(&other.tip).map(|(a, b)| far(a, b))) / way
}

/// The answer of a first-order lag to a ramp from 0 to 1 that begins at 0 and takes `length`.
fn lagged(time: f64, length: f64) -> f64 {
    let ramp = |time: f64| if time > 0.0 { time - LAG * (1.0 - (-time / LAG).exp()) } else { 0.0 };
    (ramp(time) - ramp(time - length)) / length
}

/// The pressure itself to rounding; the swing as far as straight pieces of 2 ms follow the exponential:
/// an eighth of (2 ms/τ)² of the step, and the tolerance of the runs.
#[test]
fn a_step_is_followed_with_lag_and_dead_time() {
    let model = stepped(&[("pressure_line.time_constant", LAG), ("pressure_line.dead_time", DEAD)]);
    let due = |time: f64| (30.0 + 6.0 * lagged(time - DEAD - STEP[0], STEP[1] - STEP[0])) * PSI;
    let pressure = RodPressure::of(&model);
    for k in 0..=600 {
        let time = 0.002 * f64::from(k);
        assert!((pressure.at(time) - due(time)).abs() < 1e-9 * due(time), "{time} s: {}", pressure.at(time));
    }
    let begin = STEP[0] + DEAD;
    let rows = (0..500).map(|k| begin + 0.002 * f64::from(k)).map(|time| (time, due(time)));
    let tabulated = under(&[(0.0, 30.0 * PSI)].into_iter().chain(rows).collect::<Vec<_>>(), &effects(&[]));
    let off = apart(&run(&tabulated, &[]), &run(&model, &[]));
    let at_once = apart(&run(&tabulated, &[]), &run(&stepped(&[]), &[]));
    println!("lag: {off:.1e} of the way from the tabulated pressure; without a line {at_once:.2}");
    assert!(off < 1e-4 && at_once > 0.05, "{off:.1e}, {at_once:.1e}");
}

/// With a limit of 10 psi/s and no lag the step is a ramp of 0.6 s, and the rod that of the ramp.
#[test]
fn a_step_is_followed_at_the_rate_limit() {
    let model = stepped(&[("pressure_line.time_constant", 0.0), ("pressure_line.rate_limit", 10.0 * PSI)]);
    let ramp = [(0.0, 30.0 * PSI), (STEP[0], 30.0 * PSI), (STEP[0] + 0.6, 36.0 * PSI)];
    let ramp = under(&ramp, &effects(&[]));
    for k in 0..=120 {
        let [found, due] = [&model, &ramp].map(|model| RodPressure::of(model).at(0.01 * f64::from(k)));
        assert!((found - due).abs() < 1e-9 * due, "{k}: {found}, due {due}");
    }
    let off = apart(&run(&ramp, &[]), &run(&model, &[]));
    println!("rate limit: {off:.1e} of the way from the ramp");
    assert!(off < 1e-5, "{off:.1e}");
}

/// The poles are those of the rod and −1/τ, and the response is that of the rod times that of the line. A swept command shows
/// it to 1 %, as without a line.
#[test]
fn a_linear_model_has_the_state_of_the_line() {
    let outputs = ["tip_x", "tip_z"];
    let [rod, behind] = [&[][..], &[("pressure_line.time_constant", LAG)]]
        .map(|line| linear(&paper(30.0, NODES, &effects(line)), 30.0, &["force_z", "pressure"], &outputs));
    assert_eq!(behind.states.last().map(|state| state.name.as_str()), Some("rod_pressure"));
    let pole =
        behind.modal.poles().into_iter().map(|pole| (pole.at.re * LAG + 1.0).abs()).fold(1.0, f64::min);
    assert!(pole < 1e-9, "{pole:e}");
    for frequency in [0.0, 0.3, 1.3, 5.0, 20.0] {
        let s = Complex::new(0.0, TAU * frequency);
        let (found, due) = (behind.modal.response(s), rod.modal.response(s));
        for output in 0..2 {
            for (input, lag) in [(0, Complex::from(1.0)), (1, (1.0 + s * LAG).inv())] {
                let error = (found[(output, input)] / (due[(output, input)] * lag) - 1.0).norm();
                assert!(error < 1e-9, "{frequency} Hz, {output} by {input}: {error:e}");
            }
        }
    }
    for frequency in [0.5, 1.3, 3.0] {
        let rows: Vec<_> = (0..=(14.0 * frequency * 100.0) as usize)
            .map(|k| {
                let phase = TAU * k as f64 / 100.0;
                (k as f64 / 100.0 / frequency, (30.0 + 0.3 * phase.sin()) * PSI)
            })
            .collect();
        let line = effects(&[("pressure_line.time_constant", LAG)]);
        let hold = paper(30.0, NODES, &effects(&[]));
        let found = swept(&under(&rows, &line), &hold, frequency) / (0.3 * PSI);
        let due = behind.modal.response(Complex::new(0.0, TAU * frequency))[(1, 1)];
        let error = (found / due - 1.0).norm();
        println!("command, {frequency} Hz: {error:.1e}");
        assert!(error < 0.01, "{frequency} Hz: {found} against {due}, {error:.4}");
    }
}

/// A calibration can fit the line: what the tip does by its parameters is what runs differ by, to the tolerance of runs over
/// what a hundredth of the parameter does.
#[test]
fn slopes_by_the_line_are_those_of_differences() {
    let line = [
        ("pressure_line.time_constant", LAG),
        ("pressure_line.dead_time", DEAD),
        ("pressure_line.rate_limit", 20.0 * PSI),
    ];
    let model = stepped(&line);
    let all: Vec<usize> =
        line.iter().map(|(path, _)| model.index(&format!("effects.{path}")).expect("there")).collect();
    let found = run(&model, &all);
    for (place, k) in all.iter().enumerate() {
        let step = 1e-2 * model.theta[*k];
        let side = |sign: f64| {
            let mut moved = model.clone();
            moved.theta[*k] += sign * step;
            run(&moved, &[]).tip
        };
        let (plus, minus) = (side(1.0), side(-1.0));
        let (mut worst, mut scale) = (0.0_f64, 0.0_f64);
        for (s, (plus, minus)) in plus.iter().zip(&minus).enumerate() {
            for c in 0..2 {
                let due = (plus[c] - minus[c]) / (2.0 * step);
                worst = worst.max((found.tip_by_parameters[s][place][c] - due).abs());
                scale = scale.max(due.abs());
            }
        }
        println!("{}: {:.1e} of {scale:.2e}", model.parameters[*k].path, worst / scale);
        assert!(worst < 1e-3 * scale, "{}: {worst:e} of {scale:e}", model.parameters[*k].path);
    }
}
