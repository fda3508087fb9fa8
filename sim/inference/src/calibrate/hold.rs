//! A rod that is held bent before its release: the force and the moment of the hand, from the markers.
//!
//! The rod starts at rest under a dead load at its end (`effects::tip_hold`). The load is a nuisance parameter of its
//! release. Here it gets its first value: least squares on the places of the markers at the release, with what a hand may
//! do as a prior.
//!
//! A rod that begins in mid-swing starts likewise: its posture is the rest under such a load, its velocity that with which
//! this rest moves as force and moment change. Six numbers hold the first modes. Their first values are least squares on
//! the first quarter of a swing.

use std::ops::ControlFlow;

use efam_core::forward::{ForwardError, Initial, Run, forward};
use efam_core::levenberg_marquardt::{Evaluated, FIRST_DAMPING, Search, minimise};
use efam_experiments::release::Release;
use models::effects::tip_hold::{HELD, NAME, PULL};
use models::error::ModelError;
use models::model::Model;
use models::statics::{equilibrium, modes};
use nalgebra::{DMatrix, DVector};

use super::problem::Trial;
use super::stage::{MOST_EVALUATIONS, STAGE_SHARE, STAGE_TOLERANCE};

/// Time before the release in which the hand that holds the rod hardly moves, s.
pub(super) const LATE_HOLD: f64 = 0.1;
/// Error of a marker's place, over the rod's length: half a millimetre on the paper's muscle.
const PLACE: f64 = 3e-3;
/// Nodes of the rod while its load is looked for: the places of sixteen edges are within a tenth of [`PLACE`] of the
/// limit of fine meshes.
const NODES: usize = 17;

/// Sizes of what a hand does: forces that bend the rod by its length and bear what it weighs, rates that change them in
/// the time in which the end falls by that length, the moment of such a force, and its rate.
/// Source: a cantilever under a load at its end, `P = 3 EI w / L³`.
pub(crate) fn sizes(model: &Model) -> Result<[f64; 6], ModelError> {
    let rod = model.rod();
    let mass = rod.mass + model.value("effects.end_fitting.mass")? + model.value("effects.payload.mass")?;
    let gravity = model.value("effects.gravity.acceleration")?;
    let force = 3.0 * rod.bending_stiffness / rod.length.powi(2) + mass * gravity;
    let rate = force / (rod.length / gravity.max(1.0)).sqrt();
    Ok([force, force, rate, rate, force * rod.length, rate * rod.length])
}

/// Part of a swing on which a start in motion gets its first values.
const FIRST_PART: f64 = 0.25;
/// Samples that this has at least.
const FIRST_SAMPLES: usize = 4;

/// Angular frequency of the slowest mode of a trial about its rest, rad/s.
fn pace(trial: &Trial) -> Option<f64> {
    let mut model = trial.model.clone();
    model.schedule = None;
    let rest = equilibrium(&model, None).ok()?;
    Some(modes(&model, &rest, 1).ok()?.first()?.angular_frequency).filter(|pace| *pace > 0.0)
}

/// What moves the start of a trial, as far as its release can determine it: path, unit, and standard deviation. One marker does not
/// show the moment of a hand. Of a rod in motion the swing shows all, and its rates have its pace.
pub(crate) fn pulls(trial: &Trial) -> Result<Vec<(&'static str, &'static str, f64)>, ModelError> {
    let units = ["N", "N", "N/s", "N/s", "N m", "N m/s"];
    let mut sizes = sizes(&trial.model)?;
    let count = match trial.is_in_motion() {
        true => PULL.len(),
        false if trial.release.tracks.len() > 1 => PULL.len() - 1,
        false => PULL.len() - 2,
    };
    if trial.is_in_motion()
        && let Some(pace) = pace(trial)
    {
        let [x, z, _, _, moment, _] = sizes;
        sizes = [x, z, pace * x, pace * z, moment, pace * moment];
    }
    let all = PULL.into_iter().zip(units).zip(sizes);
    Ok(all.map(|((path, unit), size)| (path, unit, size)).take(count).collect())
}

/// Lets a trial start at rest in the hand that holds its markers where they are seen.
pub(crate) fn hold(trial: &mut Trial) -> Result<(), ForwardError> {
    trial.model = trial.model.with_effect(NAME, &[("held", 0.0)])?;
    let mut holding = trial.model.clone();
    holding.schedule = None;
    holding.set(HELD, 1.0)?;
    let own = vec![holding.index(HELD)?];
    trial.run.initial = Initial::Equilibrium { hold: Box::new(holding), own };
    let values = find(trial)?;
    (trial.model, trial.run.initial) = trial.with(&values);
    Ok(())
}

/// What is looked for: path, place in `theta`, and size. The rates of a hand show in the hold, not in a posture.
fn load(trial: &Trial) -> Result<Vec<(&'static str, usize, f64)>, ModelError> {
    let is_seen = |unit: &str| trial.is_in_motion() || !unit.ends_with("/s");
    let all = pulls(trial)?.into_iter().filter(|(_, unit, _)| is_seen(unit));
    all.map(|(path, _, size)| Ok((path, trial.model.index(path)?, size))).collect()
}

