//! `efam predict`: what a calibrated muscle will do with a payload.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use models::muscle::BUILT_IN;
use models::quantity::Quantity;
use serde::Serialize;
use serde_json::Value;
use sim::predict::{Prediction, Settings, predict};
use sim::results::predicted::{prediction_table, write_prediction};
use sim::results::{self, Request};
use sim::scenario::Scenario;
use sim::schema::JsonSchema;

use super::Predict;
use super::failure::Failure;
use super::interrupt;
use super::voice::{Voice, print};

pub const HELP: &str = "Examples:
  efam predict --muscle outputs/beam/muscle.toml --pressure 40psi --payload 80g
  efam predict --muscle garbulinski-2022 --pressure 15psi --angle \"25 deg\"
  efam predict --muscle muscle.toml --pressure 40psi --draws 400 --json

Exit codes: 3 for a muscle file that cannot be used, 4 if the case cannot be
simulated, 130 if it is interrupted, which saves nothing.";

/// What is printed for programs.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// What is foretold.
    prediction: &'a Prediction,
}

pub fn run(args: &Predict, voice: &Voice) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let (text, input_hashes) = scenario(args)?;
    let scenario = Scenario::parse(Path::new("efam-predict.toml"), &text, &args.set)?;
    let cases = scenario.cases()?;
    let [case] = &cases[..] else {
        return Err(Failure::Usage("--pressure: one pressure, such as 40psi".to_owned()));
    };
    let request = Request {
        name: case.name.clone(),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        resolved_scenario: case.resolved.clone(),
        input_hashes,
        argv: std::env::args().collect(),
        ..Request::default()
    };
    // What stands in the way is said before the simulations.
    interrupt::listen();
    let folder = results::begin(&request)?;
    let settings = Settings { draws: args.draws, seed: args.seed };
    let stages = voice.stages();
    let threads = rayon::current_num_threads();
    stages.tell(&format!("simulating what the calibration admits, on {threads} threads"));
    let done = AtomicUsize::new(0);
    let tell = || {
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        if done.is_multiple_of(args.draws.div_ceil(10)) {
            stages.tell(&format!("{done} of {} draws", args.draws));
        }
    };
    let work = || predict(case, scenario.known(), &settings, &tell);
    let (folder, outcome) = interrupt::during(folder, &stages, work);
    let outcome = outcome.map_err(|error| Failure::Diverged(error.to_string()))?;
    stages.tell("writing");
    let warnings = outcome.prediction.warnings.clone();
    let request = Request { warnings, wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    write_prediction(&folder, &request, &outcome)?;
    interrupt::check()?;
    let folder = folder.finish()?;
    stages.clear();
    voice.detail(format!("written to {}", folder.display()));
    if args.output.form.json {
        print(&Printed { folder: &folder, prediction: &outcome.prediction })?;
    } else if !voice.quiet {
        let mut out = io::stdout().lock();
        write!(out, "{}", prediction_table(&outcome.prediction))?;
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What is asked as a scenario, and the hash of the muscle's file.
fn scenario(args: &Predict) -> Result<(String, BTreeMap<String, String>), Failure> {
    let quoted = |text: &str| Value::from(text).to_string();
    let mut hashes = BTreeMap::new();
    let muscle = if BUILT_IN.iter().any(|(name, _)| *name == args.muscle) {
        format!("name = {}", quoted(&args.muscle))
    } else {
        let file = PathBuf::from(&args.muscle);
        let unreadable = |error: io::Error| {
            let known = BUILT_IN.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            Failure::Data(format!(
                "{}: cannot be read ({error}); give the muscle.toml of a calibration, or a built-in muscle: {known}",
                file.display()
            ))
        };
        let bytes = std::fs::read(&file).map_err(unreadable)?;
        let file = file.canonicalize().map_err(unreadable)?;
        hashes.insert(file.display().to_string(), results::sha256(&bytes));
        format!("file = {}", quoted(&file.display().to_string()))
    };
    let named = |option: &str, value: &str, unit: &str| {
        let parsed = Quantity::parse(value).and_then(|quantity| quantity.to(unit));
        parsed.map_err(|error| Failure::Usage(format!("{option} {value}: {error}")))
    };
    let pressure = named("--pressure", &args.pressure, "Pa")?;
    let payload = named("--payload", &args.payload, "kg")?;
    if payload.is_nan() || payload < 0.0 {
        return Err(Failure::Usage(format!("--payload {}: it must not be negative", args.payload)));
    }
    let mut text = format!(
        "name = {}\n[muscle]\n{muscle}\npressure = \"{pressure:?} Pa\"\nextrapolation = \"allowed\"\n[release]\nangle = {}\n[run]\nduration = {}\n[effects.payload]\nmass = \"{payload:?} kg\"\n",
        quoted(&format!("{} with {}", args.pressure, args.payload)),
        quoted(&args.angle),
        quoted(&args.duration),
    );
    for (key, value) in [("center_of_mass", &args.payload_center), ("rotary_inertia", &args.payload_inertia)]
    {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {}", quoted(value));
        }
    }
    if let Some(area) = &args.frontal_area {
        let area = named("--frontal-area", area, "m^2")?;
        let _ = writeln!(text, "[effects.tip_drag]\ndrag_area = \"{:?} m^2\"", DRAG_COEFFICIENT * area);
    }
    Ok((text, hashes))
}

/// Of a blunt body. Source: Hoerner (1965), Fluid-Dynamic Drag, chapter 3: a cube, face on, 1.05.
const DRAG_COEFFICIENT: f64 = 1.05;
