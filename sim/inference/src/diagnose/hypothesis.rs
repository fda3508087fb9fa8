//! A hypothesis: models of all releases and the unknowns that act on them; how it is simulated, with slopes by all unknowns
//! from one run of each release.

use std::ops::{ControlFlow, Range};

use efam_core::forward::{Cancel, FAST_TOLERANCE, Initial, Run, forward};
use efam_core::integrate::{Method, Steps};
use efam_core::levenberg_marquardt::{FIRST_DAMPING, Search};
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::release::Point;
use models::error::ModelError;
use models::model::Model;
use models::sensor::Sensor;
use nalgebra::DVector;

use super::unknown::{Act, Unknown};
use crate::calibrate::{CalibrateError, Trial};
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
    /// The statement that is freed.
    pub freed: Option<&'static str>,
}

/// Coordinates of one release, and how each unknown that acts on it moves them: shape `[coordinate][sample]`, m.
pub struct Simulated {
    pub coordinates: Vec<Vec<f64>>,
    pub slopes: Vec<(usize, Vec<Vec<f64>>)>,
}

/// What the unknowns make of the model of one release.
#[derive(Default)]
struct Setting<'a> {
    /// Parameters with their values.
    theta: Vec<(usize, f64)>,
    /// Shift of the recording's zero, s.
    instant: f64,
    /// Shift of all tracks, m.
    offset: [f64; 2],
    /// Places of the tracks on the rod.
    points: Vec<Point>,
    /// Unknowns of which slopes are wanted.
    chains: Vec<Chain<'a>>,
}

/// An unknown, how it acts, and the derivatives of the parameters that it moves.
struct Chain<'a> {
    unknown: usize,
    act: &'a Act,
    theta: Vec<(usize, f64)>,
    /// Derivative of what is no parameter: an instant, an offset, a place.
    slope: f64,
}

