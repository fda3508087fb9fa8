//! `efam predict --check`: predictions beside the recordings of an experiment.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use crate::experiment::Experiment;
use crate::predict::Settings;
use crate::predict::check::{Check, check, fitted_files};
use crate::results::checked::{check_table, write_check};
use crate::results::{self, Request};
use crate::schema::JsonSchema;
use serde::Serialize;

use super::super::arguments::argv;
use super::super::calibrate::input_hashes;
use super::super::experiment::read;
use super::super::interrupt;
use super::super::terminal::stdout;
use super::super::voice::{Voice, print};
use super::{Predict, asked};
use crate::failure::Failure;

/// What is printed for programs.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// What was compared.
    check: &'a Check,
}

/// Predicts the releases of an experiment by the rod that is asked about, or else by its own.
pub fn run(args: &Predict, file: &Path, voice: &Voice) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let own = Experiment::load(file, &args.set)?;
    let has_rod = args.scenario.is_some() || args.muscle.is_some();
    let (experiment, known, rod) = match has_rod {
        true => {
            let (asked, hashes) = asked(args)?;
            let (experiment, known) = asked.in_experiment(&own)?;
            (experiment, known, hashes)
        }
        false => (own.clone(), own.known().cloned(), Default::default()),
    };
    let rod_file = args.scenario.as_deref().or(args.muscle.as_deref().map(Path::new));
    let fitted = rod_file.map(fitted_files).unwrap_or_default();
    let request = Request {
        name: format!("{} predicted", own.name),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        resolved_scenario: experiment.text().to_owned(),
        input_hashes: input_hashes(&own).into_iter().chain(rod).collect(),
        argv: argv(),
        ..Request::default()
    };
    interrupt::listen();
    let folder = results::begin(&request)?;
    let stages = voice.stages();
    let settings = Settings { draws: args.draws, seed: args.seed };
    let work = || {
        let cleaned = read(&experiment, &stages)?;
        stages.tell(&format!("predicting {} releases", cleaned.used().count()));
        Ok(check(&experiment, &cleaned, known.as_ref(), &fitted, &settings)?)
    };
    let (folder, check): (_, Result<Check, Failure>) = interrupt::during(folder, &stages, work);
    let check = check?;
    let done =
        Request { warnings: check.warnings.clone(), wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    write_check(&folder, &done, &check)?;
    interrupt::check()?;
    let folder = folder.finish()?;
    stages.clear();
    if args.output.form.json {
        print(&super::Printed::Check(Printed { folder: &folder, check: &check }))?;
    } else if !voice.quiet {
        writeln!(stdout(), "{}\nresults in {}", check_table(&check), folder.display())?;
    }
    Ok(ExitCode::SUCCESS)
}
