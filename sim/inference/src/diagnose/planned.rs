//! Experiments that were not made: the releases at hand with one thing more, simulated at what is known and
//! looked at as if they had been recorded, to say which of them would tell two effects apart.
//!
//! An experiment is a part of a larger one: some of its releases, markers and samples. So the largest is simulated, once,
//! and each is looked at in it. Releases of one condition differ by
//! noise alone: one of them is simulated, with the weight of all.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::Course;
use super::candidate::Candidate;
use super::design_matrix::{Column, extended, normal_equations, places, predictions};
use super::extra::Extra::{self, Angles, BodyMarkers, LongRecord, Payload};
use super::extra::{ALL_MORE, ONE_MORE, TWO_MORE, add_body_markers, lengthen};
use super::score::{APART, columns, distance, gram};
use super::verdict::{Separation, Verdict};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::prediction::Slopes;
use crate::calibrate::refine::LAST;
use crate::calibrate::repeats::{grouped, is_one_condition};
use crate::calibrate::unknowns::{Group, Unknown};
use crate::calibrate::view::Series;
use crate::calibrate::{CalibrateError, Problem, Trial};
use crate::listed::listed;

/// Times that releases are recorded at most: an afternoon's work.
const MOST_TIMES: u32 = 10;

/// Two effects at what is known, of which the first may be the answer.
pub(super) struct Pair<'a> {
    pub problem: &'a Problem,
    pub known: &'a [Estimate],
    pub of: [Candidate; 2],
    /// Strength of the first.
    pub strength: f64,
    /// Variance of the noise over that of white noise as large as stated.
    pub variance_inflation: f64,
    /// Distance in the experiment at hand.
    pub now: f64,
}

/// The releases at hand and what is recorded besides, simulated, with the traces of two effects.
struct Simulated {
    fit: Joint,
    columns: Vec<Column>,
    /// Of each release what it has that those at hand have not.
    more: Vec<Vec<Extra>>,
    /// Number of releases of its condition for which each stands.
    times: Vec<usize>,
    /// Markers and samples of each release that are recorded without anything more.
    tracks: Vec<usize>,
    counts: Vec<usize>,
    /// Residuals and slopes, those of the columns behind the others.
    blocks: Vec<Vec<Series>>,
}

