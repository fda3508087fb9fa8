//! Observed points: from coordinates to what a marker on the rod sees.

use models::effects::LANES;
use models::system::System;

use crate::experiment::release::Point;
use crate::forward;

/// Where an observed point stands in the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Observed {
    /// The observed tip.
    Tip,
    /// Between nodes: the cubic through four of them, which are equal shares of the rod apart, so
    /// that the error is of fourth order in the edge length.
    Between {
        /// The first of the four.
        first: usize,
        /// What each counts.
        weights: [f64; 4],
    },
}

impl Observed {
    /// A point of a rod of so many edges, three at least.
    pub fn new(point: Point, edges: usize) -> Self {
        match point {
            Point::Tip => Observed::Tip,
            Point::Along(share) => {
                let at = share.clamp(0.0, 1.0) * edges as f64;
                let first = (at as usize).saturating_sub(1).min(edges - 3);
                let s = at - first as f64;
                let weights = std::array::from_fn(|k| {
                    let others = (0..4).filter(|other| *other != k);
                    others.map(|other| (s - other as f64) / (k as f64 - other as f64)).product()
                });
                Observed::Between { first, weights }
            }
        }
    }

    /// Position, m, and velocity, m/s, in W.
    pub fn see(&self, system: &System, q: &[f64], v: &[f64]) -> ([f64; 2], [f64; 2]) {
        let Observed::Between { first, weights } = self else { return forward::tip(system, q, v) };
        let (mut position, mut velocity) = ([0.0; 2], [0.0; 2]);
        for (node, weight) in (*first..).zip(weights) {
            let (x, rate) = match node {
                0 => continue,
                node if node == system.model.edges => forward::beyond(system, 0.0, q, v),
                node => {
                    let k = 2 * node - 2;
                    ([q[k], q[k + 1]], [v[k], v[k + 1]])
                }
            };
            for axis in 0..2 {
                position[axis] += weight * x[axis];
                velocity[axis] += weight * rate[axis];
            }
        }
        (position, velocity)
    }

    /// Derivatives of the position by the `group`-th [`LANES`] watched parameters, from those of
    /// the coordinates.
    pub fn by_parameters(
        &self,
        system: &System,
        group: usize,
        q: &[f64],
        by_theta: &[[f64; LANES]],
    ) -> [[f64; LANES]; 2] {
        let Observed::Between { first, weights } = self else {
            return system.tip_by_parameters(group, system.model.tip_distance, q, by_theta);
        };
        let mut slopes = [[0.0; LANES]; 2];
        for (node, weight) in (*first..).zip(weights) {
            let of_node = match node {
                0 => continue,
                node if node == system.model.edges => system.tip_by_parameters(group, 0.0, q, by_theta),
                node => [by_theta[2 * node - 2], by_theta[2 * node - 1]],
            };
            for (slopes, of_node) in slopes.iter_mut().zip(of_node) {
                for (slope, own) in slopes.iter_mut().zip(of_node) {
                    *slope += weight * own;
                }
            }
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic in the material coordinate is interpolated exactly, at the ends as well.
    #[test]
    fn the_weights_reproduce_a_cubic() {
        let edges = 7;
        let cubic = |s: f64| 0.3 - s + 2.0 * s * s - 1.5 * s * s * s;
        for share in [0.0, 0.05, 0.31, 0.5, 0.93, 1.0] {
            let Observed::Between { first, weights } = Observed::new(Point::Along(share), edges) else {
                panic!("a point along the rod")
            };
            let sum: f64 = (0..4).map(|k| weights[k] * cubic((first + k) as f64 / edges as f64)).sum();
            assert!((sum - cubic(share)).abs() < 1e-14, "{share}: {sum}");
        }
    }
}
