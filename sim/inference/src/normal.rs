//! The normal distribution, and random numbers.

use nalgebra::{DMatrix, SymmetricEigen};
use rand_xoshiro::rand_core::RngCore;

/// Its 97.5 % point: so many standard deviations to each side hold 95 %.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Its 95 % point.
pub const NORMAL_95_ONE_SIDED: f64 = 1.644_853_626_951_472_7;

/// Standard deviations from which on a difference is taken for one: one in 370 is larger by chance.
pub const CLEAR: f64 = 3.0;

/// A number from 0 to below 1, of 53 bits.
pub fn uniform(random: &mut impl RngCore) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// A standard normal number. Source: Box and Muller (1958).
pub fn normal(random: &mut impl RngCore) -> f64 {
    let (u, v) = (1.0 - uniform(random), uniform(random));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Takes independent standard normal numbers to ones of this covariance. It is the root of the correlations: numbers differ in
/// size by many orders, and the root of the covariance itself draws the small ones with the rounding of the large ones.
pub fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    if covariance.is_empty() {
        return covariance.clone();
    }
    let deviations = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let correlation = |a: usize, b: usize| match deviations[a] * deviations[b] {
        // Nothing is left of it, or rounding alone.
        0.0 => 0.0,
        both => (covariance[(a, b)] / both).clamp(-1.0, 1.0),
    };
    let correlations = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), correlation);
    let eigen = SymmetricEigen::new(correlations);
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    DMatrix::from_diagonal(&deviations) * &eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number that is 1e-12 of two others, which are nearly one: its variance is its own. Of no number there is no root.
    #[test]
    fn a_root_gives_small_numbers_their_own_variance() {
        let near = 1.0 - 1e-9;
        let covariance =
            DMatrix::from_row_slice(3, 3, &[1.0, near, 1e-13, near, 1.0, 1e-13, 1e-13, 1e-13, 1e-24]);
        let root = root(&covariance);
        let again = &root * root.transpose();
        assert!(
            (again[(2, 2)] / 1e-24 - 1.0).abs() < 1e-9 && (again[(0, 1)] - near).abs() < 1e-12,
            "{again}"
        );
        assert!(super::root(&DMatrix::zeros(0, 0)).is_empty());
    }
}
