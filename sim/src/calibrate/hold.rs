//! A rod that is held bent before its release: the force and the moment of the hand, from the markers.
//!
//! The rod starts at rest under a dead load at its end (`effects::tip_hold`). The load is a nuisance parameter of its
//! release. Here it gets its first value: least squares on the places of the markers at the release, by Levenberg and
//! Marquardt's method, with what a hand may do as a prior.

use std::ops::ControlFlow;

use models::effects::tip_hold::{HELD, NAME, PULL};
use models::error::ModelError;
use models::model::Model;
use nalgebra::{DMatrix, DVector};

use super::problem::Trial;
use crate::experiment::release::Release;
use crate::forward::{ForwardError, Initial, Run, forward};

/// Time before the release in which the hand that holds the rod hardly moves, s.
pub(super) const LATE_HOLD: f64 = 0.1;
/// Error of a marker's place, over the rod's length: half a millimetre on the paper's muscle.
const PLACE: f64 = 3e-3;
const MOST_ITERATIONS: usize = 60;
/// Change of the load, over its size, below which it is found.
const SETTLED: f64 = 1e-4;

/// Sizes of what a hand does: forces that bend the rod by its length and bear what it weighs, rates that change them in
/// the time in which the end falls by that length, the moment of such a force.
/// Source: a cantilever under a load at its end, `P = 3 EI w / L³`.
pub(super) fn sizes(model: &Model) -> [f64; 5] {
    let value = |path: &str| model.index(path).map_or(0.0, |k| model.theta[k]);
    let rod = model.rod();
    let mass = rod.mass + value("effects.end_fitting.mass") + value("effects.payload.mass");
    let gravity = value("effects.gravity.acceleration");
    let force = 3.0 * rod.bending_stiffness / rod.length.powi(2) + mass * gravity;
    let rate = force / (rod.length / gravity.max(1.0)).sqrt();
    [force, force, rate, rate, force * rod.length]
}

/// How many of them a release can tell: one marker does not show a moment.
pub(super) fn components(release: &Release) -> usize {
    if release.tracks.len() > 1 { 5 } else { 4 }
}

/// Lets a trial start at rest in the hand that holds its markers where they are seen.
pub(super) fn hold(trial: &mut Trial) -> Result<(), ForwardError> {
    trial.model = trial.model.with_effect(NAME, &[("held", 0.0)])?;
    let mut holding = trial.model.clone();
    holding.set(HELD, 1.0)?;
    let own = vec![holding.index(HELD)?];
    trial.run.initial = Initial::Equilibrium { hold: Box::new(holding), own };
    let values = find(trial)?;
    (trial.model, trial.run.initial) = trial.with(&values);
    Ok(())
}

/// Where the force and the moment stand in `theta`, and their sizes.
fn load(model: &Model) -> Result<[(usize, f64); 3], ModelError> {
    let ([x, z, _, _, moment], [force, .., of_moment]) = (PULL, sizes(model));
    Ok([(model.index(x)?, force), (model.index(z)?, force), (model.index(moment)?, of_moment)])
}

/// Where each track is at the release: the mean of the end of the hold, or else the first sample.
fn targets(release: &Release) -> Vec<Option<[f64; 2]>> {
    let mean = |path: &Vec<Option<[f64; 2]>>| {
        let samples = || release.time.iter().zip(path).filter_map(|(time, at)| Some((*time, (*at)?)));
        let held: Vec<[f64; 2]> =
            samples().filter(|(time, _)| (-LATE_HOLD..=0.0).contains(time)).map(|(_, at)| at).collect();
        if held.is_empty() {
            return samples().find(|(time, _)| *time > 0.0).map(|(_, at)| at);
        }
        Some([0, 1].map(|axis| held.iter().map(|at| at[axis]).sum::<f64>() / held.len() as f64))
    };
    release.tracks.iter().map(|track| mean(&track.position)).collect()
}

/// The load that brings the markers nearest to where they are.
fn find(trial: &Trial) -> Result<Vec<(usize, f64)>, ForwardError> {
    let targets = targets(&trial.release);
    let load = load(&trial.model)?;
    let unknowns = if trial.release.tracks.len() > 1 { 3 } else { 2 };
    let load = &load[..unknowns];
    let scaled = |x: &DVector<f64>| -> Vec<_> {
        load.iter().zip(x.iter()).map(|((place, size), x)| (*place, size * x)).collect()
    };
    let per_error = (PLACE * trial.model.rod().length).recip();
    // Residuals of the markers that are seen and of the prior, and their slopes by the load over its sizes.
    let look = |x: &DVector<f64>| -> Result<(DVector<f64>, DMatrix<f64>), ForwardError> {
        let (model, initial) = trial.with(&scaled(x));
        let run = Run {
            initial,
            sensitivities: load.iter().map(|(place, _)| *place).collect(),
            points: trial.release.tracks.iter().map(|track| track.at).collect(),
            trace_step: None,
            samples: vec![0.0],
            ..Run::release(0.0, 1.0)
        };
        let seen = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
        let rows = 2 * targets.iter().flatten().count() + unknowns;
        let (mut residual, mut slopes) = (DVector::zeros(rows), DMatrix::zeros(rows, unknowns));
        let mut row = 0;
        for (t, target) in targets.iter().enumerate() {
            let Some(target) = target else { continue };
            for axis in 0..2 {
                residual[row] = per_error * (target[axis] - seen.points[0][t][axis]);
                for k in 0..unknowns {
                    slopes[(row, k)] = per_error * load[k].1 * seen.points_by_parameters[0][t][k][axis];
                }
                row += 1;
            }
        }
        for k in 0..unknowns {
            residual[row + k] = -x[k];
            slopes[(row + k, k)] = 1.0;
        }
        Ok((residual, slopes))
    };
    let mut x = DVector::zeros(unknowns);
    let (mut residual, mut slopes) = look(&x)?;
    let mut damping = 1.0;
    for _ in 0..MOST_ITERATIONS {
        let mut normal = slopes.tr_mul(&slopes);
        for k in 0..unknowns {
            normal[(k, k)] *= 1.0 + damping;
        }
        let Some(inverse) = normal.cholesky() else { break };
        let step = inverse.solve(&slopes.tr_mul(&residual));
        match look(&(&x + &step)) {
            Ok((other, of_other)) if other.norm_squared() < residual.norm_squared() => {
                (x, residual, slopes) = (x + &step, other, of_other);
                damping *= 0.2;
                if step.amax() < SETTLED {
                    break;
                }
            }
            _ if damping > 1e9 => break,
            _ => damping *= 5.0,
        }
    }
    Ok(scaled(&x))
}
