//! A robust loss: quadratic for what noise explains, linear for what it does not, so that a ghost
//! that cleaning has missed pulls no harder than a sample at the threshold.
//!
//! The fits of the program and of its page in the browser share it.
//!
//! Source: Huber (1964), Annals of Mathematical Statistics 35, 73-101; applied to the length of the
//! residual in the plane, so that no direction is preferred.

use std::f64::consts::LN_2;

/// Huber's loss of a residual of given length, in units of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Huber {
    /// Length at which the loss becomes linear.
    pub threshold: f64,
}

/// At three standard deviations of a plane's normal noise one sample in ninety counts as far, and
/// the estimate loses less than a per cent of its precision.
const THRESHOLD: f64 = 3.0;

impl Huber {
    /// The loss for residuals of a spread, in units of the noise; never below the noise itself.
    pub fn for_spread(spread: f64) -> Self {
        Self { threshold: THRESHOLD * spread.max(1.0) }
    }

    /// What a residual of a length adds to the cost.
    pub fn cost(self, length: f64) -> f64 {
        if length <= self.threshold {
            0.5 * length * length
        } else {
            self.threshold * (length - 0.5 * self.threshold)
        }
    }

    /// What a residual counts: its gradient is `weight × residual`.
    pub fn weight(self, length: f64) -> f64 {
        if length <= self.threshold { 1.0 } else { self.threshold / length }
    }
}

/// Standard deviation of each coordinate, from the median length, which is `√(2 ln 2)` deviations in a plane of normal
/// residuals: blind to a minority of ghosts.
#[must_use]
pub fn spread(mut lengths: Vec<f64>) -> f64 {
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    *median / (2.0 * LN_2).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loss_has_the_gradient_that_its_weight_says() {
        let huber = Huber::for_spread(1.5);
        for length in [0.1, 4.4, 4.6, 100.0] {
            let slope = (huber.cost(length + 1e-6) - huber.cost(length - 1e-6)) / 2e-6;
            assert!((slope - huber.weight(length) * length).abs() < 1e-6, "{length}");
        }
    }

    #[test]
    fn a_third_of_ghosts_leaves_the_spread_of_the_rest() {
        let mut lengths: Vec<f64> =
            (0..2000).map(|k| 2.0 * (-2.0 * ((k as f64 + 0.5) / 2000.0).ln()).sqrt()).collect();
        assert!((spread(lengths.clone()) - 2.0).abs() < 0.01);
        lengths.extend(vec![1e4; 200]);
        assert!((spread(lengths) - 2.0).abs() < 0.25);
        assert_eq!(spread(Vec::new()), 0.0);
    }
}
