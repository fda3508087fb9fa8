//! What a run leaves: the sampled states, the path of the tip, its derivatives, what it cost.

use models::model::Model;
use models::snapshot::Energy;
use models::system::System;

use crate::forward::{self, Run};
use crate::integrate::{Effort, State};
use crate::schema::JsonSchema;

/// Whether a run came to its end.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, JsonSchema)]
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

/// A sampled trajectory.
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
    /// What it cost.
    pub effort: Effort,
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
            dof,
            memory,
            ..Self::default()
        }
    }

    pub(crate) fn record(&mut self, system: &System, state: &State, energy: Energy) {
        self.times.push(state.time);
        self.states.extend(state.q.iter().chain(&state.v).chain(&state.z));
        let (tip, velocity) = forward::tip(system, &state.q, &state.v);
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

    /// Heights of the tip, m.
    pub fn tip_z(&self) -> Vec<f64> {
        self.tip.iter().map(|tip| tip[1]).collect()
    }
}
