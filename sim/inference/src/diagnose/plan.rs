//! What an experiment that is not made yet could show: from which size on each effect of the catalogue is
//! seen, and from which it is told from all others.
//!
//! Releases are simulated and looked at as if they had been recorded. With `s⊥` the trace of an effect of
//! unit strength that the baseline cannot make, in units of the noise, the effect is seen from
//! `5 / |s⊥|` on, and told from another from `5 / (|s⊥| √(1 − cos²))` on, with the angle between the two
//! traces (`score.rs`). Both are of small effects, with white noise, what does not repeat as a diagnosis takes it
//! (`calibrate/repeats.rs`), and a model that is right otherwise.

use std::sync::Arc;

use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use efam_experiments::scenario::Case;
use schemars::JsonSchema;
use serde::Serialize;

use super::DiagnosisSettings;
use super::candidate::{Candidate, candidates};
use super::design_matrix::{Column, extended, normal_equations, places, predictions};
use super::planned::record;
use super::score::{APART, columns, gram, unit_distance};
use super::section::{SHARED, USUAL_TILT, admit_tilt};
use crate::calibrate::joint::Joint;
use crate::calibrate::prediction::Slopes;
use crate::calibrate::refine::LAST;
use crate::calibrate::repeats::Repeats;
use crate::calibrate::{CalibrateError, FittedParameter, Nuisances, Problem, Scope, Trial};

/// Standard error of the release instant in a recording, s: that of a camera at 100 Hz.
const INSTANT: f64 = 2e-3;

/// Sensitivity of a planned experiment to one effect.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Prospect {
    /// Its stable name.
    pub effect: String,
    /// The parameter that is its strength, and its SI unit.
    pub parameter: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Values at which its other parameters are taken.
    pub tried: Vec<(String, f64)>,
    /// Smallest strength that can be detected; infinite, in JSON null, where the baseline covers the effect.
    #[schemars(with = "Option<f64>")]
    pub detectable_from: f64,
    /// Smallest strength that separates it from every other effect; null likewise.
    #[schemars(with = "Option<f64>")]
    pub separable_from: f64,
    /// The effect that resembles it most.
    pub nearest: Option<String>,
    /// The largest plausible strength, where the catalogue states one.
    pub largest_plausible: Option<f64>,
}

/// What is unknown of releases that are planned as scenarios: EI at each pressure, and the losses that
/// their models have. The tip is tracked, and markers at shares of the length.
pub fn problem(cases: &[Case], noise: f64, markers: &[f64]) -> Problem {
    let trials: Vec<Arc<Trial>> = cases.iter().map(|case| trial(case, noise, markers).into()).collect();
    let has = |path: &str| trials.iter().all(|trial| trial.model.index(path).is_ok());
    let losses = SHARED.into_iter().filter(|path| has(path));
    let mut parameters: Vec<FittedParameter> =
        losses.map(|path| FittedParameter::new(path, Scope::Shared)).collect();
    let is_under_pressure = trials.iter().all(|trial| trial.release.pressure.is_some());
    let scope = if is_under_pressure { Scope::PerPressure } else { Scope::Shared };
    parameters.insert(0, FittedParameter::new("rod.bending_stiffness", scope));
    let mut problem = Problem { trials, parameters, nuisances: Nuisances::default() };
    admit_tilt(&mut problem, USUAL_TILT);
    problem
}

fn trial(case: &Case, noise: f64, markers: &[f64]) -> Trial {
    let time = case.run.samples.clone();
    let track =
        |marker: String, at| Track { marker, at, position: vec![None; time.len()], noise, discrepancy: 0.0 };
    let on_body = markers.iter().map(|share| track(format!("at {share}"), Point::Along(*share)));
    let release = Release {
        name: case.name.clone(),
        release_uncertainty: INSTANT,
        tracks: std::iter::once(track("tip".to_owned(), Point::Tip)).chain(on_body).collect(),
        pressure: case.pressure,
        payload: 0.0,
        held_out: false,
        out_of_plane: OutOfPlane::default(),
        time,
    };
    Trial { release, model: case.model.clone(), run: case.run.clone() }
}

