//! What a run leaves: the sampled states, the path of the tip, its derivatives, what it cost.

use models::model::Model;
use models::snapshot::Energy;
use models::system::System;

use crate::integrate::{Effort, State};
use crate::run::Run;

/// Whether a run came to its end.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Status {
    /// It did.
    #[default]
    Complete,
    /// An observer broke it off.
    CutShort {
        /// Last time integrated, s.
        time: f64,
    },
    /// It could not go on.
    Failed {
        /// Last time integrated, s.
        time: f64,
        /// Why.
        reason: String,
    },
}

/// What a law fed to the rod that, by its kind, feeds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fed {
    /// Name of the law.
    pub law: &'static str,
    /// Energy, J.
    pub energy: f64,
    /// Since when, s after release.
    pub since: Option<f64>,
}

/// The path of the tip, evenly spaced from time zero on: what analyses take, which the samples may be too far
/// apart for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Time between points, s; zero without any.
    pub step: f64,
    /// Position of the observed tip in W, m.
    pub tip: Vec<[f64; 2]>,
    /// Its velocity, m/s.
    pub velocity: Vec<[f64; 2]>,
    /// Angle of the end body, rad from x towards z.
    pub angle: Vec<f64>,
}

/// The tip at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// After release, s.
    pub time: f64,
    /// Position in W, m.
    pub tip: [f64; 2],
    /// Angle of the end body, rad from x towards z.
    pub angle: f64,
}

impl Trace {
    /// Heights of the tip, m.
    pub fn heights(&self) -> Vec<f64> {
        self.tip.iter().map(|tip| tip[1]).collect()
    }

    /// Largest extent of the path, m: the diagonal of the box that holds it.
    pub fn extent(&self) -> f64 {
        let Some(first) = self.tip.first() else { return 0.0 };
        let [mut low, mut high] = [*first; 2];
        for tip in &self.tip {
            for k in 0..2 {
                low[k] = low[k].min(tip[k]);
                high[k] = high[k].max(tip[k]);
            }
        }
        (high[0] - low[0]).hypot(high[1] - low[1])
    }

    /// Time of a point, s.
    pub fn time(&self, point: usize) -> f64 {
        point as f64 * self.step
    }

    /// Farthest that two traces are apart, m, and when, s; as far as both go.
    pub fn farthest(&self, other: &Trace) -> (f64, f64) {
        let apart = self.tip.iter().zip(&other.tip).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        let (mut most, mut at) = (0.0, 0);
        for (point, distance) in apart.enumerate() {
            if distance > most {
                (most, at) = (distance, point);
            }
        }
        (most, self.time(at))
    }

    /// Where the tip is lowest, between points by the cubic through two of them and their velocities: a tip that
    /// whips turns round within a few hundredths of a second.
    pub fn lowest(&self) -> Option<Instant> {
        let least = (0..self.tip.len()).min_by(|&a, &b| self.tip[a][1].total_cmp(&self.tip[b][1]))?;
        Some(self.low_about(least))
    }

    /// Where the tip first turned upwards.
    pub fn first_low(&self) -> Option<Instant> {
        let z = |point: usize| self.tip[point][1];
        let turns = |point: &usize| z(*point) < z(point - 1) && z(*point) <= z(point + 1);
        let first = (1..self.tip.len().saturating_sub(1)).find(turns)?;
        Some(self.low_about(first))
    }

    /// The lowest point of the steps before and after a point of the trace.
    fn low_about(&self, point: usize) -> Instant {
        let before = point.checked_sub(1).map(|before| self.low_between(before));
        let after = (point + 1 < self.tip.len()).then(|| self.low_between(point));
        let own = self.between(
            point.min(self.tip.len().saturating_sub(2)),
            if point + 1 < self.tip.len() { 0.0 } else { 1.0 },
        );
        [before, after]
            .into_iter()
            .flatten()
            .fold(own, |low, other| if other.tip[1] < low.tip[1] { other } else { low })
    }

    /// The lowest point of the step that begins at a point.
    fn low_between(&self, point: usize) -> Instant {
        let at = |k: usize| (self.tip[k][1], self.step * self.velocity[k][1]);
        let ((z, begin), (next, end)) = (at(point), at(point + 1));
        let rise = next - z;
        // Where the cubic's slope, begin + 2 square s + 3 cube s², turns from falling to rising.
        let (square, cube) = (3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise);
        let root = (square * square - 3.0 * cube * begin).max(0.0).sqrt();
        let turn = if square + root == 0.0 { 0.0 } else { -begin / (square + root) };
        let inner = self.between(point, turn.clamp(0.0, 1.0));
        [0.0, 1.0]
            .map(|share| self.between(point, share))
            .into_iter()
            .fold(inner, |low, other| if other.tip[1] < low.tip[1] { other } else { low })
    }

