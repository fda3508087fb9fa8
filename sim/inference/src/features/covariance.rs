//! Covariance of features by the noise of the camera: the noise goes through the extractor itself.
//!
//! Noise of the measured size and colour is drawn, with a slow wander, and added to the recording; the features of each draw are
//! compared.
//! So every window, mean and ratio has the variance that it has, and what shares samples is correlated.

use nalgebra::DMatrix;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::Plan;
use crate::normal::normal;

/// Draws of the noise: standard errors of the features are known to 6 %.
const DRAWS: usize = 128;
const SEED: u64 = 0x6665_6174;

/// Covariance of the features of a plan, in their own units, by the noise of its recording as a process of first order.
/// Correlations are shrunk towards none, as so few draws leave them uncertain.
pub fn covariance(plan: &Plan) -> DMatrix<f64> {
    let features = plan.features.len();
    let near = plan.of_recording();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let (deviation, correlation) = (plan.noise.deviation, plan.noise.correlation());
    let fresh = (1.0 - correlation * correlation).sqrt();
    let draw = |random: &mut Xoshiro256PlusPlus| {
        let mut moved = plan.recorded.clone();
        for q in &mut moved {
            let mut noise = normal(random);
            for q in q.iter_mut() {
                *q += deviation * noise;
                noise = correlation * noise + fresh * normal(random);
            }
            plan.wander.add_to(q, random);
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
    use super::super::{Noise, Plan, What};
    use super::*;

    /// Of white noise the variance of a weighted mean is `σ² Σw² / (Σw)²`, of a `sin²` window three halves of that of a plain
    /// mean; that of the frequency of a long swing is Rife's and Boorstyn's bound (1974), `σ_ω² = 12 σ² / (A²/2 · N T²)`, more
    /// where the swing decays. 128 draws are good to 13 % of a variance.
    #[test]
    fn variances_are_those_of_closed_forms() {
        let plan = Plan::of(&swing(1.4, 0.02, |_| [0.0; 2]), false).unwrap();
        assert_eq!(plan.noise, Noise { deviation: 1e-4, slow: 1.0 });
        let covariance = covariance(&plan);
        let place = |what: What| plan.features.iter().position(|own| *own == what).unwrap();
        let rest = place(What::Rest { coordinate: 0 });
        let samples = 0.3 * plan.samples.len() as f64;
        let due = plan.noise.deviation.powi(2) * 1.5 / samples;
        assert!((covariance[(rest, rest)] / due - 1.0).abs() < 0.4, "{} {due}", covariance[(rest, rest)]);
        let window = place(What::Frequency { window: 2 });
        // Four cycles of 1.4 Hz at 100 Hz; amplitude 0.1 m, along q.
        let span = 4.0 / 1.4;
        let count = 100.0 * span;
        let rate = 24.0 * plan.noise.deviation.powi(2) / (0.1f64.powi(2) * count * span * span);
        let due = rate / (std::f64::consts::TAU * 1.4).powi(2);
        let found = covariance[(window, window)];
        // Ramps at both ends take half of a half period each.
        assert!(found > 0.6 * due && found < 2.0 * due, "{found}, due {due}");
    }
}
