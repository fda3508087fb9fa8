//! One round of a search: which candidates are fitted, and what the odds of each are over the model before.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::Listener;
use super::data::Data;
use super::extension::Extension;
use super::likelihood::{Features, Fit};
use super::samples::{Sampled, Samples, promised};
use super::screen::{Promise, Screened, beside};
use super::search::{EFFORT, Point, steps};
use super::verdict::{Odds, Round};

/// Candidates of a round that are fitted at least and at most, and how far behind the best by the screen one may be. The promise of a
/// linearised model is rough where the misfit is large. Where it is noise, one is fitted that promises anything.
const LEAST_FITTED: usize = 8;
const MOST_FITTED: usize = 12;
const BEHIND: f64 = 15.0;
/// Tries of one effect that are fitted: a memory may be short or long.
const TRIES: usize = 2;
/// Candidates that begin by the promise of all samples, at most.
const MOST_SAMPLED: usize = 4;
/// Candidates that are fitted to their end at a time: the first show by how much results exceed promises.
const HEAT: usize = 2;
/// How often some are: a class of more than eight says nothing.
const HEATS: usize = 4;
/// Log odds within which two answers are one class: twenty to one.
const CLASS: f64 = 3.0;
/// A fit whose log evidence is so far below that of the model that it extends ended in a local minimum, and begins again.
const LOCAL_MINIMUM: f64 = 2.0;
/// First steps of a candidate's fit by features.
const FIRST_STEPS: usize = 4;

/// A candidate of a round.
pub struct Tried<'a> {
    pub extension: &'a Extension,
    /// Where it is: after its first steps, or at its end.
    fit: Fit,
    /// Whether features lead it, or all samples.
    by_features: bool,
    /// Log odds by all samples that the first steps promise.
    promise: f64,
    /// Whether it was fitted to its end, or cannot be.
    is_ended: bool,
    pub sampled: Option<Sampled>,
    /// Log odds over the model before, by features and, where they were fitted, by all samples.
    features: f64,
    pub all: f64,
}

