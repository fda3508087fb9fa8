//! A planar beam of Hermite elements: a deliberate second formulation of the muscle, see `twin`.
//!
//! Each node has its position r and its gradient p = dr/dS, S the rest arc length; between nodes r is
//! the cubic that they define (the gradient-deficient element of the absolute nodal coordinates).
//!
//! Energy:   ½ ∫ EA e² + EI κ² dS,   e = |r'| − 1,   κ = dθ/dS = (r' × r'') / |r'|²
//! Damping:  tension β EA ė, moment β EI κ̇; force −α m v on every mass
//! Tip:      rigid bodies whose axis is the tangent t = p/|p| of the last node: centre at r + c t,
//!           angular velocity ω = (p × ṗ) / |p|²
//! Clamp:    r = 0 and p along x are exact; |p| is free.
//!
//! Angles turn by rest arc length, not by current length: the continuum that a discrete rod with
//! turning angles over rest lengths has. Source of the element: Gerstmayr and Irschik (2008), On the
//! correct representation of bending and axial deformation in the absolute nodal coordinate
//! formulation with an elastic line approach; κ there is by current length.

use super::band::Band;
use super::element::{FOUR, Real, THREE, along, cross, curvature, dot, hermite, seed, slopes_of};

/// A cantilever with rigid bodies at its end, in the plane x, z; SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Beam {
    /// Number of elements.
    pub elements: usize,
    /// Length without load, m.
    pub length: f64,
    /// Distributed mass in all, kg.
    pub mass: f64,
    /// EI, N m².
    pub bending_stiffness: f64,
    /// EA, N.
    pub axial_stiffness: f64,
    /// Strain per tension beside that of EA, which takes no part in the damping, 1/N.
    pub axial_compliance: f64,
    /// End fitting, payload.
    pub bodies: Vec<Body>,
    /// Downwards, m/s².
    pub gravity: f64,
    /// Angle of the clamp above the horizontal, rad. The coordinates are those of the clamp: x along it.
    pub incline: f64,
    /// Mass damping, 1/s.
    pub alpha: f64,
    /// Stiffness damping, s.
    pub beta: f64,
}

/// A rigid body fixed to the end of the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass beyond the end of the beam, m.
    pub center: f64,
    /// Rotary inertia about it, kg m².
    pub inertia: f64,
}

/// Coordinates that the clamp holds: x, z, and the gradient's z of node 0.
pub const CLAMPED: [usize; 3] = [0, 1, 3];

/// How velocity and acceleration follow a change of the coordinates in an implicit step.
#[derive(Clone, Copy)]
pub struct Slopes {
    /// ∂v/∂q, 1/s.
    pub velocity: f64,
    /// ∂a/∂q, 1/s².
    pub acceleration: f64,
}

impl Beam {
    /// Number of coordinates `x, z, x', z'` of the nodes, the clamped ones included.
    pub fn dof(&self) -> usize {
        4 * (self.elements + 1)
    }

    /// Length of an element, m.
    pub fn element_length(&self) -> f64 {
        self.length / self.elements as f64
    }

    /// The consistent mass matrix of the beam alone.
    pub fn mass_matrix(&self) -> Band {
        let mut mass = Band::zeros(self.dof());
        for e in 0..self.elements {
            for (xi, weight) in FOUR {
                let [shape, ..] = hermite(xi, self.element_length());
                let share = weight * self.mass / self.elements as f64;
                for (i, j, k) in (0..32).map(|m| (m / 8, m / 2 % 4, m % 2)) {
                    mass.add(4 * e + 2 * i + k, 4 * e + 2 * j + k, share * shape[i] * shape[j]);
                }
            }
        }
        mass
    }

    /// What holds a resting mass against its weight, m/s², in the coordinates of the clamp.
    pub fn lift(&self) -> [f64; 2] {
        [self.gravity * self.incline.sin(), self.gravity * self.incline.cos()]
    }

    /// [`Beam::lift`] of each coordinate: gradients have no weight.
    fn lifts(&self) -> Vec<f64> {
        let [along, across] = self.lift();
        [along, across, 0.0, 0.0].into_iter().cycle().take(self.dof()).collect()
    }

