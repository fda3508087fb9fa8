//! Runs beside one another: `comparison.json`, and a page.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html            the page, with the pictures that lie in pictures/
//!   comparison.json        the same numbers
//!   summary.json           which runs were compared, by which command
//! ```

mod page;
mod table;

use std::collections::BTreeMap;
use std::time::SystemTime;

use efam_inference::calibrate::calibration::Calibrated;
use efam_store::StoreError;
use efam_store::folder::{Folder, MARK};
use efam_store::input;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use crate::page::REPORT;
use crate::picture::{Named, Picture, Tip, over_pressures, tips_of_runs};
use crate::quantities::quantities;
use crate::reread::{Reread, RunKind};
use crate::simulated::psi;
use crate::{Request, write_mark};
pub use table::comparison_table;

/// The numbers.
pub const COMPARISON: &str = "comparison.json";

/// What is compared, and what came of it. Lists of values have one for each run, in their order.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Comparison {
    /// The runs.
    pub runs: Vec<Compared>,
    /// Numbers of simulations.
    pub quantities: Vec<Row>,
    /// Keys of scenarios and experiments that are not the same everywhere.
    pub differences: Vec<Difference>,
    /// Frequency and damping of sets, by pressure.
    pub over_pressure: Vec<Row>,
    /// Parameters of calibrations.
    pub parameters: Vec<ComparedParameter>,
    /// Answers of diagnoses.
    pub verdicts: Vec<Verdict>,
    /// Numbers of predictions, with their intervals.
    pub predictions: Vec<Row>,
    /// Numbers of analyses, by release.
    pub analyses: Vec<Row>,
}

/// A run of a comparison.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Compared {
    /// Its letter.
    pub letter: String,
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: String,
    /// Its folder.
    pub folder: String,
}

/// One number of all runs that may have it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Row {
    /// What it is.
    pub name: String,
    /// Unit in which it is given.
    pub unit: String,
    /// None where the run has none.
    pub values: Vec<Option<f64>>,
    /// Intervals that hold 95 %, of those that have one.
    pub intervals: Vec<Option<[f64; 2]>>,
}

/// A key that is not the same everywhere.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Difference {
    /// Path.
    pub key: String,
    /// None where the run does not say it.
    pub values: Vec<Option<String>>,
}

/// A parameter of calibrations.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ComparedParameter {
    /// Path, and what it belongs to.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// None where the run did not find it.
    pub values: Vec<Option<f64>>,
    /// Their standard errors.
    pub errors: Vec<Option<f64>>,
}

/// Answer of a diagnosis.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Verdict {
    /// Letter of the run.
    pub letter: String,
    /// The answer.
    pub verdict: String,
    /// What was added to the model.
    pub effects: Vec<String>,
    /// Mean gap over the noise, before and after, of the fitted releases.
    pub gap: Option<[f64; 2]>,
    /// The same for held-out releases.
    #[serde(alias = "locked_gap")]
    pub held_out_gap: Option<[f64; 2]>,
}

/// Compares runs.
pub fn compare(runs: &[Reread]) -> Comparison {
    let compared = |(k, run): (usize, &Reread)| Compared {
        letter: letter(k),
        name: run.name.clone(),
        kind: run.kind.word().to_owned(),
        folder: run.folder.display().to_string(),
    };
    Comparison {
        runs: runs.iter().enumerate().map(compared).collect(),
        quantities: of_simulations(runs),
        differences: differences(runs),
        over_pressure: of_sets(runs),
        parameters: of_calibrations(runs),
        verdicts: of_diagnoses(runs),
        predictions: of_predictions(runs),
        analyses: of_analyses(runs),
    }
}

/// A, B, …, Z, A1, …: by which a run is called in a comparison.
pub fn letter(k: usize) -> String {
    let letter = char::from(b'A' + (k % 26) as u8);
    if k < 26 { letter.to_string() } else { format!("{letter}{}", k / 26) }
}

/// What the folder of a comparison says of its making.
pub fn request_of(runs: &[Reread]) -> Request {
    let mut names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let hash = |run: &Reread| {
        let file = run.folder.join(MARK);
        Some((file.display().to_string(), input::sha256(&file).ok()?))
    };
    let input_hashes = runs.iter().filter_map(hash).collect();
    Request { name: names.join(", "), input_hashes, ..Request::default() }
}

/// Writes a comparison into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_comparison(
    folder: &Folder,
    request: &Request,
    runs: &[Reread],
    comparison: &Comparison,
) -> Result<(), StoreError> {
    let text = serde_json::to_string_pretty(comparison).expect("a comparison has nothing that JSON has not");
    folder.write(COMPARISON, text.as_bytes())?;
    let pictures = pictures(runs, comparison);
    for picture in &pictures {
        folder.write(&picture.file(), picture.svg().as_bytes())?;
    }
    let written = SystemTime::now();
    let html = page::page(request, runs, comparison, &pictures, written);
    folder.write(REPORT, html.as_bytes())?;
    write_mark(folder, request, "comparison", written, json!({ "compared": comparison.runs }))
}

