//! What a calibration leaves on disk.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   calibration.json       parameters, intervals, correlations, fit of each release, warnings
//!   muscle.toml            the muscle with the calibrated columns, for `efam simulate --muscle`
//!   rod.toml               the rod instead, where it is no muscle: a scenario
//!   experiment.toml        the experiment as it was read
//!   residuals.csv          measurement and fit, sample by sample
//!   fit-01.svg …           each track: fit over measurement, residuals, decay, damping
//!   parameters.svg         parameters over pressure
//!   report.html            the page for people, with the pictures that lie in pictures/
//!   summary.json           the parameters alone, and by which command
//! ```

mod model;
mod page;

use std::fmt::Write;
use std::time::SystemTime;

use efam_inference::calibrate::calibration::Calibrated;
use efam_inference::calibrate::repeats::{Repeats, Source};
use efam_inference::calibrate::{Calibration, CalibrationOutcome, Problem};
use efam_store::StoreError;
use efam_store::escape::cell;
use efam_store::folder::Folder;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::interval::with_ends;
use crate::page::REPORT;
use crate::picture::{against_markers, calibrated, fitted, over_pressure};
use crate::report::{significant, significant_or_dash};
use crate::{Request, write_mark};

pub use model::{ModelFile, Setup, models, muscle_file, rod_files};

/// File names of a calibration's folder.
pub const CALIBRATION: &str = "calibration.json";
/// The experiment.
pub const EXPERIMENT: &str = "experiment.toml";
/// The curves.
pub const RESIDUALS: &str = "residuals.csv";
/// The picture over pressure.
pub const PARAMETERS: &str = "parameters.svg";

/// Writes a calibration into an open folder; `request.resolved_scenario` is the experiment's text.
/// # Errors
/// [`StoreError::Write`].
pub fn write_calibration(
    folder: &Folder,
    request: &Request,
    problem: &Problem,
    outcome: &CalibrationOutcome,
    models: &[ModelFile],
) -> Result<(), StoreError> {
    let calibration = &outcome.calibration;
    let text =
        serde_json::to_string_pretty(calibration).expect("a calibration has nothing that JSON has not");
    folder.write(CALIBRATION, text.as_bytes())?;
    folder.write(EXPERIMENT, request.resolved_scenario.as_bytes())?;
    for model in models {
        folder.write(&model.name, model.text.as_bytes())?;
    }
    folder.write(RESIDUALS, residuals(outcome).as_bytes())?;
    for (k, curve) in outcome.curves.iter().enumerate() {
        folder.write(&format!("fit-{:02}.svg", k + 1), calibrated(curve).svg.as_bytes())?;
    }
    if let Some(picture) = over_pressure(&request.name, calibration) {
        folder.write(PARAMETERS, picture.svg.as_bytes())?;
    }
    let short = |found: &Calibrated| {
        json!({ "name": found.label(), "value": found.value, "unit": found.unit,
                "standard_error": found.standard_error, "interval_95": found.interval_95 })
    };
    let parameters: Vec<_> = calibration.parameters.iter().map(short).collect();
    let (mut pictures, written) = (fitted(calibration, &outcome.curves), SystemTime::now());
    pictures.extend(against_markers(problem, outcome));
    for picture in &pictures {
        folder.write(&picture.file(), picture.svg().as_bytes())?;
    }
    let html = page::page(request, problem, outcome, &pictures, written);
    folder.write(REPORT, html.as_bytes())?;
    write_mark(folder, request, "calibration", written, json!({ "parameters": parameters }))
}

fn residuals(outcome: &CalibrationOutcome) -> String {
    let mut text = String::from("release,marker,time_s,x_m,z_m,fitted_x_m,fitted_z_m\n");
    let quoted = |name: &str| format!("\"{}\"", cell(name).replace('"', "\"\""));
    for curve in &outcome.curves {
        let (release, marker) = (quoted(&curve.release), quoted(&curve.marker));
        for ((time, seen), fitted) in curve.time.iter().zip(&curve.measured).zip(&curve.predicted) {
            let _ = writeln!(
                text,
                "{release},{marker},{time},{},{},{},{}",
                seen[0], seen[1], fitted[0], fitted[1]
            );
        }
    }
    text
}

/// How well an experiment repeats, in words.
fn repeats_in_words(repeats: &Repeats) -> String {
    let size = significant(repeats.distance_mm, 2);
    match repeats.source {
        Source::Measured => {
            let plural = if repeats.pairs == 1 { "" } else { "s" };
            format!(
                "repeatability: {size} mm rms, from {} pair{plural} of repeated releases{}",
                repeats.pairs,
                repeats.between()
            )
        }
        Source::Stated => format!("repeatability: {size} mm rms, as stated"),
    }
}

/// How each release swings in the recording and in the fit.
fn swings(calibration: &Calibration) -> Aligned {
    let numbers = ["frequency, Hz", "fitted", "damping ratio", "fitted"].map(|head| (head, Side::Number));
    let mut swings = Aligned::new(&[&[("release", Side::Words)], &numbers[..]].concat());
    for release in &calibration.releases {
        let [measured, fitted] = [release.measured, release.fitted];
        let numbers =
            [measured.frequency_hz, fitted.frequency_hz, measured.damping_ratio, fitted.damping_ratio];
        swings.row([release.name.clone()].into_iter().chain(numbers.map(|own| significant_or_dash(own, 3))));
    }
    swings
}

/// A calibration as a table for people.
pub fn table(calibration: &Calibration) -> String {
    let numbers = ["value", "error"].map(|head| (head, Side::Number));
    let heads = [&[("", Side::Words)], &numbers[..], &[("95 % interval", Side::Name)]].concat();
    let mut parameters = Aligned::new(&heads);
    for found in &calibration.parameters {
        let error = match found.relative_error() {
            Some(error) if error < 1.0 => format!("{} %", significant(100.0 * error, 2)),
            Some(_) => "> 100 %".to_owned(),
            None => "-".to_owned(),
        };
        let (value, ends) = with_ends(found.value, found.interval_95, 1.0);
        let unit = if found.unit.is_empty() { String::new() } else { format!(" {}", found.unit) };
        let bound = if found.at_bound { ", at its bound" } else { "" };
        let interval = match ends {
            Some([low, high]) => format!("{low} to {high}{unit}{bound}"),
            None => format!("not determined{bound}"),
        };
        parameters.row([found.label(), value, error, interval]);
    }
    let numbers = ["samples", "rms, mm", "noise, mm", "chi2", "held back"].map(|head| (head, Side::Number));
    let heads = [("release", Side::Words), ("marker", Side::Words)];
    let mut releases = Aligned::new(&[&heads, &numbers[..]].concat());
    for release in &calibration.releases {
        for track in &release.tracks {
            releases.row([
                release.name.clone(),
                track.marker.clone(),
                track.samples.to_string(),
                significant(track.rms_mm, 3),
                significant(track.stated_noise_mm, 3),
                significant(track.reduced_chi_squared, 3),
                track.held_back.to_string(),
            ]);
        }
    }
    let mut text = format!("{parameters}\n{releases}\n{}", swings(calibration));
    if let Some(repeats) = &calibration.repeats {
        let _ = writeln!(text, "\n{}", repeats_in_words(repeats));
    }
    for warning in &calibration.warnings {
        let _ = write!(text, "\n! {warning}");
    }
    text
}