/// What the releases that are not held out would show of each effect, at each try of its other parameters, the
/// best visible first. Two releases of one condition differ by what is stated, m, or else by what the problem's own
/// recordings tell; `tell` hears what is being done.
/// # Errors
/// [`CalibrateError`] for releases that cannot be simulated.
pub fn plan(
    problem: &Problem,
    repeatability: Option<f64>,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Prospect>, CalibrateError> {
    let repeats = Repeats::of(problem, repeatability);
    let mut recorded = problem.clone();
    recorded.trials.retain(|trial| !trial.release.held_out);
    record(&mut recorded, &[])?;
    let recorded = match repeats.filter(Repeats::is_known) {
        Some(repeats) => repeats.heard_in(&recorded),
        None => recorded,
    };
    let fit = Joint::at(&recorded, &[], Slopes::Differences, LAST)?;
    let off = predictions(&fit).ok_or_else(|| fit.objective.refusal(&fit.found.x))?;
    let candidates = candidates(&recorded, &DiagnosisSettings::default());
    let columns = columns(&candidates, &fit, &off, tell);
    let (_, hessian) = normal_equations(&fit, &extended(&fit, &columns), columns.len());
    let gram = gram(&fit, &hessian);
    let traces: Vec<Trace> =
        candidates.iter().enumerate().map(|(c, candidate)| Trace::of(candidate, c, &columns)).collect();
    let prospect = |trace: &Trace| {
        let size = unit_distance(&gram, &trace.columns, &[]);
        let others = traces.iter().filter(|other| other.candidate.name() != trace.candidate.name());
        let nearest = others
            .map(|other| (other, unit_distance(&gram, &trace.columns, &other.columns)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let (low, high) = trace.candidate.believed();
        let null_value = trace.candidate.null_value;
        Prospect {
            effect: trace.candidate.name().to_owned(),
            parameter: trace.candidate.strength.name.to_owned(),
            unit: trace.candidate.strength.unit.to_owned(),
            tried: trace.candidate.tried.iter().map(|(own, value)| (own.name.to_owned(), *value)).collect(),
            detectable_from: APART / size,
            separable_from: APART / nearest.as_ref().map_or(size, |(_, apart)| *apart),
            nearest: nearest.map(|(other, _)| other.candidate.name().to_owned()),
            largest_plausible: trace
                .candidate
                .strength
                .plausible
                .map(|_| (high - null_value).max(null_value - low)),
        }
    };
    let mut prospects: Vec<Prospect> = traces.iter().map(prospect).collect();
    let share =
        |prospect: &Prospect| prospect.detectable_from / prospect.largest_plausible.unwrap_or(f64::INFINITY);
    prospects.sort_by(|a, b| share(a).total_cmp(&share(b)));
    Ok(prospects)
}

/// Of each strength the prospect that is seen best, whatever the other parameters are.
pub fn best_seen(prospects: Vec<Prospect>) -> Vec<Prospect> {
    let mut best: Vec<Prospect> = Vec::new();
    for prospect in prospects {
        // Those that are seen best come first.
        let is_there =
            |other: &Prospect| (&other.effect, &other.parameter) == (&prospect.effect, &prospect.parameter);
        if !best.iter().any(is_there) {
            best.push(prospect);
        }
    }
    best
}

/// A candidate with its columns.
struct Trace<'a> {
    candidate: &'a Candidate,
    columns: Vec<usize>,
}

impl<'a> Trace<'a> {
    fn of(candidate: &'a Candidate, place: usize, columns: &[Column]) -> Self {
        Self { candidate, columns: places(columns, place) }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use efam_experiments::scenario::Scenario;

    use super::*;

    /// What does not repeat hides what a camera alone would show.
    #[test]
    fn less_is_seen_of_releases_that_do_not_repeat() {
        let text = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
                    [run]\nduration = \"1 s\"\n[effects.rayleigh_mass]\nalpha = \"0.3 1/s\"\n";
        let scenario = Scenario::parse(Path::new("s.toml"), text, &[]).expect("sound");
        let cases: Vec<_> = scenario.cases().expect("a case").into_iter().map(Case::begun).collect();
        let limit = |repeatability: Option<f64>| {
            let planned = plan(&problem(&cases, 3e-4, &[]), repeatability, &|_| ());
            let prospects = planned.expect("it can be simulated");
            prospects.iter().find(|own| own.effect == "air_drag").expect("a candidate").detectable_from
        };
        let [exact, repeated] = [None, Some(2e-3)].map(limit);
        assert!(repeated > 5.0 * exact, "{repeated} against {exact}");
    }
}
