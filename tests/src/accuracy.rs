//! Whether a run is as accurate as was asked: drawn scenarios against much finer runs of their own.

use std::ops::ControlFlow;
use std::time::Instant;

use efam_core::accuracy::{Errors, Goal, Settled, settle};
use efam_core::forward::{Run, Sample, forward};

use crate::drawn_scenarios::drawn;

/// What came of one accuracy that was asked of one scenario.
#[derive(Clone, Debug)]
pub struct Found {
    /// The true error over what was asked.
    pub ratio: f64,
    /// Whether there was a warning.
    pub warned: bool,
    /// All that is known of it.
    pub text: String,
}

fn quiet(_: &mut Sample) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The scenario of a seed at some accuracies, m, the last being the finest, against a mesh eight times finer than that
/// one's and a tolerance of a thousandth. Empty if that reference fails.
pub fn found(seed: u64, asked: &[f64]) -> Vec<Found> {
    let (model, run, scenario) = drawn(seed);
    let goal = |accuracy| Goal { accuracy, chooses_mesh: true, chooses_tolerance: true };
    let settled: Vec<(Settled, f64)> = asked
        .iter()
        .map(|asked| {
            let begin = Instant::now();
            let settled = settle(&model, &run, &goal(Some(*asked)), &mut quiet).expect("it can be run");
            (settled, begin.elapsed().as_secs_f64())
        })
        .collect();
    let Some((finest, _)) = settled.last() else { return Vec::new() };
    let (exact, exact_run) =
        finest.run.on_mesh(&finest.model, (finest.model.edges * 8).min(400) + 1).expect("a mesh");
    let tolerance = (1e-3 * finest.run.tolerance).max(1e-11);
    let exact_run = Run { tolerance, energy: false, most_steps: 400_000, ..exact_run };
    let Ok(exact) = forward(&exact, &exact_run, &mut quiet) else {
        eprintln!("seed {seed}: no reference: {scenario}");
        return Vec::new();
    };
    let one = |(settled, seconds): &(Settled, f64)| {
        let Settled { model, run, trajectory, errors } = settled;
        let errors: &Errors = errors.as_ref().expect("it came to its end");
        let off = trajectory.trace.farthest(&exact.trace).0;
        let text = format!(
            "seed {seed}: asked {} mm, true {:.5}, mesh {:.5}, steps {:.5}, energy {:.5?}; {} nodes, {:.0e}, \
             {} attempts, {seconds:.3} s; {scenario}",
            1e3 * errors.requested_m,
            1e3 * off,
            1e3 * errors.mesh_m,
            1e3 * errors.step_m,
            errors.energy_m.map(|e| 1e3 * e),
            model.edges + 1,
            run.tolerance,
            errors.attempts,
        );
        let warned = !errors.warnings(run, model, &goal(None)).is_empty();
        Found { ratio: off / errors.requested_m, warned, text }
    };
    settled.iter().map(one).collect()
}
