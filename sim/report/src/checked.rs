//! What predictions beside recordings leave on disk, and their table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html       the page for people
//!   check.json        each number of each release: measured, predicted, interval, whether that holds
//!   experiment.toml   the experiment, with the calibrated rod
//!   summary.json      the request, and its command
//! ```

use std::fmt::Write;
use std::time::SystemTime;

use efam_inference::predict::check::{Check, Checked, Number};
use efam_store::StoreError;
use efam_store::folder::Folder;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::calibrated::EXPERIMENT;
use crate::interval::with_ends;
use crate::page::{BeforeUse, Page, REPORT, Table};
use crate::report::{readable, significant};
use crate::{Request, write_mark};

/// The numbers.
pub const CHECK: &str = "check.json";
const HEADS: [&str; 5] = ["", "measured", "predicted", "95 % interval", "holds"];

/// Writes predictions beside recordings into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_check(folder: &Folder, request: &Request, check: &Check) -> Result<(), StoreError> {
    let text = serde_json::to_string_pretty(check).expect("numbers and texts have JSON");
    folder.write(CHECK, text.as_bytes())?;
    let written = SystemTime::now();
    folder.write(REPORT, page(request, check, written).as_bytes())?;
    folder.write(EXPERIMENT, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "prediction check", written, json!({}))
}

/// The count, as the first line for people.
fn answer(check: &Check) -> String {
    match check.compared {
        0 => "no interval of a release that took no part in the calibration was compared".to_owned(),
        compared => format!("{} of {compared} intervals hold what was measured", check.held),
    }
}

/// Predictions beside recordings as a table for people.
pub fn check_table(check: &Check) -> String {
    let mut text = format!("{}\n", answer(check));
    for release in &check.releases {
        let _ = writeln!(text, "\n{}", heading(release));
        let sides = [Side::Words, Side::Number, Side::Number, Side::Name, Side::Name];
        let heads: Vec<_> = HEADS.into_iter().zip(sides).collect();
        let mut table = Aligned::new(&heads).indented(2);
        release.numbers.iter().for_each(|number| table.row(cells(number)));
        let _ = write!(text, "{table}");
        for warning in &release.warnings {
            let _ = writeln!(text, "  warning: {warning}");
        }
    }
    for warning in &check.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

fn heading(release: &Checked) -> String {
    let part = if release.took_part { ", which took part in the calibration" } else { "" };
    format!("{}{part}", release.name)
}

fn cells(number: &Number) -> [String; 5] {
    let (factor, unit) = readable(&number.unit);
    let (predicted, ends) = with_ends(number.predicted, number.interval_95, factor);
    let (measured, _) = with_ends(number.measured, number.interval_95, factor);
    let measured = match number.measured_error {
        0.0 => measured,
        error => format!("{measured} ± {}", significant(error * factor, 2)),
    };
    let interval = ends.map_or(String::new(), |[low, high]| format!("{low} to {high} {unit}"));
    let holds = number.holds.map_or("", |holds| if holds { "yes" } else { "no" });
    [number.meaning.clone(), measured, predicted, interval.trim_end().to_owned(), holds.to_owned()]
}

fn page(request: &Request, check: &Check, written: SystemTime) -> String {
    let mut page = Page::new(&format!("Check: {}", check.name), "Predicted and measured", &answer(check));
    let of_releases = check
        .releases
        .iter()
        .flat_map(|own| own.warnings.iter().map(|words| format!("{}: {words}", own.name)));
    for release in &check.releases {
        page.section(&heading(release));
        page.table(&Table {
            caption: "Numbers as measured and as predicted",
            heads: &HEADS,
            rows: release.numbers.iter().map(|number| cells(number).to_vec()).collect(),
        });
    }
    page.before_use(&BeforeUse {
        warnings: check.warnings.iter().cloned().chain(of_releases).collect(),
        assumed: vec![
            "The interval is that of the prediction. The count of those that hold includes the error of the measurement, where it is known.".to_owned(),
        ],
        ..BeforeUse::default()
    });
    page.facts_of(request, written, vec![("releases".to_owned(), check.releases.len().to_string())]);
    page.finish()
}
