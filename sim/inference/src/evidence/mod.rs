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
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::calibrate::repeats::quantile_of_f;
use crate::calibrate::{CalibrateError, Problem, SectionError, Trial};
use crate::diagnose::{DiagnosisSettings, Listener, section};
use candidates::{Extension, effects, statements};
use data::Data;
use hypothesis::Hypothesis;
use likelihood::{FIRST_SHARE, Features, Fit};
use samples::{Sampled, Samples};
use screen::{Promise, Screened, beside, screen};
use search::{EFFORT, Effort, Point, steps};
pub use verdict::Weighed;
use verdict::{Odds, Round};

/// Candidates of a round that are fitted at least and at most, and how far behind the best by the screen one may be. The promise of a
/// linearised model is rough where the misfit is large.
const LEAST_FITTED: usize = 8;
const MOST_FITTED: usize = 12;
const BEHIND: f64 = 15.0;
/// Tries of one effect that are fitted: a memory may be short or long.
const TRIES: usize = 2;
/// Candidates that are fitted to their end by features, and to all samples, by each of the two promises.
const MOST_SAMPLED: usize = 4;
/// Log odds within which two answers are one class: twenty to one.
const CLASS: f64 = 3.0;
/// Log odds over all candidates together that an answer needs beside, `ln K` being their number.
const MARGIN: f64 = 2.0;
/// A fit whose log evidence is so far below that of the model that it extends ended in a local minimum, and begins again.
const LOCAL_MINIMUM: f64 = 2.0;
/// Prior standard deviations between the optimum and the priors' means from which on candidates are tried from both.
const FAR: f64 = 2.0;
/// How much a fit may cost by features: of the model as it is, and of a candidate's first steps.
const BASE_EFFORT: Effort = Effort { rounds: 5, evaluations: 25 };
const FIRST_STEPS: usize = 4;

/// The problem of an experiment: as of a calibration, losses shared, a stated stiffness with the prior of a test.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub fn problem(experiment: &Experiment, cleaned: &Cleaned) -> Result<Problem, SectionError> {
    section::parameters(experiment, cleaned)
}

/// A candidate that was fitted.
struct Tried<'a> {
    extension: &'a Extension,
    fit: Fit,
    sampled: Option<Sampled>,
    /// Log odds over the model before, by features and, where they were fitted, by all samples.
    features: f64,
    all: f64,
}

/// A candidate that was accepted.
struct Accepted {
    name: String,
    sampled: Sampled,
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
    let work = Work::limited(settings.budget);
    let trials = |is_coarse: bool| {
        let mut trials = setup::trials(problem, is_coarse).map_err(of_model)?;
        trials.iter_mut().for_each(|trial| trial.run.work = work.clone());
        Ok(trials)
    };
    let own_mesh = trials(false)?;
    let trials = trials(true)?;
    if trials.is_empty() {
        return Err(CalibrateError::NoTrials);
    }
    listener.doing("features of the recordings");
    let (data, places) = Data::of(&trials);
    let mut warnings: Vec<String> = (0..trials.len())
        .filter(|r| !places.contains(r))
        .map(|r| format!("{}: shows no swing, and takes no part", trials[r].release.name))
        .collect();
    if places.is_empty() {
        return Err(CalibrateError::NoFit { release: name });
    }
    let nothing = |trials: Vec<Trial>| {
        let trials = places.iter().map(|r| trials[*r].clone()).collect();
        Ok(Arc::new(setup::nothing(problem, trials, &data.plans).map_err(of_model)?))
    };
    let no_fit = || CalibrateError::NoFit { release: name.clone() };
    listener.doing("the model as it is");
    let (mut nothing, fine) = (nothing(trials)?, nothing(own_mesh)?);
    let mut at_means = Point::of(&data, &nothing, nothing.start()).ok_or_else(no_fit)?;
    let edges = |of: &Hypothesis| of.trials.iter().map(|trial| trial.model.edges).collect::<Vec<_>>();
    if edges(&nothing) != edges(&fine) && !data.is_same(&at_means, &fine).ok_or_else(no_fit)? {
        nothing = fine;
        at_means = Point::of(&data, &nothing, nothing.start()).ok_or_else(no_fit)?;
    }
    let by_features = Fit::by_features(&data, &nothing, at_means.clone(), FIRST_SHARE, BASE_EFFORT);
    let mut baseline = Sampled::from(&data, &by_features.ok_or_else(no_fit)?).ok_or_else(no_fit)?;
    listener.began();
    // A setup that is found where it is stated is one origin, not two.
    let is_far = (&baseline.fit.at.z - &at_means.z).amax() > FAR;
    let means = is_far.then_some(&at_means);
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
        let base = accepted.last_mut().map_or(&mut baseline, |last| &mut last.sampled);
        let extensions = extensions(&base.fit, settings);
        let mut names: Vec<&str> = extensions.iter().map(|own| own.name.as_str()).collect();
        names.dedup();
        let bar = (names.len() as f64).ln() + MARGIN;
        listener.doing(&format!("round {}: screen", number + 1));
        let screened = screen(&data, base, others, extensions);
        let share = base.fit.share;
        let tried = round(&data, base, &screened, number, listener);
        rounds.push(Round { bar, share, candidates: tried.iter().map(Tried::odds_of).collect() });
        // What was not fitted to all samples is no answer.
        let mut sampled = tried.into_iter().filter_map(Tried::accepted);
        let Some((all, best)) = sampled.next().filter(|(all, _)| *all >= bar) else { break };
        members = sampled.filter(|(own, _)| all - own < CLASS).map(|(_, own)| own.name).collect();
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
    Ok(answer::answer(&data, &baseline, &accepted, members, rounds, warnings))
}