    /// The cubic through a point and the next at a share of the way; of the angle a straight line.
    fn between(&self, point: usize, share: f64) -> Instant {
        let next = (point + 1).min(self.tip.len() - 1);
        let tip = [0, 1].map(|k| {
            let (x, begin) = (self.tip[point][k], self.step * self.velocity[point][k]);
            let (rise, end) = (self.tip[next][k] - x, self.step * self.velocity[next][k]);
            let (square, cube) = (3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise);
            x + share * (begin + share * (square + share * cube))
        });
        let angle = self.angle[point] + share * (self.angle[next] - self.angle[point]);
        Instant { time: self.time(point) + share * self.step, tip, angle }
    }

    pub(crate) fn due(&self, end: f64, duration: f64) -> Option<f64> {
        let time = self.time(self.tip.len());
        (self.step > 0.0 && time <= end && time <= duration * (1.0 + 1e-12)).then_some(time)
    }

    pub(crate) fn record(&mut self, system: &System, state: &State) {
        let (tip, velocity) = system.observed_tip(&state.q, &state.v);
        self.tip.push(tip);
        self.velocity.push(velocity);
        self.angle.push(state.q[2 * system.model.edges]);
    }
}

/// A sampled trajectory.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use efam_core::forward::{Run, forward};
/// use efam_core::trajectory::Status;
/// # use models::effects::Rod;
/// # use models::model::{Model, ModelSpec};
/// # let rod = Rod { length: 0.2, mass: 0.03, bending_stiffness: 5e-3, axial_stiffness: 500.0, diameter: 0.03,
/// #     pressure: 0.0 };
/// # let model = Model::new(&ModelSpec { nodes: 12, ..ModelSpec::of(rod) }.with(&[("rayleigh_mass.alpha", 1.0)]))?;
///
/// let run = Run { energy: true, ..Run::release(1.0, 50.0) };
/// let path = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
/// assert_eq!(path.status, Status::Complete);
/// assert_eq!((path.times.len(), path.tip.len(), path.energy.len()), (51, 51, 51));
/// // A sample's state is all that another run needs to go on from there.
/// assert_eq!(path.state(25).time, 0.5);
/// assert!(path.closure().is_some_and(|share| share < 1e-3), "the energy closes");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// Times of the samples that were reached, s; this and what has a row a sample stay empty where the run keeps none.
    pub times: Vec<f64>,
    /// Coordinates, velocities and memory, one sample after another, shape `[samples][2 dof + memory]`.
    pub states: Vec<f64>,
    /// Position of the observed tip in W, m.
    pub tip: Vec<[f64; 2]>,
    /// Its velocity, m/s.
    pub tip_velocity: Vec<[f64; 2]>,
    /// Energies, if the run follows them.
    pub energy: Vec<Energy>,
    /// Derivative of the tip's position by each parameter of [`Run::sensitivities`], shape
    /// `[samples][parameters]`, m per unit.
    pub tip_by_parameters: Vec<Vec<[f64; 2]>>,
    /// Where a recording shows the tip at the times of the samples, m; empty unless an effect on what
    /// is observed acts.
    pub seen_tip: Vec<[f64; 2]>,
    /// Where a recording shows the points of [`Run::points`] at the times of the samples, m, shape
    /// `[samples][points]`: without an effect on what is observed, where they are in W.
    pub points: Vec<Vec<[f64; 2]>>,
    /// Their velocities in it, m/s.
    pub point_velocities: Vec<Vec<[f64; 2]>>,
    /// Derivatives of `points`, shape `[samples][points][parameters]`, m per unit.
    pub points_by_parameters: Vec<Vec<Vec<[f64; 2]>>>,
    /// Where the steps ended, s, if the run keeps that.
    pub steps: Vec<f64>,
    /// The path of the tip alone, as often as the run says.
    pub trace: Trace,
    /// What it cost.
    pub effort: Effort,
    /// Energy that laws as text fed, if the run follows energies.
    pub fed: Vec<Fed>,
    /// Whether it came to its end.
    pub status: Status,
    dof: usize,
    memory: usize,
}

impl Trajectory {
    pub(crate) fn new(model: &Model, run: &Run) -> Self {
        let (dof, memory) = (model.dof(), model.memory());
        let samples = if run.keep_samples { run.samples.len() } else { 0 };
        Self {
            times: Vec::with_capacity(samples),
            states: Vec::with_capacity(samples * (2 * dof + memory)),
            tip: Vec::with_capacity(samples),
            tip_velocity: Vec::with_capacity(samples),
            trace: Trace { step: run.trace_step.unwrap_or(0.0), ..Trace::default() },
            dof,
            memory,
            ..Self::default()
        }
    }

