//! Analysis, calibration, diagnosis and prediction, as the program's commands do them.

use std::path::{Path, PathBuf};
use std::time::Instant;

use efam::failure::Failure;
use efam_core::forward::Cancel;
use efam_experiments::analyse as analysis;
use efam_experiments::analysis::static_stiffness::NODES;
use efam_experiments::kind::FileKind;
use efam_inference::calibrate as calibration;
use efam_inference::diagnose as diagnosis;
use efam_inference::predict as prediction;
use efam_inference::predict::PredictionSettings;
use efam_inference::predict::check::{check, fitted_files};
use efam_inference::predict::grid::grid;
use efam_inference::predict::request::CaseRequest;
use efam_report::Request;
use efam_report::calibrated::{models, table, write_calibration};
use efam_report::checked::{check_table, write_check};
use efam_report::diagnosed::{diagnosis_table, plan_table, write_diagnosis};
use efam_report::experiment as releases;
use efam_report::experiment::Row;
use efam_report::grid::{grid_table, write_grid};
use efam_report::predicted::{prediction_table, write_prediction};
use models::muscle::BUILT_IN;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;

use crate::answer::{AnswerData, request_of};
use crate::experiment::ExperimentData;
use crate::failure::exception;
use crate::model::Model;
use crate::overrides::{Laws, overrides, quantity};
use crate::watch::{Progress, followed};

/// Says on the thread of the call what a search does, and can end it.
pub struct Listener<'a>(pub Cancel, pub &'a Progress);

impl calibration::Listener for Listener<'_> {
    fn doing(&self, what: &str) {
        self.1.step();
        self.1.say(what);
    }
}

impl diagnosis::Listener for Listener<'_> {
    fn doing(&self, what: &str) {
        self.1.step();
        self.1.say(what);
    }

    fn stop(&self) -> Cancel {
        self.0.clone()
    }
}

/// Releases of an experiment with what was decided, and with their analysis if there are nodes for that.
#[pyfunction]
pub fn analyse(
    py: Python<'_>,
    experiment: Py<ExperimentData>,
    nodes: Option<Vec<usize>>,
) -> PyResult<AnswerData> {
    let own = experiment.get();
    if let Some(wrong) = nodes.iter().flatten().find(|nodes| !(4..=2000).contains(*nodes)) {
        return Err(exception(Failure::Usage(format!("nodes = {wrong}: must lie in 4..=2000"))));
    }
    let work = |_: Cancel, _: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        let cleaned = own.cleaned()?;
        let analysed =
            nodes.as_ref().map(|nodes| analysis::analyse(&own.own, &cleaned, nodes)).transpose()?;
        let mut printed = json!({
            "releases": cleaned.releases.iter().map(Row::of).collect::<Vec<_>>(),
            "decisions": cleaned.decisions,
        });
        let mut text = Vec::new();
        releases::table(&mut text, &cleaned)?;
        if let Some(analysed) = &analysed {
            printed["analysis"] = json!(analysed.iter().map(analysis::Analysed::said).collect::<Vec<_>>());
            for one in analysed {
                releases::analysed_table(&mut text, one)?;
            }
        }
        let request = request_of(own, &[], begin.elapsed().as_secs_f64());
        drop(analysed);
        let (experiment, nodes) = (own.own.clone(), nodes.clone());
        let write = move |folder: &_, request: &Request| {
            // It was analysed above, with the same numbers.
            let again = |nodes| analysis::analyse(&experiment, &cleaned, nodes).ok();
            let analysed = nodes.as_deref().and_then(again);
            releases::write(folder, request, &experiment, &cleaned, analysed.as_deref())
        };
        Ok(AnswerData::of(&printed, String::from_utf8_lossy(&text).into_owned(), request, write))
    };
    followed(py, None, work)?.map_err(exception)
}

/// Nodes of the static fits of an analysis.
#[pyfunction]
pub fn analysis_nodes() -> Vec<usize> {
    NODES.to_vec()
}

