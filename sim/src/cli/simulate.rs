//! `efam simulate`: one run, or one for each row of a muscle's table.

mod watch;

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, ValueEnum};
use efam_core::accuracy::Settled;
use efam_core::forward::{Run, Sample, forward};
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::{Case, Scenario};
use efam_experiments::summary::Summary;
use efam_experiments::table::{Series, Table};
use efam_report::Request;
use efam_report::aligned::{Aligned, Side};
use efam_report::beside_the_paper::beside_the_paper;
use efam_report::report::report;
use efam_report::simulated::{Member, write_set};
use efam_report::told::told;
use efam_store::Folder;
use efam_store::memory;
use models::quantity::format_si;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Output, ReleaseArguments, Source, argv};
use super::browser;
use super::console::{Console, print};
use super::failure::{Failure, of_kind};
use super::live::Rerun;
use super::progress::{Cost, ProgressBar};
use super::signals;
use super::terminal::{say, stdout};
use crate::simulate;

const HELP: &str = "Examples:
  efam simulate scenarios/release-15psi.toml
  efam simulate scenarios/release-15psi.toml --pressure 40psi --csv
  efam simulate scenarios/release-15psi.toml --payload 80g --angle 20deg
  efam simulate scenarios/payload-80g.toml --set effects.payload.mass=\"50 g\"
  efam simulate scenarios/release-15psi.toml --muscle muscle.toml --json
  efam simulate scenarios/release-15psi.toml --no-files --json
  efam simulate scenarios/release-15psi.toml --no-files --json --trajectory
  efam simulate scenarios/undamped.toml --out outputs/undamped --overwrite -v
  efam simulate scenarios/release-15psi.toml --set run.duration=\"24 h\"
    --rerun serve --watch-only

Exit codes: 4 if it cannot go on, 130 if it is interrupted; both save what was
integrated.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Simulate {
    #[command(flatten)]
    source: Source,
    /// Mass at the tip, such as 80g [default: the scenario's, or none].
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    payload: Option<String>,
    #[command(flatten)]
    release: ReleaseArguments,
    #[command(flatten)]
    output: Output,
    /// Also write CSV.
    #[arg(long)]
    csv: bool,
    /// Write nothing: the table or JSON is all that is left of the run.
    #[arg(long, conflicts_with_all = ["out", "overwrite", "csv", "open", "rerun"])]
    no_files: bool,
    /// With --json: print the samples, too; `nodes` adds the position and velocity of each node.
    #[arg(
        long,
        value_name = "OF",
        requires = "json",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "tip"
    )]
    trajectory: Option<Of>,
    /// Leave out the runs on a coarser mesh and with longer steps that
    /// estimate the errors of the tip and choose mesh and tolerance.
    #[arg(long)]
    no_error_estimate: bool,
    /// Show the rod in Rerun: save, spawn, connect, connect=URL or serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse)]
    rerun: Option<Rerun>,
    /// Send the run to Rerun only and save no results; memory use stays constant.
    #[arg(long, requires = "rerun", conflicts_with_all = ["csv", "json"])]
    watch_only: bool,
}

/// Of what the samples are printed.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Of {
    /// Time, tip, end body and energies.
    Tip,
    /// The nodes, too.
    Nodes,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Name of the scenario.
    scenario: &'a str,
    /// Where the results are; none with `--no-files`.
    folder: Option<&'a Path>,
    /// Each run; several where all rows of a muscle were requested.
    runs: Vec<OfRun<'a>>,
}

/// A run.
#[derive(Serialize, JsonSchema)]
struct OfRun<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// The samples with `--trajectory`: a list for each column of `trajectory.parquet`; null where there is no number.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<BTreeMap<String, Vec<Option<f64>>>>")]
    trajectory: Option<&'a Series>,
}

