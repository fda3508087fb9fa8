//! A run folder read back: what it is, its numbers, its scenario, the path of its tip.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use efam_experiments::summary::Summary;
use efam_inference::calibrate::Calibration;
use efam_inference::diagnose::Diagnosis;
use efam_recordings::{ReadOptions, RecordingError, read};
use efam_store::folder::MARK;
use efam_store::input::{MOST_JSON, up_to};
use efam_store::names::plain_name;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::calibrated::{CALIBRATION, EXPERIMENT};
use crate::diagnosed::DIAGNOSIS;
use crate::page::REPORT;
use crate::predicted::PREDICTION;
use crate::{PARQUET, SCENARIO};

/// A folder that cannot be read as a run.
#[derive(Debug, thiserror::Error)]
pub enum RereadError {
    /// There is none.
    #[error("{}: is no folder; give the folder of a run, such as outputs/…_release-15psi_…", folder.display())]
    NoFolder {
        /// What was given.
        folder: PathBuf,
    },
    /// A folder of other things.
    #[error(
        "{}: is no run, for it has no {MARK}; give a folder that efam simulate, calibrate, diagnose, predict or \
         analyse has written", folder.display()
    )]
    NoRun {
        /// What was given.
        folder: PathBuf,
    },
    /// A file of it cannot be read.
    #[error("{}: cannot be read ({source}); make the run again", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of it is not what efam writes.
    #[error("{}: is not what efam {} writes ({reason}); make the run again", file.display(), env!("CARGO_PKG_VERSION"))]
    Broken {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The trajectory.
    #[error(transparent)]
    Trajectory(#[from] RecordingError),
}

/// A run as its folder has it.
#[derive(Clone, Debug)]
pub struct Reread {
    /// The folder.
    pub folder: PathBuf,
    /// Name of the run.
    pub name: String,
    /// What was done, with its numbers.
    pub kind: RunKind,
    /// What it warned of.
    pub warnings: Vec<String>,
    /// The command.
    pub argv: Vec<String>,
    /// When it was written.
    pub written: String,
    /// SHA-256 of what it read, by name.
    pub hashes: BTreeMap<String, String>,
    /// Its scenario or experiment, key by key; of a set what all its runs share.
    pub keys: BTreeMap<String, String>,
    /// Whether it has a page of its own.
    pub has_page: bool,
}

/// What a run is.
#[derive(Clone, Debug)]
pub enum RunKind {
    /// A simulation.
    Simulation(Box<Simulated>),
    /// Simulations over pressure, each with its pressure, Pa.
    Set(Vec<(Option<f64>, Summary)>),
    /// A calibration.
    Calibration(Box<Calibration>),
    /// A diagnosis.
    Diagnosis(Box<Diagnosis>),
    /// A prediction, as its file has it.
    Prediction(Value),
    /// An analysis of an experiment, as its file has it.
    Analysis(Value),
    /// Something else, by its word: a check, a comparison.
    Other(String),
}

/// A simulation with the path of its tip.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Its numbers.
    pub summary: Summary,
    /// Times of its samples, s.
    pub times: Vec<f64>,
    /// Positions of its tip, m.
    pub tip: Vec<[f64; 2]>,
}

impl RunKind {
    /// Whether it comes from recordings, and its keys are those of an experiment.
    pub fn is_of_experiment(&self) -> bool {
        matches!(self, RunKind::Calibration(_) | RunKind::Diagnosis(_) | RunKind::Analysis(_))
    }

    /// What it is, in a word.
    pub fn word(&self) -> &str {
        match self {
            RunKind::Simulation(_) => "simulation",
            RunKind::Set(_) => "set of simulations",
            RunKind::Calibration(_) => "calibration",
            RunKind::Diagnosis(_) => "diagnosis",
            RunKind::Prediction(_) => "prediction",
            RunKind::Analysis(_) => "analysis",
            RunKind::Other(word) => word,
        }
    }
}

/// Reads the folder of a run.
/// # Errors
/// [`RereadError`].
pub fn reread(folder: &Path) -> Result<Reread, RereadError> {
    if !folder.is_dir() {
        return Err(RereadError::NoFolder { folder: folder.to_owned() });
    }
    let file = folder.join(MARK);
    if !file.is_file() {
        return Err(RereadError::NoRun { folder: folder.to_owned() });
    }
    let mark: Value = json(&file)?;
    let text = |key: &str| mark[key].as_str().unwrap_or_default().to_owned();
    let list = |key: &str| -> Vec<String> {
        let items = mark[key].as_array().into_iter().flatten();
        items.filter_map(|item| Some(item.as_str()?.to_owned())).collect()
    };
    let hash = |(name, hash): (&String, &Value)| Some((name.clone(), hash.as_str()?.to_owned()));
    let hashes = mark["inputs_sha256"].as_object().into_iter().flatten().filter_map(hash).collect();
    let (kind, keys) = match (mark["kind"].as_str(), mark["runs"].as_array()) {
        (Some("calibration"), _) => {
            (RunKind::Calibration(json(&folder.join(CALIBRATION))?), keys(&folder.join(EXPERIMENT))?)
        }
        (Some("diagnosis"), _) => {
            (RunKind::Diagnosis(json(&folder.join(DIAGNOSIS))?), keys(&folder.join(EXPERIMENT))?)
        }
        (Some("prediction"), _) => {
            (RunKind::Prediction(json(&folder.join(PREDICTION))?), keys(&folder.join(SCENARIO))?)
        }
        (Some("analysis"), _) => (RunKind::Analysis(mark.clone()), keys(&folder.join(EXPERIMENT))?),
        (Some("set") | None, Some(runs)) => set(folder, &file, runs)?,
        (Some(other), _) => (RunKind::Other(other.to_owned()), BTreeMap::new()),
        (None, None) => {
            (RunKind::Simulation(Box::new(simulated(folder, &mark)?)), keys(&folder.join(SCENARIO))?)
        }
    };
    let (mut warnings, argv, mut keys) = (list("warnings"), list("argv"), keys);
    // A scenario is written as it was run, an experiment as its file is.
    if kind.is_of_experiment() {
        let pairs = argv.windows(2).filter(|pair| pair[0] == "--set");
        let set = pairs.filter_map(|pair| pair[1].split_once('='));
        keys.extend(set.map(|(key, value)| (key.to_owned(), value.trim_matches('"').to_owned())));
    }
    if let RunKind::Set(runs) = &kind {
        let own = |(_, summary): &(Option<f64>, Summary)| summary.warnings.clone();
        warnings = runs.iter().flat_map(own).collect();
        warnings.dedup();
    }
    Ok(Reread {
        folder: folder.to_owned(),
        name: text("name"),
        warnings,
        argv,
        written: text("written_utc"),
        hashes,
        keys,
        has_page: folder.join(REPORT).is_file(),
        kind,
    })
}

