//! `efam sweep merge`: all shards as one table, its page and its pictures.

use std::process::ExitCode;

use clap::Args;
use efam_report::Request;
use efam_report::swept::{request_of, write_swept};
use efam_store::escape::shell_word;
use efam_sweeps::merge::{Merged, merge};
use efam_sweeps::plan::Plan;

use super::super::arguments::{Form, argv};
use super::super::console::Console;
use super::super::failure::Failure;
use super::super::interrupt;
use super::super::terminal::say;
use super::{OfPlan, tell};

const HELP: &str = "Examples:
  efam sweep merge --plan outputs/map
  sbatch --dependency=afterany:42 outputs/map/merge.sh

Exit codes: 3 if a shard is missing or broken; it says which, in the form of
--array=.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Merge {
    #[command(flatten)]
    of: OfPlan,
    /// Also write CSV.
    #[arg(long)]
    csv: bool,
    #[command(flatten)]
    form: Form,
}

pub fn run(args: &Merge, console: &Console) -> Result<ExitCode, Failure> {
    let plan = Plan::open(&args.of.plan)?;
    let merged = merged(&plan, args.csv, 0.0, console)?;
    tell(&plan.folder, &merged, args.form.json, console)
}

/// Merges a sweep and writes what it says; `seconds` is what it took, where that is known.
pub fn merged(plan: &Plan, csv: bool, seconds: f64, console: &Console) -> Result<Merged, Failure> {
    let stages = console.steps(plan.head.shards(), "shards merged");
    let last_words = || {
        let plan = shell_word(&plan.folder);
        say(format_args!("interrupted: all shards are kept; go on: efam sweep merge --plan {plan}"));
    };
    let work = || merge(plan, csv, &|| stages.step());
    let ((), done) = interrupt::during_or((), &stages, work, last_words);
    stages.clear();
    let (merged, kept) = done?;
    let request =
        Request { warnings: merged.warnings.clone(), argv: argv(), wall_time_s: seconds, ..request_of(plan) };
    write_swept(plan, &request, &merged, &kept)?;
    Ok(merged)
}
