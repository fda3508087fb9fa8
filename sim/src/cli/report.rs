//! `efam report`: comparison of runs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_report::Request;
use efam_report::compared::{Comparison, compare, comparison_table, request_of, write_comparison};
use efam_report::reread::{Reread, RereadError, reread};
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::answer;
use super::arguments::{Output, argv};
use super::console::Console;
use super::failure::Failure;

const HELP: &str = "Examples:
  efam report outputs/beam outputs/loaded-beam
  efam report outputs/a outputs/b --out outputs/a-and-b --json

Exit codes: 2 for a folder that is no run, 3 for one that cannot be read.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Report {
    /// Folders of runs: of simulate, calibrate, diagnose, predict, analyse.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the page is.
    folder: &'a Path,
    /// The comparison of the runs.
    comparison: &'a Comparison,
}

pub fn run(args: &Report, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let runs: Vec<Reread> = args.runs.iter().map(|run| reread(run)).collect::<Result<_, _>>()?;
    let comparison = compare(&runs);
    let request = Request { argv: argv(), ..request_of(&runs) };
    let asks = format!("{:?}", request.input_hashes);
    let folder = efam_store::folder::open(
        args.output.out.as_deref(),
        args.output.overwrite,
        &format!("report {}", request.name),
        &asks,
    )?;
    let request = Request { wall_time_s: begin.elapsed().as_secs_f64(), ..request };
    write_comparison(&folder, &request, &runs, &comparison)?;
    let folder = folder.finish()?;
    let printed = Printed { folder: &folder, comparison: &comparison };
    answer(&args.output, console, &folder, &printed, || comparison_table(&comparison))?;
    Ok(ExitCode::SUCCESS)
}

impl From<RereadError> for Failure {
    fn from(error: RereadError) -> Self {
        match error {
            RereadError::NoFolder { .. } | RereadError::NoRun { .. } => Failure::Usage(error.to_string()),
            error => Failure::Data(error.to_string()),
        }
    }
}