impl Pair<'_> {
    /// The experiment that tells them apart best, of those that could be made: several things together only where
    /// one is not enough, and the best of all more than once only where that is not.
    pub fn separation(&self) -> Option<Separation> {
        let (angles, payload, both) = (vec![Angles], vec![Payload], vec![Angles, Payload]);
        let is_long = |more: &[Extra]| more.is_empty();
        let one_more = self.simulated(&[angles.clone(), payload.clone()], is_long);
        let mut simulated = one_more.or_else(|| self.simulated(&[], is_long))?;
        // Where their traces would be told apart already and their fits are not, traces predict nothing.
        if self.distance(&simulated, simulated.hessian(&[])?, 1) >= APART {
            return None;
        }
        let best_of = |simulated: &Simulated, all: &[&'static [Extra]]| {
            let distances = all.iter().filter_map(|extras| {
                Some((self.distance(simulated, simulated.hessian(extras)?, 1), *extras))
            });
            distances.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (mut distance, mut extras) = best_of(&simulated, &ONE_MORE)?;
        // One thing more is less work than several.
        if distance < APART
            && let Some(found) = best_of(&simulated, &TWO_MORE).filter(|found| found.0 > distance)
        {
            (distance, extras) = found;
        }
        if distance < APART
            && let Some(all_more) = self.simulated(&[angles, payload, both], |_| true)
            && let Some(found) = best_of(&all_more, &ALL_MORE).filter(|found| found.0 > distance)
        {
            (distance, extras) = found;
            simulated = all_more;
        }
        let words: Vec<String> = extras.iter().map(|extra| extra.words().to_owned()).collect();
        let mut what = format!("the same releases {}", listed(&words));
        if distance < APART {
            let needed = (APART / distance).powi(2).ceil() as u32;
            let hessian = simulated.hessian(extras)?;
            let several = |times: u32| (times, self.distance(&simulated, hessian.clone(), times));
            let mut enough = (needed..=MOST_TIMES).map(several);
            if let Some((times, enough)) = enough.find(|(_, distance)| *distance >= APART) {
                what += &format!(", each recorded {times} times");
                distance = enough;
            }
        }
        Some(Separation { what, distance, distance_now: self.now }).filter(|best| best.distance > self.now)
    }

    /// The releases at hand and those `repeats` of them that can be run, with all markers, and long ones where asked; what
    /// cannot be run, nobody will record. None where those at hand cannot be run, or an effect cannot in one of them.
    fn simulated(&self, repeats: &[Vec<Extra>], is_long: impl Fn(&[Extra]) -> bool) -> Option<Simulated> {
        let (fitted, times): (Vec<usize>, Vec<usize>) =
            one_of_each_condition(self.problem).into_iter().unzip();
        let hand = |r: usize| &self.problem.trials[fitted[r % fitted.len()]];
        let of = |more: &[Extra]| -> Option<Vec<Arc<Trial>>> {
            let made = |r: usize| {
                let start = Trial::clone(hand(r));
                let mut trial = more.iter().try_fold(start, |trial, extra| extra.repeated(&trial))?;
                add_body_markers(&mut trial);
                if is_long(more) {
                    lengthen(&mut trial);
                }
                Some(Arc::new(trial))
            };
            let trials = (0..fitted.len()).map(made).collect::<Option<Vec<_>>>()?;
            let mut planned = Problem { trials, ..self.problem.clone() };
            record(&mut planned, &known_of(self.known, &fitted)).ok()?;
            Some(planned.trials)
        };
        let mut trials = of(&[])?;
        let mut more = vec![Vec::new(); trials.len()];
        for repeat in repeats {
            if let Some(made) = of(repeat) {
                more.extend(vec![repeat.clone(); made.len()]);
                trials.extend(made);
            }
        }
        let count = trials.len();
        let planned = Problem { trials, ..self.problem.clone() };
        let known = known_of(self.known, &fitted.repeat(count / fitted.len()));
        let fit = Joint::at(&planned, &known, Slopes::Differences, LAST).ok()?;
        let columns = columns(&self.of, &fit, &predictions(&fit)?, &|_| ());
        if places(&columns, 0).is_empty() || places(&columns, 1).is_empty() {
            return None;
        }
        let tracks = (0..count).map(|r| hand(r).release.tracks.len()).collect();
        let within = |r: usize| {
            let count = hand(r).release.time.len();
            fit.objective.measured[r].samples.iter().filter(|sample| **sample < count).count()
        };
        let counts = (0..count).map(within).collect();
        let times = times.repeat(count / fitted.len());
        Some(Simulated { blocks: extended(&fit, &columns), fit, columns, more, times, tracks, counts })
    }

    /// How far apart they are in an experiment with these second derivatives, whose releases are each recorded some times.
    fn distance(&self, simulated: &Simulated, mut hessian: DMatrix<f64>, times: u32) -> f64 {
        let Simulated { fit, columns, .. } = simulated;
        // One release stands for so many alike, each with a setup of its own: these together weigh as much more as they are
        // against what is believed of all, so that a distance is that of one times the root of `times`.
        for (k, _, slope) in fit.objective.prior_residuals(&fit.found.x) {
            let weight = match fit.objective.part.unknowns[k].group {
                Group::Release(r) => simulated.times[r] as f64,
                Group::All | Group::Pressure(_) => f64::from(times).recip(),
            };
            hessian[(k, k)] += slope * slope * (weight - 1.0);
        }
        let (first, second) = (places(columns, 0), places(columns, 1));
        let strengths = vec![self.strength - self.of[0].null_value; first.len()];
        let distance = distance(&gram(fit, &hessian), &first, &second, &strengths);
        distance * (f64::from(times) / self.variance_inflation).sqrt()
    }
}

impl Simulated {
    /// Second derivatives of an experiment, by the unknowns and the strengths of both effects behind them. None where it has
    /// nothing more than the one at hand.
    fn hessian(&self, extras: &[Extra]) -> Option<DMatrix<f64>> {
        let blocks = self.part(extras)?;
        Some(normal_equations(&self.fit, &blocks, self.columns.len()).1)
    }

    /// What is recorded in an experiment: its releases, markers and samples, and nothing of the others. None where it has
    /// nothing more than the one at hand.
    fn part(&self, extras: &[Extra]) -> Option<Vec<Vec<Series>>> {
        let is_more = |extra: &Extra| match extra {
            LongRecord => true,
            BodyMarkers => self.blocks.iter().zip(&self.tracks).any(|(block, tracks)| block.len() > *tracks),
            Angles | Payload => self.more.iter().any(|more| more.contains(extra)),
        };
        extras.iter().all(is_more).then_some(())?;
        let of_track = |r: usize, t: usize, series: &Series| {
            let is_made = self.more[r].iter().all(|extra| extras.contains(extra));
            let is_seen = is_made && (t < self.tracks[r] || extras.contains(&BodyMarkers));
            let is_within = |k: &usize| is_seen && (extras.contains(&LongRecord) || *k < self.counts[r]);
            // Samples ascend.
            let count = series.samples.iter().take_while(|k| is_within(k)).count();
            let root = (self.times[r] as f64).sqrt();
            let weighted = |own: &[f64; 2]| own.map(|own| root * own);
            let slopes = series.slopes[..count].iter().map(|own| own.iter().map(weighted).collect());
            Series {
                samples: series.samples[..count].to_vec(),
                residual: series.residual[..count].iter().map(weighted).collect(),
                slopes: slopes.collect(),
            }
        };
        let of_release = |(r, block): (usize, &Vec<Series>)| {
            block.iter().enumerate().map(|(t, series)| of_track(r, t, series)).collect()
        };
        Some(self.blocks.iter().enumerate().map(of_release).collect())
    }
}

