//! How often to look at a rod: what its slowest mode says.

use models::digits::{short, significant};
use models::model::Model;

use crate::rest::slowest_frequency;

/// Samples a second of a rod that swings slowly, as the paper's cameras took them.
pub const DEFAULT_RATE: f64 = 100.0;
/// Samples of a period of the slowest mode that are stored at least, unless a rate is given.
const STORED: f64 = 20.0;
/// Points of a period that are traced: a parabola through three of them finds a peak to 2e-5 of its height.
const TRACED: f64 = 50.0;
/// Samples of a period below which a path does not show its swing.
const SHOWN: f64 = 5.0;
/// Samples that a rate is raised to at most, and points of a trace.
const MOST_SAMPLES: f64 = 1e5;
const MOST_POINTS: f64 = 4e6;

/// How often a run is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// Samples a second, Hz.
    pub rate: f64,
    /// Time between points of the trace, s: one sample, or a whole part of that.
    pub trace_step: f64,
    /// What to know of samples that are too far apart.
    pub warning: Option<String>,
}

impl Pace {
    /// That of a model, for a rate that is given or chosen, and a duration, s.
    pub fn of(model: &Model, rate: Option<f64>, duration: f64) -> Self {
        let slowest = slowest_frequency(model).unwrap_or(0.0);
        let raised = DEFAULT_RATE.max(round_up(STORED * slowest).min(MOST_SAMPLES / duration));
        let chosen = rate.unwrap_or(raised);
        let points = (TRACED * slowest).min(MOST_POINTS / duration);
        let trace_step = 1.0 / (chosen * (points / chosen).ceil().max(1.0));
        let warning = (chosen < SHOWN * slowest).then(|| {
            let seen = if TRACED * slowest * duration > 2.0 * MOST_POINTS {
                "frequency, damping and settling are not analysed over so many swings"
            } else {
                "frequency, damping and settling are those of the integrator's own path"
            };
            format!(
                "samples at {} Hz do not show a swing of {} Hz; {seen}; run.rate = \"{} Hz\" shows it",
                short(chosen),
                significant(slowest, 3),
                round_up(STORED * slowest)
            )
        });
        Self { rate: chosen, trace_step, warning }
    }
}

/// The next number of two digits.
fn round_up(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    (value / unit).ceil() * unit
}
