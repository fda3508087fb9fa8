//! A sweep as a page.

use std::time::SystemTime;

use efam_sweeps::merge::{Merged, Spread};
use efam_sweeps::plan::Head;
use efam_sweeps::work::Work;

use crate::Request;
use crate::page::{BeforeUse, Family, Page, Table, extrapolated};
use crate::picture::{Picture, Rods};
use crate::swept::{HEADS, diagnosed, told};

/// What any sweep over a scenario takes for granted.
const ASSUMED: [&str; 2] = [
    "Parameters that do not vary have the values of the scenario.",
    "Each point is one run on the scenario's own mesh and tolerance; every number includes their error.",
];
/// What any sweep over experiments takes for granted.
const OF_DIAGNOSES: [&str; 1] = [
    "Each experiment is diagnosed as by efam diagnose. That command also gives the evidence, pictures and the repaired model.",
];

/// The page of a merged sweep.
pub(crate) fn page(
    request: &Request,
    (head, merged): (&Head, &Merged),
    (family, rods, pictures): (&Family, Option<Rods>, &[Picture]),
    written: SystemTime,
) -> String {
    let (points, failed, done) = (merged.points, merged.failed, head.work.done());
    let (lead, word, assumed) = match &head.work {
        Work::Simulate(own) => {
            let design = serde_json::to_value(own.design).ok();
            let design = design.and_then(|word| word.as_str().map(str::to_owned)).unwrap_or_default();
            let (design, over) = (design.replace('_', " "), own.parameters.join(", "));
            let lead = format!("{points} points of a {design} over {over}; {failed} could not be simulated.");
            (lead, "Simulated", ASSUMED.map(str::to_owned).to_vec())
        }
        Work::Diagnose(own) => {
            let (level, most) = (&own.false_alarm, own.most);
            let lead = format!(
                "{points} experiments, at a false-alarm level of {level}, with {most} added at most; {failed} could \
                 not be diagnosed."
            );
            (lead, "Diagnosed", OF_DIAGNOSES.map(str::to_owned).to_vec())
        }
    };
    let mut page = Page::new(&format!("Sweep: {}", merged.name), word, &lead);
    let (extrapolated, warnings) = extrapolated(&merged.warnings);
    match &merged.diagnosed {
        Some(answers) => diagnosed::page(&mut page, answers),
        None => {
            page.section("Pictures");
            match pictures {
                [] => page.text("No number varies."),
                all => {
                    page.family(family);
                    all.iter().take(1).for_each(|picture| page.figure(picture));
                    rods.iter().for_each(|rods| page.rods(rods));
                    all.iter().skip(1).for_each(|picture| page.figure(picture));
                }
            }
        }
    }
    page.section("Numbers");
    let heads: Vec<_> = [""].into_iter().chain(HEADS).chain(["unit"]).collect();
    for (caption, all) in [("Varied parameters", &merged.parameters), ("Results", &merged.numbers)] {
        page.table(&Table { caption, heads: &heads, rows: all.iter().map(row).collect() });
    }
    page.section(&format!("Points that could not be {done}"));
    if merged.reasons.is_empty() {
        page.text("None.")
    } else {
        page.table(&Table {
            caption: "The most frequent reasons; the table has each point's own",
            heads: &["reason", "points", "first point"],
            rows: merged
                .reasons
                .iter()
                .map(|own| vec![own.reason.clone(), own.points.to_string(), own.first.to_string()])
                .collect(),
        })
    }
    let mut own = vec![("plan, SHA-256", head.sha256.clone()), ("shards", head.shards().to_string())];
    match &head.work {
        Work::Simulate(of) => own.push(("seed", of.seed.to_string())),
        Work::Diagnose(of) => own.push(("experiments in", of.folder.clone())),
    }
    page.before_use(&BeforeUse {
        warnings,
        extrapolated: Some(extrapolated),
        assumed,
        ..BeforeUse::default()
    });
    page.facts_of(request, written, own.into_iter().map(|(name, value)| (name.to_owned(), value)).collect());
    page.finish()
}

fn row(spread: &Spread) -> Vec<String> {
    let (cells, unit) = told(spread);
    let name = [spread.name.clone()];
    name.into_iter().chain(cells).chain([unit.to_owned()]).collect()
}
