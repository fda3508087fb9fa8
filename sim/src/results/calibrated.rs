//! What a calibration leaves on disk.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   calibration.json       parameters, intervals, correlations, fit of each release, warnings
//!   muscle.toml            the muscle with the calibrated columns, for `efam simulate --muscle`
//!   experiment.toml        the experiment as it was read
//!   residuals.csv          measurement and fit, sample by sample
//!   fit-01.svg …           each track: fit over measurement, residuals, decay, damping
//!   parameters.svg         parameters over pressure
//!   report.html            the page for people, with the pictures that lie in pictures/
//!   summary.json           the parameters alone, and by which command
//! ```

mod page;

use std::fmt::Write;
use std::time::SystemTime;

use models::muscle::{CalibratedColumn, Found, Knob, Known, Muscle, MuscleError};
use serde_json::json;

use super::folder::Folder;
use super::page::REPORT;
use super::picture::{calibrated, fitted, over_pressure};
use super::report::significant;
use super::{Request, ResultsError, write_mark};
use crate::calibrate::calibration::{Calibrated, Correlations};
use crate::calibrate::{Calibration, Outcome, Problem};

/// File names of a calibration's folder.
pub const CALIBRATION: &str = "calibration.json";
/// The muscle.
pub const MUSCLE: &str = "muscle.toml";
/// The experiment.
pub const EXPERIMENT: &str = "experiment.toml";
/// The curves.
pub const RESIDUALS: &str = "residuals.csv";
/// The picture over pressure.
pub const PARAMETERS: &str = "parameters.svg";

/// Parameters that a muscle file has columns for.
const COLUMNS: [(&str, &str); 3] = [
    ("rod.bending_stiffness", "bending_stiffness_calibrated"),
    ("effects.rayleigh_mass.alpha", "rayleigh_mass"),
    ("effects.rayleigh_stiffness.beta", "rayleigh_stiffness"),
];

/// Parameters for which it has a constant.
const ROD_MASS: &str = "rod.mass";
const END_FITTING_MASS: &str = "effects.end_fitting.mass";

/// Writes a calibration into an open folder; `request.resolved_scenario` is the experiment's text.
/// # Errors
/// [`ResultsError::Write`].
pub fn write_calibration(
    folder: &Folder,
    request: &Request,
    problem: &Problem,
    outcome: &Outcome,
    muscle: Option<&str>,
) -> Result<(), ResultsError> {
    let calibration = &outcome.calibration;
    let text =
        serde_json::to_string_pretty(calibration).expect("a calibration has nothing that JSON has not");
    folder.write(CALIBRATION, text.as_bytes())?;
    folder.write(EXPERIMENT, request.resolved_scenario.as_bytes())?;
    if let Some(muscle) = muscle {
        folder.write(MUSCLE, muscle.as_bytes())?;
    }
    folder.write(RESIDUALS, residuals(outcome).as_bytes())?;
    for (k, curve) in outcome.curves.iter().enumerate() {
        folder.write(&format!("fit-{:02}.svg", k + 1), calibrated(curve).as_bytes())?;
    }
    if let Some(picture) = over_pressure(&request.name, calibration) {
        folder.write(PARAMETERS, picture.as_bytes())?;
    }
    let short = |found: &Calibrated| {
        json!({ "name": found.label(), "value": found.value, "unit": found.unit,
                "standard_error": found.standard_error, "interval_95": found.interval_95 })
    };
    let parameters: Vec<_> = calibration.parameters.iter().map(short).collect();
    let (pictures, written) = (fitted(calibration, &outcome.curves), SystemTime::now());
    for picture in &pictures {
        folder.write(&picture.file(), picture.svg.as_bytes())?;
    }
    let html = page::page(request, problem, outcome, &pictures, written);
    folder.write(REPORT, html.as_bytes())?;
    write_mark(folder, request, "calibration", written, json!({ "parameters": parameters }))
}

