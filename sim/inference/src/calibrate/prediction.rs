//! What a model predicts that a recording shows, and how that changes with the unknowns.

use std::ops::ControlFlow;

use efam_core::forward::{ForwardError, Run, forward};
use efam_core::integrate::{IntegrateError, Method, Steps};
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::release::Point;
use models::sensor::Sensor;
use nalgebra::DVector;
use rayon::prelude::*;

use super::error::CalibrateError;
use super::hold::LATE_HOLD;
use super::problem::{Trial, refine};
use super::unknowns::{Acts, Local, Unknown};
use crate::normal::CLEAR;
use crate::ordered::in_order;

/// The samples of a release that are fitted.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// Places in the release's `time`, ascending; each has a track at least.
    pub samples: Vec<usize>,
    /// Standard deviation of each track, m: of its noise and of what does not repeat.
    pub noise: Vec<f64>,
    /// Standard deviation of the noise alone, m.
    pub camera_noise: Vec<f64>,
}

/// How finely a run is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fidelity {
    /// Error admitted in a step.
    pub tolerance: f64,
    /// Edges for each edge of the model.
    pub refinement: usize,
}

/// How finely a fit runs the model; what that leaves is removed in the end.
pub(crate) const FIT: Fidelity = Fidelity { tolerance: 1e-4, refinement: 1 };

/// How the slopes of a prediction are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slopes {
    /// From the variational equation: those of the exact solution, a per cent or two off at the
    /// tolerance of a fit. Cheap, and good enough to come near.
    Variational,
    /// Differences of runs on the same steps: those of the prediction itself, to five digits. Where two
    /// unknowns do almost the same, a search comes to rest only with these.
    Differences,
}

/// A release of a search: what was measured of it, and the unknowns that act on it.
#[derive(Clone, Copy)]
pub(crate) struct Member<'a> {
    pub trial: &'a Trial,
    pub measured: &'a Measured,
    pub locals: &'a [Local],
    /// Those of the whole part.
    pub unknowns: &'a [Unknown],
}

/// How far and how finely a release is run.
#[derive(Clone, Debug)]
pub(crate) struct RunRequest {
    /// Samples, from the first.
    pub count: usize,
    pub fidelity: Fidelity,
    pub steps: Steps,
}

/// Change of a scaled unknown by which differences are taken: the prediction's rounding, some 1e-11 m,
/// leaves 1e-6 m, its curvature 1e-5 of the slope.
const DIFFERENCE: f64 = 1e-5;
/// The same with friction. The instant at which it turns round jumps from step to step as parameters change, which moves the
/// prediction by some 1e-6 m at the tolerance of a fit. Over a change of 1e-5 that would be a slope larger than the true one.
const DIFFERENCE_WITH_FRICTION: f64 = 1e-3;

/// Predicted positions of every track, without offsets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Prediction {
    /// Shape `[tracks][samples]`, m.
    pub position: Vec<Vec<[f64; 2]>>,
    /// Derivatives by the scaled unknowns of the trial, shape `[tracks][samples][locals]`, m; empty
    /// unless requested.
    pub slopes: Vec<Vec<Vec<[f64; 2]>>>,
    /// Where the steps of the integrator ended, s.
    pub steps: Vec<f64>,
    /// Steps of all runs that were made, those for slopes included.
    pub steps_in_all: usize,
}

/// Fewest samples that say something.
pub(crate) const LEAST_SAMPLES: usize = 5;
/// Noise that is assumed of a track at least, m: no camera is better.
const LEAST_NOISE: f64 = 1e-7;
/// Noise of a track that does not say, m.
const USUAL_NOISE: f64 = 2e-4;
/// Shortest last step of a run on the steps of another, s.
const LEAST_STEP: f64 = 1e-6;
/// Steps after which a run of a fit is given up.
const MOST_STEPS: usize = 300_000;