impl Hypothesis {
    /// Where a search begins.
    pub fn start(&self) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|own| own.start))
    }

    /// How its unknowns are searched: `longest` is the longest step, prior standard deviations, `tolerance` the predicted
    /// decrease of the cost that is not worth a step, nats.
    pub fn search(&self, longest: f64, tolerance: f64, most_evaluations: usize) -> Search {
        // Half-normal unknowns are not negative.
        let bounds = |own: &Unknown| (if own.is_half { 0.0 } else { -FARTHEST }, FARTHEST);
        Search {
            bounds: self.unknowns.iter().map(bounds).collect(),
            longest: vec![longest; self.unknowns.len()],
            tolerance,
            relative: 0.0,
            most_evaluations,
            first_damping: FIRST_DAMPING,
            reuses_slopes: true,
            is_followed: true,
        }
    }

    /// Simulates one release at the times of its plan, with slopes by the unknowns of which they are wanted. None where the model
    /// cannot be run.
    pub fn simulate(
        &self,
        r: usize,
        plan: &Plan,
        z: &DVector<f64>,
        wanted: &Range<usize>,
    ) -> Option<Simulated> {
        let mut setting = self.setting(r, &plan.tracks, z, wanted);
        let markers = setting.points.len();
        let asides: Vec<usize> = setting.chains.iter().filter_map(|chain| setting.place(chain)).collect();
        for track in asides {
            setting.points.push(setting.aside(track));
        }
        let mut watched: Vec<usize> =
            setting.chains.iter().flat_map(|chain| chain.theta.iter().map(|(k, _)| *k)).collect();
        watched.sort_unstable();
        watched.dedup();
        let (path, times) = self.path(r, plan, &setting, &watched)?;
        let offset = setting.offset;
        let seen = |m: usize, k: usize| [0, 1].map(|axis| path.points[k][m][axis] + offset[axis]);
        let coordinates = plan.coordinates(&seen, times.len());
        if !coordinates.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        let mut slopes: Vec<(usize, Vec<Vec<f64>>)> = Vec::with_capacity(setting.chains.len());
        let mut aside = markers;
        for chain in &setting.chains {
            let own =
                Moved { chain, setting: &setting, path: &path, times: &times, watched: &watched, aside };
            aside += usize::from(setting.place(chain).is_some());
            let moved = plan.coordinates(&|m, k| own.at(m, k), times.len());
            match slopes.iter_mut().find(|(u, _)| *u == chain.unknown) {
                Some((_, known)) => known
                    .iter_mut()
                    .flatten()
                    .zip(moved.into_iter().flatten())
                    .for_each(|(known, more)| *known += more),
                None => slopes.push((chain.unknown, moved)),
            }
        }
        Some(Simulated { coordinates, slopes })
    }

    /// Values of the model and of the setup at `z`.
    fn setting(&self, r: usize, tracks: &[usize], z: &DVector<f64>, wanted: &Range<usize>) -> Setting<'_> {
        let trial = &self.trials[r];
        let points = tracks.iter().map(|track| trial.release.tracks[*track].at).collect();
        let mut setting = Setting { points, ..Setting::default() };
        for (u, unknown) in self.unknowns.iter().enumerate() {
            for (_, act) in unknown.acts.iter().filter(|(own, _)| *own == r) {
                let (mut theta, mut slope) = (Vec::new(), unknown.slope(0.0, z[u]));
                match act {
                    Act::Theta(places) => {
                        theta = places
                            .iter()
                            .map(|k| (*k, setting.move_theta(trial, *k, unknown, z[u])))
                            .collect();
                    }
                    Act::Instant => setting.instant += unknown.value(0.0, z[u]),
                    Act::Offset(axis) => setting.offset[*axis] += unknown.value(0.0, z[u]),
                    Act::Place(track) => {
                        if let Some(Point::Along(share)) = setting.points.get_mut(*track) {
                            slope = unknown.slope(*share, z[u]);
                            *share = unknown.value(*share, z[u]).clamp(0.0, 1.0);
                        }
                    }
                }
                if wanted.contains(&u) {
                    setting.chains.push(Chain { unknown: u, act, theta, slope });
                }
            }
        }
        setting
    }

    /// The run of one release, with the times at which it is compared, s.
    fn path(
        &self,
        r: usize,
        plan: &Plan,
        setting: &Setting,
        watched: &[usize],
    ) -> Option<(Trajectory, Vec<f64>)> {
        let trial = &self.trials[r];
        let (model, initial) = trial.with(&setting.theta);
        let times: Vec<f64> = plan.time.iter().map(|t| (t - setting.instant).max(0.0)).collect();
        let path = run(trial, &model, initial, &times, setting.points.clone(), watched)?;
        Some((path, times))
    }

    /// One release with the values of all unknowns at `z`; `tracks` are those of its plan.
    pub fn settled(&self, r: usize, tracks: &[usize], z: &DVector<f64>) -> Settled {
        let setting = self.setting(r, tracks, z, &(0..0));
        let mut trial = self.trials[r].clone();
        (trial.model, trial.run.initial) = trial.with(&setting.theta);
        trial.run.cancel = Cancel::default();
        for (place, track) in tracks.iter().enumerate() {
            trial.release.tracks[*track].at = setting.points[place];
        }
        Settled { trial, instant: setting.instant, offset: setting.offset }
    }

    /// The hypothesis of the releases from `first` on alone, which are those that are held out: what they share with others stays as it
    /// is at `z`, and what is their own is unknown. `plans` are those of all releases.
    pub fn apart(&self, first: usize, plans: &[&Plan], z: &DVector<f64>) -> Self {
        let is_own = |u: &usize| self.unknowns[*u].acts.iter().all(|(r, _)| *r >= first);
        let (own, shared): (Vec<usize>, Vec<usize>) = (0..z.len()).partition(is_own);
        let of = |places: &[usize]| places.iter().map(|u| self.unknowns[*u].clone()).collect::<Vec<_>>();
        let known = Self { unknowns: of(&shared), ..self.clone() };
        let z = z.select_rows(&shared);
        let trials = (first..plans.len()).map(|r| known.settled(r, &plans[r].tracks, &z).trial);
        let mut unknowns = of(&own);
        unknowns.iter_mut().flat_map(|own| &mut own.acts).for_each(|(r, _)| *r -= first);
        Self { trials: trials.collect(), unknowns, freed: None }
    }
}

