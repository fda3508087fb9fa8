//! A candidate fitted in full: its parameters beside all others, mesh and step removed anew.

use efam_experiments::release::Release;
use models::muscle::{self, CalibratedParameter};
use models::quantity::format_si;

use super::candidate::Candidate;
use super::validation::set;
use super::verdict::{Added, ParameterValue};
use crate::calibrate::hold;
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::marker::marker;
use crate::calibrate::profile::profile;
use crate::calibrate::refine::{RESOLUTION_COMPARED, RESOLUTION_FITTED};
use crate::calibrate::stage::STAGE_SHARE;
use crate::calibrate::uncertainty::{Uncertainty, uncertainty};
use crate::calibrate::unknowns::Group;
use crate::calibrate::{CalibrateError, Problem, Trial};
use crate::normal::NORMAL_95;

/// A model with one more effect, fitted.
#[derive(Clone)]
pub(super) struct Refit {
    /// The fit, with the effect in its problem.
    pub fitted: Joint,
    /// Where it ended.
    pub known: Vec<Estimate>,
    /// Cost under the loss of the noise.
    pub cost: f64,
    /// Parameters of the effect.
    pub values: Vec<ParameterValue>,
    /// How many unknowns it brought.
    pub unknowns: usize,
}

/// A model with one more effect, near its fit.
pub(super) struct Rough {
    pub problem: Problem,
    pub known: Vec<Estimate>,
    /// Unknowns without it.
    pub without: usize,
    /// Cost under the loss of the noise, with mesh and step as they are.
    pub cost: f64,
    /// Whether it is within [`STAGE_SHARE`] of its least.
    pub is_near: bool,
    /// Whether the noise explains its residuals.
    pub is_explained: bool,
    /// Steps that a run of a fit may take.
    most_steps: usize,
}

impl Rough {
    /// How many unknowns it brought.
    pub fn unknowns(&self) -> usize {
        self.known.len() - self.without
    }
}

/// χ² of a fit with a penalty for each of the unknowns that it brought.
pub(super) fn penalised(cost: f64, unknowns: usize, each: f64, variance_inflation: f64) -> f64 {
    2.0 * cost / variance_inflation + each * unknowns as f64
}

/// χ² that an unknown has to be worth: `ln n`, with as many independent samples n as the noise leaves. Schwarz (1978),
/// Annals of Statistics 6, 461-464.
pub(super) fn penalty(fit: &Joint, variance_inflation: f64) -> f64 {
    let series = fit.found.at.carried.blocks.iter().flatten();
    let samples = series.map(|series| 2 * series.samples.len()).sum::<usize>() as f64 / variance_inflation;
    samples.max(1.0).ln()
}

/// Width of an interval, as a share of the value, from which on a parabola is not asked alone.
const WIDE: f64 = 0.2;

/// Steps of a run, in those of the model without a candidate, from which on it is not worth its time. A run with any effect
/// of a usual size takes up to four times those of a plain one; ten are of a stiffness that no rod has, or of friction that
/// turns round with waves that nothing damps.
const MOST_STEPS: usize = 10;

/// The same in numbers, for runs like those of a fit.
pub(super) fn most_steps(fit: &Joint) -> usize {
    let most = fit.found.view.steps.iter().flatten().map(Vec::len).max();
    most.map_or(usize::MAX, |most| MOST_STEPS * most)
}

/// The problem of a search whose runs take so many steps at most. What is found belongs to the problem without that limit:
/// held-out releases may be longer.
pub(super) fn within_steps(problem: &Problem, most_steps: usize) -> Problem {
    let mut problem = problem.clone();
    problem.trials_mut().for_each(|trial| trial.run.most_steps = trial.run.most_steps.min(most_steps));
    problem
}

/// Brings a candidate near its fit from one without it, beginning with the strength that its score asks
/// for; where that leads astray, with none, from where it cannot end worse than without. None where it
/// cannot be run.
pub(super) fn rough(
    candidate: &Candidate,
    estimate: f64,
    without: &Joint,
) -> Result<Option<Rough>, CalibrateError> {
    let known = without.known();
    let mut best: Option<Rough> = None;
    for strength in [estimate, candidate.null_value] {
        if best.as_ref().is_some_and(|best| best.cost <= without.cost()) {
            break;
        }
        let found = rough_from(candidate, strength, &known, without)?;
        best = found.into_iter().chain(best).min_by(|a, b| a.cost.total_cmp(&b.cost));
    }
    Ok(best)
}

