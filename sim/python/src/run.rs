//! A run with all its numbers.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Instant;

use efam::failure::Failure;
use efam::simulate;
use efam_core::accuracy::Settled;
use efam_core::forward::Cancel;
use efam_core::trajectory::Status;
use efam_experiments::scenario::Case;
use efam_experiments::table::Table;
use efam_report::Request;
use efam_report::report::report;
use efam_report::told::{Told, told};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::failure::exception;
use crate::watch::watched;

/// A run with its numbers.
#[pyclass(frozen, module = "efam._efam")]
pub struct RunData {
    case: Case,
    done: Settled,
    /// Paths of the parameters by which the tip is differentiated.
    sensitivities: Vec<String>,
    wall_time_s: f64,
    /// What a loop over parameters need not have, and would take a third of its time.
    about: OnceLock<(Request, Told)>,
}

/// Simulates a case.
pub fn run(py: Python<'_>, case: &Case, estimates: bool, by: Vec<String>) -> PyResult<RunData> {
    let mut case = case.clone();
    let index = |path: &String| case.model.index(path);
    let indices = by.iter().map(index).collect::<Result<_, _>>();
    case.run.sensitivities =
        indices.map_err(|error| exception(Failure::Usage(format!("sensitivities: {error}"))))?;
    watched(py, |cancel| finished(case, estimates, by, cancel))?.map_err(exception)
}

fn finished(case: Case, estimates: bool, by: Vec<String>, cancel: Cancel) -> Result<RunData, Failure> {
    let begin = Instant::now();
    let done = simulate::simulate(&case, estimates, cancel, &mut |_| ControlFlow::Continue(()))?;
    match &done.trajectory.status {
        Status::Complete => {}
        // Nothing but a signal cuts it short, and becomes the exception.
        Status::CutShort { .. } => return Err(Failure::Interrupted),
        Status::Failed { reason, .. } => return Err(Failure::Diverged(reason.clone())),
    }
    let wall_time_s = begin.elapsed().as_secs_f64();
    Ok(RunData { case, done, sensitivities: by, wall_time_s, about: OnceLock::new() })
}

impl RunData {
    fn about(&self, py: Python<'_>) -> &(Request, Told) {
        // Another thread may hold the lock of the cell, and wait for the global one.
        py.detach(|| self.about.get_or_init(|| self.summarised()))
    }

    fn summarised(&self) -> (Request, Told) {
        let (case, done) = (&self.case, &self.done);
        let warnings = simulate::warnings(case, done);
        let request = Request {
            name: case.name.clone(),
            resolved_scenario: self.text(),
            warnings: case.warnings.iter().cloned().chain(warnings).collect(),
            wall_time_s: self.wall_time_s,
            errors: done.errors.clone(),
            ..Request::default()
        };
        let told = told(&request, &done.model, &done.run, &done.trajectory);
        (request, told)
    }

    fn table(&self) -> Table<'_> {
        Table::new(&self.done.model, &self.done.trajectory, self.done.run.energy)
    }
}

#[pymethods]
impl RunData {
    /// Names of the columns, as in trajectory.parquet.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.table().columns().iter().map(|own| own.name.clone()).collect()
    }

    /// All numbers, shape `[samples, columns]`, handed over without a copy.
    fn data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = py.detach(|| self.table().numbers());
        let shape = [self.done.trajectory.times.len(), self.table().columns().len()];
        PyArray1::from_vec(py, numbers).reshape(shape)
    }

    /// Nodes of the mesh that was taken.
    #[getter]
    fn nodes(&self) -> usize {
        self.done.model.edges + 1
    }

    /// Derivatives of the tip's position by a parameter, m per SI unit, shape `[samples, 2]`.
    fn sensitivity<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let Some(k) = self.sensitivities.iter().position(|own| own == path) else { return Ok(None) };
        let rows = &self.done.trajectory.tip_by_parameters;
        let numbers: Vec<f64> = rows.iter().flat_map(|row| row[k]).collect();
        PyArray1::from_vec(py, numbers).reshape([rows.len(), 2]).map(Some)
    }

    /// What `efam simulate --json` prints of the run.
    #[getter]
    fn json(&self, py: Python<'_>) -> String {
        serde_json::to_string(&self.about(py).1.summary).expect("a summary has nothing that JSON has not")
    }

    /// What `efam simulate` prints of the run.
    #[getter]
    fn report(&self, py: Python<'_>) -> String {
        report(&self.about(py).1.summary)
    }

    /// What to know before the run is used.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> Vec<String> {
        self.about(py).0.warnings.clone()
    }

    /// The page of the run.
    fn page(&self, py: Python<'_>) -> String {
        let Settled { model, run, trajectory, .. } = &self.done;
        let (request, told) = self.about(py);
        py.detach(|| told.page(request, model, run, trajectory))
    }

    /// Paths of the parameters by which the tip is differentiated.
    #[getter]
    fn sensitivities(&self) -> Vec<String> {
        self.sensitivities.clone()
    }

    /// Writes the folder that the program writes; returns where it is.
    fn write(&self, py: Python<'_>, out: Option<PathBuf>, overwrite: bool, csv: bool) -> PyResult<PathBuf> {
        let Settled { model, run, trajectory, .. } = &self.done;
        let request = Request { out, overwrite, csv, ..self.about(py).0.clone() };
        let written = py.detach(|| efam_report::write(&request, model, run, trajectory));
        Ok(written.map_err(exception)?.folder)
    }

    /// The scenario that gives the same bits.
    #[getter]
    fn text(&self) -> String {
        self.case.run_as(&self.done.model, &self.done.run).resolved()
    }
}
