//! Linearised equations of motion: tangent stiffness and damping, with the memory condensed out.
//!
//! An implicit step solves `(a²M + a D + K) u_q = r_f + (a M + D) r_q` with `a = 1/(γh)`. Memory
//! is a scalar of one bend and one effect, so `(a − ∂g/∂z) u_z = r_z + ∂g/∂q u_q + ∂g/∂v u_v` is
//! eliminated bend by bend before assembly: the tangents by curvature and rate gain
//! `m_z g_κ/(a − g_z)` and `m_z g_κ̇/(a − g_z)`, and the band stays as narrow as without memory.

use nalgebra::{Matrix2, Vector2};

use crate::banded::Banded;
use crate::coupled::Coupled;
use crate::effects::BendTangent;
use crate::kinematics::{Fields, dot, left};
use crate::model::Model;
use crate::system::{Assembly, Context, System};

/// Tangents of the laws and geometry of the posture at which they were taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tangent {
    by_kappa: Vec<f64>,
    by_kappa_rate: Vec<f64>,
    /// Moments' tangents by the mean square curvature.
    by_mean: Vec<f64>,
    by_stretch: Vec<f64>,
    by_stretch_rate: Vec<f64>,
    flow: Vec<[[f64; 2]; 2]>,
    tip: [[f64; 6]; 3],
    /// One entry a bend and effect with memory, in the order of the memory.
    memory: Vec<BendTangent>,
    /// Gradient of an edge's angle by the edge vector, 1/m, and of its rate, 1/(m s).
    angle_by_edge: Vec<[f64; 2]>,
    rate_by_edge: Vec<[f64; 2]>,
    kappa: Vec<f64>,
    kappa_slope: Vec<f64>,
    kappa_rate: Vec<f64>,
    moment: Vec<f64>,
    tension: Vec<f64>,
    tangent: Vec<[f64; 2]>,
    per_length: Vec<f64>,
    edge_rate: Vec<f64>,
    outer: Vec<[f64; 2]>,
    midpoint_velocity: Vec<[f64; 2]>,
    body_axis: [f64; 2],
    body_rate: f64,
    last_force: [f64; 2],
    decay_rate: f64,
    /// Turning moments' tangents by turning angle and its rate, memory condensed, shape `[N+1]`.
    by_angle: Vec<f64>,
    by_angle_rate: Vec<f64>,
    stiffness: Coupled,
    damping: Banded,
    /// Whether damping has more than the decay of momenta.
    couples_rates: bool,
}

