//! From generalised coordinates to edges and bends, and from moments and tensions back to forces.
//!
//! Nodes `0..=N`, edges `0..N`; bend `i` sits at node `i`, with the clamp before the first edge and
//! the end body after the last one, so that there are `N+1` bends. Coordinates `q`, shape `[2N+1]`:
//! `x, z` of the nodes `1..N`, then `x, z` of the end body's centre of mass and its angle. The
//! last node is a point of the end body, so the mass matrix is constant and diagonal.

use crate::context::Context;
use crate::number::Number;
use crate::plane::{cross, dot, left, minus};

/// Edge and bend quantities of one posture, and what the laws give for them.
#[derive(Clone, Debug, Default)]
pub struct Fields<T> {
    /// Node positions in W, m, shape `[N+1]`.
    pub position: Vec<[T; 2]>,
    /// Node velocities, m/s, shape `[N+1]`.
    pub velocity: Vec<[T; 2]>,
    /// Direction of the end body.
    pub body_axis: [T; 2],
    /// From the last node to the end body's centre of mass, m.
    pub body_arm: [T; 2],
    /// Its angular velocity, rad/s.
    pub body_rate: T,
    /// Unit tangents, shape `[N]`.
    pub tangent: Vec<[T; 2]>,
    /// One over current edge length, 1/m, shape `[N]`.
    pub per_length: Vec<T>,
    /// Angular velocity of the edge, rad/s, shape `[N]`.
    pub edge_rate: Vec<T>,
    /// Length of each edge, m, and its rate, m/s, shape `[N]`.
    pub length: Vec<T>,
    /// Rate of the edge length, m/s, shape `[N]`.
    pub length_rate: Vec<T>,
    /// Length of the rod's arc between two nodes over that of the edge, its chord, shape `[N]`.
    pub arc: Vec<T>,
    /// Rate of that ratio, 1/s, shape `[N]`.
    pub arc_rate: Vec<T>,
    /// Stretch of the arc, shape `[N]`.
    pub stretch: Vec<T>,
    /// Its rate at the present rest length, 1/s, shape `[N]`.
    pub stretch_rate: Vec<T>,
    /// `tan(φ/2)` of each turning angle, shape `[N+1]`.
    pub half_tangent: Vec<T>,
    /// Turning angle as the scheme takes it, rad, shape `[N+1]`; at the root the clamp's turn included.
    pub angle: Vec<T>,
    /// Its derivative by the turning angle.
    pub angle_slope: Vec<T>,
    /// Its rate, rad/s.
    pub angle_rate: Vec<T>,
    /// Integrated curvature of the rod, shape `[N+1]`, see [`Stencil`](crate::stencil::Stencil).
    pub kappa: Vec<T>,
    /// Its rate at the present rest length, 1/s.
    pub kappa_rate: Vec<T>,
    /// Mean square of the curvature over the rod, 1/m²; zero unless [requested](Self::average).
    pub mean_square_curvature: T,
    /// Resisting moment of each bend, N m, shape `[N+1]`, as the laws have it.
    pub moment: Vec<T>,
    /// What resists each [turning angle](Self::angle), N m, shape `[N+1]`.
    pub angle_moment: Vec<T>,
    /// Tension of each edge, N, shape `[N]`.
    pub tension: Vec<T>,
    /// Outer force on each edge in W, N, shape `[N]`.
    pub outer: Vec<[T; 2]>,
    /// Force on the last node in W, N, and moment on the end body, N m.
    pub tip: [T; 3],
    /// Acceleration of everything that has mass, m/s².
    pub acceleration: [T; 2],
    /// Rate at which its velocity decays, 1/s.
    pub decay_rate: T,
}

impl<T: Number> Fields<T> {
    /// Room for `edges` edges.
    pub fn new(edges: usize) -> Self {
        let zero = T::from(0.0);
        let per_edge = vec![zero; edges];
        let per_bend = vec![zero; edges + 1];
        Self {
            position: vec![[zero; 2]; edges + 1],
            velocity: vec![[zero; 2]; edges + 1],
            body_axis: [zero; 2],
            body_arm: [zero; 2],
            body_rate: zero,
            tangent: vec![[zero; 2]; edges],
            per_length: per_edge.clone(),
            edge_rate: per_edge.clone(),
            length: per_edge.clone(),
            length_rate: per_edge.clone(),
            arc: per_edge.clone(),
            arc_rate: per_edge.clone(),
            stretch: per_edge.clone(),
            stretch_rate: per_edge.clone(),
            half_tangent: per_bend.clone(),
            angle: per_bend.clone(),
            angle_slope: per_bend.clone(),
            angle_rate: per_bend.clone(),
            kappa: per_bend.clone(),
            kappa_rate: per_bend.clone(),
            mean_square_curvature: zero,
            moment: per_bend.clone(),
            angle_moment: per_bend,
            tension: per_edge,
            outer: vec![[zero; 2]; edges],
            tip: [zero; 3],
            acceleration: [zero; 2],
            decay_rate: zero,
        }
    }

