//! A hypothesis: models of all releases and the unknowns that act on them; how it is simulated, with slopes by all unknowns
//! from one run of each release.

use std::ops::ControlFlow;

use efam_core::forward::{FAST_TOLERANCE, Run, forward};
use efam_core::integrate::{Method, Steps};
use efam_core::trajectory::Status;
use efam_experiments::release::Point;
use models::sensor::Sensor;
use nalgebra::DVector;

use super::unknown::{Act, Unknown};
use crate::calibrate::Trial;
use crate::features::Plan;

/// Change of a marker's place along the rod by which its slope is taken, a share of the length: the rod bends over tenths.
const PLACE_STEP: f64 = 1e-3;
/// Steps after which a run is given up.
const MOST_STEPS: usize = 100_000;

/// Models and unknowns.
#[derive(Clone)]
pub struct Hypothesis {
    /// One for each release that is compared.
    pub trials: Vec<Trial>,
    pub unknowns: Vec<Unknown>,
    /// Effects that were added, and the statement that is freed.
    pub effects: Vec<String>,
    pub freed: Option<&'static str>,
}

/// Coordinates of one release, and how each unknown that acts on it moves them: shape `[coordinate][sample]`, m.
pub struct Simulated {
    pub coordinates: Vec<Vec<f64>>,
    pub slopes: Vec<(usize, Vec<Vec<f64>>)>,
}

/// An unknown, what it acts on, and the parameters that it moves with the derivatives of their values.
type Chain<'a> = (usize, &'a Act, Vec<(usize, f64)>);

