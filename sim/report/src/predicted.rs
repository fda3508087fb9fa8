//! What a prediction leaves on disk, and its table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html              all of it, for people
//!   prediction.json          numbers with intervals, cycles, warnings
//!   prediction.svg           height of the tip, rod, damping and frequency over amplitude
//!   scenario.resolved.toml   the case, for `efam simulate`
//!   summary.json             the request, and its command
//! ```

pub(super) mod answers;
pub(super) mod page;

use std::fmt::Write;
use std::time::SystemTime;

use efam_inference::predict::{Prediction, PredictionOutcome};
use efam_store::StoreError;
use efam_store::folder::Folder;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::interval::with_ends;
use crate::page::REPORT;
use crate::picture::predicted;
use crate::report::{readable, significant};
use crate::{Request, SCENARIO, write_mark};

/// The numbers.
pub const PREDICTION: &str = "prediction.json";
/// The picture.
pub const PICTURE: &str = "prediction.svg";

/// Writes a prediction into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_prediction(
    folder: &Folder,
    request: &Request,
    outcome: &PredictionOutcome,
) -> Result<(), StoreError> {
    let prediction = &outcome.prediction;
    let text = serde_json::to_string_pretty(prediction).expect("a prediction has nothing that JSON has not");
    folder.write(PREDICTION, text.as_bytes())?;
    let (picture, written) = (predicted(outcome), SystemTime::now());
    folder.write(PICTURE, picture.svg().as_bytes())?;
    folder.write(REPORT, page::of_one(request, prediction, &[picture], written).as_bytes())?;
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "prediction", written, json!({}))
}

/// A prediction as a table for people.
pub fn prediction_table(prediction: &Prediction) -> String {
    let mut table = Aligned::new(&[
        (prediction.name.as_str(), Side::Name),
        ("", Side::Number),
        ("95 % interval", Side::Words),
    ]);
    for quantity in &prediction.quantities {
        let (factor, unit) = readable(&quantity.unit);
        let Some(value) = quantity.value else {
            let why = quantity.missing.as_deref().unwrap_or("there is none");
            table.row([quantity.meaning.as_str(), "-", why]);
            continue;
        };
        let (value, interval) = with_ends(value, quantity.interval_95, factor);
        let interval = interval.map_or(String::new(), |[low, high]| format!("{low} to {high} "));
        table.row([quantity.meaning.clone(), value, format!("{interval}{unit}")]);
    }
    if let (Some(first), Some(last)) = (prediction.cycles.first(), prediction.cycles.last()) {
        for cycle in [first, last] {
            let name = format!("damping ratio at {} mm", significant(1e3 * cycle.amplitude_m, 3));
            let (ratio, interval) = with_ends(cycle.damping_ratio, cycle.damping_ratio_95, 1.0);
            let interval = interval.map_or(String::new(), |[low, high]| format!("{low} to {high}"));
            table.row([name, ratio, interval]);
        }
    }
    let mut text = table.to_string();
    if prediction.draws > 0 {
        let _ = writeln!(
            text,
            "\nintervals: {} draws from the errors of calibration and interpolation",
            prediction.draws
        );
    }
    for warning in &prediction.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