    /// Puts the rod at coordinates `q` and velocities `v`, shape `[2N+1]` each, and clears what the
    /// laws have said.
    #[inline(always)]
    pub fn place(&mut self, c: &Context<T>, q: &[T], v: &[T]) {
        self.place_nodes(c, q, v);
        self.place_edges(c);
        self.place_bends(c);
        self.place_arcs(c);
        self.clear();
    }

    #[inline(always)]
    fn place_nodes(&mut self, c: &Context<T>, q: &[T], v: &[T]) {
        let zero = T::from(0.0);
        let n = c.edges;
        self.position[0] = [zero; 2];
        self.velocity[0] = [zero; 2];
        for i in 1..n {
            self.position[i] = [q[2 * i - 2], q[2 * i - 1]];
            self.velocity[i] = [v[2 * i - 2], v[2 * i - 1]];
        }
        let angle = q[2 * n];
        let rate = v[2 * n];
        let axis = [angle.cos(), angle.sin()];
        let arm = c.body.arm(axis);
        let swing = left(arm);
        self.body_axis = axis;
        self.body_arm = arm;
        self.body_rate = rate;
        for k in 0..2 {
            self.position[n][k] = q[2 * n - 2 + k] - arm[k];
            self.velocity[n][k] = v[2 * n - 2 + k] - swing[k] * rate;
        }
    }

    #[inline(always)]
    fn place_edges(&mut self, c: &Context<T>) {
        for j in 0..c.edges {
            let edge = minus(self.position[j + 1], self.position[j]);
            let rate = minus(self.velocity[j + 1], self.velocity[j]);
            let length = dot(edge, edge).sqrt();
            let per_length = length.recip();
            let tangent = [edge[0] * per_length, edge[1] * per_length];
            self.tangent[j] = tangent;
            self.per_length[j] = per_length;
            self.edge_rate[j] = cross(tangent, rate) * per_length;
            self.length[j] = length;
            self.length_rate[j] = dot(tangent, rate);
        }
    }

    #[inline(always)]
    fn place_bends(&mut self, c: &Context<T>) {
        let n = c.edges;
        let mut before = c.base_axis;
        let mut rate_before = T::from(0.0);
        for i in 0..=n {
            let (after, rate_after) =
                if i < n { (self.tangent[i], self.edge_rate[i]) } else { (self.body_axis, self.body_rate) };
            let half_tangent = cross(before, after) / (dot(before, after) + 1.0);
            let (angle, slope) = c.stencil.angle(half_tangent);
            self.half_tangent[i] = half_tangent;
            self.angle[i] = angle;
            self.angle_slope[i] = slope;
            self.angle_rate[i] = slope * (rate_after - rate_before);
            (before, rate_before) = (after, rate_after);
        }
        c.stencil.curvatures(&self.angle, &mut self.kappa);
        c.stencil.curvatures(&self.angle_rate, &mut self.kappa_rate);
    }

    /// From chords to the arcs over them.
    #[inline(always)]
    fn place_arcs(&mut self, c: &Context<T>) {
        for j in 0..c.edges {
            let [before, after] = c.stencil.arc(j);
            let (a, b) = (self.angle[j], self.angle[j + 1]);
            let arc = a * a * before + b * b * after + 1.0;
            let rate = (a * self.angle_rate[j] * before + b * self.angle_rate[j + 1] * after) * 2.0;
            let length = self.length[j];
            self.arc[j] = arc;
            self.arc_rate[j] = rate;
            self.stretch[j] = length * arc * c.per_rest_length - 1.0;
            self.stretch_rate[j] = (self.length_rate[j] * arc + length * rate) * c.per_rest_length;
        }
    }

    /// Takes the mean square of the curvature, `⟨κ²⟩ = Σ κ_i²/ℓ_i / Σ ℓ_i` with integrated curvatures.
    #[inline(always)]
    pub fn average(&mut self, c: &Context<T>) {
        let zero = T::from(0.0);
        let square = self.kappa.iter().zip(&c.per_voronoi).fold(zero, |sum, (k, per)| sum + *k * *k * *per);
        self.mean_square_curvature = square / c.bent_length();
    }

    /// Forgets moments, tensions and loads.
    #[inline(always)]
    pub fn clear(&mut self) {
        let zero = T::from(0.0);
        self.moment.fill(zero);
        self.tension.fill(zero);
        self.outer.fill([zero; 2]);
        self.tip = [zero; 3];
        self.acceleration = [zero; 2];
        self.decay_rate = zero;
    }

