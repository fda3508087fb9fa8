//! `efam sweep plan`: every point, frozen.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use efam_experiments::kind::FileKind;
use efam_report::swept::{again, write_plan};
use efam_store::escape::shell_word;
use efam_sweeps::estimate::{points_for_a_cluster, time_of_a_point};
use efam_sweeps::plan::{self, Head, Plan};
use efam_sweeps::request::SweepRequest;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::arguments::{Output, argv};
use super::super::browser;
use super::super::console::{Console, print};
use super::super::failure::{Failure, of_kind};
use super::super::interrupt;
use super::super::terminal::stdout;

const HELP: &str = "Examples:
  efam sweep plan scenarios/sweep/payload-and-pressure.toml --out outputs/map
  efam sweep plan scenarios/sweep/latin-hypercube.toml --points-per-shard 500
  efam sweep plan bench/sweep.toml --out outputs/bench

The plan of a scenario needs no other file: its folder can be copied.
Experiments are read at their paths; one that was changed since becomes a row
with an error.
Each diagnosis has a shard of its own, and is not timed.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Freeze {
    /// The sweep's file, TOML.
    file: PathBuf,
    #[command(flatten)]
    planned: Planned,
    #[command(flatten)]
    output: Output,
}

/// The options of a plan beside its file.
#[derive(Args)]
pub struct Planned {
    /// Override a value of the file, such as sweep.points=64; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Points in a shard [default: 1, or as many as make a thousand shards].
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub points_per_shard: Option<u32>,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the plan is.
    folder: &'a Path,
    /// How many shards it has.
    shards: usize,
    /// Processor time of a point, as three were tried here; none for diagnoses, and for a plan that was there.
    seconds_per_point: Option<f64>,
    /// What it says beside its points.
    plan: &'a Head,
}

pub fn run(args: &Freeze, console: &Console) -> Result<ExitCode, Failure> {
    let (plan, time) = planned(&args.file, &args.planned, &args.output, true, console)?;
    let (folder, head) = (&plan.folder, &plan.head);
    let shards = head.shards();
    if args.output.form.json {
        let seconds_per_point = time.map(|time| time.as_secs_f64());
        print(&Printed { folder, shards, seconds_per_point, plan: head })?;
    } else if !console.quiet {
        let (name, points, own) = (&head.name, head.points, head.points_per_shard);
        let each =
            time.map_or(String::new(), |time| format!("; a point takes some {:.3} s", time.as_secs_f64()));
        let word = shell_word(folder);
        let mut out = stdout();
        writeln!(out, "{name}: {points} points, in {shards} shards of {own}{each}")?;
        writeln!(out, "here:       efam sweep run --plan {word}")?;
        writeln!(out, "on Slurm:   efam sweep submit --plan {word}")?;
        if let Some(points) = time.and_then(|time| points_for_a_cluster(own, time)) {
            writeln!(
                out,
                "            better planned with --points-per-shard {points}: half a minute a shard"
            )?;
        }
        writeln!(out, "plan in {}", folder.display())?;
    }
    browser::show(args.output.open, folder, console);
    Ok(ExitCode::SUCCESS)
}

/// The plan of a file: a new one, or that which is in the folder already. With how long a point takes, if that is
/// requested and the plan is new.
pub fn planned(
    file: &Path,
    own: &Planned,
    output: &Output,
    is_timed: bool,
    console: &Console,
) -> Result<(Plan, Option<Duration>), Failure> {
    let request = of_kind(FileKind::Sweep, file, SweepRequest::load(file, &own.set))?;
    console.warn(&request.warnings);
    let given = own.points_per_shard.map(|count| count as usize);
    let there = output.out.as_deref().filter(|out| out.join(plan::PLAN).is_file() && !output.overwrite);
    match there {
        Some(folder) => {
            let plan = again(&request, given, folder)?;
            console.detail(format!("{}: goes on", plan.folder.display()));
            Ok((plan, None))
        }
        None => new(&request, given, output, is_timed, console),
    }
}

fn new(
    request: &SweepRequest,
    given: Option<usize>,
    output: &Output,
    is_timed: bool,
    console: &Console,
) -> Result<(Plan, Option<Duration>), Failure> {
    let mut folder =
        efam_store::folder::open(output.out.as_deref(), output.overwrite, &request.name, &request.text)?;
    let stages = console.stages();
    let mut time = None;
    if is_timed {
        stages.tell("trying some points");
        let tried;
        (folder, tried) = interrupt::during(folder, &stages, || time_of_a_point(request));
        time = tried?;
    }
    stages.tell(&format!("freezing {} points", request.points()));
    let head = write_plan(&mut folder, request, given, argv())?;
    stages.clear();
    interrupt::check()?;
    Ok((Plan { folder: folder.finish()?, head }, time))
}
