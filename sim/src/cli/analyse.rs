//! `efam analyse`: the paper's analysis of every release of an experiment.

use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_experiments::analyse::{Analysed, Said, analyse};
use efam_experiments::analysis::static_stiffness;
use efam_report::experiment::{analysed_table, decisions, table, write};
use efam_store::Folder;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Cleaning;
use super::browser;
use super::console::{Console, print};
use super::experiment::{CheckPrinted, open, read, request};
use super::failure::Failure;
use super::interrupt;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam analyse beam.toml
  efam analyse beam.toml --nodes 16,32,64 --decisions
  efam analyse beam.toml --out outputs/analysed --json

Exit codes: 2 for the experiment file, 3 for its recordings, 130 if it is
interrupted, which saves nothing.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Analyse {
    #[command(flatten)]
    cleaning: Cleaning,
    /// Numbers of nodes with which to fit the tip at rest.
    #[arg(long, value_delimiter = ',', value_name = "N,…", default_values_t = static_stiffness::NODES)]
    nodes: Vec<usize>,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    #[serde(flatten)]
    cleaned: CheckPrinted<'a>,
    /// Each release that is used.
    analysis: Vec<Said<'a>>,
}

pub fn run(args: &Analyse, console: &Console) -> Result<ExitCode, Failure> {
    let (args, nodes) = (&args.cleaning, &args.nodes);
    if let Some(wrong) = nodes.iter().find(|nodes| !(4..=2000).contains(*nodes)) {
        return Err(Failure::Usage(format!("--nodes {wrong}: must lie in 4..=2000")));
    }
    let begin = Instant::now();
    let (experiment, folder) = open(&args.of, console)?;
    let stages = console.stages();
    let (folder, cleaned) = interrupt::during(folder, &stages, || read(&experiment, &stages));
    let cleaned = cleaned?;
    stages.tell("frequency, damping and stiffness of each release");
    let (folder, analysed) = interrupt::during(folder, &stages, || analyse(&experiment, &cleaned, nodes));
    let analysed = analysed?;
    stages.tell("writing");
    let written =
        |folder: &Folder| write(folder, &request(&experiment, begin), &experiment, &cleaned, Some(&analysed));
    let folder = interrupt::finished(folder, &stages, written)?;
    stages.clear();
    console.warn(cleaned.warnings());
    if args.of.output.form.json {
        let analysis = analysed.iter().map(Analysed::said).collect();
        print(&Printed { cleaned: CheckPrinted::of(&cleaned, &folder), analysis })?;
    }
    browser::show(args.of.output.open, &folder, console);
    if args.of.output.form.json || console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = stdout();
    table(&mut out, &cleaned)?;
    if args.decisions {
        decisions(&mut out, &cleaned)?;
    }
    for one in &analysed {
        analysed_table(&mut out, one)?;
    }
    if !experiment.has_model() {
        writeln!(out, "\nno [rod] or [muscle] in the experiment: no stiffness is claimed")?;
    }
    writeln!(out, "\n{}", folder.display())?;
    Ok(ExitCode::SUCCESS)
}
