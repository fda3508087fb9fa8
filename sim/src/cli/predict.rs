//! `efam predict`: what a calibrated muscle will do with a payload.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use models::muscle::BUILT_IN;
use models::quantity::{Quantity, format_si};
use serde_json::json;
use sim::predict::asked::Asked;
use sim::predict::family::{Member, family};
use sim::predict::grid::{grid, runs};
use sim::predict::span::values;
use sim::predict::{Settings, predict};
use sim::results::grid::{grid_table, write_grid};
use sim::results::predicted::{prediction_table, write_prediction};
use sim::results::{self, Request};
use sim::scenario::Case;

use super::Predict;
use super::failure::Failure;
use super::live::{LiveFamily, Rerun};
use super::progress;

pub fn run(args: &Predict) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let (asked, input_hashes) = asked(args)?;
    let pressures = several("--pressure", &args.pressure, "Pa")?;
    let payloads = several("--payload", &args.payload, "kg")?;
    if payloads.iter().any(|payload| *payload < 0.0) {
        let payload = args.payload.as_deref().unwrap_or_default();
        return Err(Failure::Usage(format!("--payload {payload}: it must not be negative")));
    }
    if !pressures.is_empty() && !asked.has_muscle() {
        return Err(Failure::Usage(
            "--pressure: the scenario's rod is no muscle, and is the same at every pressure; leave it out"
                .to_owned(),
        ));
    }
    // What the scenario refuses is said before a folder is opened.
    let (case, known) = asked.case(pressures.first().copied(), payloads.first().copied())?;
    let is_grid = pressures.len() > 1 || payloads.len() > 1;
    let name = title(args, &case.name);
    let case = Case { name: name.clone(), ..case };
    let request = Request {
        name: name.replace([',', ':', '/'], " "),
        out: args.out.clone(),
        overwrite: args.overwrite,
        resolved_scenario: case.resolved.clone(),
        input_hashes,
        argv: std::env::args().collect(),
        ..Request::default()
    };
    // What stands in the way is said before the simulations.
    let folder = results::begin(&request)?;
    let is_silent = args.quiet || args.json;
    let done = |warnings: &[String]| Request {
        warnings: warnings.to_vec(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..request.clone()
    };
    let (told, table, members) = if is_grid {
        let payloads = if payloads.is_empty() { vec![0.0] } else { payloads };
        let make = |pressure, payload| Ok(asked.case(pressure, Some(payload))?.0);
        let cases = pressures.len().max(1) * payloads.len();
        let progress = progress::steps(is_silent, cases, &format!("cases of {} runs", runs(known.as_ref())));
        let grid = grid(&name, (&pressures, &payloads), &make, known.as_ref(), &|| progress.inc(1))?;
        progress.finish_and_clear();
        write_grid(&folder, &done(&grid.warnings), &grid)?;
        let cases = grid.cells.iter().map(|cell| {
            let case = asked.case(cell.pressure_pa, Some(cell.payload_kg))?.0;
            let name = cell_name(cell.pressure_pa, cell.payload_kg);
            Ok::<_, Failure>(Member { name, ..Member::case(&case) })
        });
        let members = if args.rerun.is_some() { cases.collect::<Result<Vec<_>, _>>()? } else { Vec::new() };
        (json!({ "grid": grid }), grid_table(&grid), members)
    } else {
        let settings = Settings { draws: args.draws, seed: args.seed };
        let draws = known.as_ref().map_or(0, |_| args.draws);
        let progress = progress::steps(is_silent, draws, "draws");
        let outcome = predict(&case, known.as_ref(), &settings, &|| progress.inc(1));
        let outcome = outcome.map_err(|error| Failure::Diverged(error.to_string()))?;
        progress.finish_and_clear();
        write_prediction(&folder, &done(&outcome.prediction.warnings), &outcome)?;
        let members =
            if args.rerun.is_some() { family(&case, known.as_ref(), &settings) } else { Vec::new() };
        (json!({ "prediction": outcome.prediction }), prediction_table(&outcome.prediction), members)
    };
    let open = |how| {
        let id = results::sha256(format!("{name}{}", case.resolved).as_bytes());
        LiveFamily::family(how, &name, &id, folder.path(), &members)
    };
    let live = args.rerun.as_ref().map(open).transpose()?;
    // A file belongs to the results; a viewer is served when they are there.
    let saves = args.rerun == Some(Rerun::Save);
    let (file, viewer) = if saves { (live, None) } else { (None, live) };
    file.map_or(Ok(()), |file| file.finish(false))?;
    let folder = folder.finish()?;
    let mut out = io::stdout().lock();
    if args.json {
        let mut told = told;
        told["folder"] = json!(folder);
        writeln!(out, "{told}")?;
    } else if !args.quiet {
        write!(out, "{table}")?;
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    drop(out);
    viewer.map_or(Ok(()), |viewer| viewer.finish(args.rerun == Some(Rerun::Serve)))?;
    Ok(ExitCode::SUCCESS)
}

/// A case of several, by what distinguishes it.
fn cell_name(pressure: Option<f64>, payload: f64) -> String {
    let payload = format_si(payload, "kg");
    pressure.map_or(payload.clone(), |pressure| format!("{}, {payload}", format_si(pressure, "Pa")))
}

/// What is asked, in words: `40psi with 80g`.
fn title(args: &Predict, case: &str) -> String {
    let payload = args.payload.as_ref().map_or(String::new(), |payload| format!(" with {payload}"));
    match (&args.scenario, &args.pressure) {
        (None, Some(pressure)) => format!("{pressure}{payload}"),
        (_, Some(pressure)) => format!("{case} at {pressure}{payload}"),
        (_, None) => format!("{case}{payload}"),
    }
}

/// The rod that is asked about, and the hash of its file.
fn asked(args: &Predict) -> Result<(Asked, BTreeMap<String, String>), Failure> {
    let mut hashes = BTreeMap::new();
    let mut read = |file: &Path, what: &str| {
        let bytes = std::fs::read(file).map_err(|error| {
            Failure::Data(format!("{}: cannot be read ({error}); give {what}", file.display()))
        })?;
        hashes.insert(file.display().to_string(), results::sha256(&bytes));
        Ok::<_, Failure>(bytes)
    };
    let mut asked = match (&args.scenario, &args.muscle) {
        (Some(scenario), _) => {
            let bytes = read(scenario, "a scenario, such as the rod.toml of a calibration")?;
            let text = String::from_utf8(bytes);
            Asked::scenario(
                scenario,
                text.map_err(|_| Failure::Data(format!("{}: is no text", scenario.display())))?,
            )
        }
        (None, muscle) => {
            let muscle = muscle.as_deref().unwrap_or_default();
            if !BUILT_IN.iter().any(|(name, _)| *name == muscle) {
                let known = BUILT_IN.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
                read(
                    Path::new(muscle),
                    &format!("the muscle.toml of a calibration, or a built-in muscle: {known}"),
                )?;
            }
            Asked::muscle(muscle)
        }
    };
    asked.payload_center = one("--payload-center", &args.payload_center, "m")?;
    asked.payload_inertia = one("--payload-inertia", &args.payload_inertia, "kg m^2")?;
    asked.frontal_area = one("--frontal-area", &args.frontal_area, "m^2")?;
    asked.angle = one("--angle", &args.angle, "rad")?;
    asked.duration = one("--duration", &args.duration, "s")?;
    asked.set.clone_from(&args.set);
    Ok((asked, hashes))
}

/// The quantity of an option.
fn one(option: &str, value: &Option<String>, unit: &str) -> Result<Option<f64>, Failure> {
    let Some(text) = value else { return Ok(None) };
    let parsed = Quantity::parse(text).and_then(|quantity| quantity.to(unit));
    parsed.map(Some).map_err(|error| Failure::Usage(format!("{option} {text}: {error}")))
}

/// The quantities of an option that may have several.
fn several(option: &str, value: &Option<String>, unit: &str) -> Result<Vec<f64>, Failure> {
    let Some(text) = value else { return Ok(Vec::new()) };
    values(text, unit).map_err(|error| Failure::Usage(format!("{option} {text}: {error}")))
}
