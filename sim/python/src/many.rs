//! The tips of many runs.

use std::ops::ControlFlow;

use efam_core::forward::{Run, uniform};
use efam_core::trajectory::Status;
use efam_experiments::scenario::Case;
use numpy::PyArray1;
use pyo3::prelude::*;
use rayon::prelude::*;
use sim::failure::Failure;
use sim::simulate;

use crate::failure::exception;
use crate::model::Model;
use crate::watch::followed;

/// What comes of many runs: times, tips with shape `[models][samples][2]`, and the failures with their places.
type Tips<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Vec<(usize, String)>);

/// The tips of many models, on all cores, sampled `rate` times a second. What a run has not is not a number.
#[pyfunction]
pub fn tips_of_many<'py>(
    py: Python<'py>,
    models: Vec<Py<Model>>,
    rate: f64,
    tell: Option<Py<PyAny>>,
) -> PyResult<Tips<'py>> {
    if !(rate > 0.0 && rate.is_finite()) {
        return Err(exception(Failure::Usage(format!("rate = {rate} Hz: must be positive"))));
    }
    let cases: Vec<&Case> = models.iter().map(|model| &model.get().case).collect();
    let longest = cases.iter().map(|case| case.run.duration).fold(0.0, f64::max);
    let count = longest * rate * cases.len() as f64;
    if count > 1e9 {
        let message = format!("{count:.0} samples in all are more than memory holds; lower rate or duration");
        return Err(exception(Failure::Usage(message)));
    }
    let times = uniform(longest, rate);
    let (tips, failures) = followed(py, tell, |cancel, progress| {
        progress.expect(cases.len());
        let mut tips = vec![f64::NAN; 2 * times.len() * cases.len()];
        let width = 2 * times.len();
        let one = |(place, (row, case)): (usize, (&mut [f64], &&Case))| {
            if cancel.is_requested() {
                return None;
            }
            let samples: Vec<f64> = times.iter().copied().filter(|time| *time <= case.run.duration).collect();
            let run = Run { samples, energy: false, trace_step: None, ..case.run.clone() };
            let case = case.run_as(&case.model, &run);
            let done = simulate::simulate(&case, false, cancel.clone(), &mut |_| ControlFlow::Continue(()));
            progress.step();
            match done {
                Err(failure) => Some((place, failure.to_string())),
                Ok(done) => {
                    for (own, tip) in row.chunks_exact_mut(2).zip(&done.trajectory.tip) {
                        own.copy_from_slice(tip);
                    }
                    match done.trajectory.status {
                        Status::Failed { reason, .. } => Some((place, reason)),
                        _ => None,
                    }
                }
            }
        };
        let failures: Vec<_> = tips.par_chunks_mut(width).zip(&cases).enumerate().filter_map(one).collect();
        (tips, failures)
    })?;
    Ok((PyArray1::from_vec(py, times), PyArray1::from_vec(py, tips), failures))
}
