//! Experiments that were not made: the releases at hand with one thing more, simulated at what is known and
//! looked at as if they had been recorded, to say which of them would tell two effects apart.

use std::sync::Arc;

use efam_experiments::release::{Point, Track};

use super::Course;
use super::candidate::Candidate;
use super::design_matrix::predictions;
use super::score::{APART, columns, distance, gram};
use super::verdict::{Separation, Verdict};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::prediction::Slopes;
use crate::calibrate::refine::LAST;
use crate::calibrate::{CalibrateError, Problem, Scope, Trial};
use crate::listed::listed;

/// What could be recorded besides.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Extra {
    BodyMarkers,
    Angles,
    Payload,
    LongRecord,
}

/// What may be recorded together, the least work first.
const TOGETHER: [&[Extra]; 4] = [
    &[Extra::BodyMarkers, Extra::Payload],
    &[Extra::BodyMarkers, Extra::LongRecord],
    &[Extra::Angles, Extra::Payload],
    &[Extra::BodyMarkers, Extra::Angles, Extra::Payload, Extra::LongRecord],
];

impl Extra {
    const ALL: [Self; 4] = [Self::BodyMarkers, Self::Angles, Self::Payload, Self::LongRecord];

    fn words(self) -> &'static str {
        match self {
            Self::BodyMarkers => "with markers at 0.3, 0.55 and 0.8 of the length",
            Self::Angles => "repeated from 25 degrees below",
            Self::Payload => "repeated with 20 g at the tip",
            Self::LongRecord => "three times as long",
        }
    }

    /// The trials of the larger experiment; none where it is no more than the one at hand.
    fn made(self, trials: &[Arc<Trial>]) -> Option<Vec<Arc<Trial>>> {
        let mut all = trials.to_vec();
        match self {
            Self::BodyMarkers => {
                if trials.iter().any(|trial| trial.release.tracks.len() > 1) {
                    return None;
                }
                for release in all.iter_mut().map(|trial| &mut Arc::make_mut(trial).release) {
                    let first = release.tracks.first()?.clone();
                    release.tracks.extend([0.3, 0.55, 0.8].map(|share| Track {
                        marker: format!("at {share} of the length"),
                        at: Point::Along(share),
                        ..first.clone()
                    }));
                }
            }
            Self::Angles => {
                let turned = |trial: &Arc<Trial>| {
                    let mut trial = Trial::clone(trial);
                    let k = trial.model.index("release.angle").ok()?;
                    trial.is_straight().then_some(())?;
                    trial.model.theta[k] -= 25f64.to_radians();
                    trial.release.name += ", from 25 degrees below";
                    Some(Arc::new(trial))
                };
                all.extend(trials.iter().map(turned).collect::<Option<Vec<_>>>()?);
            }
            Self::Payload => {
                let loaded = |trial: &Arc<Trial>| {
                    let mut trial = Trial::clone(trial);
                    trial.is_straight().then_some(())?;
                    trial.model = trial.model.with_effect("payload", &[("mass", 0.02)]).ok()?;
                    trial.release.name += ", with 20 g";
                    Some(Arc::new(trial))
                };
                if trials.iter().any(|trial| trial.release.payload > 0.0) {
                    return None;
                }
                all.extend(trials.iter().map(loaded).collect::<Option<Vec<_>>>()?);
            }
            Self::LongRecord => {
                for release in all.iter_mut().map(|trial| &mut Arc::make_mut(trial).release) {
                    let (last, count) = (*release.time.last()?, release.time.len());
                    let step = last / count as f64;
                    release.time.extend((1..=2 * count).map(|k| last + step * k as f64));
                }
            }
        }
        Some(all)
    }
}

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