    pub(crate) fn record(&mut self, system: &System, state: &State, energy: Energy) {
        self.times.push(state.time);
        self.states.extend(state.q.iter().chain(&state.v).chain(&state.z));
        let (tip, velocity) = system.observed_tip(&state.q, &state.v);
        self.tip.push(tip);
        self.tip_velocity.push(velocity);
        self.energy.push(energy);
    }

    /// Leaves out what was seen beyond the last sample of the states.
    pub(crate) fn cut(&mut self) {
        let samples = self.times.len();
        self.seen_tip.truncate(samples);
        self.points.truncate(samples);
        self.point_velocities.truncate(samples);
        self.points_by_parameters.truncate(samples);
    }

    /// The state of a sample.
    pub fn state(&self, sample: usize) -> State {
        let width = 2 * self.dof + self.memory;
        let row = &self.states[sample * width..(sample + 1) * width];
        let (q, rest) = row.split_at(self.dof);
        let (v, z) = rest.split_at(self.dof);
        State { time: self.times[sample], q: q.to_vec(), v: v.to_vec(), z: z.to_vec() }
    }

    /// Largest distance of the energy's total from its start, over the largest change of its kinetic, elastic or
    /// potential part; none where the run does not follow it or nothing moves.
    pub fn closure(&self) -> Option<f64> {
        self.energy.first()?;
        let parts: [&dyn Fn(&Energy) -> f64; 3] = [&|e| e.kinetic, &|e| e.elastic, &|e| e.potential];
        let exchanged = parts.into_iter().map(|part| self.largest_change(part)).fold(0.0, f64::max);
        (exchanged > 0.0).then(|| self.largest_change(&Energy::total) / exchanged)
    }

    /// Energy of the motion itself, J: the largest kinetic energy, or what was dissipated or supplied, if that is more.
    /// About a rest, elastic and potential energy change by much more, and cancel. None where the run does not follow
    /// energies or nothing moves.
    pub fn motion_energy(&self) -> Option<f64> {
        let of = |e: &Energy| e.kinetic.max(e.dissipated.abs()).max(e.supplied.abs());
        self.energy.iter().map(of).reduce(f64::max).filter(|energy| *energy > 0.0)
    }

    /// Largest distance of the energy's total from its start, over the energy of the motion itself; none without that.
    pub fn unclosed(&self) -> Option<f64> {
        self.motion_energy().map(|moved| self.largest_change(&Energy::total) / moved)
    }

    /// Largest change of an energy from its start, J.
    fn largest_change(&self, of: &dyn Fn(&Energy) -> f64) -> f64 {
        let Some(first) = self.energy.first() else { return 0.0 };
        self.energy.iter().map(|energy| (of(energy) - of(first)).abs()).fold(0.0, f64::max)
    }

    /// Heights of the tip, m.
    pub fn tip_z(&self) -> Vec<f64> {
        self.tip.iter().map(|tip| tip[1]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(z: fn(f64) -> (f64, f64), step: f64, count: usize) -> Trace {
        let mut trace = Trace { step, ..Trace::default() };
        for k in 0..count {
            let (height, rate) = z(step * k as f64);
            trace.tip.push([0.0, height]);
            trace.velocity.push([0.0, rate]);
            trace.angle.push(0.0);
        }
        trace
    }

    /// A parabola is a cubic; a cosine is one up to a fourth power of the step.
    #[test]
    fn the_lowest_lies_between_points() {
        let parabola = |t: f64| ((t - 4.3).powi(2) - 1.0, 2.0 * (t - 4.3));
        let low = trace(parabola, 1.0, 10).lowest().unwrap();
        assert!((low.tip[1] + 1.0).abs() < 1e-12 && (low.time - 4.3).abs() < 1e-12, "{low:?}");
        let cosine = |t: f64| (t.cos(), -t.sin());
        let low = trace(cosine, 0.3, 20).lowest().unwrap();
        assert!((low.tip[1] + 1.0).abs() < 0.3f64.powi(4) / 384.0, "{low:?}");
        let line = |t: f64| (t, 1.0);
        assert_eq!(trace(line, 1.0, 2).lowest().map(|low| (low.time, low.tip[1])), Some((0.0, 0.0)));
        assert_eq!(trace(line, 1.0, 0).lowest(), None);
    }

    #[test]
    fn the_first_turn_is_not_the_lowest() {
        let swing = |t: f64| ((1.0 + 0.1 * t) * t.cos(), 0.1 * t.cos() - (1.0 + 0.1 * t) * t.sin());
        let trace = trace(swing, 0.1, 200);
        let (first, lowest) = (trace.first_low().unwrap(), trace.lowest().unwrap());
        assert!((first.time - 3.22).abs() < 0.02 && lowest.time > 9.0, "{first:?}, {lowest:?}");
    }
}
