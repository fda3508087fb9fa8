//! What hypotheses are compared with: features of all releases and all samples; and the comparison, release by release.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::{Hypothesis, Simulated};
use super::likelihood::Weights;
use super::search::Point;
use super::slopes::Slopes;
use crate::calibrate::Trial;
use crate::features::covariance::covariance;
use crate::features::{Noise, Plan};

/// Error of a mesh that the noise hides, over the noise: it adds a ninth to the mean square.
const MESH: f64 = 1.0 / 3.0;

/// Share of the first swing that does not repeat, where nothing else is known: two releases by hand differ by 1 to 3 %, of which
/// this is the geometric mean.
const REPEATS: f64 = 0.017;

/// Features of releases, and what was simulated so far.
pub struct Data {
    /// Of the releases that are fitted.
    pub plans: Vec<Plan>,
    pub weights: Vec<Weights>,
    /// Of those that are held out.
    pub held_out: Vec<Plan>,
    /// How well releases repeat, as stated, m.
    repeatability: Option<f64>,
    runs: AtomicUsize,
}

/// Differences, simulated less recorded, and their slopes; by release.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    pub differences: Vec<DVector<f64>>,
    pub slopes: Arc<Vec<Slopes>>,
}

/// One simulation of all releases beside the recordings.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Features, over their scales.
    pub features: Compared,
    /// All samples, m.
    pub samples: Compared,
    /// What the slopes of all samples make, by release.
    pub squares: Arc<Vec<Squares>>,
}

/// Of the slopes J of a release `JᵀJ`, and their parts that wander has.
#[derive(Clone, Debug)]
pub struct Squares {
    pub jj: DMatrix<f64>,
    pub slow: DMatrix<f64>,
}

impl Data {
    /// Of the releases of trials that show a swing, with the places of these: the fitted ones first. `slow_noise` is
    /// [`Noise::slow`] where these were not recorded.
    pub fn of(trials: &[Trial], repeatability: Option<f64>, slow_noise: Option<f64>) -> (Self, Vec<usize>) {
        let mut found: Vec<_> =
            trials.par_iter().map(|trial| Plan::of(&trial.release, trial.is_held())).collect();
        // One camera sees all: each release shows a little of its colour.
        let slow_noise = slow_noise.unwrap_or_else(|| slow(found.iter().flatten().map(|plan| plan.noise)));
        found.par_iter_mut().flatten().for_each(|plan| plan.with_slow_noise(slow_noise));
        let is_held_out = |r: &usize| trials[*r].release.held_out;
        let shown = (0..trials.len()).filter(|r| found[*r].is_some());
        let (held_out, fitted): (Vec<usize>, Vec<usize>) = shown.partition(is_held_out);
        let of = |places: &[usize]| places.iter().filter_map(|r| found[*r].clone()).collect::<Vec<_>>();
        let plans = of(&fitted);
        let weights = plans.par_iter().map(weights).collect();
        let data = Self { plans, weights, held_out: of(&held_out), repeatability, runs: AtomicUsize::new(0) };
        (data, [fitted, held_out].concat())
    }

    /// Of the held-out releases alone; none where there are none.
    pub fn apart(&self) -> Option<Self> {
        let plans = self.held_out.clone();
        let weights = plans.par_iter().map(weights).collect();
        let (held_out, runs) = (Vec::new(), AtomicUsize::new(0));
        (!plans.is_empty()).then_some(Self { plans, weights, held_out, repeatability: None, runs })
    }

    /// Releases simulated so far, with slopes or without.
    pub fn runs(&self) -> usize {
        self.runs.load(Ordering::Relaxed)
    }

    /// The plans of all releases.
    pub fn all(&self) -> Vec<&Plan> {
        self.plans.iter().chain(&self.held_out).collect()
    }

    /// [`Noise::slow`], which is that of all recordings.
    pub fn slow_noise(&self) -> f64 {
        self.plans[0].noise.slow
    }

    /// How well releases repeat, m: as stated, or else as releases by hand do.
    pub fn repeats(&self) -> f64 {
        let first_swing = self.plans.iter().map(|plan| plan.first_swing).fold(0.0, f64::max);
        self.repeatability.unwrap_or(REPEATS * first_swing)
    }

    /// The same as far as it is known, m: several releases determine it by what they have in common.
    pub fn known_repeats(&self) -> f64 {
        if self.plans.len() == 1 { self.repeats() } else { self.repeatability.unwrap_or(0.0) }
    }

    /// The same as it is stated, m.
    pub fn stated_repeats(&self) -> f64 {
        self.repeatability.unwrap_or(0.0)
    }

    /// Number of features.
    pub fn count(&self) -> usize {
        self.plans.iter().map(|plan| plan.features.len()).sum()
    }

    /// All releases simulated and compared, with slopes by all unknowns; none where one cannot be run.
    pub fn compare(&self, hypothesis: &Hypothesis, z: &DVector<f64>) -> Option<Comparison> {
        self.compare_by(hypothesis, z, &(0..z.len()))
    }

