//! `efam sweep submit`: the missing shards as a Slurm job array, and the merge behind it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Args;
use efam_store::added;
use efam_store::disk::create_dir_all;
use efam_store::escape::shell_word;
use efam_store::names::plain_name;
use efam_sweeps::cluster::{array_script, job, merge_script};
use efam_sweeps::plan::Plan;
use efam_sweeps::status::status;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::arguments::Form;
use super::super::console::{Console, print};
use super::super::failure::Failure;
use super::super::terminal::stdout;
use super::OfPlan;

const HELP: &str = "Examples:
  efam sweep submit --plan outputs/map
  efam sweep submit --plan outputs/map -- --partition=short --time=10
  efam sweep submit --plan outputs/map --dry-run

What follows -- goes to sbatch as it is. The folder must be one that all
machines see. A member takes one processor, or as many as --cpus-per-task says.
The merge begins after any end of the array, since it would wait for ever
behind a member that failed; it checks that nothing is missing.";

/// The script of the array.
const ARRAY: &str = "array.sh";
/// That of the merge.
const MERGE: &str = "merge.sh";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Submit {
    #[command(flatten)]
    of: OfPlan,
    /// Write the scripts and print the command, but submit nothing.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    form: Form,
    /// Further options of sbatch.
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the plan is.
    folder: &'a Path,
    /// The shards that are handed in, as `sbatch --array=` takes them; empty if none is missing.
    array: String,
    /// The job; none where nothing was handed in.
    job: Option<String>,
    /// The job that merges, likewise.
    merge_job: Option<String>,
    /// The script of the array.
    script: PathBuf,
    /// That of the merge.
    merge_script: PathBuf,
}

pub fn run(args: &Submit, console: &Console) -> Result<ExitCode, Failure> {
    let plan = Plan::open(&args.of.plan)?;
    let here = |error: io::Error| Failure::Output(format!("{}: {error}", plan.folder.display()));
    let folder = fs::canonicalize(&plan.folder).map_err(here)?;
    let program = std::env::current_exe().map_err(here)?;
    let name = plain_name(&plan.head.name);
    let status = status(&plan);
    console.warn(&status.faults);
    let (script, merge) = (folder.join(ARRAY), folder.join(MERGE));
    let array_text = array_script(&name, &program, &folder).map_err(Failure::Usage)?;
    let merge_text = merge_script(&name, &program, &folder).map_err(Failure::Usage)?;
    for (name, text) in [(ARRAY, array_text), (MERGE, merge_text)] {
        added::add(&folder, name, |file| file.write_all(text.as_bytes()))?;
    }
    create_dir_all(&folder.join("log")).map_err(here)?;
    let array = status.missing_array.clone();
    let mut first = vec![format!("--array={array}")];
    first.extend(args.options.iter().cloned());
    let is_due = !status.missing.is_empty() && !args.dry_run;
    let own = is_due.then(|| sbatch(&first, &script)).transpose()?;
    let behind = |job: &String| sbatch(&[format!("--dependency=afterany:{job}")], &merge);
    let merge_job = own.as_ref().map(behind).transpose()?;
    if args.form.json {
        let (job, folder) = (own, &plan.folder);
        print(&Printed { folder, array, job, merge_job, script, merge_script: merge })?;
    } else if !console.quiet {
        let mut out = stdout();
        let (count, all) = (status.missing.len(), status.shards);
        match (&own, &merge_job) {
            (Some(own), Some(merge)) => {
                writeln!(out, "job {own}: {count} of {all} shards; job {merge} merges them")?;
                writeln!(out, "status: efam sweep status --plan {}", shell_word(&plan.folder))?;
            }
            _ if count == 0 => {
                writeln!(out, "nothing is missing: efam sweep merge --plan {}", shell_word(&plan.folder))?
            }
            _ => {
                writeln!(out, "{}", command(&first, &script))?;
                writeln!(out, "sbatch --dependency=afterany:JOB {}", shell_word(&merge))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The command that hands in a script, to be copied.
fn command(options: &[String], script: &Path) -> String {
    let words = options.iter().map(|option| shell_word(Path::new(option))).chain([shell_word(script)]);
    words.fold("sbatch".to_owned(), |command, word| format!("{command} {word}"))
}

/// Hands in a script, and returns the number of the job.
fn sbatch(options: &[String], script: &Path) -> Result<String, Failure> {
    let by_hand = format!("submit it yourself: {}", command(options, script));
    let output = Command::new("sbatch").arg("--parsable").args(options).arg(script).output();
    let output = output.map_err(|error| {
        Failure::Output(format!("sbatch: cannot be started ({error}); where Slurm is, {by_hand}"))
    })?;
    let (said, wrong) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    match job(&said).filter(|_| output.status.success()) {
        Some(job) => Ok(job.to_owned()),
        None => {
            let why = wrong.trim().replace('\n', "; ");
            Err(Failure::Output(format!("sbatch: submitted nothing ({why}); mend that, or {by_hand}")))
        }
    }
}
