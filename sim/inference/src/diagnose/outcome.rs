//! What a search found: models, curves, and how well their numbers are known.

use std::sync::Arc;

use efam_core::work::Work;
use efam_experiments::release::Point as Place;
use models::error::ModelError;
use models::muscle::{self, CalibratedParameter, Marker};

use super::answer::{answer, is_contradicted};
use super::curve::{curves, gaps};
use super::data::Data;
use super::hypothesis::{Hypothesis, Settled};
use super::likelihood::Fit;
use super::planned::separation;
use super::samples::Sampled;
use super::search::Point;
use super::setup::NODES;
use super::summary_text::summary;
use super::unknown::{Act, Role, Unknown};
use super::verdict::CutShort;
use super::warnings::warnings;
use super::{DiagnosisOutcome, DiagnosisSettings, Found, Listener, cut_by};
use crate::calibrate::{CalibrateError, FittedParameter, Problem, Scope};
use crate::features::Plan;

/// The outcome of a search.
/// # Errors
/// [`CalibrateError::Model`] for a mesh that a model cannot have.
pub(super) fn outcome(
    problem: &Problem,
    settings: &DiagnosisSettings,
    mut found: Found,
    listener: &dyn Listener,
    work: &Work,
) -> Result<DiagnosisOutcome, CalibrateError> {
    listener.doing("what remains, and held-out releases");
    let apart = found.data.apart();
    let settled = |found: &Found, fit: &Fit| settled(&found.data, apart.as_ref(), fit);
    let before = settled(&found, &found.baseline.fit);
    let met = |found: &Found| {
        let last = found.accepted.last().map_or(&found.baseline, |own| &own.sampled);
        let after = settled(found, &last.fit);
        let curves = curves(&before.iter().zip(&after).collect::<Vec<_>>());
        (after, gaps(&curves), curves)
    };
    let (mut after, mut gaps, mut curves) = met(&found);
    // What held-out releases contradict is no answer.
    while !found.accepted.is_empty() && is_contradicted(&gaps) {
        found.refuse_last();
        (after, gaps, curves) = met(&found);
    }
    let last = found.accepted.last().map_or(&found.baseline, |own| &own.sampled);
    let of = |settled: &[Settled], hypothesis: &Hypothesis| {
        posed(problem, &found.places, settled, hypothesis).map_err(|error| problem.refused(error))
    };
    let baseline = of(&before, &found.baseline.fit.hypothesis)?;
    let repaired = of(&after, &last.fit.hypothesis)?;
    let errors = known(&found.data, last);
    let mut diagnosis = answer(&found, settings, gaps);
    if !diagnosis.members.is_empty() {
        // The search is over: what is left out of the answer changes no name.
        match cut_by(listener, work) {
            Some(by) => _ = found.cut_short.get_or_insert(CutShort { round: None, by }),
            None => {
                listener.doing("recordings that separate the candidates");
                diagnosis.separating_experiment = separation(&found, &mut diagnosis.members);
            }
        }
    }
    diagnosis.cut_short = found.cut_short.take();
    (diagnosis.budget, diagnosis.node_steps) = (settings.budget, work.node_steps());
    diagnosis.warnings = warnings(&diagnosis, problem, &found);
    diagnosis.summary = summary(&diagnosis);
    Ok(DiagnosisOutcome { diagnosis, baseline, repaired, errors, curves })
}

/// All releases as a fit has them. Of those that are held out, which are those of `apart`, what they share with the others is that
/// of the fit, and what is their own is fitted to them.
fn settled(data: &Data, apart: Option<&Data>, fit: &Fit) -> Vec<Settled> {
    let (fitted, plans) = (data.plans.len(), data.all());
    let of = |r: usize| fit.hypothesis.settled(r, &plans[r].tracks, &fit.at.z);
    let mut all: Vec<Settled> = (0..plans.len()).map(of).collect();
    if let Some(own) = apart.and_then(|apart| held_out(apart, fit, fitted, &plans)) {
        all.splice(fitted.., own);
    }
    all
}

