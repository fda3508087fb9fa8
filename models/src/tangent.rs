//! Tangent stiffness and damping, assembled from tangents of the laws and the geometry of a posture: first by edge vectors, then
//! by coordinates.

use crate::banded::Banded;
use crate::by_turns::{Block, ByTurns, HALF_REACH, place_edges};
use crate::context::Context;
use crate::coupled::Coupled;
use crate::edge_rows::{Damping, Stiffness};
use crate::effects::BendTangent;
use crate::kinematics::Fields;
use crate::model::Model;
use crate::number::Plain;
use crate::plane::{dot, left};
use crate::stencil::Stencil;

/// Tangents of the laws and geometry of the posture at which they were taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tangent<T = f64> {
    pub by_kappa: Vec<T>,
    pub by_kappa_rate: Vec<T>,
    /// Moments' tangents by the mean square curvature.
    pub by_mean: Vec<T>,
    pub by_stretch: Vec<T>,
    pub by_stretch_rate: Vec<T>,
    pub flow: Vec<[[T; 2]; 2]>,
    pub tip: [[T; 6]; 3],
    /// One entry a bend and memory, in the order of the memories: effect, memory of the effect, bend.
    pub memory: Vec<BendTangent<T>>,
    /// How many of them, from the first, there are up to the last that a moment depends on: an effect that is off has none.
    pub felt: usize,
    /// Gradient of an edge's angle by the edge vector, 1/m, and of its rate, 1/(m s).
    pub angle_by_edge: Vec<[T; 2]>,
    pub rate_by_edge: Vec<[T; 2]>,
    /// Gradient of the rate of an edge's length by the edge vector, 1/s; that of its length is the tangent.
    pub length_rate_by_edge: Vec<[T; 2]>,
    /// Axial force and shear force times length in each edge, N and N m.
    pub pull: Vec<T>,
    pub torque: Vec<T>,
    /// First and second derivative of the angles by the turning angles, and the second times their rate.
    pub angle_slope: Vec<T>,
    pub angle_curve: Vec<T>,
    pub angle_curve_rate: Vec<T>,
    pub tangent: Vec<[T; 2]>,
    pub per_length: Vec<T>,
    outer: Vec<[T; 2]>,
    midpoint_velocity: Vec<[T; 2]>,
    /// From the last node to the end body's centre of mass, m.
    pub body_arm: [T; 2],
    pub body_rate: T,
    last_force: [T; 2],
    pub decay_rate: T,
    /// Moments and axial forces by turning angles and edge lengths, and by their rates; memory condensed.
    pub by_turns: ByTurns<T>,
    pub by_turn_rates: ByTurns<T>,
    /// Room for moments of the bends, and for those at the turning angles, shape `[N+1]`.
    pub of_bends: Vec<T>,
    pub of_angles: Vec<T>,
    pub stiffness: Coupled<T>,
    pub damping: Banded<T>,
    /// Whether damping has more than the decay of momenta.
    pub couples_rates: bool,
}

