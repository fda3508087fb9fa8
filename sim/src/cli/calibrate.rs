//! `efam calibrate`: parameters of a model from the releases of an experiment.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use serde_json::json;
use sim::calibrate::{Settings, calibrate, problem};
use sim::cleaning::clean;
use sim::experiment::{Entry, Experiment};
use sim::results::calibrated::{MUSCLE, muscle_file, table, write_calibration};
use sim::results::{self, Request};

use super::Calibrate;
use super::experiment::open;
use super::failure::Failure;
use super::progress;

pub fn run(args: &Calibrate) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    // What stands in the way is said before a long search.
    let (experiment, folder) = open(&args.of)?;
    let input_hashes = input_hashes(&experiment);
    let progress = progress::line(args.quiet || args.of.json);
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
    let request = Request {
        name: experiment.name.clone(),
        resolved_scenario: experiment.text().to_owned(),
        warnings: calibration.warnings.clone(),
        input_hashes,
        argv: std::env::args().collect(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    };
    write_calibration(&folder, &request, &problem, &outcome, muscle.as_deref())?;
    let folder = folder.finish()?;

    let mut out = io::stdout().lock();
    if args.of.json {
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

/// SHA-256 of the experiment and of its recordings, by file.
pub fn input_hashes(experiment: &Experiment) -> BTreeMap<String, String> {
    let hash = |file: &Path, bytes: &[u8]| (file.display().to_string(), results::sha256(bytes));
    let own = hash(&experiment.path, experiment.text().as_bytes());
    let read = |entry: &Entry| Some(hash(&entry.file, &std::fs::read(&entry.file).ok()?));
    experiment.recordings.iter().filter_map(read).chain([own]).collect()
}
