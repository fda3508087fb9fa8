//! Who watches a run: a viewer or a recording that sees every sample.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use efam_core::forward::Run;
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::scenario::Case;
use efam_report::{Request, write_watched};
use models::quantity::format_si;

use super::super::console::Console;
use super::super::failure::Failure;
use super::super::live::{Live, Recording, Rerun};
use super::super::progress::ProgressBar;
use super::super::signals;
use super::super::terminal::{say, stdout};
use super::{follow, timed};

/// Runs a case while it is watched; a recording that is saved goes into a folder.
pub fn shown(how: &Rerun, case: &Case, folder: &Path, progress: &ProgressBar) -> Result<Trajectory, Failure> {
    let mut live = Live::open(how, case, folder)?;
    let trajectory = follow(case, progress, &mut |sample| live.log(&sample.snapshot()))?;
    live.finish(*how == Rerun::Serve && !signals::is_requested())?;
    Ok(trajectory)
}

/// The same, and nothing of the run is kept beside: memory does not grow with it.
pub fn only(how: &Rerun, case: &Case, request: &Request, console: &Console) -> Result<ExitCode, Failure> {
    let case = case.run_as(&case.model, &Run { keep_samples: false, trace_step: None, ..case.run.clone() });
    let folder = if *how == Rerun::Save { Some(efam_report::begin(request)?) } else { None };
    let progress = console.bar(case.run.samples.len());
    let nowhere = Path::new("");
    let within = folder.as_ref().map_or(nowhere, |folder| folder.path());
    let (run, wall_time_s) = timed(|| shown(how, &case, within, &progress));
    progress.finish_and_clear();
    let Trajectory { status, .. } = run?;
    let kept = match folder {
        Some(folder) => {
            write_watched(&folder, &Request { wall_time_s, ..request.clone() }, &status)?;
            format!("what was seen is in {}", folder.finish()?.display())
        }
        None => "nothing is kept".to_owned(),
    };
    let name = &case.name;
    match status {
        Status::Complete => {
            let [simulated, took] = [case.run.duration, wall_time_s].map(|time| format_si(time, "s"));
            if !console.quiet {
                writeln!(stdout(), "{name}: {simulated} in {took}; {kept}")?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Status::CutShort { time } => {
            say(format_args!("interrupted: {name}: at {} of the run; {kept}", format_si(time, "s")));
            Ok(ExitCode::from(signals::exit_code()))
        }
        Status::Failed { reason, .. } => Err(Failure::Diverged(format!("{reason}; {kept}"))),
    }
}
