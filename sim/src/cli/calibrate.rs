//! `efam calibrate`: parameters of a model from the releases of an experiment.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Instant;

use clap::Args;
use efam_inference::calibrate::{
    Calibration, CalibrationOutcome, CalibrationSettings, Problem, calibrate, problem,
};
use efam_report::Request;
use efam_report::calibrated::{models, table, write_calibration};
use efam_store::escape::shell_word;
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::answer;
use super::arguments::OfExperiment;
use super::console::Console;
use super::experiment::{open, read, request};
use super::failure::Failure;
use super::interrupt;
use super::live::{LiveFit, Recording, Rerun, Watcher, unlocked};
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam calibrate beam.toml
  efam calibrate beam.toml --profile --out outputs/beam --overwrite
  efam calibrate beam.toml --set calibrate.mesh=\"kept\" --json

Exit codes: 3 for data that cannot be used, 4 if no fit is found, 130 if it is
interrupted, which saves nothing.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Calibrate {
    #[command(flatten)]
    of: OfExperiment,
    /// Also find intervals by the profile of the likelihood, which takes longer.
    #[arg(long)]
    profile: bool,
    /// Show progress and fitted releases in Rerun: save, spawn, connect, connect=URL or serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse)]
    rerun: Option<Rerun>,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// What was found.
    calibration: &'a Calibration,
}

pub fn run(args: &Calibrate, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    // Obstacles are reported before a long search.
    let (experiment, folder) = open(&args.of, console)?;
    // With the hashes of what is read now.
    let request = request(&experiment, begin);
    let stages = console.stages();
    let open = |how| {
        let id = efam_store::sha::sha256(format!("{:?}{}", request.input_hashes, args.profile).as_bytes());
        LiveFit::fit(how, &experiment.name, &id, folder.path())
    };
    let live = args.rerun.as_ref().map(open).transpose()?.map(Mutex::new);
    let work = || -> Result<(Problem, CalibrationSettings, CalibrationOutcome), Failure> {
        let cleaned = read(&experiment, &stages)?;
        let (problem, settings) = problem(&experiment, &cleaned)?;
        let settings = CalibrationSettings { profile: args.profile, ..settings };
        let outcome =
            calibrate(&problem, &settings, &Watcher { stages: &stages, live: live.as_ref(), ending: None })?;
        Ok((problem, settings, outcome))
    };
    let (folder, done) = interrupt::during(folder, &stages, work);
    let (problem, settings, outcome) = done?;
    stages.tell("writing");

    let calibration = &outcome.calibration;
    let models = models(&experiment, &problem, &settings, calibration)
        .map_err(|error| Failure::Usage(error.to_string()))?;
    let wall_time_s = begin.elapsed().as_secs_f64();
    let request = Request { warnings: calibration.warnings.clone(), wall_time_s, ..request };
    let written = || write_calibration(&folder, &request, &problem, &outcome, &models);
    interrupt::writing(&folder, &stages, written)?;
    let live = unlocked(live).map(|mut live| live.found(&problem, &outcome).map(|()| live)).transpose()?;
    let viewer = Recording::saved(live, args.rerun.as_ref())?;
    interrupt::check()?;
    let folder = folder.finish()?;
    stages.clear();
    console.detail(format!("written to {}", folder.display()));
    let output = &args.of.output;
    answer(output, console, &folder, &Printed { folder: &folder, calibration }, || table(calibration))?;
    if !output.form.json && !console.quiet {
        let mut out = stdout();
        for model in &models {
            let option = if experiment.muscle().is_some() { "--muscle " } else { "" };
            writeln!(
                out,
                "predict with them: efam predict {option}{}",
                shell_word(&folder.join(&model.name))
            )?;
        }
    }
    Recording::shown(viewer, args.rerun.as_ref())?;
    Ok(ExitCode::SUCCESS)
}
