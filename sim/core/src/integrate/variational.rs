//! Forward sensitivities: the derivative of a trajectory by parameters, integrated along it.
//!
//! The derivatives obey the linearised equations of motion, `M s̈ + ∂M/∂theta q̈ = −K s − D ṡ + ∂f/∂theta`,
//! with coefficients known along the trajectory. The masses are constant, so with `w = ṡ + M⁻¹ ∂M/∂theta q̇`
//! for a velocity no acceleration is needed, which the stiff edges would make rough. A stage of a diagonally
//! implicit method for a linear equation is one back-substitution, so all parameters share each stage's tangent and
//! its factors. Every step of the trajectory, whichever integrator made it, is one step here, of third order.
//!
//! What drives the derivatives, `∂f/∂theta`, is evaluated at every stage: a parameter of the geometry pulls along the stiff
//! edges, with a force that must turn with them, and friction turns round within a step.

use models::coupled::Coupled;
use models::effects::LANES;
use models::model::Model;
use models::system::System;

use super::{IntegrateError, Reached, State, Stiff};

/// L-stable, stiffly accurate, order 3. Source: Alexander (1977), SIAM J. Numer. Anal. 14, 1006-1021;
/// `gamma` is the root of `γ³ − 3γ² + 3γ/2 − 1/6` near 0.44.
const GAMMA: f64 = 0.435_866_521_508_459;
const STAGES: usize = 3;
const NODES: [f64; STAGES] = [GAMMA, 0.5 * (1.0 + GAMMA), 1.0];
const WEIGHTS: [&[f64]; STAGES] = [
    &[],
    &[0.5 * (1.0 - GAMMA)],
    &[-0.25 * (6.0 * GAMMA * GAMMA - 16.0 * GAMMA + 1.0), 0.25 * (6.0 * GAMMA * GAMMA - 20.0 * GAMMA + 5.0)],
];

type Row = [f64; LANES];

/// Derivatives of a state by [`LANES`] parameters.
#[derive(Clone, Debug, Default)]
pub struct Slopes {
    /// Of the coordinates, shape `[2N+1]`.
    pub q: Vec<Row>,
    /// Of the velocities.
    pub v: Vec<Row>,
    /// Of the memory that is felt: nothing depends on that of an effect that is off.
    pub z: Vec<Row>,
}

/// Sensitivities of one run by one list of parameters.
pub struct Variational {
    system: System,
    /// Derivatives at the end of the last step, one entry a group of [`LANES`] parameters.
    pub slopes: Vec<Slopes>,
    /// Those at its start, with `w` for the velocities, and the rod's own velocities there.
    start: Vec<Slopes>,
    start_velocity: Vec<f64>,
    /// `M⁻¹ ∂M/∂theta` of each group.
    by_mass: Vec<Vec<Row>>,
    /// Stage derivatives, `[group][stage]`.
    rates: Vec<[Slopes; STAGES]>,
    at: State,
    force: Vec<f64>,
    z_rate: Vec<f64>,
    matrix: Coupled,
    known: Slopes,
    residual: Slopes,
    damped: Vec<Row>,
}

/// Parameters that move the rod, each once, in the order in which they fill the groups: those of one law alone, which cost
/// less, are adjacent.
pub fn lane_order(model: &Model, parameters: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    for k in parameters.iter().filter(|k| !model.is_of_sensor(**k)) {
        if !order.contains(k) {
            order.push(*k);
        }
    }
    order.sort_by_key(|k| !model.is_of_law(*k));
    order
}

impl Slopes {
    fn zeros(model: &Model) -> Self {
        let zero = [0.0; LANES];
        Self { q: vec![zero; model.dof()], v: vec![zero; model.dof()], z: vec![zero; model.felt_memory()] }
    }

    fn parts(&self) -> [&Vec<Row>; 3] {
        [&self.q, &self.v, &self.z]
    }

    fn parts_mut(&mut self) -> [&mut Vec<Row>; 3] {
        [&mut self.q, &mut self.v, &mut self.z]
    }

    fn copy_from(&mut self, other: &Self) {
        for (own, other) in self.parts_mut().into_iter().zip(other.parts()) {
            own.copy_from_slice(other);
        }
    }

    fn add(&mut self, weight: f64, other: &Self) {
        for (own, other) in self.parts_mut().into_iter().zip(other.parts()) {
            for (own, other) in own.iter_mut().zip(other) {
                for p in 0..LANES {
                    own[p] += weight * other[p];
                }
            }
        }
    }
}

impl Variational {
    /// Starts with the derivatives of the initial state by what a `system` watches, one entry a group.
    pub fn new(system: System, slopes: Vec<Slopes>) -> Self {
        let model = &system.model;
        let zeros = Slopes::zeros(model);
        let state = State {
            time: 0.0,
            q: vec![0.0; model.dof()],
            v: vec![0.0; model.dof()],
            z: vec![0.0; model.memory()],
        };
        Self {
            start: slopes.clone(),
            rates: vec![std::array::from_fn(|_| zeros.clone()); slopes.len()],
            by_mass: (0..slopes.len()).map(|group| system.mass_by_parameters(group).collect()).collect(),
            start_velocity: state.v.clone(),
            force: state.v.clone(),
            z_rate: state.z.clone(),
            at: state,
            matrix: Coupled::zeros(model.dof()),
            known: zeros.clone(),
            damped: zeros.q.clone(),
            residual: zeros,
            slopes,
            system,
        }
    }

