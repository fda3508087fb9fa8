//! `efam calibrate`: parameters of a model from the releases of an experiment.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde_json::json;
use sim::calibrate::{Settings, calibrate, problem};
use sim::cleaning::clean;
use sim::experiment::{Entry, Experiment};
use sim::results::calibrated::{muscle_file, rod_files, table, write_calibration};
use sim::results::{self, Request};

use super::Calibrate;
use super::experiment::open;
use super::failure::Failure;
use super::live::{LiveFit, Rerun, Watcher};
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
    let open = |how| {
        let id = results::sha256(format!("{input_hashes:?}{settings:?}").as_bytes());
        LiveFit::fit(how, &experiment.name, &id, folder.path())
    };
    let live = args.rerun.as_ref().map(open).transpose()?.map(Mutex::new);
    let watcher = Watcher { progress: &progress, live: live.as_ref() };
    let outcome = calibrate(&problem, &settings, &watcher)?;
    progress.finish_and_clear();

    let calibration = &outcome.calibration;
    let source = format!(
        "calibrated by efam {} from {} releases of {}",
        env!("CARGO_PKG_VERSION"),
        calibration.releases.iter().filter(|release| !release.held_out).count(),
        experiment.path.display()
    );
    let kept = problem.trials.first().filter(|_| !settings.remove_mesh);
    let nodes = kept.map(|trial| trial.model.edges + 1);
    let models = match experiment.muscle() {
        Some(muscle) => muscle_file(muscle, calibration, nodes, &source)
            .map_err(|error| Failure::Usage(error.to_string()))?
            .into_iter()
            .collect(),
        None => rod_files(&problem, calibration, nodes, &source),
    };
    let request = Request {
        name: experiment.name.clone(),
        resolved_scenario: experiment.text().to_owned(),
        warnings: calibration.warnings.clone(),
        input_hashes,
        argv: std::env::args().collect(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    };
    write_calibration(&folder, &request, &outcome, &models)?;
    let live = live.map(|live| live.into_inner().unwrap_or_else(PoisonError::into_inner));
    let live = live.map(|mut live| live.found(&problem, &outcome).map(|()| live)).transpose()?;
    // A file belongs to the results; a viewer is served when they are there.
    let saves = args.rerun == Some(Rerun::Save);
    let (file, viewer) = if saves { (live, None) } else { (None, live) };
    file.map_or(Ok(()), |file| file.finish(false))?;
    let folder = folder.finish()?;

    let mut out = io::stdout().lock();
    if args.of.json {
        writeln!(out, "{}", json!({ "folder": folder, "calibration": calibration }))?;
    } else if !args.quiet {
        write!(out, "{}", table(calibration))?;
        writeln!(out, "\nresults in {}", folder.display())?;
        for model in &models {
            let option = if experiment.muscle().is_some() { "--muscle " } else { "" };
            writeln!(out, "predict with them: efam predict {option}{}", folder.join(&model.name).display())?;
        }
    }
    drop(out);
    viewer.map_or(Ok(()), |viewer| viewer.finish(args.rerun == Some(Rerun::Serve)))?;
    Ok(ExitCode::SUCCESS)
}

/// SHA-256 of the experiment and of its recordings, by file.
pub fn input_hashes(experiment: &Experiment) -> BTreeMap<String, String> {
    let hash = |file: &Path, bytes: &[u8]| (file.display().to_string(), results::sha256(bytes));
    let own = hash(&experiment.path, experiment.text().as_bytes());
    let read = |entry: &Entry| Some(hash(&entry.file, &std::fs::read(&entry.file).ok()?));
    experiment.recordings.iter().filter_map(read).chain([own]).collect()
}
