//! Covariance of features by the noise of the camera: the noise goes through the extractor itself.
//!
//! Noise of the measured size and colour is drawn and added to the recording, and the features of each draw are compared.
//! So every window, mean and ratio has the variance that it has, and what shares samples is correlated.

use nalgebra::DMatrix;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::Plan;
use super::window::{Span, fit};
use crate::normal::normal;

/// Draws of the noise: standard errors of the features are known to 6 %.
const DRAWS: usize = 128;
/// Correlation of neighbouring samples that is assumed where the recording does not show it: filters of cameras leave some.
const USUAL_COLOUR: f64 = 0.5;
/// Largest correlation of neighbours that counts as noise; beyond it is motion.
const MOST_COLOUR: f64 = 0.95;
/// Residuals at the end of a record of more than this many times the stated noise are motion.
const MOTION: f64 = 3.0;
const SEED: u64 = 0x6665_6174;

/// Correlation of neighbouring samples of the noise: from what the end of the record is off a decaying swing.
pub fn colour(plan: &Plan) -> f64 {
    let samples = plan.samples.len();
    let from = samples * 7 / 10;
    let (time, q) = (&plan.time[from..samples], &plan.recorded[0][from..]);
    let (Some(begin), Some(end)) = (time.first(), time.last()) else { return USUAL_COLOUR };
    // Weights are even over the record: the ramps lie outside.
    let half_period = 0.5 / plan.frequency;
    let span = Span { begin: begin - half_period, end: end + half_period, half_period };
    let Some(found) = fit(time, &[q.to_vec()], &span, (plan.frequency, 0.0)) else { return USUAL_COLOUR };
    let middle = 0.5 * (begin + end);
    let residual: Vec<f64> = (time.iter().zip(q))
        .map(|(t, q)| {
            let from = t - middle;
            let (sin, cos) = (std::f64::consts::TAU * found.frequency * from).sin_cos();
            let decay = (-found.loss * from).exp();
            let [c, a, b, a2, b2] = found.coefficients[0];
            let second = a2 * (cos * cos - sin * sin) + b2 * 2.0 * sin * cos;
            q - c - decay * (a * cos + b * sin) - decay * decay * second
        })
        .collect();
    let square: f64 = residual.iter().map(|r| r * r).sum();
    let lag: f64 = residual.windows(2).map(|two| two[0] * two[1]).sum();
    let size = (square / residual.len() as f64).sqrt();
    if !(size > 0.0 && size < MOTION * plan.noise) {
        return USUAL_COLOUR;
    }
    (lag / square).clamp(0.0, MOST_COLOUR)
}

/// Covariance of the features of a plan, in their own units, with the noise's variance at each sample and neighbours correlated
/// by `colour`. Correlations are shrunk towards none, as so few draws leave them uncertain.
pub fn covariance(plan: &Plan, colour: f64) -> DMatrix<f64> {
    let features = plan.features.len();
    let near = plan.of_recording();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let fresh = (1.0 - colour * colour).sqrt();
    let draw = |random: &mut Xoshiro256PlusPlus| {
        let mut moved = plan.recorded.clone();
        for q in &mut moved {
            let mut noise = normal(random);
            for q in q.iter_mut() {
                *q += plan.noise * noise;
                noise = colour * noise + fresh * normal(random);
            }
        }
        plan.disturbed(&moved, &near).values
    };
    let draws: Vec<Vec<f64>> = (0..DRAWS).map(|_| draw(&mut random)).collect();
    let mean = |f: usize| {
        let seen: Vec<f64> = draws.iter().map(|draw| draw[f]).filter(|x| x.is_finite()).collect();
        (seen.iter().sum::<f64>() / seen.len().max(1) as f64, seen.len())
    };
    let means: Vec<(f64, usize)> = (0..features).map(mean).collect();
    let share = DRAWS as f64 / (DRAWS + features) as f64;
    DMatrix::from_fn(features, features, |a, b| {
        let product = |draw: &Vec<f64>| (draw[a] - means[a].0) * (draw[b] - means[b].0);
        let products: Vec<f64> = draws.iter().map(product).filter(|x| x.is_finite()).collect();
        let mean = products.iter().sum::<f64>() / (products.len().max(2) - 1) as f64;
        if a == b { mean } else { share * mean }
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::swing;
    use super::super::{Plan, What};
    use super::*;

    /// Of white noise the variance of a weighted mean is `σ² Σw² / (Σw)²`, of a `sin²` window three halves of that of a plain
    /// mean; that of the frequency of a long swing is Rife's and Boorstyn's bound (1974), `σ_ω² = 12 σ² / (A²/2 · N T²)`, more
    /// where the swing decays. 128 draws are good to 13 % of a variance.
    #[test]
    fn variances_are_those_of_closed_forms() {
        let plan = Plan::of(&swing(1.4, 0.02, |_| [0.0; 2]), false).unwrap();
        let covariance = covariance(&plan, 0.0);
        let place = |what: What| plan.features.iter().position(|own| *own == what).unwrap();
        let rest = place(What::Rest { coordinate: 0 });
        let samples = 0.3 * plan.samples.len() as f64;
        let due = plan.noise.powi(2) * 1.5 / samples;
        assert!((covariance[(rest, rest)] / due - 1.0).abs() < 0.4, "{} {due}", covariance[(rest, rest)]);
        let window = place(What::Frequency { window: 2 });
        // Four cycles of 1.4 Hz at 100 Hz; amplitude 0.1 m, along q.
        let span = 4.0 / 1.4;
        let count = 100.0 * span;
        let rate = 24.0 * plan.noise.powi(2) / (0.1f64.powi(2) * count * span * span);
        let due = rate / (std::f64::consts::TAU * 1.4).powi(2);
        let found = covariance[(window, window)];
        // Ramps at both ends take half of a half period each.
        assert!(found > 0.6 * due && found < 2.0 * due, "{found}, due {due}");
    }

    /// AR(1) noise of 0.6 is seen as such, to the error of 240 samples.
    #[test]
    fn the_colour_of_noise_is_seen() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut state = [0.0; 2];
        let noise: Vec<[f64; 2]> = (0..800)
            .map(|_| {
                state = state.map(|x: f64| 0.6 * x + 0.8 * normal(&mut random));
                state.map(|x| 1e-4 * x)
            })
            .collect();
        let plan = Plan::of(&swing(1.4, 0.5, |k| noise[k]), false).unwrap();
        let found = colour(&plan);
        assert!((found - 0.6).abs() < 0.2, "{found}");
    }
}
