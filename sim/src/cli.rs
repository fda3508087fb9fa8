//! The command line: parse, call one function, print, exit code. The only file that names clap.

mod analyse;
mod calibrate;
mod diagnose;
mod effects;
mod experiment;
mod failure;
mod figures;
mod inspect;
mod interrupt;
mod live;
mod predict;
mod progress;
mod report;
mod rest;
mod simulate;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use live::Rerun;
use models::quantity::Quantity;
use sim::recording::{Length, ReadOptions};

/// Exit codes, as the help prints them.
const EXIT_CODES: &str = "Exit codes:
    0  all is well
    1  results could not be written or shown
    2  the command line or the scenario is wrong
    3  a muscle file, a recording or other data are wrong
    4  the simulation or the search for a rest posture could not go on
  130  interrupted; what was integrated is saved (a second Ctrl-C exits at once, and saves nothing)

Results and tables go to stdout; progress, warnings and errors to stderr. NO_COLOR is respected.";

/// A cantilevered fluidic artificial muscle, simulated in the time domain.
#[derive(Parser)]
#[command(name = "efam", version, after_help = EXIT_CODES, after_long_help = EXIT_CODES)]
struct Efam {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a scenario; the results go to a folder of their own.
    Simulate(Simulate),
    /// Find parameters of a model from the releases of an experiment.
    Calibrate(Calibrate),
    /// Find which physical effect the model lacks: scores, fits, judges, and repairs.
    Diagnose(Diagnose),
    /// Foretell what a calibrated muscle will do with a payload, with intervals.
    Predict(Predict),
    /// Put runs beside one another, on a page and in numbers.
    Report(report::Report),
    /// Redraw the paper's Figures 4 to 9 from runs of our own.
    Figures(figures::Figures),
    /// List the physical effects, or show the page of one.
    Effects {
        /// An effect.
        name: Option<String>,
        /// One JSON object instead.
        #[arg(long)]
        json: bool,
    },
    /// Write an experiment file from recordings, or check one: what is kept of its recordings.
    Experiment {
        #[command(subcommand)]
        what: OnExperiment,
    },
    /// Clean an experiment's recordings and analyse each release: frequency, damping, stiffness.
    Analyse {
        #[command(flatten)]
        of: Cleaning,
        /// Numbers of nodes with which to fit the tip at rest.
        #[arg(long, value_delimiter = ',', value_name = "N,…", default_values_t = sim::analysis::static_stiffness::NODES)]
        nodes: Vec<usize>,
    },
    /// Say what is in recordings of a motion-capture system.
    Inspect {
        /// Recordings: tables as text or Parquet, Vicon, Motive, Qualisys, TRC, C3D.
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        #[command(flatten)]
        overrides: Overrides,
        /// One JSON object instead.
        #[arg(long)]
        json: bool,
    },
    /// Show the posture in which a scenario's rod hangs.
    Statics {
        #[command(flatten)]
        source: Source,
        /// One JSON object instead.
        #[arg(long)]
        json: bool,
    },
    /// Show the small vibrations about the rest posture.
    Modes {
        #[command(flatten)]
        source: Source,
        /// How many, from the slowest.
        #[arg(long, default_value_t = 3, value_name = "N")]
        count: usize,
        /// One JSON object instead.
        #[arg(long)]
        json: bool,
    },
}

#[derive(Subcommand)]
enum OnExperiment {
    /// Write a first experiment file from the recordings themselves.
    Init(Init),
    /// Clean the recordings, and show what was cut, masked and decided.
    Check(Cleaning),
}

#[derive(Args)]
struct Init {
    /// Recordings, in any format that can be read.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The file to write.
    #[arg(long, value_name = "FILE", default_value = "experiment.toml")]
    out: PathBuf,
    /// Replace a file that is there.
    #[arg(long)]
    overwrite: bool,
}

/// An experiment, what is set over it, and where its results go.
#[derive(Args)]
struct OfExperiment {
    /// Experiment, a TOML file.
    experiment: PathBuf,
    /// Set a value over the experiment's, such as `recording[1].up="+z"`; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Folder for the results [default: outputs/ and the experiment's name].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace a folder that is there.
    #[arg(long)]
    overwrite: bool,
    /// One JSON object on stdout, and nothing else.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct Cleaning {
    #[command(flatten)]
    of: OfExperiment,
    /// List every decision, with the key that decides otherwise.
    #[arg(long)]
    decisions: bool,
}

/// A scenario and what is set over it.
#[derive(Args)]
struct Source {
    /// Scenario, a TOML file.
    scenario: PathBuf,
    /// Set a value over the scenario's, such as effects.payload.mass="50 g"; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Muscle file to use instead of the scenario's muscle.
    #[arg(long, value_name = "FILE")]
    muscle: Option<String>,
    /// Pressure to use instead of the scenario's, such as 40psi.
    #[arg(long)]
    pressure: Option<String>,
}

