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

use num_dual::{Derivative, DualNum, DualSVec64};

use super::band::Band;

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
    /// End fitting, payload.
    pub bodies: Vec<Body>,
    /// Downwards, m/s².
    pub gravity: f64,
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

/// Derivatives by four numbers.
type Dual = DualSVec64<4>;

trait Real: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

/// Gauss points and weights of the unit interval. Three for strains: with as many constraints as
/// coordinates an element that hardly stretches would lock. Four for mass: exact.
const THREE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_7, 0.173_927_422_568_726_9),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
];

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

    fn element_length(&self) -> f64 {
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

    /// Imbalance `M a + … − forces`, N and N m, of a motion; rows that the clamp holds are zero.
    pub fn imbalance(&self, mass: &Band, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let falls = |i: usize| if i % 4 == 1 { self.gravity } else { 0.0 };
        let inertia: Vec<f64> = (0..self.dof()).map(|i| a[i] + self.alpha * v[i] + falls(i)).collect();
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
        CLAMPED.iter().for_each(|&i| out[i] = 0.0);
        out
    }

    /// Derivative of [`Beam::imbalance`] by `q`, with `v` and `a` following by `slopes`.
    pub fn tangent(&self, mass: &Band, q: &[f64], v: &[f64], a: &[f64], slopes: Slopes) -> Band {
        let mut out = mass.times(slopes.acceleration + self.alpha * slopes.velocity);
        for e in 0..self.elements {
            for (xi, weight) in THREE {
                let [_, first, second] = hermite(xi, self.element_length());
                let at = |x: &[f64]| [along(&first, &x[4 * e..]), along(&second, &x[4 * e..])];
                let force = self.strain_forces(seed(at(q), 1.0), seed(at(v), slopes.velocity));
                let by = force.map(|f| slopes_of(&f));
                let scale = weight * self.element_length();
                let shape = [first, second];
                for (i, j) in (0..64).map(|m| (m / 8, m % 8)) {
                    let mut sum = 0.0;
                    for (s, r) in (0..4).map(|m| (m / 2, m % 2)) {
                        sum += shape[s][i / 2] * by[2 * s + i % 2][2 * r + j % 2] * shape[r][j / 2];
                    }
                    out.add(4 * e + i, 4 * e + j, scale * sum);
                }
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
        CLAMPED.iter().for_each(|&i| out.hold(i));
        out
    }

    /// Forces conjugate to `[r', r'']`, per rest length.
    fn strain_forces<T: Real>(&self, [p, k]: [[T; 2]; 2], [p_rate, k_rate]: [[T; 2]; 2]) -> [T; 4] {
        let square = dot(p, p);
        let length = square.sqrt();
        let kappa = cross(p, k) / square;
        let e_by_p = p.map(|p| p / length);
        let kappa_by_p = [(k[1] - kappa * p[0] * 2.0) / square, (-k[0] - kappa * p[1] * 2.0) / square];
        let kappa_by_k = [-p[1] / square, p[0] / square];
        let e_rate = dot(e_by_p, p_rate);
        let kappa_rate = dot(kappa_by_p, p_rate) + dot(kappa_by_k, k_rate);
        let tension = (length - 1.0 + e_rate * self.beta) * self.axial_stiffness;
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
        let mut out = [T::from(0.0); 4];
        for body in &self.bodies {
            let swing = (omega_rate + omega * self.alpha) * body.center;
            let inward = omega * omega * body.center;
            let mut force = [0, 1].map(|k| a[k] + v[k] * self.alpha + n[k] * swing - t[k] * inward);
            force[1] += self.gravity;
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
        let lift: Vec<f64> = (0..self.dof()).map(|i| if i % 4 == 1 { self.gravity } else { 0.0 }).collect();
        let mut potential = product(&lift, &mass.apply(q));
        let mut elastic = 0.0;
        for e in 0..self.elements {
            for (xi, weight) in THREE {
                let [_, first, second] = hermite(xi, self.element_length());
                let (p, k) = (along(&first, &q[4 * e..]), along(&second, &q[4 * e..]));
                let (e, kappa) = (dot(p, p).sqrt() - 1.0, cross(p, k) / dot(p, p));
                let density = self.axial_stiffness * e * e + self.bending_stiffness * kappa * kappa;
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
            potential += body.mass * self.gravity * (end[1] + body.center * t[1]);
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

/// Cubic Hermite functions of an element and their first and second derivatives by arc length.
fn hermite(xi: f64, length: f64) -> [[f64; 4]; 3] {
    let l = length;
    [
        [
            1.0 - xi * xi * (3.0 - 2.0 * xi),
            l * xi * (1.0 - xi).powi(2),
            xi * xi * (3.0 - 2.0 * xi),
            l * xi * xi * (xi - 1.0),
        ],
        [
            6.0 * xi * (xi - 1.0) / l,
            (1.0 - xi) * (1.0 - 3.0 * xi),
            6.0 * xi * (1.0 - xi) / l,
            xi * (3.0 * xi - 2.0),
        ],
        [
            (12.0 * xi - 6.0) / (l * l),
            (6.0 * xi - 4.0) / l,
            (6.0 - 12.0 * xi) / (l * l),
            (6.0 * xi - 2.0) / l,
        ],
    ]
}

/// A combination of an element's four pairs of coordinates.
fn along(shape: &[f64; 4], x: &[f64]) -> [f64; 2] {
    [0, 1].map(|k| (0..4).map(|i| shape[i] * x[2 * i + k]).sum())
}

fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

/// Two pairs as dual numbers, each of them changing at `rate` with its own of four parameters.
fn seed(pairs: [[f64; 2]; 2], rate: f64) -> [[Dual; 2]; 2] {
    [0, 1].map(|s| {
        [0, 1].map(|k| {
            let mut by = [0.0; 4];
            by[2 * s + k] = rate;
            Dual::new(pairs[s][k], Derivative::some(by.into()))
        })
    })
}

fn slopes_of(x: &Dual) -> [f64; 4] {
    x.eps.0.map_or([0.0; 4], |eps| eps.data.0[0])
}
