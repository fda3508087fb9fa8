//! Failures as Python exceptions, with the words of the program.

use efam::failure::Failure;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

create_exception!(efam, EfamError, PyException, "What efam refuses, or could not do.");
create_exception!(efam, ScenarioError, EfamError, "A scenario, an experiment or an option is wrong.");
create_exception!(efam, DataError, EfamError, "A muscle file, a recording or other data are wrong.");
create_exception!(efam, SimulationError, EfamError, "A simulation or a search could not go on.");
create_exception!(efam, OutputError, EfamError, "Results could not be written or shown.");

/// Adds the exceptions to the module.
pub fn register(py: Python<'_>, module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("EfamError", py.get_type::<EfamError>())?;
    module.add("ScenarioError", py.get_type::<ScenarioError>())?;
    module.add("DataError", py.get_type::<DataError>())?;
    module.add("SimulationError", py.get_type::<SimulationError>())?;
    module.add("OutputError", py.get_type::<OutputError>())
}

/// The exception of a failure.
pub fn exception(failure: impl Into<Failure>) -> PyErr {
    let failure = failure.into();
    let message = failure.to_string();
    match failure {
        Failure::Scenario(error) if error.is_data() => DataError::new_err(message),
        Failure::Scenario(_) | Failure::Usage(_) => ScenarioError::new_err(message),
        Failure::Diverged(_) => SimulationError::new_err(message),
        Failure::Data(_) => DataError::new_err(message),
        Failure::Output(_) | Failure::Unread => OutputError::new_err(message),
        Failure::Interrupted => PyKeyboardInterrupt::new_err(message),
    }
}
