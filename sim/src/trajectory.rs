//! What a run leaves: the sampled states, the path of the tip, its derivatives, what it cost.

use models::effects::LANES;
use models::model::Model;
use models::snapshot::Energy;
use models::system::System;

use crate::forward::{self, Run};
use crate::integrate::variational::{Variational, lane_order};
use crate::integrate::{Effort, State};
use crate::observed::Observed;

/// Whether a run came to its end.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
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
    /// Times of the samples that were reached, s.
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
    /// Positions of the further points of [`Run::points`] in W, m, shape `[samples][points]`.
    pub points: Vec<Vec<[f64; 2]>>,
    /// Their velocities, m/s.
    pub point_velocities: Vec<Vec<[f64; 2]>>,
    /// Derivatives of their positions, shape `[samples][points][parameters]`, m per unit.
    pub points_by_parameters: Vec<Vec<Vec<[f64; 2]>>>,
    /// Where the steps ended, s, if the run keeps that.
    pub steps: Vec<f64>,
    /// What it cost.
    pub effort: Effort,
    /// Whether it came to its end.
    pub status: Status,
    dof: usize,
    memory: usize,
    /// Lane of each parameter of [`Run::sensitivities`], counted over all groups.
    lanes: Vec<usize>,
    observed: Vec<Observed>,
    row: Vec<[f64; LANES]>,
}

impl Trajectory {
    pub(crate) fn new(model: &Model, run: &Run) -> Self {
        let (dof, memory) = (model.dof(), model.memory());
        let samples = run.samples.len();
        let order = lane_order(model, &run.sensitivities);
        let lane = |k: &usize| order.iter().position(|other| other == k).expect("the same parameters");
        Self {
            times: Vec::with_capacity(samples),
            states: Vec::with_capacity(samples * (2 * dof + memory)),
            tip: Vec::with_capacity(samples),
            tip_velocity: Vec::with_capacity(samples),
            lanes: run.sensitivities.iter().map(lane).collect(),
            observed: run.points.iter().map(|point| Observed::new(*point, model.edges)).collect(),
            row: vec![[0.0; LANES]; dof],
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
        if !self.observed.is_empty() {
            let seen = self.observed.iter().map(|point| point.see(system, &state.q, &state.v));
            let (positions, velocities) = seen.unzip();
            self.points.push(positions);
            self.point_velocities.push(velocities);
        }
        self.energy.push(energy);
    }

    pub(crate) fn record_slopes(&mut self, variational: &Variational, state: &State, begin: f64, end: f64) {
        let system = variational.system();
        let lanes = variational.slopes.len() * LANES;
        let mut slopes = Vec::with_capacity(lanes);
        let mut of_points = vec![Vec::with_capacity(lanes); self.observed.len()];
        // The tip hangs on the end body alone.
        let first = if self.observed.is_empty() { self.dof - 3 } else { 0 };
        for group in 0..variational.slopes.len() {
            variational.interpolate(group, [begin, end], state.time, first, &mut self.row);
            let [x, z] = system.tip_by_parameters(group, system.model.tip_distance, &state.q, &self.row);
            slopes.extend(x.into_iter().zip(z).map(|(x, z)| [x, z]));
            for (point, slopes) in self.observed.iter().zip(&mut of_points) {
                let [x, z] = point.by_parameters(system, group, &state.q, &self.row);
                slopes.extend(x.into_iter().zip(z).map(|(x, z)| [x, z]));
            }
        }
        let in_order = |slopes: &Vec<[f64; 2]>| self.lanes.iter().map(|lane| slopes[*lane]).collect();
        self.tip_by_parameters.push(in_order(&slopes));
        if !of_points.is_empty() {
            self.points_by_parameters.push(of_points.iter().map(in_order).collect());
        }
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
