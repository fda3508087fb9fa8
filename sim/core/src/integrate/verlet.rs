//! Velocity Verlet: explicit, symplectic, second order, for models that lose no energy.
//!
//! Without any loss the release from the horizontal passes its energy down into ever faster modes.
//! A method that damps those modes loses it, the linearly implicit ones 3 % in 20 s at the tolerance of
//! fits, unless their steps resolve every mode, and then an explicit step is ten times cheaper. The
//! energy of this method swings about a constant. Source: Hairer, Lubich and Wanner (2006),
//! Geometric Numerical Integration, I.1.4 and IX.

use models::model::Model;
use models::system::System;

use super::{Control, Effort, IntegrateError, Integrator, Reached, State, Steps, Stiff};

/// A run of velocity Verlet.
pub struct Verlet {
    system: System,
    control: Control,
    effort: Effort,
    state: State,
    start: State,
    acceleration: Vec<f64>,
    start_acceleration: Vec<f64>,
    step: f64,
    least_step: f64,
}

/// What a mode may turn by in a step, rad, when the step is chosen.
const PHASE: f64 = 0.5;
/// The same when it is made, before the step is halved for good: a rod that stretches or folds grows stiffer.
const MOST_PHASE: f64 = 1.0;
/// Where an explicit step is stable no more.
const UNSTABLE: f64 = 2.0;
/// Step below which none is tried, as a share of the first.
const LEAST_SHARE: f64 = 1e-6;

impl Verlet {
    /// Starts at a state, with a step that resolves the fastest mode of it, or with the fixed one.
    pub fn new(model: &Model, state: State, control: Control) -> Self {
        let mut system = System::new(model);
        let step = match control.steps {
            Steps::Adaptive => PHASE / fastest(&mut system, &state),
            Steps::Fixed(step) => step,
            Steps::Given(_) | Steps::Repeated(_) => f64::INFINITY,
        };
        let mut run = Self {
            effort: Effort::default(),
            start: state.clone(),
            acceleration: vec![0.0; model.dof()],
            start_acceleration: vec![0.0; model.dof()],
            step,
            least_step: LEAST_SHARE * step,
            system,
            state,
            control,
        };
        run.accelerate();
        run
    }

    fn accelerate(&mut self) {
        let State { time, q, v, z } = &self.state;
        self.system.force(*time, q, v, z, &mut self.acceleration, &mut []);
        for (a, m) in self.acceleration.iter_mut().zip(&self.system.mass) {
            *a /= m;
        }
        self.effort.evaluations += 1;
    }

    /// What moved in the last step turned by in it, rad: Rayleigh's quotient of the change of force over the change of
    /// place. Where a mode grows without bound it is that of the mode.
    fn phase(&self, h: f64) -> f64 {
        let (mut change, mut moved) = (0.0, 0.0);
        for (k, mass) in self.system.mass.iter().enumerate() {
            change += mass * (self.acceleration[k] - self.start_acceleration[k]).powi(2);
            moved += mass * (self.state.q[k] - self.start.q[k]).powi(2);
        }
        if moved > 0.0 { h * (change / moved).powf(0.25) } else { 0.0 }
    }

    /// From the start of the last step over a time, s.
    fn drift(&mut self, h: f64) {
        self.kick(0.5 * h);
        for (q, v) in self.state.q.iter_mut().zip(&self.state.v) {
            *q += h * v;
        }
        self.state.time = self.start.time + h;
        self.accelerate();
        self.kick(0.5 * h);
    }

    /// Where the force changed most in the last step.
    fn fastest_node(&self) -> usize {
        let change = |k: &usize| {
            let change = (self.acceleration[*k] - self.start_acceleration[*k]).abs();
            if change.is_finite() { change } else { f64::INFINITY }
        };
        let fastest = (0..self.acceleration.len()).max_by(|a, b| change(a).total_cmp(&change(b)));
        fastest.map_or(0, |k| (k / 2 + 1).min(self.acceleration.len() / 2))
    }

