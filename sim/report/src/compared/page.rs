//! A comparison as a page.

use std::time::SystemTime;

use efam_core::trajectory::Status;

use crate::Request;
use crate::compared::{ComparedParameter, Comparison, Row, Verdict};
use crate::page::{BeforeUse, Page, REPORT, Table, extrapolated};
use crate::picture::Picture;
use crate::report::significant;
use crate::reread::{Reread, RunKind};

/// The page of a comparison with its pictures; `written` is when.
pub(super) fn page(
    request: &Request,
    runs: &[Reread],
    comparison: &Comparison,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let (word, lead) = lead(runs, comparison);
    let mut page = Page::new(&format!("Comparison of {}", request.name), &word, &lead);
    page.section("The runs");
    the_runs(&mut page, runs, comparison);
    differences(&mut page, comparison);
    let heads = heads(comparison);
    let sections: [(&str, &str, &[Row]); 4] = [
        ("Simulations", "Numbers of each run", &comparison.quantities),
        ("Sets over pressure", "Each set by pressure", &comparison.over_pressure),
        ("Predictions", "Predictions with 95 % intervals", &comparison.predictions),
        ("Analyses", "Numbers of each release", &comparison.analyses),
    ];
    for (title, caption, rows) in sections {
        if rows.is_empty() {
            continue;
        }
        page.section(title);
        let is_own = |picture: &&Picture| match title {
            "Simulations" => !picture.name.contains("over-pressure"),
            "Sets over pressure" => picture.name.contains("over-pressure"),
            _ => false,
        };
        page.figures(pictures.iter().filter(is_own));
        let of = columns(rows, runs.len());
        let heads: Vec<&str> = heads_of(&heads, &of);
        let rows = rows.iter().map(|one| row(one, &of)).collect();
        page.table(&Table { caption, heads: &heads, rows });
    }
    parameters(&mut page, comparison, &heads);
    verdicts(&mut page, &comparison.verdicts);
    let mut own = Vec::new();
    for (run, compared) in runs.iter().zip(&comparison.runs) {
        let letter = &compared.letter;
        own.push((format!("{letter}: folder"), compared.folder.clone()));
        own.push((format!("{letter}: command"), run.argv.join(" ")));
        own.push((format!("{letter}: written, UTC"), run.written.clone()));
        let hash = |(file, hash): (&String, &String)| (format!("{letter}: SHA-256 of {file}"), hash.clone());
        own.extend(run.hashes.iter().map(hash));
    }
    page.before_use(&before_use(runs, comparison));
    page.facts_of(request, written, own);
    page.finish()
}

/// The first lines: how much the numbers by which one would know a muscle differ.
fn lead(runs: &[Reread], comparison: &Comparison) -> (String, String) {
    if let [run] = runs {
        let page = if run.has_page {
            format!("Its own page, {REPORT}, is in its folder.")
        } else {
            format!(
                "It has no page of its own: it was made before efam wrote {REPORT}, or lost it; make it again for one. {}",
                again(run)
            )
        };
        let text = format!(
            "There is nothing to compare it with; below are its numbers as its folder has them. {page}"
        );
        return (format!("One {}", run.kind.word()), text);
    }
    let mut text = match comparison.differences.len() {
        0 => "No key of their scenarios or experiments differs.".to_owned(),
        1 => format!("They differ in one key, {}.", comparison.differences[0].key),
        count => format!("They differ in {count} keys."),
    };
    for name in ["natural frequency, eq. 7", "damping ratio, eq. 6"] {
        let Some(row) = comparison.quantities.iter().find(|row| row.name == name) else { continue };
        let values: Vec<f64> = row.values.iter().flatten().copied().collect();
        let (Some(least), Some(most)) =
            (values.iter().copied().reduce(f64::min), values.iter().copied().reduce(f64::max))
        else {
            continue;
        };
        if values.len() > 1 {
            let apart = significant(100.0 * (most / least - 1.0), 2);
            let [least, most] = [least, most].map(|value| significant(value, 4));
            let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
            let title = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
            text += &format!(" {title}: {least} to {most}{unit}, {apart} % apart.");
        }
    }
    (format!("Comparison of {} runs", runs.len()), text)
}

