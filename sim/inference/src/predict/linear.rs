//! The linear model of a calibrated rod: how far the errors of its calibration move poles, gains and responses.

use std::f64::consts::TAU;

use efam_core::linear::{Complex, DMatrix, Linear, Pole, linearise};
use efam_experiments::scenario::Case;
use models::muscle::Known;
use rayon::prelude::*;

use super::PredictionSettings;
use super::errors::Errors;
use super::interval::of_draws;
use super::model_error::ModelError;
use super::quantity::Off;
use super::warnings::{Extent, warnings};

/// Intervals that hold 95 % of what the errors of a calibration admit; shapes `[outputs, inputs]`, SI.
#[derive(Clone, Debug, Default)]
pub struct LinearIntervals {
    /// Draws that have a linear model.
    pub draws: usize,
    /// Draws that have none.
    pub failed_draws: usize,
    /// Undamped frequency, Hz, damping ratio, and time in which it decays to 5 %, s, of each bending vibration, slowest first.
    pub vibrations: Vec<[Option<[f64; 2]>; 3]>,
    /// Of the static gain.
    pub static_gain: Ends,
    /// Of the size of the response, at each frequency.
    pub gain: Vec<Ends>,
    /// Of its phase at each frequency, rad, from that of the model itself.
    pub phase: Vec<Ends>,
    /// Of the step response, at each time.
    pub step: Vec<Ends>,
}

const PUBLISHED_SLOPE: &str = "EI was not calibrated at two pressures: its slope over pressure is the published one, and intervals of \
    the gain from pressure exclude its error";

/// Lower and upper ends of intervals.
pub type Ends = DMatrix<[f64; 2]>;

/// What one model says.
struct Seen {
    vibrations: Vec<Pole>,
    static_gain: DMatrix<f64>,
    response: Vec<DMatrix<Complex>>,
    step: Vec<DMatrix<f64>>,
}

impl Seen {
    fn of(linear: &Linear, frequencies: &[f64], times: &[f64]) -> Self {
        let response = |f: &f64| linear.modal.response(Complex::new(0.0, TAU * f));
        Self {
            vibrations: linear.modal.vibrations(),
            static_gain: linear.modal.static_gain(),
            response: frequencies.iter().map(response).collect(),
            step: times.iter().map(|time| linear.modal.step(*time)).collect(),
        }
    }
}

/// A case as its calibration says that it is: its loss at its own frequency, and a payload without a size as a compact body, as in a
/// prediction.
pub struct Calibrated {
    /// The case.
    pub case: Case,
    /// What to know before its linear model is used.
    pub warnings: Vec<String>,
    errors: Errors,
    model_error: Option<ModelError>,
}

impl Calibrated {
    /// Of what a calibration knows.
    pub fn of(case: &Case, known: &Known) -> Self {
        let errors = Errors::new(known, case);
        let payload = case.model.value_or_zero("effects.payload.mass");
        // Small motions go nowhere.
        let extent = Extent { pressures: case.pressure.as_slice(), payloads: &[payload], excursion: 0.0 };
        let mut warnings = warnings(&extent, Some(known), std::slice::from_ref(&errors));
        if case.rod_slopes().is_some() && !errors.has_slope() {
            warnings.push(PUBLISHED_SLOPE.to_owned());
        }
        let model_error = known.misfit.map(|misfit| ModelError { misfit, excursion: 0.0, length: 1.0 });
        Self { case: case.run_as(&errors.model, &case.run), warnings, errors, model_error }
    }

    /// The intervals of its linear model, at frequencies, Hz, and times, s. Frequency and damping ratio of the first vibration have the
    /// error of the model in them, as in a prediction. The slope of EI over pressure is drawn with EI.
    pub fn intervals(
        &self,
        own: &Linear,
        (frequencies, times): (&[f64], &[f64]),
        settings: &PredictionSettings,
        tell: &(dyn Fn() + Sync),
    ) -> LinearIntervals {
        let names = |signals: &[efam_core::linear::Signal]| -> Vec<String> {
            signals.iter().map(|signal| signal.name.clone()).collect()
        };
        let (inputs, outputs) = (names(&own.inputs), names(&own.outputs));
        let seen = |draw: usize| {
            let slopes = self.case.rod_slopes().map(|slopes| self.errors.slopes(settings.seed, draw, slopes));
            let linear = linearise(&self.errors.drawn(settings.seed, draw)?, slopes, &inputs, &outputs).ok();
            tell();
            Some(Seen::of(&linear?, frequencies, times))
        };
        let all: Vec<Seen> = (0..settings.draws).into_par_iter().filter_map(seen).collect();
        let own = Seen::of(own, frequencies, times);
        // Half of the draws have each number of the response: they have all of it or nothing.
        let ends = |value: &dyn Fn(&Seen, (usize, usize)) -> f64| {
            Ends::from_fn(outputs.len(), inputs.len(), |output, input| {
                let at = |seen: &Seen| value(seen, (output, input));
                of_draws(at(&own), all.iter().map(at).collect(), all.len()).unwrap_or([at(&own); 2])
            })
        };
        let vibration = |k: usize, off: Off, of: fn(&Pole) -> f64| {
            let value = of(&own.vibrations[k]);
            let drawn = all.iter().filter_map(|seen| seen.vibrations.get(k).map(of)).collect();
            let interval = of_draws(value, drawn, all.len())?;
            let widened = |error: &ModelError| error.widened(off, value, interval);
            Some(self.model_error.as_ref().filter(|_| k == 0).map_or(interval, widened))
        };
        let phase = |k: usize| {
            let from_own =
                |seen: &Seen, at: (usize, usize)| (seen.response[k][at] / own.response[k][at]).arg();
            ends(&from_own)
        };
        LinearIntervals {
            draws: all.len(),
            failed_draws: settings.draws - all.len(),
            vibrations: (0..own.vibrations.len())
                .map(|k| {
                    [
                        vibration(k, Off::Frequency, |pole| pole.frequency),
                        vibration(k, Off::Damping, |pole| pole.damping_ratio),
                        vibration(k, Off::Damping, Pole::settling),
                    ]
                })
                .collect(),
            static_gain: ends(&|seen, at| seen.static_gain[at]),
            gain: (0..frequencies.len()).map(|k| ends(&|seen, at| seen.response[k][at].norm())).collect(),
            phase: (0..frequencies.len()).map(phase).collect(),
            step: (0..times.len()).map(|k| ends(&|seen, at| seen.step[k][at])).collect(),
        }
    }
}
