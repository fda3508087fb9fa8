//! The only file that knows nuts-rs: one chain of the no-U-turn sampler over a density that is near a standard normal one.
//!
//! Source: Hoffman and Gelman (2014), J. Machine Learning Research 15, 1593-1623.

use std::collections::HashMap;

use nuts_rs::rand::rngs::ChaCha8Rng;
use nuts_rs::rand::{Rng as _, SeedableRng};
use nuts_rs::{
    Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, KineticEnergyKind, LogpError,
    Settings,
};
use thiserror::Error;

/// Logarithm of a density up to a constant, and a force: its gradient, or what is near it. None where there is no density.
///
/// The force may be some per cent off: steps are reversible and keep the volume, and a draw is accepted by the density alone. The force
/// of another density leads chains to places that they do not leave, and moments are wrong.
pub type Density<'a> = dyn Fn(&[f64], &mut [f64]) -> Option<f64> + Sync + 'a;

/// What one chain found.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// Shape `[draws][dimensions]`.
    pub draws: Vec<Vec<f64>>,
    /// Places at which the density was evaluated, those of the warm-up included.
    pub evaluations: u64,
    /// Draws whose trajectory was broken off because its energy ran away.
    pub divergent: u64,
}

/// First step of the warm-up: in a density near the normal one the tuned step is of this order.
const FIRST_STEP: f64 = 0.5;

/// Longest step: where the density is normal, a quarter of a rotation leads to a draw that is independent of the last one, and a half
/// one to its mirror image.
const LONGEST_STEP: f64 = std::f64::consts::FRAC_PI_2;

/// Length of a trajectory: half a rotation, beyond which a normal density only mirrors what came before. A step of a quarter is taken
/// once, shorter ones until the length is reached or the trajectory turns round.
const LENGTH: f64 = std::f64::consts::PI;

/// Draws after which masses would be adapted: never, since the coordinates have equal ones.
const NEVER: u64 = u32::MAX as u64;

struct Target<'a> {
    density: &'a Density<'a>,
    size: usize,
}

/// The density is not defined at a place, such as where a simulation diverges; the draw is rejected.
#[derive(Debug, Error)]
#[error("the model cannot be simulated there")]
struct Undefined;

impl LogpError for Undefined {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl HasDims for Target<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.size as u64)])
    }
}

impl CpuLogpFunc for Target<'_> {
    type LogpError = Undefined;
    type FlowParameters = ();
    type ExpandedVector = ();

    fn dim(&self) -> usize {
        self.size
    }

    fn logp(&mut self, position: &[f64], gradient: &mut [f64]) -> Result<f64, Undefined> {
        (self.density)(position, gradient).filter(|value| value.is_finite()).ok_or(Undefined)
    }

    fn expand_vector<R: nuts_rs::rand::Rng + ?Sized>(
        &mut self,
        _: &mut R,
        _: &[f64],
    ) -> Result<(), CpuMathError> {
        Ok(())
    }
}

/// Runs one chain in so many dimensions; `tell` is called after each draw, and ends the chain by `false`. None where the
/// density is not defined at the start, or the sampler gives up.
///
/// It starts one deviation from the middle in each dimension. The sampler takes its masses from the gradient there, which
/// has the size one as well.
pub fn chain(
    density: &Density<'_>,
    size: usize,
    (warm_up, draws): (usize, usize),
    (seed, number): (u64, u64),
    tell: &(dyn Fn() -> bool + Sync),
) -> Option<Chain> {
    let mut settings = DiagNutsSettings {
        num_tune: warm_up as u64,
        num_draws: draws as u64,
        // Rotations solve a normal density exactly, so the step is bounded by what departs from it alone.
        trajectory_kind: KineticEnergyKind::ExactNormal,
        ..DiagNutsSettings::default()
    };
    settings.target_integration_time = Some(LENGTH);
    settings.adapt_options.early_mass_matrix_switch_freq = NEVER;
    settings.adapt_options.mass_matrix_switch_freq = NEVER;
    settings.adapt_options.mass_matrix_update_freq = NEVER;
    let steps = &mut settings.adapt_options.step_size_settings;
    steps.initial_step = FIRST_STEP;
    steps.jitter = None;
    steps.adapt_options.dual_average.max_step_size = LONGEST_STEP;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    let start: Vec<f64> =
        (0..size).map(|_| if random.next_u32().is_multiple_of(2) { 1.0 } else { -1.0 }).collect();
    let math = CpuMath::new(Target { density, size });
    let mut sampler = settings.new_chain(number, math, &mut random).ok()?;
    sampler.set_position(&start).ok()?;
    let mut found = Chain::default();
    for k in 0..warm_up + draws {
        let (position, progress) = sampler.draw().ok()?;
        found.evaluations += progress.num_gradients;
        if k >= warm_up {
            found.divergent += u64::from(progress.diverging);
            found.draws.push(position.into_vec());
        }
        if !tell() {
            return None;
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exponential-ish tail in one direction, bent valley in the other: moments against sums over a fine grid. The force is the gradient,
    /// or three tenths of it are that of a standard normal density: slopes of a fit are less off elsewhere.
    #[test]
    fn a_force_that_is_off_leaves_the_density_right() {
        let cost = |x: f64, y: f64| 0.5 * x * x + 0.5 * (y - 0.3 * x * x).powi(2) + 0.2 * x.exp();
        let grid = || (-160..160).map(|k| 0.05 * f64::from(k));
        let mut sums = [0.0; 4];
        for x in grid() {
            for y in grid() {
                let weight = (-cost(x, y)).exp();
                let powers = [1.0, x, y, y * y];
                sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += weight * power);
            }
        }
        let due = [sums[1] / sums[0], sums[2] / sums[0], sums[3] / sums[0]];
        for off in [0.0, 0.3] {
            let density = |z: &[f64], force: &mut [f64]| {
                let (x, y) = (z[0], z[1]);
                let miss = y - 0.3 * x * x;
                let by_x = 0.6 * x * miss - x - 0.2 * x.exp();
                force.copy_from_slice(&[by_x * (1.0 - off) - off * x, -miss * (1.0 - off) - off * y]);
                Some(-cost(x, y))
            };
            let draws = || chain(&density, 2, (200, 8000), (1, 0), &|| true).unwrap().draws;
            let found = draws();
            let mean = |of: &dyn Fn(&[f64]) -> f64| found.iter().map(|own| of(own)).sum::<f64>() / 8000.0;
            let means = [mean(&|z| z[0]), mean(&|z| z[1]), mean(&|z| z[1] * z[1])];
            // Four standard errors of 2000 independent draws; y² has a deviation near 2.5.
            for ((found, due), tolerance) in means.iter().zip(due).zip([0.08, 0.1, 0.22]) {
                assert!((found - due).abs() < tolerance, "{off}: {means:?}, due {due:?}");
            }
            assert_eq!(found, draws());
        }
    }
}
