//! The search for the optimum of a hypothesis, by features or by all samples.
//!
//! Levenberg and Marquardt at a given scale of what the model misses, then the scale that is most probable there, and so on. The
//! scale falls with the misfit, which anneals the search. All unknowns are standard normal, so no scales of them are needed.

use std::sync::Arc;

use efam_core::levenberg_marquardt::{Evaluated, Reused, minimise};
use nalgebra::DVector;

use super::data::{Comparison, Data};
use super::hypothesis::Hypothesis;
use super::likelihood::Expanded;

/// Predicted decrease of the cost that is not worth a step, nats: a tenth of what separates the members of a class. The steps of
/// the integrator make the cost of a rod with friction uneven by as much.
const TOLERANCE: f64 = 0.3;

/// How a search compares, with the scale of what the model misses.
pub trait Likelihood {
    /// The scale.
    type Scale;
    /// Longest step of an unknown, prior standard deviations.
    const LONGEST: f64;

    /// Cost and derivatives at `z` for a scale.
    fn expanded(&self, data: &Data, seen: &Comparison, z: &DVector<f64>, scale: &Self::Scale) -> Expanded;

    /// The most probable scale at `z`, near another one.
    fn scale(
        &self,
        data: &Data,
        hypothesis: &Hypothesis,
        seen: &Comparison,
        z: &DVector<f64>,
        near: &Self::Scale,
    ) -> Self::Scale;

    /// Whether a change of the scale is worth no other round.
    fn is_settled(&self, before: &Self::Scale, after: &Self::Scale) -> bool;
}

/// How much a search may cost.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Rounds of steps and scale.
    pub rounds: usize,
    /// Evaluations in each.
    pub evaluations: usize,
}

/// Effort of a fit to its end: the scale follows it.
pub const EFFORT: Effort = Effort { rounds: 4, evaluations: 10 };

/// A point, and how it compares there, with the slopes of some point.
#[derive(Clone)]
pub struct Point {
    pub z: DVector<f64>,
    pub seen: Arc<Comparison>,
}

impl Point {
    /// With slopes of the point itself; none where the model cannot be run.
    pub fn of(data: &Data, hypothesis: &Hypothesis, z: DVector<f64>) -> Option<Self> {
        let seen = data.compare(hypothesis, &z)?.into();
        Some(Self { z, seen })
    }
}

/// The optimum from a point that has its own slopes, with its scale; the end has slopes that are good within a standard error.
/// None where the model cannot be run.
pub fn search<L: Likelihood>(
    by: &L,
    data: &Data,
    hypothesis: &Hypothesis,
    start: Point,
    mut scale: L::Scale,
    effort: Effort,
) -> Option<(Point, L::Scale)> {
    let mut at = start;
    let mut home = at.z.clone();
    for _ in 0..effort.rounds {
        let limits = hypothesis.search(L::LONGEST, TOLERANCE, effort.evaluations);
        let mut evaluate = |x: &DVector<f64>, slopes: Option<&Arc<Comparison>>| {
            let seen = match slopes {
                _ if *x == at.z && (slopes.is_some() || home == at.z) => at.seen.clone(),
                Some(slopes) => data.compare_with(hypothesis, x, slopes)?.into(),
                None => data.compare(hypothesis, x)?.into(),
            };
            Some(evaluated(by, data, seen, x, &scale))
        };
        let known = Reused { carried: &at.seen, home: Some(&home) };
        let found = minimise(&at.z, Some(known), &limits, &mut evaluate)?;
        let is_near = |home: &DVector<f64>| {
            let moved = &found.x - home;
            moved.dot(&(&found.at.hessian * &moved)) < 1.0
        };
        let has_moved = found.x != at.z;
        let from = if has_moved { found.home } else { Some(home) };
        let from = from.filter(is_near);
        let is_there = from.is_some();
        let seen = if is_there { found.at.carried } else { data.compare(hypothesis, &found.x)?.into() };
        home = from.unwrap_or_else(|| found.x.clone());
        at = Point { z: found.x, seen };
        let best = by.scale(data, hypothesis, &at.seen, &at.z, &scale);
        // A search that did not move would not do so again.
        let is_over = is_there && (found.converged || !has_moved);
        let is_settled = by.is_settled(&scale, &best);
        scale = best;
        if is_settled && is_over {
            break;
        }
    }
    Some((at, scale))
}

/// Some steps with the slopes of another point; none where the model cannot be run.
pub fn steps<L: Likelihood>(
    by: &L,
    data: &Data,
    hypothesis: &Hypothesis,
    start: &DVector<f64>,
    slopes: &Comparison,
    scale: &L::Scale,
    count: usize,
) -> Option<Point> {
    let limits = hypothesis.search(L::LONGEST, TOLERANCE, count);
    let mut last: Option<Point> = None;
    let mut evaluate = |x: &DVector<f64>, _: Option<&Arc<Comparison>>| {
        // There are no other slopes to be had.
        let seen = match last.take().filter(|last| last.z == *x) {
            Some(last) => last.seen,
            None => Arc::new(data.compare_with(hypothesis, x, slopes)?),
        };
        last = Some(Point { z: x.clone(), seen: seen.clone() });
        Some(evaluated(by, data, seen, x, scale))
    };
    let found = minimise(start, None, &limits, &mut evaluate)?;
    Some(Point { z: found.x, seen: found.at.carried })
}

fn evaluated<L: Likelihood>(
    by: &L,
    data: &Data,
    seen: Arc<Comparison>,
    z: &DVector<f64>,
    scale: &L::Scale,
) -> Evaluated<Arc<Comparison>> {
    let Expanded { cost, gradient, hessian } = by.expanded(data, &seen, z, scale);
    Evaluated { cost, gradient, hessian, carried: seen }
}
