//! `efam sweep run`: the shards of a plan, or one of them.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::Args;
use efam_core::forward::Cancel;
use efam_store::escape::shell_word;
use efam_sweeps::cluster::array_place;
use efam_sweeps::plan::Plan;
use efam_sweeps::shard::{self, Told, run_all};
use efam_sweeps::status;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::arguments::Form;
use super::super::console::{Console, print};
use super::super::failure::Failure;
use super::super::interrupt;
use super::super::terminal::{say, stdout};
use super::OfPlan;

const HELP: &str = "Examples:
  efam sweep run --plan outputs/map
  efam sweep run --plan outputs/map --shard 3
  seq 0 9 | parallel efam sweep run --plan outputs/map --shard {}

Without --shard the place in a job array says which: SLURM_ARRAY_TASK_ID,
PBS_ARRAY_INDEX, SGE_TASK_ID (from 1 on) or AWS_BATCH_JOB_ARRAY_INDEX. Where
there is none, all shards that are missing are run. A shard that is there is
skipped. Killed at any moment, a shard is whole or not there.

Diagnoses run in parallel, one on each thread; a few of them share the threads.
The time of each is in seconds.csv beside its shard.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Run {
    #[command(flatten)]
    of: OfPlan,
    /// Only this shard, from 0 on.
    #[arg(long)]
    shard: Option<usize>,
    /// Replace shards of another plan.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    form: Form,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the plan is.
    folder: &'a Path,
    /// Shards that were run.
    run: Vec<usize>,
    /// Shards that were there already.
    skipped: usize,
    /// Points that have no answer, of those that were run.
    failed_points: usize,
}

pub fn run(args: &Run, console: &Console) -> Result<ExitCode, Failure> {
    let plan = Plan::open(&args.of.plan)?;
    let of_scheduler = match args.shard {
        Some(_) => None,
        None => array_place(|name| std::env::var(name).ok()).map_err(Failure::Usage)?,
    };
    if let Some((shard, name)) = of_scheduler {
        console.detail(format!("shard {shard}, by {name}"));
    }
    let due = match args.shard.or(of_scheduler.map(|own| own.0)) {
        Some(shard) => vec![shard],
        None => (0..plan.head.shards()).collect(),
    };
    let (run, failed_points) = shards(&plan, &due, args.overwrite, console)?;
    let skipped = due.len() - run.len();
    if args.form.json {
        print(&Printed { folder: &plan.folder, run, skipped, failed_points })?;
    } else if !console.quiet {
        let all = run.len();
        writeln!(
            stdout(),
            "{all} shards run, {skipped} were there already; {failed_points} points could not be {}\n\
             shards in {}",
            plan.head.work.done(),
            plan.folder.display()
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Runs those of some shards that are not there; returns which, and how many of their points have no answer.
pub fn shards(
    plan: &Plan,
    which: &[usize],
    overwrite: bool,
    console: &Console,
) -> Result<(Vec<usize>, usize), Failure> {
    let head = &plan.head;
    let mut due = Vec::new();
    for shard in which {
        if shard::is_due(plan, *shard, overwrite)? {
            due.push(*shard);
        }
    }
    let points: usize = due.iter().map(|shard| head.points_of(*shard).len()).sum();
    let threads = rayon::current_num_threads();
    console.detail(format!(
        "{}: {points} points to be {}, on {threads} threads",
        plan.folder.display(),
        head.work.done()
    ));
    let stages = console.steps(points, "points");
    let tell = |told| match told {
        Told::Point => stages.step(),
        Told::Shard(shard) => stages.told(&format!("shard {shard} is written")),
    };
    let work = || run_all(plan, &due, &Cancel::default(), &tell);
    let last_words = || {
        let (done, all) = (status::status(plan).shards_done, head.shards());
        let plan = shell_word(&plan.folder);
        say(format_args!(
            "interrupted: {done} of {all} shards are whole and kept; go on: efam sweep run --plan {plan}"
        ));
    };
    let ((), failed) = interrupt::during_or((), &stages, work, last_words);
    stages.clear();
    let failed = failed?;
    Ok((due, failed))
}
