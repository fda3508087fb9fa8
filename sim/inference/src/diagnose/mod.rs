//! Diagnosis: where simulation and recordings disagree, which effect is missing, and what remains when it is added.
//!
//! Hypotheses are weighed by what an expert compares, then by all samples. A hypothesis is a model with unknowns that all have
//! proper priors (`setup.rs`). Nothing, every effect of the catalogue and every statement that may be wrong are hypotheses
//! (`extension.rs`); a screen at a few strengths chooses which are fitted (`screen.rs`). The fit compares features of all
//! releases (`likelihood.rs`, `search.rs`): they are smooth in all unknowns, so that starts matter little. Those that features
//! favour are fitted to all samples (`samples.rs`), whose evidence by Laplace's method decides (`round.rs`). The verdict is odds
//! (`answer.rs`), and one rule beside: odds do not know that the truth is absent, so the misfit must fall by half, or the answer
//! is unknown. Releases that are held out take no part in this, and show what the answer is worth (`outcome.rs`).

mod answer;
pub(crate) mod candidate;
pub mod curve;
mod data;
mod equations;
mod extension;
mod extra;
mod hypothesis;
mod likelihood;
mod outcome;
pub mod plan;
mod planned;
mod round;
mod samples;
mod screen;
mod search;
pub(crate) mod section;
mod settings;
mod setup;
mod slopes;
mod stated;
mod summary_text;
mod swing;
mod traces;
mod unknown;
pub mod verdict;
mod warnings;
mod words;

use std::sync::Arc;

use efam_core::forward::Cancel;
use efam_core::work::Work;
use models::muscle;

use crate::calibrate::{CalibrateError, Problem, Trial};
pub use curve::Curve;
use data::Data;
use extension::{Extension, Group, effects, statements};
use hypothesis::{Hypothesis, refusal};
use likelihood::{FIRST_SHARE, Fit};
use round::{round, weighed};
use samples::Sampled;
use screen::screen;
use search::{Effort, Point};
pub use section::{known_effects, problem};
pub use settings::{DiagnosisSettings, USUAL_BUDGET};
pub use stated::without;
use verdict::{CutBy, CutShort, Round};
pub use verdict::{Diagnosis, Verdict};

/// Prior standard deviations between the optimum and the priors' means from which on candidates are tried from both.
const FAR: f64 = 2.0;
/// How much a fit of the model as it is may cost by features.
const BASE_EFFORT: Effort = Effort { rounds: 5, evaluations: 25 };

/// Receives the progress of a diagnosis, from any thread. A closure receives what is being done.
pub trait Listener: Sync {
    /// What is being done.
    fn doing(&self, what: &str);

    /// The candidates of a round, counted from one, with their odds.
    fn ranked(&self, _number: usize, _round: &Round) {}

    /// The model as it is is fitted: from here on a search that is cut short has an answer.
    fn began(&self) {}

    /// A request to end the search at the next opportunity, with what was found by then.
    fn stop(&self) -> Cancel {
        Cancel::default()
    }
}

impl<F: Fn(&str) + Sync> Listener for F {
    fn doing(&self, what: &str) {
        self(what);
    }
}

/// What was found, with the model that has it.
#[derive(Clone)]
pub struct DiagnosisOutcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The problem with what was found before anything was added set in its models.
    pub baseline: Problem,
    /// The same with the effects in its models.
    pub repaired: Problem,
    /// How well its parameters are known.
    pub errors: muscle::Known,
    /// Each track of each release as it was measured, and as it is predicted before and after; first those
    /// that were fitted.
    pub curves: Vec<Curve>,
}

/// A hypothesis that was accepted, or that explains as much.
struct Accepted {
    name: String,
    /// Places of its strengths; none of a statement.
    strengths: Vec<usize>,
    /// Log odds over the model before.
    odds: f64,
    sampled: Sampled,
}

/// A search as it ended.
struct Found {
    data: Data,
    /// Places of the compared releases in the problem.
    places: Vec<usize>,
    baseline: Sampled,
    accepted: Vec<Accepted>,
    /// What explains as much as one that was accepted, with its place.
    members: Vec<(usize, Accepted)>,
    rounds: Vec<Round>,
    /// Whether the last round has an answer that may not be added.
    has_more: bool,
    cut_short: Option<CutShort>,
}

impl Found {
    /// Takes the last answer back, for held-out releases contradict it.
    fn refuse_last(&mut self) {
        self.accepted.pop();
        let left = self.accepted.len();
        self.members.retain(|(place, _)| *place < left);
        let candidates = self.rounds.iter_mut().skip(left).flat_map(|round| &mut round.candidates);
        candidates
            .filter(|own| own.rejected.is_none())
            .for_each(|own| own.rejected = Some("held-out releases contradict it".to_owned()));
    }
}

/// Finds what is missing.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where the model as it is cannot be fitted.
pub fn diagnose(
    problem: &Problem,
    settings: &DiagnosisSettings,
    listener: &dyn Listener,
) -> Result<DiagnosisOutcome, CalibrateError> {
    let work = Work::limited(settings.budget);
    let mut search = Search::begin(problem, settings, listener, &work)?;
    search.run();
    outcome::outcome(problem, settings, search.found, listener, &work)
}

/// A search in progress.
struct Search<'a> {
    settings: &'a DiagnosisSettings,
    listener: &'a dyn Listener,
    work: &'a Work,
    /// The priors' means, where the model as it is is far from them.
    means: Option<Point>,
    found: Found,
}

