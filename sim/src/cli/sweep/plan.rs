//! `efam sweep plan`: every point, frozen.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use serde::Serialize;
use sim::results::swept::swept_mark;
use sim::results::{self, MARK, Request};
use sim::schema::JsonSchema;
use sim::sweep::SweepError;
use sim::sweep::asked::Asked;
use sim::sweep::estimate::{microseconds_per_point, points_per_shard};
use sim::sweep::plan::{self, Head, Plan, freeze, head_text};
use sim::sweep::work::Work;

use super::super::arguments::Output;
use super::super::failure::Failure;
use super::super::interrupt;
use super::super::voice::{Voice, print};

const HELP: &str = "Examples:
  efam sweep plan scenarios/sweep/payload-and-pressure.toml --out outputs/map
  efam sweep plan scenarios/sweep/latin-hypercube.toml --points-per-shard 500
  efam sweep plan bench/sweep.toml --out outputs/bench

Of a scenario, the folder can be copied to where it is run: it needs no other
file. Experiments are read where they are, and each that was changed since is a
row that says so; a diagnosis is not tried, and has a shard of its own.";

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

/// What a plan is told beside its file.
#[derive(Args)]
pub struct Planned {
    /// Set a value over the file's, such as sweep.points=64; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Points in a shard [default: as many as half a minute of one processor takes].
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub points_per_shard: Option<u32>,
}

/// What is printed for programs.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the plan is.
    folder: &'a Path,
    /// How many shards it has.
    shards: usize,
    /// What it says beside its points.
    plan: &'a Head,
}

pub fn run(args: &Freeze, voice: &Voice) -> Result<ExitCode, Failure> {
    let plan = planned(&args.file, &args.planned, &args.output, voice)?;
    let (folder, head) = (&plan.folder, &plan.head);
    let shards = head.shards();
    if args.output.form.json {
        print(&Printed { folder, shards, plan: head })?;
    } else if !voice.quiet {
        let (name, points, own) = (&head.name, head.points, head.points_per_shard);
        let each = match head.work {
            Work::Simulate(_) => format!("points of some {:.3} s", 1e-6 * head.microseconds_per_point as f64),
            Work::Diagnose(_) => "experiments".to_owned(),
        };
        let folder = folder.display();
        let mut out = io::stdout().lock();
        writeln!(out, "{name}: {points} {each}, in {shards} shards of {own}")?;
        writeln!(out, "here:       efam sweep run --plan {folder}")?;
        writeln!(out, "on Slurm:   efam sweep submit --plan {folder}")?;
        writeln!(out, "plan in {folder}")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The plan of a file: a new one, or that which is in the folder already.
pub fn planned(file: &Path, own: &Planned, output: &Output, voice: &Voice) -> Result<Plan, Failure> {
    let asked = Asked::load(file, &own.set)?;
    voice.warn(&asked.warnings);
    let given = own.points_per_shard.map(|count| count as usize);
    let there = output.out.as_deref().filter(|out| out.join(plan::PLAN).is_file() && !output.overwrite);
    match there {
        Some(folder) => again(&asked, given, folder, voice),
        None => new(&asked, given, output, voice),
    }
}

/// The plan in a folder, if it is the one that is asked for.
fn again(asked: &Asked, given: Option<usize>, folder: &Path, voice: &Voice) -> Result<Plan, Failure> {
    let there = Plan::open(folder)?;
    let head = &there.head;
    let own = given.unwrap_or(head.points_per_shard);
    let asked = freeze(asked, own, head.microseconds_per_point, &mut io::sink())?;
    if asked.sha256 != head.sha256 {
        let folder = folder.display();
        return Err(Failure::Usage(format!(
            "{folder}: holds the sweep of another plan; choose another --out, or replace it with --overwrite"
        )));
    }
    voice.detail(format!("{}: goes on", folder.display()));
    Ok(there)
}

fn new(asked: &Asked, given: Option<usize>, output: &Output, voice: &Voice) -> Result<Plan, Failure> {
    let request = Request {
        name: asked.name.clone(),
        input_hashes: hashes(asked.texts()),
        warnings: asked.warnings.clone(),
        argv: std::env::args().collect(),
        ..Request::default()
    };
    let folder = results::open(output.out.as_deref(), output.overwrite, &asked.name, &asked.text)?;
    let stages = voice.stages();
    stages.tell("trying some points");
    let (folder, tried) = interrupt::during(folder, &stages, || microseconds_per_point(asked));
    let tried = tried?;
    let own = given.unwrap_or_else(|| points_per_shard(asked.points(), tried));
    stages.tell(&format!("freezing {} points", asked.points()));
    let mut head = None;
    let written = folder.write_with(plan::POINTS, |file| {
        let mut to = io::BufWriter::new(file);
        let frozen = freeze(asked, own, tried, &mut to);
        let is_frozen = frozen.is_ok();
        head = Some(frozen);
        if is_frozen { to.flush() } else { Err(io::Error::other("no plan")) }
    });
    stages.clear();
    let head = match head {
        Some(Err(error)) if !matches!(error, SweepError::Unwritten { .. }) => return Err(error.into()),
        Some(Ok(head)) => written.map(|()| head)?,
        _ => return Err(written.err().map_or(Failure::Interrupted, Failure::from)),
    };
    folder.write(plan::PLAN, head_text(&head).as_bytes())?;
    folder.write(MARK, swept_mark(&request).as_bytes())?;
    interrupt::check()?;
    Ok(Plan { folder: folder.finish()?, head })
}

/// What was read, by name.
pub fn hashes(texts: Vec<(&Path, &str)>) -> BTreeMap<String, String> {
    let hash = |(path, text): (&Path, &str)| (path.display().to_string(), results::sha256(text.as_bytes()));
    texts.into_iter().map(hash).collect()
}