/// The place of one fitted release of each condition with the same markers, and the number of such releases.
fn one_of_each_condition(problem: &Problem) -> Vec<(usize, usize)> {
    let is_fitted = |trial: &Trial| !trial.release.held_out;
    let is_alike = |a: &Trial, b: &Trial| {
        let [one, other] = [a, b].map(|trial| trial.release.tracks.iter().map(|track| track.at));
        one.eq(other) && is_one_condition(a, b)
    };
    grouped(problem, is_fitted, is_alike).into_iter().map(|own| (own[0], own.len())).collect()
}

/// What is known of releases planned like those at these places: each takes over the values of its own.
fn known_of(known: &[Estimate], places: &[usize]) -> Vec<Estimate> {
    let of_release = |known: &Estimate, r: usize, t: usize| {
        let unknown = Unknown { group: Group::Release(r), ..known.unknown.clone() };
        (known.unknown.group == Group::Release(t)).then_some(Estimate { unknown, x: known.x })
    };
    let of_place =
        |(r, t): (usize, &usize)| known.iter().filter_map(|own| of_release(own, r, *t)).collect::<Vec<_>>();
    let is_of_several = |known: &&Estimate| !matches!(known.unknown.group, Group::Release(_));
    let of_several = known.iter().filter(is_of_several).cloned();
    of_several.chain(places.iter().enumerate().flat_map(of_place)).collect()
}

/// Fills the tracks with what is predicted at what is known, whatever was in them.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense or that cannot be simulated.
pub(super) fn record(planned: &mut Problem, known: &[Estimate]) -> Result<(), CalibrateError> {
    for release in planned.trials_mut().map(|trial| &mut trial.release) {
        let count = release.time.len();
        release.tracks.iter_mut().for_each(|track| track.position = vec![Some([0.0; 2]); count]);
    }
    let blank = planned.clone();
    let (objective, seen) = Joint::seen(&blank, known)?;
    for (r, trial) in planned.trials_mut().enumerate() {
        let measured = &objective.measured[r];
        for (t, series) in seen.blocks[r].iter().enumerate() {
            let noise = measured.noise[t];
            for (k, residual) in series.samples.iter().zip(&series.residual) {
                // Measured was zero.
                let predicted = residual.map(|residual| -noise * residual);
                trial.release.tracks[t].position[measured.samples[*k]] = Some(predicted);
            }
        }
    }
    Ok(())
}