/// Everything that may be missing or wrong beside a model.
fn extensions(base: &Fit, settings: &DiagnosisSettings) -> Vec<Extension> {
    let mut all = effects(&base.hypothesis, settings);
    all.extend(statements(&base.hypothesis));
    all
}

/// One round: the most promising candidates are fitted by features, and the best to all samples; the best first.
fn round<'a>(
    data: &Data,
    base: &mut Sampled,
    screened: &'a [Screened],
    number: usize,
    listener: &dyn Listener,
) -> Vec<Tried<'a>> {
    listener.doing(&format!("round {}: fits by features", number + 1));
    let mut tried: Vec<Tried> = leaders(screened, |own| own.by_features.as_ref(), MOST_FITTED)
        .into_par_iter()
        .filter_map(|(own, promise)| {
            Some(Tried::of(base, &own.extension, first_steps(data, base, own, promise)?))
        })
        .collect();
    tried.sort_by(|a, b| b.features.total_cmp(&a.features));
    let top = tried.first().map_or(0.0, |own| own.features);
    tried.par_iter_mut().take(MOST_SAMPLED).filter(|own| top - own.features < BEHIND).for_each(|own| {
        let (hypothesis, share) = (&own.fit.hypothesis, own.fit.share);
        let found = Point::of(data, hypothesis, own.fit.at.z.clone())
            .and_then(|start| Fit::by_features(data, hypothesis, start, share, EFFORT));
        if let Some(found) = found {
            *own = Tried::of(base, own.extension, found);
        }
    });
    listener.doing(&format!("round {}: fits to all samples", number + 1));
    tried.par_iter_mut().take(MOST_SAMPLED).filter(|own| own.features > 0.0).for_each(|own| {
        own.sampled = Sampled::from(data, &own.fit);
    });
    let direct = |(own, promise): (&'a Screened, &Promise)| {
        let hypothesis = Arc::new(own.extension.hypothesis.clone());
        let (start, slopes) = (&promise.start, promise.slopes());
        let misfits = Samples::misfits(data, &base.fit.at.seen);
        let near = steps(&Samples, data, &hypothesis, start, &slopes, &misfits, FIRST_STEPS)?;
        let fit = Fit::at(data, &hypothesis, Point::of(data, &hypothesis, near.z)?, promise.share);
        let sampled = Sampled::from(data, &fit)?;
        let tried = Tried::of(base, &own.extension, sampled.fit.clone());
        Some(Tried { sampled: Some(sampled), ..tried })
    };
    let by_samples = leaders(screened, |own| own.by_samples.as_ref(), MOST_SAMPLED);
    let is_hopeful = |(_, promise): &(&Screened, &Promise)| promise.odds > 0.0;
    // What came to more than was promised is there already.
    let is_new = |(own, promise): &(&Screened, &Promise)| {
        let of = |tried: &Tried| {
            tried.sampled.as_ref().map(|found| found.evidence - base.evidence + own.extension.odds)
        };
        let is_there =
            |tried: &Tried| tried.extension.name == own.extension.name && of(tried) >= Some(promise.odds);
        !tried.iter().any(is_there)
    };
    let by_samples: Vec<_> = by_samples.into_iter().filter(is_new).collect();
    tried.extend(by_samples.into_par_iter().filter(is_hopeful).filter_map(direct).collect::<Vec<_>>());
    again(data, base, &tried);
    for own in &mut tried {
        own.all = own.sampled.as_ref().map_or(f64::NEG_INFINITY, |sampled| sampled.evidence) - base.evidence
            + own.extension.odds;
    }
    // Those that were not fitted to all samples stay behind.
    tried.sort_by(|a, b| b.all.total_cmp(&a.all).then(b.features.total_cmp(&a.features)));
    // The best of several tries of one effect stays.
    let mut seen: Vec<&str> = Vec::new();
    tried.retain(|own| {
        let is_new = !seen.contains(&own.extension.name.as_str());
        seen.push(&own.extension.name);
        is_new
    });
    tried
}