    /// Imbalance `M a + … − forces`, N and N m, of a motion; rows that the clamp holds are zero.
    pub fn imbalance(&self, mass: &Band, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let mut out = self.unheld_imbalance(mass, q, v, a);
        CLAMPED.iter().for_each(|&i| out[i] = 0.0);
        out
    }

    /// [`Beam::imbalance`], the force of the clamp left out.
    pub(super) fn unheld_imbalance(&self, mass: &Band, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let lifts = self.lifts();
        let inertia: Vec<f64> = (0..self.dof()).map(|i| a[i] + self.alpha * v[i] + lifts[i]).collect();
        let mut out = mass.apply(&inertia);
        for e in 0..self.elements {
            for (xi, weight) in THREE {
                let [_, first, second] = hermite(xi, self.element_length());
                let at = |x: &[f64]| [along(&first, &x[4 * e..]), along(&second, &x[4 * e..])];
                let force = self.strain_forces(at(q), at(v));
                for (i, k) in (0..8).map(|m| (m / 2, m % 2)) {
                    let share = first[i] * force[k] + second[i] * force[2 + k];
                    out[4 * e + 2 * i + k] += weight * self.element_length() * share;
                }
            }
        }
        let last = self.dof() - 4;
        let pairs = |x: &[f64]| [[x[last], x[last + 1]], [x[last + 2], x[last + 3]]];
        let force = self.body_forces(pairs(q), pairs(v), pairs(a));
        (0..4).for_each(|k| out[last + k] += force[k]);
        out
    }

    /// Derivative of [`Beam::imbalance`] by `q`, with `v` and `a` following by `slopes`.
    pub fn tangent(&self, mass: &Band, q: &[f64], v: &[f64], a: &[f64], slopes: Slopes) -> Band {
        let mut out = self.unheld_tangent(mass, q, v, a, slopes);
        CLAMPED.iter().for_each(|&i| out.hold(i));
        out
    }

    /// [`Beam::tangent`] without the clamp.
    pub(super) fn unheld_tangent(
        &self,
        mass: &Band,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        slopes: Slopes,
    ) -> Band {
        let mut out = mass.times(slopes.acceleration + self.alpha * slopes.velocity);
        for e in 0..self.elements {
            for (xi, weight) in THREE {
                let [_, first, second] = hermite(xi, self.element_length());
                let at = |x: &[f64]| [along(&first, &x[4 * e..]), along(&second, &x[4 * e..])];
                let force = self.strain_forces(seed(at(q), 1.0), seed(at(v), slopes.velocity));
                let by = force.map(|force| slopes_of(&force));
                out.add_element(4 * e, &[first, second], &by, weight * self.element_length());
            }
        }
        let last = self.dof() - 4;
        let pairs = |x: &[f64]| [[x[last], x[last + 1]], [x[last + 2], x[last + 3]]];
        let force = self.body_forces(
            seed(pairs(q), 1.0),
            seed(pairs(v), slopes.velocity),
            seed(pairs(a), slopes.acceleration),
        );
        for (i, by) in force.iter().map(slopes_of).enumerate() {
            (0..4).for_each(|j| out.add(last + i, last + j, by[j]));
        }
        out
    }

    /// Tension over stretch at rest as a share of EA.
    fn softness(&self) -> f64 {
        1.0 / (1.0 + self.axial_stiffness * self.axial_compliance)
    }

    /// Forces conjugate to `[r', r'']`, per rest length.
    fn strain_forces<T: Real>(&self, [p, k]: [[T; 2]; 2], [p_rate, k_rate]: [[T; 2]; 2]) -> [T; 4] {
        let length = dot(p, p).sqrt();
        let e_by_p = p.map(|p| p / length);
        let (kappa, kappa_by_p, kappa_by_k) = curvature([p, k]);
        let e_rate = dot(e_by_p, p_rate);
        let kappa_rate = dot(kappa_by_p, p_rate) + dot(kappa_by_k, k_rate);
        let tension = ((length - 1.0) * self.softness() + e_rate * self.beta) * self.axial_stiffness;
        let moment = (kappa + kappa_rate * self.beta) * self.bending_stiffness;
        let by_p = [0, 1].map(|i| tension * e_by_p[i] + moment * kappa_by_p[i]);
        [by_p[0], by_p[1], moment * kappa_by_k[0], moment * kappa_by_k[1]]
    }

