//! `efam doctor`: what this program has, and what it finds around it.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::thread;

use clap::Args;
use efam_experiments::summary::Versions;
use efam_store::StoreError;
use efam_store::folder::OUTPUTS;
use models::effects::CATALOGUE;
use models::muscle::BUILT_IN;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Form;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::{say, stdout};
use crate::observe::VIEWER;

const HELP: &str = "Examples:
  efam doctor
  efam doctor --json

Exit codes: 1 if something that every run needs is broken. A missing viewer
is no error.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Doctor {
    #[command(flatten)]
    form: Form,
}

/// The state of this installation.
#[derive(Serialize, JsonSchema)]
pub struct Printed {
    /// Version of the program.
    efam: String,
    /// The compiler that built it.
    rustc: String,
    /// Machine and system that it was built for.
    target: String,
    /// What may be compiled in.
    features: Vec<Feature>,
    /// Threads that simulate at a time.
    threads: usize,
    /// Processors that this program may use.
    processors: Option<usize>,
    /// Muscles that are built in.
    muscles: Vec<String>,
    /// Physical effects in the catalogue.
    effects: usize,
    /// The Rerun viewer.
    viewer: Viewer,
    /// Where results go if nothing else is said.
    outputs: Outputs,
    /// Faults; empty if there are none.
    faults: Vec<String>,
}

/// A part of the program that may be left out when it is built.
#[derive(Serialize, JsonSchema)]
struct Feature {
    /// Its name, as cargo knows it.
    name: String,
    /// Whether it is there.
    compiled_in: bool,
    /// What it is for.
    what_for: String,
}

/// The viewer that `--rerun spawn` starts.
#[derive(Serialize, JsonSchema)]
struct Viewer {
    /// The only version that is sure to fit; none where the program was built without Rerun.
    needed: Option<String>,
    /// Version of the program `rerun` on the PATH; none where there is none or it does not say.
    found: Option<String>,
    /// Both in words.
    says: String,
}

/// Whether results can be written.
#[derive(Serialize, JsonSchema)]
struct Outputs {
    /// The folder.
    folder: String,
    /// Whether a run could be written into it.
    writable: bool,
}

