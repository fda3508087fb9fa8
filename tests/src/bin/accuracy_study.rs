//! Whether a run is as accurate as was asked: `cargo run --release -p tests --bin accuracy_study -- FIRST COUNT`.
//!
//! Draws scenarios, asks for three accuracies, and compares the tip with that on a mesh eight times finer and with a
//! tolerance of a thousandth. Prints each miss, and how often the true error was within 1.5 and 3 times what was asked.

use std::ops::ControlFlow;
use std::time::Instant;

use rayon::prelude::*;
use sim::accuracy::{Goal, Settled, settle};
use sim::forward::{Run, forward};
use tests::drawn_scenarios::drawn;

const ASKED: [f64; 3] = [5e-4, 5e-5, 5e-6];

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse::<u64>().ok());
    let (first, count) = (words.next().unwrap_or(1), words.next().unwrap_or(20));
    let rows: Vec<_> = (first..first + count).into_par_iter().map(of).collect();
    let mut all: Vec<_> = rows.into_iter().flatten().collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share =
        |limit: f64| 100.0 * all.iter().filter(|row| row.0 <= limit).count() as f64 / all.len() as f64;
    println!(
        "{} runs: within what was asked {:.1} %, 1.5 times {:.1} %, 3 times {:.1} %",
        all.len(),
        share(1.0),
        share(1.5),
        share(3.0)
    );
    println!("median {:.2}, least {:.3}", all[all.len() / 2].0, all[0].0);
    for row in all.iter().rev().take_while(|row| row.0 > 1.0) {
        println!("{:.2}{} {}", row.0, if row.1 { " warned" } else { " SILENT" }, row.2);
    }
}

fn of(seed: u64) -> Vec<(f64, bool, String)> {
    let (model, run, text) = drawn(seed);
    let mut quiet = |_: &mut sim::forward::Sample| ControlFlow::Continue(());
    let mut settled: Vec<(Settled, f64)> = Vec::new();
    for asked in ASKED {
        let goal = Goal { accuracy: Some(asked), chooses_mesh: true, chooses_tolerance: true };
        let begin = Instant::now();
        settled.push((
            settle(&model, &run, &goal, &mut quiet).expect("it can be run"),
            begin.elapsed().as_secs_f64(),
        ));
    }
    let finest = &settled[2].0;
    let (exact, exact_run) =
        finest.run.on_mesh(&finest.model, (finest.model.edges * 8).min(400) + 1).expect("a mesh");
    let exact_run = Run {
        tolerance: (1e-3 * finest.run.tolerance).max(1e-11),
        energy: false,
        most_steps: 400_000,
        ..exact_run
    };
    let Ok(exact) = forward(&exact, &exact_run, &mut quiet) else {
        eprintln!("seed {seed}: no reference: {text}");
        return Vec::new();
    };
    let row = |(settled, seconds): &(Settled, f64)| {
        let Settled { model, run, trajectory, errors } = settled;
        let errors = errors.as_ref().expect("it came to its end");
        let off = trajectory.trace.farthest(&exact.trace).0;
        let warned = !errors
            .warnings(run, model, &Goal { accuracy: None, chooses_mesh: true, chooses_tolerance: true })
            .is_empty();
        let text = format!(
            "seed {seed}: asked {} mm, true {:.5}, mesh {:.5}, steps {:.5}, energy {:.5?}; {} nodes, {:.0e}, {} attempts, {:.3} s; {text}",
            1e3 * errors.asked_m,
            1e3 * off,
            1e3 * errors.mesh_m,
            1e3 * errors.step_m,
            errors.energy_m.map(|e| 1e3 * e),
            model.edges + 1,
            run.tolerance,
            errors.attempts,
            seconds
        );
        (off / errors.asked_m, warned, text)
    };
    if std::env::var("EFAM_ALL").is_ok() {
        settled.iter().map(row).for_each(|row| println!("{:.2} {}", row.0, row.2));
    }
    settled.iter().map(row).collect()
}