/// Brings a candidate near its fit from what is known of the other unknowns. None where it cannot be run.
pub(super) fn rough_from(
    candidate: &Candidate,
    strength: f64,
    known: &[Estimate],
    without: &Joint,
) -> Result<Option<Rough>, CalibrateError> {
    // A memory that turns round needs steps where that happens.
    let has_own_steps = candidate.effect.about().memory > 0;
    let (view, most_steps) = (&without.found.view, most_steps(without));
    let Ok(problem) = candidate.added_to(&without.problem, strength) else { return Ok(None) };
    let limited = within_steps(&problem, most_steps);
    let known = held(candidate, strength, known, &without.problem);
    let found = Joint::approach(&limited, &known, view, has_own_steps, STAGE_SHARE)?;
    Ok(found.map(|fit| {
        let (known, cost, without) = (fit.known(), fit.cost(), without.found.x.len());
        let (is_near, is_explained) = (fit.found.converged, fit.is_explained());
        Rough { problem, known, without, cost, is_near, is_explained, most_steps }
    }))
}

/// What is known, with the loads of hands changed so that the markers stay where they are when a candidate is added.
fn held(candidate: &Candidate, strength: f64, known: &[Estimate], problem: &Problem) -> Vec<Estimate> {
    let is_fitted = |trial: &Trial| trial.is_held() && !trial.release.held_out;
    let mut changed = known.to_vec();
    if !problem.trials.iter().any(|trial| is_fitted(trial)) {
        return changed;
    }
    let mut problem = problem.clone();
    set(&mut problem, known);
    for (place, before) in problem.trials.iter().enumerate().filter(|(_, trial)| is_fitted(trial)) {
        let change = |after: Trial| hold::change(before, &after).ok();
        let changes = candidate.begun(before, strength).ok().and_then(change);
        for (path, change) in changes.into_iter().flatten() {
            let group = Group::Release(place);
            let is_own = |own: &&mut Estimate| own.unknown.name == path && own.unknown.group == group;
            for own in changed.iter_mut().filter(is_own) {
                own.x = own.unknown.scaled.variable(own.value() + change);
            }
        }
    }
    changed
}

/// Follows a candidate to a fit that can be compared with others. It `is_surpassed` if another one leaves only noise and it is
/// far behind. None where it cannot be run.
pub(super) fn refit(
    rough: &Rough,
    candidate: &Candidate,
    is_surpassed: bool,
) -> Result<Option<Refit>, CalibrateError> {
    let mut known = rough.known.clone();
    let fitted = candidate.within_ranges(rough.problem.clone(), |problem| {
        let limited = within_steps(problem, rough.most_steps);
        let followed = Joint::follow(&limited, &known, RESOLUTION_COMPARED)?;
        // The way from the fit without it may end beside the best, for friction changes the phase, or where no run
        // ends: that says nothing of the effect. One that is surpassed is too far behind to be worth a search.
        let is_met = |fit: &Joint| !candidate.strength.is_friction || fit.is_explained();
        let is_over = is_surpassed || followed.as_ref().is_some_and(is_met);
        let searched = if is_over { None } else { Joint::search(&limited, &|_| ()).ok() };
        let by_cost = |a: &Joint, b: &Joint| a.cost().total_cmp(&b.cost());
        let Some(fit) = followed.into_iter().chain(searched).min_by(by_cost) else { return Ok(None) };
        known = fit.known();
        Ok(Some((fit.with_problem(problem.clone())?, known.clone())))
    })?;
    Ok(fitted.map(|fitted| Refit::of(fitted, candidate, rough.without)))
}

impl Refit {
    /// The same fit, followed to its end.
    pub(super) fn finished(self, candidate: &Candidate) -> Self {
        let without = self.known.len() - self.unknowns;
        let finished = self.fitted.clone().refined(RESOLUTION_FITTED);
        finished.map_or(self, |fitted| Self::of(fitted, candidate, without))
    }

    /// A fit with a candidate, which has so many unknowns `without` it.
    pub(super) fn of(fitted: Joint, candidate: &Candidate, without: usize) -> Self {
        let values = Added::of(&fitted, candidate).parameters;
        let (known, cost) = (fitted.known(), fitted.cost());
        let unknowns = known.len() - without;
        Self { fitted, known, cost, values, unknowns }
    }
}

impl Added {
    /// An effect that was added, as a fit has it.
    pub(super) fn of(fit: &Joint, candidate: &Candidate) -> Self {
        let of = uncertainty(&fit.objective, &fit.found);
        let parameters = values(fit, candidate, &of, &|k, known| parabola(&of, k, known));
        Self { effect: candidate.name().to_owned(), parameters }
    }

