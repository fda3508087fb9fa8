//! How long a release takes in the library, without files and pages: what `tests/peers` measures of ours.
//!
//! `cargo run --release -p efam --no-default-features --example release -- SCENARIO REPEATS [PATH=VALUE…]` prints the
//! shortest wall time of REPEATS runs, s, and how many steps one took, then the path of the tip, m. With REPEATS of 0
//! it only reads the scenario.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use efam_core::forward::{Run, forward};
use efam_experiments::scenario::Scenario;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scenario, repeats, set @ ..] = &words[..] else {
        return Err("release SCENARIO REPEATS [PATH=VALUE…]".into());
    };
    let text = std::fs::read_to_string(scenario)?;
    let cases = Scenario::parse(Path::new(scenario), &text, set)?.cases()?;
    let case = cases.first().ok_or("a scenario has one case at least")?;
    // The path alone, as the others give it.
    let run = Run { energy: false, ..case.run.clone() };
    let (mut wall, mut steps, mut tip) = (f64::INFINITY, 0, Vec::new());
    for _ in 0..repeats.parse::<usize>()? {
        let begin = Instant::now();
        let trajectory = forward(&case.model, &run, &mut |_| ControlFlow::Continue(()))?;
        wall = wall.min(begin.elapsed().as_secs_f64());
        (steps, tip) = (trajectory.effort.steps, trajectory.tip);
    }
    println!("{wall},{steps}");
    tip.iter().for_each(|[x, z]| println!("{x},{z}"));
    Ok(())
}
