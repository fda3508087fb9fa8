//! Whether a run is as accurate as requested: drawn scenarios against much finer runs of their own.

use std::ops::ControlFlow;
use std::time::Instant;

use efam_core::accuracy::{Errors, Goal, Settled, settle};
use efam_core::forward::{Run, Sample, forward};

use crate::drawn_scenarios::drawn;

/// The result for one accuracy requested of one scenario.
#[derive(Clone, Debug)]
pub struct Found {
    /// The true error over the requested one.
    pub ratio: f64,
    /// Whether there was a warning.
    pub warned: bool,
    /// All that is known of it.
    pub text: String,
}

/// What came of an accuracy and of a tenth of it, without any reference.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Distance of the two paths over the sum of their errors, each as requested or, if that is more, as estimated.
    pub ratio: f64,
    /// The error of mesh and steps, as estimated, of the finer run over that of the coarser one. What attempts of one search
    /// differ by is not in it: a search that makes more attempts sees more of them differ, and warns.
    pub worse: f64,
    /// Whether the errors are said not to be trusted.
    pub warned: bool,
    /// All that is known of it.
    pub text: String,
}

/// The scenario of a seed at an accuracy, m, and at a tenth of it; none where one of them cannot be run to its end.
pub fn compared(seed: u64, requested: f64) -> Option<Compared> {
    let (model, run, scenario) = drawn(seed);
    let settled = [requested, 0.1 * requested].map(|accuracy| {
        let goal = Goal { accuracy: Some(accuracy), chooses_mesh: true, chooses_tolerance: true };
        settle(&model, &run, &goal, &mut quiet).expect("it can be run")
    });
    let [coarse, fine] = [&settled[0], &settled[1]].map(|settled| settled.errors.as_ref());
    let (coarse, fine) = (coarse?, fine?);
    let [a, b] = [coarse, fine].map(|errors| errors.tip_m().max(errors.requested_m));
    let distance = settled[0].trajectory.trace.farthest(&settled[1].trajectory.trace).0;
    let of = |settled: &Settled, errors: &Errors| {
        format!(
            "{:.5} mm with {} nodes, {:.0e}, {} attempts",
            1e3 * errors.tip_m(),
            settled.model.edges + 1,
            settled.run.tolerance,
            errors.attempts
        )
    };
    Some(Compared {
        ratio: distance / (a + b),
        worse: (fine.mesh_m + fine.step_m) / (coarse.mesh_m + coarse.step_m),
        warned: fine.apart_m.is_some() || coarse.apart_m.is_some(),
        text: format!(
            "seed {seed}: {:.5} mm apart; {}; {}; {scenario}",
            1e3 * distance,
            of(&settled[0], coarse),
            of(&settled[1], fine)
        ),
    })
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
