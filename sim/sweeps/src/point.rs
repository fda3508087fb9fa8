//! A point of a sweep over a scenario: the case that it defines, and what a run of that says.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use efam_experiments::scenario::{Case, Scenario, ScenarioError};
use efam_experiments::summary::EnergyBalance;
use efam_inference::predict::quantity::{meanings, units};
use efam_inference::predict::simulated::{Simulated, simulate};
use efam_store::columns::{Cell, Column, Holds};

use super::key::{self, ValueKind, Varying};
use super::row::{DesignValue, Point, Row, fault, joined};

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
    let keys = Varying::with(scenario, text, paths)?;
    let mut all = set.to_vec();
    all.extend(paths.iter().zip(&point.values).map(|(path, value)| setting(keys.kind(path), path, value)));
    let scenario = Scenario::parse(scenario, text, &all)?;
    let case = scenario.cases()?.swap_remove(0).begun();
    Ok((case, scenario))
}

/// A value as it is set: a number to its last bit.
pub fn setting(kind: Option<ValueKind>, path: &str, value: &DesignValue) -> String {
    match (value, kind) {
        (DesignValue::Number(number), Some(ValueKind::Quantity(unit))) if !unit.is_empty() => {
            format!("{path}=\"{number:?} {unit}\"")
        }
        (DesignValue::Number(number), Some(ValueKind::Count)) => format!("{path}={number}"),
        (DesignValue::Number(number), _) => format!("{path}={number:?}"),
        (DesignValue::Word(word), _) => format!("{path}=\"{word}\""),
    }
}

/// Simulates a point to its end. The row gives whatever goes wrong.
pub fn run(make: impl FnOnce(&Point) -> Result<Case, ScenarioError>, point: &Point) -> Row {
    let simulated = catch_unwind(AssertUnwindSafe(|| {
        let case = make(point).map_err(|error| error.message())?;
        Ok((simulate(&case.model, &case.run)?, case.warnings))
    }));
    match simulated.unwrap_or_else(|_| Err(fault())) {
        Ok((simulated, warnings)) => {
            let missing = simulated.missing.iter().map(|(entry, why)| format!("{entry}: {why}")).collect();
            let numbers = told(&simulated).into_iter().map(|own| Cell::Number(own.unwrap_or(f64::NAN)));
            let words = [joined(missing, "; "), joined(warnings, "; ")].map(Cell::Text);
            Row::whole(numbers.chain(words).collect())
        }
        Err(why) => Row::failed(why, &answers()),
    }
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

/// The columns that a point has before it is run: its number, its seed, and the values of these keys.
pub(super) fn given(keys: &Varying, paths: &[String]) -> Vec<Column> {
    let column = |name: String, unit, holds| Column { name, unit, holds };
    let mut all =
        vec![column("point".to_owned(), "", Holds::Counts), column("seed".to_owned(), "", Holds::Counts)];
    all.extend(paths.iter().map(|path| match keys.kind(path) {
        Some(ValueKind::Quantity(unit)) => column(key::column(path, unit), unit, Holds::Numbers),
        Some(ValueKind::Count) => column(key::column(path, ""), "", Holds::Counts),
        _ => column(key::column(path, ""), "", Holds::Texts),
    }));
    all
}

/// The columns of what a run says.
pub(super) fn answers() -> Vec<Column> {
    let numbers = numbers().map(|(name, unit)| (name, unit, Holds::NumbersOrNone));
    let words = ["missing", "warnings"].map(|name| (name, "", Holds::Texts));
    let column = |(name, unit, holds): (&str, _, _)| Column { name: name.to_owned(), unit, holds };
    numbers.chain(words).map(column).collect()
}
