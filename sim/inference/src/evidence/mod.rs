//! One inference: hypotheses are weighed by what an expert compares, then by all samples.
//!
//! Experimental: `efam diagnose --method features`. A hypothesis is a model with unknowns that all have proper priors
//! (`setup.rs`). Nothing, every effect of the catalogue and every statement that may be wrong are hypotheses (`candidates.rs`); a
//! screen at a few strengths chooses which are fitted (`screen.rs`). The fit compares features of all releases
//! (`likelihood.rs`, `search.rs`): they are smooth in all unknowns, so that starts matter little. Those that features favour are
//! fitted to all samples (`samples.rs`), whose evidence by Laplace's method decides. The verdict is odds (`verdict.rs`), and one
//! rule beside: odds do not know that the truth is absent, so the misfit must fall by half, or the answer is unknown.

mod answer;
mod candidates;
mod data;
mod hypothesis;
mod likelihood;
mod samples;
mod screen;
mod search;
mod setup;
mod unknown;
pub mod verdict;
mod words;

use std::sync::Arc;

use efam_core::work::Work;
use efam_experiments::cleaning::Cleaned;
use efam_experiments::experiment::Experiment;
use rayon::prelude::*;

use crate::calibrate::{CalibrateError, Problem, SectionError};
use crate::diagnose::{DiagnosisSettings, Listener, section};
use crate::normal::NORMAL_95;
use candidates::{Extension, effects, statements};
use data::Data;
use samples::Sampled;
use screen::{Origin, Screened, beside, screen};
use search::{Effort, FIRST_SHARE, Fit, fit};
pub use verdict::Weighed;
use verdict::{Odds, Round};

/// Candidates of a round that are fitted at least and at most, and how far behind the best by the screen one may be.
const LEAST_FITTED: usize = 5;
const MOST_FITTED: usize = 12;
const BEHIND: f64 = 15.0;
/// Tries of one effect that are fitted: a memory may be short or long.
const TRIES: usize = 2;
/// Candidates that are fitted to all samples, of those that features favour at all.
const MOST_SAMPLED: usize = 4;
/// Log odds within which two answers are one class: twenty to one.
const CLASS: f64 = 3.0;
/// Log odds over all candidates together that an answer needs beside, `ln K` being their number.
const MARGIN: f64 = 2.0;
/// A fit whose log evidence is so far below that of the model that it extends ended in a local minimum, and begins again.
const LOCAL_MINIMUM: f64 = 2.0;
/// Prior standard deviations between the optimum and the priors' means from which on candidates are tried from both.
const FAR: f64 = 2.0;
/// Evaluations of a fit from the priors' means in each round, and of a candidate's.
const BASE_EFFORT: Effort = Effort(25);
const EFFORT: Effort = Effort(12);

/// The problem of an experiment: as of a calibration, losses shared, a stated stiffness with the prior of a test.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub fn problem(experiment: &Experiment, cleaned: &Cleaned) -> Result<Problem, SectionError> {
    section::parameters(experiment, cleaned)
}

/// A candidate that was fitted.
struct Tried {
    name: String,
    fit: Fit,
    sampled: Option<Sampled>,
    /// Places of its strengths among the unknowns, and the logarithm of its prior odds.
    strengths: Vec<usize>,
    odds: f64,
    /// Log odds over the model before, by features and, where they were fitted, by all samples.
    features: f64,
    all: f64,
}

/// A candidate that was fitted to all samples.
struct Accepted {
    name: String,
    fit: Fit,
    sampled: Sampled,
    /// Log odds over the model before.
    all: f64,
}