impl Pair<'_> {
    /// The experiment that tells them apart best, of those that could be made: several things together only where
    /// one is not enough, and the best of all more than once only where that is not.
    pub fn separation(&self) -> Option<Separation> {
        let fitted = self.problem.trials.iter().filter(|trial| !trial.release.held_out);
        let fitted: Vec<Arc<Trial>> = fitted.cloned().collect();
        // Where their traces would be told apart already and their fits are not, traces predict nothing.
        if self.distance(&fitted, 1).is_none_or(|distance| distance >= APART) {
            return None;
        }
        let mut best: Option<(Separation, Vec<Arc<Trial>>)> = None;
        for extras in Extra::ALL.iter().map(std::slice::from_ref).chain(TOGETHER) {
            // One thing more is less work than several.
            if extras.len() > 1 && best.as_ref().is_some_and(|(best, _)| best.distance >= APART) {
                break;
            }
            let all = extras.iter().try_fold(fitted.clone(), |trials, extra| extra.made(&trials));
            let Some(trials) = all else { continue };
            let Some(distance) = self.distance(&trials, 1) else { continue };
            if best.as_ref().is_none_or(|(best, _)| distance > best.distance) {
                let words: Vec<String> = extras.iter().map(|extra| extra.words().to_owned()).collect();
                let what = format!("the same releases {}", listed(&words));
                best = Some((Separation { what, distance, distance_now: self.now }, trials));
            }
        }
        let (mut best, trials) = best?;
        let needed = (APART / best.distance).powi(2).ceil();
        let times = (needed as u32..=MOST_TIMES).filter(|times| *times > 1);
        for times in times {
            let Some(distance) = self.distance(&trials, times).filter(|distance| *distance >= APART) else {
                continue;
            };
            best.what += &format!(", each recorded {times} times");
            best.distance = distance;
            break;
        }
        Some(best).filter(|best| best.distance > self.now)
    }

    /// How far apart they are in releases that are each recorded some times; none where those cannot be run: what
    /// cannot be run, nobody will record.
    fn distance(&self, trials: &[Arc<Trial>], times: u32) -> Option<f64> {
        let mut planned = repeated(self.problem, trials, times);
        record(&mut planned, self.known).ok()?;
        let fit = Joint::at(&planned, self.known, Slopes::Differences, LAST).ok()?;
        let off = predictions(&fit)?;
        let columns = columns(&self.of, &fit, &off, &|_| ());
        let of = |c: usize| (0..columns.len()).filter(|k| columns[*k].of == c).collect::<Vec<_>>();
        let (first, second) = (of(0), of(1));
        let strengths = vec![self.strength - self.of[0].null_value; first.len()];
        let distance = distance(&gram(&fit, &columns), &first, &second, &strengths);
        Some(distance * (f64::from(times) / self.variance_inflation).sqrt())
    }
}

/// A problem of releases one of which stands for so many alike, each with a setup of its own: these together weigh as
/// much more as they are against what is believed of all, so that a distance is that of one times the root of `times`.
fn repeated(problem: &Problem, trials: &[Arc<Trial>], times: u32) -> Problem {
    let mut planned = Problem { trials: trials.to_vec(), ..problem.clone() };
    for parameter in planned.parameters.iter_mut().filter(|own| own.scope != Scope::PerRelease) {
        if let Some(prior) = &mut parameter.prior {
            prior.deviation *= f64::from(times).sqrt();
        }
    }
    planned
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
        let Some(best) = self.added.iter().find(|best| !best.members.is_empty()) else { return };
        if self.diagnosis.verdict == Verdict::Named {
            self.diagnosis.verdict = Verdict::Class;
        }
        self.diagnosis.members = best.members.iter().map(|(member, _)| member.clone()).collect();
        if self.is_stopped() {
            return;
        }
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

    use super::*;
    use crate::calibrate::{FittedParameter, Nuisances, Prior};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::example;

    fn release() -> Arc<Trial> {
        let time = uniform(2.0, 20.0);
        let (marker, at) = ("tip".to_owned(), Point::Tip);
        let track =
            Track { marker, at, position: vec![Some([0.0; 2]); time.len()], noise: 3e-4, discrepancy: 0.0 };
        let release = example::release(time, vec![track]);
        Trial { release, model: muscle_at_15_psi(), run: Run::release(2.0, 20.0) }.into()
    }

    /// One release that stands for four is worth four, each with its own hold and instant, and with the mass that is
    /// believed of all.
    #[test]
    fn releases_that_stand_for_several_are_worth_as_much() {
        let prior = |mean: f64| Some(Prior { mean, deviation: 0.01 * mean });
        let mass = muscle_at_15_psi().theta[muscle_at_15_psi().index("rod.mass").unwrap()];
        let problem = Problem {
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
        };
        let all = candidates(&problem, &DiagnosisSettings::default());
        let named = |name: &str| all.iter().find(|own| own.name() == name).unwrap().clone();
        let of = [named("tip_mass"), named("scale")];
        let pair =
            Pair { problem: &problem, known: &[], of, strength: 1.0, variance_inflation: 1.0, now: 0.0 };
        let one = pair.distance(&[release()], 1).unwrap();
        let standing_for_four = pair.distance(&[release()], 4).unwrap();
        let four = pair.distance(&vec![release(); 4], 1).unwrap();
        assert!((standing_for_four / four - 1.0).abs() < 1e-3, "{standing_for_four} {four}");
        // What is believed of the mass is worth no more for being believed four times.
        assert!(four < 1.995 * one, "{four} {one}");
    }
}