pub fn run(args: &Simulate, console: &Console) -> Result<ExitCode, Failure> {
    let release = args.release.options(args.payload.as_ref(), &args.source.set)?;
    let overrides = [release.overrides(), args.source.overrides()?].concat();
    let scenario = of_kind(
        FileKind::Scenario,
        &args.source.scenario,
        Scenario::load_with(&args.source.scenario, &overrides, &args.source.law),
    )?;
    let cases = scenario.cases()?;
    let is_sweep = scenario.is_all_rows();
    if is_sweep && args.rerun.is_some() {
        let message = "--rerun shows one run; choose one pressure, such as --pressure 40psi";
        return Err(Failure::Usage(message.to_owned()));
    }
    console.warn(cases.iter().flat_map(|case| &case.warnings));
    signals::listen();
    if let (Some(how), true) = (&args.rerun, args.watch_only) {
        return watch::only(how, &cases[0], &request(args, &scenario, &cases[0]), console);
    }
    admit(&cases)?;
    let (runs, threads) = (cases.len(), rayon::current_num_threads());
    console.detail(format!("{}: {runs} to simulate, on {threads} threads", scenario.path.display()));
    let request = request(args, &scenario, &cases[0]);
    let folder = if args.no_files { None } else { Some(efam_report::begin(&request)?) };
    let samples: usize = cases.iter().map(|case| case.run.samples.len()).sum();
    let progress = console.bar(samples);
    let begin = Instant::now();
    let runs: Vec<_> = cases
        .par_iter()
        .map(|case| {
            timed(|| -> Result<Settled, Failure> {
                let done = simulate(case, !args.no_error_estimate, &progress, console)?;
                if let (Some(how), Some(folder), Status::Complete) =
                    (&args.rerun, &folder, &done.trajectory.status)
                {
                    watch::shown(how, &case.run_as(&done.model, &done.run), folder.path(), &progress)?;
                }
                Ok(done)
            })
        })
        .collect();
    let wall_time_s = begin.elapsed().as_secs_f64();
    progress.finish_and_clear();
    let (done, series) = written(args, console, folder.as_ref(), (&scenario, &request), &cases, runs)?;
    if let (Some(folder), true) = (&folder, is_sweep) {
        let remarks = is_the_papers(&scenario).then(|| beside_the_paper(&done));
        let request = Request { wall_time_s, ..request };
        write_set(folder, &request, &cases[0].model, &done, remarks.as_deref())?;
    }
    let folder = folder.map(Folder::finish).transpose()?;
    let folder = folder.as_deref();
    if let Some(folder) = folder {
        console.detail(format!("written to {}", folder.display()));
    }
    if args.output.form.json {
        let series = series.iter().map(Option::as_ref);
        let runs = done.iter().zip(series);
        let runs = runs.map(|(member, trajectory)| OfRun { summary: &member.summary, trajectory }).collect();
        print(&Printed { scenario: &scenario.name, folder, runs })?;
    } else {
        tell(console, &scenario, folder, &done)?;
    }
    if let Some(folder) = folder.filter(|_| !signals::is_requested()) {
        browser::show(args.output.open, folder, console);
    }
    outcome(folder, &done)
}

/// Writes what was simulated; the members with the samples that are printed.
fn written(
    args: &Simulate,
    console: &Console,
    folder: Option<&Folder>,
    (scenario, request): (&Scenario, &Request),
    cases: &[Case],
    runs: Vec<(Result<Settled, Failure>, f64)>,
) -> Result<(Vec<Member>, Vec<Option<Series>>), Failure> {
    let is_sweep = scenario.is_all_rows();
    let mut done: Vec<Member> = Vec::with_capacity(runs.len());
    let mut series = Vec::new();
    for (case, (run, wall_time_s)) in cases.iter().zip(runs) {
        let run: Settled = run?;
        let warnings = simulate::warnings(case, &run);
        let case = case.run_as(&run.model, &run.run);
        console.warn(&warnings);
        let own = Request {
            name: case.name.clone(),
            resolved_scenario: case.resolved(),
            warnings: case.warnings.iter().cloned().chain(warnings).collect(),
            wall_time_s,
            errors: run.errors,
            ..request.clone()
        };
        console.detail(format!("{}: analysis, tables and pages", case.name));
        let within = is_sweep.then_some(case.name.as_str());
        let run = run.trajectory;
        let summary = match folder {
            Some(folder) => efam_report::write_run(folder, within, &own, &case.model, &case.run, &run)?,
            None => told(&own, &case.model, &case.run, &run).summary,
        };
        console.detail(integrated(&summary));
        let table = || Table::new(&case.model, &run, case.run.energy);
        series.push(args.trajectory.map(|of| table().series(of == Of::Nodes)));
        done.push(if is_sweep && folder.is_some() {
            Member::of_set(done.len(), summary, case.pressure, &case.model, run)
        } else {
            Member::new(summary, case.pressure, run)
        });
    }
    Ok((done, series))
}

fn request(args: &Simulate, scenario: &Scenario, first: &Case) -> Request {
    let hash = |(file, text): (&str, &str)| (file.to_owned(), efam_store::sha::sha256(text.as_bytes()));
    Request {
        name: scenario.name.clone(),
        out: args.output.out.clone(),
        overwrite: args.output.overwrite,
        csv: args.csv,
        resolved_scenario: first.resolved(),
        input_hashes: scenario.files().map(hash).collect(),
        argv: argv(),
        cancel: signals::cancel(),
        ..Request::default()
    }
}

/// What a run cost, in a line.
fn integrated(summary: &Summary) -> String {
    let Summary { name, simulated_s, effort, wall_time_s, .. } = summary;
    let (steps, method) = (effort.steps, summary.settings.method);
    let nodes = summary.settings.nodes;
    format!("{name}: {simulated_s} s with {nodes} nodes by {method:?}: {steps} steps in {wall_time_s:.3} s")
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = Instant::now();
    let done = work();
    (done, begin.elapsed().as_secs_f64())
}

