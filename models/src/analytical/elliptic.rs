//! Elliptic integrals: Carlson's symmetric forms by duplication, and the complete one of the first
//! kind by the arithmetic-geometric mean. Good to a few units in the last place.
//!
//! Duplication leaves an integral as it is and brings its arguments together fourfold a step; once
//! they agree, the integral is a power of them. Carlson stops early and closes with a series: fewer
//! steps, but coefficients that no test can see.
//!
//! Source: Carlson (1995), Numerical computation of real or complex elliptic integrals, Numerical
//! Algorithms 10, algorithms 1 and 4.

use std::f64::consts::FRAC_PI_2;

/// Spread of the arguments about their mean, relative to it, that counts as none: what it makes
/// of an integral is less than 3 spread².
const SPREAD: f64 = 3e-9;

/// `R_F(x, y, z) = 1/2 ∫₀^∞ dt / √((t+x)(t+y)(t+z))`
///
/// # Panics
/// If an argument is negative, or two are zero.
pub fn carlson_rf(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let admissible = x.min(y).min(z) >= 0.0 && (x + y).min(y + z).min(z + x) > 0.0;
    assert!(admissible, "R_F({x}, {y}, {z}) does not exist");
    loop {
        let mean = (x + y + z) / 3.0;
        if agree([x, y, z], mean) {
            return mean.sqrt().recip();
        }
        [x, y, z] = duplicated([x, y, z]);
    }
}

/// `R_D(x, y, z) = 3/2 ∫₀^∞ dt / ((t+z) √((t+x)(t+y)(t+z)))`
///
/// # Panics
/// If `x` or `y` is negative, both are zero, or `z` is not positive.
pub fn carlson_rd(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let admissible = x.min(y) >= 0.0 && x + y > 0.0 && z > 0.0;
    assert!(admissible, "R_D({x}, {y}, {z}) does not exist");
    let (mut sum, mut shrink) = (0.0, 1.0);
    loop {
        let mean = (x + y + 3.0 * z) / 5.0;
        if agree([x, y, z], mean) {
            return 3.0 * sum + shrink / (mean * mean.sqrt());
        }
        let next = duplicated([x, y, z]);
        sum += shrink / (z.sqrt() * 4.0 * next[2]);
        shrink *= 0.25;
        [x, y, z] = next;
    }
}

fn agree(arguments: [f64; 3], mean: f64) -> bool {
    arguments.iter().all(|value| (value - mean).abs() < SPREAD * mean)
}

fn duplicated([x, y, z]: [f64; 3]) -> [f64; 3] {
    let lambda = (x * y).sqrt() + (y * z).sqrt() + (z * x).sqrt();
    [x, y, z].map(|value| 0.25 * (value + lambda))
}

/// Complete elliptic integral of the first kind over the complementary modulus `k' = √(1 − k²)`:
/// `K = ∫₀^{π/2} dφ / √(1 − k² sin²φ)`.
///
/// The complement, because near `k = 1` it keeps the digits that `1 − k²` loses.
/// # Panics
/// If `complement` is not in `0 < k' <= 1`.
pub fn complete_first(complement: f64) -> f64 {
    assert!(complement > 0.0 && complement <= 1.0, "K(k' = {complement}) does not exist");
    let (mut a, mut b) = (1.0, complement);
    // The last half step leaves (a − b)² / 16 a², less than rounding.
    while a - b > 1e-8 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / (0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a / b - 1.0).abs() < tolerance, "{a} is not {b}");
    }

    /// Carlson (1995), numerical checks; printed with fourteen digits.
    #[test]
    fn published_values_come_out() {
        let tolerance = 1e-13;
        close(carlson_rf(1.0, 2.0, 0.0), 1.3110287771461, tolerance);
        close(carlson_rf(0.5, 1.0, 0.0), 1.8540746773014, tolerance);
        close(carlson_rf(2.0, 3.0, 4.0), 0.58408284167715, tolerance);
        close(carlson_rd(0.0, 2.0, 1.0), 1.7972103521034, tolerance);
        close(carlson_rd(2.0, 3.0, 4.0), 0.16510527294261, tolerance);
    }

    #[test]
    fn equal_arguments_reduce_to_powers() {
        close(carlson_rf(4.0, 4.0, 4.0), 0.5, 1e-15);
        close(carlson_rd(4.0, 4.0, 4.0), 0.125, 1e-15);
    }

    /// `K(k) = R_F(0, k'², 1)`: two roads to one number, down to where K is nearly `ln(4/k')`.
    #[test]
    fn duplication_and_mean_agree() {
        for complement in [1.0, 0.9, 0.5, 0.1, 1e-3, 1e-8] {
            close(complete_first(complement), carlson_rf(0.0, complement * complement, 1.0), 4e-15);
        }
    }
}
