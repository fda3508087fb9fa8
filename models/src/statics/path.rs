//! Steps that turn and stretch the edges instead of moving nodes along straight lines.
//!
//! Of the increment `de` of an edge, the part across turns the edge, the part along stretches it,
//! and the posture is put together again edge by edge,
//!
//! ```text
//! δθ_j = n_j·de_j / |e_j|,   δs_j = t_j·de_j / |e_j|,   e_j(α) = |e_j| (1 + α δs_j) t(θ_j + α δθ_j)
//! ```
//!
//! On this path the second derivative of the energy is the tangent stiffness plus what the curve
//! of the path does against the imbalance `G_j`, the energy's gradient by edge vector `j` (minus
//! the sum of the forces from that edge to the tip):
//!
//! ```text
//! H = K + Σ_j de_jᵀ [ (G_j·n_j)(t nᵀ + n tᵀ) − (G_j·t_j) n nᵀ ] de_j / |e_j|
//! ```
//!
//! It equals `K` at equilibrium and keeps the band. A dead load enters it as a load, not as the
//! tension that a wrong posture happens to have, and how stiff the rod is against stretch does not
//! matter.

use std::f64::consts::PI;

use crate::banded::Banded;
use crate::plane::{dot, left};
use crate::system::System;

/// Largest rotation of an edge in one step, rad.
const LARGEST_TURN: f64 = 1.0;

/// A path that leaves a posture.
#[derive(Clone, Debug)]
pub(super) struct Path {
    /// Coordinates at the share last followed, shape `[2N+1]`.
    pub q: Vec<f64>,
    /// Their derivative by the share.
    pub rate: Vec<f64>,
    /// Largest turn (rad) or stretch of the whole step.
    pub size: f64,
    tangent: Vec<[f64; 2]>,
    length: Vec<f64>,
    /// Turn and stretch of each edge.
    step: Vec<[f64; 2]>,
    body_angle: f64,
    body_axis: [f64; 2],
    body_arm: [f64; 2],
    body_turn: f64,
}

impl Path {
    pub fn new(edges: usize) -> Self {
        Self {
            q: vec![0.0; 2 * edges + 1],
            rate: vec![0.0; 2 * edges + 1],
            size: 0.0,
            tangent: vec![[0.0; 2]; edges],
            length: vec![0.0; edges],
            step: vec![[0.0; 2]; edges],
            body_angle: 0.0,
            body_axis: [0.0; 2],
            body_arm: [0.0; 2],
            body_turn: 0.0,
        }
    }

    /// Starts at the posture `q` of the system, in the direction of an increment of
    /// coordinates. Returns the share of the path after which a bend would be folded, an edge
    /// turned too far or crushed, at most 1.
    pub fn leave(&mut self, system: &System, q: &[f64], increment: &[f64]) -> f64 {
        let f = &system.assembly.fields;
        let c = &system.assembly.context;
        let n = c.edges;
        self.tangent.copy_from_slice(&f.tangent);
        self.body_axis = f.body_axis;
        self.body_arm = f.body_arm;
        self.body_angle = q[2 * n];
        self.body_turn = increment[2 * n];
        self.size = 0.0;
        let mut share = 1.0_f64;
        let mut start = [0.0; 2];
        for j in 0..n {
            let mut end = [increment[2 * j], increment[2 * j + 1]];
            if j + 1 == n {
                let swing = left(f.body_arm);
                end = [0, 1].map(|k| end[k] - swing[k] * self.body_turn);
            }
            let edge = [0, 1].map(|k| (end[k] - start[k]) * f.per_length[j]);
            start = end;
            let (turn, stretch) = (dot(left(f.tangent[j]), edge), dot(f.tangent[j], edge));
            self.length[j] = f.per_length[j].recip();
            self.step[j] = [turn, stretch];
            self.size = worse(self.size, worse(turn.abs(), stretch.abs()));
            share = share.min(0.5 / (-stretch).max(0.5)).min(LARGEST_TURN / turn.abs().max(LARGEST_TURN));
        }
        self.size = worse(self.size, self.body_turn.abs());
        let (mut axis_before, mut turn_before) = (c.base_axis, 0.0);
        for i in 0..=n {
            let (axis, turn) =
                if i < n { (f.tangent[i], self.step[i][0]) } else { (f.body_axis, self.body_turn) };
            let bend = f64::atan2(dot(left(axis_before), axis), dot(axis_before, axis)).abs();
            let room = 0.5 * (PI - bend);
            share = share.min(room / (turn - turn_before).abs().max(room));
            (axis_before, turn_before) = (axis, turn);
        }
        share
    }

    /// Goes to a share of the path, counted from its start.
    pub fn follow(&mut self, share: f64) {
        let n = self.length.len();
        let (mut at, mut rate) = ([0.0; 2], [0.0; 2]);
        for j in 0..n {
            let [turn, stretch] = self.step[j];
            let along = turned(self.tangent[j], share * turn);
            let across = left(along);
            let length = self.length[j] * (1.0 + share * stretch);
            for k in 0..2 {
                at[k] += length * along[k];
                rate[k] += self.length[j] * stretch * along[k] + length * turn * across[k];
                self.q[2 * j + k] = at[k];
                self.rate[2 * j + k] = rate[k];
            }
        }
        let arm = turned(self.body_arm, share * self.body_turn);
        let swing = left(arm);
        for k in 0..2 {
            self.q[2 * n - 2 + k] += arm[k];
            self.rate[2 * n - 2 + k] += self.body_turn * swing[k];
        }
        self.q[2 * n] = self.body_angle + share * self.body_turn;
        self.rate[2 * n] = self.body_turn;
    }
}

