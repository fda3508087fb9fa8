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

mod page;

use std::fmt::Write;
use std::time::SystemTime;

use serde_json::json;

use super::atomic::write_whole;
use super::page::REPORT;
use super::picture::swept_pictures;
use super::report::significant;
use super::{MARK, Request, ResultsError, mark};
use crate::sweep::asked::Design;
use crate::sweep::merge::{Kept, Merged, Spread};
use crate::sweep::plan::Plan;

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
pub fn write_swept(plan: &Plan, request: &Request, merged: &Merged, kept: &Kept) -> Result<(), ResultsError> {
    let text = serde_json::to_string_pretty(merged).expect("a sweep has nothing that JSON has not");
    let put = |name: &str, text: &str| {
        write_whole(&plan.folder.join(name), |file| std::io::Write::write_all(file, text.as_bytes()))
    };
    put(NUMBERS, &text)?;
    let pictures = swept_pictures(merged, kept, plan.head.design == Design::Grid);
    for picture in &pictures {
        put(&format!("{}.svg", picture.name), &picture.svg)?;
    }
    put(REPORT, &page::page(request, (&plan.head, merged), &pictures, SystemTime::now()))?;
    put(MARK, &swept_mark(request))
}

/// Numbers that the table shows.
const SHOWN: [&str; 7] = [
    "rest_z_m",
    "small_frequency_hz",
    "frequency_hz",
    "damping_ratio",
    "lowest_z_m",
    "settling_5_percent_s",
    "peak_speed_m_s",
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
    let shown = merged.numbers.iter().filter(|own| SHOWN.contains(&own.column.as_str()));
    for spread in merged.parameters.iter().chain(shown) {
        let (factor, unit) = readable(spread);
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        let _ = write!(text, "{:40}{:>11}", format!("{}{unit}", spread.name), spread.points);
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
