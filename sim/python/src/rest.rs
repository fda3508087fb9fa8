//! Rest, modes, the catalogue of effects and the paper's figures, as the program's commands print them.

use std::ops::ControlFlow;
use std::time::Instant;

use efam_core::forward::{Run, forward};
use efam_report::Request;
use efam_report::figures::{words, write_figures};

use efam::catalogue::{Effect, all, listed, named};
use efam::failure::Failure;
use efam::figures::{Runs, admit, of_recordings, table};
use efam::rest::{ModesPrinted, StaticsPrinted, resting, vibrations};
use efam::simulate::kept;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{json, to_value};

use crate::answer::{AnswerData, request_of};
use crate::experiment::ExperimentData;
use crate::failure::exception;
use crate::model::Model;
use crate::overrides::{Laws, tables};
use crate::watch::watched;

/// The rest posture of a model.
#[pyfunction]
pub fn statics(py: Python<'_>, model: Py<Model>) -> PyResult<AnswerData> {
    let work = |_| -> Result<AnswerData, Failure> {
        let printed = StaticsPrinted { statics: vec![resting(&model.get().case)?] };
        Ok(AnswerData::printed(&printed, printed.table()))
    };
    watched(py, work)?.map_err(exception)
}

/// The slowest vibrations of a model about its rest.
#[pyfunction]
pub fn modes(py: Python<'_>, model: Py<Model>, count: usize) -> PyResult<AnswerData> {
    let work = |_| -> Result<AnswerData, Failure> {
        let printed = ModesPrinted { modes: vibrations(&model.get().case, count)? };
        Ok(AnswerData::printed(&printed, printed.table()))
    };
    watched(py, work)?.map_err(exception)
}

/// All effects, or the page of one.
#[pyfunction]
pub fn effects(name: Option<&str>) -> PyResult<AnswerData> {
    let Some(name) = name else {
        return Ok(AnswerData::printed(&json!({ "effects": all() }), listed()));
    };
    let effect = named(name).map_err(exception)?;
    let mut entries = to_value(Effect::of(effect.about())).expect("an effect has nothing that JSON has not");
    entries["page"] = json!(effect.page());
    Ok(AnswerData::printed(&entries, effect.page()))
}

/// The paper's figures, from the releases of an experiment, or else from runs of our own with these options.
#[pyfunction]
pub fn figures(
    py: Python<'_>,
    experiment: Option<Py<ExperimentData>>,
    options: &Bound<'_, PyDict>,
) -> PyResult<AnswerData> {
    let set = tables(options, &Laws::default())?;
    let work = |cancel: efam_core::forward::Cancel| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        let (all, request) = match &experiment {
            Some(experiment) => {
                let own = experiment.get();
                admit(&own.own)?;
                let (all, warnings) = of_recordings(&own.own, &own.cleaned()?)?;
                let request = request_of(own, &warnings, 0.0);
                (all, Request { name: format!("{} figures", request.name), ..request })
            }
            None => {
                let runs = Runs::new(&set)?;
                let follow = |case: &efam_experiments::scenario::Case| {
                    let run = Run { cancel: cancel.clone(), ..case.run.clone() };
                    kept(case, forward(&case.model, &run, &mut |_| ControlFlow::Continue(())))
                };
                (runs.pressures(&follow)?, runs.request)
            }
        };
        let request = Request { wall_time_s: begin.elapsed().as_secs_f64(), ..request };
        let words = words(&all);
        let entries = json!({ "figures": words, "warnings": request.warnings });
        let text = table(&words);
        let write = move |folder: &_, request: &_| write_figures(folder, request, &all, &words);
        Ok(AnswerData::of(&entries, text, request, write))
    };
    watched(py, work)?.map_err(exception)
}
