//! The numerics gate: before anything is asked, mesh and step must be a matter of no consequence.
//!
//! A fit removes what mesh and step do, up to a part that it estimates. What is left stays the same from
//! sample to sample, so that far less of it than the noise of one passes for a missing effect: a muscle of 16
//! nodes has had five of nine experiments with nothing hidden called something else. So the mesh is made
//! finer until that part is a small share of the noise.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::calibrate::joint::Joint;
use crate::calibrate::prediction::Measured;
use crate::calibrate::refine::RESOLUTION_FITTED;
use crate::calibrate::view::Series;
use crate::calibrate::{CalibrateError, Problem};

/// Mesh and step, as a diagnosis found them and left them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Numerics {
    /// Nodes of the models as they were given, the most of all releases.
    pub nodes_given: usize,
    /// Nodes that were taken.
    pub nodes: usize,
    /// Bound of the remaining mesh error over the noise, the largest of all releases.
    pub left: f64,
}

/// What may be left, over the noise.
const LARGEST_ERROR: f64 = 0.2;
/// Nodes beyond which no mesh is made finer.
const MOST_NODES: usize = 130;

/// A model fitted on a mesh that is fine enough, if one is.
pub(super) fn on_fine_mesh(
    problem: &Problem,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<(Joint, Numerics), CalibrateError> {
    let nodes_given = nodes(problem);
    let mut fitted = Joint::search(problem, tell)?;
    if let Some(problem) = with_errors_of_laws(&fitted)
        && let Some(fit) = Joint::follow(&problem, &fitted.known(), RESOLUTION_FITTED)?
    {
        fitted = fit;
    }
    let mut left = left_of_mesh(&fitted);
    while left > LARGEST_ERROR && 2 * nodes(&fitted.problem) <= MOST_NODES {
        let mut finer = fitted.problem.clone();
        let refined = finer.trials_mut().try_for_each(|trial| trial.refine(2));
        if refined.is_err() {
            break;
        }
        tell(&format!("mesh error up to {left:.2} times the noise: now {} nodes", nodes(&finer)));
        let Some(fit) = Joint::follow(&finer, &fitted.known(), RESOLUTION_FITTED)? else { break };
        fitted = fit;
        left = left_of_mesh(&fitted);
    }
    let numerics = Numerics { nodes_given, nodes: nodes(&fitted.problem), left };
    Ok((fitted, numerics))
}

/// Error of a law in what it explains: no law of a material, or of the air, is known to better than a tenth. An effect that
/// is less than that of what the model misses is not looked for.
pub(super) const LAW: f64 = 0.1;

/// The problem with the error of a law that explains what a fit misses, beside the noise of each track; none where the
/// noise is larger. What held-out releases would miss is not known, and taken to be what the fitted ones miss on average.
fn with_errors_of_laws(fit: &Joint) -> Option<Problem> {
    let error = |(series, noise): (&Series, &f64)| {
        let squares = series.lengths().map(|length| 0.5 * (noise * length).powi(2)).sum::<f64>();
        let missed = (squares / series.residual.len().max(1) as f64 - noise * noise).max(0.0).sqrt();
        if LAW * missed > *noise { LAW * missed } else { 0.0 }
    };
    let releases = fit.found.at.carried.blocks.iter().zip(&fit.objective.measured);
    let errors: Vec<Vec<f64>> =
        releases.map(|(block, measured)| block.iter().zip(&measured.noise).map(error).collect()).collect();
    let all: Vec<f64> = errors.iter().flatten().copied().collect();
    let usual = (all.iter().map(|error| error * error).sum::<f64>() / all.len().max(1) as f64).sqrt();
    if usual == 0.0 {
        return None;
    }
    let mut problem = fit.problem.clone();
    let mut fitted = errors.into_iter();
    for release in problem.trials_mut().map(|trial| &mut trial.release) {
        let own = if release.held_out { None } else { fitted.next() };
        let own = own.unwrap_or_else(|| vec![usual; release.tracks.len()]);
        for (track, error) in release.tracks.iter_mut().zip(own) {
            track.discrepancy = track.discrepancy.hypot(error);
        }
    }
    Some(problem)
}

fn nodes(problem: &Problem) -> usize {
    problem.trials.iter().map(|trial| trial.model.edges + 1).max().unwrap_or(0)
}

/// Bound of the remaining mesh error over the noise, the largest of all releases.
fn left_of_mesh(fit: &Joint) -> f64 {
    let Some(left) = &fit.left_of_mesh else { return 0.0 };
    let own = |(left, measured): (&f64, &Measured)| {
        let noise = measured.noise.iter().copied().fold(f64::INFINITY, f64::min);
        left / noise
    };
    left.iter().zip(&fit.objective.measured).map(own).fold(0.0, f64::max)
}

/// What should be known of it.
pub(super) fn warning(numerics: &Numerics) -> Option<String> {
    let Numerics { nodes_given, nodes, left } = numerics;
    if *left > LARGEST_ERROR {
        Some(format!(
            "with {nodes} nodes the mesh error may be {left:.2} times the noise: small effects can come from it; give the recordings a larger noise"
        ))
    } else if nodes > nodes_given {
        Some(format!(
            "{nodes_given} nodes cannot separate an effect from the mesh error: {nodes} are used, also in the repaired model"
        ))
    } else {
        None
    }
}
