//! A text of a scenario with what is set over it.

use std::path::PathBuf;

use efam::failure::Failure;
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::{Case, Scenario};
use efam_store::input;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::failure::{ScenarioError, exception};
use crate::overrides::Laws;

/// The path that files are relative to, the text, and what is set over it: what a pickle holds.
pub type Parts = (PathBuf, String, Vec<String>);

/// A scenario of one run as it is written.
#[derive(Clone)]
pub struct Source {
    pub path: PathBuf,
    pub text: String,
    pub overrides: Vec<String>,
}

impl Source {
    /// Its one run, and the scenario that was read.
    pub fn case(&self) -> PyResult<(Case, Scenario)> {
        let scenario = Scenario::parse(&self.path, &self.text, &self.overrides).map_err(exception)?;
        if scenario.is_all_rows() {
            let message =
                "muscle.pressure = \"all rows\" is several runs; choose one, such as pressure=\"40 psi\"";
            return Err(exception(Failure::Usage(message.to_owned())));
        }
        let mut cases = scenario.cases().map_err(exception)?;
        Ok((cases.swap_remove(0), scenario))
    }

    /// Its laws as text.
    pub fn laws(&self) -> Laws<'_> {
        Laws::of(&self.path, &self.text, &self.overrides)
    }

    /// The same with more set over it. What is set again replaces what was set, so that a loop does not grow.
    pub fn with(&self, more: Vec<String>) -> Self {
        let key = |set: &String| set.split('=').next().unwrap_or_default().to_owned();
        let again: Vec<String> = more.iter().map(key).collect();
        let kept = self.overrides.iter().filter(|own| !again.contains(&key(own))).cloned();
        Self { overrides: kept.chain(more).collect(), ..self.clone() }
    }
}

/// Text of a scenario or an experiment, and the path that its files are relative to; `name` replaces that of a text.
pub fn read(given: &Bound<'_, PyAny>, name: &str) -> PyResult<(PathBuf, String)> {
    let is_text = given.cast::<PyString>().is_ok_and(|text| {
        let text = text.to_string_lossy();
        text.contains(['\n', '=']) || text.trim().is_empty()
    });
    if is_text {
        return Ok((PathBuf::from(name), given.extract()?));
    }
    let path: PathBuf = given.extract().map_err(|_| {
        PyTypeError::new_err(format!("{name}: a path, a text, a dict or an object of efam is due"))
    })?;
    let text = input::text(&path).map_err(|error| {
        let path = path.display();
        exception(Failure::Usage(format!("{path}: cannot be read ({error}); check the path")))
    })?;
    Ok((path, text))
}

/// The error of a file that is plainly of another kind than the one that is due, with the call that takes it; or else its
/// own.
pub fn of_kind(due: FileKind, given: &Bound<'_, PyAny>, error: PyErr) -> PyErr {
    // A text is no path of a file.
    let Ok(path) = given.extract::<PathBuf>() else { return error };
    let Some(found) = FileKind::of(&path).filter(|found| *found != due) else { return error };
    let call = match found {
        FileKind::Scenario => "efam.simulate",
        FileKind::Experiment => "efam.analyse",
        FileKind::Sweep => "efam.sweep",
        FileKind::Muscle => "efam.predict",
        FileKind::Laws => "laws=",
        FileKind::Recording => "efam.Experiment.init, which drafts an experiment, or efam.Recording",
        FileKind::Run => "efam.load",
    };
    ScenarioError::new_err(format!("{}: is {found}, and {due} is due; it is for {call}", path.display()))
}