fn again(run: &Reread) -> &'static str {
    match run.kind {
        RunKind::Simulation(_) => "efam simulate on its scenario.resolved.toml gives the same bits.",
        _ => "",
    }
}

fn before_use(runs: &[Reread], comparison: &Comparison) -> BeforeUse {
    let mut warnings = Vec::new();
    for (run, compared) in runs.iter().zip(&comparison.runs) {
        warnings.extend(run.warnings.iter().map(|warning| format!("{}: {warning}", compared.letter)));
        if let RunKind::Other(word) = &run.kind {
            warnings.push(format!("{}: a {word} has nothing to compare", compared.letter));
        }
        if let RunKind::Simulation(of) = &run.kind
            && of.summary.status != Status::Complete
        {
            let simulated = of.summary.simulated_s;
            warnings.push(format!(
                "{}: did not come to its end; its numbers are of {simulated:.2} s",
                compared.letter
            ));
        }
    }
    let versions: Vec<&str> = runs
        .iter()
        .filter_map(|run| match &run.kind {
            RunKind::Simulation(of) => Some(of.summary.versions.efam.as_str()),
            _ => None,
        })
        .collect();
    if versions.windows(2).any(|pair| pair[0] != pair[1]) {
        warnings.push(format!("the runs were made by different versions of efam: {}", versions.join(", ")));
    }
    let kinds = comparison.runs.iter().map(|run| run.kind.as_str());
    if kinds.clone().any(|kind| Some(kind) != kinds.clone().next()) {
        warnings.push("the runs are of different kinds; only runs of one kind share a table".to_owned());
    }
    let (extrapolated, warnings) = extrapolated(&warnings);
    BeforeUse {
        note: Some("The numbers are those that the folders hold; nothing was run again.".to_owned()),
        warnings,
        extrapolated: Some(extrapolated),
        assumed: vec!["What each run took for granted stands on its own page.".to_owned()],
        ..BeforeUse::default()
    }
}

fn the_runs(page: &mut Page, runs: &[Reread], comparison: &Comparison) {
    let row = |(run, compared): (&Reread, &crate::compared::Compared)| {
        vec![
            compared.letter.clone(),
            compared.name.clone(),
            compared.kind.clone(),
            run.written.clone(),
            compared.folder.clone(),
        ]
    };
    page.table(&Table {
        caption: "What is compared; differences below are from the first run that has the number",
        heads: &["", "name", "kind", "written, UTC", "folder"],
        rows: runs.iter().zip(&comparison.runs).map(row).collect(),
    });
}

fn differences(page: &mut Page, comparison: &Comparison) {
    if comparison.runs.len() < 2 {
        return;
    }
    page.section("Differences");
    if comparison.differences.is_empty() {
        page.text("In no key of their scenarios or experiments.");
    }
    let heads: Vec<&str> =
        std::iter::once("key").chain(comparison.runs.iter().map(|run| run.letter.as_str())).collect();
    let row = |of: &crate::compared::Difference| {
        let values = of.values.iter().map(|value| value.clone().unwrap_or_else(|| "-".to_owned()));
        std::iter::once(of.key.clone()).chain(values).collect()
    };
    page.table(&Table {
        caption: "Keys of the scenario with all defaults written out, or of the experiment",
        heads: &heads,
        rows: comparison.differences.iter().map(row).collect(),
    });
}

/// `A release-15psi` for each run.
fn heads(comparison: &Comparison) -> Vec<[String; 2]> {
    let head = |run: &crate::compared::Compared| [run.letter.clone(), format!("{}, more by %", run.letter)];
    comparison.runs.iter().map(head).collect()
}

/// The runs that have any of the numbers.
fn columns(rows: &[Row], runs: usize) -> Vec<usize> {
    (0..runs).filter(|k| rows.iter().any(|row| row.values[*k].is_some())).collect()
}

