//! A linear model of a rod, for a controller.

use efam::failure::Failure;
use efam_core::linear::{Complex, DMatrix, LinearError, Modal, Signal, StateSpace};
use efam_experiments::scenario::Case;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::failure::exception;
use crate::overrides::quantity;

type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// Matrices of small motions about a rest, with names and units.
#[pyclass(frozen, module = "efam._efam")]
pub struct Linear {
    matrices: StateSpace,
    /// Of a continuous model.
    modal: Option<Modal>,
    states: Vec<Signal>,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    sample: Option<f64>,
    /// Of a reduced model.
    error_bound: Option<DMatrix<f64>>,
}

impl Linear {
    /// That of a case.
    pub fn of(case: &Case, inputs: &[String], outputs: &[String]) -> PyResult<Self> {
        let linear = case.linearise(inputs, outputs).map_err(failure)?;
        Ok(Self {
            matrices: linear.matrices,
            modal: Some(linear.modal),
            states: linear.states,
            inputs: linear.inputs,
            outputs: linear.outputs,
            sample: None,
            error_bound: None,
        })
    }

    fn modal(&self) -> PyResult<&Modal> {
        let message = "the model has samples already; begin with the continuous one";
        self.modal.as_ref().ok_or_else(|| exception(Failure::Usage(message.to_owned())))
    }

    /// The same signals with other matrices.
    fn with(&self, matrices: StateSpace, modal: Option<Modal>, sample: Option<f64>) -> Self {
        let [inputs, outputs] = [&self.inputs, &self.outputs].map(Clone::clone);
        Self { matrices, modal, states: self.states.clone(), inputs, outputs, sample, error_bound: None }
    }

    fn signals(&self) -> impl Iterator<Item = &Signal> {
        self.inputs.iter().chain(&self.outputs).chain(&self.states)
    }

    fn all<'py>(&self, py: Python<'py>) -> PyResult<[Matrix<'py>; 4]> {
        let StateSpace { a, b, c, d } = &self.matrices;
        Ok([array(py, a)?, array(py, b)?, array(py, c)?, array(py, d)?])
    }
}

#[pymethods]
impl Linear {
    /// States by states.
    #[getter(A)]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        array(py, &self.matrices.a)
    }

    /// States by inputs.
    #[getter(B)]
    fn b<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        array(py, &self.matrices.b)
    }

    /// Outputs by states.
    #[getter(C)]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        array(py, &self.matrices.c)
    }

    /// Outputs by inputs.
    #[getter(D)]
    fn d<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        array(py, &self.matrices.d)
    }

    /// Names of the states.
    #[getter]
    fn states(&self) -> Vec<String> {
        names(&self.states)
    }

    /// Names of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(&self.inputs)
    }

    /// Names of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(&self.outputs)
    }

    /// SI unit of each input, output and state.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.signals().map(|own| (&own.name, &own.unit)).into_py_dict(py)
    }

    /// Value of each input, output and state at the rest, from which the model counts.
    #[getter]
    fn at_rest<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.signals().map(|own| (&own.name, own.at_rest)).into_py_dict(py)
    }

    /// Poles of a continuous model, 1/s, slowest first; of a pair the one above the real axis.
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<Complex>>> {
        let poles = self.modal()?.poles().iter().map(|pole| pole.at).collect();
        Ok(PyArray1::from_vec(py, poles))
    }

    /// Outputs after long by inputs that stay, of a continuous model.
    #[getter]
    fn static_gain<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        array(py, &self.modal()?.static_gain())
    }

    /// Time between samples, s; none of a continuous model.
    #[getter]
    fn sample(&self) -> Option<f64> {
        self.sample
    }

    /// Largest error of a reduced model at any frequency, shape `[outputs, inputs]`; none of a whole one.
    #[getter]
    fn error_bound<'py>(&self, py: Python<'py>) -> PyResult<Option<Matrix<'py>>> {
        self.error_bound.as_ref().map(|bound| array(py, bound)).transpose()
    }

    /// The model with samples a time apart, such as 0.01 or "10 ms", inputs held between them.
    fn discrete(&self, dt: &Bound<'_, PyAny>) -> PyResult<Self> {
        let sample = quantity("dt", dt, "s")?;
        if !(sample > 0.0 && sample.is_finite()) {
            return Err(exception(Failure::Usage(format!("dt = {sample} s: must be longer than zero"))));
        }
        let discrete = self.with(self.modal()?.discrete(sample), None, Some(sample));
        Ok(Self { error_bound: self.error_bound.clone(), ..discrete })
    }

    /// The model with so many states, by balancing.
    fn reduce(&self, states: usize) -> PyResult<Self> {
        let reduced = self.modal()?.reduced(states).map_err(failure)?;
        let modal = reduced.matrices.modal().map_err(failure)?;
        let name = |k| Signal { name: format!("balanced_{k}"), unit: String::new(), at_rest: 0.0 };
        let states = (1..=states).map(name).collect();
        let error_bound = Some(reduced.error_bound);
        Ok(Self { states, error_bound, ..self.with(reduced.matrices, Some(modal), None) })
    }

    /// The same for python-control, with its names.
    fn to_control<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        // Dots would part a system from its signal there.
        let plain = |all: &[Signal]| all.iter().map(|own| own.name.replace('.', "_")).collect::<Vec<_>>();
        let [a, b, c, d] = self.all(py)?;
        let options = PyDict::new(py);
        for (key, all) in [("states", &self.states), ("inputs", &self.inputs), ("outputs", &self.outputs)] {
            options.set_item(key, plain(all))?;
        }
        optional(py, "control")?.getattr("ss")?.call((a, b, c, d, self.sample.unwrap_or(0.0)), Some(&options))
    }

    /// The same for scipy.
    fn to_scipy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [a, b, c, d] = self.all(py)?;
        let options = PyDict::new(py);
        if let Some(sample) = self.sample {
            options.set_item("dt", sample)?;
        }
        optional(py, "scipy.signal")?.getattr("StateSpace")?.call((a, b, c, d), Some(&options))
    }

    fn __repr__(&self) -> String {
        let kind = self.sample.map_or(String::new(), |sample| format!(", samples of {sample} s"));
        let [inputs, outputs] = [&self.inputs, &self.outputs].map(|all| names(all).join(", "));
        format!("<efam.Linear {inputs} to {outputs}: {} states{kind}>", self.states.len())
    }
}

fn names(all: &[Signal]) -> Vec<String> {
    all.iter().map(|own| own.name.clone()).collect()
}

fn array<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Matrix<'py>> {
    let rows = matrix.transpose().as_slice().to_vec();
    PyArray1::from_vec(py, rows).reshape([matrix.nrows(), matrix.ncols()])
}

/// A package that is an extra.
fn optional<'py>(py: Python<'py>, module: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("efam._extras")?.getattr("optional")?.call1((module,))
}

fn failure(error: LinearError) -> PyErr {
    exception(Failure::from(error))
}