impl Measured {
    pub fn of(trial: &Trial) -> Result<Self, CalibrateError> {
        let release = &trial.release;
        for track in &release.tracks {
            if let Point::Along(share) = track.at
                && !(0.0..=1.0).contains(&share)
            {
                return Err(CalibrateError::OffTheRod {
                    release: release.name.clone(),
                    marker: track.marker.clone(),
                    share,
                });
            }
        }
        // The posture in the hand is known from the end of the hold.
        let clear = if trial.is_held() { -LATE_HOLD } else { CLEAR * release.release_uncertainty };
        let is_seen = |k: &usize| release.tracks.iter().any(|track| track.position[*k].is_some());
        let samples: Vec<usize> =
            (0..release.time.len()).filter(|k| release.time[*k] > clear).filter(is_seen).collect();
        if samples.len() < LEAST_SAMPLES {
            return Err(CalibrateError::TooFewSamples {
                release: release.name.clone(),
                samples: samples.len(),
                least: LEAST_SAMPLES,
            });
        }
        let camera_noise: Vec<f64> = (release.tracks.iter())
            .map(|track| match track.noise {
                noise if noise > 0.0 && noise.is_finite() => noise.max(LEAST_NOISE),
                _ => USUAL_NOISE,
            })
            .collect();
        let both = release.tracks.iter().zip(&camera_noise);
        let noise = both.map(|(track, noise)| noise.hypot(track.discrepancy)).collect();
        Ok(Self { samples, noise, camera_noise })
    }
}