/// The first steps of a candidate's fit by features; from beside the model before where they are lost.
fn first_steps(data: &Data, base: &Sampled, own: &Screened, promise: &Promise) -> Option<Fit> {
    let hypothesis = Arc::new(own.extension.hypothesis.clone());
    let slopes = promise.slopes();
    let from = |start: &DVector<f64>, share: f64| {
        let at = steps(&Features, data, &hypothesis, start, &slopes, &share, FIRST_STEPS)?;
        Some(Fit::at(data, &hypothesis, at, share))
    };
    let first = from(&promise.start, promise.share);
    let is_lost = first.as_ref().is_none_or(|fit| fit.evidence < base.fit.evidence - LOCAL_MINIMUM);
    let again = is_lost.then(|| from(&beside(base, &base.fit.at.z, &own.extension), base.fit.share));
    [first, again.flatten()].into_iter().flatten().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Fits the model before to all samples once more, from where the best candidate leads without its strength: what the setup
/// explains is no evidence of an effect.
fn again(data: &Data, base: &mut Sampled, tried: &[Tried]) {
    let effects = tried.iter().filter(|own| !own.extension.strengths.is_empty());
    let best =
        effects.filter_map(|own| own.sampled.as_ref()).max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    let Some(best) = best else { return };
    let start = best.fit.at.z.rows(0, base.fit.at.z.len()).into_owned();
    let Some(start) = Point::of(data, &base.fit.hypothesis, start) else { return };
    let fit = Fit::at(data, &base.fit.hypothesis, start, base.fit.share);
    if let Some(found) = Sampled::from(data, &fit).filter(|own| own.evidence > base.evidence) {
        *base = found;
    }
}

/// The most promising candidates that are near the best, and not too many tries of one effect.
fn leaders(
    screened: &[Screened],
    promise: impl Fn(&Screened) -> Option<&Promise>,
    most: usize,
) -> Vec<(&Screened, &Promise)> {
    let mut all: Vec<_> = screened.iter().filter_map(|own| Some((own, promise(own)?))).collect();
    all.sort_by(|a, b| b.1.odds.total_cmp(&a.1.odds));
    let top = all.first().map_or(0.0, |(_, promise)| promise.odds);
    let mut chosen: Vec<(&Screened, &Promise)> = Vec::new();
    for own in all {
        let tries = chosen.iter().filter(|other| other.0.extension.name == own.0.extension.name).count();
        let is_near = top - own.1.odds < BEHIND || chosen.len() < LEAST_FITTED;
        if tries < TRIES && chosen.len() < most && is_near {
            chosen.push(own);
        }
    }
    chosen
}

impl<'a> Tried<'a> {
    fn of(base: &Sampled, extension: &'a Extension, fit: Fit) -> Self {
        let features = fit.evidence - base.fit.evidence + extension.odds;
        Self { extension, fit, sampled: None, features, all: f64::NEG_INFINITY }
    }

    /// What was fitted to all samples, with its log odds, unless the interval of its strengths together holds zero.
    fn accepted(self) -> Option<(f64, Accepted)> {
        let (sampled, strengths) = (self.sampled?, &self.extension.strengths);
        let z = DVector::from_iterator(strengths.len(), strengths.iter().map(|u| sampled.fit.at.z[*u]));
        let covariance = sampled.covariance.select_rows(strengths).select_columns(strengths);
        let is_significant = strengths.is_empty() || is_off(&z, covariance)?;
        is_significant.then(|| (self.all, Accepted { name: self.extension.name.clone(), sampled }))
    }

    fn odds_of(&self) -> Odds {
        Odds {
            name: self.extension.name.clone(),
            features: self.features,
            all: self.sampled.as_ref().map(|_| self.all),
            share: self.fit.share,
            rms_mm: self.sampled.as_ref().map(|own| 1e3 * own.rms),
        }
    }
}

/// Whether zero lies outside of the interval of 95 % of numbers that are normal together: chi-squared, which is F with no end of
/// degrees of freedom below. None where the covariance is none.
fn is_off(z: &DVector<f64>, covariance: DMatrix<f64>) -> Option<bool> {
    const NO_END: f64 = 1e9;
    let count = z.len() as f64;
    Some(z.dot(&covariance.cholesky()?.solve(z)) > count * quantile_of_f(count, NO_END))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two numbers whose sum is known badly and whose difference is known well: neither is off by itself, but together they are.
    /// The 95 % point of chi-squared is 5.99 for two and 3.84 for one.
    #[test]
    fn strengths_may_be_off_together() {
        let alike = DMatrix::from_row_slice(2, 2, &[1.0, 0.99, 0.99, 1.0]);
        let of = |z: [f64; 2], covariance: &DMatrix<f64>| {
            is_off(&DVector::from_column_slice(&z), covariance.clone())
        };
        assert_eq!(of([0.3, -0.3], &alike), Some(true));
        assert_eq!(of([0.3, 0.3], &alike), Some(false));
        let one = |z: f64| is_off(&DVector::from_element(1, z), DMatrix::identity(1, 1)).unwrap();
        assert!(one(2.0) && one(-2.0) && !one(1.9));
        let apart = DMatrix::identity(2, 2);
        assert_eq!((of([1.75, 1.75], &apart), of([1.7, 1.7], &apart)), (Some(true), Some(false)));
    }
}