impl Hypothesis {
    /// Where a search begins.
    pub fn start(&self) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|own| own.start))
    }

    /// Admissible `z`: half-normal unknowns are not negative, and eight standard deviations are beyond any prior.
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        self.unknowns
            .iter()
            .map(|own| if own.is_half { (0.0, FARTHEST) } else { (-FARTHEST, FARTHEST) })
            .collect()
    }

    /// Simulates one release at the times of its plan. `wanted` says of which unknowns slopes are wanted. None where the model
    /// cannot be run.
    pub fn simulate(
        &self,
        r: usize,
        plan: &Plan,
        z: &DVector<f64>,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Option<Simulated> {
        let trial = &self.trials[r];
        let (mut theta, mut instant, mut offset) = (Vec::<(usize, f64)>::new(), 0.0, [0.0; 2]);
        let mut points: Vec<Point> =
            plan.tracks.iter().map(|track| trial.release.tracks[*track].at).collect();
        // By unknown: parameters with the derivatives of their values.
        let mut chains: Vec<Chain<'_>> = Vec::new();
        for (u, unknown) in self.unknowns.iter().enumerate() {
            for (_, act) in unknown.acts.iter().filter(|(own, _)| *own == r) {
                let mut chain = Vec::new();
                match act {
                    Act::Theta(places) => {
                        for &k in places {
                            let own = theta.iter().position(|(other, _)| *other == k).unwrap_or_else(|| {
                                theta.push((k, trial.model.theta[k]));
                                theta.len() - 1
                            });
                            let before = theta[own].1;
                            let (low, high) = trial.model.parameters[k].range;
                            theta[own].1 = unknown.value(before, z[u]).max(low).min(high);
                            chain.push((k, unknown.slope(before, z[u])));
                        }
                    }
                    Act::Instant => instant += unknown.value(0.0, z[u]),
                    Act::Offset(axis) => offset[*axis] += unknown.value(0.0, z[u]),
                    Act::Place(track) => {
                        if let Point::Along(share) = &mut points[*track] {
                            *share = unknown.value(*share, z[u]).clamp(0.0, 1.0);
                        }
                    }
                }
                if wanted(u) {
                    chains.push((u, act, chain));
                }
            }
        }
        let markers = points.len();
        let mut watched: Vec<usize> = Vec::new();
        for (_, act, chain) in &chains {
            watched.extend(chain.iter().map(|(k, _)| *k));
            if let Act::Place(track) = act
                && let Point::Along(share) = points[*track]
            {
                points.push(Point::Along((share + PLACE_STEP).min(1.0)));
            }
        }
        watched.sort_unstable();
        watched.dedup();
        let (model, initial) = trial.with(&theta);
        let times: Vec<f64> = plan.time.iter().map(|t| (t - instant).max(0.0)).collect();
        let last = times.last().copied()?;
        let duration = last.max(Sensor::new(&model, model.theta.clone()).instant(last));
        let run = Run {
            initial,
            history: trial.run.history,
            duration,
            samples: times.clone(),
            method: if trial.run.method == Method::Auto { Method::Rodas4 } else { trial.run.method },
            tolerance: FAST_TOLERANCE,
            steps: Steps::Adaptive,
            most_steps: MOST_STEPS,
            keep_samples: true,
            keep_steps: false,
            energy: false,
            sensitivities: watched.clone(),
            points: points.clone(),
            trace_step: None,
            cancel: trial.run.cancel.clone(),
            work: trial.run.work.clone(),
        };
        let path = forward(&model, &run, &mut |_| ControlFlow::Continue(())).ok()?;
        if path.status != Status::Complete || path.points.len() != times.len() {
            return None;
        }
        let seen = |m: usize, k: usize| [0, 1].map(|axis| path.points[k][m][axis] + offset[axis]);
        let coordinates = plan.coordinates(&seen, times.len());
        if !coordinates.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        let mut place = markers;
        let mut slopes = Vec::with_capacity(chains.len());
        for (u, act, chain) in &chains {
            let columns: Vec<(usize, f64)> = (chain.iter())
                .filter_map(|(k, slope)| Some((watched.iter().position(|own| own == k)?, *slope)))
                .collect();
            let unknown = &self.unknowns[*u];
            let moved: Box<dyn Fn(usize, usize) -> [f64; 2]> = match act {
                Act::Theta(_) => Box::new(|m: usize, k: usize| {
                    let by = &path.points_by_parameters[k][m];
                    [0, 1].map(|axis| columns.iter().map(|(column, slope)| slope * by[*column][axis]).sum())
                }),
                Act::Instant => {
                    let slope = unknown.slope(0.0, z[*u]);
                    let times = &times;
                    let path = &path;
                    Box::new(move |m: usize, k: usize| {
                        let rate = if times[k] > 0.0 { path.point_velocities[k][m] } else { [0.0; 2] };
                        rate.map(|rate| -slope * rate)
                    })
                }
                Act::Offset(axis) => {
                    let (slope, axis) = (unknown.slope(0.0, z[*u]), *axis);
                    Box::new(move |_, _| [0, 1].map(|own| if own == axis { slope } else { 0.0 }))
                }
                Act::Place(track) => {
                    let Point::Along(share) = points[*track] else { continue };
                    let (track, aside, path) = (*track, place, &path);
                    let step = (share + PLACE_STEP).min(1.0) - share;
                    place += 1;
                    let slope = if step > 0.0 { unknown.slope(share, z[*u]) / step } else { 0.0 };
                    Box::new(move |m: usize, k: usize| {
                        let (there, here) = (path.points[k][aside], path.points[k][track]);
                        [0, 1].map(|axis| if m == track { slope * (there[axis] - here[axis]) } else { 0.0 })
                    })
                }
            };
            let moved = plan.coordinates(&*moved, times.len());
            match slopes.iter_mut().find(|(own, _): &&mut (usize, Vec<Vec<f64>>)| own == u) {
                Some((_, known)) => {
                    for (known, more) in known.iter_mut().flatten().zip(moved.into_iter().flatten()) {
                        *known += more;
                    }
                }
                None => slopes.push((*u, moved)),
            }
        }
        Some(Simulated { coordinates, slopes })
    }
}

/// Standard deviations beyond which nothing is searched.
pub const FARTHEST: f64 = 8.0;