fn load(file: &Path) -> Result<String, RereadError> {
    let unreadable = |source| RereadError::Unreadable { file: file.to_owned(), source };
    up_to(file, MOST_JSON).map_err(unreadable)
}

fn broken(file: &Path) -> impl Fn(&dyn std::fmt::Display) -> RereadError {
    let file = file.to_owned();
    move |reason| RereadError::Broken { file: file.clone(), reason: reason.to_string() }
}

fn json<T: DeserializeOwned>(file: &Path) -> Result<T, RereadError> {
    serde_json::from_str(&load(file)?).map_err(|error| broken(file)(&error))
}

fn simulated(folder: &Path, mark: &Value) -> Result<Simulated, RereadError> {
    let summary: Summary =
        serde_json::from_value(mark.clone()).map_err(|error| broken(&folder.join(MARK))(&error))?;
    // A run that failed at once has no path.
    if summary.samples < 2 {
        return Ok(Simulated { summary, times: Vec::new(), tip: Vec::new() });
    }
    let file = folder.join(PARQUET);
    let recording = read(&file, &ReadOptions::default())?;
    let tip = recording.markers.iter().find(|marker| marker.name == "tip");
    let Some(tip) = tip else { return Err(broken(&file)(&"it has no tip")) };
    let all = recording.time.iter().zip(&tip.position);
    let (times, tip) = all.filter_map(|(time, at)| at.map(|[x, _, z]| (*time, [x, z]))).unzip();
    Ok(Simulated { summary, times, tip })
}

/// A set, and the keys that its runs share.
fn set(
    folder: &Path,
    file: &Path,
    runs: &[Value],
) -> Result<(RunKind, BTreeMap<String, String>), RereadError> {
    let mut members: Vec<(Option<f64>, Summary)> = Vec::new();
    let mut shared: Option<BTreeMap<String, String>> = None;
    for run in runs {
        let summary: Summary =
            serde_json::from_value(run["run"].clone()).map_err(|error| broken(file)(&error))?;
        let own = keys(&folder.join(plain_name(&summary.name)).join(SCENARIO))?;
        let shared = shared.get_or_insert_with(|| own.clone());
        shared.retain(|key, value| own.get(key) == Some(value));
        members.push((run["pressure_pa"].as_f64(), summary));
    }
    Ok((RunKind::Set(members), shared.unwrap_or_default()))
}

/// A TOML file as one value for each path; nothing where it is not there.
fn keys(file: &Path) -> Result<BTreeMap<String, String>, RereadError> {
    if !file.is_file() {
        return Ok(BTreeMap::new());
    }
    let table: toml::Table = load(file)?.parse().map_err(|error: toml::de::Error| broken(file)(&error))?;
    let mut found = BTreeMap::new();
    flatten("", &toml::Value::Table(table), &mut found);
    found.remove("name");
    Ok(found)
}

fn flatten(path: &str, value: &toml::Value, found: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten(&path, value, found);
            }
        }
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            for (k, item) in items.iter().enumerate() {
                flatten(&format!("{path}[{}]", k + 1), item, found);
            }
        }
        toml::Value::String(text) => drop(found.insert(path.to_owned(), text.clone())),
        other => drop(found.insert(path.to_owned(), other.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_becomes_one_value_for_each_path() {
        let table: toml::Table =
            "a = 1\n[rod]\nlength = \"3 mm\"\nrow = [1, 2]\n[[recording]]\nfile = \"x\"\n[[recording]]\nfile = \"y\""
                .parse()
                .unwrap();
        let mut found = BTreeMap::new();
        flatten("", &toml::Value::Table(table), &mut found);
        let expected = [
            ("a", "1"),
            ("recording[1].file", "x"),
            ("recording[2].file", "y"),
            ("rod.length", "3 mm"),
            ("rod.row", "[1, 2]"),
        ];
        assert_eq!(found, expected.map(|(key, value)| (key.to_owned(), value.to_owned())).into());
    }
}
