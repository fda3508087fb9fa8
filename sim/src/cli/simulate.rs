//! `efam simulate`: one run, or one for each row of a muscle's table.

use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use models::quantity::format_si;
use rayon::prelude::*;
use serde_json::{Value, json};
use sim::forward::{ForwardError, forward};
use sim::scenario::{Case, Scenario};
use sim::trajectory::{Status, Trajectory};

use super::failure::Failure;
use super::live::{Live, Rerun};
use super::output::{Folder, summary};
use super::{Simulate, interrupt};

pub fn run(args: &Simulate) -> Result<ExitCode, Failure> {
    let scenario = Scenario::load(&args.source.scenario, &args.source.overrides())?;
    let cases = scenario.cases()?;
    let is_sweep = scenario.is_all_rows();
    if is_sweep && args.rerun.is_some() {
        let message = "--rerun shows one run; choose one pressure, such as --pressure 40psi";
        return Err(Failure::Usage(message.to_owned()));
    }
    for warning in cases.iter().flat_map(|case| &case.warnings) {
        eprintln!("warning: {warning}");
    }
    let path = args.out.clone().unwrap_or_else(|| Path::new("outputs").join(&scenario.name));
    let folder = Folder::open(&path, args.overwrite)?;
    interrupt::listen();
    let samples: usize = cases.iter().map(|case| case.run.samples.len()).sum();
    let progress = progress(args, samples);
    let runs: Vec<Result<Trajectory, Failure>> = match &args.rerun {
        Some(how) => vec![shown(how, &cases[0], &folder, &progress)],
        None => cases.par_iter().map(|case| follow(case, &progress, &mut |_| Ok(()))).collect(),
    };
    progress.finish_and_clear();
    let mut summaries = Vec::with_capacity(runs.len());
    for (case, run) in cases.iter().zip(runs) {
        let trajectory = run?;
        let summary = summary(case, &trajectory);
        let own = is_sweep.then_some(case.name.as_str());
        folder.write(own, case, &trajectory, &summary, args.csv)?;
        summaries.push((trajectory.status, summary));
    }
    let folder = folder.finish()?;
    tell(args, &scenario, &folder, &summaries)?;
    outcome(&folder, &summaries)
}