/// Weighs what may be missing.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where the model cannot be run.
pub fn diagnose(
    problem: &Problem,
    settings: &DiagnosisSettings,
    listener: &dyn Listener,
) -> Result<Weighed, CalibrateError> {
    let name = problem.trials.first().map_or(String::new(), |trial| trial.release.name.clone());
    let of_model = |error| CalibrateError::Model { release: name.clone(), error };
    let mut trials = setup::trials(problem).map_err(of_model)?;
    let work = Work::limited(settings.budget);
    trials.iter_mut().for_each(|trial| trial.run.work = work.clone());
    if trials.is_empty() {
        return Err(CalibrateError::NoTrials);
    }
    listener.doing("features of the recordings");
    let (data, places) = Data::of(&trials);
    let mut warnings: Vec<String> = (0..trials.len())
        .filter(|r| !places.contains(r))
        .map(|r| format!("{}: shows no swing, and takes no part", trials[r].release.name))
        .collect();
    let trials: Vec<_> = places.iter().map(|r| trials[*r].clone()).collect();
    if trials.is_empty() {
        return Err(CalibrateError::NoFit { release: name });
    }
    let nothing = Arc::new(setup::nothing(problem, trials, &data.plans).map_err(of_model)?);
    listener.doing("the model as it is");
    let no_fit = || CalibrateError::NoFit { release: name.clone() };
    let start = nothing.start();
    let at_means = Arc::new(data.compare(&nothing, &start, &|_| true).ok_or_else(no_fit)?);
    let baseline =
        fit(&data, &nothing, &start, Some(at_means.clone()), FIRST_SHARE, BASE_EFFORT).ok_or_else(no_fit)?;
    let mut baseline_sampled = samples::fit(&data, &nothing, &baseline.z).ok_or_else(no_fit)?;
    listener.began();
    // A setup that is found where it is stated is one origin, not two.
    let is_far = (&baseline.z - &start).amax() > FAR;
    let means = is_far.then(|| Origin { z: &start, compared: &at_means });
    let (mut rounds, mut accepted): (Vec<Round>, Vec<Accepted>) = (Vec::new(), Vec::new());
    let mut members = Vec::new();
    for number in 0..settings.most_effects {
        if listener.stop().is_requested() {
            break;
        }
        // Between parts of the search no run is in progress, so the count is that of any machine.
        if work.is_spent() {
            warnings.push(format!("the budget ended the search before round {}", number + 1));
            break;
        }
        let others = if accepted.is_empty() { means.as_slice() } else { &[] };
        let (base, sampled) = match accepted.last_mut() {
            Some(last) => (&last.fit, &mut last.sampled),
            None => (&baseline, &mut baseline_sampled),
        };
        let (bar, tried) = round(&data, base, sampled, others, settings, number, listener);
        rounds.push(Round { bar, share: base.share, candidates: tried.iter().map(Tried::odds_of).collect() });
        // What was not fitted to all samples is no answer.
        let mut sampled = tried.into_iter().filter_map(Tried::sampled);
        let Some(best) = sampled.next().filter(|best| best.all >= bar) else { break };
        members = sampled.filter(|own| best.all - own.all < CLASS).map(|own| own.name).collect();
        // What does not repeat is no second effect.
        let is_done = best.sampled.is_little(data.first_swing());
        accepted.push(best);
        if is_done {
            break;
        }
    }
    if data.plans.iter().any(|plan| plan.frequency * (plan.time[1] - plan.time[0]) > 0.1) {
        warnings.push("fewer than ten samples in a cycle: turns are known badly".to_owned());
    }
    Ok(answer::answer(&data, &baseline, &baseline_sampled, &accepted, members, rounds, warnings))
}

