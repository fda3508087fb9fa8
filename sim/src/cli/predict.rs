//! `efam predict`: what a calibrated muscle will do with a payload.

mod check;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_experiments::kind::FileKind;
use efam_inference::predict::ensemble::{Member, ensemble};
use efam_inference::predict::grid::{Cell, Grid, grid, runs};
use efam_inference::predict::request::CaseRequest;
use efam_inference::predict::span::values;
use efam_inference::predict::{Prediction, PredictionSettings, predict};
use efam_report::Request;
use efam_report::grid::{grid_table, write_grid};
use efam_report::predicted::{prediction_table, write_prediction};
use efam_store::Folder;
use efam_store::input;
use models::muscle::BUILT_IN;
use models::quantity::format_si;
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::answer;
use super::arguments::{Output, ReleaseArguments, argv, once};
use super::console::Console;
use super::failure::{Failure, of_kind};
use super::live::{LiveEnsemble, Recording, Rerun};
use super::{interrupt, signals};

const HELP: &str = "Examples:
  efam predict --muscle outputs/beam/muscle.toml --pressure 40psi --payload 80g
  efam predict --muscle garbulinski-2022 --pressure 15psi --angle \"25 deg\"
  efam predict --muscle muscle.toml --pressure 10psi..100psi:19 --payload 0g,50g
  efam predict outputs/beam/rod.toml --payload 20g --draws 400 --json
  efam predict outputs/beam/rod.toml --check loaded.toml

Exit codes: 3 for a muscle file that cannot be used, 4 if the case cannot be
simulated, 130 if it is interrupted, which saves nothing.";

/// Options of a case, and of showing it. With --check the experiment says what was released.
const CASE: [&str; 8] = [
    "pressure",
    "payload",
    "payload_center",
    "payload_inertia",
    "frontal_area",
    "angle",
    "duration",
    "rerun",
];

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Predict {
    /// Scenario with the rod, such as the rod.toml of a calibration; or a muscle, as with --muscle.
    #[arg(value_name = "SCENARIO")]
    scenario: Option<PathBuf>,
    /// Muscle file that a calibration wrote, or the name of a built-in muscle.
    #[arg(long, value_name = "FILE", conflicts_with = "scenario")]
    muscle: Option<String>,
    /// Pressure above ambient, such as 40psi; several, as 10psi,40psi; or from one to another, as
    /// 10psi..100psi or, in 19 values, 10psi..100psi:19.
    #[arg(long)]
    pressure: Option<String>,
    /// Mass at the tip; several, or from one to another, as 0g..200g.
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    payload: Option<String>,
    #[command(flatten)]
    release: ReleaseArguments,
    /// Override a value of the scenario, such as effects.air_drag.drag_coefficient=1.1; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Predict the releases of an experiment instead, and count how often intervals hold what was measured; without
    /// SCENARIO and --muscle, by the experiment's own rod.
    #[arg(long, value_name = "EXPERIMENT", conflicts_with_all = CASE)]
    check: Option<PathBuf>,
    /// Number of draws from the errors of the calibration, for one case.
    #[arg(long, value_name = "COUNT", default_value_t = efam_inference::predict::PredictionSettings::default().draws)]
    draws: usize,
    /// Of the random numbers.
    #[arg(long, default_value_t = efam_inference::predict::PredictionSettings::default().seed)]
    seed: u64,
    /// Show the ensemble of rods in Rerun: save, spawn, connect, connect=URL or serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse)]
    rerun: Option<Rerun>,
    #[command(flatten)]
    output: Output,
}

/// The JSON output: one case, or a grid of cases.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Printed<'a> {
    /// Of one case.
    One {
        /// Where the results are.
        folder: &'a Path,
        /// The prediction.
        prediction: &'a Prediction,
    },
    /// Of several pressures or payloads.
    Several {
        /// Where the results are.
        folder: &'a Path,
        /// The prediction.
        grid: &'a Grid,
    },
    /// Of the releases of an experiment, with `--check`.
    Check(check::Printed<'a>),
}

