//! A whole run, with the numbers of `efam simulate` for the scenario of the same setup.

use std::ops::ControlFlow;

use efam_core::forward::forward;
use serde::Serialize;

use crate::error::PlaygroundError;
use crate::setup::Setup;

/// A run, sampled.
#[derive(Clone, Debug, Serialize)]
pub struct Path {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// Observed tip, m.
    pub tip: Vec<[f64; 2]>,
    /// Its velocity, m/s.
    pub tip_velocity: Vec<[f64; 2]>,
    /// Kinetic, elastic, potential and dissipated energy, J.
    pub energy: Vec<[f64; 4]>,
    /// Accepted steps.
    pub steps: usize,
}

/// Simulates a release.
pub fn release(setup: &Setup) -> Result<Path, PlaygroundError> {
    let model = setup.model()?;
    let run = setup.run(&model)?;
    let found = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
    let energy = found.energy.iter().map(|e| [e.kinetic, e.elastic, e.potential, e.dissipated]);
    Ok(Path {
        energy: energy.collect(),
        time: found.times,
        tip: found.tip,
        tip_velocity: found.tip_velocity,
        steps: found.effort.steps,
    })
}