impl Tangent {
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.edges;
        let bends = vec![0.0; n + 1];
        let edges = vec![0.0; n];
        let vectors = vec![[0.0; 2]; n];
        Self {
            by_kappa: bends.clone(),
            by_kappa_rate: bends.clone(),
            by_mean: bends.clone(),
            by_stretch: edges.clone(),
            by_stretch_rate: edges.clone(),
            flow: vec![[[0.0; 2]; 2]; n],
            memory: vec![BendTangent::default(); model.memory()],
            angle_by_edge: vectors.clone(),
            rate_by_edge: vectors.clone(),
            kappa: bends.clone(),
            kappa_slope: bends.clone(),
            kappa_rate: bends.clone(),
            moment: bends.clone(),
            tension: edges.clone(),
            tangent: vectors.clone(),
            per_length: edges.clone(),
            edge_rate: edges,
            outer: vectors.clone(),
            midpoint_velocity: vectors,
            by_angle: bends.clone(),
            by_angle_rate: bends,
            stiffness: Coupled::zeros(model.dof()),
            damping: Banded::zeros(model.dof()),
            ..Self::default()
        }
    }

    /// Keeps what the matrices need of the posture and of what the laws say there.
    fn keep_geometry(&mut self, c: &Context<f64>, f: &Fields<f64>, has_flow: bool) {
        let n = c.edges;
        for j in 0..n {
            let tangent = f.tangent[j];
            let normal = left(tangent);
            let per_length = f.per_length[j];
            let along = f.stretch_rate[j] * c.rest_length * per_length;
            let turn = f.edge_rate[j];
            self.angle_by_edge[j] = normal.map(|n| n * per_length);
            self.rate_by_edge[j] = [0, 1].map(|k| -(tangent[k] * turn + normal[k] * along) * per_length);
            if has_flow {
                self.midpoint_velocity[j] = f.midpoint_velocity(j);
            }
        }
        let inner = f.edge_force(n - 1);
        self.last_force = [0, 1].map(|k| f.tip[k] - inner[k] + 0.5 * f.outer[n - 1][k]);
        self.decay_rate = f.decay_rate;
        self.kappa.copy_from_slice(&f.kappa);
        self.kappa_slope.copy_from_slice(&f.kappa_slope);
        self.kappa_rate.copy_from_slice(&f.kappa_rate);
        self.moment.copy_from_slice(&f.moment);
        self.tension.copy_from_slice(&f.tension);
        self.tangent.copy_from_slice(&f.tangent);
        self.per_length.copy_from_slice(&f.per_length);
        self.edge_rate.copy_from_slice(&f.edge_rate);
        self.outer.copy_from_slice(&f.outer);
        self.body_axis = f.body_axis;
        self.body_rate = f.body_rate;
    }

    /// Generalised forces, one for each coordinate, with which torques that resist the turning of
    /// bends, N m, resist; with `arm` from the last node to the end body's centre of mass.
    fn spread(&self, arm: f64, torque: impl Fn(usize) -> f64, mut add: impl FnMut(usize, f64)) {
        let n = self.tangent.len();
        let mut before = torque(0);
        let mut pull_before = [0.0; 2];
        for j in 0..n {
            let after = torque(j + 1);
            let pull = self.angle_by_edge[j].map(|g| g * (before - after));
            if j > 0 {
                for k in 0..2 {
                    add(2 * j - 2 + k, pull_before[k] - pull[k]);
                }
            }
            (before, pull_before) = (after, pull);
        }
        for k in 0..2 {
            add(2 * n - 2 + k, pull_before[k]);
        }
        add(2 * n, before - arm * dot(pull_before, left(self.body_axis)));
    }

    /// What the mean square curvature `⟨κ²⟩` adds to the stiffness, beside its band: how it moves the
    /// forces, times how the coordinates move it.
    fn couple(&mut self, c: &Context<f64>) {
        let arm = c.body.center_of_mass;
        let per_length = 2.0 / c.bent_length();
        let mut stiffness = std::mem::take(&mut self.stiffness);
        stiffness.put_beside(|column, row| {
            let torque = |i: usize| self.by_mean[i] * self.kappa_slope[i];
            self.spread(arm, torque, |dof, x| column[dof] = x);
            let slope = |i: usize| per_length * c.per_voronoi[i] * self.kappa[i] * self.kappa_slope[i];
            self.spread(arm, slope, |dof, x| row[dof] = x);
        });
        self.stiffness = stiffness;
    }

    /// `∂g/∂z` of every memory variable, 1/s.
    pub(crate) fn memory_slopes(&self) -> impl Iterator<Item = f64> + '_ {
        self.memory.iter().map(|tangent| tangent.memory_rate[2])
    }
}

