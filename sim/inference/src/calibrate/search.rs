//! The search of one part: the first swing, then ever longer stretches of the recordings, then all.
//!
//! A model whose frequency is off by a per cent has lost its phase after fifty swings, and the cost
//! of a whole recording then has many minima. So each stage only adds as much as the fit before it
//! predicts; where it does not, less is added. A search that ends far from the data is begun again
//! from the next best start. Multiple shooting would free the state at the start of each stretch, some
//! hundred unknowns of a rod for each, of which a marker or two see little; stages have been enough.

use efam_core::levenberg_marquardt::{
    Evaluated, FIRST_DAMPING, NEAR_DAMPING, Reused, Search, Solution, minimise,
};
use efam_core::loss::{Huber, spread};
use nalgebra::DVector;

use super::objective::Objective;
use super::prediction::{Fidelity, Slopes};
use super::stage::{MOST_EVALUATIONS, STAGE_SHARE, STAGE_TOLERANCE, Stage};
use super::starts::{FIRST_SWINGS, counts, ranked, swing_times};
use super::view::{Evaluation, View};

/// Where a search ended.
#[derive(Clone)]
pub(crate) struct Found {
    pub x: DVector<f64>,
    pub at: Evaluated<Evaluation>,
    /// Where its slopes were taken, as [`Solution::home`].
    pub home: Option<DVector<f64>>,
    pub view: View,
    pub stages: Vec<Stage>,
    /// Decrease of the cost that is still predicted.
    pub predicted: f64,
    pub converged: bool,
    pub starts: usize,
}

impl Found {
    /// Where one search ended.
    pub fn of(ended: Solution<Evaluation>, view: View, stages: Vec<Stage>) -> Self {
        let Solution { x, at, home, predicted, converged, .. } = ended;
        Self { x, at, home, view, stages, predicted, converged, starts: 1 }
    }

    /// Takes over where a search that went on from here ended.
    pub fn go_to(&mut self, ended: Solution<Evaluation>, view: View) {
        let mut stages = std::mem::take(&mut self.stages);
        stages.push(stage(self.starts - 1, None, &ended));
        *self = Self { starts: self.starts, ..Self::of(ended, view, stages) };
    }
}

/// Searches begun at most.
const MOST_STARTS: usize = 4;
/// Logarithm of the ratio of two costs that are one: stages end within a few per cent.
const ALIKE: f64 = 0.05;
/// Residuals of this spread, in units of the noise, are explained.
pub(super) const EXPLAINED: f64 = 2.0;
/// Residuals below this share of the motion need not come from a diverged search.
const NEAR: f64 = 0.05;
/// A new stretch whose residuals are this share of its motion was not predicted.
const SLIPPED: f64 = 0.7;
/// How much longer each stretch is than the one before, and at least where that was not predicted.
const GROWTH: f64 = 4.0;
const LEAST_GROWTH: f64 = 1.2;

/// Finds the best fit of a part; `tell` receives each stage, and where it ended.
pub(crate) fn search(
    objective: &Objective,
    start: &DVector<f64>,
    tell: &(dyn Fn(&Stage, &DVector<f64>) + Sync),
) -> Option<Found> {
    let starts = ranked(objective, start);
    let mut best: Option<Found> = None;
    let mut stages = Vec::new();
    let mut begun = 0;
    for (k, start) in starts.iter().enumerate().take(MOST_STARTS) {
        begun = k + 1;
        let Some(found) = climb(objective, start, k, tell) else { continue };
        stages.extend(found.stages.iter().cloned());
        let before = best.as_ref().map(|best| common_cost(objective, best));
        let cost = common_cost(objective, &found);
        // Two searches that end alike have not both diverged: the remaining residual is no fault of the search.
        let is_found_again = before.is_some_and(|before| (cost / before).ln().abs() < ALIKE);
        let is_done = is_found_again || is_met(objective, &found);
        if before.is_none_or(|before| cost < before) {
            best = Some(found);
        }
        if is_done {
            break;
        }
    }
    best.map(|best| Found { stages, starts: begun, ..best })
}

/// Costs of different searches are compared under the loss of the noise itself.
pub(crate) fn common_cost(objective: &Objective, found: &Found) -> f64 {
    let loss = vec![Huber::for_spread(1.0); found.view.loss.len()];
    objective.cost(&found.at.carried, &found.x, &View { loss, ..found.view.clone() })
}

/// Whether the residuals are noise, or small beside the motion.
pub(super) fn is_met(objective: &Objective, found: &Found) -> bool {
    let spreads = found.at.carried.spreads();
    let of = |(r, spread): (usize, &f64)| {
        let motion = excursion(objective, r, 0, found.view.counts[r]);
        *spread < EXPLAINED || *spread < NEAR * motion
    };
    spreads.iter().enumerate().all(of)
}

