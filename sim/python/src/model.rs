//! A scenario that is ready to run.

use std::path::PathBuf;

use efam::failure::Failure;
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::Case;
use efam_inference::predict::errors::Errors;
use models::muscle::Known;
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::failure::exception;
use crate::linear::Linear;
use crate::overrides::{Laws, overrides, tables};
use crate::run::{self, RunData};
use crate::source::{Parts, Source, of_kind, read};
use crate::swing::Swing;

/// A rod with its clamp, effects and release: a scenario of one run.
#[pyclass(frozen, module = "efam._efam")]
pub struct Model {
    source: Source,
    /// What pickles need beside the text: the muscle and posture that its files say.
    without_files: Vec<String>,
    /// How well a calibration knows its rod.
    known: Option<Known>,
    /// The one run of the scenario.
    pub case: Case,
}

impl Model {
    fn of(path: PathBuf, text: String, overrides: Vec<String>) -> PyResult<Self> {
        Self::of_source(Source { path, text, overrides })
    }

    fn of_source(source: Source) -> PyResult<Self> {
        let (case, scenario) = source.case()?;
        Ok(Self { source, without_files: scenario.without_files(), known: scenario.known().cloned(), case })
    }
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (source, /, **options))]
    fn new(source: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        if let Ok(model) = source.cast::<Model>() {
            let own = &model.get().source;
            return Self::of_source(own.with(overrides(options, &own.laws())?));
        }
        if let Ok(dict) = source.cast::<PyDict>() {
            let (path, own) = (PathBuf::from("scenario"), tables(dict, &Laws::default())?);
            let set = overrides(options, &Laws::of(&path, "", &own))?;
            return Self::of(path, String::new(), [own, set].concat());
        }
        let made = || {
            let (path, text) = read(source, "scenario")?;
            let set = overrides(options, &Laws::of(&path, &text, &[]))?;
            Self::of(path, text, set)
        };
        made().map_err(|error| of_kind(FileKind::Scenario, source, error))
    }

    /// The same model with something else.
    #[pyo3(signature = (**options))]
    fn replace(&self, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Self::of_source(self.source.with(overrides(options, &self.source.laws())?))
    }

    /// Simulates it.
    #[pyo3(signature = (*, error_estimate = true, sensitivities = Vec::new()))]
    fn run(&self, py: Python<'_>, error_estimate: bool, sensitivities: Vec<String>) -> PyResult<RunData> {
        run::run(py, &self.case, error_estimate, sensitivities)
    }

    /// The rod at its start, to be stepped.
    fn start(&self) -> PyResult<Swing> {
        Swing::of(self.source.clone())
    }

    /// The linear model about its rest, for a controller.
    #[pyo3(signature = (*, inputs = Vec::new(), outputs = vec!["tip_x".to_owned(), "tip_z".to_owned()], slipping = false))]
    fn linearise(
        &self,
        py: Python<'_>,
        inputs: Vec<String>,
        outputs: Vec<String>,
        slipping: bool,
    ) -> PyResult<Linear> {
        let case = self.case.clone();
        py.detach(|| Linear::of(&if slipping { case.slipping() } else { case }, &inputs, &outputs))
    }

    /// Models that the errors of its calibration admit, in SI units: their pressure is as it is.
    #[pyo3(signature = (count, *, seed = 1))]
    fn drawn(&self, py: Python<'_>, count: usize, seed: u64) -> PyResult<Vec<Self>> {
        let known = self.known.as_ref().ok_or_else(|| {
            let message =
                "has no [calibration], and its muscle none: take the rod.toml or muscle.toml of one";
            exception(Failure::Usage(format!("{}: {message}", self.case.name)))
        })?;
        let errors = Errors::new(known, &self.case);
        let texts: Vec<String> = py.detach(|| {
            let drawn = (0..count).into_par_iter().map(|draw| errors.drawn(seed, draw)).collect::<Vec<_>>();
            drawn.iter().flatten().map(|model| self.case.run_as(model, &self.case.run).resolved()).collect()
        });
        texts.into_iter().map(|text| Self::of(PathBuf::from("scenario"), text, Vec::new())).collect()
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
        let Source { path, text, overrides } = own.source.clone();
        Ok((restore.unbind(), (path, text, [overrides, own.without_files.clone()].concat())))
    }

    #[staticmethod]
    fn _restore(path: PathBuf, text: String, overrides: Vec<String>) -> PyResult<Self> {
        Self::of(path, text, overrides)
    }
}
