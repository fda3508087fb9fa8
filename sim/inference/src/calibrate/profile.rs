//! Intervals by the profile of the likelihood: one unknown is moved, all others follow.
//!
//! An interval from the curvature is a parabola's; where the cost is none, the profile gives it. The
//! bounds lie where twice the cost has risen by `1.96²`, times how much wider the covariance is than for
//! white noise as large as stated.
//! Source: Venzon and Moolgavkar (1988), Applied Statistics 37, 87-94.

use efam_core::levenberg_marquardt::{NEAR_DAMPING, Reused, Search, minimise};
use nalgebra::DVector;

use super::objective::Objective;
use super::search::Found;
use super::uncertainty::Uncertainty;
use super::view::Evaluation;
use crate::normal::NORMAL_95;

/// How near the root of the rise has to come to the wanted one, 1.96, for a line through the last two points to lead to it.
const NEAR: f64 = 0.2;
/// Predicted decrease of the cost at which the others have followed: the root of the rise is off by half of that.
const TOLERANCE: f64 = 0.02;
/// Points at which the profile is looked at, at most.
const MOST_POINTS: usize = 6;

/// Bounds of the scaled unknown; none where the data do not bound it.
pub(crate) fn profile(
    objective: &Objective,
    found: &Found,
    uncertainty: &Uncertainty,
    unknown: usize,
) -> Option<[f64; 2]> {
    if !uncertainty.is_determined[unknown] {
        return None;
    }
    let variance_inflation = uncertainty.variance_inflation(unknown);
    let error = uncertainty.covariance[(unknown, unknown)].sqrt();
    let side = |sign: f64| bound(objective, found, unknown, sign * error, variance_inflation.max(1e-12));
    Some([side(-1.0)?, side(1.0)?])
}

/// Steps outward by the parabola's bound, then as the root of the rise predicts.
fn bound(
    objective: &Objective,
    found: &Found,
    unknown: usize,
    step: f64,
    variance_inflation: f64,
) -> Option<f64> {
    let (low, high) = objective.part.unknowns[unknown].bounds;
    let mut x = found.x.clone();
    let (mut length, mut before) = (NORMAL_95, (0.0, 0.0));
    for _ in 0..MOST_POINTS {
        let wanted = found.x[unknown] + length * step;
        let value = wanted.clamp(low, high);
        let moved = (value - found.x[unknown]) / step;
        let follow = &x - &found.x;
        x = &found.x + follow * if before.0 > 0.0 { moved / before.0 } else { 1.0 };
        let (next, cost) = held(objective, found, &x, unknown, value)?;
        x = next;
        let rise = (2.0 * (cost - found.at.cost) / variance_inflation).max(0.0).sqrt();
        if value != wanted && rise < NORMAL_95 {
            // The admissible values end before the data object.
            return Some(value);
        }
        let slope = (rise - before.1) / (moved - before.0);
        let is_near = (rise - NORMAL_95).abs() < NEAR;
        before = (moved, rise);
        length = if slope > 0.0 {
            (moved + (NORMAL_95 - rise) / slope).clamp(0.3 * moved, 3.0 * moved)
        } else {
            2.0 * moved
        };
        if is_near {
            break;
        }
    }
    Some((found.x[unknown] + length * step).clamp(low, high))
}

/// The least cost with one unknown held.
fn held(
    objective: &Objective,
    found: &Found,
    x: &DVector<f64>,
    unknown: usize,
    value: f64,
) -> Option<(DVector<f64>, f64)> {
    let unknowns = &objective.part.unknowns;
    let mut bounds: Vec<_> = unknowns.iter().map(|unknown| unknown.bounds).collect();
    bounds[unknown] = (value, value);
    let search = Search {
        bounds,
        longest: unknowns.iter().map(|unknown| unknown.longest_step()).collect(),
        tolerance: TOLERANCE,
        relative: 0.0,
        most_evaluations: 10,
        first_damping: NEAR_DAMPING,
        reuses_slopes: true,
        is_followed: true,
    };
    let mut evaluate =
        |x: &DVector<f64>, reused: Option<&Evaluation>| objective.evaluate(x, &found.view, reused);
    let reused = Reused { carried: &found.at.carried, home: None };
    let solution = minimise(x, Some(reused), &search, &mut evaluate)?;
    Some((solution.x, solution.at.cost))
}
