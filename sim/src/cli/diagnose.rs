//! `efam diagnose`: which physical effect the model of an experiment lacks.

use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use models::effects::{CATALOGUE, by_name};
use models::nearest::nearest;
use serde_json::json;
use sim::cleaning::clean;
use sim::diagnose::{Settings, diagnose, plan, problem};
use sim::results::diagnosed::{diagnosis_table, plan_table, write_diagnosis};
use sim::results::{self, Request};
use sim::scenario::Scenario;

use super::Diagnose;
use super::calibrate::input_hashes;
use super::experiment::open;
use super::failure::Failure;
use super::live::{LiveSearch, Rerun, Watcher};
use super::progress;

pub fn run(args: &Diagnose) -> Result<ExitCode, Failure> {
    if args.plan {
        return planned(args);
    }
    let begin = Instant::now();
    if let Some(name) = args.without.iter().find(|name| by_name(name).is_none()) {
        let near = nearest(name, CATALOGUE.iter().map(|effect| effect.about().name));
        let near = near.map_or(String::new(), |near| format!("; did you mean {near}"));
        return Err(Failure::Usage(format!(
            "--without {name}: there is no such effect{near}; efam effects lists all"
        )));
    }
    // What stands in the way is said before a long search.
    let (experiment, folder) = open(&args.of)?;
    let input_hashes = input_hashes(&experiment);
    let progress = progress::line(args.quiet || args.of.json);
    progress.set_message("reading and cleaning the recordings");
    let cleaned = clean(&experiment)?;
    let problem = problem(&experiment, &cleaned)?;
    let settings =
        Settings { false_alarm: args.false_alarm, most_effects: args.most, excluded: args.without.clone() };
    let open = |how| {
        let id = results::sha256(format!("{input_hashes:?}{settings:?}").as_bytes());
        LiveSearch::search(how, &experiment.name, &id, folder.path())
    };
    let live = args.rerun.as_ref().map(open).transpose()?.map(Mutex::new);
    let watcher = Watcher { progress: &progress, live: live.as_ref() };
    let outcome = diagnose(&problem, &settings, &watcher)?;
    progress.finish_and_clear();
    let request = Request {
        name: experiment.name.clone(),
        resolved_scenario: experiment.text().to_owned(),
        warnings: outcome.diagnosis.warnings.clone(),
        input_hashes,
        argv: std::env::args().collect(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    };
    write_diagnosis(&folder, &request, &outcome)?;
    let live = live.map(|live| live.into_inner().unwrap_or_else(PoisonError::into_inner));
    let live = live.map(|mut live| live.found(&outcome).map(|()| live)).transpose()?;
    // A file belongs to the results; a viewer is served when they are there.
    let saves = args.rerun == Some(Rerun::Save);
    let (file, viewer) = if saves { (live, None) } else { (None, live) };
    file.map_or(Ok(()), |file| file.finish(false))?;
    let folder = folder.finish()?;
    let mut out = io::stdout().lock();
    if args.of.json {
        writeln!(out, "{}", json!({ "folder": folder, "diagnosis": outcome.diagnosis }))?;
    } else if !args.quiet {
        write!(out, "{}", diagnosis_table(&outcome.diagnosis))?;
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    drop(out);
    viewer.map_or(Ok(()), |viewer| viewer.finish(args.rerun == Some(Rerun::Serve)))?;
    Ok(ExitCode::SUCCESS)
}

/// What releases that are not recorded yet could show.
fn planned(args: &Diagnose) -> Result<ExitCode, Failure> {
    let mut cases = Vec::new();
    for path in std::iter::once(&args.of.experiment).chain(&args.also) {
        let overrides = if path == &args.of.experiment { &args.of.set[..] } else { &[] };
        cases.extend(Scenario::load(path, overrides)?.cases()?);
    }
    for warning in cases.iter().flat_map(|case| &case.warnings) {
        eprintln!("warning: {warning}");
    }
    let problem = plan::problem(&cases, args.noise, &args.marker);
    let progress = progress::line(args.quiet || args.of.json);
    let prospects = plan::plan(&problem, &|what| progress.set_message(what.to_owned()))?;
    let prospects = plan::best_seen(prospects);
    progress.finish_and_clear();
    let mut out = io::stdout().lock();
    if args.of.json {
        writeln!(out, "{}", json!({ "releases": cases.len(), "prospects": prospects }))?;
    } else if !args.quiet {
        write!(out, "{}", plan_table(&prospects, cases.len()))?;
    }
    Ok(ExitCode::SUCCESS)
}