impl<T: Plain> Tangent<T> {
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.edges;
        let zero = T::default();
        let bends = vec![zero; n + 1];
        let edges = vec![zero; n];
        let vectors = vec![[zero; 2]; n];
        Self {
            by_kappa: bends.clone(),
            by_kappa_rate: bends.clone(),
            by_mean: bends.clone(),
            by_stretch: edges.clone(),
            by_stretch_rate: edges.clone(),
            flow: vec![[[zero; 2]; 2]; n],
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
    #[inline(always)]
    pub fn keep_geometry(&mut self, c: &Context<T>, f: &Fields<T>, has_flow: bool) {
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
        self.last_force = [0, 1].map(|k| f.tip[k] - inner[k] + f.outer[n - 1][k] * 0.5);
        self.decay_rate = f.decay_rate;
        self.angle_slope.copy_from_slice(&f.angle_slope);
        self.tangent.copy_from_slice(&f.tangent);
        self.per_length.copy_from_slice(&f.per_length);
        self.outer.copy_from_slice(&f.outer);
        self.body_arm = f.body_arm;
        self.body_rate = f.body_rate;
    }

    /// Turns moments of the bends into those at the turning angles, in place.
    #[inline(always)]
    pub fn turn_moments(&mut self, stencil: &Stencil<T>) {
        stencil.moments(&self.of_bends, &mut self.of_angles);
        for (moment, slope) in self.of_angles.iter_mut().zip(&self.angle_slope) {
            *moment = *moment * *slope;
        }
    }

    /// Generalised forces, one for each coordinate, with which the moments [at the turning
    /// angles](Self::of_angles), N m, resist.
    #[inline(always)]
    pub fn spread(&self, mut add: impl FnMut(usize, T)) {
        let n = self.tangent.len();
        let moment = &self.of_angles;
        let mut pull_before = [T::default(); 2];
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
    #[inline(always)]
    pub fn couple(&mut self, c: &Context<T>, kappa: &[T]) {
        let per_length = T::from(2.0) / c.bent_length();
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
    pub(crate) fn memory_slopes(&self) -> impl Iterator<Item = T> + '_ {
        self.memory.iter().map(|tangent| tangent.memory_rate[2])
    }

    /// Derivatives of the rate of every memory variable: by integrated curvature, by its rate, by itself.
    pub(crate) fn memory_rates(&self) -> impl Iterator<Item = [T; 3]> + '_ {
        self.memory.iter().map(|tangent| tangent.memory_rate)
    }
}

/// Adds `scale · block` at a pair of nodes; the clamped node 0 has no row.
#[inline(always)]
fn scatter<T: Plain>(matrix: &mut Banded<T>, row: usize, column: usize, scale: f64, block: &Block<T>) {
    if row == 0 || column == 0 {
        return;
    }
    for k in 0..2 {
        for l in 0..2 {
            matrix[(2 * row - 2 + k, 2 * column - 2 + l)] += block.0[k][l] * scale;
        }
    }
}

/// Coordinates before the last node's that it is joined with: those of four nodes.
const LAST_REACH: usize = 2 * (HALF_REACH + 1);
impl<T: Plain> Tangent<T> {
    /// Stretch of an edge's arc.
    #[inline(always)]
    pub fn add_edge(&mut self, j: usize, c: &Context<T>, f: &Fields<T>) {
        let [before, after] = c.stencil.arc(j).map(|weight| 2.0 * weight);
        let per_rest_length = c.per_rest_length;
        let (length, length_rate, tension) = (f.length[j], f.length_rate[j], f.tension[j]);
        let zero = T::default();
        let mut strain = [zero, zero, f.arc[j] * per_rest_length];
        let mut strain_rate = [zero, zero, f.arc_rate[j] * per_rest_length];
        // The strain's second derivative; the angle's own is among the moments.
        let mut curve = [[zero; 3]; 3];
        for (k, (bend, weight)) in [(j, before), (j + 1, after)].into_iter().enumerate() {
            let (angle, slope, rate) = (f.angle[bend], f.angle_slope[bend], f.angle_rate[bend]);
            let arc = angle * weight * slope;
            let arc_rate = (slope * rate + angle * self.angle_curve_rate[bend]) * weight;
            strain[k] = length * arc * per_rest_length;
            strain_rate[k] = (length_rate * arc + length * arc_rate) * per_rest_length;
            curve[k][k] = tension * length * weight * slope * slope;
            curve[k][2] = tension * arc;
            curve[2][k] = tension * arc;
        }
        let stiffness = self.by_stretch[j] * c.rest_length;
        let damping = self.by_stretch_rate[j] * c.rest_length;
        let mut by_strain = [[zero; 3]; 3];
        let mut by_rate = [[zero; 3]; 3];
        for l in 0..3 {
            let force = stiffness * strain[l] + damping * strain_rate[l];
            for k in 0..3 {
                by_strain[k][l] = strain[k] * force + curve[k][l];
                by_rate[k][l] = damping * strain[k] * strain[l];
            }
        }
        self.by_turns.add_edge(j, &by_strain);
        self.by_turn_rates.add_edge(j, &by_rate);
    }