/// The releases that are held out, fitted; none where they cannot be.
fn held_out(data: &Data, fit: &Fit, fitted: usize, plans: &[&Plan]) -> Option<Vec<Settled>> {
    let mut own = fit.hypothesis.apart(fitted, plans, &fit.at.z);
    own.trials.iter_mut().for_each(|trial| trial.release.held_out = false);
    let own = Arc::new(own);
    let start = Point::of(data, &own, own.start())?;
    let found = Sampled::from(data, &Fit::at(data, &own, start, fit.share))?;
    let of = |(r, plan): (usize, &Plan)| {
        let mut settled = own.settled(r, &plan.tracks, &found.fit.at.z);
        settled.trial.release.held_out = true;
        settled
    };
    Some(data.plans.iter().enumerate().map(of).collect())
}

/// A problem with its compared releases as a fit has them, on their own mesh or the coarsest that is compared.
fn posed(
    problem: &Problem,
    places: &[usize],
    settled: &[Settled],
    hypothesis: &Hypothesis,
) -> Result<Problem, ModelError> {
    let mut posed = problem.clone();
    for (place, settled) in places.iter().zip(settled) {
        let nodes = (problem.trials[*place].model.edges + 1).max(NODES);
        posed.trials[*place] = Arc::new(settled.on_mesh(nodes)?);
    }
    for unknown in hypothesis.unknowns.iter().filter(|own| matches!(own.role, Role::Strength | Role::Shape)) {
        let Some(path) = unknown.path(&hypothesis.trials) else { continue };
        if posed.parameters.iter().all(|own| own.path != path) {
            let scope = match (unknown.pressure, unknown.is_own) {
                (Some(_), _) => Scope::PerPressure,
                (None, true) => Scope::PerRelease,
                (None, false) => Scope::Shared,
            };
            posed.parameters.push(FittedParameter::new(path, scope));
        }
    }
    Ok(posed)
}

/// How well a fit knows the parameters that all releases or those of a pressure share.
fn known(data: &Data, sampled: &Sampled) -> muscle::Known {
    let (hypothesis, z) = (&sampled.fit.hypothesis, &sampled.fit.at.z);
    let (trials, unknowns) = (&hypothesis.trials, &hypothesis.unknowns);
    let is_parameter = |own: &Unknown| match own.role {
        Role::Strength | Role::Shape => true,
        Role::Setup(word) => ["stiffness", "parameter"].contains(&word),
    };
    let is_shared = |u: &usize| {
        let own = &unknowns[*u];
        is_parameter(own) && !own.is_own && own.is_of_any(data.plans.len()) && own.path(trials).is_some()
    };
    let shared: Vec<usize> = (0..unknowns.len()).filter(is_shared).collect();
    let deviation = |u: usize| sampled.covariance[(u, u)].max(0.0).sqrt();
    let correlation = |u: usize, v: usize| match deviation(u) * deviation(v) {
        _ if u == v => 1.0,
        both if both > 0.0 => (sampled.covariance[(u, v)] / both).clamp(-1.0, 1.0),
        _ => 0.0,
    };
    let error = |u: usize| deviation(u) * unknowns[u].slope(unknowns[u].own(trials), z[u]).abs();
    let parameter = |u: &usize| CalibratedParameter {
        path: unknowns[*u].path(trials).unwrap_or_default().to_owned(),
        pressure_pa: unknowns[*u].pressure,
        value: unknowns[*u].value(unknowns[*u].own(trials), z[*u]),
        standard_error: Some(error(*u)).filter(|error| error.is_finite()),
        correlations: shared.iter().map(|v| correlation(*u, *v)).collect(),
    };
    let fitted = || trials[..data.plans.len()].iter().map(|trial| &trial.release);
    let offset = |r: usize, axis: usize| {
        let u = unknowns.iter().position(|own| own.acts[..] == [(r, Act::Offset(axis))])?;
        Some((unknowns[u].value(0.0, z[u]), error(u)))
    };
    let tip = fitted().find_map(|release| release.tracks.iter().find(|track| track.at == Place::Tip));
    let offsets: Vec<_> =
        (0..data.plans.len()).filter_map(|r| Some([offset(r, 0)?, offset(r, 1)?])).collect();
    muscle::Known {
        releases: data.plans.len(),
        pressure_pa: muscle::Known::span(fitted().filter_map(|release| release.pressure)),
        payload_kg: muscle::Known::span(fitted().map(|release| release.payload)),
        parameter: shared.iter().map(parameter).collect(),
        marker: tip.and_then(|track| Marker::of(&track.marker, &offsets)),
        ..muscle::Known::default()
    }
}
