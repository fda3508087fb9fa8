//! `efam diagnose`: which physical effect the model of an experiment lacks.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Args;
use efam_core::work::written;
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::Scenario;
use efam_inference::diagnose::plan::Prospect;
use efam_inference::diagnose::{
    Diagnosis, DiagnosisOutcome, DiagnosisSettings, diagnose, known_effects, plan, problem,
};
use efam_report::Request;
use efam_report::diagnosed::{diagnosis_table, plan_table, write_diagnosis};
use models::quantity::Quantity;
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::answer;
use super::arguments::OfExperiment;
use super::console::{Console, print};
use super::experiment::{claim, load, read, request};
use super::failure::{Failure, of_kind};
use super::interrupt::{self, Ending};
use super::live::{LiveSearch, Recording, Rerun, Watcher, unlocked};
use super::terminal::{say, stdout};
use super::{node_steps, signals};

const HELP: &str = "Examples:
  efam diagnose scenarios/diagnosis/air-drag/experiment.toml
  efam diagnose beam.toml --most 1 --without tip_drag --out outputs/beam -v
  efam diagnose beam.toml --law my_law.toml
  efam diagnose beam.toml --rerun save --json
  efam diagnose --plan scenarios/release-15psi.toml --noise \"0.1 mm\"

Exit codes: 0 whatever the answer is, 3 for data that cannot be used, 4 if the
baseline cannot be fitted, 130 if it is interrupted. An interrupted search
saves its results once the baseline is fitted. A second Ctrl-C saves nothing.";

/// [`USUAL_BUDGET`] as it is typed.
const BUDGET: &str = "2e9";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Diagnose {
    #[command(flatten)]
    of: OfExperiment,
    /// Probability that nothing is missing, given the recordings, above which no effect is named.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    false_alarm: f64,
    /// Largest number of effects to add.
    #[arg(long, value_name = "COUNT", default_value_t = 3)]
    most: usize,
    /// Node steps (nodes times steps of the integrator) after which no further part of the search begins. The answer
    /// then lists what was left out. It depends on no clock, load or number of threads. The fit of the baseline is always
    /// completed.
    #[arg(long, value_name = "NODE_STEPS", default_value = BUDGET, value_parser = node_steps::parse, conflicts_with = "plan")]
    budget: u64,
    /// Also end the search after this time, with the results up to then. Answers then depend on the machine and its load.
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "plan")]
    time_limit: Option<Duration>,
    /// Remove an effect from the candidates; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Read a scenario of a planned release: print which effects it can show, and from which size.
    #[arg(long)]
    plan: bool,
    /// Another scenario of the plan; may be repeated.
    #[arg(long, value_name = "SCENARIO", requires = "plan")]
    also: Vec<PathBuf>,
    /// Camera noise of the planned release.
    #[arg(long, value_name = "LENGTH", requires = "plan", default_value = "0.3 mm", value_parser = length)]
    noise: f64,
    /// Root mean square distance between two planned releases of one condition; without it they repeat exactly.
    #[arg(long, value_name = "LENGTH", requires = "plan", value_parser = length)]
    repeatability: Option<f64>,
    /// Planned marker on the body, as a share of the length; may be repeated.
    #[arg(long, value_name = "SHARE", requires = "plan", value_parser = share)]
    marker: Vec<f64>,
    /// Show progress and each release before and after in Rerun: save, spawn, connect, connect=URL or
    /// serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse, conflicts_with = "plan")]
    rerun: Option<Rerun>,
}

/// The JSON output: a diagnosis, or a plan with `--plan`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Printed<'a> {
    /// Of an experiment.
    Diagnosed {
        /// Where the results are.
        folder: &'a Path,
        /// What was found.
        diagnosis: &'a Diagnosis,
    },
    /// Of releases that are planned.
    Planned {
        /// How many releases.
        releases: usize,
        /// Each effect, that which is seen best first.
        prospects: &'a [Prospect],
    },
}

