//! `efam watch`: each recording of a folder is analysed as soon as it is saved, and one page is kept up to date.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use efam_experiments::analyse::{Analysed, analyse};
use efam_experiments::analysis::static_stiffness::NODES;
use efam_experiments::cleaning::clean;
use efam_experiments::experiment::Experiment;
use efam_experiments::kind::may_be_recording;
use efam_experiments::{gathered, init};
use efam_recordings::{ReadOptions, read};
use efam_report::experiment::write;
use efam_store::{Folder, input};
use models::quantity::Quantity;

use super::arguments::OfRecording;
use super::browser;
use super::console::Console;
use super::experiment::request;
use super::failure::Failure;
use super::terminal::{say, stdout};
use super::{interrupt, signals};

const HELP: &str = "Examples:
  efam watch recordings
  efam watch tracked --unit '0.42 mm' --columns t_s,x,y
  efam watch recordings --experiment beam.toml --out outputs/today --open

Facts about the recordings come from experiment.toml in the folder, or from
--experiment. A recording that it does not name has the facts of its last one.
Without such a file they are guessed, as `efam experiment init` does, and
--unit, --rate and --columns say how to read.

Ctrl-C ends it and keeps the page. Exit codes: 2 if there is no such folder or
the experiment file is wrong; that of the cause if the page could not be
written.";

/// Facts of a folder.
const EXPERIMENT: &str = "experiment.toml";
/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Watch {
    /// Folder in which recordings are saved.
    folder: PathBuf,
    /// Experiment whose facts the recordings share [default: experiment.toml in the folder, if it is there].
    #[arg(long, value_name = "FILE")]
    experiment: Option<PathBuf>,
    /// Folder of the page; a page of before is replaced [default: outputs/ and the folder's name with -watched].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How often to look; a recording counts once its size stays from one look to the next.
    #[arg(long, value_name = "TIME", default_value = "500 ms", value_parser = time)]
    every: Duration,
    #[command(flatten)]
    of: OfRecording,
    /// Show the page in the browser when it is first written.
    #[arg(long)]
    open: bool,
}

