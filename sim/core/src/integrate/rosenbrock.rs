//! Linearly implicit (Rosenbrock-Wanner) methods: one tangent and one factorization a step, one
//! back-substitution a stage, no Newton iteration.
//!
//! In transformed stages `u_i`, with `a = 1/(γh)` (Hairer and Wanner, Solving ODEs II, IV.7):
//! `(a − J) u_i = F(y + Σ a_ij u_j) + Σ (c_ij/h) u_j + h d_i ∂F/∂t`. Rates of coordinates are
//! velocities, so half of the unknowns drop out before factorization: see `models::tangent`.

use models::coupled::Coupled;
use models::model::Model;
use models::system::{System, TimePass};

use super::tableau::Tableau;
use super::{Control, Effort, IntegrateError, Integrator, State, Steps, Stiff};

/// A run of a Rosenbrock method.
pub struct Rosenbrock {
    system: System,
    tableau: &'static Tableau,
    control: Control,
    effort: Effort,
    state: State,
    step_start: f64,
    step: f64,
    last_error: f64,
    scale_q: f64,
    scale_v: f64,
    /// `u_i`, one after another, each `[q, v, z]`.
    stages: Vec<Vec<f64>>,
    start: State,
    trial: State,
    sum: Vec<f64>,
    force: Vec<f64>,
    z_rate: Vec<f64>,
    start_force: Vec<f64>,
    start_z_rate: Vec<f64>,
    force_by_time: Vec<f64>,
    z_rate_by_time: Vec<f64>,
    rhs: Vec<f64>,
    matrix: Coupled,
    time_pass: Option<TimePass>,
    dense: Vec<Vec<f64>>,
}

/// Error, over what is admitted, from on a given step is halved, and the same of
/// the memory as a share of its largest value.
const POOR: f64 = 10.0;
const POOR_MEMORY: f64 = 0.3;
/// For the memory such steps are not halved below this, s.
const SMALLEST_MEMORY_STEP: f64 = 1e-5;
/// The first step of a run, s, if its steps are adaptive.
const FIRST_STEP: f64 = 1e-4;
/// Steps below this, s, lead nowhere.
const SMALLEST_STEP: f64 = 1e-12;

impl Rosenbrock {
    /// Starts at a state.
    pub fn new(tableau: &'static Tableau, model: &Model, state: State, control: Control) -> Self {
        let system = System::new(model);
        let (nq, nz) = (model.dof(), model.memory());
        let length = model.rod().length;
        let width = 2 * nq + nz;
        Self {
            tableau,
            effort: Effort::default(),
            step_start: state.time,
            step: first_step(&control),
            last_error: 1.0,
            scale_q: control.tolerance * length,
            // Velocities count at a hundredth of the speed of a fall over the rod's length: those of
            // the fast modes, which no position shows, would else set the step. Of the weights 1,
            // 0.1 and 0.01 this one reaches 0.05 mm at the tip, and a budget of energy closed to
            // 1e-6, in the fewest steps.
            scale_v: control.tolerance * 100.0 * (length * 9.81).sqrt(),
            stages: vec![vec![0.0; width]; tableau.stages()],
            start: state.clone(),
            trial: state.clone(),
            sum: vec![0.0; width],
            force: vec![0.0; nq],
            z_rate: vec![0.0; nz],
            start_force: vec![0.0; nq],
            start_z_rate: vec![0.0; nz],
            force_by_time: vec![0.0; nq],
            z_rate_by_time: vec![0.0; nz],
            rhs: vec![0.0; nq],
            matrix: Coupled::zeros(nq),
            time_pass: model.is_timed().then(|| TimePass::new(model)),
            dense: vec![vec![0.0; width]; tableau.dense.len()],
            system,
            state,
            control,
        }
    }

    /// Tangents at the state; again after each attempt at a step, for its stages have moved the rod on
    /// which they are condensed.
    fn linearise(&mut self) {
        let State { time, q, v, z } = &self.state;
        self.system.linearise_into(*time, q, v, z, &mut self.start_force, &mut self.start_z_rate);
        self.effort.linearisations += 1;
    }

