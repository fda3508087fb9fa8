//! A posture by its nodes: what a recording, a file or another model can give.

use crate::assembly::Assembly;
use crate::context::Context;
use crate::effects::{Place, Real, Release, Scalar};
use crate::model::{Active, Model, RELEASE_ANGLE, RELEASE_RATE};
use crate::plane::left;

/// Nodes and end body of a rod, in W.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture<T> {
    /// Node positions, m, shape `[N+1]`; the first is the origin.
    pub nodes: Vec<[T; 2]>,
    /// Node velocities, m/s, shape `[N+1]`.
    pub velocities: Vec<[T; 2]>,
    /// Angle of the end body, rad, from x towards z.
    pub angle: T,
    /// Its rate, rad/s.
    pub rate: T,
}

impl<T: Copy> Posture<T> {
    /// The same posture over another scalar.
    pub fn map<U>(self, f: impl Fn(T) -> U + Copy) -> Posture<U> {
        Posture {
            nodes: self.nodes.into_iter().map(|x| x.map(f)).collect(),
            velocities: self.velocities.into_iter().map(|v| v.map(f)).collect(),
            angle: f(self.angle),
            rate: f(self.rate),
        }
    }
}

impl<T: Real> Posture<T> {
    /// The same posture turned about the clamp, with an angular velocity about it on top.
    pub fn turned(self, by: Release<T>) -> Self {
        let (sin, cos) = by.angle.sin_cos();
        let turn = |[x, z]: [T; 2]| [cos * x - sin * z, sin * x + cos * z];
        let nodes: Vec<_> = self.nodes.into_iter().map(turn).collect();
        let swing = |(velocity, node): ([T; 2], &[T; 2])| {
            let (along, across) = (turn(velocity), left(*node));
            [0, 1].map(|k| along[k] + across[k] * by.angular_velocity)
        };
        Self {
            velocities: self.velocities.into_iter().zip(&nodes).map(swing).collect(),
            nodes,
            angle: self.angle + by.angle,
            rate: self.rate + by.angular_velocity,
        }
    }

    /// The straight rod at an angle, turning about the clamp.
    pub fn straight(edges: usize, rest_length: T, angle: T, rate: T) -> Self {
        let axis = [angle.cos(), angle.sin()];
        let across = left(axis);
        let along = |i: usize| rest_length * i as f64;
        Self {
            nodes: (0..=edges).map(|i| axis.map(|a| a * along(i))).collect(),
            velocities: (0..=edges).map(|i| across.map(|a| a * along(i) * rate)).collect(),
            angle,
            rate,
        }
    }
}

impl Posture<f64> {
    /// The same posture on another mesh: by the cubics through four nodes each, to fourth order in the edge length.
    pub fn resampled(&self, edges: usize) -> Self {
        let own = self.nodes.len() - 1;
        let of = |values: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let at = |i: usize| Between::of(i as f64 / edges as f64, own).of_nodes(|node| values[node]);
            (0..=edges).map(at).collect()
        };
        Self { nodes: of(&self.nodes), velocities: of(&self.velocities), angle: self.angle, rate: self.rate }
    }

    /// The posture of a curve through the clamp, sampled at `edges + 1` nodes in equal shares of its
    /// length; the end body continues the last piece.
    pub fn along(curve: &[[f64; 2]], velocities: &[[f64; 2]], edges: usize) -> Self {
        let pieces: Vec<f64> =
            curve.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).collect();
        let length: f64 = pieces.iter().sum();
        let mut nodes = Vec::with_capacity(edges + 1);
        let mut rates = Vec::with_capacity(edges + 1);
        let (mut piece, mut before) = (0, 0.0);
        for i in 0..=edges {
            let at = length * i as f64 / edges as f64;
            while piece + 1 < pieces.len() && before + pieces[piece] < at {
                before += pieces[piece];
                piece += 1;
            }
            let share = if pieces[piece] > 0.0 { ((at - before) / pieces[piece]).min(1.0) } else { 0.0 };
            let between =
                |of: &[[f64; 2]]| [0, 1].map(|k| of[piece][k] + share * (of[piece + 1][k] - of[piece][k]));
            nodes.push(between(curve));
            rates.push(between(velocities));
        }
        let edge = [0, 1].map(|k| nodes[edges][k] - nodes[edges - 1][k]);
        let turn = [0, 1].map(|k| rates[edges][k] - rates[edges - 1][k]);
        let square = edge[0] * edge[0] + edge[1] * edge[1];
        Self {
            nodes,
            velocities: rates,
            angle: edge[1].atan2(edge[0]),
            rate: (edge[0] * turn[1] - edge[1] * turn[0]) / square,
        }
    }
}

/// A place between nodes: the cubic through four of them, which are equal shares of the rod apart, so
/// that the error is of fourth order in the edge length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The first of the four.
    pub first: usize,
    /// What each counts.
    pub weights: [f64; 4],
    /// What each counts in the derivative along the rod, over nodes.
    pub slopes: [f64; 4],
}

