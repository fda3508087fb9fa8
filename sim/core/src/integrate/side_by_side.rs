//! Several rods in the steps of a Rosenbrock method at once, each with its own size of steps.
//!
//! One attempt solves the stages of a step of every rod. Each rod estimates its own error: where one tries again with a
//! shorter step, its neighbours are already in their next one. So no rod waits for another, and each makes the steps, with
//! the bits, that it makes alone.

use models::model::Model;
use models::pack::{Pack, RODS};
use models::rods::{Rods, put_rod, take_rod};
use multiversion::multiversion;

use super::span::Span;
use super::stages::{Coordinates, Equations, Stages};
use super::stride::{Attempt, Stepping, Stride, memory_error};
use super::tableau::Tableau;
use super::{Control, IntegrateError, State};

/// Runs of a Rosenbrock method side by side.
pub(crate) struct SideBySide {
    rods: Rods,
    stages: Stages<Pack>,
    state: Coordinates<Pack>,
    /// Sizes of the steps that are tried, s; of a rod that has left, its last.
    h: Pack,
    lanes: [Option<Lane>; RODS],
}

/// One rod among others.
pub(crate) struct Lane {
    span: Span,
    stride: Stride,
    /// Where the step that is tried has to end at the latest, s; none between two steps.
    stop: Option<f64>,
}

impl Equations<Pack> for Rods {
    #[inline(always)]
    fn mass(&self) -> &[Pack] {
        Rods::mass(self)
    }
    #[inline(always)]
    fn add_damping(&self, v: &[Pack], sum: &mut [Pack]) {
        Rods::add_damping(self, v, sum);
    }
    #[inline(always)]
    fn condense_residual(&mut self, a: Pack, r_z: &[Pack], r_f: &mut [Pack]) {
        Rods::condense_residual(self, a, r_z, r_f);
    }
    #[inline(always)]
    fn solve(&self, x: &mut [Pack]) {
        Rods::solve(self, x);
    }
    #[inline(always)]
    fn recover_memory(&mut self, a: Pack, u_q: &[Pack], u_v: &[Pack], r_z: &mut [Pack]) {
        Rods::recover_memory(self, a, u_q, u_v, r_z);
    }
}

impl SideBySide {
    /// Room for rods like a model; no rod is there yet.
    pub fn new(tableau: &'static Tableau, model: &Model) -> Self {
        let (nq, nz) = (model.dof(), model.memory());
        let [q, z] = [nq, nz].map(|length| vec![Pack::default(); length]);
        Self {
            rods: Rods::new(model),
            stages: Stages::new(tableau, nq, nz),
            state: Coordinates { q: q.clone(), v: q, z },
            h: Pack::from(1.0),
            lanes: [const { None }; RODS],
        }
    }

    /// Starts a rod at a state.
    pub fn put(&mut self, rod: usize, model: &Model, state: State, control: Control) {
        let tableau = self.stages.tableau;
        self.rods.put(rod, model);
        put_rod(rod, &state.q, &mut self.state.q);
        put_rod(rod, &state.v, &mut self.state.v);
        put_rod(rod, &state.z, &mut self.state.z);
        self.lanes[rod] = Some(Lane {
            span: Span::at(state, tableau.dense.len()),
            stride: Stride::new(tableau, model.rod().length, control),
            stop: None,
        });
    }

    /// Takes a rod out; what is computed in its place means nothing.
    pub fn leave(&mut self, rod: usize) {
        self.lanes[rod] = None;
    }

    /// A rod that is there.
    pub fn lane(&mut self, rod: usize) -> &mut Lane {
        self.lanes[rod].as_mut().expect("a rod that is there")
    }

