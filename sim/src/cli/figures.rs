//! `efam figures`: the paper's Figures 4 to 9 from our own runs.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;
use sim::figures::{MUSCLE, Pressure, SCENARIO};
use sim::results::figures::{Words, words, write_figures};
use sim::results::{self, Request};
use sim::scenario::{Case, Scenario};
use sim::schema::JsonSchema;
use sim::trajectory::Status;

use super::arguments::{Output, argv};
use super::failure::Failure;
use super::interrupt;
use super::simulate::{admit, follow};
use super::terminal::stdout;
use super::voice::{Voice, print};

const HELP: &str = "Examples:
  efam figures
  efam figures --set effects.rayleigh_mass.alpha=\"0.8 1/s\" --overwrite

Exit codes: 4 if a release cannot be simulated, 130 if it is interrupted, which
saves nothing.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Figures {
    /// Set a value over the scenario of the figures, such as effects.rayleigh_mass.alpha="0.8 1/s"; may be
    /// repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    output: Output,
}

/// What is printed for programs.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the figures are.
    folder: &'a Path,
    /// What each shows, in the paper and here.
    figures: &'a [Words],
}

pub fn run(args: &Figures, voice: &Voice) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let file = Path::new("efam-figures.toml");
    let scenario = Scenario::parse(file, SCENARIO, &args.set)?;
    if !scenario.is_all_rows() || scenario.muscle_name() != Some(MUSCLE) {
        let message = format!(
            "--set: the figures are those of {MUSCLE} at every pressure of its table; leave muscle.name, muscle.file and muscle.pressure as they are, or use efam simulate"
        );
        return Err(Failure::Usage(message));
    }
    let cases = scenario.cases()?;
    admit(&cases)?;
    let mut warnings: Vec<String> = cases.iter().flat_map(|case| case.warnings.clone()).collect();
    warnings.dedup();
    voice.warn(&warnings);
    let hash = |text: &str| results::sha256(text.as_bytes());
    let set: Vec<String> = args.set.iter().map(|set| format!("--set {set}")).collect();
    let mut input_hashes = BTreeMap::from([(results::figures::SCENARIO.to_owned(), hash(SCENARIO))]);
    input_hashes.extend(set.iter().map(|set| (set.clone(), hash(set))));
    let request = Request {
        name: scenario.name.clone(),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        resolved_scenario: set.iter().map(|set| format!("# with {set}\n")).collect::<String>() + SCENARIO,
        warnings,
        input_hashes,
        argv: argv(),
        ..Request::default()
    };
    let folder = results::begin(&request)?;
    interrupt::listen();
    let samples: usize = cases.iter().map(|case| case.run.samples.len()).sum();
    let progress = voice.bar(samples);
    let one = |case: &Case| {
        let trajectory = follow(case, &progress, &mut |_| Ok(()))?;
        match &trajectory.status {
            Status::Failed { reason, .. } => {
                return Err(Failure::Diverged(format!("{}: {reason}", case.name)));
            }
            Status::CutShort { .. } => return Ok(None),
            Status::Complete => {}
        }
        let of = Pressure::new(case, trajectory).map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Some(of))
    };
    let done: Result<Option<Vec<Pressure>>, Failure> = cases.par_iter().map(one).collect();
    let done = done?;
    progress.finish_and_clear();
    let Some(all) = done else {
        return Err(Failure::Interrupted);
    };
    let words = words(&all);
    let request = Request { wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    write_figures(&folder, &request, &all, &words)?;
    let folder = folder.finish()?;
    if args.output.form.json {
        print(&Printed { folder: &folder, figures: &words })?;
    } else if !voice.quiet {
        let mut out = stdout();
        for of in &words {
            writeln!(out, "Figure {}\n  paper: {}\n  ours:  {}", of.number, of.paper, of.ours)?;
        }
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    Ok(ExitCode::SUCCESS)
}