/// One round: the most promising candidates take their first steps, and the best are fitted to all samples; the best first.
pub fn round<'a>(
    data: &Data,
    base: &mut Sampled,
    screened: &'a [Screened],
    number: usize,
    listener: &dyn Listener,
) -> Vec<Tried<'a>> {
    listener.doing(&format!("round {number}: first steps"));
    let least = if base.may_be_noise(data.stated_repeats()) { 0 } else { LEAST_FITTED };
    let by_features = leaders(screened, |own| own.by_features.as_ref(), least, MOST_FITTED);
    let mut tried: Vec<Tried> = by_features
        .into_par_iter()
        .filter_map(|(own, promise)| {
            Tried::of(data, base, &own.extension, first_steps(data, base, own, promise)?, true)
        })
        .collect();
    let variances = Samples::variances(data, &base.fit.at.seen);
    let direct = |(own, promise): (&'a Screened, &Promise)| {
        let hypothesis = Arc::new(own.extension.hypothesis.clone());
        let (start, slopes) = (&promise.start, promise.slopes());
        let near = steps(&Samples, data, &hypothesis, start, &slopes, &variances, FIRST_STEPS)?;
        Tried::of(data, base, &own.extension, Fit::at(data, &hypothesis, near, promise.share), false)
    };
    let by_samples = leaders(screened, |own| own.by_samples.as_ref(), least, MOST_SAMPLED);
    tried.extend(by_samples.into_par_iter().filter_map(direct).collect::<Vec<_>>());
    listener.doing(&format!("round {number}: fits to all samples"));
    race(data, base, &mut tried);
    again(data, base, &tried);
    for own in &mut tried {
        own.all = own.sampled.as_ref().map_or(f64::NEG_INFINITY, |sampled| own.odds_of(base, sampled));
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

/// Fits those to their end that may come near the best, a few at a time. Others may come to as much more than they promise as those
/// did of which the end is known; as long as none is, every one may come near.
fn race(data: &Data, base: &Sampled, tried: &mut [Tried]) {
    tried.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    let (mut best, mut rough) = (0.0_f64, f64::INFINITY);
    for _ in 0..HEATS {
        let ended: Vec<(&str, f64)> = tried
            .iter()
            .filter(|own| own.sampled.is_some())
            .map(|own| (own.extension.name.as_str(), own.all))
            .collect();
        // Another try of an effect that came to more than this one promises is no use.
        let is_there =
            |own: &Tried| ended.iter().any(|(name, all)| *name == own.extension.name && *all >= own.promise);
        let may_come_near = |own: &Tried| own.promise + rough > (best - BEHIND).max(0.0);
        // Those near the best by features are fitted to samples, whatever they promise there.
        let by_features = tried.iter().map(|own| own.features).fold(0.0, f64::max);
        let is_near = |own: &Tried| own.features > (by_features - BEHIND).max(0.0);
        let is_chosen = |own: &Tried| !own.is_ended && !is_there(own) && (may_come_near(own) || is_near(own));
        let chosen: Vec<usize> = (0..tried.len()).filter(|k| is_chosen(&tried[*k])).take(HEAT).collect();
        if chosen.is_empty() {
            break;
        }
        let heat = tried.par_iter_mut().enumerate().filter(|(k, _)| chosen.contains(k));
        heat.for_each(|(_, own)| own.finish(data, base));
        for own in tried.iter().filter(|own| own.sampled.is_some()) {
            let more = (own.all - own.promise).max(0.0);
            rough = if rough.is_finite() { rough.max(more) } else { more };
            best = best.max(own.all);
        }
    }
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
    least: usize,
    most: usize,
) -> Vec<(&Screened, &Promise)> {
    let mut all: Vec<_> = screened.iter().filter_map(|own| Some((own, promise(own)?))).collect();
    all.sort_by(|a, b| b.1.odds.total_cmp(&a.1.odds));
    let top = all.first().map_or(0.0, |(_, promise)| promise.odds);
    let mut chosen: Vec<(&Screened, &Promise)> = Vec::new();
    for own in all {
        let tries = chosen.iter().filter(|other| other.0.extension.name == own.0.extension.name).count();
        let is_near = own.1.odds > 0.0 && top - own.1.odds < BEHIND || chosen.len() < least;
        if tries < TRIES && chosen.len() < most && is_near {
            chosen.push(own);
        }
    }
    chosen
}

impl<'a> Tried<'a> {
    /// After the first steps of its fit; none where the model that is linear there has no optimum.
    fn of(
        data: &Data,
        base: &Sampled,
        extension: &'a Extension,
        fit: Fit,
        by_features: bool,
    ) -> Option<Self> {
        let features = fit.evidence - base.fit.evidence + extension.odds;
        let promise = promised(data, &fit)? - base.evidence + extension.odds;
        let (is_ended, sampled, all) = (false, None, f64::NEG_INFINITY);
        Some(Self { extension, fit, by_features, promise, is_ended, sampled, features, all })
    }

    /// Fits it to its end, by features first where these lead it.
    fn finish(&mut self, data: &Data, base: &Sampled) {
        self.is_ended = true;
        let (hypothesis, share) = (&self.fit.hypothesis, self.fit.share);
        let start = Point::of(data, hypothesis, self.fit.at.z.clone());
        let fit = start.and_then(|start| {
            if self.by_features {
                Fit::by_features(data, hypothesis, start, share, EFFORT)
            } else {
                Some(Fit::at(data, hypothesis, start, share))
            }
        });
        let Some(fit) = fit else { return };
        self.sampled = Sampled::from(data, &fit);
        let fit = self.sampled.as_ref().map_or(fit, |own| own.fit.clone());
        self.features = fit.evidence - base.fit.evidence + self.extension.odds;
        self.fit = fit;
        self.all = self.sampled.as_ref().map_or(f64::NEG_INFINITY, |sampled| self.odds_of(base, sampled));
    }

    /// Log odds over the model before, by all samples.
    fn odds_of(&self, base: &Sampled, sampled: &Sampled) -> f64 {
        sampled.evidence - base.evidence + self.extension.odds
    }

    fn odds(&self, rejected: Option<String>) -> Odds {
        Odds {
            name: self.extension.name.clone(),
            features: self.features,
            all: self.sampled.as_ref().map(|_| self.all),
            share: self.fit.share,
            rms_mm: self.sampled.as_ref().map(|own| 1e3 * own.rms),
            rejected,
        }
    }
}

/// What a round says: its candidates with their odds, and of those that were fitted the place of the answer, if there is one, and of
/// those that would do as well.
pub fn weighed(
    tried: &[Tried],
    screened: &[Screened],
    bar: f64,
    share: f64,
) -> (Round, Option<usize>, Vec<usize>) {
    let first = tried.iter().position(|own| own.sampled.is_some());
    // Two that explain the same share the evidence for them.
    let all: f64 = tried.iter().filter(|own| own.sampled.is_some()).map(|own| own.all.exp()).sum();
    let best = first.filter(|_| all.ln() >= bar);
    // With a strength for each pressure an effect is no other one.
    let is_member = |k: &usize| {
        let is_near = |best: usize| {
            let is_other = tried[best].extension.effect() != tried[*k].extension.effect();
            *k > best && is_other && tried[best].all - tried[*k].all < CLASS
        };
        best.is_some_and(is_near)
    };
    let mut members: Vec<usize> = Vec::new();
    for k in (0..tried.len()).filter(|k| is_member(k) && tried[*k].sampled.is_some()) {
        if members.iter().all(|own| tried[*own].extension.effect() != tried[k].extension.effect()) {
            members.push(k);
        }
    }
    let rejected = |(k, own): (usize, &Tried)| {
        let why = match best {
            Some(best) if k == best => return own.odds(None),
            _ if own.sampled.is_none() => "features favour others".to_owned(),
            _ if members.contains(&k) => "explains the recordings as well".to_owned(),
            _ if own.all < bar => "its odds are below the bar".to_owned(),
            Some(best) => format!("{} explains more", tried[best].extension.name),
            None => "its odds are below the bar".to_owned(),
        };
        own.odds(Some(why))
    };
    let candidates: Vec<Odds> = tried.iter().enumerate().map(rejected).collect();
    let mut others: Vec<String> = Vec::new();
    for own in screened.iter().map(|own| &own.extension.name) {
        if !others.contains(own) && candidates.iter().all(|candidate| candidate.name != *own) {
            others.push(own.clone());
        }
    }
    (Round { bar, share, candidates, others }, best, members)
}