    /// Stretch, bending and their geometric stiffness, with the last node in the place of the
    /// body's centre of mass.
    #[inline(always)]
    pub fn assemble_edges(&mut self, n: usize) {
        let is_damped = |slope: &T| slope.any(|slope| slope != 0.0);
        let mut rates = self.by_turn_rates.angles.iter().flatten().chain(&self.by_stretch_rate);
        self.couples_rates = rates.any(is_damped);
        let mut stiffness = std::mem::take(&mut self.stiffness);
        place_edges(&mut stiffness.band, n, &Stiffness(self));
        let mut damping = std::mem::take(&mut self.damping);
        if self.couples_rates {
            place_edges(&mut damping, n, &Damping(self));
        } else {
            damping.clear();
        }
        self.place_body(n, &mut stiffness.band, &mut damping);
        self.stiffness = stiffness;
        self.damping = damping;
    }

    /// The end body's angle, which is that of one edge more, of no length.
    #[inline(always)]
    fn place_body(&self, n: usize, stiffness: &mut Banded<T>, damping: &mut Banded<T>) {
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
                    stiffness[(dof, angle)] += column[k] * sign;
                    damping[(dof, angle)] += column_rate[k] * sign;
                    stiffness[(angle, dof)] += row[k] * sign;
                    damping[(angle, dof)] += row_rate[k] * sign;
                }
            }
        }
    }

    /// Outer forces on edges, half on each end.
    #[inline(always)]
    pub fn assemble_flows(&mut self, n: usize) {
        for j in 0..n {
            let tangent = self.tangent[j];
            let normal = left(tangent);
            let [along, across] = self.midpoint_velocity[j];
            let axes = [tangent, normal];
            let mut by_velocity = Block::default();
            for (k, row) in self.flow[j].iter().enumerate() {
                for (l, slope) in row.iter().enumerate() {
                    by_velocity.add(Block::outer(axes[k], axes[l]).times(*slope));
                }
            }
            // Turning the edge turns the force with it, and the velocity that it sees against it.
            let seen = [0, 1].map(|k| {
                let turns = self.flow[j].iter().zip(axes);
                turns.fold(T::from(-0.0), |sum, (row, axis)| {
                    sum + (row[0] * across - row[1] * along) * axis[k]
                })
            });
            let turned = left(self.outer[j]);
            let by_angle = [0, 1].map(|k| turned[k] + seen[k]);
            let by_edge = Block::outer(by_angle, self.angle_by_edge[j]);
            for row in [j, j + 1] {
                scatter(&mut self.stiffness.band, row, j + 1, -0.5, &by_edge);
                scatter(&mut self.stiffness.band, row, j, 0.5, &by_edge);
                scatter(&mut self.damping, row, j, -0.25, &by_velocity);
                scatter(&mut self.damping, row, j + 1, -0.25, &by_velocity);
            }
        }
    }

    /// Loads at the tip; the angle's coordinate follows the last node's.
    #[inline(always)]
    pub fn assemble_tip(&mut self, n: usize) {
        for (k, row) in self.tip.iter().enumerate() {
            for l in 0..3 {
                self.stiffness.band[(2 * n - 2 + k, 2 * n - 2 + l)] -= row[l];
                self.damping[(2 * n - 2 + k, 2 * n - 2 + l)] -= row[3 + l];
            }
        }
    }

    /// From the last node to the body's centre of mass: `x_N = X − c d(φ)`, by the chain rule.
    #[inline(always)]
    pub fn turn_to_body(&mut self, n: usize) {
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