    /// Solves all stages of a step of size `h`; false if the matrix is singular.
    fn solve_stages(&mut self, h: f64) -> bool {
        let tableau = self.tableau;
        let a = 1.0 / (tableau.gamma * h);
        let per_h = 1.0 / h;
        let (nq, time) = (self.rhs.len(), self.state.time);
        let system = &mut self.system;
        system.condense(a);
        self.matrix.combine(a, &system.mass, system.damping(), system.stiffness());
        self.effort.factorizations += 1;
        if self.matrix.factorize().is_err() {
            return false;
        }
        for i in 0..tableau.stages() {
            self.sum.fill(0.0);
            self.trial.q.copy_from_slice(&self.state.q);
            self.trial.v.copy_from_slice(&self.state.v);
            self.trial.z.copy_from_slice(&self.state.z);
            let (done, rest) = self.stages.split_at_mut(i);
            for (j, u) in done.iter().enumerate() {
                let (weight, rate) = (tableau.a[i][j], tableau.c[i][j] * per_h);
                if weight != 0.0 {
                    add(&mut self.trial.q, weight, &u[..nq]);
                    add(&mut self.trial.v, weight, &u[nq..2 * nq]);
                    add(&mut self.trial.z, weight, &u[2 * nq..]);
                }
                add(&mut self.sum, rate, u);
            }
            if i == 0 {
                self.force.copy_from_slice(&self.start_force);
                self.z_rate.copy_from_slice(&self.start_z_rate);
            } else {
                let at = time + tableau.alpha[i] * h;
                let State { q, v, z, .. } = &self.trial;
                system.force(at, q, v, z, &mut self.force, &mut self.z_rate);
                self.effort.evaluations += 1;
            }
            let u = &mut rest[0];
            let (u_q, tail) = u.split_at_mut(nq);
            let (u_v, u_z) = tail.split_at_mut(nq);
            // u_v holds r_q, u_z holds r_z until the solve.
            for k in 0..nq {
                u_v[k] = self.trial.v[k] + self.sum[k];
                self.rhs[k] = self.force[k] + system.mass[k] * (self.sum[nq + k] + a * u_v[k]);
            }
            for (k, r_z) in u_z.iter_mut().enumerate() {
                *r_z = self.z_rate[k] + self.sum[2 * nq + k];
            }
            if self.time_pass.is_some() {
                add(&mut self.rhs, h * tableau.d[i], &self.force_by_time);
                add(u_z, h * tableau.d[i], &self.z_rate_by_time);
            }
            system.add_damping(columns(u_v), columns_mut(&mut self.rhs));
            system.condense_residual(a, columns(u_z), columns_mut(&mut self.rhs));
            u_q.copy_from_slice(&self.rhs);
            self.matrix.solve(u_q);
            for (u_v, u_q) in u_v.iter_mut().zip(&*u_q) {
                *u_v = a * u_q - *u_v;
            }
            system.recover_memory(a, columns(u_q), columns(u_v), columns_mut(u_z));
        }
        let last = &self.stages[tableau.stages() - 1];
        add(&mut self.trial.q, 1.0, &last[..nq]);
        add(&mut self.trial.v, 1.0, &last[nq..2 * nq]);
        add(&mut self.trial.z, 1.0, &last[2 * nq..]);
        true
    }

    /// Error of the last step against what is admitted, and the node where it is largest.
    fn error(&self) -> (f64, usize) {
        let nq = self.rhs.len();
        let last = &self.stages[self.tableau.stages() - 1];
        let length = self.scale_q / self.control.tolerance;
        let mut sum = 0.0;
        let mut worst = (0.0, 0);
        for k in 0..nq {
            // The angle of the end body counts as a length at the rod's radius.
            let radius = if k == nq - 1 { length } else { 1.0 };
            let e_q = last[k] * radius / self.scale_q;
            let e_v = last[nq + k] * radius / self.scale_v;
            let e = e_q * e_q + e_v * e_v;
            if e > worst.0 || e.is_nan() {
                worst = (e, (k / 2 + 1).min(nq / 2));
            }
            sum += e;
        }
        ((sum / nq as f64).sqrt(), worst.1)
    }

    /// Error of the memory in the last step, as a share of its largest value.
    fn memory_error(&self) -> f64 {
        let nq = self.rhs.len();
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        let scale = largest(&self.state.z).max(largest(&self.trial.z)).max(f64::MIN_POSITIVE);
        largest(&self.stages[self.tableau.stages() - 1][2 * nq..]) / scale
    }

    /// Accepts the trial state of a step of size `h`.
    fn accept(&mut self, h: f64) {
        std::mem::swap(&mut self.start, &mut self.state);
        std::mem::swap(&mut self.state, &mut self.trial);
        self.step_start = self.start.time;
        self.state.time = self.start.time + h;
        self.effort.steps += 1;
        for (dense, weights) in self.dense.iter_mut().zip(self.tableau.dense) {
            dense.fill(0.0);
            for (u, weight) in self.stages.iter().zip(*weights) {
                if *weight != 0.0 {
                    add(dense, *weight, u);
                }
            }
        }
    }
}

