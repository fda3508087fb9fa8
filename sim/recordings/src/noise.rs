//! Noise of a marker: what no motion explains from one sample to the next.
//!
//! Third differences of four samples in a row see no constant, no straight motion and no steady
//! acceleration; of white noise their variance is 20 times that of a sample. The median of their sizes
//! counts, so that ghosts and a few fast swings do not.

use efam_core::quantile::quantile;

/// Standard deviation of a normal number over the median of its size.
const OF_MEDIAN: f64 = 1.482_602;

/// Variance of the noise of each coordinate, m², by the third differences whose first of four samples is
/// admitted; nothing of fewer than `least`.
pub fn variances<const N: usize>(
    path: &[Option<[f64; N]>],
    least: usize,
    admits: impl Fn(usize) -> bool,
) -> Option<[f64; N]> {
    let mut differences: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for (i, four) in path.windows(4).enumerate() {
        let [Some(a), Some(b), Some(c), Some(d)] = four else { continue };
        if admits(i) {
            for k in 0..N {
                differences[k].push((d[k] - 3.0 * c[k] + 3.0 * b[k] - a[k]).abs());
            }
        }
    }
    if differences[0].len() < least {
        return None;
    }
    let variance = |sizes| quantile(sizes, 0.5).map_or(0.0, |median| (OF_MEDIAN * median).powi(2) / 20.0);
    Some(differences.map(variance))
}