    /// Inertia, weight and mass damping of the rigid bodies, conjugate to `[r, p]` of the last node.
    fn body_forces<T: Real>(
        &self,
        [_, p]: [[T; 2]; 2],
        [v, p_rate]: [[T; 2]; 2],
        [a, p_turn]: [[T; 2]; 2],
    ) -> [T; 4] {
        let length = dot(p, p).sqrt();
        let t = p.map(|p| p / length);
        let n = [-t[1], t[0]];
        let omega = dot(n, p_rate) / length;
        let omega_rate = (dot(n, p_turn) - omega * dot(t, p_rate) * 2.0) / length;
        let lift = self.lift();
        let mut out = [T::from(0.0); 4];
        for body in &self.bodies {
            let swing = (omega_rate + omega * self.alpha) * body.center;
            let inward = omega * omega * body.center;
            let force = [0, 1].map(|k| a[k] + v[k] * self.alpha + n[k] * swing - t[k] * inward + lift[k]);
            let force = force.map(|f| f * body.mass);
            let moment = (omega_rate + omega * self.alpha) * body.inertia + dot(n, force) * body.center;
            for k in 0..2 {
                out[k] += force[k];
                out[2 + k] += n[k] * moment / length;
            }
        }
        out
    }

    /// Kinetic, elastic and potential energy, J; the last is zero at the height of the clamp.
    pub fn energy(&self, mass: &Band, q: &[f64], v: &[f64]) -> [f64; 3] {
        let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut kinetic = 0.5 * product(v, &mass.apply(v));
        let mut potential = product(&self.lifts(), &mass.apply(q));
        let mut elastic = 0.0;
        for e in 0..self.elements {
            for (xi, weight) in THREE {
                let [_, first, second] = hermite(xi, self.element_length());
                let (p, k) = (along(&first, &q[4 * e..]), along(&second, &q[4 * e..]));
                let (e, (kappa, ..)) = (dot(p, p).sqrt() - 1.0, curvature([p, k]));
                let density =
                    self.softness() * self.axial_stiffness * e * e + self.bending_stiffness * kappa * kappa;
                elastic += 0.5 * weight * self.element_length() * density;
            }
        }
        let (end, end_rate) = (&q[self.dof() - 4..], &v[self.dof() - 4..]);
        let p = [end[2], end[3]];
        let omega = cross(p, [end_rate[2], end_rate[3]]) / dot(p, p);
        let t = p.map(|x| x / dot(p, p).sqrt());
        for body in &self.bodies {
            let arm = omega * body.center;
            let v = [end_rate[0] - arm * t[1], end_rate[1] + arm * t[0]];
            kinetic += 0.5 * (body.mass * dot(v, v) + body.inertia * omega * omega);
            let at = [0, 1].map(|k| end[k] + body.center * t[k]);
            potential += body.mass * dot(self.lift(), at);
        }
        [kinetic, elastic, potential]
    }

    /// Position, m, and gradient of the axis at a share of the length; past 1 it goes on along the
    /// end's tangent, as the rigid bodies do.
    pub fn axis(&self, q: &[f64], share: f64) -> [[f64; 2]; 2] {
        let at = share.min(1.0) * self.elements as f64;
        let e = (at as usize).min(self.elements - 1);
        let [shape, first, _] = hermite(at - e as f64, self.element_length());
        let (r, p) = (along(&shape, &q[4 * e..]), along(&first, &q[4 * e..]));
        let beyond = (share - 1.0).max(0.0) * self.length / dot(p, p).sqrt();
        [[0, 1].map(|k| r[k] + beyond * p[k]), p]
    }
}