impl<'a> Search<'a> {
    /// Fits the model as it is.
    fn begin(
        problem: &Problem,
        settings: &'a DiagnosisSettings,
        listener: &'a dyn Listener,
        work: &'a Work,
    ) -> Result<Self, CalibrateError> {
        let trials = |is_coarse: bool| {
            let mut trials = setup::trials(problem, is_coarse).map_err(|error| problem.refused(error))?;
            for trial in &mut trials {
                (trial.run.work, trial.run.cancel) = (work.clone(), listener.stop());
            }
            Ok(trials)
        };
        let own_mesh = trials(false)?;
        let trials = trials(true)?;
        if trials.iter().all(|trial| trial.release.held_out) {
            return Err(CalibrateError::NoTrials);
        }
        listener.doing("features of the recordings");
        let (data, places) = Data::of(&trials, settings.repeatability, None);
        if data.plans.is_empty() {
            return Err(CalibrateError::NoFit { release: problem.first_name() });
        }
        let nothing = |trials: Vec<Trial>| {
            let trials = places.iter().map(|r| trials[*r].clone()).collect();
            let nothing = setup::nothing(problem, trials, &data.all());
            Ok(Arc::new(nothing.map_err(|error| problem.refused(error))?))
        };
        listener.doing("the model as it is");
        let (mut nothing, fine) = (nothing(trials)?, nothing(own_mesh)?);
        let first = nothing.trials[0].clone();
        let no_fit = || refusal(&first);
        let mut at_means = Point::of(&data, &nothing, nothing.start()).ok_or_else(no_fit)?;
        let edges = |of: &Hypothesis| of.trials.iter().map(|trial| trial.model.edges).collect::<Vec<_>>();
        if edges(&nothing) != edges(&fine) && !data.is_same(&at_means, &fine).ok_or_else(no_fit)? {
            nothing = fine;
            at_means = Point::of(&data, &nothing, nothing.start()).ok_or_else(no_fit)?;
        }
        let by_features = Fit::by_features(&data, &nothing, at_means.clone(), FIRST_SHARE, BASE_EFFORT);
        let baseline = Sampled::from(&data, &by_features.ok_or_else(no_fit)?).ok_or_else(no_fit)?;
        listener.began();
        // A setup that is found where it is stated is one origin, not two.
        let is_far = (&baseline.fit.at.z - &at_means.z).amax() > FAR;
        let (accepted, members, rounds) = (Vec::new(), Vec::new(), Vec::new());
        let found =
            Found { data, places, baseline, accepted, members, rounds, has_more: false, cut_short: None };
        Ok(Self { settings, listener, work, means: is_far.then_some(at_means), found })
    }

    /// Adds one after another the effects that the recordings support.
    fn run(&mut self) {
        // Where none may be added, one round still shows what the recordings support.
        for number in 1..=self.settings.most_effects.max(1) {
            if self.is_cut_short(number) || !self.add(number) {
                break;
            }
        }
    }

    /// Whether the search ends before or in a round. Between rounds no run is in progress, so the count of the work is that of
    /// any machine.
    fn is_cut_short(&mut self, round: usize) -> bool {
        let Some(by) = cut_by(self.listener, self.work) else { return false };
        self.found.cut_short.get_or_insert(CutShort { round: Some(round), by });
        true
    }

    /// One round; whether another one is worth it.
    fn add(&mut self, number: usize) -> bool {
        let Found { data, baseline, accepted, members, rounds, has_more, .. } = &mut self.found;
        let others = if accepted.is_empty() { self.means.as_slice() } else { &[] };
        let base = accepted.last_mut().map_or(baseline, |last| &mut last.sampled);
        let extensions = extensions(&base.fit, self.settings);
        let mut names: Vec<&str> =
            extensions.iter().flat_map(|own| &own.extensions).map(Extension::effect).collect();
        names.sort_unstable();
        names.dedup();
        // That nothing is missing is as probable beforehand as that something is, and then each candidate alike. By Markov's
        // inequality the odds of all are so large in a share of `false_alarm` at most where nothing is missing.
        let false_alarm = self.settings.false_alarm;
        let bar = (names.len() as f64).ln() + ((1.0 - false_alarm) / false_alarm).ln();
        self.listener.doing(&format!("round {number}: screen"));
        let screened = screen(data, base, others, extensions);
        let share = base.fit.share;
        let mut tried = round(data, base, &screened, number, self.listener);
        let (round, best, near) = weighed(&tried, &screened, bar, share);
        self.listener.ranked(number, &round);
        rounds.push(round);
        let is_interrupted = self.listener.stop().is_requested();
        let may_add = accepted.len() < self.settings.most_effects;
        *has_more = best.is_some() && !may_add;
        let mut taken = |k: usize| {
            let (own, odds) = (tried[k].extension, tried[k].all);
            let sampled = tried[k].sampled.take()?;
            Some(Accepted { name: own.effect().to_owned(), strengths: own.strengths.clone(), odds, sampled })
        };
        let best = best.filter(|_| may_add).and_then(&mut taken);
        let is_next = best.as_ref().is_some_and(|own| own.sampled.misfit() > data.known_repeats());
        if let Some(best) = best {
            let place = accepted.len();
            members.retain(|(_, own)| own.name != best.name);
            members.extend(near.into_iter().filter_map(taken).map(|own| (place, own)));
            accepted.push(best);
        }
        if is_interrupted {
            self.is_cut_short(number);
        }
        // What does not repeat is no second effect.
        is_next
    }
}

/// What ends a search, if something does.
fn cut_by(listener: &dyn Listener, work: &Work) -> Option<CutBy> {
    if listener.stop().is_requested() {
        return Some(CutBy::Interruption);
    }
    work.is_spent().then_some(CutBy::Budget)
}

/// Everything that may be missing or wrong beside a model.
fn extensions(base: &Fit, settings: &DiagnosisSettings) -> Vec<Group> {
    let mut all = effects(&base.hypothesis, settings);
    all.extend(statements(&base.hypothesis));
    all
}
