//! `efam experiment init` and `check`: from recordings to releases.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_experiments::cleaning::{Cleaned, Decision, clean};
use efam_experiments::experiment::Experiment;
use efam_experiments::init;
use efam_experiments::kind::FileKind;
use efam_experiments::out_of_plane::{OverPressures, over_pressures};
use efam_report::Request;
use efam_report::experiment::{Row, decisions, input_hashes, table, write};
use efam_store::atomic::{write_new, write_whole};
use efam_store::disk::File;
use efam_store::escape::shell_word;
use efam_store::{Folder, StoreError};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Cleaning, Form, OfExperiment, OfRecording, argv};
use super::browser;
use super::console::{Console, Stages, print};
use super::failure::{Failure, of_kind};
use super::terminal::stdout;
use super::{interrupt, signals};

const INIT_HELP: &str = "Examples:
  efam experiment init 15psi.csv 20psi.csv
  efam experiment init trial.c3d --out beam.toml
  efam experiment init tracker.csv --unit m

Exit codes: 3 if a recording cannot be read.";

#[derive(Args)]
#[command(after_help = INIT_HELP)]
pub struct Init {
    /// Recordings, in any format that can be read.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The file to write.
    #[arg(long, value_name = "FILE", default_value = "experiment.toml")]
    out: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    of: OfRecording,
    #[command(flatten)]
    form: Form,
}

const CHECK_HELP: &str = "Examples:
  efam experiment check beam.toml
  efam experiment check beam.toml --decisions --out outputs/check
  efam experiment check beam.toml --set recording[1].up=\"+z\" --json

Exit codes: 2 for the experiment file, 3 for its recordings, 130 if it is
interrupted, which saves nothing.";

#[derive(Args)]
#[command(after_help = CHECK_HELP)]
pub struct Check {
    #[command(flatten)]
    cleaning: Cleaning,
}

/// The JSON output: a first experiment file.
#[derive(Serialize, JsonSchema)]
pub struct InitPrinted<'a> {
    /// The file.
    file: &'a Path,
    /// Recordings in it.
    recordings: usize,
    /// Lines with something that was guessed.
    guesses: usize,
    /// Lines with something that cannot be known from recordings.
    to_fill_in: usize,
}

/// The JSON output: cleaned recordings.
#[derive(Serialize, JsonSchema)]
pub struct CheckPrinted<'a> {
    /// Each release.
    releases: Vec<Row<'a>>,
    /// Distances of the tips from the vertical plane through the clamp's axis, over the pressures; none without a release.
    out_of_plane: Option<OverPressures>,
    /// Caveats of what a planar model says of these releases.
    warnings: Vec<String>,
    /// Decisions, each with the key that overrides it.
    decisions: &'a [Decision],
    /// Where the results are.
    folder: &'a Path,
}

impl<'a> CheckPrinted<'a> {
    pub fn of(cleaned: &'a Cleaned, folder: &'a Path) -> Self {
        let releases = cleaned.releases.iter().map(Row::of).collect();
        Self {
            releases,
            out_of_plane: over_pressures(cleaned.used().map(|used| &used.release)),
            warnings: cleaned.warnings(),
            decisions: &cleaned.decisions,
            folder,
        }
    }
}

