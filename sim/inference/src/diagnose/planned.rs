//! Experiments that were not made: the releases at hand with one thing more, simulated at what is known and looked at as if they
//! had been recorded, to say which of them would separate two effects.

use nalgebra::DVector;

use super::data::Data;
use super::extra::Extra::{self, Angles, BodyMarkers, LongRecord, Payload};
use super::extra::{ALL_MORE, ONE_MORE, TWO_MORE, add_body_markers, lengthen};
use super::hypothesis::Hypothesis;
use super::samples::Sampled;
use super::search::Point;
use super::traces::{APART, Traces, trace};
use super::verdict::{Member, Separation};
use super::{Accepted, Found};
use crate::calibrate::Trial;
use crate::calibrate::repeats::{grouped_trials, is_one_condition};
use crate::listed::listed;

/// Times that releases are recorded at most: an afternoon's work.
const MOST_TIMES: u32 = 10;

/// Fills in how far each member of a class is from the answer, and says which recordings would separate the nearest one; none
/// where none would, and for statements.
pub(super) fn separation(found: &Found, members: &mut [Member]) -> Option<Separation> {
    let mut nearest: Option<(f64, Pair)> = None;
    for ((place, other), member) in found.members.iter().zip(members) {
        let best = &found.accepted[*place];
        let base = place.checked_sub(1).map_or(&found.baseline, |before| &found.accepted[before].sampled);
        if best.strengths.is_empty() || other.strengths.is_empty() {
            continue;
        }
        let pair = Pair { found, base, of: [best, other] };
        member.distance = pair.now();
        let is_nearer = |now: &f64| nearest.as_ref().is_none_or(|(before, _)| now < before);
        if let Some(now) = member.distance.filter(is_nearer) {
            nearest = Some((now, pair));
        }
    }
    let (now, pair) = nearest?;
    pair.separation(now)
}

/// An answer and what would do as well, beside the model before.
struct Pair<'a> {
    found: &'a Found,
    base: &'a Sampled,
    of: [&'a Accepted; 2],
}

