//! Answers: what the program's commands print and write.

use std::path::PathBuf;

use efam::failure::Failure;
use efam_report::Request;
use efam_report::experiment::input_hashes;
use efam_store::{Folder, StoreError};
use pyo3::prelude::*;
use serde::Serialize;

use crate::experiment::ExperimentData;
use crate::failure::exception;

/// Writes the files of an answer into an open folder.
type Write = dyn Fn(&Folder, &Request) -> Result<(), StoreError> + Send + Sync;

/// What a command says: its JSON, its table, its folder.
#[pyclass(frozen, module = "efam._efam")]
pub struct AnswerData {
    json: String,
    table: String,
    /// Files with a calibrated model, by name.
    models: Vec<(String, String)>,
    request: Request,
    /// None of an answer that is printed and never written.
    write: Option<Box<Write>>,
}

impl AnswerData {
    /// By what is printed as JSON and for people, and by what writes the folder.
    pub fn of(
        answer: &impl Serialize,
        table: String,
        request: Request,
        write: impl Fn(&Folder, &Request) -> Result<(), StoreError> + Send + Sync + 'static,
    ) -> Self {
        Self { request, write: Some(Box::new(write)), ..Self::printed(answer, table) }
    }

    /// One that the program prints, and writes to no folder.
    pub fn printed(answer: &impl Serialize, table: String) -> Self {
        let json = serde_json::to_string(answer).expect("an answer has nothing that JSON has not");
        Self { json, table, models: Vec::new(), request: Request::default(), write: None }
    }

    /// The same with files of a calibrated model.
    pub fn with_models(self, models: Vec<(String, String)>) -> Self {
        Self { models, ..self }
    }
}

/// What the folder of an experiment's answer says of its making.
pub fn request_of(experiment: &ExperimentData, warnings: &[String], wall_time_s: f64) -> Request {
    Request {
        name: experiment.own.name.clone(),
        resolved_scenario: experiment.own.text().to_owned(),
        warnings: warnings.to_vec(),
        input_hashes: input_hashes(&experiment.own),
        wall_time_s,
        ..Request::default()
    }
}

#[pymethods]
impl AnswerData {
    /// What is printed with `--json`, without the folder.
    #[getter]
    fn json(&self) -> &str {
        &self.json
    }

    /// What is printed for people.
    #[getter]
    fn table(&self) -> &str {
        &self.table
    }

    /// Files with a calibrated model: name and text.
    #[getter]
    fn models(&self) -> Vec<(String, String)> {
        self.models.clone()
    }

    /// Whether it has a folder.
    #[getter]
    fn has_folder(&self) -> bool {
        self.write.is_some()
    }

    /// Writes the folder that the program writes; returns where it is.
    fn write(&self, py: Python<'_>, out: Option<PathBuf>, overwrite: bool) -> PyResult<PathBuf> {
        let Some(write) = &self.write else {
            let message = "write: the program writes no folder of this; str() and the entries are all of it";
            return Err(exception(Failure::Usage(message.to_owned())));
        };
        let request = Request { out, overwrite, ..self.request.clone() };
        let written = || -> Result<PathBuf, Failure> {
            let folder = efam_report::begin(&request)?;
            write(&folder, &request)?;
            Ok(folder.finish()?)
        };
        py.detach(written).map_err(exception)
    }
}
