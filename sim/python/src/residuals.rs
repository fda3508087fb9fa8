//! Residuals of an experiment and their Jacobian, for solvers of Python.

use efam::failure::Failure;
use efam_inference::calibrate::problem;
use efam_inference::calibrate::residuals::{Evaluation, Residuals as Own};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::experiment::ExperimentData;
use crate::failure::exception;
use crate::watch::watched;

/// Residuals and Jacobian.
type Arrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Residuals of an experiment at any values of its unknowns.
#[pyclass(frozen, module = "efam._efam")]
pub struct ResidualsData {
    own: Own,
}

#[pymethods]
impl ResidualsData {
    #[new]
    fn new(py: Python<'_>, experiment: Py<ExperimentData>) -> PyResult<Self> {
        let own = experiment.get();
        let read = || -> Result<Own, Failure> {
            let (problem, _) = problem(&own.own, &own.cleaned()?)?;
            Ok(Own::of(problem)?)
        };
        Ok(Self { own: watched(py, |_| read())?.map_err(exception)? })
    }

    /// Name of each unknown.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.own.names.clone()
    }

    /// SI unit of each unknown.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.own.units.clone()
    }

    /// Where a search starts, SI.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.own.start)
    }

    /// Lowest and highest value of each unknown, as scipy takes them.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let end = |k: usize| self.own.bounds.iter().map(move |bounds| bounds[k]).collect();
        (PyArray1::from_vec(py, end(0)), PyArray1::from_vec(py, end(1)))
    }

    /// Residuals over the noise, and their derivatives, shape `[residuals, unknowns]`: some per cent off, or exact by a run
    /// more for each unknown.
    #[pyo3(signature = (theta, *, exact = false))]
    fn residuals_and_jacobian<'py>(
        &self,
        py: Python<'py>,
        theta: Vec<f64>,
        exact: bool,
    ) -> PyResult<Arrays<'py>> {
        let due = self.own.start.len();
        if theta.len() != due || !theta.iter().all(|value| value.is_finite()) {
            let message = format!("theta: {due} finite numbers are due, {} were given", theta.len());
            return Err(exception(Failure::Usage(message)));
        }
        let seen = watched(py, |_| self.own.at(&theta, exact))?.map_err(exception)?;
        let Some(Evaluation { residuals, jacobian }) = seen else {
            let message = "a release cannot be simulated at these values".to_owned();
            return Err(exception(Failure::Diverged(message)));
        };
        let shape = [residuals.len(), due];
        Ok((PyArray1::from_vec(py, residuals), PyArray1::from_vec(py, jacobian).reshape(shape)?))
    }
}