impl Member<'_> {
    /// Values of the unknowns as the model takes them: parameters, and the release instant, s.
    pub fn values(&self, x: &DVector<f64>) -> (Vec<(usize, f64)>, f64) {
        let mut theta: Vec<(usize, f64)> = Vec::new();
        let mut instant = 0.0;
        for local in self.locals {
            let value = self.unknowns[local.unknown].scaled.value(x[local.unknown]);
            match local.acts {
                Acts::Theta(k) => theta.push((k, value)),
                Acts::OnTheta(k) => {
                    let fitted = theta.iter().find(|(own, _)| *own == k);
                    theta.push((k, fitted.map_or(self.trial.model.theta[k], |(_, fitted)| *fitted) + value));
                }
                Acts::Instant => instant = value,
                Acts::Offset { .. } => {}
            }
        }
        (theta, instant)
    }

    /// The trajectory with parameters set, `(index in theta, value)`, and its derivatives by the `watched` ones.
    pub fn simulate(
        &self,
        theta: &[(usize, f64)],
        instant: f64,
        request: RunRequest,
        watched: Vec<usize>,
    ) -> Result<Trajectory, ForwardError> {
        let Self { trial, measured, .. } = *self;
        let RunRequest { count, fidelity, steps } = request;
        let (mut model, mut initial) = trial.with(theta);
        if fidelity.refinement > 1 {
            refine(&mut model, &mut initial, fidelity.refinement)?;
        }
        let times: Vec<f64> =
            (measured.samples[..count].iter()).map(|k| (trial.release.time[*k] - instant).max(0.0)).collect();
        let last = times.last().copied().unwrap_or(0.0);
        let duration = last.max(Sensor::new(&model, model.theta.clone()).instant(last));
        let run = Run {
            initial,
            history: trial.run.history,
            duration,
            samples: times,
            method: if trial.run.method == Method::Auto { Method::Rodas4 } else { trial.run.method },
            tolerance: fidelity.tolerance,
            steps: steps.ending_before(duration - LEAST_STEP),
            most_steps: trial.run.most_steps.min(MOST_STEPS),
            keep_samples: true,
            keep_steps: true,
            energy: false,
            sensitivities: watched,
            points: trial.release.tracks.iter().map(|track| track.at).collect(),
            trace_step: None,
            cancel: trial.run.cancel.clone(),
            work: trial.run.work.clone(),
        };
        let path = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
        if let Status::CutShort { time } = path.status {
            return Err(ForwardError::CutShort { time });
        }
        Ok(path)
    }

    /// Simulates it and looks at it as its recording did.
    pub fn predict(
        &self,
        x: &DVector<f64>,
        request: RunRequest,
        slopes: Option<Slopes>,
    ) -> Result<Prediction, ForwardError> {
        let Self { trial, measured, .. } = *self;
        let RunRequest { count, fidelity, .. } = request;
        let (theta, instant) = self.values(x);
        let watched: Vec<usize> = match slopes {
            Some(Slopes::Variational) => theta.iter().map(|(k, _)| *k).collect(),
            _ => Vec::new(),
        };
        let slips = || trial.with(&theta).0.slipping().is_some();
        let path = match (self.simulate(&theta, instant, request.clone(), watched.clone()), request.steps) {
            // Friction at rest turns either way by rounding: a run on the steps of another, or on its own, may have to resolve
            // a turn that the first one did not.
            (
                Err(ForwardError::Integrate { error: IntegrateError::StepTooLong { .. }, .. }),
                Steps::Repeated(ends),
            ) if slips() => {
                let resolving = RunRequest { count, fidelity, steps: Steps::Given(ends) };
                self.simulate(&theta, instant, resolving, watched)?
            }
            (path, _) => path?,
        };
        let tracks = trial.release.tracks.len();
        // A hand that moves brings the markers along a straight line to where it lets go.
        let way = |track: usize, sample: usize| {
            let before = trial.release.time[measured.samples[sample]] - instant;
            let velocity = path.point_velocities[0][track];
            if trial.is_held() && before < 0.0 {
                velocity.map(|velocity| before * velocity)
            } else {
                [0.0; 2]
            }
        };
        let of_track = |track: usize| {
            let moved = |(sample, points): (usize, &Vec<[f64; 2]>)| {
                let ([x, z], [dx, dz]) = (points[track], way(track, sample));
                [x + dx, z + dz]
            };
            path.points.iter().enumerate().map(moved).collect()
        };
        let mut prediction = Prediction {
            position: (0..tracks).map(of_track).collect(),
            slopes: Vec::new(),
            steps: path.steps.clone(),
            steps_in_all: path.steps.len(),
        };
        if let Some(slopes) = slopes {
            self.add_slopes(&mut prediction, x, slopes, &path, (count, fidelity))?;
        }
        Ok(prediction)
    }

    /// Adds the slopes of a prediction that was simulated along a path.
    fn add_slopes(
        &self,
        prediction: &mut Prediction,
        x: &DVector<f64>,
        slopes: Slopes,
        path: &Trajectory,
        (count, fidelity): (usize, Fidelity),
    ) -> Result<(), ForwardError> {
        let Self { trial, locals, unknowns, .. } = *self;
        let tracks = trial.release.tracks.len();
        let difference = match slopes {
            Slopes::Differences if self.trial.with(&self.values(x).0).0.slipping().is_some() => {
                DIFFERENCE_WITH_FRICTION
            }
            _ => DIFFERENCE,
        };
        let moved = |(l, local): (usize, &Local)| match (slopes, local.acts) {
            (Slopes::Differences, Acts::Theta(_) | Acts::OnTheta(_)) => {
                let mut aside = x.clone();
                aside[locals[l].unknown] += difference;
                let steps = Steps::Repeated(path.steps.clone());
                self.predict(&aside, RunRequest { count, fidelity, steps }, None).map(Some)
            }
            _ => Ok(None),
        };
        let moved = in_order::<_, Result<Vec<Option<Prediction>>, ForwardError>>(
            locals.par_iter().enumerate().map(moved),
        )?;
        prediction.steps_in_all += moved.iter().flatten().map(|moved| moved.steps_in_all).sum::<usize>();
        let chain: Vec<f64> =
            locals.iter().map(|local| unknowns[local.unknown].scaled.slope(x[local.unknown])).collect();
        for track in 0..tracks {
            let row = |sample: usize| {
                let found = path.points_by_parameters.get(sample);
                let mut by_theta = found.map_or(&[][..], |points| &points[track]).iter();
                let is_held = path.times[sample] <= 0.0;
                let of_local = |((local, chain), moved): ((&Local, &f64), &Option<Prediction>)| match local
                    .acts
                {
                    _ if moved.is_some() => {
                        let aside = moved.as_ref().map_or([0.0; 2], |moved| moved.position[track][sample]);
                        let here = prediction.position[track][sample];
                        [0, 1].map(|axis| (aside[axis] - here[axis]) / difference)
                    }
                    Acts::Theta(_) | Acts::OnTheta(_) => {
                        by_theta.next().map_or([0.0; 2], |slope| slope.map(|slope| chain * slope))
                    }
                    Acts::Instant if is_held && !trial.is_held() => [0.0; 2],
                    Acts::Instant => path.point_velocities[sample][track].map(|rate| -chain * rate),
                    Acts::Offset { track: own, axis } => {
                        [0, 1].map(|k| if own == track && axis == k { *chain } else { 0.0 })
                    }
                };
                locals.iter().zip(&chain).zip(&moved).map(of_local).collect()
            };
            prediction.slopes.push((0..count).map(row).collect());
        }
        Ok(())
    }
}