    /// Velocity of an edge's midpoint along and across it, m/s.
    #[inline(always)]
    pub fn midpoint_velocity(&self, j: usize) -> [T; 2] {
        let (start, end) = (self.velocity[j], self.velocity[j + 1]);
        let sum = [(start[0] + end[0]) * 0.5, (start[1] + end[1]) * 0.5];
        [dot(self.tangent[j], sum), cross(self.tangent[j], sum)]
    }

    /// Adds an outer force along and across edge `j`, N.
    #[inline(always)]
    pub fn add_outer_force(&mut self, j: usize, along: T, across: T) {
        let tangent = self.tangent[j];
        let normal = left(tangent);
        for k in 0..2 {
            self.outer[j][k] += tangent[k] * along + normal[k] * across;
        }
    }

    /// From the moments of the bends, the clamp's and the tensions to what resists the turning angles.
    #[inline(always)]
    pub fn resist(&mut self, c: &Context<T>, clamp_acts: bool) {
        c.stencil.moments(&self.moment, &mut self.angle_moment);
        if clamp_acts {
            c.stencil.add_clamp(&self.angle, &mut self.angle_moment);
        }
        for j in 0..c.edges {
            let [before, after] = c.stencil.arc(j);
            let pull = self.tension[j] * self.length[j] * 2.0;
            self.angle_moment[j] += self.angle[j] * pull * before;
            self.angle_moment[j + 1] += self.angle[j + 1] * pull * after;
        }
    }

    /// Bending moment that turns the edges at a bend, N m; positive where the rod is bent towards +z.
    #[inline(always)]
    pub fn bending_moment(&self, bend: usize) -> T {
        self.angle_moment[bend] * self.angle_slope[bend]
    }

    /// Difference of the bending moments at the ends of edge `j`, N m: its shear force times its length.
    #[inline(always)]
    pub fn torque(&self, j: usize) -> T {
        self.bending_moment(j) - self.bending_moment(j + 1)
    }

    /// Gradient of stored and dissipated power by the edge vector, N: tension along, shear across.
    #[inline(always)]
    pub fn edge_force(&self, j: usize) -> [T; 2] {
        let tangent = self.tangent[j];
        let normal = left(tangent);
        let pull = self.tension[j] * self.arc[j];
        let shear = self.torque(j) * self.per_length[j];
        [tangent[0] * pull + normal[0] * shear, tangent[1] * pull + normal[1] * shear]
    }

    /// Generalised forces, shape `[2N+1]`, of all that the laws have said.
    #[inline(always)]
    pub fn gather(&self, c: &Context<T>, v: &[T], force: &mut [T]) {
        let n = c.edges;
        let mut before = [T::from(0.0); 2];
        let mut outer_before = before;
        for i in 0..n {
            let after = self.edge_force(i);
            let outer = self.outer[i];
            if i > 0 {
                for k in 0..2 {
                    let dof = 2 * i - 2 + k;
                    let weight = self.acceleration[k] - self.decay_rate * v[dof];
                    let borne = self.acceleration[k] * c.weightless_mass;
                    force[dof] =
                        after[k] - before[k] + (outer[k] + outer_before[k]) * 0.5 + weight * c.node_mass
                            - borne;
                }
            }
            (before, outer_before) = (after, outer);
        }
        let last = [0, 1].map(|k| self.tip[k] - before[k] + outer_before[k] * 0.5);
        for k in 0..2 {
            let dof = 2 * n - 2 + k;
            let weight = self.acceleration[k] - self.decay_rate * v[dof];
            force[dof] = last[k] + weight * c.body.mass;
        }
        force[2 * n] = self.tip[2]
            - self.bending_moment(n)
            - cross(self.body_arm, last)
            - self.decay_rate * v[2 * n] * c.body.rotary_inertia;
    }

    /// Force on each node in W, N, shape `[N+1]`, the end body's loads at the last node: for
    /// observers.
    pub fn node_forces(&self, c: &Context<T>) -> Vec<[T; 2]> {
        let n = c.edges;
        let zero = [T::from(0.0); 2];
        let mut force = vec![zero; n + 1];
        for j in 0..n {
            let inner = self.edge_force(j);
            for k in 0..2 {
                force[j][k] += inner[k] + self.outer[j][k] * 0.5;
                force[j + 1][k] += self.outer[j][k] * 0.5 - inner[k];
            }
        }
        for i in 0..=n {
            let mass = match i {
                0 => c.node_mass * 0.5,
                i if i < n => c.node_mass,
                _ => c.body.mass,
            };
            // The mass at the last node is among the loads at the tip.
            let weightless = match i {
                0 => c.weightless_mass * 0.5,
                i if i < n => c.weightless_mass,
                _ => T::from(0.0),
            };
            for k in 0..2 {
                force[i][k] += (self.acceleration[k] - self.decay_rate * self.velocity[i][k]) * mass
                    - self.acceleration[k] * weightless;
            }
        }
        for k in 0..2 {
            force[n][k] += self.tip[k];
        }
        force
    }
}
