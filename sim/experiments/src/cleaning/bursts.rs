//! Bursts of ghosts: points that agree with one another, and not with the marker before and after.
//!
//! The path is broken wherever a sample is not where the two before it lead. Of the pieces, those
//! are kept that make the longest chain in which each piece leads to the next: a burst leads nowhere.

use efam_core::quantile::quantile;

use super::distance;
use super::spurious::bend;

/// Acceleration that is always accepted, m/s²: six times gravity.
const ALWAYS_BELIEVED: f64 = 60.0;
/// Second differences that are accepted, in those below which 98 % lie: ghosts are rarer than 1 %.
const MOST_BEND: f64 = 5.0;
/// Noise that may be in a second difference, in standard deviations of a sample.
const MOST_NOISE: f64 = 15.0;
/// Gap after which a marker may be anywhere, s.
const LONG_GAP: f64 = 0.5;
/// Pieces back to which a chain may reach.
const MOST_PIECES_BACK: usize = 60;

struct Piece {
    first: usize,
    last: usize,
    samples: usize,
    /// Velocity at the first and the last sample, m/s; none of a single sample.
    velocity: Option<[[f64; 3]; 2]>,
}

/// Marks samples outside the longest chain; `sigma` is the noise of a sample, m, `step` the usual time
/// between samples, s.
pub fn find(time: &[f64], path: &[Option<[f64; 3]>], step: f64, sigma: f64) -> Vec<bool> {
    let most = bend_limit(path, step, sigma);
    let pieces = pieces(time, path, step, most);
    let mut kept = vec![false; path.len()];
    // Longest chain that ends with each piece, in samples, and the piece before.
    let mut chains: Vec<(usize, Option<usize>)> = Vec::with_capacity(pieces.len());
    for (k, piece) in pieces.iter().enumerate() {
        let before = (k.saturating_sub(MOST_PIECES_BACK)..k)
            .filter(|&j| leads(time, path, &pieces[j], piece, step, most))
            .max_by_key(|&j| chains[j].0);
        let samples = before.map_or(0, |j| chains[j].0) + piece.samples;
        chains.push((samples, before));
    }
    let mut at = (0..pieces.len()).max_by_key(|&k| chains[k].0);
    while let Some(k) = at {
        kept[pieces[k].first..=pieces[k].last].fill(true);
        at = chains[k].1;
    }
    (0..path.len()).map(|i| path[i].is_some() && !kept[i]).collect()
}

/// Largest second difference that is accepted, m.
fn bend_limit(path: &[Option<[f64; 3]>], step: f64, sigma: f64) -> f64 {
    let bends = path.windows(3).filter_map(|three| Some(bend(three[0]?, three[1]?, three[2]?)));
    let usual = quantile(bends.collect(), 0.98);
    (ALWAYS_BELIEVED * step * step).max(MOST_BEND * usual.unwrap_or(0.0)) + MOST_NOISE * sigma
}

fn pieces(time: &[f64], path: &[Option<[f64; 3]>], step: f64, most: f64) -> Vec<Piece> {
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for i in (0..path.len()).filter(|&i| path[i].is_some()) {
        let goes_on = runs.last().is_some_and(|run| {
            let last = run[run.len() - 1];
            let is_next = time[i] - time[last] < 1.5 * step;
            is_next
                && match run.len() {
                    1 => distance(at(path, i), at(path, last)) < 10.0 * most,
                    n => {
                        let (a, b) = (at(path, run[n - 2]), at(path, last));
                        let predicted = std::array::from_fn(|k| 2.0 * b[k] - a[k]);
                        distance(at(path, i), predicted) < most
                    }
                }
        });
        match runs.last_mut().filter(|_| goes_on) {
            Some(run) => run.push(i),
            None => runs.push(vec![i]),
        }
    }
    let piece = |run: Vec<usize>| {
        let (first, last) = (run[0], run[run.len() - 1]);
        let reach = (run.len() - 1).min(2);
        let rate = |a: usize, b: usize| {
            let (p, q) = (at(path, run[a]), at(path, run[b]));
            std::array::from_fn(|k| (q[k] - p[k]) / (time[run[b]] - time[run[a]]))
        };
        let velocity = (run.len() > 1).then(|| [rate(0, reach), rate(run.len() - 1 - reach, run.len() - 1)]);
        Piece { first, last, samples: run.len(), velocity }
    };
    runs.into_iter().map(piece).collect()
}

/// Whether one piece may go on as another: the straight line between has the mean of the two
/// velocities, to within what an accepted acceleration does in the time between.
fn leads(time: &[f64], path: &[Option<[f64; 3]>], a: &Piece, b: &Piece, step: f64, most: f64) -> bool {
    let gap = time[b.first] - time[a.last];
    if gap > LONG_GAP {
        return true;
    }
    let steps = gap / step;
    let (from, to) = (at(path, a.last), at(path, b.first));
    let (leaving, coming) = match (a.velocity, b.velocity) {
        (Some(a), Some(b)) => (a[1], b[0]),
        (Some(a), None) => (a[1], a[1]),
        (None, Some(b)) => (b[0], b[0]),
        (None, None) => return distance(from, to) < 3.0 * most * steps,
    };
    let expected = std::array::from_fn(|k| from[k] + 0.5 * (leaving[k] + coming[k]) * gap);
    distance(to, expected) < most * (1.0 + 0.25 * steps * steps)
}

fn at(path: &[Option<[f64; 3]>], i: usize) -> [f64; 3] {
    path[i].unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::tests::{Noise, falling_swing};

    #[test]
    fn bursts_are_found_and_gaps_and_the_release_are_not() {
        let mut noise = Noise::new(5);
        let (time, mut path) = falling_swing(1.23, 6.0, 0.2, 8.0, 0.01);
        noise.disturb(&mut path, 2e-4);
        path[200..230].fill(None);
        assert!(!find(&time, &path, 0.01, 2e-4).contains(&true));
        let burst = 400..412;
        for point in path[burst.clone()].iter_mut().flatten() {
            point[0] += 0.08;
            point[2] -= 0.05;
        }
        let marked = find(&time, &path, 0.01, 2e-4);
        let found: Vec<usize> = (0..path.len()).filter(|&i| marked[i]).collect();
        assert!(burst.clone().all(|i| found.contains(&i)), "{found:?}");
        assert!(found.len() <= burst.len() + 2, "{found:?}");
    }
}