/// What is predicted: a scenario's rod, or a muscle.
#[derive(Clone, Copy)]
enum RodFile<'a> {
    Scenario(&'a Path),
    Muscle(&'a str),
}

impl Predict {
    /// As it was given, a muscle by its option or in the place of a scenario.
    fn rod(&self) -> Option<RodFile<'_>> {
        let muscle = self.muscle.as_deref();
        let Some(scenario) = &self.scenario else { return muscle.map(RodFile::Muscle) };
        let is_muscle = |file: &&str| {
            BUILT_IN.iter().any(|(name, _)| name == file) || FileKind::of(scenario) == Some(FileKind::Muscle)
        };
        Some(match scenario.to_str().filter(is_muscle) {
            Some(muscle) => RodFile::Muscle(muscle),
            None => RodFile::Scenario(scenario),
        })
    }
}

pub fn run(args: &Predict, console: &Console) -> Result<ExitCode, Failure> {
    if let Some(experiment) = &args.check {
        return check::run(args, experiment, console);
    }
    let rod = requested_rod(args)?;
    let begin = Instant::now();
    let (cases, input_hashes) = case_request(args, rod)?;
    let (pressures, payloads) = grid_of(args, cases.has_muscle())?;
    // What the scenario refuses is said before a folder is opened.
    let read = cases.case(pressures.first().copied(), payloads.first().copied());
    let (mut case, known) = match rod {
        RodFile::Scenario(file) => of_kind(FileKind::Scenario, file, read)?,
        RodFile::Muscle(_) => read?,
    };
    let is_grid = pressures.len() > 1 || payloads.len() > 1;
    let name = title(args, &case.name);
    case.name = name.clone();
    let request = Request {
        name: name.replace([',', ':', '/'], " "),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        resolved_scenario: case.resolved(),
        input_hashes,
        argv: argv(),
        ..Request::default()
    };
    // Obstacles are reported before the simulations.
    signals::listen();
    let folder = efam_report::begin(&request)?;
    console.detail(format!("{name}: on {} threads", rayon::current_num_threads()));
    let done = |warnings: &[String]| Request {
        warnings: warnings.to_vec(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..request.clone()
    };
    if is_grid {
        let payloads = if payloads.is_empty() { vec![0.0] } else { payloads };
        let make = |pressure, payload| Ok(cases.case(pressure, Some(payload))?.0);
        let cases = pressures.len().max(1) * payloads.len();
        let stages = console.steps(cases, &format!("cases of {} runs", runs(known.as_ref())));
        let step = || stages.step();
        let work = || grid(&name, (&pressures, &payloads), &make, known.as_ref(), &step);
        let (folder, grid) = interrupt::during(folder, &stages, work);
        let grid = grid?;
        stages.clear();
        interrupt::writing(&folder, &stages, || write_grid(&folder, &done(&grid.warnings), &grid))?;
        let member = |cell: &Cell| -> Result<Member, Failure> {
            let case = make(cell.pressure_pa, cell.payload_kg)?;
            Ok(Member { name: cell_name(cell), ..Member::case(&case) })
        };
        let members = || grid.cells.iter().map(member).collect();
        let (folder, viewer) = finish(args, console, folder, &request, &members)?;
        let printed = Printed::Several { folder: &folder, grid: &grid };
        answer(&args.output, console, &folder, &printed, || grid_table(&grid))?;
        Recording::shown(viewer, args.rerun.as_ref())?;
    } else {
        let settings = PredictionSettings { draws: args.draws, seed: args.seed };
        let stages = console.steps(known.as_ref().map_or(0, |_| args.draws), "draws");
        let step = || stages.step();
        let work = || predict(&case, known.as_ref(), &settings, &step);
        let (folder, outcome) = interrupt::during(folder, &stages, work);
        let outcome = outcome.map_err(|error| Failure::Diverged(error.to_string()))?;
        stages.clear();
        let prediction = &outcome.prediction;
        let written = || write_prediction(&folder, &done(&prediction.warnings), &outcome);
        interrupt::writing(&folder, &stages, written)?;
        let members = || Ok(ensemble(&case, known.as_ref(), &settings));
        let (folder, viewer) = finish(args, console, folder, &request, &members)?;
        let printed = Printed::One { folder: &folder, prediction };
        answer(&args.output, console, &folder, &printed, || prediction_table(prediction))?;
        Recording::shown(viewer, args.rerun.as_ref())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The rod that is requested, and of a muscle its pressure as well.
fn requested_rod(args: &Predict) -> Result<RodFile<'_>, Failure> {
    match (args.rod(), &args.pressure) {
        (None, _) => Err(Failure::Usage(format!(
            "which rod? give the rod.toml of a calibration; or --muscle muscle.toml --pressure 40psi; or a built-in muscle: {}",
            built_in()
        ))),
        (Some(RodFile::Muscle(muscle)), None) => Err(Failure::Usage(format!(
            "{muscle} is a muscle, which needs --pressure, such as --pressure 40psi"
        ))),
        (Some(rod), _) => Ok(rod),
    }
}

/// The requested pressures, Pa, and payloads, kg; none where the rod's own is meant.
fn grid_of(args: &Predict, has_muscle: bool) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    once("--pressure", args.pressure.as_ref(), "muscle.pressure", &args.set)?;
    once("--payload", args.payload.as_ref(), "effects.payload.mass", &args.set)?;
    let pressures = several("--pressure", &args.pressure, "Pa")?;
    let payloads = several("--payload", &args.payload, "kg")?;
    if payloads.iter().any(|payload| *payload < 0.0) {
        let payload = args.payload.as_deref().unwrap_or_default();
        return Err(Failure::Usage(format!("--payload {payload}: it must not be negative")));
    }
    if !pressures.is_empty() && !has_muscle {
        return Err(Failure::Usage(
            "--pressure: the scenario's rod is no muscle, and is the same at every pressure; leave it out"
                .to_owned(),
        ));
    }
    Ok((pressures, payloads))
}

/// Shows the rods if that is requested, and gives the folder its name, unless it is interrupted.
fn finish(
    args: &Predict,
    console: &Console,
    folder: Folder,
    request: &Request,
    members: &dyn Fn() -> Result<Vec<Member>, Failure>,
) -> Result<(PathBuf, Option<LiveEnsemble>), Failure> {
    let open = |how| {
        let id = efam_store::sha::sha256(format!("{}{}", request.name, request.resolved_scenario).as_bytes());
        LiveEnsemble::ensemble(how, &request.name, &id, folder.path(), &members()?)
    };
    let live = args.rerun.as_ref().map(open).transpose()?;
    let viewer = Recording::saved(live, args.rerun.as_ref())?;
    interrupt::check()?;
    let folder = folder.finish()?;
    console.detail(format!("written to {}", folder.display()));
    Ok((folder, viewer))
}

/// A case of several, by what distinguishes it.
fn cell_name(cell: &Cell) -> String {
    let payload = format_si(cell.payload_kg, "kg");
    cell.pressure_pa.map_or(payload.clone(), |pressure| format!("{}, {payload}", format_si(pressure, "Pa")))
}

/// The request, in words: `40psi with 80g`.
fn title(args: &Predict, case: &str) -> String {
    let payload = args.payload.as_ref().map_or(String::new(), |payload| format!(" with {payload}"));
    match (args.rod(), &args.pressure) {
        (Some(RodFile::Muscle(_)), Some(pressure)) => format!("{pressure}{payload}"),
        (_, Some(pressure)) => format!("{case} at {pressure}{payload}"),
        (_, None) => format!("{case}{payload}"),
    }
}

/// The requested rod, and the hash of its file.
fn case_request(args: &Predict, rod: RodFile) -> Result<(CaseRequest, BTreeMap<String, String>), Failure> {
    let mut hashes = BTreeMap::new();
    let mut read = |file: &Path, what: &str| {
        let text = input::text(file).map_err(|error| {
            Failure::Data(format!("{}: cannot be read ({error}); give {what}", file.display()))
        })?;
        hashes.insert(file.display().to_string(), efam_store::sha::sha256(text.as_bytes()));
        Ok::<_, Failure>(text)
    };
    let mut request = match rod {
        RodFile::Scenario(scenario) => CaseRequest::scenario(
            scenario,
            read(scenario, "a scenario, such as the rod.toml of a calibration")?,
        ),
        RodFile::Muscle(muscle) => {
            if !BUILT_IN.iter().any(|(name, _)| *name == muscle) {
                read(
                    Path::new(muscle),
                    &format!("the muscle.toml of a calibration, or a built-in muscle: {}", built_in()),
                )?;
            }
            CaseRequest::muscle(muscle)
        }
    };
    request.release = args.release.options(None, &args.set)?;
    request.set.clone_from(&args.set);
    Ok((request, hashes))
}

/// Names of the built-in muscles.
fn built_in() -> String {
    BUILT_IN.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// The quantities of an option that may have several.
fn several(option: &str, value: &Option<String>, unit: &str) -> Result<Vec<f64>, Failure> {
    let Some(text) = value else { return Ok(Vec::new()) };
    values(text, unit).map_err(|error| Failure::Usage(format!("{option} {text}: {error}")))
}
