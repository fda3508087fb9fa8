//! `efam report`: comparison of runs.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_report::Request;
use efam_report::aligned::{Aligned, Side};
use efam_report::compared::{Comparison, compare, write_comparison};
use efam_report::reread::{Reread, RereadError, reread};
use efam_store::folder::MARK;
use efam_store::input;
use models::digits::significant_or_dash;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Output, argv};
use super::browser;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::stdout;

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
    let mut names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let hash = |run: &PathBuf| {
        let file = run.join(MARK);
        Some((file.display().to_string(), input::sha256(&file).ok()?))
    };
    let request = Request {
        name: names.join(", "),
        input_hashes: args.runs.iter().filter_map(hash).collect(),
        argv: argv(),
        ..Request::default()
    };
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
    if args.output.form.json {
        print(&Printed { folder: &folder, comparison: &comparison })?;
    } else if !console.quiet {
        let mut out = stdout();
        tell(&mut out, &comparison)?;
        writeln!(out, "\nresults in {}", folder.display())?;
    }
    browser::show(args.output.open, &folder, console);
    Ok(ExitCode::SUCCESS)
}

fn tell(out: &mut impl Write, comparison: &Comparison) -> io::Result<()> {
    for run in &comparison.runs {
        writeln!(out, "{}  {}, {}", run.letter, run.name, run.kind)?;
    }
    let letters = || comparison.runs.iter().map(|run| run.letter.as_str());
    let with_heads = |side: Side| {
        let own = letters().map(|letter| (letter, side));
        Aligned::new(
            &[("", Side::Words)].into_iter().chain(own).chain([("", Side::Name)]).collect::<Vec<_>>(),
        )
    };
    let mut differences = with_heads(Side::Words);
    for of in &comparison.differences {
        let values = of.values.iter().map(|value| value.as_deref().unwrap_or("-"));
        differences.row([of.key.as_str()].into_iter().chain(values));
    }
    if !comparison.differences.is_empty() {
        write!(out, "\n{differences}")?;
    }
    let mut numbers = with_heads(Side::Number);
    let rows =
        [&comparison.quantities, &comparison.over_pressure, &comparison.predictions, &comparison.analyses];
    for row in rows.into_iter().flatten() {
        let values = row.values.iter().map(|value| significant_or_dash(*value, 4));
        numbers.row([row.name.clone()].into_iter().chain(values).chain([row.unit.clone()]));
    }
    for one in &comparison.parameters {
        let values = one.values.iter().map(|value| significant_or_dash(*value, 5));
        numbers.row([one.name.clone()].into_iter().chain(values).chain([one.unit.clone()]));
    }
    write!(out, "\n{numbers}")?;
    for of in &comparison.verdicts {
        writeln!(out, "{}  {}: {}", of.letter, of.verdict, of.effects.join(", "))?;
    }
    Ok(())
}

impl From<RereadError> for Failure {
    fn from(error: RereadError) -> Self {
        match error {
            RereadError::NoFolder { .. } | RereadError::NoRun { .. } => Failure::Usage(error.to_string()),
            error => Failure::Data(error.to_string()),
        }
    }
}
