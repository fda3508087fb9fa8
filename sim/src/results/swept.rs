//! What a sweep leaves on disk beside its shards and its table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   plan.json, points.csv        the plan: what is simulated, frozen
//!   shard=00000/part.parquet …   rows of each shard
//!   sweep.parquet                all rows, in the order of the points (sweep.csv on request)
//!   sweep.json                   how each number is spread, failures, warnings
//!   report.html, over-….svg      all of it, for people
//!   summary.json                 what was asked, by which command
//! ```

use std::fmt::Write;
use std::path::Path;
use std::time::SystemTime;

use serde_json::json;

use super::atomic::write_whole;
use super::report::significant;
use super::{MARK, Request, ResultsError, mark};
use crate::sweep::merge::{Merged, Spread};

/// The numbers.
pub const NUMBERS: &str = "sweep.json";
/// The kind of folder.
pub const KIND: &str = "sweep";

/// The mark of a sweep's folder.
pub fn swept_mark(request: &Request) -> String {
    mark(request, KIND, SystemTime::now(), json!({}))
}

/// Writes what a merged sweep says into its folder.
/// # Errors
/// [`ResultsError::Write`].
pub fn write_swept(folder: &Path, request: &Request, merged: &Merged) -> Result<(), ResultsError> {
    let text = serde_json::to_string_pretty(merged).expect("a sweep has nothing that JSON has not");
    let put = |name: &str, text: &str| {
        write_whole(&folder.join(name), |file| std::io::Write::write_all(file, text.as_bytes()))
    };
    put(NUMBERS, &text)?;
    put(MARK, &swept_mark(request))
}

/// Numbers that the table shows, and what they are.
const SHOWN: [(&str, &str); 8] = [
    ("rest_z_m", "tip at rest, z"),
    ("small_frequency_hz", "frequency of small swings"),
    ("frequency_hz", "frequency as released"),
    ("damping_ratio", "damping ratio as released"),
    ("lowest_z_m", "lowest point of the tip"),
    ("settling_5_percent_s", "settled to 5 % after"),
    ("peak_speed_m_s", "greatest speed of the tip"),
    ("energy_closure", "energy closed to"),
];

/// A sweep as a table for people.
pub fn swept_table(merged: &Merged) -> String {
    let mut text =
        format!("{}: {} points, {} could not be simulated\n", merged.name, merged.points, merged.failed);
    for reason in &merged.reasons {
        let _ = writeln!(text, "  {} points, first {}: {}", reason.points, reason.first, reason.reason);
    }
    let head = ["points", "least", "2.5 %", "median", "97.5 %", "greatest"];
    let _ = write!(text, "\n{:40}", "");
    head.iter().for_each(|head| {
        let _ = write!(text, "{head:>11}");
    });
    text.push('\n');
    let shown = SHOWN.iter().filter_map(|(column, name)| {
        merged.numbers.iter().find(|own| own.column == *column).map(|own| (*name, own))
    });
    let parameters = merged.parameters.iter().map(|own| (own.column.as_str(), own));
    for (name, spread) in parameters.chain(shown) {
        let (factor, unit) = readable(spread);
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        let _ = write!(text, "{:40}{:>11}", format!("{name}{unit}"), spread.points);
        for value in [spread.least, spread.low_95, spread.median, spread.high_95, spread.greatest] {
            let value = value.map_or("-".to_owned(), |value| significant(factor * value, 4));
            let _ = write!(text, "{value:>11}");
        }
        text.push('\n');
    }
    for warning in &merged.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

/// Factor and unit in which a number is told: lengths in mm, angles in degrees, pressures in kPa, masses in g.
pub(super) fn readable(spread: &Spread) -> (f64, &str) {
    match spread.unit.as_str() {
        "m" => (1e3, "mm"),
        "rad" => (1.0f64.to_degrees(), "deg"),
        "Pa" => (1e-3, "kPa"),
        "kg" => (1e3, "g"),
        "J" => (1e3, "mJ"),
        unit => (1.0, unit),
    }
}