/// What the statuses say: interrupted, diverged, or well.
fn outcome(folder: &Path, summaries: &[(Status, Value)]) -> Result<ExitCode, Failure> {
    let saved = |time: f64| {
        let time = format_si(time, "s");
        format!("the {time} before that are in {}, marked in summary.json", folder.display())
    };
    for (status, summary) in summaries {
        match status {
            Status::Complete => {}
            Status::CutShort { time } => {
                eprintln!("interrupted: {}: {}", summary["name"].as_str().unwrap_or_default(), saved(*time));
                return Ok(ExitCode::from(interrupt::EXIT_CODE));
            }
            Status::Failed { time, reason } => {
                return Err(Failure::Diverged(format!("{reason}; {}", saved(*time))));
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn progress(args: &Simulate, samples: usize) -> ProgressBar {
    if args.quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent} % of simulated time, {eta} left");
    let bar = ProgressBar::new(samples as u64);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

type See<'a> = dyn FnMut(&mut sim::forward::Sample) -> Result<(), Failure> + 'a;

/// Runs a case until its end, Ctrl-C, or where it fails; what was integrated is kept.
fn follow(case: &Case, progress: &ProgressBar, see: &mut See) -> Result<Trajectory, Failure> {
    let mut failure = None;
    let mut observe = |sample: &mut sim::forward::Sample| {
        progress.inc(1);
        if let Err(error) = see(sample) {
            failure = Some(error);
            return ControlFlow::Break(());
        }
        if interrupt::is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = forward(&case.model, &case.run, &mut observe);
    match (failure, run) {
        (Some(failure), _) => Err(failure),
        (None, Ok(trajectory)) => Ok(trajectory),
        (None, Err(ForwardError::Integrate { trajectory, .. })) => Ok(*trajectory),
        (None, Err(ForwardError::Model(error))) => Err(error.into()),
    }
}

/// Runs a case with a viewer or a recording that sees every sample.
fn shown(how: &Rerun, case: &Case, folder: &Folder, progress: &ProgressBar) -> Result<Trajectory, Failure> {
    let mut live = Live::open(how, case, folder.partial())?;
    let trajectory = follow(case, progress, &mut |sample| live.log(&sample.snapshot()))?;
    live.finish(*how == Rerun::Serve && !interrupt::is_asked())?;
    Ok(trajectory)
}

fn tell(
    args: &Simulate,
    scenario: &Scenario,
    folder: &Path,
    summaries: &[(Status, Value)],
) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    if args.json {
        let runs: Vec<_> = summaries.iter().map(|(_, summary)| summary).collect();
        let folder: PathBuf = folder.to_owned();
        writeln!(out, "{}", json!({ "scenario": scenario.name, "folder": folder, "runs": runs }))?;
        return Ok(());
    }
    if args.quiet {
        return Ok(());
    }
    writeln!(out, "{:24}{:>12}{:>12}{:>16}{:>10}", "", "pressure", "frequency", "damping ratio", "steps")?;
    for (status, summary) in summaries {
        let number = |key: &str| summary[key].as_f64();
        let text = |key: &str, unit: &str| number(key).map_or("-".to_owned(), |value| format_si(value, unit));
        let ratio = number("damping_ratio").map_or("-".to_owned(), |ratio| format!("{ratio:.4}"));
        writeln!(
            out,
            "{:24}{:>12}{:>12}{ratio:>16}{:>10}{}",
            summary["name"].as_str().unwrap_or_default(),
            text("pressure_pa", "Pa"),
            text("damped_frequency_hz", "Hz"),
            summary["effort"]["steps"].to_string(),
            if *status == Status::Complete { "" } else { "  not to its end" }
        )?;
    }
    if scenario.is_all_rows() && scenario.muscle_name() == Some("garbulinski-2022") {
        write!(out, "\n{}", beside_the_paper(summaries))?;
    }
    writeln!(out, "\nresults in {}", folder.display())?;
    Ok(())
}

/// The trends that the paper measured beside those simulated, and what would make up the difference.
fn beside_the_paper(summaries: &[(Status, Value)]) -> String {
    let at = |(_, summary): &(Status, Value)| {
        Some((summary["damped_frequency_hz"].as_f64()?, summary["pressure_pa"].as_f64()?))
    };
    let mut swings: Vec<_> = summaries.iter().filter_map(at).collect();
    swings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let psi = |pascal: f64| (pascal / 6894.757).round();
    let ours = match swings[..] {
        [slow, .., fast] => format!(
            "{:.2} to {:.2} Hz, {:.0} % apart; highest at {} psi, lowest at {} psi",
            slow.0,
            fast.0,
            100.0 * (fast.0 / slow.0 - 1.0),
            psi(fast.1),
            psi(slow.1)
        ),
        _ => "no swing".to_owned(),
    };
    let ratio = |(_, summary): &(Status, Value)| summary["damping_ratio"].as_f64();
    let damping = match (summaries.first().and_then(ratio), summaries.last().and_then(ratio)) {
        (Some(first), Some(last)) => format!("from {first:.3} to {last:.3}, {:.1} times", last / first),
        _ => "unknown".to_owned(),
    };
    format!(
        "simulated frequency: {ours}
measured (Garbulinski and Wereley 2022): 20 % apart; highest at 10 psi, lowest at 30 to 40 psi, \
rising in a straight line above
simulated damping ratio, lowest to highest pressure: {damping}
measured: about 4.5 times, two thirds of the highest by 30 psi
Missing here: the muscle is stiffer in motion than at rest, and more so at high pressure, where it \
also loses more.
A bending moment that resists change, viscoelastic or frictional, has both; see `efam effects viscoelastic`.
"
    )
}