/// Parameters of an experiment's model.
#[pyfunction]
pub fn calibrate(
    py: Python<'_>,
    experiment: Py<ExperimentData>,
    profile: bool,
    tell: Option<Py<PyAny>>,
) -> PyResult<AnswerData> {
    let own = experiment.get();
    let work = |cancel: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        progress.say("reading and cleaning the recordings");
        let (mut problem, settings) = calibration::problem(&own.own, &own.cleaned()?)?;
        problem.trials_mut().for_each(|trial| trial.run.cancel = cancel.clone());
        let settings = calibration::CalibrationSettings { profile, ..settings };
        let outcome = calibration::calibrate(&problem, &settings, &Listener(cancel, progress))?;
        let found = &outcome.calibration;
        let files = models(&own.own, &problem, &settings, found);
        let files = files.map_err(|error| Failure::Usage(error.to_string()))?;
        let request = request_of(own, &found.warnings, begin.elapsed().as_secs_f64());
        let named = files.iter().map(|file| (file.name.clone(), file.text.clone())).collect();
        let (answer, text) = (json!(found), table(found));
        let write = move |folder: &_, request: &Request| {
            write_calibration(folder, request, &problem, &outcome, &files)
        };
        Ok(AnswerData::of(&answer, text, request, write).with_models(named))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// Which effect the model of an experiment lacks.
#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    experiment: Py<ExperimentData>,
    false_alarm: f64,
    most: usize,
    without: Vec<String>,
    budget: f64,
    tell: Option<Py<PyAny>>,
) -> PyResult<AnswerData> {
    let own = experiment.get();
    let usage = |message: String| exception(Failure::Usage(message));
    if !(false_alarm > 0.0 && false_alarm < 1.0) {
        return Err(usage(format!("false_alarm = {false_alarm}: it must lie between 0 and 1, such as 0.01")));
    }
    if !(1.0..=1e18).contains(&budget) {
        return Err(usage(format!(
            "budget = {budget}: it must be a number of node steps, 1 to 1e18, such as 2e9"
        )));
    }
    diagnosis::known_effects(&without, &own.own.catalogue())
        .map_err(|wrong| usage(format!("without: {wrong}")))?;
    let work = |cancel: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        progress.say("reading and cleaning the recordings");
        let settings = diagnosis::DiagnosisSettings {
            false_alarm,
            most_effects: most,
            excluded: without,
            budget: budget as u64,
            ..diagnosis::DiagnosisSettings::default()
        }
        .stated(&own.own)?;
        let problem = diagnosis::problem(&own.own, &own.cleaned()?)?;
        let outcome = diagnosis::diagnose(&problem, &settings, &Listener(cancel, progress))?;
        let found = &outcome.diagnosis;
        let request = request_of(own, &found.warnings, begin.elapsed().as_secs_f64());
        let (answer, text) = (json!(found), diagnosis_table(found));
        let write = move |folder: &_, request: &Request| write_diagnosis(folder, request, &outcome);
        Ok(AnswerData::of(&answer, text, request, write))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// The requested rod: a scenario by its text or path, or a muscle.
fn request(of: &str) -> Result<CaseRequest, Failure> {
    let is_built_in = BUILT_IN.iter().any(|(name, _)| *name == of);
    if is_built_in || FileKind::of(Path::new(of)) == Some(FileKind::Muscle) {
        return Ok(CaseRequest::muscle(of));
    }
    if of.contains('\n') {
        return Ok(CaseRequest::scenario(Path::new("rod.toml"), of.to_owned()));
    }
    let text = efam_store::input::text(Path::new(of)).map_err(|error| {
        Failure::Data(format!(
            "{of}: cannot be read ({error}); give a scenario, such as the rod.toml of a calibration, or the \
             muscle.toml of one"
        ))
    })?;
    Ok(CaseRequest::scenario(Path::new(of), text))
}

/// What a calibrated rod will do: of a scenario or a muscle, with draws from the errors of its calibration.
#[pyfunction]
#[pyo3(signature = (of, draws, seed, tell, **options))]
pub fn predict(
    py: Python<'_>,
    of: String,
    draws: usize,
    seed: u64,
    tell: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<AnswerData> {
    let set = overrides(options, &Laws::default())?;
    let work = |_: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        let mut request = request(&of)?;
        request.set = set;
        let (case, known) = request.case(None, None)?;
        let settings = PredictionSettings { draws, seed };
        progress.expect(known.as_ref().map_or(0, |_| draws));
        let outcome = prediction::predict(&case, known.as_ref(), &settings, &|| progress.step());
        let outcome = outcome.map_err(|error| Failure::Diverged(error.to_string()))?;
        let found = &outcome.prediction;
        let request = Request {
            name: case.name.replace([',', ':', '/'], " "),
            resolved_scenario: case.resolved(),
            warnings: found.warnings.clone(),
            wall_time_s: begin.elapsed().as_secs_f64(),
            ..Request::default()
        };
        let (answer, text) = (json!(found), prediction_table(found));
        let write = move |folder: &_, request: &Request| write_prediction(folder, request, &outcome);
        Ok(AnswerData::of(&answer, text, request, write))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// The same of every pressure, Pa, with every payload, kg; without pressures at the scenario's own.
#[pyfunction]
#[pyo3(signature = (of, pressures, payloads, tell, **options))]
pub fn predict_grid(
    py: Python<'_>,
    of: String,
    pressures: Vec<Bound<'_, PyAny>>,
    payloads: Vec<Bound<'_, PyAny>>,
    tell: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<AnswerData> {
    let set = overrides(options, &Laws::default())?;
    let all = |name: &str, values: &[Bound<'_, PyAny>], unit: &str| -> PyResult<Vec<f64>> {
        let mut all = values.iter().map(|value| quantity(name, value, unit)).collect::<PyResult<Vec<_>>>()?;
        all.sort_by(f64::total_cmp);
        all.dedup();
        Ok(all)
    };
    let pressures = all("pressures", &pressures, "Pa")?;
    let payloads = all("payloads", &payloads, "kg")?;
    let work = |_: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        let mut request = request(&of)?;
        request.set = set;
        let (case, known) = request.case(pressures.first().copied(), payloads.first().copied())?;
        progress.expect(pressures.len().max(1) * payloads.len());
        let make = |pressure, payload| Ok(request.case(pressure, Some(payload))?.0);
        let name = case.name.replace([',', ':', '/'], " ");
        let tell = || progress.step();
        let grid = grid(&name, (&pressures, &payloads), &make, known.as_ref(), &tell)?;
        let request = Request {
            name,
            resolved_scenario: case.resolved(),
            warnings: grid.warnings.clone(),
            wall_time_s: begin.elapsed().as_secs_f64(),
            ..Request::default()
        };
        let (answer, text) = (json!(grid), grid_table(&grid));
        Ok(AnswerData::of(&answer, text, request, move |folder, request| write_grid(folder, request, &grid)))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// What releases that are not recorded yet could show of each effect; lengths in m, markers as shares of the length.
#[pyfunction]
pub fn plan(
    py: Python<'_>,
    scenarios: Vec<Py<Model>>,
    noise: &Bound<'_, PyAny>,
    markers: Vec<f64>,
    repeatability: Option<Bound<'_, PyAny>>,
    tell: Option<Py<PyAny>>,
) -> PyResult<AnswerData> {
    let noise = quantity("noise", noise, "m")?;
    let repeatability = repeatability.map(|length| quantity("repeatability", &length, "m")).transpose()?;
    let is_length = |length: &f64| *length > 0.0 && length.is_finite();
    let is_share = |share: &f64| *share > 0.0 && *share < 1.0;
    if ![Some(noise), repeatability].iter().flatten().all(is_length) || !markers.iter().all(is_share) {
        let message = "plan: noise and repeatability must be more than nothing, markers lie between 0 and 1";
        return Err(exception(Failure::Usage(message.to_owned())));
    }
    let cases: Vec<_> = scenarios.iter().map(|model| model.get().case.clone()).collect();
    let work = |_: Cancel, progress: &Progress| -> Result<AnswerData, Failure> {
        let problem = diagnosis::plan::problem(&cases, noise, &markers);
        let found = diagnosis::plan::plan(&problem, repeatability, &|what| progress.say(what))?;
        let prospects = diagnosis::plan::best_seen(found);
        let answer = json!({ "releases": cases.len(), "prospects": prospects });
        Ok(AnswerData::printed(&answer, plan_table(&prospects, cases.len())))
    };
    followed(py, tell, work)?.map_err(exception)
}

/// Predictions beside the releases of an experiment, by the requested rod, or else by its own.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    experiment: Py<ExperimentData>,
    of: Option<String>,
    draws: usize,
    seed: u64,
) -> PyResult<AnswerData> {
    let own = experiment.get();
    let work = |_: Cancel, _: &Progress| -> Result<AnswerData, Failure> {
        let begin = Instant::now();
        let (experiment, known, left_out) = match &of {
            None => (own.own.clone(), own.own.known().cloned(), Vec::new()),
            Some(of) => {
                let mut request = request(of)?;
                request.set = own.overrides().to_vec();
                request.in_experiment(&own.own)?
            }
        };
        let rod = of.as_ref().filter(|of| !of.contains('\n')).map(PathBuf::from);
        let fitted = rod.as_deref().map(fitted_files).unwrap_or_default();
        let cleaned = efam_experiments::cleaning::clean(&experiment)?;
        let settings = PredictionSettings { draws, seed };
        let mut found = check(&experiment, &cleaned, known.as_ref(), &fitted, &settings)?;
        found.warnings.splice(..0, left_out);
        let request = request_of(own, &found.warnings, begin.elapsed().as_secs_f64());
        let request = Request { name: format!("{} predicted", request.name), ..request };
        let (answer, text) = (json!(found), check_table(&found));
        Ok(AnswerData::of(&answer, text, request, move |folder, request| {
            write_check(folder, request, &found)
        }))
    };
    followed(py, None, work)?.map_err(exception)
}
