//! The cost near a point as a quadratic, and its least value within bounds: `gᵀs + sᵀA s / 2`, `low ≤ s ≤ high`.
//!
//! The least value is found by a primal active set: from zero to the minimum over the free variables, or to the first bound on the way,
//! whose variable is then held; at the minimum of a face the variable is set free that gains most. The value falls in every
//! step. Putting all that would leave the bounds onto them at once is shorter, and in a narrow valley may end above zero.
//! Source: Nocedal and Wright (2006), Numerical Optimization, section 16.5.

use nalgebra::{DMatrix, DVector};

use super::second_order::SecondOrder;
use super::{Evaluated, Search};

/// Largest damping that is tried, relative to D: a step is zero then, to all digits.
const MOST_DAMPING: f64 = 1e12;
/// Keeps the undamped system solvable where the data say nothing, relative to D.
pub const LEAST_DAMPING: f64 = 1e-12;

/// The cost near a point, as a quadratic.
pub struct Quadratic {
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

impl Quadratic {
    /// At a point that is `moved` away from where its slopes were taken. Without the terms of second order where the matrix is
    /// not positive definite with them.
    pub fn of<T>(
        at: &Evaluated<T>,
        moved: Option<&DVector<f64>>,
        second_order: &SecondOrder,
        diagonal: &DVector<f64>,
    ) -> Self {
        let hessian = &at.hessian + second_order.matrix();
        let solvable = &hessian + DMatrix::from_diagonal(&(LEAST_DAMPING * diagonal));
        match moved {
            Some(moved) if solvable.cholesky().is_some() => {
                Self { gradient: &at.gradient + second_order.matrix() * moved, hessian }
            }
            _ => Self::plain(at),
        }
    }

    /// Without the terms of second order.
    pub fn plain<T>(at: &Evaluated<T>) -> Self {
        Self { gradient: at.gradient.clone(), hessian: at.hessian.clone() }
    }

    /// The step of least damping that is no longer than the radius, as [`Quadratic::step`], and whether the radius shortens it.
    pub fn step_within(
        &self,
        radius: f64,
        x: &DVector<f64>,
        diagonal: &DVector<f64>,
        least_damping: f64,
        search: &Search,
    ) -> (DVector<f64>, f64, bool) {
        let mut damping = least_damping;
        loop {
            let (tried, decrease) = self.step(x, diagonal, damping, search, true);
            if length(&(&tried - x), diagonal) <= radius || damping > MOST_DAMPING {
                return (tried, decrease, damping > least_damping);
            }
            damping *= 2.0;
        }
    }

    /// The change of the cost by a step.
    pub fn at(&self, step: &DVector<f64>) -> f64 {
        self.gradient.dot(step) + 0.5 * step.dot(&(&self.hessian * step))
    }

