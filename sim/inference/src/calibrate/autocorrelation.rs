//! How residuals that follow one another resemble each other.
//!
//! A model that lacks something leaves residuals that swing as the rod does; taken for fresh
//! noise they would make intervals too narrow. Their autocorrelation is estimated from the residuals
//! themselves and put into the covariance of the estimate where the slopes of neighbouring samples
//! are multiplied. The usual estimator takes the products of residual and slope as they come, and has a matrix to
//! estimate at each lag; this one knows the slopes and has one curve to estimate, so that white noise is
//! left as it is.
//!
//! Where the curve ends is found by the rule of Politis and White (2004), Econometric Reviews 23,
//! 53-70: the first lag after which several in a row cannot be distinguished from zero. The taper is theirs too, flat
//! and then falling to zero, but twice as long: what each lag is too small to show, many are not. It is flat
//! as far as twice that lag, and ends at four times it. It may leave a spectrum that is negative somewhere;
//! the taper is then Bartlett's, with which none is: Newey and West (1987), Econometrica 55, 703-708.
//! Bartlett's throughout, ending at twice that lag, takes a quarter of the variance that noise with a memory of
//! three samples has at the frequency of a swing.

/// Autocovariance of a plane's residuals, tapered: at lag zero their variance by coordinate, and
/// nothing beyond the lags that matter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Autocovariance {
    /// By lag in samples.
    pub by_lag: Vec<f64>,
    /// Autocorrelation at a lag of one sample, as it is.
    pub next: f64,
}

/// Lags in a row that must not differ from zero.
const QUIET_LAGS: usize = 5;
/// Share of the samples up to which lags are looked at.
const LONGEST: f64 = 0.2;

impl Autocovariance {
    /// Of residuals on a regular grid; lost samples are gaps in it.
    pub fn of(grid: &[Option<[f64; 2]>]) -> Self {
        let count = grid.iter().flatten().count();
        let product = |lag: usize| -> f64 {
            let (sum, pairs) = products(grid, lag);
            // Gaps are made up for; the pairs that the end of the recording takes are not.
            let share = (grid.len() - lag) as f64 / grid.len() as f64;
            share * sum / (2 * pairs).max(1) as f64
        };
        let variance = product(0);
        if variance <= 0.0 {
            return Self { by_lag: vec![0.0], next: 0.0 };
        }
        let most = ((LONGEST * grid.len() as f64) as usize).max(1);
        let n = 2.0 * count as f64;
        let threshold = 2.0 * (n.log10() / n).sqrt();
        let mut correlation = vec![1.0];
        let mut quiet = 0;
        for lag in 1..=most {
            let value = product(lag) / variance;
            correlation.push(value);
            quiet = if value.abs() < threshold { quiet + 1 } else { 0 };
            if quiet == QUIET_LAGS {
                break;
            }
        }
        let last = correlation.len() - 1 - quiet;
        let reach = 4 * last;
        for lag in correlation.len()..=reach.min(most) {
            correlation.push(product(lag) / variance);
        }
        let next = correlation.get(1).copied().unwrap_or(0.0);
        correlation.truncate(reach.max(1));
        let flat_top = tapered(&correlation, 2.0);
        let tapered = if has_positive_spectrum(&flat_top) { flat_top } else { tapered(&correlation, 1.0) };
        Self { by_lag: tapered.iter().map(|value| variance * value).collect(), next }
    }
}

/// Sum of the products of a plane's values at samples that are so far apart, and how many pairs are there.
pub(super) fn products(grid: &[Option<[f64; 2]>], lag: usize) -> (f64, usize) {
    let pairs = grid.iter().zip(grid.iter().skip(lag));
    let both = pairs.filter_map(|(a, b)| (*a).zip(*b));
    both.fold((0.0, 0), |(sum, count), (a, b)| (sum + (a[0] * b[0] + a[1] * b[1]), count + 1))
}

/// Weights that fall to zero one lag after the last, `steepness` times as fast as a line from one at lag zero.
fn tapered(correlation: &[f64], steepness: f64) -> Vec<f64> {
    let share = |lag: usize| 1.0 - lag as f64 / correlation.len() as f64;
    correlation.iter().enumerate().map(|(lag, value)| (steepness * share(lag)).min(1.0) * value).collect()
}

/// Whether no frequency has a variance below zero, as far as frequencies of half the resolution show. The sum of
/// cosines is Clenshaw's: (1955), Mathematics of Computation 9, 118-120.
fn has_positive_spectrum(by_lag: &[f64]) -> bool {
    let count = 4 * by_lag.len();
    (0..=count).all(|k| {
        let cos = (std::f64::consts::PI * k as f64 / count as f64).cos();
        let step = |[next, after]: [f64; 2], value: &f64| [value + 2.0 * cos * next - after, next];
        let [first, second] = by_lag.iter().rev().fold([0.0; 2], step);
        2.0 * (first - cos * second) > by_lag[0]
    })
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    use super::*;
    use crate::normal::normal;

    fn noise(count: usize, memory: f64) -> Vec<Option<[f64; 2]>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut at = [0.0; 2];
        let fresh = (1.0 - memory * memory).sqrt();
        (0..count)
            .map(|_| {
                at = at.map(|at| memory * at + fresh * normal(&mut random));
                Some(at)
            })
            .collect()
    }

    #[test]
    fn white_noise_has_no_neighbours() {
        let found = Autocovariance::of(&noise(4000, 0.0));
        assert_eq!(found.by_lag.len(), 1, "{found:?}");
        // Standard error of a variance: √(2/n), n = 8000.
        assert!((found.by_lag[0] - 1.0).abs() < 4.0 * (2.0 / 8000.0f64).sqrt());
    }

    /// `Σ ρ^|lag|` over all lags is `(1 + ρ) / (1 − ρ)`: 9 for ρ = 0.8.
    #[test]
    fn memory_adds_up() {
        let found = Autocovariance::of(&noise(20_000, 0.8));
        let sum = 2.0 * found.by_lag.iter().sum::<f64>() - found.by_lag[0];
        assert!((8.2..9.8).contains(&sum), "{sum}");
        assert!((found.next - 0.8).abs() < 0.02, "{}", found.next);
    }

    #[test]
    fn gaps_do_not_shift_the_lags() {
        let mut grid = noise(4000, 0.8);
        for k in (0..4000).step_by(3) {
            grid[k] = None;
        }
        let found = Autocovariance::of(&grid);
        assert!((found.next - 0.8).abs() < 0.04, "{}", found.next);
    }
}