/// Writes a first experiment file.
pub fn init(args: &Init, console: &Console) -> Result<ExitCode, Failure> {
    let out = &args.out;
    // Said before anything is read; what comes meanwhile is not replaced either.
    if out.exists() && !args.overwrite {
        return Err(StoreError::Exists { folder: out.clone() }.into());
    }
    let options = args.of.options();
    let mut recordings = Vec::new();
    for file in &args.files {
        console.detail(format!("reading {}", file.display()));
        recordings.push((
            relative(file, out)?,
            of_kind(FileKind::Recording, file, efam_recordings::read(file, &options))?,
        ));
    }
    let name = out.file_stem().map_or("".into(), |name| name.to_string_lossy());
    let text = init::draft(&name, &recordings, &options);
    // What is written can be read back, whatever names the recordings hold.
    Experiment::parse(out, &text, &[])?;
    let write = |file: &mut File| file.write_all(text.as_bytes());
    if args.overwrite {
        write_whole(out, write)?
    } else {
        write_new(out, write)?
    }
    // The head explains both words.
    let lines = || text.lines().skip_while(|line| line.starts_with('#'));
    let guesses = lines().filter(|line| line.contains("GUESS")).count();
    let unknown = lines().filter(|line| line.contains("FILL IN")).count();
    if args.form.json {
        print(&InitPrinted { file: out, recordings: recordings.len(), guesses, to_fill_in: unknown })?;
    }
    if args.form.json || console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    writeln!(
        stdout(),
        "{}: {} recording{}; look at {guesses} lines with GUESS and {unknown} with FILL IN, then\n  efam experiment check {}",
        out.display(),
        recordings.len(),
        if recordings.len() == 1 { "" } else { "s" },
        shell_word(out)
    )?;
    for line in text.lines().filter(|line| line.contains("# GUESS, ")) {
        writeln!(stdout(), "  {}", line.trim_start_matches("# "))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A recording's path as the experiment file names it: relative to that file where one is below the other.
fn relative(file: &Path, out: &Path) -> Result<String, Failure> {
    let folder = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let whole = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let (file_whole, folder) = (whole(file), whole(folder));
    let mut path = file_whole.clone();
    for (up, above) in folder.ancestors().enumerate() {
        // The root alone is no common ground.
        if above.parent().is_none() {
            break;
        }
        if let Ok(below) = file_whole.strip_prefix(above) {
            path = std::iter::repeat_n(Path::new(".."), up).collect::<PathBuf>().join(below);
            break;
        }
    }
    let text =
        path.to_str().map(|text| if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() });
    text.ok_or_else(|| {
        let file = file.display();
        Failure::Data(format!(
            "{file}: its path is not UTF-8, so an experiment file cannot name it; rename it"
        ))
    })
}

/// Cleans the recordings and shows what came of it.
pub fn check(args: &Check, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let args = &args.cleaning;
    let (experiment, folder) = open(&args.of, console)?;
    let stages = console.stages();
    let (folder, cleaned) = interrupt::during(folder, &stages, || read(&experiment, &stages));
    let cleaned = cleaned?;
    stages.tell("writing");
    let written = |folder: &Folder| write(folder, &request(&experiment, begin), &experiment, &cleaned, None);
    let folder = interrupt::finished(folder, &stages, written)?;
    stages.clear();
    console.warn(cleaned.warnings());
    if args.of.output.form.json {
        print(&CheckPrinted::of(&cleaned, &folder))?;
    }
    browser::show(args.of.output.open, &folder, console);
    if args.of.output.form.json || console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = stdout();
    table(&mut out, &cleaned)?;
    if args.decisions {
        decisions(&mut out, &cleaned)?;
    } else {
        writeln!(
            out,
            "{} decisions; --decisions lists them, with the keys that decide otherwise",
            cleaned.decisions.len()
        )?;
    }
    writeln!(out, "{}", folder.display())?;
    Ok(ExitCode::SUCCESS)
}

/// The command that read an experiment, and its inputs.
pub fn request(experiment: &Experiment, begin: Instant) -> Request {
    Request {
        name: experiment.name.clone(),
        resolved_scenario: experiment.text().to_owned(),
        input_hashes: input_hashes(experiment),
        argv: argv(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    }
}

/// Reads the experiment and opens the folder before the work, so that obstacles are reported first.
/// From here on Ctrl-C is listened to.
pub fn open(args: &OfExperiment, console: &Console) -> Result<(Experiment, Folder), Failure> {
    let experiment = load(args)?;
    let folder = claim(&experiment, args, console)?;
    Ok((experiment, folder))
}

/// Reads the experiment.
pub fn load(args: &OfExperiment) -> Result<Experiment, Failure> {
    let read = Experiment::load_with(&args.experiment, &args.set, &args.law);
    of_kind(FileKind::Experiment, &args.experiment, read)
}

/// Opens the folder of an experiment that was read.
pub fn claim(experiment: &Experiment, args: &OfExperiment, console: &Console) -> Result<Folder, Failure> {
    let (recordings, threads) = (experiment.recordings.len(), rayon::current_num_threads());
    let path = experiment.path.display();
    console.detail(format!("{path}: {recordings} recordings, on {threads} threads"));
    signals::listen();
    let (out, overwrite) = (args.output.out.as_deref(), args.output.overwrite);
    Ok(efam_store::folder::open(out, overwrite, &experiment.name, experiment.text())?)
}

/// Reads and cleans the recordings, and says what is kept of each.
pub fn read(experiment: &Experiment, stages: &Stages) -> Result<Cleaned, Failure> {
    stages.tell("reading and cleaning the recordings");
    let cleaned = clean(experiment)?;
    for (k, of) in cleaned.recordings.iter().enumerate() {
        let (samples, rate) = (of.recording.time.len(), of.recording.rate_hz);
        let releases = cleaned.releases.iter().filter(|release| release.recording == k).count();
        stages.tell(&format!("{}: {samples} samples at {rate:.1} Hz; releases: {releases}", of.name));
    }
    Ok(cleaned)
}