    /// The equations that it linearises.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Follows the last step of a integrator.
    /// # Errors
    /// [`IntegrateError::StepTooSmall`] if a stage's matrix is singular.
    pub fn follow(&mut self, integrator: &mut dyn Reached) -> Result<(), IntegrateError> {
        let (begin, end) = (integrator.step_start(), integrator.state().time);
        let h = end - begin;
        let a = 1.0 / (GAMMA * h);
        self.system.begin_step(begin);
        integrator.interpolate(begin, &mut self.at);
        self.start_velocity.copy_from_slice(&self.at.v);
        for ((start, slopes), by_mass) in self.start.iter_mut().zip(&self.slopes).zip(&self.by_mass) {
            start.copy_from(slopes);
            for ((w, by_mass), velocity) in start.v.iter_mut().zip(by_mass).zip(&self.start_velocity) {
                for p in 0..LANES {
                    w[p] += by_mass[p] * velocity;
                }
            }
        }
        for stage in 0..STAGES {
            let time = begin + NODES[stage] * h;
            integrator.interpolate(time, &mut self.at);
            let State { q, v, z, .. } = &self.at;
            self.system.linearise_into(time, q, v, z, &mut self.force, &mut self.z_rate);
            self.system.condense(a);
            self.matrix.combine(a, &self.system.mass, self.system.damping(), self.system.stiffness());
            if self.matrix.factorize().is_err() {
                return Err(IntegrateError::StepTooSmall { time, step: h, node: 0, stiff: Stiff::default() });
            }
            for group in 0..self.slopes.len() {
                self.solve_stage(group, stage, a, h);
            }
        }
        Ok(())
    }

    /// `(a − J) Z = a known + b`, then the stage's rate is `a (Z − known)`.
    fn solve_stage(&mut self, group: usize, stage: usize, a: f64, h: f64) {
        let Self { system, at, known, residual, damped, matrix, .. } = self;
        known.copy_from(&self.start[group]);
        for (weight, rate) in WEIGHTS[stage].iter().zip(&self.rates[group]) {
            known.add(weight * h, rate);
        }
        system.by_parameters(group, at.time, &at.q, &at.v, &at.z, &mut residual.v, &mut residual.z);
        for (k, (r_f, damped)) in residual.v.iter_mut().zip(&mut *damped).enumerate() {
            let (by_mass, known_q, known_w) = (&self.by_mass[group][k], &known.q[k], &known.v[k]);
            for p in 0..LANES {
                damped[p] = a * known_q[p];
                r_f[p] += a * system.mass[k] * (known_w[p] - by_mass[p] * at.v[k] + damped[p]);
            }
        }
        for (r_z, known) in residual.z.iter_mut().zip(&known.z) {
            for p in 0..LANES {
                r_z[p] += a * known[p];
            }
        }
        system.add_damping(damped, &mut residual.v);
        system.condense_residual(a, &residual.z, &mut residual.v);
        let slopes = &mut self.slopes[group];
        slopes.q.copy_from_slice(&residual.v);
        matrix.solve_many(&mut slopes.q);
        for ((v, q), known) in slopes.v.iter_mut().zip(&slopes.q).zip(&known.q) {
            for p in 0..LANES {
                v[p] = a * (q[p] - known[p]);
            }
        }
        slopes.z.copy_from_slice(&residual.z);
        system.recover_memory(a, &slopes.q, &slopes.v, &mut slopes.z);
        let rate = &mut self.rates[group][stage];
        for ((rate, found), known) in rate.parts_mut().into_iter().zip(slopes.parts()).zip(known.parts()) {
            for ((rate, found), known) in rate.iter_mut().zip(found).zip(known) {
                for p in 0..LANES {
                    rate[p] = a * (found[p] - known[p]);
                }
            }
        }
        for ((rate, by_mass), velocity) in rate.v.iter_mut().zip(&self.by_mass[group]).zip(&at.v) {
            for p in 0..LANES {
                rate[p] += a * by_mass[p] * velocity;
            }
        }
    }

    /// Derivatives of the coordinates from the `first` on at a time within the last step, by
    /// Hermite's cubic.
    pub fn interpolate(&self, group: usize, [begin, end]: [f64; 2], time: f64, first: usize, q: &mut [Row]) {
        let h = end - begin;
        let s = if h > 0.0 { (time - begin) / h } else { 1.0 };
        let (start, end, by_mass) = (&self.start[group], &self.slopes[group], &self.by_mass[group]);
        let weights = [
            (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s),
            h * s * (1.0 - s) * (1.0 - s),
            s * s * (3.0 - 2.0 * s),
            h * s * s * (s - 1.0),
        ];
        for (k, row) in q.iter_mut().enumerate().skip(first) {
            for p in 0..LANES {
                row[p] = weights[0] * start.q[k][p]
                    + weights[1] * (start.v[k][p] - by_mass[k][p] * self.start_velocity[k])
                    + weights[2] * end.q[k][p]
                    + weights[3] * end.v[k][p];
            }
        }
    }
}