/// Where the tracks are: times, s, and places there. At the release or, of a rod in motion, at the first samples.
fn seen(trial: &Trial) -> Vec<(f64, Vec<Option<[f64; 2]>>)> {
    let release = &trial.release;
    if !trial.is_in_motion() {
        return vec![(0.0, targets(release))];
    }
    let last = pace(trial).map_or(0.0, |pace| FIRST_PART * std::f64::consts::TAU / pace);
    let all = release.time.iter().enumerate().filter(|(_, time)| **time >= 0.0);
    let first = all.enumerate().take_while(|(n, (_, time))| *n < FIRST_SAMPLES || **time <= last);
    first
        .map(|(_, (k, time))| (*time, release.tracks.iter().map(|track| track.position[k]).collect()))
        .collect()
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

/// The load that brings the markers nearest to where they are, beside what a hand may do.
fn find(trial: &Trial) -> Result<Vec<(usize, f64)>, ForwardError> {
    let mut trial = trial.clone();
    if trial.model.edges >= NODES {
        (trial.model, trial.run) = trial.run.on_mesh(&trial.model, NODES)?;
    }
    let targets = seen(&trial);
    let load = load(&trial)?;
    let unknowns = load.len();
    let scaled = |x: &DVector<f64>| -> Vec<_> {
        load.iter().zip(x.iter()).map(|((_, place, size), x)| (*place, size * x)).collect()
    };
    let per_error = (PLACE * trial.model.rod().length).recip();
    let look = |x: &DVector<f64>| -> Result<Evaluated<()>, ForwardError> {
        let (model, initial) = trial.with(&scaled(x));
        let run = Run {
            initial,
            sensitivities: load.iter().map(|(_, place, _)| *place).collect(),
            points: trial.release.tracks.iter().map(|track| track.at).collect(),
            trace_step: None,
            samples: targets.iter().map(|(time, _)| *time).collect(),
            ..Run::release(targets.last().map_or(0.0, |(time, _)| *time), 1.0)
        };
        let seen = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
        // The prior has a standard deviation of one.
        let (mut cost, mut gradient) = (0.5 * x.norm_squared(), x.clone());
        let mut hessian = DMatrix::identity(unknowns, unknowns);
        let all =
            targets.iter().enumerate().flat_map(|(n, (_, tracks))| (0..tracks.len()).map(move |t| (n, t)));
        for (n, t) in all {
            let Some(target) = targets[n].1[t] else { continue };
            for axis in 0..2 {
                let residual = per_error * (target[axis] - seen.points[n][t][axis]);
                let slope = |k: usize| per_error * load[k].2 * seen.points_by_parameters[n][t][k][axis];
                let slopes = DVector::from_fn(unknowns, |k, _| slope(k));
                cost += 0.5 * residual * residual;
                gradient -= residual * &slopes;
                hessian += &slopes * slopes.transpose();
            }
        }
        Ok(Evaluated { cost, gradient, hessian, carried: () })
    };
    let start = DVector::zeros(unknowns);
    look(&start)?;
    let search = Search {
        bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); unknowns],
        longest: vec![1.0; unknowns],
        tolerance: STAGE_TOLERANCE,
        relative: STAGE_SHARE,
        most_evaluations: MOST_EVALUATIONS,
        first_damping: FIRST_DAMPING,
        reuses_slopes: false,
        is_followed: true,
    };
    let found = minimise(&start, None, &search, &mut |x, _| look(x).ok());
    Ok(scaled(&found.map_or(start, |found| found.x)))
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use models::system::System;

    use super::*;

    /// Held as high as the clamp and pushed towards it, and pulled down.
    #[test]
    fn a_coarse_mesh_places_a_held_rod() {
        let model = muscle_at_15_psi();
        let size = sizes(&model).unwrap()[0];
        for (x, z) in [(0.0, 0.4), (-0.2, 0.4), (0.3, -0.5)] {
            let pull = [("held", 1.0), ("force_x", x * size), ("force_z", z * size)];
            let held = model.with_effect(NAME, &pull).unwrap();
            let tip = |nodes: usize| {
                let held = held.with_nodes(nodes).unwrap();
                let rest = equilibrium(&held, None).unwrap();
                System::new(&held).observed_tip(&rest.q, &vec![0.0; rest.q.len()]).0
            };
            let (coarse, fine) = (tip(NODES), tip(8 * (NODES - 1) + 1));
            let off = (coarse[0] - fine[0]).hypot(coarse[1] - fine[1]) / model.rod().length;
            println!("({x}, {z}): {off:e} of the length");
            assert!(off < 0.1 * PLACE, "({x}, {z}): {off} of the length");
        }
    }
}
