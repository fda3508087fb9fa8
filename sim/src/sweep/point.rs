//! One point: the case that it stands for, and what a run of that says.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use super::asked::Value;
use super::key::{self, Kind};
use crate::predict::quantity::{meanings, units};
use crate::predict::simulated::{Simulated, simulate};
use crate::results::columns::{Cells, Column, Holds};
use crate::results::summary::EnergyBalance;
use crate::scenario::{Case, Scenario, ScenarioError};

/// One point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its number, from zero.
    pub index: usize,
    /// Of its own random numbers, below 2⁵³.
    pub seed: u64,
    /// Values of all that differs from point to point, in the order of the plan.
    pub values: Vec<Value>,
}

/// What a run of a point says.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The point.
    pub point: Point,
    /// In the order of [`numbers`]; none where the run has none.
    pub numbers: Vec<Option<f64>>,
    /// Why it could not be simulated.
    pub failed: Option<String>,
    /// Why numbers are missing.
    pub missing: Option<String>,
    /// What should be known before the numbers are used.
    pub warnings: Option<String>,
}

/// Words of the column `status`.
pub const OK: &str = "ok";
/// The other one.
pub const FAILED: &str = "failed";

/// What the energies and the effort of a run are called, with their units and what they are.
const OF_THE_RUN: [(&str, &str, &str); 4] = [
    ("potential_released_j", "J", "potential energy released"),
    ("dissipated_j", "J", "energy dissipated"),
    ("energy_closure", "", "energy closed to, of that released"),
    ("steps", "", "steps of the integrator"),
];

/// Name and unit of every number of a row: those that predictions have, and those of the run itself.
pub fn numbers() -> impl Iterator<Item = (&'static str, &'static str)> {
    units().chain(OF_THE_RUN.iter().map(|(name, unit, _)| (*name, *unit)))
}

/// What a number of a row is, in words.
pub fn meaning(name: &str) -> Option<&'static str> {
    let all = meanings().chain(OF_THE_RUN.iter().map(|(.., meaning)| *meaning));
    numbers().zip(all).find(|((own, _), _)| *own == name).map(|(_, meaning)| meaning)
}

/// The case of a point: its values, each as a `--set`, over a scenario's text and what else is set.
/// # Errors
/// [`ScenarioError`] for what the scenario, the muscle or the model refuses.
pub fn case(
    scenario: &Path,
    text: &str,
    set: &[String],
    paths: &[String],
    point: &Point,
) -> Result<(Case, Scenario), ScenarioError> {
    let mut all = set.to_vec();
    all.extend(paths.iter().zip(&point.values).map(|(path, value)| setting(path, value)));
    let scenario = Scenario::parse(scenario, text, &all)?;
    let case = scenario.cases()?.swap_remove(0);
    Ok((case, scenario))
}

/// A value as it is set: a number to its last bit.
pub fn setting(path: &str, value: &Value) -> String {
    match (value, key::kind(path)) {
        (Value::Number(number), Some(Kind::Quantity(unit))) if !unit.is_empty() => {
            format!("{path}=\"{number:?} {unit}\"")
        }
        (Value::Number(number), Some(Kind::Count)) => format!("{path}={number}"),
        (Value::Number(number), _) => format!("{path}={number:?}"),
        (Value::Word(word), _) => format!("{path}=\"{word}\""),
    }
}

/// Simulates a point to its end. Whatever goes wrong stands in the row.
pub fn run(make: impl FnOnce(&Point) -> Result<Case, ScenarioError>, point: Point) -> Row {
    let simulated = catch_unwind(AssertUnwindSafe(|| {
        let case = make(&point).map_err(|error| error.message())?;
        Ok((simulate(&case.model, &case.run)?, case.warnings))
    }));
    // A fault of the program's own has been told on stderr; it must not take the other points with it.
    let simulated =
        simulated.unwrap_or_else(|_| Err("the program itself failed; please report it".to_owned()));
    match simulated {
        Ok((simulated, warnings)) => {
            let missing = simulated.missing.iter().map(|(entry, why)| format!("{entry}: {why}")).collect();
            let (missing, warnings) = (joined(missing), joined(warnings));
            Row { point, numbers: told(&simulated), failed: None, missing, warnings }
        }
        Err(why) => {
            let numbers = vec![None; numbers().count()];
            Row { point, numbers, failed: Some(why), missing: None, warnings: None }
        }
    }
}

fn joined(words: Vec<String>) -> Option<String> {
    (!words.is_empty()).then(|| words.join("; "))
}

fn told(simulated: &Simulated) -> Vec<Option<f64>> {
    let energy = |of: fn(&EnergyBalance) -> f64| simulated.energy.as_ref().map(of);
    let of_the_run = [
        energy(|energy| energy.potential_released),
        energy(|energy| energy.dissipated),
        energy(|energy| energy.closure),
        Some(simulated.effort.steps as f64),
    ];
    simulated.numbers.iter().copied().chain(of_the_run).collect()
}

/// Columns before those of the parameters: the point and its seed.
pub(super) const FIXED: usize = 2;

/// The columns of a sweep in which these keys have values.
pub fn columns(paths: &[String]) -> Vec<Column> {
    let column = |name: String, unit, holds| Column { name, unit, holds };
    let mut all =
        vec![column("point".to_owned(), "", Holds::Counts), column("seed".to_owned(), "", Holds::Counts)];
    all.extend(paths.iter().map(|path| match key::kind(path) {
        Some(Kind::Quantity(unit)) => column(key::column(path, unit), unit, Holds::Numbers),
        Some(Kind::Count) => column(key::column(path, ""), "", Holds::Counts),
        _ => column(key::column(path, ""), "", Holds::Texts),
    }));
    all.push(column("status".to_owned(), "", Holds::Texts));
    all.push(column("reason".to_owned(), "", Holds::Texts));
    all.extend(numbers().map(|(name, unit)| column(name.to_owned(), unit, Holds::NumbersOrNone)));
    all.push(column("missing".to_owned(), "", Holds::Texts));
    all.push(column("warnings".to_owned(), "", Holds::Texts));
    all
}

/// Rows as cells, column by column, in the order of [`columns`].
pub fn cells(paths: &[String], rows: &[Row]) -> Vec<Cells> {
    let counts = |of: &dyn Fn(&Row) -> i64| Cells::Counts(rows.iter().map(of).collect());
    let texts = |of: &dyn Fn(&Row) -> Option<String>| Cells::Texts(rows.iter().map(of).collect());
    let mut all = vec![counts(&|row| row.point.index as i64), counts(&|row| row.point.seed as i64)];
    for (k, path) in paths.iter().enumerate() {
        let number =
            |row: &Row| if let Value::Number(number) = row.point.values[k] { number } else { f64::NAN };
        all.push(match key::kind(path) {
            Some(Kind::Quantity(_)) => Cells::Numbers(rows.iter().map(number).collect()),
            Some(Kind::Count) => counts(&|row| number(row) as i64),
            _ => texts(&|row| match &row.point.values[k] {
                Value::Word(word) => Some(word.clone()),
                Value::Number(_) => None,
            }),
        });
    }
    let status = |row: &Row| if row.failed.is_some() { FAILED } else { OK };
    all.push(texts(&|row| Some(status(row).to_owned())));
    all.push(texts(&|row| row.failed.clone()));
    for k in 0..numbers().count() {
        all.push(Cells::Numbers(rows.iter().map(|row| row.numbers[k].unwrap_or(f64::NAN)).collect()));
    }
    all.push(texts(&|row| row.missing.clone()));
    all.push(texts(&|row| row.warnings.clone()));
    all
}
