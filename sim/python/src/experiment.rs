//! Experiments: from a file, a text or tables, with recordings from files or from memory.

use std::path::{Path, PathBuf};

use efam::failure::Failure;
use efam_experiments::cleaning::{Cleaned, clean};
use efam_experiments::experiment::Experiment;
use efam_experiments::init;
use efam_experiments::kind::FileKind;
use efam_recordings::ReadOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::failure::exception;
use crate::overrides::{Laws, tables};
use crate::recording::RecordingData;
use crate::source::{of_kind, read};
use crate::watch::watched;

/// What takes the place of the name of a file.
const NAME: &str = "experiment";

/// A recording in memory, and the end of the path that the experiment has for it.
type Held = (String, Py<RecordingData>);

/// An experiment that was read and checked.
#[pyclass(frozen, module = "efam._efam")]
pub struct ExperimentData {
    path: PathBuf,
    text: String,
    overrides: Vec<String>,
    /// As the library has it, with the recordings in memory.
    pub own: Experiment,
}

impl ExperimentData {
    fn of(
        path: PathBuf,
        text: String,
        overrides: Vec<String>,
        held: Vec<(PathBuf, std::sync::Arc<efam_recordings::Recording>)>,
    ) -> PyResult<Self> {
        let own = Experiment::parse(&path, &text, &overrides).map_err(exception)?.holding(held);
        Ok(Self { path, text, overrides, own })
    }

    /// What is set over its text.
    pub fn overrides(&self) -> &[String] {
        &self.overrides
    }

    /// Its releases.
    pub fn cleaned(&self) -> Result<Cleaned, Failure> {
        Ok(clean(&self.own)?)
    }
}

fn shared(held: Vec<Held>) -> Vec<(PathBuf, std::sync::Arc<efam_recordings::Recording>)> {
    held.into_iter().map(|(end, data)| (PathBuf::from(end), data.get().own.clone())).collect()
}

/// Tables as the text of a file.
fn written(of: &Bound<'_, PyDict>) -> PyResult<String> {
    let lines = tables(of, &Laws::default())?;
    let is_key = |line: &String| {
        let path = line.split('=').next().unwrap_or_default();
        path.split('.').all(|key| {
            !key.is_empty() && key.chars().all(|own| own.is_ascii_alphanumeric() || "_-".contains(own))
        })
    };
    match lines.iter().find(|line| !is_key(line)) {
        None => Ok(lines.iter().map(|line| format!("{line}\n")).collect()),
        Some(line) => {
            let key = efam_store::escape::escaped(line.split('=').next().unwrap_or_default()).into_owned();
            let message = format!("{NAME}: {key}: no key; keys have letters, digits, _ and -");
            Err(exception(Failure::Usage(message)))
        }
    }
}

#[pymethods]
impl ExperimentData {
    #[new]
    fn new(of: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>, held: Vec<Held>) -> PyResult<Self> {
        let held = shared(held);
        if let Ok(dict) = of.cast::<PyDict>() {
            let (path, text) = (PathBuf::from(NAME), written(dict)?);
            let set = tables(options, &Laws::of(&path, &text, &[]))?;
            return Self::of(path, text, set, held);
        }
        let made = || {
            let (path, text) = read(of, NAME)?;
            let set = tables(options, &Laws::of(&path, &text, &[]))?;
            Self::of(path, text, set, held)
        };
        made().map_err(|error| of_kind(FileKind::Experiment, of, error))
    }

    /// The same with more set over it. What is set again replaces what was set.
    fn replace(&self, options: &Bound<'_, PyDict>, held: Vec<Held>) -> PyResult<Self> {
        let more = tables(options, &Laws::of(&self.path, &self.text, &self.overrides))?;
        let key = |set: &String| set.split('=').next().unwrap_or_default().to_owned();
        let again: Vec<String> = more.iter().map(key).collect();
        let kept = self.overrides.iter().filter(|own| !again.contains(&key(own))).cloned();
        let all = self.own.held().iter().cloned().chain(shared(held)).collect();
        Self::of(self.path.clone(), self.text.clone(), kept.chain(more).collect(), all)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.own.name
    }

    /// Its text, without what is set over it.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    /// What is set over its text.
    #[getter]
    fn settings(&self) -> Vec<String> {
        self.overrides.clone()
    }

    /// Name of each recording.
    #[getter]
    fn recordings(&self) -> Vec<String> {
        self.own.recordings.iter().map(|entry| entry.name.clone()).collect()
    }

    /// Whether it has a model.
    #[getter]
    fn has_model(&self) -> bool {
        self.own.has_model()
    }
}

/// The text of a first experiment, as `efam experiment init` writes it.
#[pyfunction]
pub fn first_experiment(py: Python<'_>, name: &str, recordings: Vec<Held>) -> PyResult<String> {
    let own: Vec<_> = recordings.iter().map(|(file, data)| (file, data.get())).collect();
    let read: Vec<_> = own.iter().map(|(file, data)| ((*file).clone(), (*data.own).clone())).collect();
    let text = watched(py, |_| init::draft(name, &read, &ReadOptions::default()))?;
    // What is written can be read back, whatever names the recordings hold.
    Experiment::parse(Path::new(NAME), &text, &[]).map_err(exception)?;
    Ok(text)
}
