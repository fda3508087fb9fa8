//! Predictions beside recordings that took no part in the calibration, and how often intervals hold.
//!
//! Each release is predicted as it was made: with the pressure, payload, clamp and start that the experiment gives, by
//! the calibrated rod. What was measured is analysed as `efam analyse` does it.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::path::Path;

use efam_experiments::analyse::measured;
use efam_experiments::analysis::measured::Measured;
use efam_experiments::cleaning::{CleanRelease, Cleaned};
use efam_experiments::experiment::{Experiment, ExperimentError};
use efam_experiments::scenario::Case;
use efam_store::MARK;
use efam_store::input;
use models::muscle::{Known, Marker};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::quantity::{REST, SEEN};
use super::{PredictError, Prediction, PredictionSettings, predict};
use crate::calibrate::{CalibrateError, SectionError, marker_error, trial};
use crate::normal::NORMAL_95;

/// Predictions of the releases of an experiment, beside what was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Check {
    /// Name of the experiment.
    pub name: String,
    /// Each release that is used.
    pub releases: Vec<Checked>,
    /// Numbers with an interval, of releases that took no part in the calibration.
    pub compared: usize,
    /// Those of them whose interval holds what was measured.
    pub held: usize,
    /// Caveats of the counts.
    pub warnings: Vec<String>,
}

/// One release.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Checked {
    /// Its name.
    pub name: String,
    /// Whether the calibration was fitted to it, so that it proves nothing.
    pub took_part: bool,
    /// Pressure above ambient, Pa.
    pub pressure_pa: Option<f64>,
    /// Mass of the payload, kg.
    pub payload_kg: f64,
    /// Each number that was measured and predicted.
    pub numbers: Vec<Number>,
    /// Caveats of its numbers.
    pub warnings: Vec<String>,
}

/// One number, measured and predicted; SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Number {
    /// Its name, with the unit, as in a prediction.
    pub name: String,
    /// What it is, in words.
    pub meaning: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// What was measured.
    pub measured: f64,
    /// Its standard error, as far as it is known: of a rest by the decay and by the place of the marker, of a frequency
    /// by its cycles, of a damping ratio by the scatter of its peaks.
    pub measured_error: f64,
    /// What was predicted.
    pub predicted: f64,
    /// The interval of the prediction.
    pub interval_95: Option<[f64; 2]>,
    /// Whether that holds what was measured, whose error counts as well; none without an interval.
    pub holds: Option<bool>,
}

/// Why predictions cannot be set beside recordings.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The experiment.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A start that the model cannot have.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// What the experiment says of its markers.
    #[error(transparent)]
    Section(#[from] SectionError),
    /// Neither the experiment nor the command names the calibrated rod.
    #[error(
        "{experiment}: says nothing of the rod; give the calibrated one too, as --muscle muscle.toml or rod.toml"
    )]
    NoModel {
        /// Its file.
        experiment: String,
    },
    /// One of the releases cannot be predicted.
    #[error(transparent)]
    Predict(#[from] PredictError),
}

/// Predicts every release of an experiment whose model is the calibrated one; `known` is what the calibration says of
/// its numbers, and `fitted` has the SHA-256 of the recordings that it was fitted to.
/// # Errors
/// [`CheckError`] for an experiment without a model, and where a release cannot be simulated.
pub fn check(
    experiment: &Experiment,
    cleaned: &Cleaned,
    known: Option<&Known>,
    fitted: &BTreeSet<String>,
    settings: &PredictionSettings,
) -> Result<Check, CheckError> {
    let marker = marker_error(experiment)?;
    let is_fitted = |file: &Path| input::sha256(file).is_ok_and(|hash| fitted.contains(&hash));
    let was_read: Vec<bool> = experiment.recordings.iter().map(|entry| is_fitted(&entry.file)).collect();
    let mut check = Check { name: experiment.name.clone(), ..Check::default() };
    for of in cleaned.used() {
        let angle = of.angle.or(Some(of.statistics.hold_angle));
        let Some(mut case) = experiment.case(of.recording, angle)? else {
            return Err(CheckError::NoModel { experiment: experiment.path.display().to_string() });
        };
        case.name.clone_from(&of.release.name);
        let start = trial(experiment, of, case.clone())?;
        (case.model, case.run) = (start.model, start.run);
        let took_part = was_read[of.recording] && !of.release.held_out;
        check.releases.push(one(of, case, known, settings, (took_part, marker))?);
    }
    let counted = check.releases.iter().filter(|release| !release.took_part);
    let holds: Vec<bool> =
        counted.flat_map(|own| own.numbers.iter().filter_map(|number| number.holds)).collect();
    (check.compared, check.held) = (holds.len(), holds.iter().filter(|held| **held).count());
    check.warnings = warnings(&check, known);
    check.warnings.extend(cleaned.warnings());
    Ok(check)
}