impl Integrator for Rosenbrock {
    fn advance(&mut self, stop: f64) -> Result<(), IntegrateError> {
        let time = self.state.time;
        let stop = self.control.steps.stop_after(time, stop);
        if stop <= time {
            return Ok(());
        }
        if self.effort.steps >= self.control.most_steps {
            return Err(IntegrateError::TooManySteps {
                time,
                steps: self.effort.steps,
                stiff: Stiff::default(),
            });
        }
        self.system.begin_step(time);
        self.linearise();
        let State { q, v, z, .. } = &self.state;
        if let Some(pass) = &mut self.time_pass {
            let (force, z_rate) = (&mut self.force_by_time, &mut self.z_rate_by_time);
            self.system.by_time(pass, time, q, v, z, force, z_rate);
        }
        let mut rejected = false;
        loop {
            let to_stop = stop - time;
            // The last two steps before a stop share what is left.
            let h = if self.step >= to_stop * (1.0 - 1e-10) {
                to_stop
            } else if self.step > 0.5 * to_stop && self.control.steps == Steps::Adaptive {
                0.5 * to_stop
            } else {
                self.step
            };
            let solved = self.solve_stages(h);
            let (error, node) = if solved { self.error() } else { (f64::INFINITY, 0) };
            let is_poor = match self.control.steps {
                Steps::Adaptive => error > 1.0 || error.is_nan(),
                // Where the other run had nothing to resolve and this one has.
                Steps::Given(_) => {
                    let keeps_memory = || h <= SMALLEST_MEMORY_STEP || self.memory_error() <= POOR_MEMORY;
                    h > SMALLEST_STEP && !(error <= POOR && keeps_memory())
                }
                Steps::Fixed(_) | Steps::Repeated(_) => false,
            };
            if is_poor {
                self.effort.rejected += 1;
                rejected = true;
                self.step = h * self.shrink(error);
                if self.step < SMALLEST_STEP && self.control.steps == Steps::Adaptive {
                    return Err(IntegrateError::StepTooSmall {
                        time,
                        step: self.step,
                        node,
                        stiff: Stiff::default(),
                    });
                }
                self.linearise();
                continue;
            }
            if !error.is_finite() {
                return Err(IntegrateError::NotFinite { time, node });
            }
            // The error of the step is as large as the rod: nothing after it would mean anything.
            if error * self.control.tolerance > 1.0 {
                return Err(IntegrateError::StepTooLong { time, step: h, node });
            }
            self.accept(h);
            if h == to_stop {
                self.state.time = stop;
            }
            match self.control.steps {
                Steps::Given(_) | Steps::Repeated(_) if h == to_stop => self.step = f64::INFINITY,
                // After a part of a given step, too: its rest may allow longer steps.
                Steps::Adaptive | Steps::Given(_) => self.step = self.grown(h, error, rejected),
                Steps::Repeated(_) | Steps::Fixed(_) => {}
            }
            return Ok(());
        }
    }

    fn state(&self) -> &State {
        &self.state
    }

    fn step_start(&self) -> f64 {
        self.step_start
    }

    fn interpolate(&mut self, time: f64, into: &mut State) {
        let h = self.state.time - self.step_start;
        let s = if h > 0.0 { (time - self.step_start) / h } else { 1.0 };
        into.time = time;
        let nq = self.rhs.len();
        let parts = [
            (&mut into.q, &self.start.q, &self.state.q, 0),
            (&mut into.v, &self.start.v, &self.state.v, nq),
            (&mut into.z, &self.start.z, &self.state.z, 2 * nq),
        ];
        for (into, start, end, offset) in parts {
            let own = offset..offset + into.len();
            for ((into, start), end) in into.iter_mut().zip(start).zip(end) {
                *into = (1.0 - s) * start + s * end;
            }
            let mut weight = (1.0 - s) * s;
            for dense in &self.dense {
                add(into, weight, &dense[own.clone()]);
                weight *= s;
            }
        }
    }

    fn next_step(&self) -> f64 {
        self.step
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

impl Rosenbrock {
    /// Share of a rejected step that is tried next.
    fn shrink(&self, error: f64) -> f64 {
        if self.control.steps != Steps::Adaptive {
            return 0.5;
        }
        let order = self.tableau.order as f64;
        let shrink = if error.is_finite() { 0.9 * error.powf(-1.0 / order) } else { 0.1 };
        shrink.clamp(0.1, 0.9)
    }

    /// Step size after an accepted step of size `h`: the usual law for the error, held back by
    /// Gustafsson's prediction where the error grows.
    fn grown(&mut self, h: f64, error: f64, rejected: bool) -> f64 {
        let order = self.tableau.order as f64;
        let error = error.max(1e-6);
        let growth = 0.9 * error.powf(-1.0 / order);
        let predicted = growth * (self.last_error / error).powf(1.0 / order);
        self.last_error = error;
        h * growth.min(predicted.max(0.2)).clamp(0.2, if rejected { 1.0 } else { 5.0 })
    }
}

/// The size of the first step, s; a given step ends where it is told to.
fn first_step(control: &Control) -> f64 {
    match control.steps {
        Steps::Adaptive => control.first_step.unwrap_or(FIRST_STEP),
        Steps::Fixed(step) => step,
        Steps::Given(_) | Steps::Repeated(_) => f64::INFINITY,
    }
}

fn add(sum: &mut [f64], weight: f64, term: &[f64]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += weight * term;
    }
}

fn columns(x: &[f64]) -> &[[f64; 1]] {
    x.as_chunks().0
}

fn columns_mut(x: &mut [f64]) -> &mut [[f64; 1]] {
    x.as_chunks_mut().0
}
