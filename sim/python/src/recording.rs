//! Recordings: from files, or from columns of numbers.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use efam::failure::Failure;
use efam_recordings::{Length, ReadOptions, Recording};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::failure::exception;
use crate::watch::watched;

/// A recording as it was read.
#[pyclass(frozen, module = "efam._efam")]
pub struct RecordingData {
    /// Shared with the experiments that it is a part of.
    pub own: Arc<Recording>,
}

/// What the user knows better than the data.
fn options(
    unit: Option<String>,
    rate_hz: Option<f64>,
    columns: Option<Vec<String>>,
) -> PyResult<ReadOptions> {
    let length = |unit: String| {
        unit.parse::<Length>().map_err(|problem| exception(Failure::Usage(problem.to_string())))
    };
    Ok(ReadOptions { unit: unit.map(length).transpose()?, rate_hz, columns })
}

#[pymethods]
impl RecordingData {
    /// Reads a file.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        unit: Option<String>,
        rate: Option<f64>,
        columns: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let options = options(unit, rate, columns)?;
        let own = watched(py, |_| efam_recordings::read(&path, &options))?.map_err(exception)?;
        Ok(Self { own: own.into() })
    }

    /// Takes columns by the names that a tidy table has: numbers, or the type of something else.
    #[staticmethod]
    fn table(
        py: Python<'_>,
        name: &str,
        names: Vec<String>,
        columns: Vec<Column>,
        unit: Option<String>,
        rate: Option<f64>,
    ) -> PyResult<Self> {
        let options = options(unit, rate, None)?;
        let columns: Vec<_> = columns.into_iter().map(Column::numbers).collect();
        let mut lengths = columns.iter().flatten().map(Vec::len);
        let first = lengths.next().unwrap_or_default();
        if columns.len() != names.len() || lengths.any(|length| length != first) {
            let message = format!("{name}: a column of one length is due for each name");
            return Err(exception(Failure::Usage(message)));
        }
        let made = || efam_recordings::table(&names, &columns, Path::new(name), &options);
        Ok(Self { own: watched(py, |_| made())?.map_err(exception)?.into() })
    }

    /// The file, or the name that it was given.
    #[getter]
    fn source(&self) -> PathBuf {
        self.own.source.clone()
    }

    /// Which system wrote it.
    #[getter]
    fn format(&self) -> &'static str {
        self.own.format.name()
    }

    /// Samples a second.
    #[getter]
    fn rate(&self) -> f64 {
        self.own.rate_hz
    }

    /// Time of each sample, s.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.own.time)
    }

    /// Names of the markers.
    #[getter]
    fn markers(&self) -> Vec<String> {
        self.own.markers.iter().map(|marker| marker.name.clone()).collect()
    }

    /// Positions, m, shape `[samples, markers, 3]`; not a number where a marker was lost.
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let own = &self.own;
        let at = |k: usize| own.markers.iter().flat_map(move |own| own.position[k].unwrap_or([f64::NAN; 3]));
        let numbers: Vec<f64> = (0..own.time.len()).flat_map(at).collect();
        PyArray1::from_vec(py, numbers).reshape([own.time.len(), own.markers.len(), 3])
    }

    /// What was found and decided in reading.
    #[getter]
    fn findings(&self) -> Vec<String> {
        self.own.findings.clone()
    }
}

/// A column of a table.
#[derive(FromPyObject)]
enum Column {
    /// The type of what are no numbers.
    Kind(String),
    /// Numbers.
    Numbers(Vec<f64>),
}

impl Column {
    fn numbers(self) -> Result<Vec<f64>, String> {
        match self {
            Column::Numbers(numbers) => Ok(numbers),
            Column::Kind(kind) => Err(kind),
        }
    }
}