fn warnings(check: &Check, known: Option<&Known>) -> Vec<String> {
    let mut words = Vec::new();
    if known.is_none() {
        words.push("the rod has no [calibration], so its predictions have no intervals".to_owned());
    }
    let took_part = check.releases.iter().filter(|release| release.took_part).count();
    if took_part > 0 {
        words.push(format!(
            "{took_part} of {} releases took part in the calibration, and are not counted",
            check.releases.len()
        ));
    }
    words
}

fn one(
    of: &CleanRelease,
    mut case: Case,
    known: Option<&Known>,
    settings: &PredictionSettings,
    (took_part, marker): (bool, f64),
) -> Result<Checked, CheckError> {
    // As long as the tip was seen to swing.
    case.run.duration = of.release.time.last().map_or(of.swings_until, |last| last.min(of.swings_until));
    let case = case.paced();
    let prediction = predict(&case, known, settings, &|| ())?.prediction;
    let (measured, rest) = measured(of);
    let error = rest.map_or([marker; 2], |rest| rest.error.map(|error| error.hypot(marker)));
    let rest = rest.map_or(of.statistics.rest, |rest| rest.position);
    let calibrated = known.and_then(|known| known.marker.as_ref());
    let is_seen = |marker: &Marker| of.release.tracks[of.release.leading_track()].marker == marker.name;
    let names = if calibrated.is_some_and(is_seen) { SEEN } else { REST };
    let mut warnings = prediction.warnings.clone();
    let measured = measured.map_err(|error| warnings.push(error.to_string())).ok();
    Ok(Checked {
        name: of.release.name.clone(),
        took_part,
        pressure_pa: prediction.pressure_pa,
        payload_kg: prediction.payload_kg,
        numbers: numbers(&prediction, names, (rest, error), measured.as_ref()),
        warnings,
    })
}

/// What a recording and a prediction both say; `rest` with its standard error, and its names among the quantities.
fn numbers(
    prediction: &Prediction,
    names: [&str; 2],
    (rest, error): ([f64; 2], [f64; 2]),
    measured: Option<&Measured>,
) -> Vec<Number> {
    // After the first, large swings are left out, frequency and damping ratio are of another motion.
    let whole = measured.filter(|measured| measured.since == 0.0);
    let frequency = whole.and_then(|whole| {
        let frequency = *whole.damped_frequency.as_ref().ok()? / TAU;
        Some((frequency, whole.frequency_error().unwrap_or(0.0) * frequency))
    });
    let damping = whole.and_then(|whole| {
        let decay = whole.decay.as_ref().ok()?;
        Some((decay.damping_ratio, decay.ratio_error))
    });
    let told = [
        (names[0], Some((rest[0], error[0]))),
        (names[1], Some((rest[1], error[1]))),
        ("frequency_hz", frequency),
        ("damping_ratio", damping),
    ];
    let number = |(name, told): (&str, Option<(f64, f64)>)| {
        let (measured, measured_error) = told?;
        let quantity = prediction.quantities.iter().find(|quantity| quantity.name == name)?;
        let predicted = quantity.value?;
        Some(Number {
            name: quantity.name.clone(),
            meaning: quantity.meaning.clone(),
            unit: quantity.unit.clone(),
            measured,
            measured_error,
            predicted,
            interval_95: quantity.interval_95,
            holds: quantity.interval_95.map(|ends| holds(predicted, ends, measured, measured_error)),
        })
    };
    told.into_iter().filter_map(number).collect()
}

/// Whether a prediction and a measurement agree at 95 %: errors of both, independent of one another.
fn holds(predicted: f64, [low, high]: [f64; 2], measured: f64, error: f64) -> bool {
    let end = if measured < predicted { low } else { high };
    (measured - predicted).abs() <= (end - predicted).abs().hypot(NORMAL_95 * error)
}

/// SHA-256 of the files that the calibration beside a muscle or rod file read; empty where nothing says so.
pub fn fitted_files(rod: &Path) -> BTreeSet<String> {
    let mark = rod.parent().map(|folder| folder.join(MARK));
    let text = mark.and_then(|mark| input::text(&mark).ok());
    let summary: Option<Value> = text.and_then(|text| serde_json::from_str(&text).ok());
    let hashes = summary.as_ref().and_then(|summary| summary.get("inputs_sha256")?.as_object());
    hashes.into_iter().flatten().filter_map(|(_, hash)| hash.as_str().map(str::to_owned)).collect()
}

#[cfg(test)]
mod tests {
    use super::holds;

    /// An interval from 8 to 11 about 10: each side has its own end, and the error of the measurement adds to it.
    #[test]
    fn both_errors_count() {
        assert!(holds(10.0, [8.0, 11.0], 8.1, 0.0) && !holds(10.0, [8.0, 11.0], 7.9, 0.0));
        assert!(holds(10.0, [8.0, 11.0], 10.9, 0.0) && !holds(10.0, [8.0, 11.0], 11.1, 0.0));
        assert!(holds(10.0, [8.0, 11.0], 11.5, 1.0) && !holds(10.0, [8.0, 11.0], 12.3, 1.0));
    }
}
