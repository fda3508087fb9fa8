//! Which samples of a release take part, and the axes in which they are seen.

use efam_experiments::release::Release;
use nalgebra::{Matrix2, SymmetricEigen};

/// Samples of a leading track that another track must have, as a share, to take part.
const SEEN: f64 = 0.8;
/// Samples without which a release has no features.
const LEAST_SAMPLES: usize = 24;

/// Tracks and samples after the release that all of them have; the leading track first.
pub fn seen(release: &Release, leading: usize) -> Option<(Vec<usize>, Vec<usize>)> {
    let has = |track: usize, k: usize| {
        release.tracks[track].position[k].is_some_and(|[x, z]| x.is_finite() && z.is_finite())
    };
    let after = |k: &usize| release.time[*k] >= 0.0;
    release.tracks.get(leading)?;
    let all: Vec<usize> = (0..release.time.len()).filter(after).filter(|k| has(leading, *k)).collect();
    let is_seen = |track: &usize| {
        let count = all.iter().filter(|k| has(*track, **k)).count();
        count as f64 >= SEEN * all.len() as f64
    };
    let others = (0..release.tracks.len()).filter(|track| *track != leading).filter(is_seen);
    let tracks: Vec<usize> = std::iter::once(leading).chain(others).collect();
    let samples: Vec<usize> =
        all.into_iter().filter(|k| tracks.iter().all(|track| has(*track, *k))).collect();
    (samples.len() >= LEAST_SAMPLES).then_some((tracks, samples))
}

/// First principal axis of a path, its largest component positive, and the axis a quarter turn on.
pub fn axes(path: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let n = path.len().max(1) as f64;
    let mean = [0, 1].map(|axis| path.iter().map(|at| at[axis]).sum::<f64>() / n);
    let mut spread = Matrix2::zeros();
    for at in path {
        let from = nalgebra::Vector2::new(at[0] - mean[0], at[1] - mean[1]);
        spread += from * from.transpose();
    }
    let eigen = SymmetricEigen::new(spread);
    let first = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let [mut x, mut z] = [first[0], first[1]];
    let largest = if x.abs() >= z.abs() { x } else { z };
    if largest < 0.0 {
        [x, z] = [-x, -z];
    }
    [[x, z], [-z, x]]
}

/// Coordinates q and p of each marker, shape `[coordinate][sample]`, m.
pub fn turned(
    axes: &[[f64; 2]; 2],
    markers: usize,
    samples: usize,
    position: impl Fn(usize, usize) -> [f64; 2],
) -> Vec<Vec<f64>> {
    let coordinate = |c: usize| {
        let [x, z] = axes[c % 2];
        let of = |k: usize| {
            let at = position(c / 2, k);
            at[0] * x + at[1] * z
        };
        (0..samples).map(of).collect()
    };
    (0..2 * markers).map(coordinate).collect()
}

/// Largest less smallest.
pub fn range(q: &[f64]) -> f64 {
    let (low, high) =
        q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(*q), high.max(*q)));
    high - low
}