fn heads_of<'a>(heads: &'a [[String; 2]], of: &[usize]) -> Vec<&'a str> {
    let mut all = vec!["quantity", "unit"];
    for (place, k) in of.iter().enumerate() {
        all.push(&heads[*k][0]);
        if place > 0 {
            all.push(&heads[*k][1]);
        }
    }
    all
}

/// Values, and by how many per cent each is more than the first.
fn row(of: &Row, columns: &[usize]) -> Vec<String> {
    let mut cells = vec![of.name.clone(), of.unit.clone()];
    let first = columns.first().and_then(|k| of.values[*k]);
    for (place, k) in columns.iter().enumerate() {
        let value = of.values[*k];
        let interval = of.intervals[*k].map_or(String::new(), |[low, high]| {
            format!(" ({} to {})", significant(low, 4), significant(high, 4))
        });
        cells.push(value.map_or("-".to_owned(), |value| format!("{}{interval}", significant(value, 4))));
        if place > 0 {
            let more = first.zip(value).filter(|(first, _)| *first != 0.0);
            cells.push(more.map_or("-".to_owned(), |(first, value)| {
                format!("{:.2}", 100.0 * (value - first) / first.abs())
            }));
        }
    }
    cells
}

fn parameters(page: &mut Page, comparison: &Comparison, heads: &[[String; 2]]) {
    if comparison.parameters.is_empty() {
        return;
    }
    page.section("Calibrations");
    let has = |k: &usize| comparison.parameters.iter().any(|one| one.values[*k].is_some());
    let of: Vec<usize> = (0..comparison.runs.len()).filter(has).collect();
    let mut all = vec!["parameter".to_owned(), "unit".to_owned()];
    for (place, k) in of.iter().enumerate() {
        all.push(heads[*k][0].clone());
        if place > 0 {
            all.push(format!("difference of {}, standard errors of both", heads[*k][0]));
        }
    }
    let row = |one: &ComparedParameter| {
        let mut cells = vec![one.name.clone(), one.unit.clone()];
        let first = of.first().copied().unwrap_or(0);
        for (place, k) in of.iter().enumerate() {
            let error = one.errors[*k].map_or(String::new(), |error| format!(" ± {}", significant(error, 2)));
            cells.push(one.values[*k].map_or("-".to_owned(), |v| format!("{}{error}", significant(v, 5))));
            if place > 0 {
                let apart = || {
                    let error = one.errors[*k]?.hypot(one.errors[first]?);
                    Some(significant((one.values[*k]? - one.values[first]?) / error, 2))
                };
                cells.push(apart().unwrap_or_else(|| "-".to_owned()));
            }
        }
        cells
    };
    page.table(&Table {
        caption: "Parameters with their standard errors. Above 3 standard errors of both, two values differ",
        heads: &all.iter().map(String::as_str).collect::<Vec<_>>(),
        rows: comparison.parameters.iter().map(row).collect(),
    });
}

fn verdicts(page: &mut Page, verdicts: &[Verdict]) {
    if verdicts.is_empty() {
        return;
    }
    page.section("Diagnoses");
    let row = |of: &Verdict| {
        let gap = |gap: Option<[f64; 2]>| {
            let text = |value: f64| format!("{value:.2}");
            gap.map_or(["-".to_owned(), "-".to_owned()], |gap| gap.map(text))
        };
        let effects = if of.effects.is_empty() { "none".to_owned() } else { of.effects.join(", ") };
        let [before, after] = gap(of.gap);
        let [held_out_before, held_out_after] = gap(of.held_out_gap);
        vec![of.letter.clone(), of.verdict.clone(), effects, before, after, held_out_before, held_out_after]
    };
    page.table(&Table {
        caption: "Verdicts, and the mean gap over the noise, 1 being noise alone",
        heads: &["", "verdict", "effects", "gap before", "gap after", "held out, before", "held out, after"],
        rows: verdicts.iter().map(row).collect(),
    });
}
