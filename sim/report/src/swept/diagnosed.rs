//! What many diagnoses say, as a table for a terminal and as a part of a page.

use efam_sweeps::answers::{Answers, Often};
use efam_sweeps::diagnosed::Answer;
use models::digits::significant;

use crate::aligned::{Aligned, Side};
use crate::page::{Page, Table};

/// What is given of each experiment after its name.
const HEADS: [&str; 4] = ["answer", "gap", "held-out gap", "s"];

/// As a table for people.
pub(super) fn table(answers: &Answers) -> String {
    let mut said = Aligned::new(&[("", Side::Number), ("", Side::Words)]);
    answers.said.iter().for_each(|often| said.row([often.points.to_string(), often.what.clone()]));
    let [what, gap, held_out, seconds] = HEADS;
    let mut table = Aligned::new(&[
        ("experiment", Side::Words),
        (what, Side::Words),
        (gap, Side::Name),
        (held_out, Side::Name),
        (seconds, Side::Number),
    ]);
    answers
        .experiments
        .iter()
        .for_each(|own| table.row([own.experiment.clone()].into_iter().chain(told(own))));
    format!("{said}\n{table}")
}

/// As a part of a page.
pub(super) fn page(page: &mut Page, answers: &Answers) {
    page.section("Verdicts and answers");
    let rows = |all: &[Often]| all.iter().map(|own| vec![own.what.clone(), own.points.to_string()]).collect();
    let heads = &["answer", "experiments"];
    page.table(&Table { caption: "Verdicts", heads, rows: rows(&answers.verdicts) });
    page.table(&Table { caption: "Answers", heads, rows: rows(&answers.said) });
    page.section("Experiments");
    page.text(
        "Gap: largest rms residual of a release over its noise; 1 is noise alone. It is given for the baseline, and with the effects that were found.",
    );
    let row = |own: &Answer| [own.experiment.clone()].into_iter().chain(told(own)).collect();
    let heads: Vec<_> = ["experiment"].into_iter().chain(HEADS).collect();
    let rows = answers.experiments.iter().map(row).collect();
    page.table(&Table { caption: "Each experiment and its answer", heads: &heads, rows });
}

/// An answer under these heads.
fn told(own: &Answer) -> [String; 4] {
    let from_to =
        |[before, after]: [f64; 2]| format!("{} to {}", significant(before, 3), significant(after, 3));
    let gap = |gap: Option<[f64; 2]>| gap.map(from_to).unwrap_or_default();
    let seconds = own.seconds.map_or(String::new(), |own| format!("{own:.1}"));
    [own.said(), gap(own.gap), gap(own.held_out_gap), seconds]
}
