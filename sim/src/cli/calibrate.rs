//! `efam calibrate`: parameters of a model from the releases of an experiment.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;

use serde_json::json;
use sim::calibrate::{Settings, calibrate, problem};
use sim::cleaning::clean;
use sim::experiment::Experiment;
use sim::results::calibrated::{MUSCLE, muscle_file, table, write_calibration};
use sim::results::{self, Request};

use super::Calibrate;
use super::failure::Failure;
use super::progress;

pub fn run(args: &Calibrate) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let experiment = Experiment::load(&args.experiment, &args.set)?;
    let text = std::fs::read_to_string(&args.experiment)?;
    let mut input_hashes = BTreeMap::new();
    input_hashes.insert(args.experiment.display().to_string(), results::sha256(text.as_bytes()));
    for entry in &experiment.recordings {
        if let Ok(bytes) = std::fs::read(&entry.file) {
            input_hashes.insert(entry.file.display().to_string(), results::sha256(&bytes));
        }
    }
    let mut request = Request {
        name: experiment.name.clone(),
        out: args.out.clone(),
        overwrite: args.overwrite,
        resolved_scenario: text,
        input_hashes,
        argv: std::env::args().collect(),
        ..Request::default()
    };
    // What stands in the way is said before a long search.
    let folder = results::begin(&request)?;
    let progress = progress::line(args.quiet || args.json);
    progress.set_message("reading and cleaning the recordings");
    let cleaned = clean(&experiment)?;
    let (problem, settings) = problem(&experiment, &cleaned)?;
    let settings = Settings { profile: args.profile, ..settings };
    let outcome = calibrate(&problem, &settings, &|stage| progress.set_message(stage.to_owned()))?;
    progress.finish_and_clear();

    let calibration = &outcome.calibration;
    let source = format!(
        "calibrated by efam {} from {} releases of {}",
        env!("CARGO_PKG_VERSION"),
        calibration.releases.iter().filter(|release| !release.held_out).count(),
        experiment.path.display()
    );
    let muscle = experiment.muscle().map(|muscle| muscle_file(muscle, calibration, &source)).transpose();
    let muscle = muscle.map_err(|error| Failure::Usage(error.to_string()))?.flatten();
    request.warnings = calibration.warnings.clone();
    request.wall_time_s = begin.elapsed().as_secs_f64();
    write_calibration(&folder, &request, &outcome, muscle.as_deref())?;
    let folder = folder.finish()?;

    let mut out = io::stdout().lock();
    if args.json {
        writeln!(out, "{}", json!({ "folder": folder, "calibration": calibration }))?;
    } else if !args.quiet {
        write!(out, "{}", table(calibration))?;
        writeln!(out, "\nresults in {}", folder.display())?;
        if muscle.is_some() {
            writeln!(out, "simulate with them by --muscle {}", folder.join(MUSCLE).display())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
