//! Rest, modes and the catalogue of effects, as the program's commands print them.

use pyo3::prelude::*;
use serde_json::{json, to_value};
use sim::catalogue::{Effect, all, listed, named};
use sim::failure::Failure;
use sim::rest::{ModesPrinted, StaticsPrinted, resting, vibrations};

use crate::answer::AnswerData;
use crate::failure::exception;
use crate::model::Model;
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
