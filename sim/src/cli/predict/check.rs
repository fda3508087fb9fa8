//! `efam predict --check`: predictions beside the recordings of an experiment.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use efam_experiments::experiment::Experiment;
use efam_experiments::kind::FileKind;
use efam_inference::predict::PredictionSettings;
use efam_inference::predict::check::{Check, check, fitted_files};
use efam_report::Request;
use efam_report::checked::{check_table, write_check};
use efam_report::experiment::input_hashes;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::answer::answer;
use super::super::arguments::argv;
use super::super::console::Console;
use super::super::experiment::read;
use super::super::failure::{Failure, of_kind};
use super::super::{interrupt, signals};
use super::{Predict, case_request};

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// What was compared.
    check: &'a Check,
}

/// Predicts the releases of an experiment by the requested rod, or else by its own.
pub fn run(args: &Predict, file: &Path, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let own = of_kind(FileKind::Experiment, file, Experiment::load(file, &args.set))?;
    let mut input_hashes = input_hashes(&own);
    let (experiment, known, left_out) = match args.rod() {
        None => (own.clone(), own.known().cloned(), Vec::new()),
        Some(rod) => {
            let (cases, hashes) = case_request(args, rod)?;
            input_hashes.extend(hashes);
            cases.in_experiment(&own)?
        }
    };
    let rod = args.scenario.as_deref().or(args.muscle.as_deref().map(Path::new));
    let fitted = rod.map(fitted_files).unwrap_or_default();
    let request = Request {
        name: format!("{} predicted", own.name),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        resolved_scenario: experiment.text().to_owned(),
        input_hashes,
        argv: argv(),
        ..Request::default()
    };
    signals::listen();
    let folder = efam_report::begin(&request)?;
    let stages = console.stages();
    let settings = PredictionSettings { draws: args.draws, seed: args.seed };
    let work = || {
        let cleaned = read(&experiment, &stages)?;
        stages.tell(&format!("predicting {} releases", cleaned.used().count()));
        Ok(check(&experiment, &cleaned, known.as_ref(), &fitted, &settings)?)
    };
    let (folder, check): (_, Result<Check, Failure>) = interrupt::during(folder, &stages, work);
    let mut check = check?;
    check.warnings.splice(..0, left_out);
    let done =
        Request { warnings: check.warnings.clone(), wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    let folder = interrupt::finished(folder, &stages, |folder| write_check(folder, &done, &check))?;
    stages.clear();
    let printed = super::Printed::Check(Printed { folder: &folder, check: &check });
    answer(&args.output, console, &folder, &printed, || check_table(&check))?;
    Ok(ExitCode::SUCCESS)
}
