//! What a sweep leaves on disk beside its shards and its table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   plan.json, points.csv        the plan: what is simulated, frozen
//!   shard=00000/part.parquet …   rows of each shard; of diagnoses how long they took, too (seconds.csv)
//!   sweep.parquet                all rows, in the order of the points (sweep.csv on request)
//!   sweep.json                   how each number is spread, what diagnoses say, failures, warnings
//!   report.html, over-….svg      all of it, for people
//!   summary.json                 the request, and its command
//! ```

mod diagnosed;
mod family;
mod page;
mod planned;

use std::fmt::Write;
use std::time::SystemTime;

use efam_store::{MARK, StoreError, added};
use efam_sweeps::merge::{Kept, Merged, Spread};
use efam_sweeps::plan::Plan;
use efam_sweeps::request::Design;
use efam_sweeps::work::Work;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::page::REPORT;
use crate::picture::swept_pictures;
use crate::report::{readable, significant_or_dash};
use crate::{Request, mark};

pub use planned::{again, request_of, write_plan};

/// The numbers.
pub const NUMBERS: &str = "sweep.json";
/// The kind of folder.
pub const KIND: &str = "sweep";

/// Folders that come into a sweep's folder after its plan; see [`Manifest`](efam_store::manifest::Manifest).
pub const ADDED: [&str; 2] = ["shard=*", "log"];

/// The mark of a sweep's folder.
pub fn swept_mark(request: &Request) -> String {
    mark(request, KIND, SystemTime::now(), json!({}))
}

/// Writes what a merged sweep says into its folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_swept(plan: &Plan, request: &Request, merged: &Merged, kept: &Kept) -> Result<(), StoreError> {
    let text = serde_json::to_string_pretty(merged).expect("a sweep has nothing that JSON has not");
    let put = |name: &str, text: &str| {
        added::add(&plan.folder, name, |file| std::io::Write::write_all(file, text.as_bytes()))
    };
    put(NUMBERS, &text)?;
    let is_grid = matches!(&plan.head.work, Work::Simulate(own) if own.design == Design::Grid);
    let pictures = swept_pictures(merged, kept, is_grid);
    let family = family::family(plan, kept);
    let rods = family::rods(plan);
    for picture in &pictures {
        put(&format!("{}.svg", picture.name), picture.svg())?;
    }
    put(REPORT, &page::page(request, (&plan.head, merged), (&family, rods, &pictures), SystemTime::now()))?;
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
    let done = if merged.diagnosed.is_some() { "diagnosed" } else { "simulated" };
    let mut text =
        format!("{}: {} points, {} could not be {done}\n", merged.name, merged.points, merged.failed);
    for reason in &merged.reasons {
        let _ = writeln!(text, "  {} points, first {}: {}", reason.points, reason.first, reason.reason);
    }
    text.push('\n');
    match &merged.diagnosed {
        Some(answers) => text += &diagnosed::table(answers),
        None => text += &spreads(merged),
    }
    for warning in &merged.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

/// A line for each number that varies or is shown.
fn spreads(merged: &Merged) -> String {
    let numbers = HEADS.map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("", Side::Words)], &numbers[..]].concat());
    let shown = merged.numbers.iter().filter(|own| SHOWN.contains(&own.column.as_str()));
    for spread in merged.parameters.iter().chain(shown) {
        let (cells, unit) = told(spread);
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        table.row([format!("{}{unit}", spread.name)].into_iter().chain(cells));
    }
    table.to_string()
}

/// What is given of a spread after its name.
const HEADS: [&str; 6] = ["points", "least", "2.5 %", "median", "97.5 %", "greatest"];

/// A spread under these heads, and its unit.
fn told(spread: &Spread) -> ([String; 6], &str) {
    let (factor, unit) = readable(&spread.unit);
    let Spread { least, low_95, median, high_95, greatest, .. } = spread;
    let [a, b, c, d, e] = [least, low_95, median, high_95, greatest]
        .map(|own| significant_or_dash(own.map(|own| factor * own), 4));
    ([spread.points.to_string(), a, b, c, d, e], unit)
}
