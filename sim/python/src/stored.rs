//! Folders that were written before: read back, written again, compared, shown in motion.

use std::path::PathBuf;

use efam::failure::Failure;
use efam_report::calibrated::{CALIBRATION, table};
use efam_report::checked::{CHECK, check_table};
use efam_report::compared::{COMPARISON, compare, comparison_table, request_of, write_comparison};
use efam_report::diagnosed::{DIAGNOSIS, diagnosis_table};
use efam_report::export::{ExportError, Format, export, read};
use efam_report::linear::LINEAR;
use efam_report::predicted::{PREDICTION, prediction_table};
use efam_report::report::report;
use efam_report::reread::{Reread, RereadError, RunKind, reread};
use efam_store::columns::{Cells, Found, table as columns_of};
use efam_store::manifest::MANIFEST;
use efam_store::{MARK, folder};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;

use crate::answer::AnswerData;
use crate::failure::exception;

/// Kind, JSON and table of the answer that a folder has.
#[pyfunction]
pub fn loaded(py: Python<'_>, of: PathBuf) -> PyResult<(String, String, String)> {
    let work = || -> Result<_, Failure> {
        let own = reread(&of)?;
        let text = |name: &str| -> Result<String, Failure> {
            let file = of.join(name);
            let said = efam_store::input::text(&file);
            said.map_err(|error| Failure::Data(format!("{}: cannot be read ({error})", file.display())))
        };
        // A prediction is read as its file has it; a table takes more.
        fn printed<T: DeserializeOwned>(json: &str, table: fn(&T) -> String) -> String {
            serde_json::from_str(json).map_or_else(|_| json.to_owned(), |own| table(&own))
        }
        let (json, table) = match &own.kind {
            RunKind::Simulation(of) => (text(MARK)?, report(&of.summary)),
            RunKind::Calibration(found) => (text(CALIBRATION)?, table(found)),
            RunKind::Diagnosis(found) => (text(DIAGNOSIS)?, diagnosis_table(found)),
            RunKind::Prediction(_) => {
                let json = text(PREDICTION)?;
                (json.clone(), printed(&json, prediction_table))
            }
            RunKind::Analysis(_) => (text(MARK)?, text(MARK)?),
            RunKind::Other(word) if word == "prediction check" => {
                let json = text(CHECK)?;
                (json.clone(), printed(&json, check_table))
            }
            RunKind::Other(word) if word == "comparison" => (text(COMPARISON)?, text(COMPARISON)?),
            RunKind::Other(word) if word == "linear model" => (text(LINEAR)?, text(LINEAR)?),
            RunKind::Set(_) => {
                let message = format!("{}: has several runs; load one of the folders in it", of.display());
                return Err(Failure::Usage(message));
            }
            RunKind::Other(_) => (text(MARK)?, text(MARK)?),
        };
        Ok((own.kind.word().to_owned(), json, table))
    };
    py.detach(work).map_err(exception)
}

/// Columns of a file of Parquet by their names.
#[pyfunction]
pub fn columns<'py>(py: Python<'py>, file: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let found = py
        .detach(|| columns_of(&file))
        .map_err(|error| exception(Failure::Data(format!("{}: cannot be read ({error})", file.display()))))?;
    arrays(py, found)
}

/// The same of columns that were read.
pub fn arrays<'py>(py: Python<'py>, found: Vec<Found>) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for own in found {
        match own.cells {
            Cells::Numbers(numbers) => all.set_item(own.name, PyArray1::from_vec(py, numbers))?,
            Cells::Counts(counts) => all.set_item(own.name, PyArray1::from_vec(py, counts))?,
            Cells::Texts(texts) => all.set_item(own.name, texts)?,
        }
    }
    Ok(all)
}

/// Writes a folder whose files are known, as the program does: complete, or not at all.
#[pyfunction]
pub fn write_files(
    py: Python<'_>,
    name: &str,
    files: Vec<(String, Vec<u8>)>,
    out: Option<PathBuf>,
    overwrite: bool,
) -> PyResult<PathBuf> {
    let written = || -> Result<PathBuf, Failure> {
        let folder = folder::open(out.as_deref(), overwrite, name, name)?;
        for (name, bytes) in files.iter().filter(|(name, _)| name != MANIFEST) {
            folder.write(name, bytes)?;
        }
        Ok(folder.finish()?)
    };
    py.detach(written).map_err(exception)
}

/// Runs beside one another, by their folders.
#[pyfunction]
pub fn compare_runs(py: Python<'_>, folders: Vec<PathBuf>) -> PyResult<AnswerData> {
    let work = || -> Result<AnswerData, RereadError> {
        let runs: Vec<Reread> = folders.iter().map(|run| reread(run)).collect::<Result<_, _>>()?;
        let (comparison, request) = (compare(&runs), request_of(&runs));
        let text = comparison_table(&comparison);
        let entries = serde_json::to_value(&comparison).expect("a comparison has nothing that JSON has not");
        let write = move |folder: &_, request: &_| write_comparison(folder, request, &runs, &comparison);
        Ok(AnswerData::of(&entries, text, request, write))
    };
    py.detach(work).map_err(exception)
}

/// The rod of a run's folder in motion, as a GIF.
#[pyfunction]
pub fn animated(py: Python<'_>, of: PathBuf, to: PathBuf) -> PyResult<()> {
    let work = || export(&read(&of)?, Format::Gif, &to, false);
    py.detach(work).map_err(|error: ExportError| exception(Failure::from(error)))
}
