//! A sweep as a page.

use std::time::SystemTime;

use super::super::Request;
use super::super::page::{BeforeUse, Page, Table, extrapolated};
use super::super::picture::Picture;
use super::super::report::significant;
use super::readable;
use crate::sweep::merge::{Merged, Spread};
use crate::sweep::plan::Head;

/// What any sweep takes for granted.
const ASSUMED: [&str; 2] = [
    "What is not varied is what the scenario says, at every point.",
    "Each point is one run on the scenario's own mesh and tolerance: the error of these is in every number.",
];

/// The page of a merged sweep.
pub(in crate::results) fn page(
    request: &Request,
    (head, merged): (&Head, &Merged),
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let (points, failed) = (merged.points, merged.failed);
    let design = serde_json::to_value(head.design).ok();
    let design = design.and_then(|word| word.as_str().map(str::to_owned)).unwrap_or_default();
    let lead = format!(
        "{points} points of a {} over {}; {failed} could not be simulated.",
        design.replace('_', " "),
        head.parameters.join(", ")
    );
    let mut page = Page::new(&format!("Sweep: {}", merged.name), "Simulated", &lead);
    let (extrapolated, warnings) = extrapolated(&merged.warnings);
    let assumed = ASSUMED.map(str::to_owned).to_vec();
    page.before_use(&BeforeUse {
        warnings,
        extrapolated: Some(extrapolated),
        assumed,
        ..BeforeUse::default()
    });
    page.section("Pictures");
    match pictures {
        [] => page.text("No number varies."),
        all => all.iter().for_each(|picture| page.figure(picture)),
    }
    page.section("Numbers");
    let heads = ["", "points", "least", "2.5 %", "median", "97.5 %", "greatest", "unit"];
    for (caption, all) in [("What varies", &merged.parameters), ("What the runs say", &merged.numbers)] {
        page.table(&Table { caption, heads: &heads, rows: all.iter().map(row).collect() });
    }
    page.section("What could not be simulated");
    match merged.reasons.is_empty() {
        true => page.text("Every point could be."),
        false => page.table(&Table {
            caption: "The most frequent reasons; the table has each point's own",
            heads: &["reason", "points", "first point"],
            rows: merged
                .reasons
                .iter()
                .map(|own| vec![own.reason.clone(), own.points.to_string(), own.first.to_string()])
                .collect(),
        }),
    }
    let own = [
        ("plan, SHA-256", head.sha256.clone()),
        ("shards", head.shards().to_string()),
        ("seed", head.seed.to_string()),
    ];
    page.facts_of(request, written, own.map(|(name, value)| (name.to_owned(), value)).to_vec());
    page.finish()
}

fn row(spread: &Spread) -> Vec<String> {
    let (factor, unit) = readable(spread);
    let value = |value: Option<f64>| value.map_or("-".to_owned(), |value| significant(factor * value, 4));
    let mut cells = vec![spread.name.clone(), spread.points.to_string()];
    cells.extend([spread.least, spread.low_95, spread.median, spread.high_95, spread.greatest].map(value));
    cells.push(unit.to_owned());
    cells
}
