//! What hypotheses are compared with: features of all releases and their weights; and the comparison, release by release.

use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::{Hypothesis, Simulated};
use super::likelihood::{Compared, Weights};
use crate::calibrate::Trial;
use crate::features::Plan;
use crate::features::covariance::{colour, covariance};

/// Features of releases, and what was simulated so far.
pub struct Data {
    pub plans: Vec<Plan>,
    pub weights: Vec<Weights>,
    runs: AtomicUsize,
}

impl Data {
    /// Of the releases of trials that show a swing, with the places of these.
    pub fn of(trials: &[Trial]) -> (Self, Vec<usize>) {
        let plan = |trial: &Trial| {
            let plan = Plan::of(&trial.release, trial.is_held())?;
            let weights = Weights::of(&plan, &covariance(&plan, colour(&plan)));
            Some((plan, weights))
        };
        let found: Vec<_> = trials.par_iter().map(plan).collect();
        let places = (0..trials.len()).filter(|r| found[*r].is_some()).collect();
        let (plans, weights) = found.into_iter().flatten().unzip();
        (Self { plans, weights, runs: AtomicUsize::new(0) }, places)
    }

    /// Releases simulated so far, with slopes or without.
    pub fn runs(&self) -> usize {
        self.runs.load(Ordering::Relaxed)
    }

    /// Size of the largest first swing, m.
    pub fn first_swing(&self) -> f64 {
        self.plans.iter().map(|plan| plan.first_swing).fold(0.0, f64::max)
    }

    /// Number of features.
    pub fn count(&self) -> usize {
        self.plans.iter().map(|plan| plan.features.len()).sum()
    }

    /// All releases simulated, and what `of` makes of each; none where one cannot be run.
    pub fn simulate<T: Send>(
        &self,
        hypothesis: &Hypothesis,
        z: &DVector<f64>,
        wanted: &(dyn Fn(usize) -> bool + Sync),
        of: impl Fn(usize, &Plan, Simulated) -> T + Sync,
    ) -> Option<Vec<T>> {
        self.runs.fetch_add(self.plans.len(), Ordering::Relaxed);
        let one = |(r, plan): (usize, &Plan)| {
            let simulated = hypothesis.simulate(r, plan, z, wanted)?;
            Some(of(r, plan, simulated))
        };
        self.plans.par_iter().enumerate().map(one).collect::<Vec<_>>().into_iter().collect()
    }

    /// Features compared; with slopes by the unknowns that are wanted, zero by others.
    pub fn compare(
        &self,
        hypothesis: &Hypothesis,
        z: &DVector<f64>,
        wanted: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Compared> {
        let n = hypothesis.unknowns.len();
        let of = |_: usize, plan: &Plan, simulated: Simulated| {
            let at = plan.simulated(&simulated.coordinates);
            let count = plan.features.len();
            let difference = DVector::from_fn(count, |f, _| (at.values[f] - plan.values[f]) / plan.scales[f]);
            let mut slopes = DMatrix::zeros(count, n);
            for (u, moved) in &simulated.slopes {
                let along = plan.along(&simulated.coordinates, &at, moved);
                for (f, slope) in along.into_iter().enumerate() {
                    slopes[(f, *u)] = slope / plan.scales[f];
                }
            }
            (difference, slopes)
        };
        let (differences, slopes) = self.simulate(hypothesis, z, wanted, of)?.into_iter().unzip();
        Some(Compared { differences, slopes })
    }
}