fn pictures(runs: &[Reread], comparison: &Comparison) -> Vec<Picture> {
    let mut tips = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let RunKind::Simulation(of) = &run.kind else { continue };
        let rest = of.summary.rest.map(|rest| [rest.tip_x_m, rest.tip_z_m]);
        let name = format!("{}, {}", letter(k), run.name);
        tips.push(Tip { name, times: &of.times, path: &of.tip, rest, case: None });
    }
    let mut pictures = tips_of_runs(&tips);
    let mut lines: BTreeMap<&str, Vec<Named>> = BTreeMap::new();
    for (k, run) in runs.iter().enumerate() {
        let RunKind::Set(members) = &run.kind else { continue };
        let name = format!("{}, {}", letter(k), comparison.runs[k].name);
        let points = |of: fn(&efam_experiments::summary::Summary) -> Option<f64>| {
            let all = members.iter();
            all.filter_map(|(pressure, summary)| Some((1e-3 * (*pressure)?, of(summary)?))).collect()
        };
        let natural = points(|summary| summary.natural_frequency_hz);
        lines.entry("natural frequency, Hz").or_default().push((name.clone(), natural));
        let ratio = points(|summary| summary.damping_ratio);
        lines.entry("damping ratio, dimensionless").or_default().push((name, ratio));
    }
    pictures.extend(lines.into_iter().rev().map(|(label, lines)| over_pressures(label, &lines)));
    pictures
}

fn of_simulations(runs: &[Reread]) -> Vec<Row> {
    let own: Vec<Option<Vec<crate::quantities::Quantity>>> = runs
        .iter()
        .map(|run| match &run.kind {
            RunKind::Simulation(of) => Some(quantities(&of.summary)),
            _ => None,
        })
        .collect();
    let Some(first) = own.iter().flatten().next() else { return Vec::new() };
    let row = |k: usize| Row {
        name: first[k].name.to_owned(),
        unit: first[k].unit.to_owned(),
        values: own.iter().map(|own| own.as_ref()?[k].value.as_ref().ok().copied()).collect(),
        intervals: vec![None; own.len()],
    };
    (0..first.len()).map(row).collect()
}

/// Scenarios are compared with scenarios, experiments with experiments.
fn differences(runs: &[Reread]) -> Vec<Difference> {
    let mut all = Vec::new();
    for is_experiment in [false, true] {
        let said: Vec<&Reread> = runs
            .iter()
            .filter(|run| run.kind.is_of_experiment() == is_experiment && !run.keys.is_empty())
            .collect();
        let mut keys: Vec<&String> = said.iter().flat_map(|run| run.keys.keys()).collect();
        keys.sort();
        keys.dedup();
        keys.retain(|key| said.iter().any(|run| run.keys.get(*key) != said[0].keys.get(*key)));
        let own = |run: &Reread| run.kind.is_of_experiment() == is_experiment;
        let value = |run: &Reread, key: &String| run.keys.get(key).filter(|_| own(run)).cloned();
        all.extend(keys.into_iter().map(|key| Difference {
            key: key.clone(),
            values: runs.iter().map(|run| value(run, key)).collect(),
        }));
    }
    all
}

fn of_sets(runs: &[Reread]) -> Vec<Row> {
    type Of = fn(&efam_experiments::summary::Summary) -> Option<f64>;
    const OF: [(&str, &str, Of); 2] = [
        ("natural frequency", "Hz", |summary| summary.natural_frequency_hz),
        ("damping ratio", "", |summary| summary.damping_ratio),
    ];
    let mut pressures: Vec<f64> = Vec::new();
    for run in runs {
        if let RunKind::Set(members) = &run.kind {
            pressures.extend(members.iter().filter_map(|(pressure, _)| *pressure));
        }
    }
    pressures.sort_by(f64::total_cmp);
    pressures.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    let mut rows = Vec::new();
    for (name, unit, of) in OF {
        for pressure in &pressures {
            let value = |run: &Reread| {
                let RunKind::Set(members) = &run.kind else { return None };
                let is_it = |own: &Option<f64>| own.is_some_and(|own| (own - pressure).abs() < 1.0);
                members.iter().find(|(own, _)| is_it(own)).and_then(|(_, summary)| of(summary))
            };
            rows.push(Row {
                name: format!("{name} at {}", psi(*pressure)),
                unit: unit.to_owned(),
                values: runs.iter().map(value).collect(),
                intervals: vec![None; runs.len()],
            });
        }
    }
    rows
}