    /// The point that minimises it, damped, within the bounds, and the decrease that it predicts there without damping.
    pub fn step(
        &self,
        x: &DVector<f64>,
        diagonal: &DVector<f64>,
        damping: f64,
        search: &Search,
        is_limited: bool,
    ) -> (DVector<f64>, f64) {
        let room = |k: usize| {
            let (low, high) = search.bounds[k];
            let most = if is_limited { search.longest[k] } else { f64::INFINITY };
            ((low - x[k]).max(-most), (high - x[k]).min(most))
        };
        let room: Vec<(f64, f64)> = (0..x.len()).map(room).collect();
        let damped = &self.hessian + DMatrix::from_diagonal(&(damping * diagonal));
        let s = least_within(&damped, &self.gradient, &room);
        let predicted = -self.at(&s);
        let mut tried = x + s;
        for (value, (low, high)) in tried.iter_mut().zip(&search.bounds) {
            *value = value.clamp(*low, *high);
        }
        (tried, predicted)
    }
}

/// The largest diagonal so far; a variable that does nothing counts as the weakest that does.
pub fn widen(diagonal: &mut DVector<f64>, hessian: &DMatrix<f64>) {
    for (d, h) in diagonal.iter_mut().zip(hessian.diagonal().iter()) {
        *d = d.max(*h);
    }
    let least = diagonal.iter().copied().filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() { least } else { 1.0 };
    for d in diagonal.iter_mut().filter(|d| **d <= 0.0) {
        *d = least;
    }
}

/// Length of a step in the scale of the diagonal.
pub fn length(step: &DVector<f64>, diagonal: &DVector<f64>) -> f64 {
    step.iter().zip(diagonal).map(|(step, scale)| scale * step * step).sum::<f64>().sqrt()
}

/// Steps for each variable after which to stop: round-off may set free and hold in turn.
const MOST_STEPS: usize = 4;

/// The point in the box where `gᵀs + sᵀA s / 2` is least, `A` being positive definite; zero is in the box. Where `A` is
/// not, to the last digit, the best point that was reached.
pub fn least_within(a: &DMatrix<f64>, g: &DVector<f64>, room: &[(f64, f64)]) -> DVector<f64> {
    let n = g.len();
    let mut s = DVector::zeros(n);
    let mut is_held = vec![false; n];
    for (k, held) in is_held.iter_mut().enumerate() {
        *held = leaves(room[k], 0.0, g[k]);
    }
    for _ in 0..MOST_STEPS * n {
        let free: Vec<usize> = (0..n).filter(|k| !is_held[*k]).collect();
        let slope = g + a * &s;
        let Some(factors) = a.select_rows(&free).select_columns(&free).cholesky() else { break };
        let way = factors.solve(&-slope.select_rows(&free));
        let reach = |(place, k): (usize, &usize)| {
            let (low, high) = room[*k];
            let bound = if way[place] < 0.0 { low } else { high };
            let share = if way[place] == 0.0 { f64::INFINITY } else { (bound - s[*k]) / way[place] };
            (share, *k, bound)
        };
        let first = free.iter().enumerate().map(reach).min_by(|a, b| a.0.total_cmp(&b.0));
        let blocked = first.filter(|(share, ..)| *share < 1.0);
        let share = blocked.map_or(1.0, |(share, ..)| share);
        for (place, k) in free.iter().enumerate() {
            s[*k] += share * way[place];
        }
        if let Some((_, k, bound)) = blocked {
            (s[k], is_held[k]) = (bound, true);
            continue;
        }
        let slope = g + a * &s;
        let gain = |k: &usize| slope[*k].powi(2) / a[(*k, *k)];
        let returns = (0..n).filter(|k| is_held[*k] && !leaves(room[*k], s[*k], slope[*k]));
        let Some(k) = returns.max_by(|a, b| gain(a).total_cmp(&gain(b))) else { break };
        is_held[k] = false;
    }
    s
}

/// Whether a variable at a bound would go beyond it.
fn leaves((low, high): (f64, f64), s: f64, slope: f64) -> bool {
    s <= low && slope >= 0.0 || s >= high && slope <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 6;

    /// Numbers between -1 and 1 without an order that matters.
    fn scattered(seed: usize, count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(move |k| {
            2.0 * ((((1 + seed * 97 + k) as f64) * 12.9898).sin() * 43758.5453).fract().abs() - 1.0
        })
    }

    /// At the least value no variable within the bounds has a slope, and one on them pushes outward: the conditions
    /// of Karush, Kuhn and Tucker, in narrow valleys, whose flattest way has 1e-4 of the usual curvature.
    #[test]
    fn nothing_within_the_box_is_lower() {
        let mut held = 0;
        for seed in 0..500 {
            let root = DMatrix::from_iterator(N, N, scattered(seed, N * N));
            let a = root.tr_mul(&root) + 1e-4 * DMatrix::identity(N, N);
            let g = DVector::from_iterator(N, scattered(1000 + seed, N).map(|x| 3.0 * x));
            let room: Vec<_> =
                scattered(2000 + seed, N).map(|x| (-0.5 * x.abs(), 0.5 - 0.5 * x.abs())).collect();
            let s = least_within(&a, &g, &room);
            let slope = &g + &a * &s;
            for (k, (low, high)) in room.into_iter().enumerate() {
                assert!(low <= s[k] && s[k] <= high);
                let is_held = leaves((low, high), s[k], slope[k]);
                assert!(is_held || slope[k].abs() < 1e-8, "{seed}, {k}: {} at {}", slope[k], s[k]);
                held += usize::from(is_held);
            }
        }
        assert!(held > 1000 && held < 500 * N - 200, "{held}");
    }
}