impl System<'_> {
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
        let model = self.model;
        let t = &mut self.tangent;
        for list in [&mut t.by_kappa, &mut t.by_kappa_rate, &mut t.by_stretch, &mut t.by_stretch_rate] {
            list.fill(0.0);
        }
        t.flow.fill([[0.0; 2]; 2]);
        t.tip = [[0.0; 6]; 3];
        self.assembly.place(model, time, q, v);
        let Assembly { context: c, fields: f, acting, .. } = &mut self.assembly;
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
        if !acting.whole.is_empty() {
            t.by_mean.fill(0.0);
        }
        for &k in &acting.whole {
            let active = &model.effects[k];
            let theta = &model.theta[active.theta.clone()];
            active.effect.linearise_by_mean(c, theta, f, &z[active.memory.clone()], &mut t.by_mean);
        }
        f.moment[0] += c.clamp_moment * f.kappa[0];
        t.by_kappa[0] += c.clamp_moment;
        for &k in &acting.edge {
            let active = &model.effects[k];
            let theta = &model.theta[active.theta.clone()];
            active.effect.linearise_tensions(c, theta, f, &mut t.by_stretch, &mut t.by_stretch_rate);
        }
        for &k in &acting.flow {
            let active = &model.effects[k];
            active.effect.linearise_flows(c, &model.theta[active.theta.clone()], f, &mut t.flow);
        }
        self.assembly.add_loads(model, q);
        for &k in &self.assembly.acting.tip {
            let active = &model.effects[k];
            let share = self.assembly.share(active.effect);
            let slopes =
                active.effect.linearise_tip(&self.assembly.tip(q), &model.theta[active.theta.clone()]);
            for (row, add) in t.tip.iter_mut().zip(slopes) {
                for (entry, slope) in row.iter_mut().zip(add) {
                    *entry += share * slope;
                }
            }
        }
        let (c, f) = (&self.assembly.context, &self.assembly.fields);
        f.gather(c, v, force);
        t.keep_geometry(c, f, !self.assembly.acting.flow.is_empty());
    }

    /// Makes tangent stiffness `−∂f/∂q` and damping `−∂f/∂v` for a step with `a = 1/(γh)`, 1/s, at
    /// the state of the last [`linearise`](Self::linearise). At `a = 0` the memory is relaxed: statics.
    pub fn condense(&mut self, a: f64) {
        self.condense_with(|memory| {
            let [g_kappa, g_rate, g_z] = memory.memory_rate;
            let response = memory.moment[2] * response(a, g_z);
            [response * g_kappa, response * g_rate]
        });
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
        self.condense_with(|memory| {
            let [g_kappa, g_rate, g_z] = memory.memory_rate;
            let response = memory.moment[2] / (square + g_z * g_z);
            [response * (square * g_rate - g_z * g_kappa), -response * (g_kappa + g_z * g_rate)]
        });
    }

    /// Condenses with what a memory adds to the tangents by curvature and by its rate.
    fn condense_with(&mut self, add: impl Fn(&BendTangent) -> [f64; 2]) {
        let c = &self.assembly.context;
        let n = c.edges;
        let share = c.root_share;
        let t = &mut self.tangent;
        for i in 0..=n {
            let mut by_kappa = t.by_kappa[i];
            let mut by_rate = t.by_kappa_rate[i];
            for memory in t.memory.iter().skip(i).step_by(n + 1) {
                let [stiffness, damping] = add(memory);
                by_kappa += stiffness;
                by_rate += damping;
            }
            // κ'' = κ κ'/2, of which the root holds the rod's share.
            let half_kappa = 0.5 * t.kappa[i] / if i == 0 { share } else { 1.0 };
            let slope = t.kappa_slope[i];
            t.by_angle[i] = (by_kappa * slope + by_rate * half_kappa * t.kappa_rate[i]) * slope
                + t.moment[i] * half_kappa * slope;
            t.by_angle_rate[i] = by_rate * slope * slope;
        }
        t.assemble_edges(n, c.per_rest_length);
        if !self.assembly.acting.flow.is_empty() {
            t.assemble_flows(n);
        }
        t.assemble_tip(n);
        t.turn_to_body(n, c.body.center_of_mass);
        match self.assembly.acting.whole.is_empty() {
            true => t.stiffness.put_nothing_beside(),
            false => t.couple(c),
        }
        t.couples_rates = !(self.assembly.acting.flow.is_empty() && self.assembly.acting.tip.is_empty())
            || t.by_angle_rate.iter().chain(&t.by_stretch_rate).any(|slope| *slope != 0.0);
        t.damping.add_diagonal(t.decay_rate, &self.mass);
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
        if self.tangent.couples_rates {
            self.tangent.damping.multiply_add(v, sum);
        } else if self.tangent.decay_rate != 0.0 {
            for ((sum, v), mass) in sum.iter_mut().zip(v).zip(&self.mass) {
                for (sum, v) in sum.iter_mut().zip(v) {
                    *sum += self.tangent.decay_rate * mass * v;
                }
            }
        }
    }

    /// Adds to the residuals of force what the residuals of memory do there, for `P` columns.
    pub fn condense_residual<const P: usize>(&self, a: f64, r_z: &[[f64; P]], r_f: &mut [[f64; P]]) {
        let t = &self.tangent;
        if t.memory.is_empty() {
            return;
        }
        let n = self.model.edges;
        let arm = self.assembly.context.body.center_of_mass;
        for p in 0..P {
            let torque = |i: usize| {
                let bend = t.memory.iter().zip(r_z).skip(i).step_by(n + 1);
                let moment: f64 = bend
                    .map(|(memory, r)| memory.moment[2] * r[p] * response(a, memory.memory_rate[2]))
                    .sum();
                moment * t.kappa_slope[i]
            };
            t.spread(arm, torque, |dof, resistance| r_f[dof][p] -= resistance);
        }
    }

    /// Memory increments that belong to increments of coordinates and velocities, for `P` columns:
    /// overwrites the residuals of memory.
    pub fn recover_memory<const P: usize>(
        &self,
        a: f64,
        u_q: &[[f64; P]],
        u_v: &[[f64; P]],
        r_z: &mut [[f64; P]],
    ) {
        let t = &self.tangent;
        if t.memory.is_empty() {
            return;
        }
        let n = self.model.edges;
        let share = self.assembly.context.root_share;
        let arm = self.assembly.context.body.center_of_mass;
        let across = left(t.body_axis);
        for p in 0..P {
            let node = |i: usize| -> ([f64; 2], [f64; 2]) {
                if i == 0 {
                    return ([0.0; 2], [0.0; 2]);
                }
                let mut at = [0, 1].map(|k| u_q[2 * i - 2 + k][p]);
                let mut rate = [0, 1].map(|k| u_v[2 * i - 2 + k][p]);
                if i == n {
                    for k in 0..2 {
                        at[k] -= arm * across[k] * u_q[2 * n][p];
                        rate[k] -=
                            arm * (across[k] * u_v[2 * n][p] - t.body_axis[k] * t.body_rate * u_q[2 * n][p]);
                    }
                }
                (at, rate)
            };
            let mut start = node(0);
            let mut turn_before = [0.0; 2];
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
                let half_kappa = 0.5 * t.kappa[i] / if i == 0 { share } else { 1.0 };
                let kappa = t.kappa_slope[i] * angle;
                let kappa_rate = half_kappa * t.kappa_rate[i] * angle + t.kappa_slope[i] * rate;
                for k in (i..t.memory.len()).step_by(n + 1) {
                    let [g_kappa, g_rate, g_z] = t.memory[k].memory_rate;
                    r_z[k][p] = (r_z[k][p] + g_kappa * kappa + g_rate * kappa_rate) * response(a, g_z);
                }
            }
        }
    }
}

