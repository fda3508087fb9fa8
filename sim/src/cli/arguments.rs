//! Arguments that several commands share.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ColorChoice};
use efam_experiments::scenario::ReleaseOptions;
use efam_recordings::{Length, ReadOptions};
use efam_store::escape::toml_string;
use models::quantity::Quantity;

use super::failure::Failure;

/// The command line as results record it. Bytes that are not UTF-8 become `\xE9`.
pub fn argv() -> Vec<String> {
    std::env::args_os().map(recorded).collect()
}

fn recorded(argument: OsString) -> String {
    let mut text = String::new();
    for piece in argument.as_encoded_bytes().utf8_chunks() {
        text.push_str(piece.valid());
        piece.invalid().iter().for_each(|byte| text.push_str(&format!("\\x{byte:02X}")));
    }
    text
}

/// The verbosity of a command: the same for all.
#[derive(Args)]
pub struct Verbosity {
    /// Print neither progress nor tables; files, JSON, warnings and errors remain.
    #[arg(short, long, global = true, display_order = 1000)]
    pub quiet: bool,
    /// Print each step with its time on stderr.
    #[arg(short, long, global = true, display_order = 1001, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Whether to colour help and errors; auto: on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, display_order = 1002, value_name = "WHEN", default_value = "auto")]
    pub color: ColorChoice,
}