fn time(text: &str) -> Result<Duration, String> {
    match Quantity::parse(text).and_then(|quantity| quantity.to("s")) {
        Ok(time) if (0.01..=3600.0).contains(&time) => Ok(Duration::from_secs_f64(time)),
        Ok(_) => Err("it must lie in 10 ms..=1 h, such as \"500 ms\"".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// How a file looks from outside.
type Look = (u64, Option<SystemTime>);

/// A recording of the folder.
#[derive(Clone, Copy, Debug)]
struct Seen {
    look: Look,
    /// Whether it was analysed as it looks now.
    is_done: bool,
    /// Whether it is on the page.
    is_good: bool,
}

pub fn run(args: &Watch, console: &Console) -> Result<ExitCode, Failure> {
    let folder = &args.folder;
    if !folder.is_dir() {
        let shown = folder.display();
        return Err(Failure::Usage(format!(
            "{shown}: is no folder; give the one in which recordings are saved"
        )));
    }
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let name = whole.file_name().map_or_else(|| "recordings".into(), |name| name.to_string_lossy());
    let out = args.out.clone().unwrap_or_else(|| Path::new("outputs").join(format!("{name}-watched")));
    efam_store::folder::admit(&out, true)?;
    let facts = facts(args, &whole)?;
    signals::listen();
    if !console.quiet {
        say(format_args!("watching {}; the page goes to {}; Ctrl-C ends", folder.display(), out.display()));
    }
    let mut seen: BTreeMap<String, Seen> = BTreeMap::new();
    let mut is_open = args.open;
    // Why the page is not up to date; it is tried again at each look.
    let mut unwritten: Option<Failure> = None;
    while !signals::is_requested() {
        let ready = look(&whole, &mut seen);
        let is_news = !ready.is_empty();
        for file in ready {
            let said = until_signal(None, console, || said(&facts, &whole, &file));
            let is_good = tell(&file, said, console)?;
            if let Some(own) = seen.get_mut(&file) {
                (own.is_done, own.is_good) = (true, is_good);
            }
        }
        let good: Vec<String> =
            seen.iter().filter(|(_, own)| own.is_good).map(|(file, _)| file.clone()).collect();
        if (is_news || unwritten.is_some()) && !good.is_empty() && !signals::is_requested() {
            let before = unwritten.take().map(|failure| failure.to_string());
            match page(&facts, &whole, &good, &out, console) {
                Ok(()) => browser::show(std::mem::take(&mut is_open), &out, console),
                Err(failure) => {
                    if before != Some(failure.to_string()) {
                        console.warn([&failure]);
                    }
                    unwritten = Some(failure);
                }
            }
        }
        let until = Instant::now() + args.every;
        while Instant::now() < until && !signals::is_requested() {
            sleep(NOTICED.min(args.every));
        }
    }
    unwritten.map_or(Ok(ExitCode::SUCCESS), Err)
}

/// An experiment file and its text.
struct Facts {
    path: PathBuf,
    text: Option<String>,
    /// How recordings are read without an experiment file, which would state it.
    options: ReadOptions,
}

/// What is known of the recordings; the file is read once, and must be an experiment.
fn facts(args: &Watch, folder: &Path) -> Result<Facts, Failure> {
    let path = args.experiment.clone().unwrap_or_else(|| folder.join(EXPERIMENT));
    let options = args.of.options();
    if args.experiment.is_none() && !path.is_file() {
        return Ok(Facts { path, text: None, options });
    }
    if options.unit.is_some() || options.rate_hz.is_some() || options.columns.is_some() {
        return Err(Failure::Usage(format!(
            "{}: states how recordings are read; set unit, rate or columns in its [[recording]], and leave out --unit, \
             --rate and --columns",
            path.display()
        )));
    }
    let text = input::text(&path).map_err(|error| {
        Failure::Usage(format!("{}: cannot be read ({error}); check the path", path.display()))
    })?;
    Experiment::parse(&path, &text, &[])?;
    Ok(Facts { path, text: Some(text), options })
}

/// Files that can be recordings and stay as they are since the last look.
fn look(folder: &Path, seen: &mut BTreeMap<String, Seen>) -> Vec<String> {
    let mut ready = Vec::new();
    let mut there = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(name) = entry.file_name().into_string() else { continue };
        let is_recording = may_be_recording(Path::new(&name));
        let Ok(metadata) = entry.metadata() else { continue };
        if !is_recording || name.starts_with('.') || !metadata.is_file() || metadata.len() == 0 {
            continue;
        }
        let look = (metadata.len(), metadata.modified().ok());
        match seen.get(&name) {
            Some(own) if own.look == look => {
                if !own.is_done {
                    ready.push(name.clone());
                }
            }
            _ => drop(seen.insert(name.clone(), Seen { look, is_done: false, is_good: false })),
        }
        there.push(name);
    }
    seen.retain(|name, _| there.contains(name));
    ready.sort();
    ready
}

/// The experiment of some recordings.
fn experiment(facts: &Facts, folder: &Path, files: &[String]) -> Result<Experiment, Failure> {
    match &facts.text {
        Some(text) => {
            let beside = facts.path.parent() == Some(folder);
            let path = |file: &String| {
                if beside { file.clone() } else { folder.join(file).to_string_lossy().into_owned() }
            };
            Ok(gathered::experiment(&facts.path, text, &files.iter().map(path).collect::<Vec<_>>())?)
        }
        None => {
            let options = &facts.options;
            let mut recordings = Vec::new();
            for file in files {
                recordings.push((file.clone(), read(&folder.join(file), options)?));
            }
            let name = folder.file_name().map_or("".into(), |name| name.to_string_lossy());
            Ok(Experiment::parse(&facts.path, &init::draft(&name, &recordings, options), &[])?)
        }
    }
}

/// Does what takes long. On a signal nothing of a page that is being written is left, and the program ends as it should.
fn until_signal<T: Send>(page: Option<&Folder>, console: &Console, work: impl FnOnce() -> T + Send) -> T {
    let last_words = || {
        page.inspect(|page| page.give_up());
        std::process::exit(0);
    };
    interrupt::during_or((), &console.stages(), work, last_words).1
}

/// Analyses a recording, and returns its line.
fn said(facts: &Facts, folder: &Path, file: &str) -> Result<String, Failure> {
    let experiment = experiment(facts, folder, &[file.to_owned()])?;
    let cleaned = clean(&experiment)?;
    let analysed = analyse(&experiment, &cleaned, &NODES)?;
    Ok(analysed.iter().map(of_release).collect::<Vec<_>>().join("; "))
}

/// Prints the line of a recording; whether it can go on the page. What is wrong with it is its line.
fn tell(file: &str, said: Result<String, Failure>, console: &Console) -> Result<bool, Failure> {
    let (line, is_good) = match said {
        Ok(line) if line.is_empty() => ("no release is used".to_owned(), false),
        Ok(line) => (line, true),
        Err(failure) => (format!("not analysed: {failure}"), false),
    };
    if !console.quiet {
        writeln!(stdout(), "{file}: {line}")?;
        stdout().end()?;
    }
    Ok(is_good)
}

/// A release in a few words.
fn of_release(one: &Analysed) -> String {
    let name = format!("release {}", one.of.release.name.rsplit('#').next().unwrap_or_default());
    match &one.measured {
        Err(error) => format!("{name}: {error}"),
        Ok(measured) => {
            let frequency = match &measured.damped_frequency {
                Ok(omega) => format!("{:.3} Hz", omega / TAU),
                Err(why) => why.clone(),
            };
            let ratio = measured
                .decay
                .as_ref()
                .map_or(String::new(), |decay| format!(", damping ratio {:.4}", decay.damping_ratio));
            format!("{name}: {frequency}{ratio}")
        }
    }
}

/// Writes the page of all recordings.
fn page(
    facts: &Facts,
    folder: &Path,
    files: &[String],
    out: &Path,
    console: &Console,
) -> Result<(), Failure> {
    let begin = Instant::now();
    let read = || -> Result<_, Failure> {
        let experiment = experiment(facts, folder, files)?;
        let cleaned = clean(&experiment)?;
        Ok((experiment, cleaned))
    };
    let (experiment, cleaned) = until_signal(None, console, read)?;
    let analysed = until_signal(None, console, || analyse(&experiment, &cleaned, &NODES))?;
    let to = efam_store::folder::open(Some(out), true, &experiment.name, experiment.text())?;
    let request = || request(&experiment, begin);
    let written = || write(&to, &request(), &experiment, &cleaned, Some(&analysed));
    until_signal(Some(&to), console, written)?;
    to.finish()?;
    Ok(())
}
