//! Predictions as pages: of one case, and of several.

use std::time::SystemTime;

use efam_inference::predict::grid::{Cell, Grid};
use efam_inference::predict::quantity::{Quantity, units};
use efam_inference::predict::{Cycle, Prediction};

use crate::Request;
use crate::interval::{with_ends, with_interval};
use crate::page::{BeforeUse, Family, Page, Table};
use crate::picture::Picture;
use crate::predicted::answers::answers;
use crate::report::{readable, significant};

/// What any prediction takes for granted.
const ASSUMED: [&str; 3] = [
    "The same effects act as in the calibration: EI and losses are the same with the payload, at other amplitudes, and later.",
    "The payload is a rigid body at the tip; the air drags at it only if its frontal area is given.",
    "Intervals include the errors of the calibration and of interpolation over pressure. They exclude effects that the calibration could not show.",
];

/// The page of one case.
pub(crate) fn of_one(
    request: &Request,
    prediction: &Prediction,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let title = format!("Prediction: {}", prediction.name);
    let mut page = Page::new(&title, "Predicted", &lead(prediction));
    page.section("Numbers");
    page.table(&Table {
        caption: "Predicted numbers with 95 % intervals from the errors of calibration and interpolation",
        heads: &["", "value", "interval", "unit"],
        rows: prediction.quantities.iter().map(row).collect(),
    });
    page.section("The release");
    pictures.iter().for_each(|picture| page.figure(picture));
    page.section("Cycle by cycle");
    let cycle = |cycle: &Cycle| {
        let ratio = value_and_interval(cycle.damping_ratio, cycle.damping_ratio_95, 1.0);
        let frequency = value_and_interval(cycle.frequency_hz, cycle.frequency_hz_95, 1.0);
        [vec![significant(1e3 * cycle.amplitude_m, 3)], ratio.to_vec(), frequency.to_vec()].concat()
    };
    if prediction.cycles.is_empty() {
        page.text("It does not swing twice.")
    } else {
        page.folded(
            "Damping and frequency of each cycle",
            &Table {
                caption: "From one upper peak to the next",
                heads: &["amplitude, mm", "damping ratio", "interval", "frequency, Hz", "interval"],
                rows: prediction.cycles.iter().map(cycle).collect(),
            },
        )
    }
    let draws = match prediction.draws {
        0 => "none: the errors are unknown".to_owned(),
        draws => format!("{draws}, of which {} could not be simulated", prediction.failed_draws),
    };
    page.before_use(&before_use(&prediction.warnings));
    page.facts_of(request, written, vec![("draws from the errors of the calibration".to_owned(), draws)]);
    page.finish()
}

/// The page of several cases.
pub(crate) fn of_several(
    request: &Request,
    grid: &Grid,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let lead = answers(grid).into_iter().take(2).collect::<Vec<_>>().join("; ");
    let mut page = Page::new(&format!("Prediction: {}", grid.name), "Predicted", &(capital(&lead) + "."));
    page.section("Summary of the cases");
    page.list(&answers(grid));
    page.section("Pictures");
    let payloads: Vec<f64> = grid.cells.iter().map(|cell| 1e3 * cell.payload_kg).collect();
    let pressures: Vec<f64> = grid.cells.iter().filter_map(|cell| Some(1e-3 * cell.pressure_pa?)).collect();
    let family = if pressures.len() == payloads.len() {
        Family::default().by("pressure", "kPa", &pressures)
    } else {
        Family::default()
    };
    page.family(&family.by("payload", "g", &payloads));
    pictures.iter().for_each(|picture| page.figure(picture));
    page.section("Numbers of each case");
    for (k, (name, _)) in units().enumerate() {
        let Some(quantity) = grid.cells.iter().find_map(|cell| cell.quantity(name)) else { continue };
        let (factor, unit) = readable(&quantity.unit);
        let case = |cell: &Cell| {
            let own = cell.quantities.get(k);
            let [value, ends] = match own.and_then(|own| Some((own.value?, own.interval_95))) {
                Some((value, ends)) => value_and_interval(value, ends, factor),
                None => ["-".to_owned(), String::new()],
            };
            let pressure =
                cell.pressure_pa.map_or("-".to_owned(), |pressure| significant(1e-3 * pressure, 4));
            let payload = significant(1e3 * cell.payload_kg, 4);
            let outside = if cell.extrapolated == Some(true) { "outside what was calibrated" } else { "" };
            vec![pressure, payload, value, ends, outside.to_owned()]
        };
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        page.folded(
            &quantity.meaning,
            &Table {
                caption: &format!("{}{unit}", quantity.meaning),
                heads: &["pressure, kPa", "payload, g", "value", "interval", ""],
                rows: grid.cells.iter().map(case).collect(),
            },
        );
    }
    page.before_use(&before_use(&grid.warnings));
    page.facts_of(request, written, vec![("cases".to_owned(), grid.cells.len().to_string())]);
    page.finish()
}

fn lead(prediction: &Prediction) -> String {
    let told = |name: &str| {
        let quantity = prediction.quantities.iter().find(|quantity| quantity.name == name)?;
        let (factor, unit) = readable(&quantity.unit);
        let value = with_interval(quantity.value?, quantity.interval_95, factor, unit);
        Some(format!("{}: {value}", quantity.meaning))
    };
    let names = ["rest_z_m", "frequency_hz", "damping_ratio", "settling_5_percent_s"];
    capital(&names.into_iter().filter_map(told).collect::<Vec<_>>().join("; ")) + "."
}

fn row(quantity: &Quantity) -> Vec<String> {
    let (factor, unit) = readable(&quantity.unit);
    let [value, interval] = match (quantity.value, &quantity.missing) {
        (Some(value), _) => value_and_interval(value, quantity.interval_95, factor),
        (None, why) => [why.clone().unwrap_or("-".to_owned()), String::new()],
    };
    vec![quantity.meaning.clone(), value, interval, unit.to_owned()]
}

/// The cells of a number and of its interval.
fn value_and_interval(value: f64, ends: Option<[f64; 2]>, factor: f64) -> [String; 2] {
    let (value, ends) = with_ends(value, ends, factor);
    [value, ends.map_or(String::new(), |[low, high]| format!("{low} to {high}"))]
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// What lies outside what was calibrated is separate from other warnings.
fn before_use(warnings: &[String]) -> BeforeUse {
    let is_outside = |warning: &String| {
        ["lies outside", "extrapolated", "was calibrated to"].iter().any(|words| warning.contains(words))
    };
    let (extrapolated, warnings) = warnings.iter().cloned().partition(is_outside);
    BeforeUse {
        warnings,
        extrapolated: Some(extrapolated),
        assumed: ASSUMED.map(str::to_owned).to_vec(),
        ..BeforeUse::default()
    }
}
