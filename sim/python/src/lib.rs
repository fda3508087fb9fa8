//! The Python package `efam`: classes and functions over the same library that the program calls.

mod answer;
mod experiment;
mod failure;
mod inference;
mod linear;
mod many;
mod model;
mod overrides;
mod posterior;
mod pressure_line;
mod program;
mod recording;
mod residuals;
mod rest;
mod run;
mod source;
mod stored;
mod sweep;
mod swing;
mod watch;

use pyo3::prelude::*;

/// What the package `efam` is made of.
#[pymodule]
fn _efam(py: Python<'_>, module: &Bound<'_, PyModule>) -> PyResult<()> {
    failure::register(py, module)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<linear::Linear>()?;
    module.add_class::<run::RunData>()?;
    module.add_class::<swing::Swing>()?;
    module.add_class::<residuals::ResidualsData>()?;
    module.add_class::<recording::RecordingData>()?;
    module.add_class::<experiment::ExperimentData>()?;
    module.add_class::<answer::AnswerData>()?;
    module.add_function(wrap_pyfunction!(experiment::first_experiment, module)?)?;
    module.add_function(wrap_pyfunction!(many::tips_of_many, module)?)?;
    module.add_function(wrap_pyfunction!(inference::analyse, module)?)?;
    module.add_function(wrap_pyfunction!(inference::analysis_nodes, module)?)?;
    module.add_function(wrap_pyfunction!(inference::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(inference::compare, module)?)?;
    module.add_function(wrap_pyfunction!(inference::diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(inference::plan, module)?)?;
    module.add_function(wrap_pyfunction!(inference::predict, module)?)?;
    module.add_function(wrap_pyfunction!(inference::predict_grid, module)?)?;
    module.add_function(wrap_pyfunction!(posterior::sample, module)?)?;
    module.add_function(wrap_pyfunction!(many::numbers_of_many, module)?)?;
    module.add_function(wrap_pyfunction!(pressure_line::fit_pressure_line, module)?)?;
    module.add_function(wrap_pyfunction!(overrides::option_keys, module)?)?;
    module.add_function(wrap_pyfunction!(rest::effects, module)?)?;
    module.add_function(wrap_pyfunction!(rest::figures, module)?)?;
    module.add_function(wrap_pyfunction!(rest::modes, module)?)?;
    module.add_function(wrap_pyfunction!(rest::statics, module)?)?;
    module.add_function(wrap_pyfunction!(stored::animated, module)?)?;
    module.add_function(wrap_pyfunction!(stored::columns, module)?)?;
    module.add_function(wrap_pyfunction!(stored::compare_runs, module)?)?;
    module.add_function(wrap_pyfunction!(stored::loaded, module)?)?;
    module.add_function(wrap_pyfunction!(stored::write_files, module)?)?;
    module.add_function(wrap_pyfunction!(swing::step_many, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(program::main, module)?)?;
    Ok(())
}