impl Pair<'_> {
    /// Distance in the recordings at hand.
    fn now(&self) -> Option<f64> {
        let data = &self.found.data;
        let fit = &self.base.fit;
        let own = |own: &Accepted| trace(data, &fit.at, &own.sampled.fit.hypothesis, &self.beside(own), 1.0);
        let traces = [own(self.of[0])?, own(self.of[1])?];
        let counts = vec![1; data.plans.len()];
        Some(Traces::of(data, &fit.at, &fit.hypothesis, &traces, (&counts, 1), self.misfit())?.apart(0, 1))
    }

    /// Mean square of what does not repeat of a coordinate, m².
    fn misfit(&self) -> f64 {
        0.5 * self.of[0].sampled.misfit().powi(2)
    }

    /// The model before, with an effect at the strength and shape that were found.
    fn beside(&self, own: &Accepted) -> DVector<f64> {
        let mut z = own.sampled.fit.at.z.clone();
        z.rows_mut(0, self.base.fit.at.z.len()).copy_from(&self.base.fit.at.z);
        z
    }

    /// The experiment that separates them best, of those that could be made: several things together only where one is not
    /// enough, and the best more than once only where that is not.
    fn separation(&self, now: f64) -> Option<Separation> {
        let mut best: Option<(f64, &[Extra], Experiment)> = None;
        for all in [&ONE_MORE[..], &TWO_MORE, &ALL_MORE] {
            for extras in all {
                let Some(made) = self.experiment(extras) else { continue };
                let Some(distance) = made.distance(1, self.misfit()) else { continue };
                if best.as_ref().is_none_or(|(before, ..)| distance > *before) {
                    best = Some((distance, extras, made));
                }
            }
            if best.as_ref().is_some_and(|(distance, ..)| *distance >= APART) {
                break;
            }
        }
        let (mut distance, extras, made) = best?;
        let words: Vec<String> = extras.iter().map(|extra| extra.words().to_owned()).collect();
        let mut what = format!("the same releases {}", listed(&words));
        if distance < APART {
            let needed = (APART / distance).powi(2).ceil().min(f64::from(MOST_TIMES) + 1.0) as u32;
            let mut several =
                (needed..=MOST_TIMES).filter_map(|times| Some((times, made.distance(times, self.misfit())?)));
            if let Some((times, enough)) = several.find(|(_, distance)| *distance >= APART) {
                what += &format!(", each recorded {times} times");
                distance = enough;
            }
        }
        (distance > now).then_some(Separation { what, distance, distance_now: now })
    }

    /// The experiment with something more; none where there is nothing more in it, or where it cannot be run.
    fn experiment(&self, extras: &[Extra]) -> Option<Experiment> {
        let fit = &self.base.fit;
        let trials = &fit.hypothesis.trials[..self.found.data.plans.len()];
        // Releases of one condition differ by noise alone: one of them counts for all.
        let groups = grouped_trials(trials.iter(), |_| true, is_one_condition);
        let (mut like, mut counts): (Vec<usize>, Vec<usize>) =
            groups.iter().map(|group| (group[0], group.len())).unzip();
        let mut planned: Vec<Vec<Extra>> = vec![Vec::new(); like.len()];
        for extra in extras.iter().filter(|extra| matches!(extra, Angles | Payload)) {
            for k in 0..like.len() {
                let more: Vec<Extra> = planned[k].iter().copied().chain([*extra]).collect();
                like.push(like[k]);
                counts.push(counts[k]);
                planned.push(more);
            }
        }
        let changed = |of: &Hypothesis| -> Option<Vec<Trial>> {
            let one = |(r, more): (&usize, &Vec<Extra>)| {
                let start = of.trials[*r].clone();
                let mut trial = more.iter().try_fold(start, |trial, extra| extra.repeated(&trial))?;
                if extras.contains(&BodyMarkers) {
                    add_body_markers(&mut trial);
                }
                if extras.contains(&LongRecord) {
                    lengthen(&mut trial);
                }
                Some(trial)
            };
            like.iter().zip(&planned).map(one).collect()
        };
        let at_hand = changed(&fit.hypothesis)?;
        let tracks = |trial: &Trial| trial.release.tracks.len();
        let has_more = at_hand.iter().zip(&like).any(|(made, r)| tracks(made) > tracks(&trials[*r]));
        if extras == [BodyMarkers] && !has_more {
            return None;
        }
        let (base, z) = fit.hypothesis.planned(&fit.at.z, &like, at_hand)?;
        let recorded = (0..like.len()).map(|p| base.settled(p, &[], &z).recorded());
        let recorded: Vec<Trial> = recorded.collect::<Option<_>>()?;
        let (data, places) = Data::of(&recorded, None, Some(self.found.data.slow_noise()));
        if places.len() < like.len() {
            return None;
        }
        let at = Point::of(&data, &base, z)?;
        let own = |own: &Accepted| {
            let hypothesis = &own.sampled.fit.hypothesis;
            let (hypothesis, z) = hypothesis.planned(&self.beside(own), &like, changed(hypothesis)?)?;
            trace(&data, &at, &hypothesis, &z, 1.0)
        };
        let traces = [own(self.of[0])?, own(self.of[1])?];
        Some(Experiment { data, at, base, traces, counts })
    }
}

/// An experiment that was not made, as it was simulated.
struct Experiment {
    data: Data,
    at: Point,
    base: Hypothesis,
    traces: [Vec<DVector<f64>>; 2],
    /// Releases for which each of the simulated ones counts.
    counts: Vec<usize>,
}

impl Experiment {
    /// How far apart the traces are where each release is recorded some times; `misfit` is a mean square, m².
    fn distance(&self, times: u32, misfit: f64) -> Option<f64> {
        let Self { data, at, base, traces, counts } = self;
        Some(Traces::of(data, at, base, traces, (counts, times), misfit)?.apart(0, 1))
    }
}
