//! Linearly implicit (Rosenbrock-Wanner) methods: one tangent and one factorization a step, one
//! back-substitution a stage, no Newton iteration; see [`Stages`].

use models::coupled::Coupled;
use models::model::Model;
use models::system::{System, TimePass};

use super::span::Span;
use super::stages::{Equations, Stages};
use super::stride::{Attempt, Stepping, Stride, memory_error};
use super::tableau::Tableau;
use super::{Control, IntegrateError, Integrator, State};

/// A run of a Rosenbrock method.
pub struct Rosenbrock {
    one: One,
    stages: Stages<f64>,
    stride: Stride,
    span: Span,
    force_by_time: Vec<f64>,
    z_rate_by_time: Vec<f64>,
    time_pass: Option<TimePass>,
}

/// One rod and the matrix of its step.
struct One {
    system: System,
    matrix: Coupled,
}

impl Equations<f64> for One {
    fn mass(&self) -> &[f64] {
        &self.system.mass
    }

    fn add_damping(&self, v: &[f64], sum: &mut [f64]) {
        self.system.add_damping(columns(v), columns_mut(sum));
    }

    fn condense_residual(&mut self, a: f64, r_z: &[f64], r_f: &mut [f64]) {
        self.system.condense_residual(a, columns(r_z), columns_mut(r_f));
    }

    fn solve(&self, x: &mut [f64]) {
        self.matrix.solve(x);
    }

    fn recover_memory(&mut self, a: f64, u_q: &[f64], u_v: &[f64], r_z: &mut [f64]) {
        self.system.recover_memory(a, columns(u_q), columns(u_v), columns_mut(r_z));
    }
}

impl Rosenbrock {
    /// Starts at a state.
    pub fn new(tableau: &'static Tableau, model: &Model, state: State, control: Control) -> Self {
        let (nq, nz) = (model.dof(), model.memory());
        Self {
            one: One { system: System::new(model), matrix: Coupled::zeros(nq) },
            stages: Stages::new(tableau, nq, nz),
            stride: Stride::new(tableau, model.rod().length, control),
            span: Span::at(state, tableau.dense.len()),
            force_by_time: vec![0.0; nq],
            z_rate_by_time: vec![0.0; nz],
            time_pass: model.is_timed().then(|| TimePass::new(model)),
        }
    }

    /// Tangents at the state; again after each attempt at a step, for its stages have moved the rod on
    /// which they are condensed.
    fn linearise(&mut self) {
        let State { time, q, v, z } = &self.span.end;
        let Stages { start_force, start_z_rate, .. } = &mut self.stages;
        self.one.system.linearise_into(*time, q, v, z, start_force, start_z_rate);
        self.stride.effort.linearisations += 1;
    }

    /// Solves all stages of a step of size `h`; false if the matrix is singular.
    fn solve_stages(&mut self, h: f64) -> bool {
        let Self { one, stages, .. } = self;
        let State { time, q, v, z } = &self.span.end;
        let tableau = stages.tableau;
        let a = 1.0 / (tableau.gamma * h);
        one.system.condense(a);
        one.matrix.combine(a, &one.system.mass, one.system.damping(), one.system.stiffness());
        self.stride.effort.factorizations += 1;
        if one.matrix.factorize().is_err() {
            return false;
        }
        for i in 0..tableau.stages() {
            stages.begin(i, 1.0 / h, [q, v, z]);
            if i > 0 {
                let Stages { trial, force, z_rate, .. } = &mut *stages;
                let at = time + tableau.alpha[i] * h;
                one.system.force(at, &trial.q, &trial.v, &trial.z, force, z_rate);
                self.stride.effort.evaluations += 1;
            }
            let by_time = [&*self.force_by_time, &*self.z_rate_by_time];
            let by_time = self.time_pass.is_some().then_some((h * tableau.d[i], by_time));
            stages.solve(i, a, one, by_time);
        }
        stages.end();
        true
    }

    /// Error of the memory in the last attempt.
    fn memory_error(&self) -> f64 {
        let Stages { tableau, all, trial, .. } = &self.stages;
        memory_error(&all[tableau.stages() - 1][2 * trial.q.len()..], &self.span.end.z, &trial.z)
    }

    /// Accepts the trial state of a step to a time.
    fn accept(&mut self, time: f64) {
        let Span { start, end, dense } = &mut self.span;
        std::mem::swap(start, end);
        let trial = &mut self.stages.trial;
        for (end, trial) in
            [(&mut end.q, &mut trial.q), (&mut end.v, &mut trial.v), (&mut end.z, &mut trial.z)]
        {
            std::mem::swap(end, trial);
        }
        end.time = time;
        self.stages.densify();
        std::mem::swap(dense, &mut self.stages.dense);
    }
}

impl Integrator for Rosenbrock {
    fn advance(&mut self, stop: f64) -> Result<(), IntegrateError> {
        let time = self.span.end.time;
        let Some(stop) = self.stride.begin(time, stop)? else { return Ok(()) };
        self.one.system.begin_step(time);
        self.linearise();
        let State { q, v, z, .. } = &self.span.end;
        if let Some(pass) = &mut self.time_pass {
            let (force, z_rate) = (&mut self.force_by_time, &mut self.z_rate_by_time);
            self.one.system.by_time(pass, time, q, v, z, force, z_rate);
        }
        let to_stop = stop - time;
        loop {
            let h = self.stride.size(to_stop);
            let solved = self.solve_stages(h);
            let nq = self.span.end.q.len();
            let last = &self.stages.all[self.stages.tableau.stages() - 1];
            let (error, node) = if solved { self.stride.error(nq, |k| last[k]) } else { (f64::INFINITY, 0) };
            let memory_error = if self.stride.judges_memory() { self.memory_error() } else { 0.0 };
            if self.stride.judge(&Attempt { time, h, to_stop, error, node, memory_error })? {
                self.accept(if h == to_stop { stop } else { time + h });
                return Ok(());
            }
            self.linearise();
        }
    }
}

impl Stepping for Rosenbrock {
    fn span(&self) -> &Span {
        &self.span
    }

    fn stride(&self) -> &Stride {
        &self.stride
    }
}

fn columns(x: &[f64]) -> &[[f64; 1]] {
    x.as_chunks().0
}

fn columns_mut(x: &mut [f64]) -> &mut [[f64; 1]] {
    x.as_chunks_mut().0
}
