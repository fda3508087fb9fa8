//! Linearised equations of motion: tangent stiffness and damping, with the memory condensed out.
//!
//! An implicit step solves `(a²M + a D + K) u_q = r_f + (a M + D) r_q` with `a = 1/(γh)`. A memory
//! is a scalar of one bend, and no memory drives another: a law sees one at a time. So `(a − ∂g/∂z) u_z = r_z + ∂g/∂q u_q + ∂g/∂v u_v`
//! is solved for each memory alone, before assembly: the tangents by curvature and rate gain
//! `m_z g_κ/(a − g_z)` and `m_z g_κ̇/(a − g_z)`, and the band stays as narrow as without memory.

use std::array::from_fn;

use crate::assembly::Assembly;
use crate::banded::Banded;
use crate::context::Context;
use crate::coupled::Coupled;
use crate::effects::BendTangent;
use crate::number::Plain;
use crate::plane::{dot, left};
use crate::system::System;
use crate::tangent::Tangent;

impl System {
    /// Evaluates forces and tangents of the laws at a state; returns the rates of the memory.
    /// [`condense`](Self::condense) then makes the matrices.
    pub fn linearise(&mut self, time: f64, q: &[f64], v: &[f64], z: &[f64], force: &mut [f64]) -> Vec<f64> {
        let mut z_rate = vec![0.0; z.len()];
        self.linearise_into(time, q, v, z, force, &mut z_rate);
        z_rate
    }

    /// [`linearise`](Self::linearise) without allocation.
    pub fn linearise_into(
        &mut self,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
        force: &mut [f64],
        z_rate: &mut [f64],
    ) {
        self.assembly.place(&self.model, time, q, v);
        self.linearise_laws(q[2 * self.model.edges], z, z_rate);
        self.tangent.keep(&mut self.assembly, v, force);
    }

    /// Adds what the laws say where the rod was put, with the end body at an angle, rad; and their tangents.
    pub(crate) fn linearise_laws(&mut self, angle: f64, z: &[f64], z_rate: &mut [f64]) {
        self.linearise_bends(z, z_rate);
        let (model, t) = (&self.model, &mut self.tangent);
        for list in [&mut t.by_stretch, &mut t.by_stretch_rate] {
            list.fill(0.0);
        }
        t.flow.fill([[0.0; 2]; 2]);
        t.tip = [[0.0; 6]; 3];
        let Assembly { context: c, fields: f, acting, .. } = &mut self.assembly;
        if !acting.whole.is_empty() {
            t.by_mean.fill(0.0);
        }
        for &k in &acting.whole {
            let active = &model.effects[k];
            let theta = &model.theta[active.theta.clone()];
            active.effect.linearise_by_mean(c, theta, f, &z[active.memory.clone()], &mut t.by_mean);
        }
        for &k in &acting.edge {
            let active = &model.effects[k];
            let theta = &model.theta[active.theta.clone()];
            active.effect.linearise_tensions(c, theta, f, &mut t.by_stretch, &mut t.by_stretch_rate);
        }
        for &k in &acting.flow {
            let active = &model.effects[k];
            active.effect.linearise_flows(c, &model.theta[active.theta.clone()], f, &mut t.flow);
        }
        self.assembly.add_loads(model, angle);
        let (borne, arm) = self.assembly.borne_at_the_end();
        for &k in &self.assembly.acting.tip {
            let active = &model.effects[k];
            let share = self.assembly.share(active.effect);
            let slopes =
                active.effect.linearise_tip(&self.assembly.tip(angle), &model.theta[active.theta.clone()]);
            for (row, add) in t.tip.iter_mut().zip(slopes) {
                for (entry, slope) in row.iter_mut().zip(add) {
                    *entry += share * slope;
                }
            }
        }
        // The weight of what has none acts before the last node, and turns with the body.
        t.tip[2][2] -= dot(arm, borne);
    }

