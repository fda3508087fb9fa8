//! Prediction: what a calibrated muscle will do in a case that nobody has recorded, with intervals.
//!
//! The errors of the calibration, with their correlations, and those of interpolation over pressure are drawn, and each
//! draw is simulated: an interval holds 95 % of the results. A calibration removes the error of the mesh from its
//! parameters, so a prediction removes it from its numbers. What a calibration cannot know is not in an interval: that
//! EI differs under load, or at amplitudes that were never seen. A warning says where a case lies outside the
//! calibration.

pub mod check;
pub mod ensemble;
pub mod errors;
pub mod grid;
mod interval;
pub mod linear;
mod model_error;
pub mod quantity;
pub mod request;
pub mod simulated;
pub mod span;
mod warnings;

use efam_core::forward::Run;
use efam_core::left_out;
use efam_experiments::scenario::Case;
use efam_experiments::summary;
use models::model::Model;
use models::muscle::Known;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use errors::Errors;
use interval::of_draws;
use model_error::ModelError;
use quantity::{Off, QUANTITIES, Quantity, REST, seen};
use simulated::{Mesh, Simulated, simulate, simulate_many};
use warnings::{Extent, warnings};

/// How a prediction is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionSettings {
    /// Draws from the errors of the calibration.
    pub draws: usize,
    /// Of the random numbers.
    pub seed: u64,
}

impl Default for PredictionSettings {
    /// Two hundred: the ends of an interval are then known to a tenth of its width.
    fn default() -> Self {
        Self { draws: 200, seed: 1 }
    }
}

/// Prediction of one case; SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Prediction {
    /// Name of the case.
    pub name: String,
    /// Pressure above ambient, Pa.
    pub pressure_pa: Option<f64>,
    /// Mass of the payload, kg.
    pub payload_kg: f64,
    /// The numbers.
    pub quantities: Vec<Quantity>,
    /// Damping and frequency of each cycle, the largest swings first.
    pub cycles: Vec<Cycle>,
    /// Draws that were simulated; none where the muscle file has no calibration.
    pub draws: usize,
    /// Draws that could not be simulated.
    pub failed_draws: usize,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// From one upper peak to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cycle {
    /// Geometric mean of the heights of the two above the rest, m.
    pub amplitude_m: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Its interval.
    pub damping_ratio_95: Option<[f64; 2]>,
    /// Damped frequency, Hz.
    pub frequency_hz: f64,
    /// Its interval.
    pub frequency_hz_95: Option<[f64; 2]>,
}

/// The height of the tip over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    /// Time after release, s.
    pub time: Vec<f64>,
    /// Height, m.
    pub height: Vec<f64>,
    /// Its interval at each time, m; empty without draws.
    pub interval_95: Vec<[f64; 2]>,
}

/// Draws that one thread takes at a time: enough that places in a pack are seldom empty, few enough that threads end
/// together, and that all of their trajectories are in memory.
const BATCH: usize = 16;

/// A prediction with what is drawn of it.
#[derive(Clone, Debug, Default)]
pub struct PredictionOutcome {
    /// The numbers.
    pub prediction: Prediction,
    /// The height of the tip.
    pub band: Band,
    /// The rod at rest and at the lowest point of the tip, m.
    pub postures: Vec<(&'static str, Vec<[f64; 2]>)>,
}

/// A case that cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct PredictError {
    /// The case.
    pub name: String,
    /// What happened.
    pub reason: String,
}

