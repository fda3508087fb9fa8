//! Slow wander of base and camera, which each release has for itself.
//!
//! A random walk less its mean is a sum of cosines of k half cycles over the record, whose variances fall as 1/k². Those of four
//! cycles of the swing and longer count as wander: what is faster is seen as noise at the end of the record. U and S are the left
//! singular vectors and values of the cosines, each times its deviation: parts `Uᵀd` of residuals d have the variances S² by wander.
//! Source: Shorack and Wellner (1986), Empirical Processes with Applications to Statistics, chapter 5, for the expansion.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Noise;
use crate::normal::normal;

/// Root mean square wander over a record, over the deviation of the noise. A laboratory that sees a tenth of a millimetre has a stiffer
/// table than one that sees a whole one.
const WANDER: f64 = 0.5;
/// Cycles of the swing in the fastest cosine.
const CYCLES: f64 = 4.0;
/// Cosines at most: those beyond have a hundredth of the variance.
const MOST: usize = 8;

/// Wander of the coordinates of a release at its samples.
#[derive(Clone, Debug, Default)]
pub struct Wander {
    /// Left singular vectors, shape `[samples, cosines]`, and singular values, m.
    modes: DMatrix<f64>,
    sizes: DVector<f64>,
}

impl Wander {
    /// Of a swing with a frequency, Hz, that is sampled at times, beside noise.
    pub fn of(time: &[f64], frequency: f64, noise: &Noise) -> Self {
        let duration = time[time.len() - 1] - time[0];
        let cosines = ((2.0 * frequency * duration / CYCLES) as usize).clamp(1, MOST);
        let deviation = |k: usize| WANDER * noise.deviation * 12f64.sqrt() / (PI * k as f64);
        let cosine = |i: usize, column: usize| {
            let k = column + 1;
            deviation(k) * (PI * k as f64 * (time[i] - time[0]) / duration).cos()
        };
        let svd = DMatrix::from_fn(time.len(), cosines, cosine).svd(true, false);
        Self { modes: svd.u.unwrap_or_default(), sizes: svd.singular_values }
    }

    /// Parts of residuals, or of their slopes: coordinate after coordinate in each column, shape `[coordinates · cosines, columns]`.
    pub fn parts(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let (samples, cosines) = self.modes.shape();
        let coordinates = columns.nrows().checked_div(samples).unwrap_or(0);
        let mut parts = DMatrix::zeros(coordinates * cosines, columns.ncols());
        for c in 0..coordinates {
            let own = self.modes.tr_mul(&columns.rows(c * samples, samples));
            parts.rows_mut(c * cosines, cosines).copy_from(&own);
        }
        parts
    }

    /// Variances of as many parts, m².
    pub fn variances(&self, parts: usize) -> DVector<f64> {
        DVector::from_fn(parts, |k, _| self.sizes[k % self.sizes.len()].powi(2))
    }

    /// Adds a drawn wander to one coordinate.
    pub fn add_to(&self, path: &mut [f64], random: &mut Xoshiro256PlusPlus) {
        for (mode, size) in self.modes.column_iter().zip(&self.sizes) {
            let part = size * normal(random);
            path.iter_mut().zip(mode.iter()).for_each(|(x, mode)| *x += part * mode);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::rand_core::SeedableRng;

    use super::*;

    /// A swing has next to no parts, a slow line has no others, and drawn wander has its size.
    #[test]
    fn what_is_slow_is_wander_and_a_swing_is_none() {
        let time: Vec<f64> = (0..800).map(|k| 0.01 * f64::from(k)).collect();
        let noise = Noise { deviation: 3e-4, slow: 1.0 };
        let wander = Wander::of(&time, 1.4, &noise);
        let share = |path: &dyn Fn(f64) -> f64| {
            let own = DMatrix::from_iterator(800, 1, time.iter().map(|t| path(*t)));
            wander.parts(&own).norm() / own.norm()
        };
        let swing = share(&|t| (-0.3 * t).exp() * (2.0 * PI * 1.4 * t).cos());
        let line = share(&|t| t - 3.995);
        assert!(swing < 0.1 && line > 0.99, "{swing} {line}");
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let (mut drawn, draws) = (0.0, 200);
        for _ in 0..draws {
            let mut path = vec![0.0; time.len()];
            wander.add_to(&mut path, &mut random);
            drawn += path.iter().map(|x| x * x).sum::<f64>();
        }
        let size = (drawn / f64::from(draws) / time.len() as f64).sqrt();
        assert!((size / (WANDER * noise.deviation) - 1.0).abs() < 0.15, "{size}");
        // Of two coordinates each has its own parts.
        let both = DMatrix::from_fn(1600, 1, |k, _| if k < 800 { 0.0 } else { time[k - 800] - 3.995 });
        let parts = wander.parts(&both);
        let half = parts.nrows() / 2;
        assert!(parts.rows(0, half).norm() < 1e-12 && parts.rows(half, half).norm() > 0.99 * both.norm());
        let variances = wander.variances(parts.nrows());
        assert_eq!(variances[0], variances[half]);
    }
}
