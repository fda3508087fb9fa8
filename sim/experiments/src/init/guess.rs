//! Which markers of a recording are its tip, its base and its body, by how far they move.

use efam_core::quantile::quantile;
use efam_recordings::Recording;

use crate::cleaning::distance;

/// Motion of base markers in that of the most moving one, at most.
const STILL: f64 = 0.04;
/// The same of markers that are named like a base.
const STILL_BY_NAME: f64 = 0.25;
/// Names of markers that do not move.
const BASES: [&str; 6] = ["base", "clamp", "root", "ground", "fixed", "wall"];
/// Motion of tip markers, likewise, at least.
const TIP: f64 = 0.8;
/// By how much the distance of two markers of one body may vary, in the motion of the tip.
const RIGID: f64 = 0.1;

/// What the markers of a recording seem to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// Most moving, and as one body.
    pub tip: Vec<String>,
    /// Least moving.
    pub base: Vec<String>,
    /// All between, with their share of the way from base to tip.
    pub body: Vec<(String, f64)>,
    /// How far each marker moves, m, in the order of the recording.
    pub moves: Vec<(String, f64)>,
}

/// Tells tip, base and body by how much they move; nothing if no marker is seen.
pub fn guess(recording: &Recording) -> Option<Guess> {
    let moves: Vec<f64> = recording.markers.iter().map(|marker| reach(&marker.position)).collect();
    let most =
        (0..moves.len()).max_by(|&a, &b| moves[a].total_cmp(&moves[b])).filter(|&k| moves[k] >= 0.0)?;
    let path = |k: usize| &recording.markers[k].position;
    let of_tip = |k: usize| {
        k == most || (moves[k] > TIP * moves[most] && spread(path(k), path(most)) < RIGID * moves[most])
    };
    let is_tip: Vec<bool> = (0..moves.len()).map(of_tip).collect();
    let is_base = |k: usize| {
        let name = recording.markers[k].name.to_lowercase();
        let limit = if BASES.iter().any(|base| name.contains(base)) { STILL_BY_NAME } else { STILL };
        !is_tip[k] && moves[k] >= 0.0 && moves[k] < limit * moves[most]
    };
    let is_base: Vec<bool> = (0..moves.len()).map(is_base).collect();
    let those = |is: &[bool]| -> Vec<usize> { (0..moves.len()).filter(|&k| is[k]).collect() };
    let (tip, base) = (those(&is_tip), those(&is_base));
    let place = |of: &[usize]| -> [f64; 3] {
        let first: Vec<[f64; 3]> =
            of.iter().filter_map(|&k| path(k).iter().flatten().next().copied()).collect();
        std::array::from_fn(|c| first.iter().map(|at| at[c]).sum::<f64>() / first.len().max(1) as f64)
    };
    let (from, to) = (place(&base), place(&tip));
    let share = |k: usize| (distance(place(&[k]), from) / distance(to, from).max(1e-9)).clamp(0.0, 1.0);
    let is_body = |k: &usize| moves[*k] >= 0.0 && !is_tip[*k] && !is_base[*k];
    let mut body: Vec<(usize, f64)> = (0..moves.len()).filter(is_body).map(|k| (k, share(k))).collect();
    body.sort_by(|a, b| a.1.total_cmp(&b.1));
    let name = |k: usize| recording.markers[k].name.clone();
    Some(Guess {
        tip: tip.iter().map(|&k| name(k)).collect(),
        base: base.iter().map(|&k| name(k)).collect(),
        body: body.into_iter().map(|(k, share)| (name(k), share)).collect(),
        moves: (0..moves.len()).map(|k| (name(k), moves[k])).collect(),
    })
}

/// Distance from its median place within which a marker is 98 % of the time, m; −1 if it is never seen.
fn reach(path: &[Option<[f64; 3]>]) -> f64 {
    let seen = || path.iter().flatten();
    let middle = std::array::from_fn(|c| quantile(seen().map(|at| at[c]).collect(), 0.5).unwrap_or_default());
    quantile(seen().map(|at| distance(*at, middle)).collect(), 0.98).unwrap_or(-1.0)
}

/// By how much the distance of two markers varies, 96 % of the time, m.
fn spread(a: &[Option<[f64; 3]>], b: &[Option<[f64; 3]>]) -> f64 {
    let both = a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
    let apart: Vec<f64> = both.map(|(a, b)| distance(a, b)).collect();
    let between = quantile(apart.clone(), 0.98).zip(quantile(apart, 0.02));
    between.map_or(f64::INFINITY, |(high, low)| high - low)
}