/// `1/(a − g_z)`; zero where the memory does not move at all.
fn response(a: f64, g_z: f64) -> f64 {
    let pole = a - g_z;
    if pole.abs() < 1e-12 { 0.0 } else { 1.0 / pole }
}

type Block = Matrix2<f64>;

fn outer(a: [f64; 2], b: [f64; 2]) -> Block {
    Vector2::from(a) * Vector2::from(b).transpose()
}

/// Adds `scale · block` at a pair of nodes; the clamped node 0 has no row.
fn scatter(matrix: &mut Banded, row: usize, column: usize, scale: f64, block: &Block) {
    if row == 0 || column == 0 {
        return;
    }
    for k in 0..2 {
        for l in 0..2 {
            matrix[(2 * row - 2 + k, 2 * column - 2 + l)] += scale * block[(k, l)];
        }
    }
}

/// An edge's row of a matrix over edge vectors: the blocks with the edge before, itself, and the
/// edge after.
#[derive(Clone, Copy, Default)]
struct EdgeRow {
    before: Block,
    own: Block,
    after: Block,
}

/// Overwrites a matrix over coordinates by one over edge vectors, given row by row: `e = x[j+1] − x[j]`,
/// so that each block of two nodes joins up to four of two edges. The angle's row becomes zero.
fn place_edges(matrix: &mut Banded, n: usize, row: impl Fn(usize) -> EdgeRow) {
    let mut inner = row(0);
    for i in 1..=n {
        let outer = if i < n { row(i) } else { EdgeRow::default() };
        let mut blocks = [
            -inner.before,
            inner.before - inner.own + outer.before,
            inner.own - inner.after - outer.before + outer.own,
            inner.after - outer.own + outer.after,
            -outer.after,
        ];
        // Node 0 is clamped.
        for block in blocks.iter_mut().take(3_usize.saturating_sub(i)) {
            *block = Block::zeros();
        }
        for k in 0..2 {
            let entries = std::array::from_fn(|at| blocks[at / 2][(k, at % 2)]);
            matrix.set_row::<10>(2 * i - 2 + k, 2 - k, entries);
        }
        inner = outer;
    }
    matrix.set_row(2 * n, 0, []);
}