/// Predicts a case; `known` is what a calibration says of its muscle. `tell` is called after each draw, from
/// any thread.
/// # Errors
/// [`PredictError`] where the case itself cannot be simulated to its end; a draw that cannot is counted.
pub fn predict(
    case: &Case,
    known: Option<&Known>,
    settings: &PredictionSettings,
    tell: &(dyn Fn() + Sync),
) -> Result<PredictionOutcome, PredictError> {
    let run = Run { energy: false, ..case.run.clone() };
    let errors = known.map(|known| Errors::new(known, case));
    let model = errors.as_ref().map_or(&case.model, |errors| &errors.model);
    let simulated = simulate(model, &run);
    let mut own = simulated.map_err(|reason| PredictError { name: case.name.clone(), reason })?;
    let mesh = mesh_of(known, &own, model, &run);
    mesh.iter().for_each(|mesh| mesh.removed(&mut own));
    // A batch of draws; none of those that cannot be.
    let simulate_draws = |draws: &[usize]| {
        let drawn = |draw: &usize| errors.as_ref().and_then(|errors| errors.drawn(settings.seed, *draw));
        let models: Vec<_> = draws.iter().filter_map(drawn).collect();
        let mut done: Vec<Simulated> = simulate_many(&models, &run).into_iter().flatten().collect();
        if let Some(mesh) = &mesh {
            done.iter_mut().for_each(|done| mesh.removed(done));
        }
        draws.iter().for_each(|_| tell());
        done
    };
    let model_error = known.and_then(|known| ModelError::of(known, case, &own));
    let widened = |off: Off, value: f64, interval: [f64; 2]| {
        model_error.as_ref().map_or(interval, |error| error.widened(off, value, interval))
    };
    let count = if errors.is_some() { settings.draws } else { 0 };
    let draws: Vec<usize> = (0..count).collect();
    let all: Vec<Simulated> = draws.par_chunks(BATCH).flat_map_iter(simulate_draws).collect();
    let mut prediction = Prediction {
        name: case.name.clone(),
        pressure_pa: case.pressure,
        payload_kg: case.model.value_or_zero("effects.payload.mass"),
        quantities: own.quantities(|k, value| {
            let drawn = all.iter().filter_map(|one| one.numbers[k]).collect();
            Some(widened(QUANTITIES[k].off, value, of_draws(value, drawn, all.len())?))
        }),
        cycles: cycles(&own, &all, &widened),
        draws: all.len(),
        failed_draws: count - all.len(),
        warnings: case.warnings.clone(),
    };
    if let Some(marker) = known.and_then(|known| known.marker.as_ref()) {
        let seen = seen(&prediction.quantities, marker);
        prediction.quantities.splice(REST.len()..REST.len(), seen);
    }
    let extent = Extent {
        pressures: case.pressure.as_slice(),
        payloads: &[prediction.payload_kg],
        excursion: own.excursion,
    };
    prediction.warnings.extend(warnings(&extent, known, errors.as_slice()));
    // A payload without a size is in the intervals, if there are any.
    prediction.warnings.extend(left_out::warnings(model, case.muscle().is_some(), 1));
    if prediction.failed_draws > 0 {
        let words = format!("{} draws could not be simulated, and are left out", prediction.failed_draws);
        prediction.warnings.push(words);
    }
    Ok(PredictionOutcome { prediction, band: band(&own, &all, &widened), postures: own.postures })
}

/// What the mesh does to the prediction, where a calibration found its numbers without a mesh.
fn mesh_of(known: Option<&Known>, own: &Simulated, model: &Model, run: &Run) -> Option<Mesh> {
    known.filter(|known| known.nodes.is_none()).and_then(|_| Mesh::of(own, model, run))
}

/// Puts the error of the model into the interval of a number.
type Widened<'a> = &'a dyn Fn(Off, f64, [f64; 2]) -> [f64; 2];

fn cycles(own: &Simulated, all: &[Simulated], widened: Widened) -> Vec<Cycle> {
    let interval_of = |k: usize, off: Off, what: fn(&summary::Cycle) -> f64| {
        let drawn = all.iter().filter_map(|one| one.cycles.get(k).map(what));
        let value = what(&own.cycles[k]);
        Some(widened(off, value, of_draws(value, drawn.collect(), all.len())?))
    };
    let cycle = |(k, cycle): (usize, &summary::Cycle)| Cycle {
        amplitude_m: cycle.amplitude_m,
        damping_ratio: cycle.damping_ratio,
        damping_ratio_95: interval_of(k, Off::Damping, |cycle| cycle.damping_ratio),
        frequency_hz: cycle.damped_frequency_hz,
        frequency_hz_95: interval_of(k, Off::Frequency, |cycle| cycle.damped_frequency_hz),
    };
    own.cycles.iter().enumerate().map(cycle).collect()
}

fn band(own: &Simulated, all: &[Simulated], widened: Widened) -> Band {
    let at = |k: usize| {
        let drawn = all.iter().filter_map(|one| one.height.get(k).copied());
        Some(widened(Off::Swing, own.height[k], of_draws(own.height[k], drawn.collect(), all.len())?))
    };
    Band {
        time: own.time.clone(),
        height: own.height.clone(),
        interval_95: (0..own.height.len()).map_while(at).collect(),
    }
}