    /// Twice the energy, J, that a small displacement from the state of the last [`linearise`](Self::linearise) puts into
    /// the stretch of the edges.
    pub(crate) fn stretch_energy(&mut self, time: f64, q: &[f64], displacement: &[f64]) -> f64 {
        self.assembly.place(&self.model, time, q, displacement);
        let (length, by_stretch) = (self.assembly.context.rest_length, &self.tangent.by_stretch);
        let stretches = self.assembly.fields.stretch_rate.iter();
        stretches.zip(by_stretch).map(|(stretch, stiffness)| length * stiffness * stretch * stretch).sum()
    }

    /// Moments, their tangents and the rates of memories at the present curvatures of the bends.
    pub(crate) fn linearise_bends(&mut self, z: &[f64], z_rate: &mut [f64]) {
        let (model, t) = (&self.model, &mut self.tangent);
        let Assembly { context: c, fields: f, acting, .. } = &mut self.assembly;
        t.by_kappa.fill(0.0);
        t.by_kappa_rate.fill(0.0);
        for &k in &acting.bend {
            let active = &model.effects[k];
            let own = active.memory.clone();
            active.effect.linearise_moments(
                c,
                &model.theta[active.theta.clone()],
                f,
                &z[own.clone()],
                &mut t.by_kappa,
                &mut t.by_kappa_rate,
                &mut t.memory[own.clone()],
                &mut z_rate[own],
            );
        }
    }

    /// Makes tangent stiffness `−∂f/∂q` and damping `−∂f/∂v` for a step with `a = 1/(γh)`, 1/s, at
    /// the state of the last [`linearise`](Self::linearise). At `a = 0` the memory is relaxed: statics.
    pub fn condense(&mut self, a: f64) {
        self.tangent.condense(&self.assembly, &self.mass, a);
    }

    /// Makes tangent stiffness and damping as a small harmonic motion of angular frequency `omega`,
    /// rad/s, about the state of the last [`linearise`](Self::linearise) sees them: memory answers
    /// with `1/(iω − g_z)`; what is in phase with the motion is stiffness, what is in phase with its
    /// rate is damping.
    ///
    /// `m_z (g_κ + iω g_κ̇)/(iω − g_z) = m_z [ω² g_κ̇ − g_z g_κ − iω (g_κ + g_z g_κ̇)]/(ω² + g_z²)`
    /// # Panics
    /// If `omega` is not positive.
    pub fn condense_at_frequency(&mut self, omega: f64) {
        assert!(omega > 0.0, "a harmonic motion needs a frequency: {omega}");
        let square = omega * omega;
        self.tangent.condense_with(&self.assembly, &self.mass, |memory| {
            let [g_kappa, g_rate, g_z] = memory.memory_rate;
            let response = memory.moment[2] / (square + g_z * g_z);
            [response * (square * g_rate - g_z * g_kappa), -response * (g_kappa + g_z * g_rate)]
        });
    }

    /// Tangent stiffness `−∂f/∂q`.
    pub fn stiffness(&self) -> &Coupled {
        &self.tangent.stiffness
    }

    /// Tangent damping `−∂f/∂v`.
    pub fn damping(&self) -> &Banded {
        &self.tangent.damping
    }

    /// Adds tangent damping times velocities, for `P` columns: `sum += D v`.
    pub fn add_damping<const P: usize>(&self, v: &[[f64; P]], sum: &mut [[f64; P]]) {
        self.tangent.add_damping(&self.mass, v, sum);
    }

    /// Adds to the residuals of force what the residuals of memory do there, for `P` columns. Those of memory that no moment
    /// depends on may be left out.
    pub fn condense_residual<const P: usize>(&mut self, a: f64, r_z: &[[f64; P]], r_f: &mut [[f64; P]]) {
        self.tangent.condense_residual(&self.assembly.context, a, r_z, r_f);
    }

    /// Memory increments that belong to increments of coordinates and velocities, for `P` columns:
    /// overwrites the residuals of memory, of as much of it as there are.
    pub fn recover_memory<const P: usize>(
        &mut self,
        a: f64,
        u_q: &[[f64; P]],
        u_v: &[[f64; P]],
        r_z: &mut [[f64; P]],
    ) {
        self.tangent.recover_memory(&self.assembly.context, a, u_q, u_v, r_z);
    }
}