    /// Tries one step of each rod, which ends at its stop, s, or before it. What became of each: nothing where the step is
    /// to be tried again, or no rod is there.
    pub fn attempt(&mut self, stops: &[f64; RODS]) -> [Option<Result<(), IntegrateError>>; RODS] {
        let mut outcomes = [const { None }; RODS];
        for (rod, lane) in self.lanes.iter_mut().enumerate() {
            let Some(lane) = lane else { continue };
            let time = lane.span.end.time;
            if lane.stop.is_none() {
                match lane.stride.begin(time, stops[rod]) {
                    Ok(Some(stop)) => lane.stop = Some(stop),
                    Ok(None) => outcomes[rod] = Some(Ok(())),
                    Err(error) => outcomes[rod] = Some(Err(error)),
                }
            }
            if let Some(stop) = lane.stop {
                self.h[rod] = lane.stride.size(stop - time);
            }
        }
        let is_regular = self.solve_stages();
        let nq = self.state.q.len();
        let mut is_dense = false;
        for (rod, lane) in self.lanes.iter_mut().enumerate() {
            let Some((lane, stop)) = lane.as_mut().and_then(|lane| lane.stop.map(|stop| (lane, stop))) else {
                continue;
            };
            lane.count(is_regular[rod], self.stages.tableau.stages() - 1);
            let (time, h) = (lane.span.end.time, self.h[rod]);
            let to_stop = stop - time;
            let last = &self.stages.all[self.stages.tableau.stages() - 1];
            let (error, node) =
                if is_regular[rod] { lane.stride.error(nq, |k| last[k][rod]) } else { (f64::INFINITY, 0) };
            let memory_error = if lane.stride.judges_memory() {
                let own = |z: &[Pack]| z.iter().map(|z| z[rod]).collect::<Vec<_>>();
                memory_error(&own(&last[2 * nq..]), &lane.span.end.z, &own(&self.stages.trial.z))
            } else {
                0.0
            };
            outcomes[rod] = match lane.stride.judge(&Attempt { time, h, to_stop, error, node, memory_error })
            {
                Ok(false) => continue,
                Ok(true) => {
                    if !is_dense {
                        densify(&mut self.stages);
                        is_dense = true;
                    }
                    lane.accept(rod, if h == to_stop { stop } else { time + h }, &self.stages);
                    put_rod(rod, &lane.span.end.q, &mut self.state.q);
                    put_rod(rod, &lane.span.end.v, &mut self.state.v);
                    put_rod(rod, &lane.span.end.z, &mut self.state.z);
                    Some(Ok(()))
                }
                Err(error) => Some(Err(error)),
            };
            lane.stop = None;
        }
        outcomes
    }

    /// Solves all stages of all rods; for each whether its matrix is regular.
    fn solve_stages(&mut self) -> [bool; RODS] {
        let Self { rods, stages, state: Coordinates { q, v, z }, h, .. } = self;
        let tableau = stages.tableau;
        rods.linearise(q, v, z, &mut stages.start_force, &mut stages.start_z_rate);
        let a = Pack(h.0.map(|h| 1.0 / (tableau.gamma * h)));
        let per_h = Pack(h.0.map(|h| 1.0 / h));
        let is_regular = rods.factorize(a);
        for i in 0..tableau.stages() {
            begin(stages, i, per_h, [q, v, z]);
            if i > 0 {
                let Stages { trial, force, z_rate, .. } = &mut *stages;
                rods.force(&trial.q, &trial.v, &trial.z, force, z_rate);
            }
            solve(stages, i, a, rods);
        }
        end(stages);
        is_regular
    }
}

impl Lane {
    fn count(&mut self, is_regular: bool, evaluations: usize) {
        let effort = &mut self.stride.effort;
        effort.linearisations += 1;
        effort.factorizations += 1;
        effort.evaluations += if is_regular { evaluations } else { 0 };
    }

    /// Accepts the trial state of a step to a time.
    fn accept(&mut self, rod: usize, time: f64, stages: &Stages<Pack>) {
        let Span { start, end, dense } = &mut self.span;
        std::mem::swap(start, end);
        end.time = time;
        take_rod(rod, &stages.trial.q, &mut end.q);
        take_rod(rod, &stages.trial.v, &mut end.v);
        take_rod(rod, &stages.trial.z, &mut end.z);
        for (own, all) in dense.iter_mut().zip(&stages.dense) {
            take_rod(rod, all, own);
        }
    }
}

impl Stepping for Lane {
    fn span(&self) -> &Span {
        &self.span
    }

    fn stride(&self) -> &Stride {
        &self.stride
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn begin(stages: &mut Stages<Pack>, i: usize, per_h: Pack, state: [&[Pack]; 3]) {
    stages.begin(i, per_h, state);
}

#[multiversion(targets("x86_64+avx2"))]
fn solve(stages: &mut Stages<Pack>, i: usize, a: Pack, rods: &mut Rods) {
    stages.solve(i, a, rods, None);
}

#[multiversion(targets("x86_64+avx2"))]
fn end(stages: &mut Stages<Pack>) {
    stages.end();
}

#[multiversion(targets("x86_64+avx2"))]
fn densify(stages: &mut Stages<Pack>) {
    stages.densify();
}