impl Hypothesis {
    /// The same of other releases, each planned like one of these, with a place of its unknowns. What belongs to a release alone
    /// does so in each that is planned like it. None where a model has not the parameters of its own.
    pub fn planned(
        &self,
        z: &DVector<f64>,
        like: &[usize],
        trials: Vec<Trial>,
    ) -> Option<(Self, DVector<f64>)> {
        let act = |p: usize, act: &Act| -> Option<(usize, Act)> {
            let Act::Theta(places) = act else { return Some((p, act.clone())) };
            let path =
                |k: &usize| trials[p].model.index(&self.trials[like[p]].model.parameters[*k].path).ok();
            Some((p, Act::Theta(places.iter().map(path).collect::<Option<_>>()?)))
        };
        let (mut unknowns, mut values) = (Vec::new(), Vec::new());
        for (unknown, z) in self.unknowns.iter().zip(z) {
            let of = |p: usize| {
                unknown.acts.iter().filter(move |(r, _)| *r == like[p]).map(move |(_, own)| act(p, own))
            };
            let acts = (0..like.len()).flat_map(of).collect::<Option<Vec<_>>>()?;
            let each: Vec<Vec<(usize, Act)>> =
                if unknown.is_own { acts.into_iter().map(|own| vec![own]).collect() } else { vec![acts] };
            for acts in each {
                unknowns.push(Unknown { acts, ..unknown.clone() });
                values.push(*z);
            }
        }
        Some((Self { trials, unknowns, freed: self.freed }, DVector::from_vec(values)))
    }
}

/// One release as a fit has it.
pub struct Settled {
    /// With the fitted values in its model; its tracks are where the fit has them on the rod.
    pub trial: Trial,
    /// How much later than its recording's zero it begins, s.
    pub instant: f64,
    /// How far all its tracks are off, m.
    pub offset: [f64; 2],
}

impl Settled {
    /// Positions of its tracks as the model has them, `[sample][track]`, m; none where it cannot be run.
    pub fn positions(&self) -> Option<Vec<Vec<[f64; 2]>>> {
        let Trial { release, model, run: own } = &self.trial;
        let times: Vec<f64> = release.time.iter().map(|t| (t - self.instant).max(0.0)).collect();
        let points = release.tracks.iter().map(|track| track.at).collect();
        let path = run(&self.trial, model, own.initial.clone(), &times, points, &[])?;
        let seen = |point: &[f64; 2]| [0, 1].map(|axis| point[axis] + self.offset[axis]);
        Some(path.points.iter().map(|all| all.iter().map(seen).collect()).collect())
    }

    /// The trial with what its model has in the place of what was recorded; none where it cannot be run.
    pub fn recorded(mut self) -> Option<Trial> {
        let positions = self.positions()?;
        for (t, track) in self.trial.release.tracks.iter_mut().enumerate() {
            track.position = positions.iter().map(|all| Some(all[t])).collect();
        }
        Some(self.trial)
    }

    /// The trial on another mesh.
    /// # Errors
    /// [`ModelError`] for a mesh that the model cannot have.
    pub fn on_mesh(&self, nodes: usize) -> Result<Trial, ModelError> {
        let mut trial = self.trial.clone();
        (trial.model, trial.run) = trial.run.on_mesh(&trial.model, nodes)?;
        Ok(trial)
    }
}

/// Why a trial cannot be compared: what keeps its model from being run, or else that no fit was found.
pub fn refusal(trial: &Trial) -> CalibrateError {
    let release = trial.release.name.clone();
    match forward(&trial.model, &trial.run, &mut |_| ControlFlow::Continue(())) {
        Err(error) => CalibrateError::Forward { release, error: Box::new(error) },
        Ok(_) => CalibrateError::NoFit { release },
    }
}

