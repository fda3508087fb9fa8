//! How well a fit knows its unknowns.
//!
//! The covariance is `H⁻¹ S H⁻¹`: H the curvature of the cost, S the covariance of its gradient, from the
//! noise that the residuals show and from how they follow one another (`autocorrelation.rs`). For
//! white noise as large as stated this is `H⁻¹`.
//! Source: Huber (1967), Proc. Fifth Berkeley Symposium 1, 221-233.

use efam_core::loss::Huber;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::autocorrelation::Autocovariance;
use super::objective::{Objective, add_at};
use super::search::Found;
use super::view::Series;

/// What a fit knows of its scaled unknowns, and what its residuals look like.
#[derive(Clone, Debug)]
pub(crate) struct Uncertainty {
    /// Covariance of the scaled unknowns; meaningless for those that are not determined.
    pub covariance: DMatrix<f64>,
    /// The same if the noise were white and as large as stated.
    pub plain: DMatrix<f64>,
    /// Whether the data and priors determine the unknown at all.
    pub is_determined: Vec<bool>,
    /// Statistics of the residuals, shape `[release][track]`.
    pub tracks: Vec<Vec<TrackStatistics>>,
}

impl Uncertainty {
    /// Variance of an unknown over what it would be if the noise were white and as large as stated.
    pub fn variance_inflation(&self, unknown: usize) -> f64 {
        self.covariance[(unknown, unknown)] / self.plain[(unknown, unknown)]
    }
}

/// Residuals of one track.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TrackStatistics {
    /// Samples fitted.
    pub samples: usize,
    /// Of these, how many the robust loss holds back.
    pub held_back: usize,
    /// Standard deviation of a coordinate, m, without what is held back.
    pub noise: f64,
    /// Root mean square distance, m, likewise.
    pub rms: f64,
    /// Variance over that of the stated noise.
    pub reduced_chi_squared: f64,
    /// Autocorrelation at one sample.
    pub autocorrelation: f64,
}

/// Curvature in units of the diagonal below which a direction counts as not determined: noise of
/// the slopes is some 1e-5 of them.
const FLAT: f64 = 1e-10;
/// Share of an unknown in such directions from which on it is not determined itself.
const SHARE: f64 = 1e-3;

pub(crate) fn uncertainty(objective: &Objective, found: &Found) -> Uncertainty {
    let hessian = &found.at.hessian;
    let (inverse, is_determined) = pseudo_inverse(hessian);
    let blocks = &found.at.carried.blocks;
    let lost = |r: usize| objective.part.locals[r].len() as f64 / blocks[r].len() as f64;
    let (spread, tracks) = spread(objective, found, blocks, 0, &lost);
    let covariance = &inverse * spread * &inverse;
    Uncertainty { covariance, plain: inverse, is_determined, tracks }
}

/// Covariance of the gradient, as the residuals in `blocks` follow one another, and what they look like;
/// `columns` as in [`Objective::normal_equations`]. `lost` are the degrees of freedom that each track of a
/// release has given away.
pub(crate) fn spread(
    objective: &Objective,
    found: &Found,
    blocks: &[Vec<Series>],
    columns: usize,
    lost: &dyn Fn(usize) -> f64,
) -> (DMatrix<f64>, Vec<Vec<TrackStatistics>>) {
    let size = found.x.len() + columns;
    let mut spread = DMatrix::zeros(size, size);
    let mut tracks = Vec::new();
    for (r, block) in blocks.iter().enumerate() {
        let (places, measured) = (objective.places(r, columns), &objective.measured[r]);
        let mut own = DMatrix::zeros(places.len(), places.len());
        let mut of_release = Vec::new();
        for (t, series) in block.iter().enumerate() {
            let samples: Vec<usize> = series.samples.iter().map(|k| measured.samples[*k]).collect();
            let (loss, noise) = (found.view.loss[r], measured.noise[t]);
            // Noise that includes pure error is given, and a fit that absorbs some has not reduced it.
            let is_told = noise > measured.camera_noise[t];
            let least = if is_told { 1.0 } else { 0.0 };
            let mut statistics = add_series(series, &samples, loss, lost(r), noise, least, &mut own);
            statistics.reduced_chi_squared *= (noise / measured.camera_noise[t]).powi(2);
            of_release.push(statistics);
        }
        tracks.push(of_release);
        add_at(&places, &own, &mut spread);
    }
    for (k, _, slope) in objective.prior_residuals(&found.x) {
        spread[(k, k)] += slope * slope;
    }
    (spread, tracks)
}