impl Course<'_> {
    /// Whether what was added stands alone, and else what would tell it from the others.
    pub(super) fn tell_apart(&mut self, known: &[Estimate]) {
        let Some(place) = self.added.iter().position(|best| !best.members.is_empty()) else { return };
        if self.diagnosis.verdict == Verdict::Named {
            self.diagnosis.verdict = Verdict::Class;
        }
        let members = &self.added[place].members;
        self.diagnosis.members = members.iter().map(|(member, _)| member.clone()).collect();
        if !self.may_add_to_answer("recordings that separate the candidates") {
            return;
        }
        let best = &self.added[place];
        let (nearest, other) = &best.members[0];
        let of = [best.candidate.clone(), other.clone()];
        let strength = best.refit.values.first().map_or(best.candidate.null_value, |value| value.value);
        self.listener.doing("recordings that separate the candidates");
        let (problem, variance_inflation, now) = (&self.problem, best.variance_inflation, nearest.distance);
        self.diagnosis.separating_experiment =
            Pair { problem, known, of, strength, variance_inflation, now }.separation();
    }
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::{Run, uniform};
    use efam_experiments::release::{Point, Track};

    use super::*;
    use crate::calibrate::unknowns::UnknownKind;
    use crate::calibrate::{FittedParameter, Nuisances, Prior, Scope};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::example;

    fn release() -> Arc<Trial> {
        let time = uniform(2.0, 20.0);
        let (marker, at) = ("tip".to_owned(), Point::Tip);
        let track =
            Track { marker, at, position: vec![Some([0.0; 2]); time.len()], noise: 3e-4, discrepancy: 0.0 };
        let release = example::release(time, vec![track]);
        // With a payload, waves that nothing damps take a hundred times the steps.
        let model = muscle_at_15_psi().with_effect("rayleigh_stiffness", &[("beta", 2e-3)]).unwrap();
        Trial { release, model, run: Run::release(2.0, 20.0) }.into()
    }

    /// A release whose stiffness and mass are unknown.
    fn problem() -> Problem {
        let prior = |mean: f64| Some(Prior { mean, deviation: 0.01 * mean });
        let mass = muscle_at_15_psi().theta[muscle_at_15_psi().index("rod.mass").unwrap()];
        Problem {
            trials: vec![release()],
            parameters: vec![
                FittedParameter::new("rod.bending_stiffness", Scope::Shared),
                FittedParameter { prior: prior(mass), ..FittedParameter::new("rod.mass", Scope::Shared) },
            ],
            nuisances: Nuisances {
                release_instant: true,
                hold_angle: Some(4e-3),
                offset: Some(2e-4),
                ..Nuisances::default()
            },
        }
    }

    /// How far apart a tip mass and a scale are in a part of what is simulated.
    fn distance(problem: &Problem, [repeats, extras]: [&[Extra]; 2], times: u32) -> f64 {
        let all = candidates(problem, &DiagnosisSettings::default());
        let named = |name: &str| all.iter().find(|own| own.name() == name).unwrap().clone();
        let of = [named("tip_mass"), named("scale")];
        let pair = Pair { problem, known: &[], of, strength: 1.0, variance_inflation: 1.0, now: 0.0 };
        let repeats: Vec<_> = repeats.iter().map(|extra| vec![*extra]).collect();
        let simulated = pair.simulated(&repeats, |_| !extras.is_empty()).unwrap();
        pair.distance(&simulated, simulated.hessian(extras).unwrap(), times)
    }

    /// An experiment of a release and one with a payload, and the same as a part of one with more markers that is longer.
    #[test]
    fn a_part_of_a_larger_experiment_is_worth_what_it_is_alone() {
        let problem = problem();
        let loaded = Payload.repeated(&problem.trials[0]).unwrap().into();
        let both = Problem { trials: vec![problem.trials[0].clone(), loaded], ..problem.clone() };
        let part = distance(&problem, [&[Payload, Angles], &[Payload]], 1);
        let alone = distance(&both, [&[], &[]], 1);
        assert!((part / alone - 1.0).abs() < 1e-2, "{part} {alone}");
        assert!(part < 0.9 * distance(&problem, [&[Payload, Angles], &[Payload, BodyMarkers]], 1), "{part}");
    }

    /// One release that stands for four is worth four, each with its own hold and instant, and with the mass that is
    /// believed of all.
    #[test]
    fn releases_that_stand_for_several_are_worth_as_much() {
        let problem = problem();
        let alike = Problem { trials: vec![release(); 4], ..problem.clone() };
        let mut apart = alike.clone();
        let k = problem.trials[0].model.index("effects.gravity.acceleration").unwrap();
        let others = apart.trials_mut().zip([0.997, 0.999, 1.001, 1.003]);
        others.for_each(|(trial, gravity)| trial.model.theta[k] *= gravity);
        assert_eq!(one_of_each_condition(&apart).len(), 4);
        let distance = |problem: &Problem, times: u32| distance(problem, [&[], &[]], times);
        let (one, four) = (distance(&problem, 1), distance(&apart, 1));
        for standing_for_four in [distance(&problem, 4), distance(&alike, 1)] {
            assert!((standing_for_four / four - 1.0).abs() < 1e-3, "{standing_for_four} {four}");
        }
        // What is believed of the mass is worth no more for being believed four times.
        assert!(four < 1.995 * one, "{four} {one}");
    }

    /// Two alike and one held out between them.
    #[test]
    fn one_release_of_a_condition_is_simulated() {
        let mut trials = vec![release(); 4];
        Arc::make_mut(&mut trials[1]).release.held_out = true;
        Arc::make_mut(&mut trials[2]).release.tracks[0].at = Point::Along(0.5);
        let problem = Problem { trials, ..problem() };
        assert_eq!(one_of_each_condition(&problem), [(0, 2), (2, 1)]);
        let known = |name: &str, group, x: f64| {
            let unknown = Unknown::nuisance(UnknownKind::HoldAngle, name, "rad", group, 1.0, 1.0);
            Estimate { unknown, x }
        };
        let all = [("shared", Group::All), ("a", Group::Release(0)), ("b", Group::Release(2))];
        let all: Vec<Estimate> =
            all.iter().zip([1.0, 2.0, 3.0]).map(|((name, group), x)| known(name, *group, x)).collect();
        let found = known_of(&all, &[0, 2, 0]);
        let found: Vec<(Group, f64)> = found.iter().map(|own| (own.unknown.group, own.x)).collect();
        let releases = [2.0, 3.0, 2.0].into_iter().enumerate().map(|(r, x)| (Group::Release(r), x));
        assert_eq!(found, [(Group::All, 1.0)].into_iter().chain(releases).collect::<Vec<_>>());
    }
}
