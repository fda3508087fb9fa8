//! Slow wander of base and camera, which each release has for itself.
//!
//! A random walk less its mean is a sum of cosines of k half cycles over the record, whose variances fall as 1/k². Those of four
//! cycles of the swing and longer count as wander: what is faster is seen as noise at the end of the record. With U S the left
//! singular vectors and values of the cosines, each times its deviation, noise of variance κσ² beside it has the covariance
//! `κσ² I + U S² Uᵀ`. Residuals times the root of κσ² over it have variance κσ² alone.
//! Source: Shorack and Wellner (1986), Empirical Processes with Applications to Statistics, chapter 5, for the expansion.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::Noise;
use crate::normal::normal;

/// Root mean square wander over a record, over the deviation of the noise: whoever sees a tenth of a millimetre has a stiffer table than
/// one who sees a whole one, and what wanders by more than its noise is seen and taken off.
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
    /// Share of each mode that residuals lose.
    lost: DVector<f64>,
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
        let density = noise.slow * noise.deviation.powi(2);
        let sizes = svd.singular_values;
        let lost = sizes.map(|size| 1.0 - (1.0 + size * size / density).sqrt().recip());
        Self { modes: svd.u.unwrap_or_default(), sizes, lost }
    }

    /// Takes from residuals of one coordinate, or their slopes, what may be wander.
    pub fn take_from(&self, path: &mut [f64]) {
        for (mode, lost) in self.modes.column_iter().zip(&self.lost) {
            let part: f64 = mode.iter().zip(path.iter()).map(|(mode, x)| mode * x).sum();
            path.iter_mut().zip(mode.iter()).for_each(|(x, mode)| *x -= lost * part * mode);
        }
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

    /// A swing loses nothing, a slow line nearly all, and drawn wander has its size; what is left of wander and noise together has
    /// the variance of the noise.
    #[test]
    fn what_is_slow_is_taken_and_a_swing_is_left() {
        let time: Vec<f64> = (0..800).map(|k| 0.01 * f64::from(k)).collect();
        let noise = Noise { deviation: 3e-5, slow: 1.0 };
        let wander = Wander::of(&time, 1.4, &noise);
        let left = |path: &dyn Fn(f64) -> f64| {
            let mut own: Vec<f64> = time.iter().map(|t| path(*t)).collect();
            let before: f64 = own.iter().map(|x| x * x).sum();
            wander.take_from(&mut own);
            (own.iter().map(|x| x * x).sum::<f64>() / before).sqrt()
        };
        let swing = left(&|t| (-0.3 * t).exp() * (2.0 * PI * 1.4 * t).cos());
        let line = left(&|t| t - 3.995);
        assert!(swing > 0.995 && line < 0.1, "{swing} {line}");
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let (mut drawn, mut rest, draws) = (0.0, 0.0, 200);
        for _ in 0..draws {
            let mut path = vec![0.0; time.len()];
            wander.add_to(&mut path, &mut random);
            drawn += path.iter().map(|x| x * x).sum::<f64>();
            path.iter_mut().for_each(|x| *x += noise.deviation * normal(&mut random));
            wander.take_from(&mut path);
            rest += path.iter().map(|x| x * x).sum::<f64>();
        }
        let mean = |sum: f64| (sum / f64::from(draws) / time.len() as f64).sqrt();
        assert!((mean(drawn) / (WANDER * noise.deviation) - 1.0).abs() < 0.15, "{}", mean(drawn));
        assert!((mean(rest) / noise.deviation - 1.0).abs() < 0.05, "{}", mean(rest));
    }
}