/// What the statuses say: interrupted, diverged, or well.
fn outcome(folder: Option<&Path>, done: &[Member]) -> Result<ExitCode, Failure> {
    let saved = |time: f64| {
        let time = format_si(time, "s");
        match folder {
            Some(folder) => {
                format!("the {time} before that are in {}, marked in summary.json", folder.display())
            }
            None => format!("the {time} before that are not saved, as --no-files says"),
        }
    };
    for Member { summary, .. } in done {
        match &summary.status {
            Status::Complete => {}
            Status::CutShort { time } => {
                say(format_args!("interrupted: {}: {}", summary.name, saved(*time)));
                return Ok(ExitCode::from(signals::exit_code()));
            }
            Status::Failed { time, reason } => {
                return Err(Failure::Diverged(format!("{reason}; {}", saved(*time))));
            }
        }
    }
    if signals::is_requested() {
        let name = done.first().map_or("", |member| member.summary.name.as_str());
        say(format_args!("interrupted: {name}: complete, without some of its pictures and pages"));
        return Ok(ExitCode::from(signals::exit_code()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Runs a case until its end, Ctrl-C, or where it fails; what was integrated is kept.
fn simulate(
    case: &Case,
    estimates: bool,
    progress: &ProgressBar,
    console: &Console,
) -> Result<Settled, Failure> {
    let mut cost = Cost::new(case.run.duration);
    let mut see = |sample: &mut Sample| {
        if let Some(whole) = cost.estimated(sample.state.time) {
            progress.suspend(|| console.expect(&case.name, whole));
        }
        counted(progress)
    };
    simulate::simulate(case, estimates, signals::cancel(), &mut see)
}

/// What sees every sample, and may fail.
pub type See<'a> = dyn FnMut(&mut Sample) -> Result<(), Failure> + 'a;

/// Runs a case without changes, and lets a viewer see it; what was integrated is kept.
pub fn follow(case: &Case, progress: &ProgressBar, see: &mut See) -> Result<Trajectory, Failure> {
    let mut failure = None;
    let mut observe = |sample: &mut Sample| {
        if let Err(error) = see(sample) {
            failure = Some(error);
            return ControlFlow::Break(());
        }
        counted(progress)
    };
    let run = Run { cancel: signals::cancel(), ..case.run.clone() };
    let run = forward(&case.model, &run, &mut observe);
    match failure {
        Some(failure) => Err(failure),
        None => simulate::kept(case, run),
    }
}

/// One sample more, unless nobody wants it any more.
fn counted(progress: &ProgressBar) -> ControlFlow<()> {
    progress.inc(1);
    if signals::is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Whether memory holds all trajectories, and the table of each that is written; checked before hours are spent.
pub fn admit(cases: &[Case]) -> Result<(), Failure> {
    let of = |case: &Case| {
        let numbers = 2 * case.model.dof() + case.model.memory() + OF_A_SAMPLE;
        2 * 8 * case.run.samples.len() as u64 * numbers as u64
    };
    let needed: u64 = cases.iter().map(of).sum();
    match memory::available() {
        Some(free) if needed > free => {
            let [needed, free] = [needed, free].map(|bytes| bytes as f64 / 1e9);
            let samples: usize = cases.iter().map(|case| case.run.samples.len()).sum();
            Err(Failure::Usage(format!(
                "{}: {samples} samples of this rod take some {needed:.1} GB of memory, and {free:.1} GB are free; \
                 lower run.rate, run.duration or rod.nodes, or keep none: --rerun HOW --watch-only",
                cases[0].name
            )))
        }
        _ => Ok(()),
    }
}

/// Numbers of a sample beside coordinates, velocities and memory: time, tip, energies.
const OF_A_SAMPLE: usize = 15;

fn tell(
    console: &Console,
    scenario: &Scenario,
    folder: Option<&Path>,
    done: &[Member],
) -> Result<(), Failure> {
    if console.quiet {
        return Ok(());
    }
    let mut out = stdout();
    match done {
        [one] => writeln!(out, "{}", report(&one.summary))?,
        _ => write!(out, "{}", over_pressure(done))?,
    }
    if is_the_papers(scenario) {
        write!(out, "\n{}", beside_the_paper(done))?;
    }
    if let Some(folder) = folder {
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    Ok(())
}

/// Whether all pressures of the paper's muscle are run, so that its trends can be set beside.
fn is_the_papers(scenario: &Scenario) -> bool {
    let is_own = |name| models::muscle::BUILT_IN.iter().any(|(own, _)| *own == name);
    scenario.is_all_rows() && scenario.muscle_name().is_some_and(is_own)
}

/// A line a run.
fn over_pressure(done: &[Member]) -> Aligned {
    let numbers = ["pressure", "frequency", "damping ratio", "steps"].map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("", Side::Words)], &numbers[..]].concat());
    for Member { summary, pressure, .. } in done {
        let text =
            |value: Option<f64>, unit: &str| value.map_or("-".to_owned(), |value| format_si(value, unit));
        let ratio = summary.damping_ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.4}"));
        let frequency = text(summary.damped_frequency_hz, "Hz");
        let steps = summary.effort.steps.to_string();
        table.row([summary.name.clone(), text(*pressure, "Pa"), frequency, ratio, steps]);
    }
    table
}
