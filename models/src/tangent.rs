//! Linearised equations of motion: tangent stiffness and damping, with the memory condensed out.
//!
//! An implicit step solves `(a²M + a D + K) u_q = r_f + (a M + D) r_q` with `a = 1/(γh)`. A memory
//! is a scalar of one bend, and no memory drives another: a law sees one at a time. So `(a − ∂g/∂z) u_z = r_z + ∂g/∂q u_q + ∂g/∂v u_v`
//! is solved for each memory alone, before assembly: the tangents by curvature and rate gain
//! `m_z g_κ/(a − g_z)` and `m_z g_κ̇/(a − g_z)`, and the band stays as narrow as without memory.

use nalgebra::{Matrix2, Vector2};

use crate::banded::Banded;
use crate::context::Context;
use crate::coupled::Coupled;
use crate::effects::BendTangent;
use crate::kinematics::Fields;
use crate::model::Model;
use crate::plane::{dot, left};
use crate::stencil::Stencil;
use crate::system::{Assembly, System};

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
    /// One entry a bend and memory, in the order of the memories: effect, memory of the effect, bend.
    memory: Vec<BendTangent>,
    /// How many of them, from the first, there are up to the last that a moment depends on: an effect that is off has none.
    felt: usize,
    /// Gradient of an edge's angle by the edge vector, 1/m, and of its rate, 1/(m s).
    angle_by_edge: Vec<[f64; 2]>,
    rate_by_edge: Vec<[f64; 2]>,
    /// Gradient of the rate of an edge's length by the edge vector, 1/s; that of its length is the tangent.
    length_rate_by_edge: Vec<[f64; 2]>,
    /// Axial force and shear force times length in each edge, N and N m.
    pull: Vec<f64>,
    torque: Vec<f64>,
    /// First and second derivative of the angles by the turning angles, and the second times their rate.
    angle_slope: Vec<f64>,
    angle_curve: Vec<f64>,
    angle_curve_rate: Vec<f64>,
    tangent: Vec<[f64; 2]>,
    per_length: Vec<f64>,
    outer: Vec<[f64; 2]>,
    midpoint_velocity: Vec<[f64; 2]>,
    /// From the last node to the end body's centre of mass, m.
    body_arm: [f64; 2],
    body_rate: f64,
    last_force: [f64; 2],
    decay_rate: f64,
    /// Moments and axial forces by turning angles and edge lengths, and by their rates; memory condensed.
    by_turns: ByTurns,
    by_turn_rates: ByTurns,
    /// Room for moments of the bends, and for those at the turning angles, shape `[N+1]`.
    of_bends: Vec<f64>,
    of_angles: Vec<f64>,
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
            felt: model.felt_memory(),
            angle_by_edge: vectors.clone(),
            rate_by_edge: vectors.clone(),
            length_rate_by_edge: vectors.clone(),
            pull: edges.clone(),
            torque: edges.clone(),
            angle_slope: bends.clone(),
            angle_curve: bends.clone(),
            angle_curve_rate: bends.clone(),
            tangent: vectors.clone(),
            per_length: edges,
            outer: vectors.clone(),
            midpoint_velocity: vectors,
            by_turns: ByTurns::new(n),
            by_turn_rates: ByTurns::new(n),
            of_bends: bends.clone(),
            of_angles: bends,
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
            let (turn, along) = (f.edge_rate[j], f.length_rate[j] * per_length);
            self.angle_by_edge[j] = normal.map(|n| n * per_length);
            self.rate_by_edge[j] = [0, 1].map(|k| -(tangent[k] * turn + normal[k] * along) * per_length);
            self.length_rate_by_edge[j] = normal.map(|n| n * turn);
            self.pull[j] = f.tension[j] * f.arc[j];
            self.torque[j] = f.torque(j);
            if has_flow {
                self.midpoint_velocity[j] = f.midpoint_velocity(j);
            }
        }
        for i in 0..=n {
            let curve = c.stencil.angle_curve(f.half_tangent[i]);
            self.angle_curve[i] = curve;
            self.angle_curve_rate[i] = curve * f.angle_rate[i] / f.angle_slope[i];
        }
        let inner = f.edge_force(n - 1);
        self.last_force = [0, 1].map(|k| f.tip[k] - inner[k] + 0.5 * f.outer[n - 1][k]);
        self.decay_rate = f.decay_rate;
        self.angle_slope.copy_from_slice(&f.angle_slope);
        self.tangent.copy_from_slice(&f.tangent);
        self.per_length.copy_from_slice(&f.per_length);
        self.outer.copy_from_slice(&f.outer);
        self.body_arm = f.body_arm;
        self.body_rate = f.body_rate;
    }

    /// Turns moments of the bends into those at the turning angles, in place.
    fn turn_moments(&mut self, stencil: &Stencil<f64>) {
        stencil.moments(&self.of_bends, &mut self.of_angles);
        for (moment, slope) in self.of_angles.iter_mut().zip(&self.angle_slope) {
            *moment *= slope;
        }
    }

    /// Generalised forces, one for each coordinate, with which the moments [at the turning
    /// angles](Self::of_angles), N m, resist.
    fn spread(&self, mut add: impl FnMut(usize, f64)) {
        let n = self.tangent.len();
        let moment = &self.of_angles;
        let mut pull_before = [0.0; 2];
        for j in 0..n {
            let pull = self.angle_by_edge[j].map(|g| g * (moment[j] - moment[j + 1]));
            if j > 0 {
                for k in 0..2 {
                    add(2 * j - 2 + k, pull_before[k] - pull[k]);
                }
            }
            pull_before = pull;
        }
        for k in 0..2 {
            add(2 * n - 2 + k, pull_before[k]);
        }
        add(2 * n, moment[n] - dot(pull_before, left(self.body_arm)));
    }

    /// What the mean square curvature `⟨κ²⟩` adds to the stiffness, beside its band: how it moves the
    /// forces, times how the coordinates move it.
    fn couple(&mut self, c: &Context<f64>, kappa: &[f64]) {
        let per_length = 2.0 / c.bent_length();
        let mut stiffness = std::mem::take(&mut self.stiffness);
        stiffness.put_beside(|column, row| {
            self.of_bends.copy_from_slice(&self.by_mean);
            self.turn_moments(&c.stencil);
            self.spread(|dof, x| column[dof] = x);
            for (i, slope) in self.of_bends.iter_mut().enumerate() {
                *slope = per_length * c.per_voronoi[i] * kappa[i];
            }
            self.turn_moments(&c.stencil);
            self.spread(|dof, x| row[dof] = x);
        });
        self.stiffness = stiffness;
    }

    /// `∂g/∂z` of every memory variable, 1/s.
    pub(crate) fn memory_slopes(&self) -> impl Iterator<Item = f64> + '_ {
        self.memory.iter().map(|tangent| tangent.memory_rate[2])
    }

    /// Derivatives of the rate of every memory variable: by integrated curvature, by its rate, by itself.
    pub(crate) fn memory_rates(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.memory.iter().map(|tangent| tangent.memory_rate)
    }
}

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
        self.assembly.add_loads(model, q);
        let (borne, arm) = self.assembly.borne_at_the_end();
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
        let Assembly { context: c, fields: f, acting, .. } = &mut self.assembly;
        // The weight of what has none acts before the last node, and turns with the body.
        t.tip[2][2] -= dot(arm, borne);
        f.resist(c, !acting.clamp.is_empty());
        f.gather(c, v, force);
        t.keep_geometry(c, f, !acting.flow.is_empty());
    }

    /// Moments, their tangents and the rates of memories at the bends' curvatures as they stand.
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
        let Assembly { context: c, fields: f, acting, .. } = &self.assembly;
        let n = c.edges;
        let t = &mut self.tangent;
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
            let slopes: [f64; 3] = std::array::from_fn(|k| row[k] * t.angle_slope[first + k]);
            let rate_slopes: [f64; 3] = std::array::from_fn(|k| row[k] * t.angle_curve_rate[first + k]);
            let moment: [f64; 3] = std::array::from_fn(|k| by_kappa * slopes[k] + by_rate * rate_slopes[k]);
            t.by_turns.add_angles(first, |k, l| slopes[k] * moment[l]);
            if by_rate != 0.0 {
                t.by_turn_rates.add_angles(first, |k, l| by_rate * slopes[k] * slopes[l]);
            }
        }
        for i in 0..=n {
            t.by_turns.angles[i][2] += t.angle_curve[i] * f.angle_moment[i];
        }
        if !acting.clamp.is_empty() {
            let clamp = c.stencil.clamp_stiffness();
            t.by_turns.add_angles(0, |k, l| clamp[k][l] * t.angle_slope[k] * t.angle_slope[l]);
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

    /// Adds to the residuals of force what the residuals of memory do there, for `P` columns. Those of memory that no moment
    /// depends on may be left out.
    pub fn condense_residual<const P: usize>(&mut self, a: f64, r_z: &[[f64; P]], r_f: &mut [[f64; P]]) {
        let t = &mut self.tangent;
        if t.felt == 0 {
            return;
        }
        let c = &self.assembly.context;
        for p in 0..P {
            for (i, moment) in t.of_bends.iter_mut().enumerate() {
                let bend = t.memory[..t.felt].iter().zip(r_z).skip(i).step_by(c.edges + 1);
                *moment = bend
                    .map(|(memory, r)| memory.moment[2] * r[p] * response(a, memory.memory_rate[2]))
                    .sum();
            }
            t.turn_moments(&c.stencil);
            t.spread(|dof, resistance| r_f[dof][p] -= resistance);
        }
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
        if r_z.is_empty() {
            return;
        }
        let t = &mut self.tangent;
        let c = &self.assembly.context;
        let n = c.edges;
        let (arm, swing) = (t.body_arm, left(t.body_arm));
        for p in 0..P {
            let node = |i: usize| -> ([f64; 2], [f64; 2]) {
                if i == 0 {
                    return ([0.0; 2], [0.0; 2]);
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
            let mut turn_before = [0.0; 2];
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
                let along =
                    |angles: &[f64]| -> f64 { row.iter().zip(&angles[first..]).map(|(a, b)| a * b).sum() };
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

/// What turning angles and edge lengths do to the moments at the turning angles and to the axial forces:
/// second derivatives of an energy, or the same of a dissipation. A bend's stencil joins three angles, so each
/// moment knows five; an edge's arc joins its length with the angles at its ends.
#[derive(Clone, Debug, Default)]
struct ByTurns {
    /// Moments by angles: entry `k` of row `i` is that by angle `i + k − 2`.
    angles: Vec<[f64; 5]>,
    /// Moments by the lengths of the edges before and after.
    angle_by_length: Vec<[f64; 2]>,
    /// Axial forces by the angles at both ends.
    length_by_angle: Vec<[f64; 2]>,
    /// Axial forces by the edge's own length.
    lengths: Vec<f64>,
}

impl ByTurns {
    fn new(edges: usize) -> Self {
        Self {
            angles: vec![[0.0; 5]; edges + 1],
            angle_by_length: vec![[0.0; 2]; edges + 1],
            length_by_angle: vec![[0.0; 2]; edges],
            lengths: vec![0.0; edges],
        }
    }

    fn clear(&mut self) {
        self.angles.fill([0.0; 5]);
        self.angle_by_length.fill([0.0; 2]);
    }

    /// Adds a matrix of the three angles from `first` on.
    fn add_angles(&mut self, first: usize, entry: impl Fn(usize, usize) -> f64) {
        for k in 0..3 {
            for l in 0..3 {
                self.angles[first + k][l + 2 - k] += entry(k, l);
            }
        }
    }

    /// Adds a matrix of the angles at both ends of an edge and of its length.
    fn add_edge(&mut self, j: usize, entry: impl Fn(usize, usize) -> f64) {
        for k in 0..2 {
            for l in 0..2 {
                self.angles[j + k][l + 2 - k] += entry(k, l);
            }
            self.angle_by_length[j + k][1 - k] += entry(k, 2);
            self.length_by_angle[j][k] = entry(2, k);
        }
        self.lengths[j] = entry(2, 2);
    }

    /// Torque on edge `j`, the end body for the last, by the angles of the edges from `j − 3` to `j + 3`.
    fn turn_by_turns(&self, j: usize) -> [f64; REACH] {
        let mut by_bends = [0.0; REACH + 1];
        for (sum, entry) in by_bends[1..].iter_mut().zip(&self.angles[j]) {
            *sum += entry;
        }
        if let Some(next) = self.angles.get(j + 1) {
            for (sum, entry) in by_bends[2..].iter_mut().zip(next) {
                *sum -= entry;
            }
        }
        std::array::from_fn(|k| by_bends[k] - by_bends[k + 1])
    }

    /// Torque on edge `j`, the end body for the last, by the lengths of the edges from `j − 1` to `j + 1`.
    fn turn_by_lengths(&self, j: usize) -> [f64; 3] {
        let [before, own] = self.angle_by_length[j];
        let [next_before, next] = self.angle_by_length.get(j + 1).copied().unwrap_or_default();
        [before, own - next_before, -next]
    }

    /// Axial force in edge `j` by the angles of the edges from `j − 1` to `j + 1`.
    fn length_by_turns(&self, j: usize) -> [f64; 3] {
        let [before, after] = self.length_by_angle[j];
        [-before, before - after, after]
    }
}

/// Coordinates before the last node's that it is joined with: those of four nodes.
const LAST_REACH: usize = 2 * (HALF_REACH + 1);
/// Edges that an edge's torque knows: itself and three to each side.
const REACH: usize = 7;
const HALF_REACH: usize = 3;

/// An edge's row of a matrix over edge vectors, the blocks from `j − 3` to `j + 3`.
type EdgeRow = [Block; REACH];

/// Overwrites a matrix over coordinates by one over edge vectors, given row by row: `e = x[j+1] − x[j]`,
/// so that each block of two nodes joins up to four of two edges. The angle's row becomes zero.
fn place_edges(matrix: &mut Banded, n: usize, row: impl Fn(usize) -> EdgeRow) {
    let mut inner = row(0);
    for i in 1..=n {
        let outer = if i < n { row(i) } else { EdgeRow::default() };
        // The row of the node over edges from `i − 4` to `i + 3`, then over nodes from `i − 4` to `i + 4`.
        let mut over_edges = [Block::zeros(); REACH + 1];
        over_edges[..REACH].copy_from_slice(&inner);
        for (block, outer) in over_edges[1..].iter_mut().zip(&outer) {
            *block -= outer;
        }
        let over_nodes = |at: usize| {
            // Node 0 is clamped.
            if i + at < HALF_REACH + 2 {
                return Block::zeros();
            }
            let end = if at > 0 { over_edges[at - 1] } else { Block::zeros() };
            let start = if at <= REACH { over_edges[at] } else { Block::zeros() };
            end - start
        };
        let blocks: [Block; REACH + 2] = std::array::from_fn(over_nodes);
        for k in 0..2 {
            let entries = std::array::from_fn(|at| blocks[at / 2][(k, at % 2)]);
            matrix.set_row::<{ 2 * (REACH + 2) }>(2 * i - 2 + k, 2 - k, entries);
        }
        inner = outer;
    }
    matrix.set_row(2 * n, 0, []);
}

impl Tangent {
    /// Stretch of an edge's arc.
    fn add_edge(&mut self, j: usize, c: &Context<f64>, f: &Fields<f64>) {
        let [before, after] = c.stencil.arc(j).map(|weight| 2.0 * weight);
        let per_rest_length = c.per_rest_length;
        let (length, length_rate, tension) = (f.length[j], f.length_rate[j], f.tension[j]);
        let mut strain = [0.0, 0.0, f.arc[j] * per_rest_length];
        let mut strain_rate = [0.0, 0.0, f.arc_rate[j] * per_rest_length];
        // The strain's second derivative; what the angle's own is stands with the moments.
        let mut curve = [[0.0; 3]; 3];
        for (k, (bend, weight)) in [(j, before), (j + 1, after)].into_iter().enumerate() {
            let (angle, slope, rate) = (f.angle[bend], f.angle_slope[bend], f.angle_rate[bend]);
            let arc = weight * angle * slope;
            let arc_rate = weight * (slope * rate + angle * self.angle_curve_rate[bend]);
            strain[k] = length * arc * per_rest_length;
            strain_rate[k] = (length_rate * arc + length * arc_rate) * per_rest_length;
            curve[k][k] = tension * length * weight * slope * slope;
            curve[k][2] = tension * arc;
            curve[2][k] = tension * arc;
        }
        let stiffness = self.by_stretch[j] * c.rest_length;
        let damping = self.by_stretch_rate[j] * c.rest_length;
        let force: [f64; 3] = std::array::from_fn(|l| stiffness * strain[l] + damping * strain_rate[l]);
        self.by_turns.add_edge(j, |k, l| strain[k] * force[l] + curve[k][l]);
        self.by_turn_rates.add_edge(j, |k, l| damping * strain[k] * strain[l]);
    }

    /// Stretch, bending and their geometric stiffness, with the last node in the place of the
    /// body's centre of mass.
    fn assemble_edges(&mut self, n: usize) {
        let is_damped = |slope: &f64| *slope != 0.0;
        let mut rates = self.by_turn_rates.angles.iter().flatten().chain(&self.by_stretch_rate);
        self.couples_rates = rates.any(is_damped);
        let mut stiffness = std::mem::take(&mut self.stiffness);
        place_edges(&mut stiffness.band, n, |j| self.edge_stiffness(j));
        let mut damping = std::mem::take(&mut self.damping);
        if self.couples_rates {
            place_edges(&mut damping, n, |j| self.edge_damping(j));
        } else {
            damping.clear();
        }
        self.place_body(n, &mut stiffness.band, &mut damping);
        self.stiffness = stiffness;
        self.damping = damping;
    }

    /// The end body's angle, which is that of one edge more, of no length.
    fn place_body(&self, n: usize, stiffness: &mut Banded, damping: &mut Banded) {
        let angle = 2 * n;
        let (own, own_rate) = (self.by_turns.turn_by_turns(n), self.by_turn_rates.turn_by_turns(n));
        stiffness[(angle, angle)] += own[HALF_REACH];
        damping[(angle, angle)] += own_rate[HALF_REACH];
        for j in n.saturating_sub(HALF_REACH)..n {
            let (a, b) = (own[j + HALF_REACH - n], own_rate[j + HALF_REACH - n]);
            let at = n + HALF_REACH - j;
            let (turn, turn_rate) =
                (self.by_turns.turn_by_turns(j)[at], self.by_turn_rates.turn_by_turns(j)[at]);
            let (g, h) = (self.angle_by_edge[j], self.rate_by_edge[j]);
            let mut column = g.map(|g| turn * g);
            let mut column_rate = g.map(|g| turn_rate * g);
            let mut row = [0, 1].map(|k| a * g[k] + b * h[k]);
            let mut row_rate = g.map(|g| b * g);
            if j + 1 == n {
                let (along, along_rate) =
                    (self.by_turns.length_by_turns(j)[2], self.by_turn_rates.length_by_turns(j)[2]);
                let (back, back_rate) =
                    (self.by_turns.turn_by_lengths(n)[0], self.by_turn_rates.turn_by_lengths(n)[0]);
                let (t, s) = (self.tangent[j], self.length_rate_by_edge[j]);
                for k in 0..2 {
                    column[k] += along * t[k];
                    column_rate[k] += along_rate * t[k];
                    row[k] += back * t[k] + back_rate * s[k];
                    row_rate[k] += back_rate * t[k];
                }
            }
            for (node, sign) in [(j + 1, 1.0), (j, -1.0)] {
                if node == 0 {
                    continue;
                }
                for k in 0..2 {
                    let dof = 2 * node - 2 + k;
                    stiffness[(dof, angle)] += sign * column[k];
                    damping[(dof, angle)] += sign * column_rate[k];
                    stiffness[(angle, dof)] += sign * row[k];
                    damping[(angle, dof)] += sign * row_rate[k];
                }
            }
        }
    }

    /// Derivative of the force in edge `j` by the edge vectors.
    fn edge_stiffness(&self, j: usize) -> EdgeRow {
        let n = self.tangent.len();
        let (turns, rates) = (&self.by_turns, &self.by_turn_rates);
        let (by_turns, by_turn_rates) = (turns.turn_by_turns(j), rates.turn_by_turns(j));
        let (by_lengths, by_length_rates) = (turns.turn_by_lengths(j), rates.turn_by_lengths(j));
        let (pull_by_turns, pull_by_turn_rates) = (turns.length_by_turns(j), rates.length_by_turns(j));
        let (along, across) = (self.tangent[j], self.angle_by_edge[j]);
        let mut row = EdgeRow::default();
        for (k, block) in row.iter_mut().enumerate() {
            let Some(other) = (j + k).checked_sub(HALF_REACH).filter(|other| *other < n) else { continue };
            let (g, h) = (self.angle_by_edge[other], self.rate_by_edge[other]);
            let mut turned = [0, 1].map(|m| by_turns[k] * g[m] + by_turn_rates[k] * h[m]);
            // The arcs of edges join neighbours alone.
            if let Some(near) = (k + 1).checked_sub(HALF_REACH).filter(|near| *near < 3) {
                let (t, s) = (self.tangent[other], self.length_rate_by_edge[other]);
                let mut pulled = [0, 1].map(|m| pull_by_turns[near] * g[m] + pull_by_turn_rates[near] * h[m]);
                for m in 0..2 {
                    turned[m] += by_lengths[near] * t[m] + by_length_rates[near] * s[m];
                    if near == 1 {
                        pulled[m] += turns.lengths[j] * t[m] + rates.lengths[j] * s[m];
                    }
                }
                *block += outer(along, pulled);
            }
            *block += outer(across, turned);
        }
        let (normal, per_length) = (left(along), self.per_length[j]);
        let crossed = outer(along, normal);
        row[HALF_REACH] += outer(normal, normal) * (self.pull[j] * per_length)
            - (crossed + crossed.transpose()) * (self.torque[j] * per_length * per_length);
        row
    }

    /// Derivative of the force in edge `j` by the rates of the edge vectors.
    fn edge_damping(&self, j: usize) -> EdgeRow {
        let n = self.tangent.len();
        let rates = &self.by_turn_rates;
        let (by_turns, by_lengths) = (rates.turn_by_turns(j), rates.turn_by_lengths(j));
        let pull_by_turns = rates.length_by_turns(j);
        let (along, across) = (self.tangent[j], self.angle_by_edge[j]);
        let mut row = EdgeRow::default();
        for (k, block) in row.iter_mut().enumerate() {
            let Some(other) = (j + k).checked_sub(HALF_REACH).filter(|other| *other < n) else { continue };
            let g = self.angle_by_edge[other];
            let mut turned = g.map(|g| by_turns[k] * g);
            if let Some(near) = (k + 1).checked_sub(HALF_REACH).filter(|near| *near < 3) {
                let t = self.tangent[other];
                let mut pulled = g.map(|g| pull_by_turns[near] * g);
                for m in 0..2 {
                    turned[m] += by_lengths[near] * t[m];
                    if near == 1 {
                        pulled[m] += rates.lengths[j] * t[m];
                    }
                }
                *block += outer(along, pulled);
            }
            *block += outer(across, turned);
        }
        row
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
    fn turn_to_body(&mut self, n: usize) {
        let angle = 2 * n;
        let last = 2 * n - 2;
        let arm = self.body_arm;
        let swing = left(arm);
        for row in last.saturating_sub(LAST_REACH)..=angle {
            let damping = [0, 1].map(|k| self.damping[(row, last + k)]);
            let stiffness = [0, 1].map(|k| self.stiffness.band[(row, last + k)]);
            self.stiffness.band[(row, angle)] += self.body_rate * dot(damping, arm) - dot(stiffness, swing);
            self.damping[(row, angle)] -= dot(damping, swing);
        }
        for column in last.saturating_sub(LAST_REACH)..=angle {
            let stiffness = [0, 1].map(|k| self.stiffness.band[(last + k, column)]);
            let damping = [0, 1].map(|k| self.damping[(last + k, column)]);
            self.stiffness.band[(angle, column)] -= dot(stiffness, swing);
            self.damping[(angle, column)] -= dot(damping, swing);
        }
        self.stiffness.band[(angle, angle)] -= dot(self.last_force, arm);
    }
}