/// One round: every candidate is screened, some are fitted, and the best also to all samples; the best first.
fn round(
    data: &Data,
    base: &Fit,
    base_sampled: &mut Sampled,
    others: &[Origin],
    settings: &DiagnosisSettings,
    number: usize,
    listener: &dyn Listener,
) -> (f64, Vec<Tried>) {
    listener.doing(&format!("round {}: screen", number + 1));
    let mut extensions = effects(&base.hypothesis, settings);
    extensions.extend(statements(&base.hypothesis));
    let mut names: Vec<&str> = extensions.iter().map(|own| own.name.as_str()).collect();
    names.dedup();
    let bar = (names.len() as f64).ln() + MARGIN;
    let screened = screen(data, base, others, extensions);
    let chosen = chosen(screened);
    listener.doing(&format!("round {}: {} fits", number + 1, chosen.len()));
    let fitted = |own: Screened| {
        let hypothesis = Arc::new(own.extension.hypothesis.clone());
        let first = fit(data, &hypothesis, &own.start, None, own.share, EFFORT);
        let is_lost = first.as_ref().is_none_or(|fit| fit.evidence < base.evidence - LOCAL_MINIMUM);
        let again = is_lost.then(|| {
            fit(data, &hypothesis, &beside(base, &base.z, &own.extension), None, base.share, EFFORT)
        });
        let best = [first, again.flatten()]
            .into_iter()
            .flatten()
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        let features = best.evidence - base.evidence + own.extension.odds;
        let Extension { name, strengths, odds, .. } = own.extension;
        Some(Tried { name, features, all: features, fit: best, sampled: None, strengths, odds })
    };
    let mut tried: Vec<Tried> =
        chosen.into_par_iter().map(fitted).collect::<Vec<_>>().into_iter().flatten().collect();
    tried.sort_by(|a, b| b.features.total_cmp(&a.features));
    // The better of several tries of one effect stays.
    let mut seen: Vec<String> = Vec::new();
    tried.retain(|own| {
        let is_new = !seen.contains(&own.name);
        seen.push(own.name.clone());
        is_new
    });
    let near: Vec<&mut Tried> =
        tried.iter_mut().take(MOST_SAMPLED).filter(|own| own.features > 0.0).collect();
    listener.doing(&format!("round {}: all samples", number + 1));
    near.into_par_iter().for_each(|own| {
        own.sampled = samples::fit(data, &own.fit.hypothesis, &own.fit.z);
    });
    again(data, base, base_sampled, &tried);
    for own in &mut tried {
        if let Some(sampled) = &own.sampled {
            own.all = sampled.evidence - base_sampled.evidence + own.odds;
        }
    }
    // Those that were not fitted to all samples stay behind.
    tried.sort_by(|a, b| b.sampled.is_some().cmp(&a.sampled.is_some()).then(b.all.total_cmp(&a.all)));
    (bar, tried)
}

/// Fits the model before to all samples once more, from where the best candidate leads without its strength: what the setup
/// explains is no evidence of an effect.
fn again(data: &Data, base: &Fit, base_sampled: &mut Sampled, tried: &[Tried]) {
    let effects = tried.iter().filter(|own| !own.strengths.is_empty()).filter_map(|own| own.sampled.as_ref());
    let Some(best) = effects.max_by(|a, b| a.evidence.total_cmp(&b.evidence)) else { return };
    let start = best.z.rows(0, base.z.len()).into_owned();
    if let Some(found) =
        samples::fit(data, &base.hypothesis, &start).filter(|own| own.evidence > base_sampled.evidence)
    {
        *base_sampled = found;
    }
}

/// The candidates that are fitted: the most promising, and not too many tries of one effect.
fn chosen(screened: Vec<Screened>) -> Vec<Screened> {
    let top = screened.first().map_or(0.0, |own| own.promise);
    let mut chosen: Vec<Screened> = Vec::new();
    for own in screened {
        let tries = chosen.iter().filter(|other| other.extension.name == own.extension.name).count();
        let is_near = top - own.promise < BEHIND;
        if tries < TRIES && chosen.len() < MOST_FITTED && (is_near || chosen.len() < LEAST_FITTED) {
            chosen.push(own);
        }
    }
    chosen
}

impl Tried {
    /// What was fitted to all samples, unless the interval of its strength holds zero.
    fn sampled(self) -> Option<Accepted> {
        let sampled = self.sampled?;
        let is_off = |u: &usize| sampled.z[*u].abs() > NORMAL_95 * sampled.covariance[(*u, *u)].sqrt();
        let is_told = self.strengths.is_empty() || self.strengths.iter().any(is_off);
        is_told.then_some(Accepted { name: self.name, fit: self.fit, sampled, all: self.all })
    }

    fn odds_of(&self) -> Odds {
        Odds {
            name: self.name.clone(),
            features: self.features,
            all: self.sampled.as_ref().map(|_| self.all),
            share: self.fit.share,
            rms_mm: self.sampled.as_ref().map(|own| 1e3 * own.rms),
        }
    }
}