pub fn run(args: &Doctor, console: &Console) -> Result<ExitCode, Failure> {
    let written = try_outputs();
    let found = looked_for();
    let Versions { efam, rustc, target } = Versions::here();
    let printed = Printed {
        efam,
        rustc,
        target,
        features: features(),
        threads: rayon::current_num_threads(),
        processors: thread::available_parallelism().ok().map(usize::from),
        muscles: BUILT_IN.iter().map(|(name, _)| (*name).to_owned()).collect(),
        effects: CATALOGUE.len(),
        viewer: viewer(cfg!(feature = "rerun"), found.as_deref()),
        outputs: Outputs {
            folder: std::path::absolute(OUTPUTS).unwrap_or_else(|_| OUTPUTS.into()).display().to_string(),
            writable: written.is_ok(),
        },
        faults: written.err().iter().map(ToString::to_string).collect(),
    };
    if args.form.json {
        print(&printed)?;
    } else if !console.quiet {
        table(&mut stdout(), &printed)?;
    }
    for fault in &printed.faults {
        say(format_args!("error: {fault}"));
    }
    Ok(if printed.faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn table(out: &mut impl Write, printed: &Printed) -> io::Result<()> {
    let mut line = |name: &str, text: &str| writeln!(out, "{name:<12}{text}");
    let Printed { efam, rustc, target, threads, .. } = printed;
    line("efam", &format!("{efam}, built by {rustc} for {target}"))?;
    for Feature { name, compiled_in, what_for } in &printed.features {
        let is_there = if *compiled_in { "compiled in" } else { "left out" };
        line("feature", &format!("{name}: {is_there} ({what_for})"))?;
    }
    let processors = printed.processors.map_or("unknown".to_owned(), |count| count.to_string());
    line("threads", &format!("{threads}, on {processors} processors; RAYON_NUM_THREADS sets them"))?;
    line("muscles", &printed.muscles.join(", "))?;
    line("effects", &format!("{}; efam effects lists them", printed.effects))?;
    line("viewer", &printed.viewer.says)?;
    let Outputs { folder, writable } = &printed.outputs;
    line("outputs", &format!("{folder} {} be written", if *writable { "can" } else { "cannot" }))?;
    line("", if printed.faults.is_empty() { "all is well" } else { "not all is well" })
}

fn features() -> Vec<Feature> {
    let feature = |name: &str, compiled_in, what_for: &str| Feature {
        name: name.to_owned(),
        compiled_in,
        what_for: what_for.to_owned(),
    };
    vec![
        feature("diffsol", cfg!(feature = "diffsol"), "the methods tr_bdf2 and esdirk34"),
        feature("rerun", cfg!(feature = "rerun"), "the live view, --rerun"),
        feature("rerun-web", cfg!(feature = "rerun-web"), "the live view as a web page, --rerun serve"),
    ]
}

/// Begins a run where runs go by default, and leaves no trace of it.
fn try_outputs() -> Result<(), StoreError> {
    let was_there = Path::new(OUTPUTS).exists();
    let tried =
        efam_store::folder::open(None, false, "doctor", "").and_then(|folder| folder.write("tried", b"well"));
    if !was_there {
        // Only if it is empty, as we would leave it.
        let _ = fs::remove_dir(OUTPUTS);
    }
    tried
}

/// Where the viewer would keep settings, which it writes at its first start: here it finds no folder, and leaves no trace.
const NO_SETTINGS: [(&str, &str); 2] = [("XDG_CONFIG_HOME", "/dev/null"), ("XDG_DATA_HOME", "/dev/null")];

/// What the program `rerun` on the PATH says of its version; nothing where there is none.
fn looked_for() -> Option<String> {
    let output = Command::new("rerun").arg("--version").envs(NO_SETTINGS).output().ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What is to be said of a viewer whose program says so of its version.
fn viewer(is_compiled_in: bool, said: Option<&str>) -> Viewer {
    let begins_as_one = |word: &&str| word.starts_with(|first: char| first.is_ascii_digit());
    let version = said.and_then(|said| said.split_whitespace().find(begins_as_one));
    let install = format!("pip install rerun-sdk=={VIEWER}");
    let says = match (is_compiled_in, said, version) {
        (false, ..) => "none is needed: this efam was built without Rerun".to_owned(),
        (true, None, _) => format!("no program `rerun` on the PATH; {install}"),
        (true, Some(_), None) => {
            format!("the program `rerun` on the PATH does not say its version; {install}")
        }
        (true, Some(_), Some(VIEWER)) => format!("{VIEWER}, as it should be"),
        (true, Some(_), Some(other)) => format!("{other}, but {VIEWER} is needed; {install}"),
    };
    Viewer { needed: is_compiled_in.then(|| VIEWER.to_owned()), found: version.map(str::to_owned), says }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_is_told_by_what_it_says() {
        let says = |is_compiled_in, said| viewer(is_compiled_in, said).says;
        let fitting = format!("rerun-cli {VIEWER} [rustc 1.93.0]");
        assert_eq!(says(true, Some(&fitting)), format!("{VIEWER}, as it should be"));
        assert!(says(true, Some("rerun_py 0.20.1")).starts_with("0.20.1, but "));
        assert!(says(true, Some("")).contains("does not say its version"));
        assert!(says(true, None).starts_with("no program `rerun`"));
        assert!(says(false, Some(&fitting)).starts_with("none is needed"));
        assert_eq!(viewer(true, Some(&fitting)).found.as_deref(), Some(VIEWER));
    }

    /// The library and the viewer must be of one version.
    #[test]
    fn the_viewer_that_is_asked_for_is_that_of_the_library() {
        let manifest = include_str!("../../../Cargo.toml");
        assert!(manifest.contains(&format!("rerun = {{ version = \"={VIEWER}\"")), "{VIEWER}");
        assert!(include_str!("../observe/rerun.rs").contains(&format!("rerun-sdk=={VIEWER}")));
    }
}