    /// The same with slopes by those unknowns alone.
    pub fn compare_by(
        &self,
        hypothesis: &Hypothesis,
        z: &DVector<f64>,
        wanted: &Range<usize>,
    ) -> Option<Comparison> {
        let of = |plan: &Plan, simulated: Simulated| {
            let at = plan.simulated(&simulated.coordinates);
            let (feature, difference) = differences(plan, &simulated, &at.values);
            let places: Vec<usize> = simulated.slopes.iter().map(|(u, _)| *u).collect();
            let mut features = DMatrix::zeros(feature.len(), places.len());
            let mut samples = DMatrix::zeros(difference.len(), places.len());
            let count = plan.samples.len();
            for (k, (_, moved)) in simulated.slopes.iter().enumerate() {
                let along = plan.along(&simulated.coordinates, &at, moved);
                for (f, slope) in along.into_iter().enumerate() {
                    features[(f, k)] = slope / plan.scales[f];
                }
                for (c, q) in moved.iter().enumerate() {
                    samples.view_mut((c * count, k), (count, 1)).copy_from_slice(&q[..count]);
                }
            }
            let square = Squares { jj: samples.transpose() * &samples, slow: plan.wander.parts(&samples) };
            let slopes = |matrix| Slopes { places: places.clone(), matrix };
            ((feature, slopes(features)), (difference, slopes(samples)), square)
        };
        let (mut feature, mut sample, mut squares) = (Vec::new(), Vec::new(), Vec::new());
        for (own, other, square) in self.simulate(hypothesis, z, wanted, of)? {
            feature.push(own);
            sample.push(other);
            squares.push(square);
        }
        let compared = |own: Vec<(DVector<f64>, Slopes)>| {
            let (differences, slopes): (Vec<_>, Vec<_>) = own.into_iter().unzip();
            Compared { differences, slopes: slopes.into() }
        };
        Some(Comparison { features: compared(feature), samples: compared(sample), squares: squares.into() })
    }

    /// The same with the slopes of another point.
    pub fn compare_with(
        &self,
        hypothesis: &Hypothesis,
        z: &DVector<f64>,
        slopes: &Comparison,
    ) -> Option<Comparison> {
        let of = |plan: &Plan, simulated: Simulated| {
            differences(plan, &simulated, &plan.simulated(&simulated.coordinates).values)
        };
        let (features, samples) = self.simulate(hypothesis, z, &(0..0), of)?.into_iter().unzip();
        Some(Comparison {
            features: Compared { differences: features, slopes: slopes.features.slopes.clone() },
            samples: Compared { differences: samples, slopes: slopes.samples.slopes.clone() },
            squares: slopes.squares.clone(),
        })
    }

    /// Whether another mesh differs by less than the noise hides; none where it cannot be run.
    pub fn is_same(&self, at: &Point, other: &Hypothesis) -> Option<bool> {
        let there = self.compare_with(other, &at.z, &at.seen)?;
        let both = at.seen.samples.differences.iter().zip(&there.samples.differences);
        let is_little = |((here, there), plan): ((&DVector<f64>, &DVector<f64>), &Plan)| {
            (here - there).norm_squared() <= here.len() as f64 * (MESH * plan.noise.deviation).powi(2)
        };
        Some(both.zip(&self.plans).all(is_little))
    }

    /// All releases simulated, and what `of` makes of each.
    fn simulate<T: Send>(
        &self,
        hypothesis: &Hypothesis,
        z: &DVector<f64>,
        wanted: &Range<usize>,
        of: impl Fn(&Plan, Simulated) -> T + Sync,
    ) -> Option<Vec<T>> {
        self.runs.fetch_add(self.plans.len(), Ordering::Relaxed);
        let one = |(r, plan): (usize, &Plan)| {
            let simulated = hypothesis.simulate(r, plan, z, wanted)?;
            Some(of(plan, simulated))
        };
        self.plans.par_iter().enumerate().map(one).collect::<Vec<_>>().into_iter().collect()
    }
}

/// Spectral density of the slow noise of all recordings over the mean one.
fn slow(all: impl Iterator<Item = Noise>) -> f64 {
    let (slow, variance) = all.fold((0.0, 0.0), |(slow, sum), own| {
        let variance = own.deviation.powi(2);
        (slow + own.slow * variance, sum + variance)
    });
    if variance > 0.0 { slow / variance } else { 1.0 }
}

/// What the features of a release are weighed by.
fn weights(plan: &Plan) -> Weights {
    Weights::of(plan, &covariance(plan))
}

/// Differences of features, over their scales, and of all samples, m.
fn differences(plan: &Plan, simulated: &Simulated, values: &[f64]) -> (DVector<f64>, DVector<f64>) {
    let feature = DVector::from_fn(plan.features.len(), |f, _| (values[f] - plan.values[f]) / plan.scales[f]);
    let count = plan.samples.len();
    let sample = DVector::from_fn(count * plan.recorded.len(), |i, _| {
        let (c, k) = (i / count, i % count);
        simulated.coordinates[c][k] - plan.recorded[c][k]
    });
    (feature, sample)
}
