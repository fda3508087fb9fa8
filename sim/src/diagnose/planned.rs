//! Experiments that were not made: the releases at hand with one thing more, simulated at what is known and
//! looked at as if they had been recorded, to say which of them would tell two effects apart.

use super::candidate::Candidate;
use super::columns::{columns, predictions};
use super::score::{APART, distance, gram};
use super::verdict::Separation;
use super::words::listed;
use crate::calibrate::joint::{Joint, Known};
use crate::calibrate::prediction::Slopes;
use crate::calibrate::{CalibrateError, Problem, Trial};
use crate::experiment::release::{Point, Track};

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
            Self::Angles => "once more from 25 degrees below",
            Self::Payload => "once more with 20 g at the tip",
            Self::LongRecord => "three times as long",
        }
    }

    /// The trials of the larger experiment; none where it is no more than the one at hand.
    fn made(self, trials: &[Trial]) -> Option<Vec<Trial>> {
        let mut all = trials.to_vec();
        match self {
            Self::BodyMarkers => {
                if trials.iter().any(|trial| trial.release.tracks.len() > 1) {
                    return None;
                }
                for release in all.iter_mut().map(|trial| &mut trial.release) {
                    let first = release.tracks.first()?.clone();
                    release.tracks.extend([0.3, 0.55, 0.8].map(|share| Track {
                        marker: format!("at {share} of the length"),
                        at: Point::Along(share),
                        ..first.clone()
                    }));
                }
            }
            Self::Angles => {
                let turned = |trial: &Trial| {
                    let mut trial = trial.clone();
                    let k = trial.model.index("release.angle").ok()?;
                    trial.is_straight().then_some(())?;
                    trial.model.theta[k] -= 25f64.to_radians();
                    trial.release.name += ", from 25 degrees below";
                    Some(trial)
                };
                all.extend(trials.iter().map(turned).collect::<Option<Vec<_>>>()?);
            }
            Self::Payload => {
                let loaded = |trial: &Trial| {
                    let mut trial = trial.clone();
                    trial.is_straight().then_some(())?;
                    trial.model = trial.model.with_effect("payload", &[("mass", 0.02)]).ok()?;
                    trial.release.name += ", with 20 g";
                    Some(trial)
                };
                if trials.iter().any(|trial| trial.release.payload > 0.0) {
                    return None;
                }
                all.extend(trials.iter().map(loaded).collect::<Option<Vec<_>>>()?);
            }
            Self::LongRecord => {
                for release in all.iter_mut().map(|trial| &mut trial.release) {
                    let (last, count) = (*release.time.last()?, release.time.len());
                    let step = last / count as f64;
                    release.time.extend((1..=2 * count).map(|k| last + step * k as f64));
                }
            }
        }
        Some(all)
    }
}

/// The experiment that tells two effects apart best, of those that could be made, several things together only where
/// one is not enough: `strengths` are those of
/// the first, `widening` the variance of the noise over that of white noise, `now` the distance in the
/// experiment at hand.
pub(super) fn separation(
    problem: &Problem,
    known: &[Known],
    pair: &[Candidate; 2],
    strength: f64,
    widening: f64,
    now: f64,
) -> Option<Separation> {
    let fitted: Vec<Trial> = problem.trials.iter().filter(|trial| !trial.release.held_out).cloned().collect();
    let mut best: Option<Separation> = None;
    for extras in Extra::ALL.iter().map(std::slice::from_ref).chain(TOGETHER) {
        // One thing more is less work than several.
        if extras.len() > 1 && best.as_ref().is_some_and(|best| best.distance >= APART) {
            break;
        }
        let all = extras.iter().try_fold(fitted.clone(), |trials, extra| extra.made(&trials));
        let Some(trials) = all else { continue };
        let mut planned = Problem { trials, ..problem.clone() };
        // What cannot be run, nobody will record.
        if record(&mut planned, known).is_err() {
            continue;
        }
        let Ok(fit) = Joint::at(&planned, known, Slopes::Variational) else { continue };
        let Some(off) = predictions(&fit) else { continue };
        let columns = columns(&fit, &off, pair, &|_| ());
        let of = |c: usize| (0..columns.len()).filter(|k| columns[*k].of == c).collect::<Vec<_>>();
        let (first, second) = (of(0), of(1));
        let strengths = vec![strength - pair[0].off; first.len()];
        let distance = distance(&gram(&fit, &columns), &first, &second, &strengths) / widening.sqrt();
        if best.as_ref().is_none_or(|best| distance > best.distance) {
            let words: Vec<String> = extras.iter().map(|extra| extra.words().to_owned()).collect();
            let what = format!("the same releases {}", listed(&words));
            best = Some(Separation { what, distance, distance_now: now });
        }
    }
    best.filter(|best| best.distance > now)
}

/// Fills the tracks with what is predicted at what is known, whatever was in them.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense or that cannot be simulated.
pub(super) fn record(planned: &mut Problem, known: &[Known]) -> Result<(), CalibrateError> {
    for release in planned.trials.iter_mut().map(|trial| &mut trial.release) {
        let count = release.time.len();
        release.tracks.iter_mut().for_each(|track| track.position = vec![Some([0.0; 2]); count]);
    }
    let blank = planned.clone();
    let (objective, seen) = Joint::seen(&blank, known)?;
    for (r, trial) in planned.trials.iter_mut().enumerate() {
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
