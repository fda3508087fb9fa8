//! What is done with a point, and the row that comes of it.
//!
//! A row begins with what the plan says of the point, goes on with `status` and `reason`, and ends with the answers of
//! its kind of work. Plan, shards, merge and cluster know no more of either kind than this.

use std::path::Path;

use efam_experiments::scenario::{Case, ScenarioError};
use efam_store::columns::{Cell, Cells, Column, Holds};
use efam_store::escape::{cell, from_cell};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::diagnosed::{self, Diagnose};
use super::key::Varying;
use super::point;
use super::request::Design;
use super::row::{DesignValue, FAILED, OK, Point, Row};

/// What is done with each point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// A scenario is simulated with values of its own.
    Simulate(Simulate),
    /// An experiment is diagnosed.
    Diagnose(Diagnose),
}

/// Simulations of one scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulate {
    /// How points were chosen.
    pub design: Design,
    /// Of the random numbers.
    pub seed: u64,
    /// Keys of the scenario that have a value of their own at each point.
    pub parameters: Vec<String>,
    /// The file of the scenario.
    pub scenario: String,
    /// What it says.
    pub scenario_text: String,
    /// What is set over it at every point: whatever other files say.
    pub set: Vec<String>,
}

impl Work {
    /// Columns that a point has before anything is done: its number first.
    pub fn given(&self) -> Vec<Column> {
        match self {
            Work::Simulate(own) => point::given(&own.keys(), &own.parameters),
            Work::Diagnose(_) => diagnosed::given(),
        }
    }

    /// All columns of a row.
    pub fn columns(&self) -> Vec<Column> {
        let mut all = self.given();
        let text = |name: &str| Column { name: name.to_owned(), unit: "", holds: Holds::Texts };
        all.extend(["status", "reason"].map(text));
        all.extend(match self {
            Work::Simulate(_) => point::answers(),
            Work::Diagnose(_) => diagnosed::answers(),
        });
        all
    }

    /// Columns before those of a point's values: its number, and its seed where something is random.
    fn fixed(&self) -> usize {
        match self {
            Work::Simulate(_) => 2,
            Work::Diagnose(_) => 1,
        }
    }

    /// A point as a line of the plan has it.
    pub(super) fn line(&self, point: &Point) -> String {
        let value = |value: &DesignValue| match value {
            DesignValue::Number(number) => format!("{number:?}"),
            DesignValue::Word(word) => cell(word).into_owned(),
        };
        let fixed = [point.index as u64, point.seed].into_iter().take(self.fixed());
        let cells: Vec<String> =
            fixed.map(|number| number.to_string()).chain(point.values.iter().map(value)).collect();
        cells.join(",") + "\n"
    }

    /// The point of such a line, of which `given` are the columns; none if it is no line of it.
    pub(super) fn point(&self, given: &[Column], line: &str) -> Option<Point> {
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != given.len() {
            return None;
        }
        let (fixed, cells) = cells.split_at(self.fixed());
        let seed = fixed.get(1).map_or(Some(0), |seed| seed.parse().ok())?;
        let value = |(column, cell): (&Column, &&str)| match column.holds {
            Holds::Texts => Some(DesignValue::Word(from_cell(cell).to_owned())),
            _ => cell.parse().ok().map(DesignValue::Number),
        };
        let values = given[self.fixed()..].iter().zip(cells).map(value).collect::<Option<_>>()?;
        Some(Point { index: fixed[0].parse().ok()?, seed, values })
    }

    /// Does what is to be done with a point, to its end. The row gives whatever goes wrong.
    pub fn run(&self, point: &Point) -> Row {
        match self {
            Work::Simulate(own) => point::run(|point| own.case(point), point),
            Work::Diagnose(own) => diagnosed::run(own, point),
        }
    }

    /// Points with their rows as cells, column by column.
    pub(super) fn table(&self, rows: Vec<(Point, Row)>) -> Vec<Cells> {
        let columns = self.columns();
        let mut all: Vec<Cells> = columns.iter().map(|column| column.holds.none()).collect();
        for (point, row) in rows {
            let fixed = [point.index as u64, point.seed].into_iter().take(self.fixed());
            let values =
                columns[self.fixed()..].iter().zip(point.values).map(|(column, value)| match value {
                    DesignValue::Number(number) if column.holds == Holds::Counts => {
                        Cell::Count(number as i64)
                    }
                    DesignValue::Number(number) => Cell::Number(number),
                    DesignValue::Word(word) => Cell::Text(Some(word).filter(|word| !word.is_empty())),
                });
            let status = if row.is_failed() { FAILED } else { OK };
            let words = [Some(status.to_owned()), row.failed].map(Cell::Text);
            let cells = fixed.map(|number| Cell::Count(number as i64)).chain(values).chain(words);
            all.iter_mut().zip(cells.chain(row.answers)).for_each(|(column, cell)| column.push(cell));
        }
        all
    }

    /// What a column of numbers is, in words.
    pub(super) fn meaning(&self, column: &str) -> String {
        let (paths, meaning) = match self {
            Work::Simulate(own) => (own.parameters.as_slice(), point::meaning(column)),
            Work::Diagnose(_) => (&[][..], diagnosed::meaning(column)),
        };
        let given = self.given();
        let path = given[self.fixed()..].iter().zip(paths).find(|(own, _)| own.name == column);
        path.map(|(_, path)| path.as_str()).or(meaning).unwrap_or(column).to_owned()
    }

    /// What a point is when all went well: simulated, diagnosed.
    pub fn done(&self) -> &'static str {
        match self {
            Work::Simulate(_) => "simulated",
            Work::Diagnose(_) => "diagnosed",
        }
    }
}

impl Simulate {
    /// Keys that may vary.
    fn keys(&self) -> Varying {
        // A plan is made of a scenario that can be read; what was altered since is refused by its hash.
        Varying::with(Path::new(&self.scenario), &self.scenario_text, &self.parameters).unwrap_or_default()
    }

    /// The case of a point.
    /// # Errors
    /// [`ScenarioError`] for what the scenario, the muscle or the model refuses.
    pub fn case(&self, own: &Point) -> Result<Case, ScenarioError> {
        let scenario = Path::new(&self.scenario);
        Ok(point::case(scenario, &self.scenario_text, &self.set, &self.parameters, own)?.0)
    }
}
