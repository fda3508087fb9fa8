//! `efam sweep status`: what is there of a sweep, and what is missing.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::Args;
use efam_store::escape::shell_word;
use efam_sweeps::plan::Plan;
use efam_sweeps::status::{Status, status};
use schemars::JsonSchema;
use serde::Serialize;

use super::super::arguments::Form;
use super::super::console::{Console, print};
use super::super::failure::Failure;
use super::super::terminal::stdout;
use super::OfPlan;

const HELP: &str = "Examples:
  efam sweep status --plan outputs/map
  sbatch $(efam -q sweep status --plan outputs/map) outputs/map/array.sh

With --quiet only --array=… is printed, or nothing where nothing is missing.
The status follows from the files alone, also while shards run.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Ask {
    #[command(flatten)]
    of: OfPlan,
    #[command(flatten)]
    form: Form,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the plan is.
    folder: &'a Path,
    /// What is there.
    status: &'a Status,
}

pub fn run(args: &Ask, console: &Console) -> Result<ExitCode, Failure> {
    let plan = Plan::open(&args.of.plan)?;
    let status = status(&plan);
    if args.form.json {
        print(&Printed { folder: &plan.folder, status: &status })?;
        return Ok(ExitCode::SUCCESS);
    }
    console.warn(&status.faults);
    let mut out = stdout();
    if !console.quiet {
        let Status { points, shards, points_done, shards_done, .. } = &status;
        writeln!(
            out,
            "{}: {shards_done} of {shards} shards, {points_done} of {points} points",
            plan.head.name
        )?;
    }
    let folder = shell_word(&plan.folder);
    match (status.missing.is_empty(), console.quiet) {
        (false, true) => writeln!(out, "--array={}", status.missing_array)?,
        (false, false) => writeln!(out, "missing: --array={}", status.missing_array)?,
        (true, true) => {}
        (true, false) if status.is_merged => {
            writeln!(out, "merged: {folder}/{}", efam_sweeps::status::SWEEP)?
        }
        (true, false) => writeln!(out, "nothing is missing: efam sweep merge --plan {folder}")?,
    }
    Ok(ExitCode::SUCCESS)
}