/// The run of a trial with a model and a start, compared at these times, s, and points. None where it does not come to its end.
fn run(
    trial: &Trial,
    model: &Model,
    initial: Initial,
    times: &[f64],
    points: Vec<Point>,
    watched: &[usize],
) -> Option<Trajectory> {
    let last = times.last().copied()?;
    let run = Run {
        initial,
        history: trial.run.history,
        duration: last.max(Sensor::new(model, model.theta.clone()).instant(last)),
        samples: times.to_vec(),
        method: if trial.run.method == Method::Auto { Method::Rodas4 } else { trial.run.method },
        tolerance: FAST_TOLERANCE,
        steps: Steps::Adaptive,
        most_steps: trial.run.most_steps.min(MOST_STEPS),
        keep_samples: true,
        keep_steps: false,
        energy: false,
        sensitivities: watched.to_vec(),
        points,
        trace_step: None,
        cancel: trial.run.cancel.clone(),
        work: trial.run.work.clone(),
    };
    let path = forward(model, &run, &mut |_| ControlFlow::Continue(())).ok()?;
    (path.status == Status::Complete && path.points.len() == times.len()).then_some(path)
}

impl Setting<'_> {
    /// Moves a parameter by an unknown, within its range; the derivative of its value.
    fn move_theta(&mut self, trial: &Trial, k: usize, unknown: &Unknown, z: f64) -> f64 {
        let own = self.theta.iter().position(|(other, _)| *other == k).unwrap_or_else(|| {
            self.theta.push((k, trial.model.theta[k]));
            self.theta.len() - 1
        });
        let before = self.theta[own].1;
        let (low, high) = trial.model.parameters[k].range;
        self.theta[own].1 = unknown.value(before, z).max(low).min(high);
        unknown.slope(before, z)
    }

    /// The track whose place an unknown moves.
    fn place(&self, chain: &Chain) -> Option<usize> {
        match chain.act {
            Act::Place(track) if matches!(self.points[*track], Point::Along(_)) => Some(*track),
            _ => None,
        }
    }

    /// A point beside a track's, by whose distance the slope of its place is taken.
    fn aside(&self, track: usize) -> Point {
        match self.points[track] {
            Point::Along(share) => Point::Along((share + PLACE_STEP).min(1.0)),
            other => other,
        }
    }
}

/// How the markers of a run move with one unknown.
struct Moved<'a> {
    chain: &'a Chain<'a>,
    setting: &'a Setting<'a>,
    path: &'a Trajectory,
    times: &'a [f64],
    /// Parameters of the run's slopes.
    watched: &'a [usize],
    /// Point of the run beside the chain's own track, if it moves one.
    aside: usize,
}

impl Moved<'_> {
    /// Derivative of the place of marker `m` at sample `k`, m.
    fn at(&self, m: usize, k: usize) -> [f64; 2] {
        let slope = self.chain.slope;
        match *self.chain.act {
            Act::Theta(_) => {
                let by = &self.path.points_by_parameters[k][m];
                let of = |axis: usize| {
                    let terms =
                        self.chain.theta.iter().filter_map(|(k, slope)| {
                            Some(slope * by[self.watched.binary_search(k).ok()?][axis])
                        });
                    terms.sum()
                };
                [of(0), of(1)]
            }
            // Before the release the rod is at rest.
            Act::Instant if self.times[k] > 0.0 => self.path.point_velocities[k][m].map(|rate| -slope * rate),
            Act::Instant => [0.0; 2],
            Act::Offset(axis) => [0, 1].map(|own| if own == axis { slope } else { 0.0 }),
            Act::Place(track) if track == m && self.setting.place(self.chain).is_some() => {
                let step = match (self.setting.aside(track), self.setting.points[track]) {
                    (Point::Along(there), Point::Along(here)) => there - here,
                    _ => 0.0,
                };
                let (there, here) = (self.path.points[k][self.aside], self.path.points[k][track]);
                [0, 1].map(|axis| if step > 0.0 { slope * (there[axis] - here[axis]) / step } else { 0.0 })
            }
            Act::Place(_) => [0.0; 2],
        }
    }
}

/// Standard deviations beyond which nothing is searched.
const FARTHEST: f64 = 8.0;