impl Verbosity {
    /// What `--color` says, before all else is read: what is wrong with the rest is coloured, too.
    pub fn color(arguments: impl Iterator<Item = OsString>) -> ColorChoice {
        let mut arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
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

/// What the person knows better than a recording's file.
#[derive(Args)]
pub struct OfRecording {
    /// Unit of the positions, where the file is silent or wrong: m, cm, mm, um, in, ft, or the length of a pixel such
    /// as "0.42 mm".
    #[arg(long)]
    unit: Option<Length>,
    /// Samples a second, where the file is silent or wrong.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// What the columns of a table hold, where its line of names is absent or wrong: such as t_s,x_mm,z_mm, with - for
    /// one to pass over.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Option<Vec<String>>,
}

impl OfRecording {
    pub fn options(&self) -> ReadOptions {
        ReadOptions { unit: self.unit, rate_hz: self.rate, columns: self.columns.clone() }
    }
}

/// For people or for programs.
#[derive(Args)]
pub struct Form {
    /// Print one JSON object on stdout; `efam schema` describes it.
    #[arg(long)]
    pub json: bool,
}

/// Where results go, and what is printed of them.
#[derive(Args)]
pub struct Output {
    /// Folder for the results [default: a new one in outputs/, named by time and input].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an existing folder.
    #[arg(long)]
    pub overwrite: bool,
    /// Show the page of the results in the browser; BROWSER may name one.
    #[arg(long)]
    pub open: bool,
    #[command(flatten)]
    pub form: Form,
}

/// A scenario and what is set over it.
#[derive(Args)]
pub struct Source {
    /// Scenario, a TOML file.
    pub scenario: PathBuf,
    /// Override a value of the scenario, such as effects.payload.mass="50 g"; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// A file of laws as text, beside those of the scenario; may be repeated. [effects.NAME] switches one on.
    #[arg(long, value_name = "FILE")]
    pub law: Vec<PathBuf>,
    /// Muscle file to use instead of the scenario's muscle.
    #[arg(long, value_name = "FILE")]
    pub muscle: Option<String>,
    /// Pressure to use instead of the scenario's, such as 40psi.
    #[arg(long)]
    pub pressure: Option<String>,
}

impl Source {
    /// All overrides as `path=value`.
    /// # Errors
    /// A value that is given twice.
    pub fn overrides(&self) -> Result<Vec<String>, Failure> {
        once("--muscle", self.muscle.as_ref(), "muscle.file", &self.set)?;
        once("--pressure", self.pressure.as_ref(), "muscle.pressure", &self.set)?;
        let quoted = |path: &str, value: &Option<String>| {
            value.as_ref().map(|value| format!("{path}={}", toml_string(value)))
        };
        let muscle = quoted("muscle.file", &self.muscle);
        let pressure = quoted("muscle.pressure", &self.pressure);
        Ok(muscle.into_iter().chain(pressure).chain(self.set.iter().cloned()).collect())
    }
}

/// Refuses an option beside a `--set` of the same key.
pub fn once(option: &str, value: Option<&String>, key: &str, set: &[String]) -> Result<(), Failure> {
    let is_of_key = |own: &&String| own.split('=').next().is_some_and(|path| path.trim() == key);
    match (value, set.iter().find(is_of_key)) {
        (Some(value), Some(set)) => {
            Err(Failure::Usage(format!("{option} {value} and --set {set} both give {key}; keep one of them")))
        }
        _ => Ok(()),
    }
}

/// The mass of a payload, such as `80g`, kg.
pub fn payload(text: Option<&String>, set: &[String]) -> Result<Option<f64>, Failure> {
    once("--payload", text, "effects.payload.mass", set)?;
    let mass = quantity("--payload", text, "kg")?;
    match (text, mass) {
        (Some(text), Some(mass)) if mass < 0.0 => {
            Err(Failure::Usage(format!("--payload {text}: it must not be negative")))
        }
        _ => Ok(mass),
    }
}

/// The value of an option in a unit.
pub fn quantity(option: &str, value: Option<&String>, unit: &str) -> Result<Option<f64>, Failure> {
    let Some(text) = value else { return Ok(None) };
    let parsed = Quantity::parse(text).and_then(|quantity| quantity.to(unit));
    parsed.map(Some).map_err(|error| Failure::Usage(format!("{option} {text}: {error}")))
}

/// The release, over what a scenario says; each command has the payload's mass, because some take several.
#[derive(Args)]
pub struct ReleaseArguments {
    /// Centre of mass of the payload beyond the active length [default: the scenario's, or at its end].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub payload_center: Option<String>,
    /// Rotary inertia of the payload about that, such as "1e-5 kg m^2" [default: the scenario's, or a point mass].
    #[arg(long, value_name = "INERTIA")]
    pub payload_inertia: Option<String>,
    /// Frontal area of the payload, such as "20 cm^2".
    #[arg(long, value_name = "AREA")]
    pub frontal_area: Option<String>,
    /// Angle above the horizontal from which it is let go; a rod whose clamp has another is held at its tip
    /// [default: the scenario's, or the clamp's].
    #[arg(long, allow_hyphen_values = true)]
    pub angle: Option<String>,
    /// How long to simulate [default: the scenario's, or 20 s].
    #[arg(long, value_name = "TIME")]
    pub duration: Option<String>,
}

impl ReleaseArguments {
    /// With a payload, such as `80g`, and beside what is set over the scenario.
    pub fn options(&self, mass: Option<&String>, set: &[String]) -> Result<ReleaseOptions, Failure> {
        let one = |option: &str, value: &Option<String>, key: &str, unit: &str| {
            once(option, value.as_ref(), key, set)?;
            quantity(option, value.as_ref(), unit)
        };
        let payload = payload(mass, set)?;
        Ok(ReleaseOptions {
            payload,
            payload_center: one(
                "--payload-center",
                &self.payload_center,
                "effects.payload.center_of_mass",
                "m",
            )?,
            payload_inertia: one(
                "--payload-inertia",
                &self.payload_inertia,
                "effects.payload.rotary_inertia",
                "kg m^2",
            )?,
            frontal_area: one("--frontal-area", &self.frontal_area, "effects.tip_drag.drag_area", "m^2")?,
            angle: one("--angle", &self.angle, "release.angle", "rad")?,
            duration: one("--duration", &self.duration, "run.duration", "s")?,
        })
    }
}

/// An experiment, what is set over it, and where its results go.
#[derive(Args)]
pub struct OfExperiment {
    /// Experiment, a TOML file.
    pub experiment: PathBuf,
    /// Override a value of the experiment, such as `recording[1].up="+z"`; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// A file of laws as text, beside those of the experiment; may be repeated.
    #[arg(long, value_name = "FILE")]
    pub law: Vec<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

/// An experiment whose recordings are cleaned.
#[derive(Args)]
pub struct Cleaning {
    #[command(flatten)]
    pub of: OfExperiment,
    /// List every decision, with the key that overrides it.
    #[arg(long)]
    pub decisions: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_argument_that_is_no_text_is_recorded_byte_by_byte() {
        use std::os::unix::ffi::OsStringExt;

        let argument = |bytes: &[u8]| recorded(OsString::from_vec(bytes.to_vec()));
        assert_eq!(argument(b"caf\xe9.csv"), "caf\\xE9.csv");
        assert_eq!(argument("café.csv".as_bytes()), "café.csv");
        assert_eq!(argument(b"\xff\xfe"), "\\xFF\\xFE");
    }
}
