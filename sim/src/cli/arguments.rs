//! What several commands are told in the same way.

use std::path::PathBuf;

use clap::{Args, ColorChoice};

/// How a command speaks: the same for all.
#[derive(Args)]
pub struct Manner {
    /// Neither progress nor tables; files, JSON, warnings and errors remain.
    #[arg(short, long, global = true, display_order = 1000)]
    pub quiet: bool,
    /// Say on stderr what is read, what is being done, and when.
    #[arg(short, long, global = true, display_order = 1001, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Whether to colour help and errors; auto: on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, display_order = 1002, value_name = "WHEN", default_value = "auto")]
    pub color: ColorChoice,
}

impl Manner {
    /// What `--color` says, before all else is read: what is wrong with the rest is coloured, too.
    pub fn color(mut arguments: impl Iterator<Item = String>) -> ColorChoice {
        while let Some(argument) = arguments.next() {
            let said = match argument.strip_prefix("--color") {
                Some("") => arguments.next(),
                Some(said) => said.strip_prefix('=').map(str::to_owned),
                None if argument == "--" => break,
                None => continue,
            };
            if let Some(Ok(choice)) = said.map(|said| said.parse()) {
                return choice;
            }
        }
        ColorChoice::Auto
    }
}

/// For people or for programs.
#[derive(Args)]
pub struct Form {
    /// One JSON object on stdout, and nothing else; `efam schema` describes it.
    #[arg(long)]
    pub json: bool,
}

/// Where results go, and what is printed of them.
#[derive(Args)]
pub struct Output {
    /// Folder for the results [default: a new one in outputs/, called after the time and what is run].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace a folder that is there.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    pub form: Form,
}

/// A scenario and what is set over it.
#[derive(Args)]
pub struct Source {
    /// Scenario, a TOML file.
    pub scenario: PathBuf,
    /// Set a value over the scenario's, such as effects.payload.mass="50 g"; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Muscle file to use instead of the scenario's muscle.
    #[arg(long, value_name = "FILE")]
    pub muscle: Option<String>,
    /// Pressure to use instead of the scenario's, such as 40psi.
    #[arg(long)]
    pub pressure: Option<String>,
}

impl Source {
    /// All overrides as `path=value`.
    pub fn overrides(&self) -> Vec<String> {
        let quoted = |path: &str, value: &Option<String>| {
            value.as_ref().map(|value| format!("{path}={}", serde_json::Value::from(value.as_str())))
        };
        let muscle = quoted("muscle.file", &self.muscle);
        let pressure = quoted("muscle.pressure", &self.pressure);
        muscle.into_iter().chain(pressure).chain(self.set.iter().cloned()).collect()
    }
}

/// An experiment, what is set over it, and where its results go.
#[derive(Args)]
pub struct OfExperiment {
    /// Experiment, a TOML file.
    pub experiment: PathBuf,
    /// Set a value over the experiment's, such as `recording[1].up="+z"`; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    pub output: Output,
}

/// An experiment whose recordings are cleaned.
#[derive(Args)]
pub struct Cleaning {
    #[command(flatten)]
    pub of: OfExperiment,
    /// List every decision, with the key that decides otherwise.
    #[arg(long)]
    pub decisions: bool,
}
