//! `efam figures`: the paper's Figures 4 to 9 from our own runs, or from the recordings of an experiment.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_core::trajectory::Status;
use efam_experiments::analyse::{Analysed, analyse};
use efam_experiments::analysis::static_stiffness::NODES;
use efam_experiments::experiment::Experiment;
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::{Case, Scenario};
use efam_report::Request;
use efam_report::figures::{Words, words, write_figures};
use efam_report::paper::{
    FiguresError, MUSCLE, Pressure, SCENARIO, admit as admit_experiment, of_experiment,
};
use efam_store::Folder;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Output, argv};
use super::browser;
use super::console::{Console, print};
use super::experiment::{read, request};
use super::failure::{Failure, of_kind};
use super::simulate::{admit, follow};
use super::terminal::stdout;
use super::{interrupt, signals};

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
    admit_experiment(&experiment).map_err(refused)?;
    signals::listen();
    let (out, overwrite) = (args.output.out.as_deref(), args.output.overwrite);
    let name = format!("{} figures", experiment.name);
    let folder = efam_store::folder::open(out, overwrite, &name, experiment.text())?;
    let stages = console.stages();
    let work = || {
        let cleaned = read(&experiment, &stages)?;
        stages.tell("frequency, damping and stiffness of each release");
        let analysed = analyse(&experiment, &cleaned, &NODES)?;
        let all = of_experiment(&experiment, &analysed).map_err(refused)?;
        let shown = |one: &&Analysed| all.iter().any(|of| of.name == one.of.release.name);
        let of_releases = analysed.iter().filter(shown).flat_map(Analysed::warnings);
        let warnings: Vec<String> = cleaned.warnings().into_iter().chain(of_releases).collect();
        Ok::<_, Failure>((all, warnings))
    };
    let (folder, done) = interrupt::during(folder, &stages, work);
    let (all, warnings) = done?;
    stages.clear();
    console.warn(&warnings);
    let request = Request { warnings, name, ..request(&experiment, begin) };
    finish(args, console, folder, &request, &all)
}

fn refused(error: FiguresError) -> Failure {
    match error {
        FiguresError::Experiment(error) => error.into(),
        FiguresError::Incomplete { .. } => Failure::Usage(error.to_string()),
    }
}

/// From runs of the paper's muscle.
fn simulated(args: &Figures, console: &Console) -> Result<ExitCode, Failure> {
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
    console.warn(&warnings);
    let hash = |text: &str| efam_store::sha::sha256(text.as_bytes());
    let set: Vec<String> = args.set.iter().map(|set| format!("--set {set}")).collect();
    let mut input_hashes = BTreeMap::from([(efam_report::figures::SCENARIO.to_owned(), hash(SCENARIO))]);
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
    let folder = efam_report::begin(&request)?;
    signals::listen();
    let samples: usize = cases.iter().map(|case| case.run.samples.len()).sum();
    let progress = console.bar(samples);
    let one = |case: &Case| {
        let trajectory = follow(case, &progress, &mut |_| Ok(()))?;
        match &trajectory.status {
            Status::Failed { reason, .. } => {
                return Err(Failure::Diverged(format!("{}: {reason}", case.name)));
            }
            Status::CutShort { .. } => return Ok(None),
            Status::Complete => {}
        }
        let of = Pressure::simulated(case, trajectory).map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Some(of))
    };
    // The first failure in the order of the cases, not in time.
    let done = cases.par_iter().map(one).collect::<Vec<_>>();
    let done = done.into_iter().collect::<Result<Option<Vec<Pressure>>, Failure>>()?;
    progress.finish_and_clear();
    let Some(all) = done else {
        return Err(Failure::Interrupted);
    };
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
    if args.output.form.json {
        print(&Printed { folder: &folder, figures: &words })?;
    } else if !console.quiet {
        let mut out = stdout();
        for of in &words {
            writeln!(out, "Figure {}\n  paper: {}\n  ours:  {}", of.number, of.paper, of.ours)?;
        }
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    browser::show(args.output.open, &folder, console);
    Ok(ExitCode::SUCCESS)
}