/// A length with its unit, m, more than nothing.
fn length(text: &str) -> Result<f64, String> {
    match Quantity::parse(text).and_then(|quantity| quantity.to("m")) {
        Ok(length) if length > 0.0 => Ok(length),
        Ok(_) => Err("it must be more than nothing, such as \"0.3 mm\"".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// A time with its unit, more than nothing.
fn time(text: &str) -> Result<Duration, String> {
    match Quantity::parse(text).and_then(|quantity| quantity.to("s")) {
        Ok(time) if time > 0.0 => Ok(Duration::try_from_secs_f64(time).unwrap_or(Duration::MAX)),
        Ok(_) => Err("it must be more than nothing, such as \"3 min\"".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// A probability, not 0 and not 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("it must lie between 0 and 1, such as 0.01".to_owned()),
    }
}

pub fn run(args: &Diagnose, console: &Console) -> Result<ExitCode, Failure> {
    if args.plan {
        return planned(args, console);
    }
    let begin = Instant::now();
    // Obstacles are reported before a long search, and before a folder is made.
    let experiment = load(&args.of)?;
    known_effects(&args.without, &experiment.catalogue())
        .map_err(|wrong| Failure::Usage(format!("--without: {wrong}")))?;
    let settings = DiagnosisSettings {
        false_alarm: args.false_alarm,
        most_effects: args.most,
        excluded: args.without.clone(),
        budget: args.budget,
        ..DiagnosisSettings::default()
    }
    .stated(&experiment)?;
    let folder = claim(&experiment, &args.of, console)?;
    // With the hashes of what is read now.
    let request = request(&experiment, begin);
    let stages = console.stages();
    let open = |how| {
        let id = efam_store::sha::sha256(format!("{:?}{settings:?}", request.input_hashes).as_bytes());
        LiveSearch::search(how, &experiment.name, &id, folder.path())
    };
    let live = args.rerun.as_ref().map(open).transpose()?.map(Mutex::new);
    let ending = Ending::after(args.time_limit);
    let work = || -> Result<DiagnosisOutcome, Failure> {
        let cleaned = read(&experiment, &stages)?;
        let problem = problem(&experiment, &cleaned)?;
        if !console.quiet && !args.of.output.form.json {
            stages.announce(expected(args));
        }
        let watcher = Watcher { stages: &stages, live: live.as_ref(), ending: Some(&ending) };
        Ok(diagnose(&problem, &settings, &watcher)?)
    };
    let (folder, outcome) = interrupt::during_search(folder, &stages, &ending, work);
    let outcome = outcome?;
    stages.tell("writing");
    let wall_time_s = begin.elapsed().as_secs_f64();
    let request = Request { warnings: outcome.diagnosis.warnings.clone(), wall_time_s, ..request };
    write_diagnosis(&folder, &request, &outcome)?;
    let live = unlocked(live).map(|mut live| live.found(&outcome).map(|()| live)).transpose()?;
    let viewer = Recording::saved(live, args.rerun.as_ref())?;
    let folder = folder.finish()?;
    stages.clear();
    console.detail(format!("written to {}", folder.display()));
    let printed = Printed::Diagnosed { folder: &folder, diagnosis: &outcome.diagnosis };
    answer(&args.of.output, console, &folder, &printed, || diagnosis_table(&outcome.diagnosis))?;
    if signals::is_requested() {
        say(format_args!("interrupted: the results up to then are saved"));
        return Ok(signals::exit_code().into());
    }
    Recording::shown(viewer, args.rerun.as_ref())?;
    Ok(ExitCode::SUCCESS)
}

/// What may end the search, and about when.
fn expected(args: &Diagnose) -> String {
    let time = node_steps::time_here(args.budget).map_or("an unknown time".to_owned(), node_steps::duration);
    let budget = written(args.budget);
    let budget = format!("budget: {budget} node steps, about {time} on one thread here");
    match args.time_limit {
        None => budget,
        Some(limit) => {
            let limit = node_steps::duration(limit);
            format!("{budget}; time limit: {limit}, by which the answer depends on this machine and its load")
        }
    }
}

/// What releases that are not recorded yet could show.
fn planned(args: &Diagnose, console: &Console) -> Result<ExitCode, Failure> {
    let mut cases = Vec::new();
    for path in std::iter::once(&args.of.experiment).chain(&args.also) {
        let overrides = if path == &args.of.experiment { &args.of.set[..] } else { &[] };
        cases.extend(of_kind(FileKind::Scenario, path, Scenario::load(path, overrides))?.cases()?);
    }
    console.warn(cases.iter().flat_map(|case| &case.warnings));
    signals::listen();
    let problem = plan::problem(&cases, args.noise, &args.marker);
    let stages = console.stages();
    let work = || plan::plan(&problem, args.repeatability, &|what| stages.tell(what));
    let ((), prospects) = interrupt::during((), &stages, work);
    let prospects = plan::best_seen(prospects?);
    stages.clear();
    if args.of.output.form.json {
        print(&Printed::Planned { releases: cases.len(), prospects: &prospects })?;
    } else if !console.quiet {
        let mut out = stdout();
        write!(out, "{}", plan_table(&prospects, cases.len()))?;
    }
    Ok(ExitCode::SUCCESS)
}