/// Root mean square of the motion of a release about its mean in a stretch, in units of the noise.
fn excursion(objective: &Objective, r: usize, from: usize, to: usize) -> f64 {
    let (trial, measured) = (&objective.part.members[r], &objective.measured[r]);
    let (mut sum, mut count) = (0.0, 0);
    for (track, noise) in trial.release.tracks.iter().zip(&measured.noise) {
        let seen: Vec<_> = measured.samples[from..to].iter().filter_map(|k| track.position[*k]).collect();
        let n = seen.len() as f64;
        for axis in 0..2 {
            let mean = seen.iter().map(|x| x[axis]).sum::<f64>() / n.max(1.0);
            sum += seen.iter().map(|x| ((x[axis] - mean) / noise).powi(2)).sum::<f64>();
        }
        count += seen.len();
    }
    (sum / (2 * count).max(1) as f64).sqrt()
}

/// One search, from the first swing to the whole recordings.
fn climb(
    objective: &Objective,
    start: &DVector<f64>,
    number: usize,
    tell: &(dyn Fn(&Stage, &DVector<f64>) + Sync),
) -> Option<Found> {
    let all = objective.all();
    let mut times = swing_times(objective, start);
    let mut x = start.clone();
    let mut stages = Vec::new();
    let (mut swings, mut reached, mut before) = (FIRST_SWINGS, 0.0, vec![0; all.len()]);
    loop {
        let mut view = View::of_all(objective.all());
        let stretch = counts(objective, &times, swings);
        // Where little is left, it costs less than a stage of its own.
        if stretch.iter().zip(&all).any(|(count, all)| 2 * count < *all) {
            view.counts = stretch;
        }
        let seen = objective.see(&x, &view, None)?;
        let growth = swings / reached;
        if growth > LEAST_GROWTH && reached > 0.0 && has_slipped(objective, &seen, &before, &view.counts) {
            swings = reached * growth.sqrt();
            continue;
        }
        let is_all = view.counts == all;
        view = view.like(seen);
        let solution = minimise_in(objective, &x, None, &view, STAGE_TOLERANCE, STAGE_SHARE)?;
        stages.push(stage(number, (!is_all).then_some(swings), &solution));
        x = solution.x.clone();
        tell(&stages[stages.len() - 1], &x);
        if is_all {
            return Some(Found::of(solution, view, stages));
        }
        if before.iter().all(|count| *count == 0) {
            times = swing_times(objective, &x);
        }
        before = view.counts;
        (reached, swings) = (swings, GROWTH * swings);
    }
}

/// Goes on from where a search ended, under weights that have changed since, or with finer steps.
pub(crate) fn go_on(objective: &Objective, found: &mut Found, fidelity: Fidelity) -> Option<()> {
    let view = View { fidelity, ..View::of_all(objective.all()) };
    let view = view.clone().like(objective.see(&found.x, &view, None)?);
    let solution = minimise_in(objective, &found.x, None, &view, STAGE_TOLERANCE, STAGE_SHARE)?;
    found.go_to(solution, view);
    Some(())
}

/// Minimises under one view; the tolerance is for residuals of unit spread.
pub(crate) fn minimise_in(
    objective: &Objective,
    x: &DVector<f64>,
    reused: Option<Reused<Evaluation>>,
    view: &View,
    tolerance: f64,
    relative: f64,
) -> Option<Solution<Evaluation>> {
    let unknowns = &objective.part.unknowns;
    let is_last = view.slopes == Slopes::Differences;
    // The threshold of the loss is three times the spread.
    let spread = view.loss.iter().map(|loss| loss.threshold / 3.0).fold(1.0, f64::max);
    let search = Search {
        bounds: unknowns.iter().map(|unknown| unknown.bounds).collect(),
        longest: unknowns.iter().map(|unknown| unknown.longest_step()).collect(),
        tolerance: tolerance * spread * spread,
        relative,
        most_evaluations: MOST_EVALUATIONS,
        first_damping: if is_last { NEAR_DAMPING } else { FIRST_DAMPING },
        reuses_slopes: true,
        is_followed: relative > 0.0,
    };
    minimise(x, reused, &search, &mut |x, reused| objective.evaluate(x, view, reused))
}

/// Whether the samples that are new are far from the prediction.
fn has_slipped(objective: &Objective, seen: &Evaluation, before: &[usize], counts: &[usize]) -> bool {
    (0..counts.len()).any(|r| {
        let (from, to) = (before[r], counts[r]);
        if from == 0 || to <= from {
            return false;
        }
        let new = seen.blocks[r].iter().flat_map(|series| {
            let lengths = series.samples.iter().zip(series.lengths());
            lengths.filter(|(k, _)| **k >= from).map(|(_, length)| length)
        });
        let residual = spread(new.collect());
        let motion = excursion(objective, r, from, to);
        residual > 5.0 && residual > SLIPPED * motion
    })
}

pub(crate) fn stage(start: usize, swings: Option<f64>, solution: &Solution<Evaluation>) -> Stage {
    Stage {
        start,
        swings,
        evaluations: solution.evaluations,
        spread: solution.at.carried.spreads().into_iter().fold(0.0, f64::max),
        converged: solution.converged,
    }
}
