//! `efam sweep`: many simulations of one design, or many diagnoses, here or on a cluster.

mod merge;
pub mod plan;
pub mod run;
pub mod status;
pub mod submit;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Subcommand};
use efam_report::swept::swept_table;
use efam_sweeps::merge::Merged;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Output;
use super::browser;
use super::console::{Console, print};
use super::failure::Failure;
use super::signals;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam sweep scenarios/sweep/payload-and-pressure.toml
  efam sweep scenarios/sweep/payload-and-pressure.toml --set sweep.seed=2 --json
  efam sweep scenarios/sweep/payload-and-pressure.toml --out outputs/map --csv
  efam sweep scenarios/sweep/diagnoses.toml

Interrupted or killed, it goes on where it was with the same command and
--out, or with `efam sweep run --plan DIR` and `efam sweep merge --plan DIR`.

On a cluster: `efam sweep plan`, `submit`, `status`, `merge`.

Exit codes: 0 also if points have no answer: each is a row that says
why. 130 if it is interrupted, which keeps the shards that are whole.";

#[derive(Args)]
#[command(after_help = HELP, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Sweep {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    whole: Whole,
}

#[derive(Subcommand)]
enum What {
    /// Write a plan: every point with its seed, identified by one hash.
    Plan(plan::Freeze),
    /// Run the missing shards of a plan, or one shard.
    Run(run::Run),
    /// Submit the missing shards to Slurm as a job array, followed by the merge.
    Submit(submit::Submit),
    /// Print finished and missing shards, in the form of --array=.
    Status(status::Ask),
    /// Merge all shards, and draw the results.
    Merge(merge::Merge),
}

/// A sweep from its file to its page.
#[derive(Args)]
struct Whole {
    /// The sweep's file, TOML.
    #[arg(required = true)]
    file: Option<PathBuf>,
    #[command(flatten)]
    planned: plan::Planned,
    #[command(flatten)]
    output: Output,
    /// Also write CSV.
    #[arg(long)]
    csv: bool,
}

/// The folder of a plan.
#[derive(Args)]
pub struct OfPlan {
    /// Folder of the plan, or its plan.json.
    #[arg(long, value_name = "DIR")]
    pub plan: PathBuf,
}

/// The JSON output: a merged sweep.
#[derive(Serialize, JsonSchema)]
pub struct MergedPrinted<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// Results of the sweep.
    sweep: &'a Merged,
}

pub fn run(args: &Sweep, console: &Console) -> Result<ExitCode, Failure> {
    signals::listen();
    match &args.what {
        Some(What::Plan(args)) => plan::run(args, console),
        Some(What::Run(args)) => run::run(args, console),
        Some(What::Submit(args)) => submit::run(args, console),
        Some(What::Status(args)) => status::run(args, console),
        Some(What::Merge(args)) => merge::run(args, console),
        None => whole(&args.whole, console),
    }
}

fn whole(args: &Whole, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let file = args.file.as_deref().unwrap_or(Path::new(""));
    let (plan, _) = plan::planned(file, &args.planned, &args.output, false, console)?;
    let due = (0..plan.head.shards()).collect::<Vec<_>>();
    run::shards(&plan, &due, args.output.overwrite, console)?;
    let seconds = begin.elapsed().as_secs_f64();
    let merged = merge::merged(&plan, args.csv, seconds, console)?;
    let code = tell(&plan.folder, &merged, args.output.form.json, console)?;
    browser::show(args.output.open, &plan.folder, console);
    Ok(code)
}

fn tell(folder: &Path, merged: &Merged, json: bool, console: &Console) -> Result<ExitCode, Failure> {
    if json {
        print(&MergedPrinted { folder, sweep: merged })?;
    } else if !console.quiet {
        writeln!(stdout(), "{}\nresults in {}", swept_table(merged), folder.display())?;
    }
    Ok(ExitCode::SUCCESS)
}