/// The muscle file of a calibration; nothing where it found nothing that has a column, or has a value
/// for each release.
/// # Errors
/// [`MuscleError`] for a pressure at which the muscle is none.
pub fn muscle_file(
    muscle: &Muscle,
    calibration: &Calibration,
    source: &str,
) -> Result<Option<String>, MuscleError> {
    let mut columns = Vec::new();
    let usable = |path: &str| {
        let found = calibration.of(path);
        let is_usable = !found.is_empty() && found.iter().all(|one| one.release.is_none());
        is_usable.then_some(found)
    };
    for (path, name) in COLUMNS {
        let Some(found) = usable(path) else { continue };
        // What all pressures share stands at any of them.
        let anywhere = calibration.releases.iter().find_map(|release| release.pressure_pa).unwrap_or(0.0);
        let values = found.iter().map(|one| (one.pressure_pa.unwrap_or(anywhere), one.value));
        columns.push(CalibratedColumn { name, values: values.collect() });
    }
    if columns.is_empty() {
        return Ok(None);
    }
    let shared = |path: &str| usable(path).filter(|found| found.len() == 1).map(|found| found[0].value);
    let found = Found {
        columns,
        rod_mass: shared(ROD_MASS),
        end_fitting_mass: shared(END_FITTING_MASS),
        known: known(calibration),
    };
    muscle.calibrated(source, &found).map(Some)
}

/// How well a calibration knows what goes into the muscle file.
fn known(calibration: &Calibration) -> Known {
    let is_written = |one: &&Calibrated| {
        let path = one.name.as_str();
        one.release.is_none()
            && (COLUMNS.iter().any(|(column, _)| *column == path)
                || [ROD_MASS, END_FITTING_MASS].contains(&path))
    };
    let own: Vec<&Calibrated> = calibration.parameters.iter().filter(is_written).collect();
    let correlation = |a: &Calibrated, b: &Calibrated| {
        if a.label() == b.label() {
            return 1.0;
        }
        let together = |group: &&Correlations| {
            let at = |one: &Calibrated| group.names.iter().position(|name| *name == one.label());
            Some(group.matrix[at(a)?][at(b)?].clamp(-1.0, 1.0))
        };
        calibration.correlations.iter().find_map(|group| together(&group)).unwrap_or(0.0)
    };
    let knob = |one: &&Calibrated| Knob {
        path: one.name.clone(),
        pressure_pa: one.pressure_pa,
        value: one.value,
        standard_error: one.standard_error,
        correlations: own.iter().map(|other| correlation(one, other)).collect(),
    };
    let fitted = || calibration.releases.iter().filter(|release| !release.held_out);
    let range = |values: Vec<f64>| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if values.is_empty() { [0.0; 2] } else { [least, most] }
    };
    Known {
        releases: fitted().count(),
        pressure_pa: range(fitted().filter_map(|release| release.pressure_pa).collect()),
        payload_kg: range(fitted().map(|release| release.payload_kg).collect()),
        excursion_m: fitted().map(|release| release.excursion_m).fold(0.0, f64::max),
        parameter: own.iter().map(knob).collect(),
    }
}

fn residuals(outcome: &Outcome) -> String {
    let mut text = String::from("release,marker,time_s,x_m,z_m,fitted_x_m,fitted_z_m\n");
    let quoted = |name: &str| format!("\"{}\"", name.replace('"', "\"\""));
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

/// A calibration as a table for people.
pub fn table(calibration: &Calibration) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{:58} {:>14} {:>10}   95 % interval", "", "value", "error");
    for found in &calibration.parameters {
        let error = match found.relative_error() {
            Some(error) if error < 1.0 => format!("{} %", significant(100.0 * error, 2)),
            Some(_) => "> 100 %".to_owned(),
            None => "-".to_owned(),
        };
        let interval = found.interval_95.map_or("not determined".to_owned(), |[low, high]| {
            format!("{} to {} {}", significant(low, 5), significant(high, 5), found.unit)
        });
        let _ = writeln!(
            text,
            "{:58} {:>14} {error:>10}   {interval}",
            found.label(),
            significant(found.value, 5)
        );
    }
    text.push('\n');
    let _ = writeln!(
        text,
        "{:34} {:20} {:>8} {:>10} {:>10} {:>8} {:>10}",
        "release", "marker", "samples", "rms, mm", "noise, mm", "chi2", "held back"
    );
    for release in &calibration.releases {
        for track in &release.tracks {
            let _ = writeln!(
                text,
                "{:34} {:20} {:>8} {:>10} {:>10} {:>8} {:>10}",
                release.name,
                track.marker,
                track.samples,
                significant(track.rms_mm, 3),
                significant(track.stated_noise_mm, 3),
                significant(track.reduced_chi_squared, 3),
                track.held_back
            );
        }
    }
    for warning in &calibration.warnings {
        let _ = write!(text, "\n! {warning}");
    }
    text
}
