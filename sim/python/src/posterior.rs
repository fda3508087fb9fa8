//! Draws from the posterior of a calibration.

use std::fmt::Write;
use std::time::Instant;

use efam::failure::Failure;
use efam_core::forward::Cancel;
use efam_inference::calibrate::posterior::{Posterior, SampleSettings, sample as sample_posterior};
use efam_inference::calibrate::problem;
use efam_report::aligned::{Aligned, Side};
use efam_report::calibrated::models;
use efam_report::interval::with_ends;
use models::digits::significant;
use pyo3::prelude::*;
use serde_json::json;

use crate::answer::AnswerData;
use crate::experiment::ExperimentData;
use crate::failure::exception;
use crate::inference::Listener;
use crate::watch::{Progress, followed};

/// The posterior of a calibration: chains of draws.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn sample(
    py: Python<'_>,
    experiment: Py<ExperimentData>,
    chains: usize,
    draws: usize,
    warm_up: usize,
    predicted: usize,
    seed: u64,
    tell: Option<Py<PyAny>>,
) -> PyResult<AnswerData> {
    let own = experiment.get();
    if !(2..=100).contains(&chains)
        || !(4..=1_000_000).contains(&draws)
        || !(10..=1_000_000).contains(&warm_up)
    {
        let message = format!(
            "sample: chains = {chains}, draws = {draws}, warm_up = {warm_up}: they must lie in 2..=100, 4..=1000000 and \
             10..=1000000"
        );
        return Err(exception(Failure::Usage(message)));
    }
    let work = |cancel: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        progress.say("reading and cleaning the recordings");
        let (mut problem, settings) = problem(&own.own, &own.cleaned()?)?;
        problem.trials_mut().for_each(|trial| trial.run.cancel = cancel.clone());
        let sampling = SampleSettings { chains, draws, warm_up, predicted, seed };
        let (outcome, posterior) =
            sample_posterior(&problem, &settings, &sampling, &Listener(cancel, progress))?;
        let found = &outcome.calibration;
        let files = models(&own.own, &problem, &settings, found);
        let files = files.map_err(|error| Failure::Usage(error.to_string()))?;
        let named = files.into_iter().map(|file| (file.name, file.text)).collect();
        let text = posterior_table(&posterior);
        let mut answer = json!(posterior);
        answer["warnings"] = json!(found.warnings.iter().chain(&posterior.warnings).collect::<Vec<_>>());
        answer["wall_time_s"] = json!(begin.elapsed().as_secs_f64());
        Ok(AnswerData::printed(&answer, text).with_models(named))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// What is printed for people of a posterior, beside what the calibration states.
fn posterior_table(posterior: &Posterior) -> String {
    let numbers = ["mean", "deviation"].map(|head| (head, Side::Number));
    let more = [("calibration's", Side::Name), ("R-hat", Side::Number), ("effective draws", Side::Number)];
    let heads = [&[("", Side::Words)], &numbers[..], &[("95 % interval", Side::Name)], &more[..]].concat();
    let mut table = Aligned::new(&heads);
    for own in &posterior.parameters {
        let (value, ends) = with_ends(own.value, Some(own.interval_95), 1.0);
        let words =
            |ends: Option<[String; 2]>| ends.map_or("-".to_owned(), |[low, high]| format!("{low} to {high}"));
        table.row([
            own.name.clone(),
            value,
            significant(own.standard_error, 2),
            format!("{} {}", words(ends), own.unit).trim_end().to_owned(),
            words(with_ends(own.value, own.laplace_95, 1.0).1),
            own.r_hat.map_or("-".to_owned(), |r_hat| format!("{r_hat:.3}")),
            own.effective_draws.map_or("-".to_owned(), |size| format!("{size:.0}")),
        ]);
    }
    let mut text = table.to_string();
    for warning in &posterior.warnings {
        let _ = write!(text, "\n! {warning}");
    }
    text
}
