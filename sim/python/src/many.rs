//! The tips of many runs.

use efam::failure::Failure;
use efam::simulate::simulate_many;
use efam_core::forward::{Run, uniform};
use efam_core::trajectory::Status;
use efam_experiments::scenario::Case;
use efam_experiments::summary::Summary;
use efam_report::Request;
use efam_report::told::told;
use numpy::PyArray1;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::failure::exception;
use crate::model::Model;
use crate::watch::followed;

/// What comes of many runs: times, tips with shape `[models][samples][2]`, numbers with shape `[models][NUMBERS]`, and the
/// failures with their places.
type Tips<'py> = (Array<'py>, Array<'py>, Array<'py>, Vec<(usize, String)>);
/// Tips and numbers of a run.
type Rows<'a> = (&'a mut [f64], &'a mut [f64]);
type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Models that one thread takes at a time: enough that places in a pack are seldom empty, few enough that threads end
/// together.
const BATCH: usize = 32;

/// Numbers of a summary: name, SI unit, value.
type Number = (&'static str, &'static str, fn(&Summary) -> Option<f64>);
const NUMBERS: [Number; 10] = [
    ("damped_frequency_hz", "Hz", |own| own.damped_frequency_hz),
    ("natural_frequency_hz", "Hz", |own| own.natural_frequency_hz),
    ("damping_ratio", "", |own| own.damping_ratio),
    ("settling_2_percent_s", "s", |own| own.settling_2_percent_s),
    ("settling_5_percent_s", "s", |own| own.settling_5_percent_s),
    ("rest_tip_x_m", "m", |own| Some(own.rest?.tip_x_m)),
    ("rest_tip_z_m", "m", |own| Some(own.rest?.tip_z_m)),
    ("lowest_tip_z_m", "m", |own| Some(own.lowest?.tip_z_m)),
    ("peak_speed_m_s", "m/s", |own| Some(own.peak_speed.as_ref()?.speed_m_s)),
    ("least_tip_angle_rad", "rad", |own| own.least_tip_angle_rad),
];

/// Name and SI unit of each number of a summary.
#[pyfunction]
pub fn numbers_of_many() -> Vec<(&'static str, &'static str)> {
    NUMBERS.iter().map(|(name, unit, _)| (*name, *unit)).collect()
}

/// The tips of many models, on all cores, sampled `rate` times a second, and the numbers of their summaries if these are
/// wanted. What a run has not is not a number.
#[pyfunction]
pub fn tips_of_many<'py>(
    py: Python<'py>,
    models: Vec<Py<Model>>,
    rate: f64,
    summaries: bool,
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
    let (tips, numbers, failures) = followed(py, tell, |cancel, progress| {
        progress.expect(cases.len());
        let mut tips = vec![f64::NAN; 2 * times.len() * cases.len()];
        let width = 2 * times.len();
        let mut numbers = vec![f64::NAN; NUMBERS.len() * cases.len()];
        // Rows of a batch, the numbers of its runs, and which it is.
        let one = |(batch, ((rows, numbers), cases)): (usize, (Rows, &[&Case]))| {
            if cancel.is_requested() {
                return Vec::new();
            }
            let runs = cases.iter().map(|case| {
                let samples: Vec<f64> =
                    times.iter().copied().filter(|time| *time <= case.run.duration).collect();
                let trace_step = case.run.trace_step.filter(|_| summaries);
                case.run_as(&case.model, &Run { samples, energy: false, trace_step, ..case.run.clone() })
            });
            let mut failures = Vec::new();
            simulate_many(&runs.collect::<Vec<_>>(), &cancel, &mut |place, done| {
                progress.step();
                let in_all = BATCH * batch + place;
                let done = match done {
                    Err(failure) => return failures.push((in_all, failure.to_string())),
                    Ok(done) => done,
                };
                if summaries {
                    let told = told(&Request::default(), &done.model, &done.run, &done.trajectory);
                    let own = &mut numbers[NUMBERS.len() * place..];
                    for (own, (_, _, number)) in own.iter_mut().zip(NUMBERS) {
                        *own = number(&told.summary).unwrap_or(f64::NAN);
                    }
                }
                let row = &mut rows[width * place..width * (place + 1)];
                for (own, tip) in row.chunks_exact_mut(2).zip(&done.trajectory.tip) {
                    own.copy_from_slice(tip);
                }
                if let Status::Failed { reason, .. } = done.trajectory.status {
                    failures.push((in_all, reason));
                }
            });
            failures.sort_unstable();
            failures
        };
        let rows = tips.par_chunks_mut(BATCH * width).zip(numbers.par_chunks_mut(BATCH * NUMBERS.len()));
        let batches = rows.zip(cases.par_chunks(BATCH)).enumerate();
        let failures: Vec<_> = batches.flat_map_iter(one).collect();
        (tips, numbers, failures)
    })?;
    let array = |own| PyArray1::from_vec(py, own);
    Ok((array(times), array(tips), array(numbers), failures))
}