impl Between {
    /// A place along a rod of so many edges, three at least, from 0 at the clamp to 1 at the end.
    pub fn of(share: f64, edges: usize) -> Self {
        let at = share.clamp(0.0, 1.0) * edges as f64;
        let first = (at as usize).saturating_sub(1).min(edges - 3);
        let s = at - first as f64;
        let others = |k: usize| (0..4).filter(move |other| *other != k);
        let weights = std::array::from_fn(|k| {
            others(k).map(|other| (s - other as f64) / (k as f64 - other as f64)).product()
        });
        let slopes = std::array::from_fn(|k| {
            let without = |left_out: usize| -> f64 {
                let factor = |other: usize| {
                    let distance = k as f64 - other as f64;
                    if other == left_out { 1.0 / distance } else { (s - other as f64) / distance }
                };
                others(k).map(factor).product()
            };
            others(k).map(without).sum()
        });
        Self { first, weights, slopes }
    }

    /// The value there of what the nodes have.
    pub fn of_nodes(&self, value: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (node, weight) in (self.first..).zip(self.weights) {
            let [x, z] = value(node);
            sum = [sum[0] + weight * x, sum[1] + weight * z];
        }
        sum
    }
}

impl<T: Scalar> Assembly<T> {
    /// Generalised coordinates and velocities of a posture, shape `[2N+1]`.
    pub fn coordinates(&self, posture: &Posture<T>) -> (Vec<T>, Vec<T>) {
        let n = self.context.edges;
        let arm = self.context.body.arm([posture.angle.cos(), posture.angle.sin()]);
        let swing = left(arm);
        let mut q = posture.nodes[1..n].as_flattened().to_vec();
        let mut v = posture.velocities[1..n].as_flattened().to_vec();
        for k in 0..2 {
            q.push(posture.nodes[n][k] + arm[k]);
            v.push(posture.velocities[n][k] + swing[k] * posture.rate);
        }
        q.push(posture.angle);
        v.push(posture.rate);
        (q, v)
    }

    /// The posture of generalised coordinates and velocities.
    pub fn posture(&mut self, q: &[T], v: &[T]) -> Posture<T> {
        self.fields.place(&self.context, q, v);
        let n = self.context.edges;
        Posture {
            nodes: self.fields.position.clone(),
            velocities: self.fields.velocity.clone(),
            angle: q[2 * n],
            rate: v[2 * n],
        }
    }

    /// Coordinates and velocities with which the rod is let go from a posture: turned and set in
    /// motion by the effects that act on the release.
    pub fn let_go(&self, model: &Model, posture: Posture<T>) -> (Vec<T>, Vec<T>) {
        let at_release = |posture: Posture<T>, active: &Active| {
            let theta = &self.context.theta[active.theta.clone()];
            posture.turned(T::laws(active.effect).release(theta))
        };
        let acting =
            model.effects.iter().filter(|active| active.effect.about().places.contains(&Place::Release));
        self.coordinates(&acting.fold(posture, at_release))
    }

    /// The straight rod at the model's release angle and rate.
    pub fn straight_at_release(&self) -> Posture<T> {
        let Context { edges, rest_length, theta, .. } = &self.context;
        Posture::straight(*edges, *rest_length, theta[RELEASE_ANGLE], theta[RELEASE_RATE])
    }

    /// Coordinates and velocities of the straight rod at an angle, turning about the clamp.
    pub fn straight(&self, angle: T, rate: T) -> (Vec<T>, Vec<T>) {
        let context = &self.context;
        self.coordinates(&Posture::straight(context.edges, context.rest_length, angle, rate))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic in the material coordinate is interpolated exactly, at the ends as well, and so is its
    /// derivative.
    #[test]
    fn the_weights_reproduce_a_cubic() {
        let edges = 7;
        let cubic = |s: f64| 0.3 - s + 2.0 * s * s - 1.5 * s * s * s;
        let slope = |s: f64| -1.0 + 4.0 * s - 4.5 * s * s;
        for share in [0.0, 0.05, 0.31, 0.5, 0.93, 1.0] {
            let Between { first, weights, slopes } = Between::of(share, edges);
            let sum = |weights: [f64; 4]| -> f64 {
                (0..4).map(|k| weights[k] * cubic((first + k) as f64 / edges as f64)).sum()
            };
            assert!((sum(weights) - cubic(share)).abs() < 1e-14, "{share}: {}", sum(weights));
            let along = sum(slopes) * edges as f64;
            assert!((along - slope(share)).abs() < 1e-13, "{share}: {along}");
        }
    }

    /// Turned and set in motion, the straight rod is the straight rod at the sums.
    #[test]
    fn a_turned_straight_rod_is_straight() {
        let start: Posture<f64> = Posture::straight(5, 0.1, 0.3, -0.7);
        let found = start.turned(Release { angle: 0.4, angular_velocity: 1.5 });
        let due = Posture::straight(5, 0.1, 0.3 + 0.4, -0.7 + 1.5);
        assert_eq!((found.angle, found.rate), (due.angle, due.rate));
        let pairs = found.nodes.iter().zip(&due.nodes).chain(found.velocities.iter().zip(&due.velocities));
        for (found, due) in pairs {
            assert!((found[0] - due[0]).hypot(found[1] - due[1]) < 1e-15, "{found:?}, due {due:?}");
        }
    }
}