fn of_calibrations(runs: &[Reread]) -> Vec<ComparedParameter> {
    let found = |run: &Reread| -> Vec<(String, Calibrated)> {
        match &run.kind {
            RunKind::Calibration(of) => of.parameters.iter().map(|own| (own.label(), own.clone())).collect(),
            _ => Vec::new(),
        }
    };
    let all: Vec<Vec<(String, Calibrated)>> = runs.iter().map(found).collect();
    let row = |(name, same): (&str, Vec<Option<&(String, Calibrated)>>)| {
        let same: Vec<Option<&Calibrated>> = same.into_iter().map(|own| own.map(|(_, own)| own)).collect();
        ComparedParameter {
            unit: same.iter().flatten().next().map_or(String::new(), |one| one.unit.clone()),
            values: same.iter().map(|own| Some(own.as_ref()?.value)).collect(),
            errors: same.iter().map(|own| own.as_ref()?.standard_error).collect(),
            name: name.to_owned(),
        }
    };
    by_name(&all, |(name, _)| name).into_iter().map(row).collect()
}

fn of_diagnoses(runs: &[Reread]) -> Vec<Verdict> {
    let mut verdicts = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let RunKind::Diagnosis(of) = &run.kind else { continue };
        let gap = |held_out: bool| {
            let own: Vec<_> = of.gap.iter().filter(|gap| gap.held_out == held_out).collect();
            let count = own.len() as f64;
            let mean = |value: fn(&efam_inference::diagnose::verdict::Gap) -> f64| {
                own.iter().map(|gap| value(gap)).sum::<f64>() / count
            };
            (!own.is_empty()).then(|| [mean(|gap| gap.before), mean(|gap| gap.after)])
        };
        verdicts.push(Verdict {
            letter: letter(k),
            verdict: json!(of.verdict).as_str().unwrap_or_default().replace('_', " "),
            effects: of.effects.iter().map(|added| added.effect.clone()).collect(),
            gap: gap(false),
            held_out_gap: gap(true),
        });
    }
    verdicts
}

/// Rows of what each run's file says, by name: `(name, unit, value, interval)`.
type Said = (String, String, Option<f64>, Option<[f64; 2]>);

fn rows(said: &[Vec<Said>]) -> Vec<Row> {
    let row = |(name, same): (&str, Vec<Option<&Said>>)| Row {
        name: name.to_owned(),
        unit: same.iter().flatten().next().map_or(String::new(), |one| one.1.clone()),
        values: same.iter().map(|own| own.and_then(|own| own.2)).collect(),
        intervals: same.iter().map(|own| own.and_then(|own| own.3)).collect(),
    };
    by_name(said, |own| &own.0).into_iter().map(row).collect()
}

/// What each of some lists has under a name, in the order in which names first come; of two of one name, the first.
fn by_name<T>(lists: &[Vec<T>], name: impl Fn(&T) -> &String) -> Vec<(&str, Vec<Option<&T>>)> {
    let mut found: Vec<(&str, Vec<Option<&T>>)> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, list) in lists.iter().enumerate() {
        for one in list {
            let place = *places.entry(name(one)).or_insert(found.len());
            if place == found.len() {
                found.push((name(one), vec![None; lists.len()]));
            }
            found[place].1[k].get_or_insert(one);
        }
    }
    found
}

fn interval(value: &Value) -> Option<[f64; 2]> {
    Some([value.get(0)?.as_f64()?, value.get(1)?.as_f64()?])
}

fn of_predictions(runs: &[Reread]) -> Vec<Row> {
    let own = |run: &Reread| -> Vec<Said> {
        let RunKind::Prediction(of) = &run.kind else { return Vec::new() };
        let said = |one: &Value| {
            let text = |key: &str| one[key].as_str().map(str::to_owned);
            let unit = text("unit").unwrap_or_default();
            Some((text("meaning")?, unit, one["value"].as_f64(), interval(&one["interval_95"])))
        };
        of["quantities"].as_array().into_iter().flatten().filter_map(said).collect()
    };
    rows(&runs.iter().map(own).collect::<Vec<_>>())
}

fn of_analyses(runs: &[Reread]) -> Vec<Row> {
    let own = |run: &Reread| -> Vec<Said> {
        let RunKind::Analysis(of) = &run.kind else { return Vec::new() };
        let mut said = Vec::new();
        for one in of["analysis"].as_array().into_iter().flatten() {
            let Some(name) = one["name"].as_str() else { continue };
            for (key, what, unit) in
                [("natural_frequency_hz", "natural frequency", "Hz"), ("damping_ratio", "damping ratio", "")]
            {
                said.push((format!("{name}: {what}"), unit.to_owned(), one[key].as_f64(), None));
            }
            let ei = one["dynamic_stiffness"]["bending_stiffness_n_m2"].as_f64();
            said.push((format!("{name}: EI from the frequency"), "N m^2".to_owned(), ei, None));
        }
        said
    };
    rows(&runs.iter().map(own).collect::<Vec<_>>())
}