impl Tangent {
    /// Stretch, bending and their geometric stiffness, with the last node in the place of the
    /// body's centre of mass.
    fn assemble_edges(&mut self, n: usize, per_rest_length: f64) {
        let mut stiffness = std::mem::take(&mut self.stiffness.band);
        place_edges(&mut stiffness, n, |j| self.edge_stiffness(j, per_rest_length));
        self.stiffness.band = stiffness;
        let mut damping = std::mem::take(&mut self.damping);
        if self.by_angle_rate.iter().chain(&self.by_stretch_rate).any(|slope| *slope != 0.0) {
            place_edges(&mut damping, n, |j| self.edge_damping(j, per_rest_length));
        } else {
            damping.clear();
        }
        self.damping = damping;
        let (a, b) = (self.by_angle[n], self.by_angle_rate[n]);
        let (g, h) = (self.angle_by_edge[n - 1], self.rate_by_edge[n - 1]);
        let angle = 2 * n;
        self.stiffness.band[(angle, angle)] += a;
        self.damping[(angle, angle)] += b;
        for k in 0..2 {
            for (node, sign) in [(n, 1.0), (n - 1, -1.0)] {
                let dof = 2 * node - 2 + k;
                self.stiffness.band[(dof, angle)] -= sign * a * g[k];
                self.stiffness.band[(angle, dof)] -= sign * (a * g[k] + b * h[k]);
                self.damping[(dof, angle)] -= sign * b * g[k];
                self.damping[(angle, dof)] -= sign * b * g[k];
            }
        }
    }

    /// Derivative of the force in edge `j` by the edge vectors.
    fn edge_stiffness(&self, j: usize, per_rest_length: f64) -> EdgeRow {
        let (a, b) = (&self.by_angle, &self.by_angle_rate);
        let tangent = self.tangent[j];
        let normal = left(tangent);
        let (g, h) = (self.angle_by_edge[j], self.rate_by_edge[j]);
        let per_length = self.per_length[j];
        let torque = self.moment[j] * self.kappa_slope[j] - self.moment[j + 1] * self.kappa_slope[j + 1];
        let across = outer(tangent, normal);
        let own = outer(tangent, tangent) * (self.by_stretch[j] * per_rest_length)
            + across * (self.by_stretch_rate[j] * per_rest_length * self.edge_rate[j])
            + outer(normal, normal) * (self.tension[j] * per_length)
            - (across + across.transpose()) * (torque * per_length * per_length)
            + outer(g, g) * (a[j] + a[j + 1])
            + outer(g, h) * (b[j] + b[j + 1]);
        let with = |other: usize, bend: usize| {
            outer(g, self.angle_by_edge[other]) * -a[bend] - outer(g, self.rate_by_edge[other]) * b[bend]
        };
        EdgeRow {
            before: if j > 0 { with(j - 1, j) } else { Block::zeros() },
            own,
            after: if j + 1 < self.tangent.len() { with(j + 1, j + 1) } else { Block::zeros() },
        }
    }

