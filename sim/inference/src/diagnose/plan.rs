//! What an experiment that is not made yet could show: from which size on each effect of the catalogue is
//! seen, and from which it is separated from all others.
//!
//! Releases are simulated and looked at as if they had been recorded; an effect is seen, and separated from another, from five
//! standard deviations on (`traces.rs`). Both are of small effects, with white noise, what does not repeat where it is stated,
//! and a model that is right otherwise.

use std::sync::Arc;

use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use efam_experiments::scenario::Case;
use nalgebra::DVector;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::DiagnosisSettings;
use super::candidate::{Candidate, candidates};
use super::data::Data;
use super::extension::extension;
use super::hypothesis::{Settled, refusal};
use super::search::Point as At;
use super::section::SHARED;
use super::setup;
use super::traces::{APART, Traces, trace};
use crate::calibrate::{CalibrateError, FittedParameter, Nuisances, Problem, Scope, Trial};

/// Standard error of the release instant in a recording, s: that of a camera at 100 Hz.
const INSTANT: f64 = 2e-3;

/// Strength at which an effect is probed, prior standard deviations: small ones are linear.
const SMALL: f64 = 0.1;

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
    Problem { trials, parameters, nuisances: Nuisances::default() }
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

/// What releases would show of each effect, at each try of its other parameters, the best visible first. Two releases of one
/// condition differ by what is stated, m; `tell` receives what is being done.
/// # Errors
/// [`CalibrateError`] for releases that cannot be simulated.
pub fn plan(
    problem: &Problem,
    repeatability: Option<f64>,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Prospect>, CalibrateError> {
    let of_model = |error| problem.refused(error);
    tell("the planned releases");
    let mut trials = setup::trials(problem, true).map_err(of_model)?;
    trials.retain(|trial| !trial.release.held_out);
    let alone = |trial: Trial| {
        let settled = Settled { trial: trial.clone(), instant: 0.0, offset: [0.0; 2] };
        settled.recorded().ok_or_else(|| refusal(&trial))
    };
    let trials = trials.into_iter().map(alone).collect::<Result<Vec<_>, _>>()?;
    let (data, places) = Data::of(&trials, repeatability, Some(1.0));
    if places.is_empty() {
        return Err(CalibrateError::NoFit { release: problem.first_name() });
    }
    let trials: Vec<Trial> = places.iter().map(|r| trials[*r].clone()).collect();
    let base = setup::nothing(problem, trials, &data.all()).map_err(of_model)?;
    let no_fit = || refusal(&base.trials[0]);
    let at = At::of(&data, &base, base.start()).ok_or_else(no_fit)?;
    tell("the effects in them");
    let probe = |candidate: Candidate| {
        let own = extension(&base, &candidate).ok()?;
        let unknowns = &own.hypothesis.unknowns;
        let z = DVector::from_fn(unknowns.len(), |u, _| match at.z.get(u) {
            Some(z) => *z,
            None if own.strengths.contains(&u) => SMALL,
            None => unknowns[u].start,
        });
        let strength = unknowns[*own.strengths.first()?].scaled.value(0.0, SMALL);
        let over = (strength - candidate.null_value).abs();
        Some((candidate, trace(&data, &at, &own.hypothesis, &z, over)?))
    };
    let all = candidates(&base.trials, &DiagnosisSettings::default());
    let (probed, columns): (Vec<Candidate>, Vec<_>) = all.into_par_iter().filter_map(probe).unzip();
    let misfit = repeatability.map_or(0.0, |distance| 0.5 * distance * distance);
    let counts = vec![1; data.plans.len()];
    let traces = Traces::of(&data, &at, &base, &columns, (&counts, 1), misfit).ok_or_else(no_fit)?;
    let prospect = |k: usize| {
        let candidate = &probed[k];
        let others = (0..probed.len()).filter(|other| probed[*other].name() != candidate.name());
        let nearest = others.map(|other| (other, traces.apart(k, other))).min_by(|a, b| a.1.total_cmp(&b.1));
        let (low, high) = candidate.believed();
        let null_value = candidate.null_value;
        Prospect {
            effect: candidate.name().to_owned(),
            parameter: candidate.strength.name.to_owned(),
            unit: candidate.strength.unit.to_owned(),
            tried: candidate.tried.iter().map(|(own, value)| (own.name.to_owned(), *value)).collect(),
            detectable_from: APART / traces.size(k),
            separable_from: APART / nearest.map_or(traces.size(k), |(_, apart)| apart),
            nearest: nearest.map(|(other, _)| probed[other].name().to_owned()),
            largest_plausible: candidate
                .strength
                .plausible
                .map(|_| (high - null_value).max(null_value - low)),
        }
    };
    let mut prospects: Vec<Prospect> = (0..probed.len()).map(prospect).collect();
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