/// From tangent stiffness to the second derivative of the energy along paths: adds what their
/// curve does against the remaining forces `force` at the present posture of the system.
pub(super) fn add_curve(system: &System, force: &[f64], hessian: &mut Banded) {
    let f = &system.assembly.fields;
    let c = &system.assembly.context;
    let n = c.edges;
    let mut gradient = [-force[2 * n - 2], -force[2 * n - 1]];
    // `X = x_N + c d(φ)` goes along a circle.
    hessian[(2 * n, 2 * n)] -= dot(gradient, f.body_arm);
    // The last node hangs on the body: `x_N = X − c d(φ)`.
    let arm = left(f.body_arm).map(|across| -across);
    for j in (0..n).rev() {
        let (tangent, normal) = (f.tangent[j], left(f.tangent[j]));
        let along = dot(gradient, tangent) * f.per_length[j];
        let across = dot(gradient, normal) * f.per_length[j];
        // The edge vector over the coordinates that it is made of: two of the node before, two of
        // the node after, and the body's angle.
        let mut made_of: [(usize, [f64; 2]); 5] = [(0, [0.0; 2]); 5];
        let mut count = 0;
        let mut add = |at: usize, direction: [f64; 2]| {
            made_of[count] = (at, direction);
            count += 1;
        };
        add(2 * j, [1.0, 0.0]);
        add(2 * j + 1, [0.0, 1.0]);
        if j > 0 {
            add(2 * j - 2, [-1.0, 0.0]);
            add(2 * j - 1, [0.0, -1.0]);
        }
        if j + 1 == n {
            add(2 * n, arm);
        }
        for (row, a) in &made_of[..count] {
            let (a_along, a_across) = (dot(*a, tangent), dot(*a, normal));
            for (column, b) in &made_of[..count] {
                let (b_along, b_across) = (dot(*b, tangent), dot(*b, normal));
                hessian[(*row, *column)] +=
                    across * (a_along * b_across + a_across * b_along) - along * a_across * b_across;
            }
        }
        if j > 0 {
            gradient = [0, 1].map(|k| gradient[k] - force[2 * j - 2 + k]);
        }
    }
}

fn turned(axis: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    let across = left(axis);
    [0, 1].map(|k| cos * axis[k] + sin * across[k])
}

/// The larger of two, or not-a-number if one is.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Rod;
    use crate::model::{Model, ModelSpec, Scheme};

    /// A heavy rod with a body beyond its end, at a posture far from rest.
    #[test]
    fn hessian_is_the_second_derivative_along_a_path() {
        let effect = |name: &str, values: &[(&str, f64)]| {
            (name.to_owned(), values.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect())
        };
        let model = Model::new(&ModelSpec {
            nodes: 6,
            rod: Rod {
                length: 0.2,
                mass: 0.03,
                bending_stiffness: 0.008,
                axial_stiffness: 40.0,
                diameter: 0.03,
                pressure: 0.0,
            },
            base_angle: 0.1,
            release_angle: 0.0,
            release_rate: 0.0,
            scheme: Scheme::Consistent,
            tip_distance: 0.0,
            effects: vec![
                effect("pressure_volume", &[("stiffening", 0.1)]),
                effect("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.02), ("rotary_inertia", 1e-5)]),
                effect("payload", &[("mass", 0.02), ("center_of_mass", 0.03), ("offset", 0.04)]),
                effect("tip_load", &[("force_x", 0.4), ("force_z", -0.3), ("moment", 0.02)]),
            ],
            catalogue: Default::default(),
            schedule: None,
        })
        .unwrap();
        let mut system = System::new(&model);
        let wobble = |k: usize, phase: f64| ((k * k) as f64 * 0.7 + phase).sin();
        let (mut q, v) = system.assembly.straight(-0.4, 0.0);
        q.iter_mut().enumerate().for_each(|(k, q)| *q += 0.008 * wobble(k, 0.3));
        let increment: Vec<f64> = (0..model.dof()).map(|k| 0.02 * wobble(k, 1.9)).collect();
        let mut force = vec![0.0; model.dof()];
        system.linearise(0.0, &q, &v, &[], &mut force);
        system.condense(0.0);
        let mut hessian = system.stiffness().clone();
        add_curve(&system, &force, &mut hessian.band);
        let mut product = vec![0.0; model.dof()];
        hessian.multiply_add(increment.as_chunks::<1>().0, product.as_chunks_mut().0);
        let expected: f64 = product.iter().zip(&increment).map(|(a, b)| a * b).sum();
        let mut path = Path::new(model.edges);
        path.leave(&system, &q, &increment);
        let mut slope = |share: f64| {
            path.follow(share);
            system.force(0.0, &path.q, &v, &[], &mut force, &mut []);
            -force.iter().zip(&path.rate).map(|(f, rate)| f * rate).sum::<f64>()
        };
        let h = 1e-5;
        let found = (slope(h) - slope(-h)) / (2.0 * h);
        // Central differences of a step of 1e-5 keep some nine digits.
        assert!((found - expected).abs() < 1e-7 * expected.abs(), "{found} against {expected}");
    }
}