    fn begin_again(&mut self) {
        self.state.q.copy_from_slice(&self.start.q);
        self.state.v.copy_from_slice(&self.start.v);
        self.acceleration.copy_from_slice(&self.start_acceleration);
    }

    fn kick(&mut self, h: f64) {
        for (v, a) in self.state.v.iter_mut().zip(&self.acceleration) {
            *v += h * a;
        }
    }
}

/// Highest angular frequency about a state, rad/s, by power iteration, rounded up.
fn fastest(system: &mut System, state: &State) -> f64 {
    let n = state.q.len();
    let mut force = vec![0.0; n];
    system.linearise(state.time, &state.q, &state.v, &state.z, &mut force);
    system.condense(0.0);
    let mut x: Vec<[f64; 1]> = (0..n).map(|k| [((k * k) as f64).sin()]).collect();
    let mut square = 0.0;
    for _ in 0..100 {
        let mut y = vec![[0.0]; n];
        system.stiffness().multiply_add(&x, &mut y);
        for (y, m) in y.iter_mut().zip(&system.mass) {
            y[0] /= m;
        }
        square = y.iter().map(|y| y[0] * y[0]).sum::<f64>().sqrt();
        x = y.iter().map(|y| [y[0] / square]).collect();
    }
    1.1 * square.sqrt()
}

impl Integrator for Verlet {
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
        self.start.time = time;
        self.start.q.copy_from_slice(&self.state.q);
        self.start.v.copy_from_slice(&self.state.v);
        self.start_acceleration.copy_from_slice(&self.acceleration);
        loop {
            let is_last = time + self.step >= stop - 1e-9 * self.step;
            let h = if is_last { stop - time } else { self.step };
            self.drift(h);
            let is_finite = self.state.v.iter().all(|v| v.is_finite());
            let phase = self.phase(h);
            let is_fixed = self.control.steps != Steps::Adaptive;
            if is_finite && phase <= if is_fixed { UNSTABLE } else { MOST_PHASE } {
                if is_last {
                    self.state.time = stop;
                }
                self.effort.steps += 1;
                return Ok(());
            }
            let node = self.fastest_node();
            self.effort.rejected += 1;
            if is_fixed {
                return Err(IntegrateError::StepTooLong { time, step: h, node });
            }
            self.step = 0.5 * h;
            if self.step < self.least_step {
                return Err(IntegrateError::StepTooSmall {
                    time,
                    step: self.step,
                    node,
                    stiff: Stiff::default(),
                });
            }
            self.begin_again();
        }
    }
}

impl Reached for Verlet {
    fn state(&self) -> &State {
        &self.state
    }

    fn step_start(&self) -> f64 {
        self.start.time
    }

    fn interpolate(&mut self, time: f64, into: &mut State) {
        let h = self.state.time - self.start.time;
        let s = if h > 0.0 { (time - self.start.time) / h } else { 1.0 };
        into.time = time;
        hermite(s, h, [&self.start.q, &self.start.v, &self.state.q, &self.state.v], &mut into.q);
        let rates = [&self.start.v, &self.start_acceleration, &self.state.v, &self.acceleration];
        hermite(s, h, rates, &mut into.v);
    }

    fn next_step(&self) -> f64 {
        self.step
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Hermite's cubic through values and rates at both ends.
fn hermite(s: f64, h: f64, [x0, v0, x1, v1]: [&Vec<f64>; 4], into: &mut [f64]) {
    let t = 1.0 - s;
    let weights = [(1.0 + 2.0 * s) * t * t, h * s * t * t, s * s * (1.0 + 2.0 * t), -h * s * s * t];
    for (k, into) in into.iter_mut().enumerate() {
        *into = weights[0] * x0[k] + weights[1] * v0[k] + weights[2] * x1[k] + weights[3] * v1[k];
    }
}
