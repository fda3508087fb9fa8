//! What a prediction leaves on disk, and its table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html              all of it, for people
//!   prediction.json          numbers with intervals, cycles, warnings
//!   prediction.svg           height of the tip, rod, damping and frequency over amplitude
//!   scenario.resolved.toml   the case, for `efam simulate`
//!   summary.json             what was asked, by which command
//! ```

pub(super) mod page;

use std::fmt::Write;
use std::time::SystemTime;

use serde_json::json;

use super::folder::Folder;
use super::page::REPORT;
use super::picture::predicted;
use super::report::{readable, significant};
use super::{Request, ResultsError, SCENARIO, write_mark};
use crate::predict::{Outcome, Prediction};

/// The numbers.
pub const PREDICTION: &str = "prediction.json";
/// The picture.
pub const PICTURE: &str = "prediction.svg";

/// Writes a prediction into an open folder.
/// # Errors
/// [`ResultsError::Write`].
pub fn write_prediction(folder: &Folder, request: &Request, outcome: &Outcome) -> Result<(), ResultsError> {
    let prediction = &outcome.prediction;
    let text = serde_json::to_string_pretty(prediction).expect("a prediction has nothing that JSON has not");
    folder.write(PREDICTION, text.as_bytes())?;
    let (picture, written) = (predicted(outcome), SystemTime::now());
    folder.write(PICTURE, picture.svg.as_bytes())?;
    folder.write(REPORT, page::of_one(request, prediction, &[picture], written).as_bytes())?;
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "prediction", written, json!({}))
}

/// A value, so many times finer, with its unit and its interval.
pub(super) fn with_interval(value: f64, interval: Option<[f64; 2]>, factor: f64, unit: &str) -> String {
    let value = format!("{} {unit}", significant(factor * value, 4));
    let value = value.trim_end();
    match interval.map(|ends| ends.map(|end| significant(factor * end, 4))) {
        Some([low, high]) => format!("{value} ({low} to {high})"),
        None => value.to_owned(),
    }
}

/// A prediction as a table for people.
pub fn prediction_table(prediction: &Prediction) -> String {
    let mut text = format!("{:40}{:>12}   95 % interval\n", prediction.name, "");
    for quantity in &prediction.quantities {
        let (factor, unit) = readable(&quantity.unit);
        let Some(value) = quantity.value else {
            let why = quantity.missing.as_deref().unwrap_or("there is none");
            let _ = writeln!(text, "{:40}{:>12}   {why}", quantity.meaning, "-");
            continue;
        };
        let interval = quantity.interval_95.map_or(String::new(), |[low, high]| {
            format!("{} to {} ", significant(factor * low, 4), significant(factor * high, 4))
        });
        let value = significant(factor * value, 4);
        let _ = writeln!(text, "{:40}{value:>12}   {interval}{unit}", quantity.meaning);
    }
    if let (Some(first), Some(last)) = (prediction.cycles.first(), prediction.cycles.last()) {
        for cycle in [first, last] {
            let name = format!("damping ratio at {} mm", significant(1e3 * cycle.amplitude_m, 3));
            let interval = cycle.damping_ratio_95.map_or(String::new(), |[low, high]| {
                format!("{} to {}", significant(low, 4), significant(high, 4))
            });
            let _ = writeln!(text, "{name:40}{:>12}   {interval}", significant(cycle.damping_ratio, 4));
        }
    }
    if prediction.draws > 0 {
        let _ = writeln!(text, "\nintervals from {} draws of the calibration's errors", prediction.draws);
    }
    for warning in &prediction.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
