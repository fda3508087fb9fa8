//! Calibration, diagnosis and prediction, as the program's commands do them: the JSON that they print, and their table.

use std::path::{Path, PathBuf};

use models::muscle::BUILT_IN;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::to_string;
use sim::calibrate as calibration;
use sim::cleaning::clean;
use sim::diagnose as diagnosis;
use sim::experiment::Experiment;
use sim::failure::Failure;
use sim::forward::Cancel;
use sim::predict as prediction;
use sim::predict::asked::Asked;
use sim::results::calibrated::table;
use sim::results::diagnosed::diagnosis_table;
use sim::results::predicted::prediction_table;

use crate::failure::exception;
use crate::overrides::overrides;
use crate::watch::watched;

/// JSON and table.
type Answer = (String, String);

/// Nobody listens, but the search can be ended.
struct Silent(Cancel);

impl calibration::Listener for Silent {
    fn doing(&self, _what: &str) {}
}

impl diagnosis::Listener for Silent {
    fn doing(&self, _what: &str) {}

    fn stop(&self) -> Cancel {
        self.0.clone()
    }
}

fn json(value: &impl serde::Serialize) -> String {
    to_string(value).expect("an answer has nothing that JSON has not")
}

/// Parameters of an experiment's model.
#[pyfunction]
pub fn calibrate(py: Python<'_>, experiment: PathBuf, set: Vec<String>, profile: bool) -> PyResult<Answer> {
    let work = |cancel: Cancel| -> Result<Answer, Failure> {
        let experiment = Experiment::load(&experiment, &set)?;
        let (mut problem, settings) = calibration::problem(&experiment, &clean(&experiment)?)?;
        problem.trials.iter_mut().for_each(|trial| trial.run.cancel = cancel.clone());
        let settings = calibration::Settings { profile, ..settings };
        let outcome = calibration::calibrate(&problem, &settings, &Silent(cancel))?;
        Ok((json(&outcome.calibration), table(&outcome.calibration)))
    };
    watched(py, work)?.map_err(exception)
}

/// Which effect the model of an experiment lacks.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    experiment: PathBuf,
    set: Vec<String>,
    false_alarm: f64,
    most: usize,
    without: Vec<String>,
) -> PyResult<Answer> {
    let work = |cancel: Cancel| -> Result<Answer, Failure> {
        let experiment = Experiment::load(&experiment, &set)?;
        let settings = diagnosis::Settings {
            false_alarm,
            most_effects: most,
            excluded: without,
            ..diagnosis::Settings::default()
        }
        .stated(&experiment)?;
        let problem = diagnosis::problem(&experiment, &clean(&experiment)?)?;
        let outcome = diagnosis::diagnose(&problem, &settings, &Silent(cancel))?;
        Ok((json(&outcome.diagnosis), diagnosis_table(&outcome.diagnosis)))
    };
    watched(py, work)?.map_err(exception)
}

/// What a calibrated rod will do: of a scenario or a muscle, with draws from the errors of its calibration.
#[pyfunction]
#[pyo3(signature = (of, draws, seed, **options))]
pub fn predict(
    py: Python<'_>,
    of: String,
    draws: usize,
    seed: u64,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Answer> {
    let set = overrides(options)?;
    let work = |_| -> Result<Answer, Failure> {
        let is_muscle = BUILT_IN.iter().any(|(name, _)| *name == of)
            || Path::new(&of).file_name().is_some_and(|name| name == "muscle.toml");
        let mut asked = match is_muscle {
            true => Asked::muscle(&of),
            false => {
                let text = sim::input::text(Path::new(&of)).map_err(|error| {
                    Failure::Data(format!(
                        "{of}: cannot be read ({error}); give a scenario, such as the \
                                           rod.toml of a calibration, or the muscle.toml of one"
                    ))
                })?;
                Asked::scenario(Path::new(&of), text)
            }
        };
        asked.set = set;
        let (case, known) = asked.case(None, None)?;
        let settings = prediction::Settings { draws, seed };
        let outcome = prediction::predict(&case, known.as_ref(), &settings, &|| ());
        let outcome = outcome.map_err(|error| Failure::Diverged(error.to_string()))?;
        Ok((json(&outcome.prediction), prediction_table(&outcome.prediction)))
    };
    watched(py, work)?.map_err(exception)
}