/// What stands above a recording's own statements.
#[derive(Args)]
struct Overrides {
    /// Unit of the positions: m, cm, mm, um, in or ft.
    #[arg(long)]
    unit: Option<Length>,
    /// Samples a second.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

impl Overrides {
    fn options(&self) -> ReadOptions {
        ReadOptions { unit: self.unit, rate_hz: self.rate }
    }
}

#[derive(Args)]
struct Simulate {
    #[command(flatten)]
    source: Source,
    /// Folder for the results [default: outputs/ and the scenario's name].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace a folder that is there.
    #[arg(long)]
    overwrite: bool,
    /// Also write CSV.
    #[arg(long)]
    csv: bool,
    /// One JSON object on stdout, and nothing else.
    #[arg(long)]
    json: bool,
    /// Show the rod in Rerun: save, spawn, connect, connect=URL or serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse)]
    rerun: Option<Rerun>,
    /// No progress, no table.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Args)]
struct Calibrate {
    #[command(flatten)]
    of: OfExperiment,
    /// Also find intervals by the profile of the likelihood, which takes longer.
    #[arg(long)]
    profile: bool,
    /// No progress, no table.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Args)]
struct Diagnose {
    #[command(flatten)]
    of: OfExperiment,
    /// Probability that a round names something where nothing is missing.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    false_alarm: f64,
    /// Effects added at most.
    #[arg(long, value_name = "COUNT", default_value_t = 3)]
    most: usize,
    /// Leave an effect out of the catalogue; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// The file is a scenario, a release that is not recorded yet: say which effects it could show, and
    /// from which size on.
    #[arg(long)]
    plan: bool,
    /// Another scenario of the plan; may be repeated.
    #[arg(long, value_name = "SCENARIO", requires = "plan")]
    also: Vec<PathBuf>,
    /// Noise of the camera that is planned.
    #[arg(long, value_name = "LENGTH", requires = "plan", default_value = "0.3 mm", value_parser = length)]
    noise: f64,
    /// A marker on the body that is planned, as a share of the length; may be repeated.
    #[arg(long, value_name = "SHARE", requires = "plan", value_parser = share)]
    marker: Vec<f64>,
    /// Show in Rerun how it goes on, and each release before and after: save, spawn, connect, connect=URL or
    /// serve.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse, conflicts_with = "plan")]
    rerun: Option<Rerun>,
    /// No progress, no table.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Args)]
struct Predict {
    /// Muscle file that a calibration wrote, or the name of a built-in muscle.
    #[arg(long, value_name = "FILE")]
    muscle: String,
    /// Pressure above ambient, such as 40psi.
    #[arg(long)]
    pressure: String,
    /// Mass at the tip.
    #[arg(long, value_name = "MASS", default_value = "0 g", allow_hyphen_values = true)]
    payload: String,
    /// Its centre of mass beyond the active length [default: at its end].
    #[arg(long, value_name = "LENGTH")]
    payload_center: Option<String>,
    /// Its rotary inertia about that, such as "1e-5 kg m^2" [default: a point mass].
    #[arg(long, value_name = "INERTIA")]
    payload_inertia: Option<String>,
    /// The area that it turns to the air, such as "20 cm^2".
    #[arg(long, value_name = "AREA")]
    frontal_area: Option<String>,
    /// Angle of the straight muscle above the horizontal, from which it is let go.
    #[arg(long, default_value = "0 deg", allow_hyphen_values = true)]
    angle: String,
    /// How long to simulate.
    #[arg(long, value_name = "TIME", default_value = "20 s")]
    duration: String,
    /// Set a value over the scenario's, such as effects.air_drag.drag_coefficient=1.1; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Draws from the errors of the calibration.
    #[arg(long, value_name = "COUNT", default_value_t = sim::predict::Settings::default().draws)]
    draws: usize,
    /// Of the random numbers.
    #[arg(long, default_value_t = sim::predict::Settings::default().seed)]
    seed: u64,
    /// Folder for the results [default: outputs/ and the case's name].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace a folder that is there.
    #[arg(long)]
    overwrite: bool,
    /// One JSON object on stdout, and nothing else.
    #[arg(long)]
    json: bool,
    /// No progress, no table.
    #[arg(short, long)]
    quiet: bool,
}

/// A length with its unit, m, more than nothing.
fn length(text: &str) -> Result<f64, String> {
    match Quantity::parse(text).and_then(|quantity| quantity.to("m")) {
        Ok(length) if length > 0.0 => Ok(length),
        Ok(_) => Err("it must be more than nothing, such as \"0.3 mm\"".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// A probability, not 0 and not 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("it must lie between 0 and 1, such as 0.01".to_owned()),
    }
}

impl Source {
    /// All overrides as `path=value`.
    fn overrides(&self) -> Vec<String> {
        let quoted = |path: &str, value: &Option<String>| {
            value.as_ref().map(|value| format!("{path}={}", serde_json::Value::from(value.as_str())))
        };
        let muscle = quoted("muscle.file", &self.muscle);
        let pressure = quoted("muscle.pressure", &self.pressure);
        muscle.into_iter().chain(pressure).chain(self.set.iter().cloned()).collect()
    }
}

pub fn main() -> ExitCode {
    let done = match Efam::parse().command {
        Command::Simulate(args) => simulate::run(&args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Diagnose(args) => diagnose::run(&args),
        Command::Predict(args) => predict::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Figures(args) => figures::run(&args),
        Command::Effects { name: None, json } => effects::list(json),
        Command::Effects { name: Some(name), json } => effects::page(&name, json),
        Command::Experiment { what: OnExperiment::Init(args) } => experiment::init(&args),
        Command::Experiment { what: OnExperiment::Check(args) } => experiment::check(&args),
        Command::Analyse { of, nodes } => analyse::run(&of, &nodes),
        Command::Inspect { files, overrides, json } => inspect::run(&files, &overrides.options(), json),
        Command::Statics { source, json } => rest::statics(&source, json),
        Command::Modes { source, count, json } => rest::modes(&source, count, json),
    };
    match done {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}
