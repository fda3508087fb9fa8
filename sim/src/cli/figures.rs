//! `efam figures`: the paper's Figures 4 to 9 from our own runs, or from the recordings of an experiment.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_experiments::experiment::Experiment;
use efam_experiments::kind::FileKind;
use efam_report::Request;
use efam_report::figures::{Words, words, write_figures};
use efam_report::paper::Pressure;
use efam_store::Folder;
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::answer;
use super::arguments::{Output, argv};
use super::console::Console;
use super::experiment::{read, request};
use super::failure::{Failure, of_kind};
use super::simulate::{admit, follow};
use super::{interrupt, signals};
use crate::figures::{Runs, admit as admit_experiment, of_recordings, table};

const HELP: &str = "Examples:
  efam figures
  efam figures --set effects.rayleigh_mass.alpha=\"0.8 1/s\" --overwrite
  efam figures --experiment experiment.toml

Exit codes: 3 for recordings, 4 if a release cannot be simulated, 130 if it is
interrupted, which saves nothing.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Figures {
    /// Draw them from the recordings of an experiment, instead of from our own runs.
    #[arg(long, value_name = "FILE")]
    experiment: Option<PathBuf>,
    /// Override a value of the figures' scenario, such as effects.rayleigh_mass.alpha="0.8 1/s", or of the
    /// experiment; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    output: Output,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the figures are.
    folder: &'a Path,
    /// What each shows, in the paper and here.
    figures: &'a [Words],
}

pub fn run(args: &Figures, console: &Console) -> Result<ExitCode, Failure> {
    match &args.experiment {
        Some(experiment) => recorded(args, experiment, console),
        None => simulated(args, console),
    }
}

/// From the recordings of an experiment.
fn recorded(args: &Figures, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let experiment = of_kind(FileKind::Experiment, file, Experiment::load(file, &args.set))?;
    admit_experiment(&experiment)?;
    signals::listen();
    let (out, overwrite) = (args.output.out.as_deref(), args.output.overwrite);
    let name = format!("{} figures", experiment.name);
    let folder = efam_store::folder::open(out, overwrite, &name, experiment.text())?;
    let stages = console.stages();
    let work = || {
        let cleaned = read(&experiment, &stages)?;
        stages.tell("frequency, damping and stiffness of each release");
        of_recordings(&experiment, &cleaned)
    };
    let (folder, done) = interrupt::during(folder, &stages, work);
    let (all, warnings) = done?;
    stages.clear();
    console.warn(&warnings);
    let request = Request { warnings, name, ..request(&experiment, begin) };
    finish(args, console, folder, &request, &all)
}

/// From runs of the paper's muscle.
fn simulated(args: &Figures, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let runs = Runs::new(&args.set)?;
    admit(&runs.cases)?;
    console.warn(&runs.request.warnings);
    let (out, overwrite) = (args.output.out.clone(), args.output.overwrite);
    let request = Request { out, overwrite, argv: argv(), ..runs.request.clone() };
    let folder = efam_report::begin(&request)?;
    signals::listen();
    let samples: usize = runs.cases.iter().map(|case| case.run.samples.len()).sum();
    let progress = console.bar(samples);
    let all = runs.pressures(&|case| follow(case, &progress, &mut |_| Ok(())))?;
    progress.finish_and_clear();
    let request = Request { wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    finish(args, console, folder, &request, &all)
}

fn finish(
    args: &Figures,
    console: &Console,
    folder: Folder,
    request: &Request,
    all: &[Pressure],
) -> Result<ExitCode, Failure> {
    let words = words(all);
    let written = |folder: &Folder| write_figures(folder, request, all, &words);
    let folder = interrupt::finished(folder, &console.stages(), written)?;
    let printed = Printed { folder: &folder, figures: &words };
    answer(&args.output, console, &folder, &printed, || table(&words))?;
    Ok(ExitCode::SUCCESS)
}