impl<T: Plain> Tangent<T> {
    /// Turns what the laws say into generalised forces, and keeps what the matrices need of the posture.
    #[inline(always)]
    pub(crate) fn keep(&mut self, assembly: &mut Assembly<T>, v: &[T], force: &mut [T]) {
        let Assembly { context: c, fields: f, acting, .. } = assembly;
        f.resist(c, !acting.clamp.is_empty());
        f.gather(c, v, force);
        self.keep_geometry(c, f, !acting.flow.is_empty());
    }

    /// Condenses for a step with `a = 1/(γh)`, 1/s.
    #[inline(always)]
    pub(crate) fn condense(&mut self, assembly: &Assembly<T>, mass: &[T], a: T) {
        self.condense_with(assembly, mass, |memory| {
            let [g_kappa, g_rate, g_z] = memory.memory_rate;
            let response = memory.moment[2] * response(a, g_z);
            [response * g_kappa, response * g_rate]
        });
    }

    /// Condenses with what a memory adds to the tangents by curvature and by its rate.
    #[inline(always)]
    pub(crate) fn condense_with(
        &mut self,
        assembly: &Assembly<T>,
        mass: &[T],
        add: impl Fn(&BendTangent<T>) -> [T; 2],
    ) {
        let Assembly { context: c, fields: f, acting, .. } = assembly;
        let n = c.edges;
        let t = self;
        t.by_turns.clear();
        t.by_turn_rates.clear();
        for i in 0..=n {
            let mut by_kappa = t.by_kappa[i];
            let mut by_rate = t.by_kappa_rate[i];
            for memory in t.memory[..t.felt].iter().skip(i).step_by(n + 1) {
                let [stiffness, damping] = add(memory);
                by_kappa += stiffness;
                by_rate += damping;
            }
            let first = c.stencil.first(i);
            let row = c.stencil.row(i);
            let zero = T::default();
            let mut slopes = [zero; 3];
            let mut moments = [zero; 3];
            for k in 0..3 {
                slopes[k] = row[k] * t.angle_slope[first + k];
                moments[k] = by_kappa * slopes[k] + by_rate * (row[k] * t.angle_curve_rate[first + k]);
            }
            let (mut by_angles, mut by_angle_rates) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for k in 0..3 {
                for l in 0..3 {
                    by_angles[k][l] = slopes[k] * moments[l];
                    by_angle_rates[k][l] = by_rate * slopes[k] * slopes[l];
                }
            }
            t.by_turns.add_angles(first, &by_angles);
            if by_rate.any(|by_rate| by_rate != 0.0) {
                t.by_turn_rates.add_angles(first, &by_angle_rates);
            }
        }
        for i in 0..=n {
            t.by_turns.angles[i][2] += t.angle_curve[i] * f.angle_moment[i];
        }
        if !acting.clamp.is_empty() {
            let clamp = c.stencil.clamp_stiffness();
            let slopes = &t.angle_slope;
            let by_angles = from_fn(|k| from_fn(|l| clamp[k][l] * slopes[k] * slopes[l]));
            t.by_turns.add_angles(0, &by_angles);
        }
        for j in 0..n {
            t.add_edge(j, c, f);
        }
        t.assemble_edges(n);
        if !acting.flow.is_empty() {
            t.assemble_flows(n);
        }
        t.assemble_tip(n);
        t.turn_to_body(n);
        if acting.whole.is_empty() {
            t.stiffness.put_nothing_beside();
        } else {
            t.couple(c, &f.kappa);
        }
        t.couples_rates = t.couples_rates || !(acting.flow.is_empty() && acting.tip.is_empty());
        t.damping.add_diagonal(t.decay_rate, mass);
    }

    /// Adds tangent damping times velocities, for `P` columns: `sum += D v`.
    #[inline(always)]
    pub(crate) fn add_damping<const P: usize>(&self, mass: &[T], v: &[[T; P]], sum: &mut [[T; P]]) {
        if self.couples_rates {
            self.damping.multiply_add(v, sum);
        } else if self.decay_rate.any(|rate| rate != 0.0) {
            for ((sum, v), mass) in sum.iter_mut().zip(v).zip(mass) {
                for (sum, v) in sum.iter_mut().zip(v) {
                    *sum += self.decay_rate * *mass * *v;
                }
            }
        }
    }

