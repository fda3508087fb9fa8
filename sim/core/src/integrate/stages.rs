//! The stages of one step of a Rosenbrock method, for one rod or for several at once.
//!
//! In transformed stages `u_i`, with `a = 1/(γh)` (Hairer and Wanner, Solving ODEs II, IV.7):
//! `(a − J) u_i = F(y + Σ a_ij u_j) + Σ (c_ij/h) u_j + h d_i ∂F/∂t`. Rates of coordinates are
//! velocities, so half of the unknowns drop out before factorization: see `models::tangent`.

use std::array::from_fn;

use models::number::Plain;

use super::tableau::Tableau;

/// What a stage solves with: the mass, and the tangents condensed for a step.
pub(super) trait Equations<T> {
    /// Diagonal of the mass matrix.
    fn mass(&self) -> &[T];
    /// `sum += D v`.
    fn add_damping(&self, v: &[T], sum: &mut [T]);
    /// Adds to the residuals of force what those of memory do there.
    fn condense_residual(&mut self, a: T, r_z: &[T], r_f: &mut [T]);
    /// Solves with the factored matrix, in place.
    fn solve(&self, x: &mut [T]);
    /// Memory increments that belong to increments of coordinates and velocities, in the place of their residuals.
    fn recover_memory(&mut self, a: T, u_q: &[T], u_v: &[T], r_z: &mut [T]);
}

/// Coordinates, velocities and memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Coordinates<T> {
    pub q: Vec<T>,
    pub v: Vec<T>,
    pub z: Vec<T>,
}

/// Stages of a step, with the room that they need.
pub(super) struct Stages<T> {
    pub tableau: &'static Tableau,
    /// `u_i`, one after another, each `[q, v, z]`.
    pub all: Vec<Vec<T>>,
    /// State of a stage, and after the last one the end of the step.
    pub trial: Coordinates<T>,
    sum: Vec<T>,
    pub force: Vec<T>,
    pub z_rate: Vec<T>,
    pub start_force: Vec<T>,
    pub start_z_rate: Vec<T>,
    rhs: Vec<T>,
    /// Coefficients of the dense output, one power after another.
    pub dense: Vec<Vec<T>>,
}

impl<T: Plain> Stages<T> {
    /// Room for so many coordinates and memories.
    pub fn new(tableau: &'static Tableau, nq: usize, nz: usize) -> Self {
        let width = 2 * nq + nz;
        let [q, z, all] = [nq, nz, width].map(|length| vec![T::default(); length]);
        Self {
            tableau,
            all: vec![all.clone(); tableau.stages()],
            trial: Coordinates { q: q.clone(), v: q.clone(), z: z.clone() },
            sum: all.clone(),
            force: q.clone(),
            z_rate: z.clone(),
            start_force: q.clone(),
            start_z_rate: z,
            rhs: q,
            dense: vec![all; tableau.dense.len()],
        }
    }

    /// Sums of the stages before the `i`-th: its state, and what it adds to the residuals.
    /// # Panics
    /// For a seventh stage.
    #[inline(always)]
    pub fn begin(&mut self, i: usize, per_h: T, state: [&[T]; 3]) {
        match i {
            0 => self.sum_stages::<0>(per_h, state),
            1 => self.sum_stages::<1>(per_h, state),
            2 => self.sum_stages::<2>(per_h, state),
            3 => self.sum_stages::<3>(per_h, state),
            4 => self.sum_stages::<4>(per_h, state),
            5 => self.sum_stages::<5>(per_h, state),
            _ => panic!("a method of six stages at most"),
        }
        if i == 0 {
            self.force.copy_from_slice(&self.start_force);
            self.z_rate.copy_from_slice(&self.start_z_rate);
        }
    }

    #[inline(always)]
    fn sum_stages<const I: usize>(&mut self, per_h: T, state: [&[T]; 3]) {
        let weights: [f64; I] = from_fn(|j| self.tableau.a[I][j]);
        let rates: [T; I] = from_fn(|j| per_h * self.tableau.c[I][j]);
        let Coordinates { q, v, z } = &mut self.trial;
        let mut first = 0;
        for (state, trial) in state.into_iter().zip([q, v, z]) {
            let own = first..first + state.len();
            let done: [&[T]; I] = from_fn(|j| &self.all[j][own.clone()]);
            let sum = &mut self.sum[own];
            for k in 0..state.len() {
                let (mut at, mut rate) = (state[k], T::default());
                for j in 0..I {
                    at += T::from(weights[j]) * done[j][k];
                    rate += rates[j] * done[j][k];
                }
                (trial[k], sum[k]) = (at, rate);
            }
            first += state.len();
        }
    }

    /// Solves the `i`-th stage, whose forces are known; `by_time` has what a change with time adds to them and to the
    /// rates of memory.
    #[inline(always)]
    pub fn solve(
        &mut self,
        i: usize,
        a: T,
        equations: &mut impl Equations<T>,
        by_time: Option<(f64, [&[T]; 2])>,
    ) {
        let nq = self.rhs.len();
        let (u_q, tail) = self.all[i].split_at_mut(nq);
        let (u_v, u_z) = tail.split_at_mut(nq);
        let mass = equations.mass();
        // u_v holds r_q, u_z holds r_z until the solve.
        for k in 0..nq {
            u_v[k] = self.trial.v[k] + self.sum[k];
            self.rhs[k] = self.force[k] + mass[k] * (self.sum[nq + k] + a * u_v[k]);
        }
        for (k, r_z) in u_z.iter_mut().enumerate() {
            *r_z = self.z_rate[k] + self.sum[2 * nq + k];
        }
        if let Some((weight, [force, z_rate])) = by_time {
            add(&mut self.rhs, T::from(weight), force);
            add(u_z, T::from(weight), z_rate);
        }
        equations.add_damping(u_v, &mut self.rhs);
        equations.condense_residual(a, u_z, &mut self.rhs);
        u_q.copy_from_slice(&self.rhs);
        equations.solve(u_q);
        for (u_v, u_q) in u_v.iter_mut().zip(&*u_q) {
            *u_v = a * *u_q - *u_v;
        }
        equations.recover_memory(a, u_q, u_v, u_z);
    }

    /// From the state of the last stage to the end of the step.
    #[inline(always)]
    pub fn end(&mut self) {
        let nq = self.rhs.len();
        let last = &self.all[self.tableau.stages() - 1];
        add(&mut self.trial.q, T::from(1.0), &last[..nq]);
        add(&mut self.trial.v, T::from(1.0), &last[nq..2 * nq]);
        add(&mut self.trial.z, T::from(1.0), &last[2 * nq..]);
    }

    /// Makes the dense output of the step.
    #[inline(always)]
    pub fn densify(&mut self) {
        for (dense, weights) in self.dense.iter_mut().zip(self.tableau.dense) {
            dense.fill(T::default());
            for (u, weight) in self.all.iter().zip(*weights) {
                if *weight != 0.0 {
                    add(dense, T::from(*weight), u);
                }
            }
        }
    }
}

#[inline(always)]
fn add<T: Plain>(sum: &mut [T], weight: T, term: &[T]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += weight * *term;
    }
}