/// Adds what one track's noise does to the gradient; says what its residuals look like. `samples` are
/// their places in the recording, gaps included. The variance of the residuals counts as `least` at least.
fn add_series(
    series: &Series,
    samples: &[usize],
    loss: Huber,
    lost: f64,
    noise: f64,
    least: f64,
    spread: &mut DMatrix<f64>,
) -> TrackStatistics {
    let count = series.residual.len();
    let first = samples.first().copied().unwrap_or(0);
    let last = samples.last().map_or(0, |last| last + 1 - first);
    let mut grid: Vec<Option<[f64; 2]>> = vec![None; last];
    let mut place = vec![usize::MAX; last];
    let (mut sum, mut held_back) = (0.0, 0);
    for (k, (sample, residual)) in samples.iter().zip(&series.residual).enumerate() {
        let weight = loss.weight(residual[0].hypot(residual[1]));
        let counted = residual.map(|r| weight * r);
        held_back += usize::from(weight < 1.0);
        sum += counted[0] * counted[0] + counted[1] * counted[1];
        grid[sample - first] = Some(counted);
        place[sample - first] = k;
    }
    // Degrees of freedom that the unknowns have taken.
    let left = (2.0 * count as f64 - lost).max(1.0);
    let variance = sum / left;
    let found = Autocovariance::of(&grid);
    let by_lag = match found.by_lag[0] {
        _ if variance < least => vec![least],
        own if own > 0.0 => found.by_lag.iter().map(|value| value * variance / own).collect(),
        _ => found.by_lag.clone(),
    };
    // Σ c(lag) a_k a_{k+lag}ᵀ, each sample's partners summed first.
    let width = series.slopes.first().map_or(0, Vec::len);
    let mut partners = vec![[0.0; 2]; width];
    for sample in (0..last).filter(|sample| place[*sample] != usize::MAX) {
        partners.fill([0.0; 2]);
        for (lag, value) in by_lag.iter().take(last - sample).enumerate() {
            let other = place[sample + lag];
            if other == usize::MAX {
                continue;
            }
            let value = if lag == 0 { 0.5 * value } else { *value };
            for (sum, slope) in partners.iter_mut().zip(&series.slopes[other]) {
                sum[0] += value * slope[0];
                sum[1] += value * slope[1];
            }
        }
        add_product(&series.slopes[place[sample]], &partners, spread);
    }
    TrackStatistics {
        samples: count,
        held_back,
        noise: noise * variance.sqrt(),
        rms: noise * (sum / (count.max(1)) as f64).sqrt(),
        reduced_chi_squared: variance,
        autocorrelation: found.next,
    }
}

/// Adds `a bᵀ + b aᵀ`, both axes.
fn add_product(a: &[[f64; 2]], b: &[[f64; 2]], sum: &mut DMatrix<f64>) {
    for i in 0..a.len() {
        for j in 0..b.len() {
            let product = a[i][0] * b[j][0] + a[i][1] * b[j][1];
            sum[(i, j)] += product;
            sum[(j, i)] += product;
        }
    }
}

/// Inverse over the directions that are determined, and which unknowns these hold.
pub(crate) fn pseudo_inverse(hessian: &DMatrix<f64>) -> (DMatrix<f64>, Vec<bool>) {
    let n = hessian.nrows();
    if n == 0 {
        return (DMatrix::zeros(0, 0), Vec::new());
    }
    let size = DVector::from_fn(n, |k, _| match hessian[(k, k)] {
        h if h > 0.0 => h.sqrt(),
        _ => 0.0,
    });
    let unit = |k: usize| if size[k] > 0.0 { size[k].recip() } else { 0.0 };
    let scaled = DMatrix::from_fn(n, n, |a, b| hessian[(a, b)] * unit(a) * unit(b));
    let eigen = SymmetricEigen::new(scaled);
    let most = eigen.eigenvalues.amax();
    let mut per_value = eigen.eigenvectors.clone();
    let mut flat_share = vec![0.0; n];
    for (value, mut vector) in eigen.eigenvalues.iter().zip(per_value.column_iter_mut()) {
        if *value > FLAT * most {
            vector /= *value;
        } else {
            flat_share.iter_mut().zip(vector.iter()).for_each(|(share, v)| *share += v * v);
            vector.fill(0.0);
        }
    }
    let inverse = per_value * eigen.eigenvectors.transpose();
    let inverse = DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * unit(a) * unit(b));
    let is_determined = (0..n).map(|k| size[k] > 0.0 && flat_share[k] < SHARE).collect();
    (inverse, is_determined)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_without_curvature_is_not_determined() {
        // Only the sum of the first two is known; the fourth not at all.
        #[rustfmt::skip]
        let hessian = DMatrix::from_row_slice(4, 4, &[
            4.0, 4.0, 0.0, 0.0,
            4.0, 4.0, 0.0, 0.0,
            0.0, 0.0, 9.0, 0.0,
            0.0, 0.0, 0.0, 0.0,
        ]);
        let (inverse, is_determined) = pseudo_inverse(&hessian);
        assert_eq!(is_determined, [false, false, true, false]);
        assert!((inverse[(2, 2)] - 1.0 / 9.0).abs() < 1e-15);
    }
}
