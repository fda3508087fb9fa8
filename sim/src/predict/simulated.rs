//! One run of a case, and what it says.

use std::ops::ControlFlow;

use models::model::Model;

use super::quantity::Told;
use crate::forward::{Run, forward};
use crate::results::rest::rest;
use crate::results::summary::{MODES, summarise};
use crate::trajectory::Trajectory;

/// One run, and what it says.
pub(super) struct Simulated {
    pub told: Told,
    pub height: Vec<f64>,
    pub time: Vec<f64>,
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
    pub postures: Vec<(&'static str, Vec<[f64; 2]>)>,
}

/// Runs a model to its end.
/// # Errors
/// Why it cannot, in words.
pub(super) fn simulate(model: &Model, run: &Run) -> Result<Simulated, String> {
    let (mut root, mut lowest) = (0.0f64, (f64::INFINITY, Vec::new()));
    let trajectory: Trajectory = forward(model, run, &mut |sample| {
        let snapshot = sample.snapshot();
        root = root.max(snapshot.bending_moment.first().copied().unwrap_or(0.0).abs());
        if snapshot.tip[1] < lowest.0 {
            lowest = (snapshot.tip[1], [snapshot.nodes, vec![snapshot.tip]].concat());
        }
        ControlFlow::Continue(())
    })
    .map_err(|error| error.to_string())?;
    let at_rest = rest(model, run.duration, MODES);
    let (summary, _) = summarise(model, run, &trajectory, &at_rest);
    let at_rest = at_rest.map_err(|error| error.to_string())?;
    let [x, z] = at_rest.tip;
    let excursion = trajectory.tip.iter().map(|tip| (tip[0] - x).hypot(tip[1] - z)).fold(0.0, f64::max);
    let height = trajectory.tip.iter().map(|tip| tip[1]).collect();
    let told = Told { summary, root_moment: root, root_moment_at_rest: at_rest.root_moment };
    let postures =
        vec![("at rest", [at_rest.nodes.clone(), vec![at_rest.tip]].concat()), ("at its lowest", lowest.1)];
    Ok(Simulated { told, height, time: trajectory.times, excursion, postures })
}

/// A parameter of a model, zero where it has none.
pub(super) fn value(model: &Model, path: &str) -> f64 {
    model.index(path).map_or(0.0, |k| model.theta[k])
}