    /// The same, where what is badly known has its bounds from the profile of the likelihood: there the cost is no
    /// parabola. `between` is the standard error of each unknown from differences between releases (`between.rs`).
    pub(super) fn profiled(fit: &Joint, candidate: &Candidate, between: &[f64]) -> Self {
        let of = uncertainty(&fit.objective, &fit.found);
        let bounds = |k: usize, known: &Estimate| {
            let linear = parabola(&of, k, known);
            let [low, high] = linear.map(|x| known.unknown.scaled.value(x));
            let is_wide = (high - low).abs() > WIDE * known.value().abs();
            let is_asked = is_wide && !matches!(known.unknown.group, Group::Release(_));
            let profile = || profile(&fit.objective, &fit.found, &of, k);
            let of_noise = is_asked.then(profile).flatten().unwrap_or(linear);
            // Two independent errors.
            of_noise.map(|x| known.x + (x - known.x).hypot(NORMAL_95 * between[k]).copysign(x - known.x))
        };
        let parameters = values(fit, candidate, &of, &bounds);
        Self { effect: candidate.name().to_owned(), parameters }
    }
}

/// How well a fit knows the parameters that all releases or those of a pressure share; the error of the mesh is
/// removed from them. `between` as in [`Added::profiled`].
pub(super) fn errors(fit: &Joint, between: &[f64]) -> muscle::Known {
    let (all, of) = (fit.known(), uncertainty(&fit.objective, &fit.found));
    let is_told =
        |known: &Estimate| !known.unknown.is_nuisance() && !matches!(known.unknown.group, Group::Release(_));
    let own: Vec<usize> = (0..all.len()).filter(|k| is_told(&all[*k])).collect();
    let deviation = |k: usize| of.covariance[(k, k)].max(0.0).sqrt();
    let error = |k: usize| deviation(k).hypot(between[k]) * all[k].unknown.scaled.slope(all[k].x).abs();
    let correlation = |k: usize, l: usize| match (k == l, deviation(k) * deviation(l)) {
        (true, _) => 1.0,
        (false, both) if both > 0.0 => (of.covariance[(k, l)] / both).clamp(-1.0, 1.0),
        _ => 0.0,
    };
    let parameter = |k: &usize| {
        let (unknown, x) = (&all[*k].unknown, all[*k].x);
        CalibratedParameter {
            path: unknown.name.clone(),
            pressure_pa: match unknown.group {
                Group::Pressure(pressure) => Some(pressure),
                _ => None,
            },
            value: unknown.scaled.value(x),
            standard_error: Some(error(*k)).filter(|error| of.is_determined[*k] && error.is_finite()),
            correlations: own.iter().map(|l| correlation(*k, *l)).collect(),
        }
    };
    let trials = || fit.objective.part.members.iter();
    let nuisance = |release: &Release, name: &str| {
        let is_of = |t: usize| fit.problem.trials[t].release.name == release.name;
        let k = all.iter().position(|known| {
            known.unknown.name == name && matches!(known.unknown.group, Group::Release(t) if is_of(t))
        })?;
        let own = of.is_determined[k].then(|| error(k));
        Some((all[k].value(), own.or(all[k].unknown.prior.map(|prior| prior.deviation))?))
    };
    muscle::Known {
        releases: trials().count(),
        pressure_pa: muscle::Known::span(trials().filter_map(|trial| trial.release.pressure)),
        payload_kg: muscle::Known::span(trials().map(|trial| trial.release.payload)),
        parameter: own.iter().map(parameter).collect(),
        marker: marker(trials().map(|trial| &trial.release), nuisance),
        ..muscle::Known::default()
    }
}

/// Places of the unknowns of a fit that are parameters of a candidate's effect.
pub(super) fn places_of<'a>(fit: &'a Joint, candidate: &Candidate) -> impl Iterator<Item = usize> + use<'a> {
    let prefix = prefix(candidate.name());
    let unknowns = fit.objective.part.unknowns.iter().enumerate();
    unknowns.filter(move |(_, own)| own.name.starts_with(&prefix)).map(|(place, _)| place)
}

/// What names of an effect's parameters begin with.
pub(super) fn prefix(effect: &str) -> String {
    format!("effects.{effect}.")
}