    /// Adds to the residuals of force what the residuals of memory do there, for `P` columns. Those of memory that no moment
    /// depends on may be left out.
    #[inline(always)]
    pub(crate) fn condense_residual<const P: usize>(
        &mut self,
        c: &Context<T>,
        a: T,
        r_z: &[[T; P]],
        r_f: &mut [[T; P]],
    ) {
        let t = self;
        if t.felt == 0 {
            return;
        }
        for p in 0..P {
            for (i, moment) in t.of_bends.iter_mut().enumerate() {
                let bend = t.memory[..t.felt].iter().zip(r_z).skip(i).step_by(c.edges + 1);
                let own =
                    bend.map(|(memory, r)| memory.moment[2] * r[p] * response(a, memory.memory_rate[2]));
                *moment = own.fold(T::from(-0.0), |sum, own| sum + own);
            }
            t.turn_moments(&c.stencil);
            t.spread(|dof, resistance| r_f[dof][p] -= resistance);
        }
    }

    /// Memory increments that belong to increments of coordinates and velocities, for `P` columns:
    /// overwrites the residuals of memory, of as much of it as there are.
    #[inline(always)]
    pub(crate) fn recover_memory<const P: usize>(
        &mut self,
        c: &Context<T>,
        a: T,
        u_q: &[[T; P]],
        u_v: &[[T; P]],
        r_z: &mut [[T; P]],
    ) {
        if r_z.is_empty() {
            return;
        }
        let t = self;
        let zero = T::default();
        let n = c.edges;
        let (arm, swing) = (t.body_arm, left(t.body_arm));
        for p in 0..P {
            let node = |i: usize| -> ([T; 2], [T; 2]) {
                if i == 0 {
                    return ([zero; 2], [zero; 2]);
                }
                let mut at = [0, 1].map(|k| u_q[2 * i - 2 + k][p]);
                let mut rate = [0, 1].map(|k| u_v[2 * i - 2 + k][p]);
                if i == n {
                    for k in 0..2 {
                        at[k] -= swing[k] * u_q[2 * n][p];
                        rate[k] -= swing[k] * u_v[2 * n][p] - arm[k] * t.body_rate * u_q[2 * n][p];
                    }
                }
                (at, rate)
            };
            let mut start = node(0);
            let mut turn_before = [zero; 2];
            // Increments of the angles and of their rates.
            for i in 0..=n {
                let turn = if i < n {
                    let end = node(i + 1);
                    let edge = [0, 1].map(|k| end.0[k] - start.0[k]);
                    let rate = [0, 1].map(|k| end.1[k] - start.1[k]);
                    start = end;
                    let g = t.angle_by_edge[i];
                    [dot(g, edge), dot(g, rate) + dot(t.rate_by_edge[i], edge)]
                } else {
                    [u_q[2 * n][p], u_v[2 * n][p]]
                };
                let [angle, rate] = [turn[0] - turn_before[0], turn[1] - turn_before[1]];
                turn_before = turn;
                t.of_angles[i] = t.angle_slope[i] * angle;
                t.of_bends[i] = t.angle_curve_rate[i] * angle + t.angle_slope[i] * rate;
            }
            for i in 0..=n {
                let (row, first) = (c.stencil.row(i), c.stencil.first(i));
                let along = |angles: &[T]| {
                    row.iter().zip(&angles[first..]).fold(T::from(-0.0), |sum, (a, b)| sum + *a * *b)
                };
                let (kappa, kappa_rate) = (along(&t.of_angles), along(&t.of_bends));
                for k in (i..r_z.len()).step_by(n + 1) {
                    let [g_kappa, g_rate, g_z] = t.memory[k].memory_rate;
                    r_z[k][p] = (r_z[k][p] + g_kappa * kappa + g_rate * kappa_rate) * response(a, g_z);
                }
            }
        }
    }
}

/// `1/(a − g_z)`; zero where the memory does not move at all.
#[inline(always)]
fn response<T: Plain>(a: T, g_z: T) -> T {
    (a - g_z).map(|pole| if pole.abs() < 1e-12 { 0.0 } else { 1.0 / pole })
}
