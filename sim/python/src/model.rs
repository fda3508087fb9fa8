//! A scenario that is ready to run.

use std::path::PathBuf;

use efam_experiments::scenario::{Case, Scenario};
use efam_store::input;
use numpy::PyArray1;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use sim::failure::Failure;

use crate::failure::exception;
use crate::overrides::{Laws, overrides, tables};
use crate::run::{self, RunData};
use crate::swing::Swing;

/// The path that files are relative to, the text, and what is set over it: what a pickle holds.
pub type Parts = (PathBuf, String, Vec<String>);

/// A rod with its clamp, effects and release: a scenario of one run.
#[pyclass(frozen, module = "efam._efam")]
pub struct Model {
    path: PathBuf,
    text: String,
    overrides: Vec<String>,
    /// What pickles need beside the text: the muscle and posture that its files say.
    without_files: Vec<String>,
    /// The one run of the scenario.
    pub case: Case,
}

impl Model {
    fn of(path: PathBuf, text: String, overrides: Vec<String>) -> PyResult<Self> {
        let scenario = Scenario::parse(&path, &text, &overrides).map_err(exception)?;
        if scenario.is_all_rows() {
            let message =
                "muscle.pressure = \"all rows\" is several runs; choose one, such as pressure=\"40 psi\"";
            return Err(exception(Failure::Usage(message.to_owned())));
        }
        let mut cases = scenario.cases().map_err(exception)?;
        let without_files = scenario.without_files();
        Ok(Self { path, text, overrides, without_files, case: cases.swap_remove(0) })
    }
}

/// Text of a scenario or an experiment, and the path that its files are relative to; `name` stands for that of a text.
pub fn source(given: &Bound<'_, PyAny>, name: &str) -> PyResult<(PathBuf, String)> {
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

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (source, /, **options))]
    fn new(source: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        if let Ok(model) = source.cast::<Model>() {
            return model.get().with(overrides(options, &model.get().laws())?);
        }
        if let Ok(dict) = source.cast::<PyDict>() {
            let (path, own) = (PathBuf::from("scenario"), tables(dict, &Laws::default())?);
            let set = overrides(options, &Laws::of(&path, "", &own))?;
            return Self::of(path, String::new(), [own, set].concat());
        }
        let (path, text) = self::source(source, "scenario")?;
        let set = overrides(options, &Laws::of(&path, &text, &[]))?;
        Self::of(path, text, set)
    }

    /// The same model with something else.
    #[pyo3(signature = (**options))]
    fn replace(&self, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.with(overrides(options, &self.laws())?)
    }

    /// Simulates it.
    #[pyo3(signature = (*, error_estimate = true, sensitivities = Vec::new()))]
    fn run(&self, py: Python<'_>, error_estimate: bool, sensitivities: Vec<String>) -> PyResult<RunData> {
        run::run(py, self, error_estimate, sensitivities)
    }

    /// The rod at its start, to be stepped.
    fn start(&self) -> PyResult<Swing> {
        Swing::of(self)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    /// What to know before its runs are used.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.case.warnings.clone()
    }

    /// Every parameter by its path, SI.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (parameter, value) in self.case.model.parameters.iter().zip(&self.case.model.theta) {
            dict.set_item(&parameter.path, *value)?;
        }
        Ok(dict)
    }

    /// The SI unit of every parameter by its path.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for parameter in &self.case.model.parameters {
            dict.set_item(&parameter.path, parameter.unit)?;
        }
        Ok(dict)
    }

    /// Times at which a run is sampled, s.
    #[getter]
    fn samples<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.case.run.samples)
    }

    /// The scenario in SI units with every default written out.
    #[getter]
    fn text(&self) -> String {
        self.case.resolved()
    }

    fn __getitem__(&self, path: &str) -> PyResult<f64> {
        let model = &self.case.model;
        let index = model.index(path).map_err(|error| PyKeyError::new_err(error.to_string()))?;
        Ok(model.theta[index])
    }

    fn __repr__(&self) -> String {
        let effects = self.case.model.exerting().join(", ");
        format!("<efam.Model {}: {effects}>", self.case.name)
    }

    /// Its text and what is set over it: a pickle needs no file.
    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, Parts)> {
        let restore = slf.py().get_type::<Model>().getattr("_restore")?;
        let own = slf.get();
        let set = [own.overrides.clone(), own.without_files.clone()].concat();
        Ok((restore.unbind(), (own.path.clone(), own.text.clone(), set)))
    }

    #[staticmethod]
    fn _restore(path: PathBuf, text: String, overrides: Vec<String>) -> PyResult<Self> {
        Self::of(path, text, overrides)
    }
}

impl Model {
    /// The path that its files are relative to, its text, and what is set over that.
    pub fn source(&self) -> Parts {
        (self.path.clone(), self.text.clone(), self.overrides.clone())
    }

    /// Its laws as text.
    fn laws(&self) -> Laws<'_> {
        Laws::of(&self.path, &self.text, &self.overrides)
    }

    /// The same with more set over it. What is set again replaces what was set, so that a loop does not grow.
    pub fn with(&self, more: Vec<String>) -> PyResult<Self> {
        let key = |set: &String| set.split('=').next().unwrap_or_default().to_owned();
        let again: Vec<String> = more.iter().map(key).collect();
        let kept = self.overrides.iter().filter(|own| !again.contains(&key(own))).cloned();
        Self::of(self.path.clone(), self.text.clone(), kept.chain(more).collect())
    }
}
