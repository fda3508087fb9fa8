//! The least value of a convex quadratic within bounds: `gᵀs + sᵀA s / 2`, `low ≤ s ≤ high`.
//!
//! A primal active set: from zero to the minimum over the free variables, or to the first bound on the way, whose
//! variable is then held; at the minimum of a face the variable is set free that gains most. The value falls in every
//! step. Putting all that would leave the bounds onto them at once is shorter, and in a narrow valley may end above zero.
//! Source: Nocedal and Wright (2006), Numerical Optimization, section 16.5.

use nalgebra::{DMatrix, DVector};

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