/// Values of an effect's parameters, with what is said of the bounds of an unknown where the data determine it.
fn values(
    fit: &Joint,
    candidate: &Candidate,
    of: &Uncertainty,
    bounds: &dyn Fn(usize, &Estimate) -> [f64; 2],
) -> Vec<ParameterValue> {
    let prefix = prefix(candidate.name());
    let mut values = Vec::new();
    for (k, known) in fit.known().iter().enumerate() {
        let Some(name) = known.unknown.name.strip_prefix(&prefix) else { continue };
        let is_determined = of.is_determined[k];
        // Beyond what is admitted there is nothing.
        let (least, most) = known.unknown.bounds;
        let interval = || bounds(k, known).map(|x| known.unknown.scaled.value(x.max(least).min(most)));
        values.push(ParameterValue {
            name: name.to_owned(),
            unit: known.unknown.unit.to_owned(),
            of: match known.unknown.group {
                Group::All => None,
                Group::Pressure(pressure) => Some(format_si(pressure, "Pa")),
                Group::Release(t) => fit.name_of(t),
            },
            value: known.value(),
            interval_95: is_determined.then(interval),
        });
    }
    for (parameter, value) in candidate.tried.iter().filter(|(parameter, _)| parameter.plausible.is_none()) {
        let (name, unit) = (parameter.name.to_owned(), parameter.unit.to_owned());
        values.push(ParameterValue { name, unit, of: None, value: *value, interval_95: None });
    }
    values
}

/// Bounds of an unknown where the cost is a parabola.
fn parabola(of: &Uncertainty, k: usize, known: &Estimate) -> [f64; 2] {
    let deviation = of.covariance[(k, k)].max(0.0).sqrt();
    [-1.0, 1.0].map(|side| known.x + side * NORMAL_95 * deviation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{FittedParameter, Nuisances, Prior, Scope};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::diagnose::planned::record;
    use crate::diagnose::prune::pruned;
    use crate::diagnose::shortlist::Best;

    /// A rod that a hand holds aside, with a prior of EI. `curvature` is its natural curvature times its length.
    fn pulled(curvature: f64) -> Problem {
        let trial = hold::tests::pulled(curvature);
        let bending_stiffness = trial.model.rod().bending_stiffness;
        let prior = Some(Prior { mean: bending_stiffness, deviation: 0.05 * bending_stiffness });
        let stiffness =
            FittedParameter { prior, ..FittedParameter::new("rod.bending_stiffness", Scope::Shared) };
        let nuisances = Nuisances { offset: Some(5e-4), release_instant: true, ..Nuisances::default() };
        Problem { trials: vec![trial.into()], parameters: vec![stiffness], nuisances }
    }

    /// A release of a rod with a natural curvature, as in `pulled`, and a model without it.
    fn curved(curvature: f64) -> Problem {
        let mut seen = pulled(curvature);
        record(&mut seen, &[]).unwrap();
        let mut problem = pulled(0.0);
        for (trial, seen) in problem.trials_mut().zip(&seen.trials) {
            trial.release = seen.release.clone();
            hold::hold(trial).unwrap();
        }
        problem
    }

    fn named(problem: &Problem, name: &str) -> Candidate {
        let all = candidates(problem, &DiagnosisSettings::default());
        all.into_iter().find(|own| own.name() == name).unwrap()
    }

    /// Natural curvature over what is asked.
    fn share(known: &[Estimate], asked: f64) -> f64 {
        let path = "effects.set_curvature.natural_curvature";
        known.iter().find(|own| own.unknown.name == path).unwrap().value() / asked
    }

    /// Nearly three times as much as is believed, from a score that asks for 0.8 of it.
    #[test]
    fn a_set_curvature_beyond_what_is_believed_is_found() {
        let problem = curved(-0.4);
        let asked = -0.4 / problem.trials[0].model.rod().length;
        let without = Joint::search(&problem, &|_| ()).unwrap();
        let found = rough(&named(&problem, "set_curvature"), 0.8 * asked, &without).unwrap().unwrap();
        let share = share(&found.known, asked);
        assert!((share - 1.0).abs() < 0.02, "{share}");
    }

    /// A scale that was taken for it is not needed beside it, and it keeps its size.
    #[test]
    fn what_is_beyond_what_is_believed_stays_when_another_effect_goes() {
        let problem = curved(-0.4);
        let asked = -0.4 / problem.trials[0].model.rod().length;
        let added = |fit: &Joint, name: &str, strength: f64| {
            let candidate = named(&problem, name);
            let found = rough(&candidate, strength, fit).unwrap().unwrap();
            let refit = refit(&found, &candidate, false).unwrap().unwrap();
            let (held_out, members) = (None, Vec::new());
            Best { candidate, refit, held_out, variance_inflation: 1.0, penalty: 4.0, gain: 0.0, members }
        };
        let scale = added(&Joint::search(&problem, &|_| ()).unwrap(), "scale", 0.01);
        let curvature = added(&scale.refit.fitted, "set_curvature", 0.8 * asked);
        let (known, cost) = (curvature.refit.known.clone(), curvature.refit.cost);
        let lean = pruned(&problem, &[scale, curvature], &known, cost).unwrap().expect("one is unnecessary");
        let share = share(&lean.known, asked);
        assert!(lean.left_out == 0 && (share - 1.0).abs() < 0.02, "{share}");
    }
}