    /// Derivative of the force in edge `j` by the rates of the edge vectors.
    fn edge_damping(&self, j: usize, per_rest_length: f64) -> EdgeRow {
        let b = &self.by_angle_rate;
        let g = self.angle_by_edge[j];
        let tangent = self.tangent[j];
        let with = |other: usize, bend: usize| outer(g, self.angle_by_edge[other]) * -b[bend];
        EdgeRow {
            before: if j > 0 { with(j - 1, j) } else { Block::zeros() },
            own: outer(tangent, tangent) * (self.by_stretch_rate[j] * per_rest_length)
                + outer(g, g) * (b[j] + b[j + 1]),
            after: if j + 1 < self.tangent.len() { with(j + 1, j + 1) } else { Block::zeros() },
        }
    }

    /// Outer forces on edges, half on each end.
    fn assemble_flows(&mut self, n: usize) {
        for j in 0..n {
            let tangent = self.tangent[j];
            let normal = left(tangent);
            let [along, across] = self.midpoint_velocity[j];
            let axes = [tangent, normal];
            let mut by_velocity = Block::zeros();
            for (k, row) in self.flow[j].iter().enumerate() {
                for (l, slope) in row.iter().enumerate() {
                    by_velocity += outer(axes[k], axes[l]) * *slope;
                }
            }
            // Turning the edge turns the force with it, and the velocity that it sees against it.
            let seen = [0, 1].map(|k| {
                self.flow[j]
                    .iter()
                    .zip(axes)
                    .map(|(row, axis)| (row[0] * across - row[1] * along) * axis[k])
                    .sum::<f64>()
            });
            let turned = left(self.outer[j]);
            let by_angle = [0, 1].map(|k| turned[k] + seen[k]);
            let by_edge = outer(by_angle, self.angle_by_edge[j]);
            for row in [j, j + 1] {
                scatter(&mut self.stiffness.band, row, j + 1, -0.5, &by_edge);
                scatter(&mut self.stiffness.band, row, j, 0.5, &by_edge);
                scatter(&mut self.damping, row, j, -0.25, &by_velocity);
                scatter(&mut self.damping, row, j + 1, -0.25, &by_velocity);
            }
        }
    }

    /// Loads at the tip; the angle's coordinate follows the last node's.
    fn assemble_tip(&mut self, n: usize) {
        for (k, row) in self.tip.iter().enumerate() {
            for l in 0..3 {
                self.stiffness.band[(2 * n - 2 + k, 2 * n - 2 + l)] -= row[l];
                self.damping[(2 * n - 2 + k, 2 * n - 2 + l)] -= row[3 + l];
            }
        }
    }

    /// From the last node to the body's centre of mass: `x_N = X − c d(φ)`, by the chain rule.
    fn turn_to_body(&mut self, n: usize, arm: f64) {
        let angle = 2 * n;
        let last = 2 * n - 2;
        let axis = self.body_axis;
        let across = left(axis);
        for row in last.saturating_sub(4)..=angle {
            let damping = [0, 1].map(|k| self.damping[(row, last + k)]);
            let stiffness = [0, 1].map(|k| self.stiffness.band[(row, last + k)]);
            self.stiffness.band[(row, angle)] +=
                arm * (self.body_rate * dot(damping, axis) - dot(stiffness, across));
            self.damping[(row, angle)] -= arm * dot(damping, across);
        }
        for column in last.saturating_sub(4)..=angle {
            let stiffness = [0, 1].map(|k| self.stiffness.band[(last + k, column)]);
            let damping = [0, 1].map(|k| self.damping[(last + k, column)]);
            self.stiffness.band[(angle, column)] -= arm * dot(stiffness, across);
            self.damping[(angle, column)] -= arm * dot(damping, across);
        }
        self.stiffness.band[(angle, angle)] -= arm * dot(self.last_force, axis);
    }
}
