//! What can be wrong with a muscle file, or with a request to a muscle.

use thiserror::Error;

use super::{BUILT_IN, Extrapolated};
use crate::nearest::nearest;
use crate::quantity::{QuantityError, Unit, format_si};

/// A muscle file that cannot be used, or a question that a muscle cannot answer.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MuscleError {
    /// No built-in muscle has this name.
    #[error(
        "no built-in muscle \"{name}\": there is {}; describe another in a file of the same form",
        built_in()
    )]
    UnknownMuscle {
        /// The name.
        name: String,
    },
    /// The file is not TOML, or a key is missing, unknown or of another type.
    #[error("{}", .0.to_string().trim_end())]
    Toml(#[from] toml::de::Error),
    /// A quantity cannot be read or is of another kind than is due.
    #[error("{key}: {problem}")]
    Quantity {
        /// The key, such as `rest.length`.
        key: String,
        /// What is wrong.
        problem: QuantityError,
    },
    /// A constant has a value that it cannot have.
    #[error("{key} = {value}: must {must}")]
    Constant {
        /// The key.
        key: &'static str,
        /// The value with its unit.
        value: String,
        /// What is admissible.
        must: &'static str,
    },
    /// A column that no muscle has.
    #[error("table.columns: unknown column \"{column}\"{}; known are {}", did_you_mean(.column, .known), .known.join(", "))]
    UnknownColumn {
        /// Its name.
        column: String,
        /// Those that there may be.
        known: Vec<&'static str>,
    },
    /// A column is given twice.
    #[error("table.columns: \"{column}\" stands twice; give each column once")]
    ColumnTwice {
        /// Its name.
        column: String,
    },
    /// A column that every muscle needs is missing.
    #[error("table.columns: \"{column}\" is missing; {why}")]
    MissingColumn {
        /// Its name.
        column: &'static str,
        /// What it is needed for, or what may replace it.
        why: &'static str,
    },
    /// There are not as many units as columns.
    #[error("table.units: {units} units for {columns} columns; give one for each")]
    UnitsDiffer {
        /// Number of units.
        units: usize,
        /// Number of columns.
        columns: usize,
    },
    /// Too few rows to interpolate.
    #[error("table.rows: {rows} rows; interpolation over pressure needs at least 2")]
    TooFewRows {
        /// How many there are.
        rows: usize,
    },
    /// More rows than a table of pressures has.
    #[error(
        "table.rows: {rows} rows; at most {most} are read; give fewer pressures, for between them is a smooth curve"
    )]
    TooManyRows {
        /// How many there are.
        rows: usize,
        /// How many there may be.
        most: usize,
    },
    /// A row is not as long as the table is wide.
    #[error("table.rows: row {row} has {found} values for {columns} columns")]
    RowLength {
        /// Which row, from one.
        row: usize,
        /// How many values it has.
        found: usize,
        /// How many columns there are.
        columns: usize,
    },
    /// A value in the table that cannot be.
    #[error("table.rows: row {row}, {column} = {value}: must {must}")]
    Value {
        /// Which row, from one.
        row: usize,
        /// Its column.
        column: String,
        /// The value with its unit.
        value: String,
        /// What is admissible.
        must: &'static str,
    },
    /// What a calibration says of its errors makes no sense.
    #[error("{what}; calibrate again, or take the section [calibration] out")]
    Calibration {
        /// What is wrong, and where.
        what: String,
    },
    /// The muscle has no such estimate of its bending stiffness.
    #[error("{muscle} has no bending stiffness \"{asked}\": it has {}{}", .known.join(", "), did_you_mean(.asked, .known))]
    UnknownStiffness {
        /// Name of the muscle.
        muscle: String,
        /// What was requested.
        asked: String,
        /// What there is.
        known: Vec<String>,
    },
    /// The pressure is infinite or not a number.
    #[error("pressure = {pressure} Pa: must be finite")]
    PressureNotFinite {
        /// The pressure, Pa.
        pressure: f64,
    },
    /// The pressure lies outside the table and extrapolation was not requested.
    #[error("pressure = {}: outside the table of {muscle}, {}; choose a pressure inside, or set extrapolation = \"allowed\"", pressure_text(*.pressure), range_text(*.range))]
    OutsideTable {
        /// Name of the muscle.
        muscle: String,
        /// The pressure, Pa.
        pressure: f64,
        /// Lowest and highest pressure of the table, Pa.
        range: (f64, f64),
    },
    /// Extrapolation leads to what cannot be.
    #[error("pressure = {}: extrapolation gives {quantity} = {}, which must be positive; choose a pressure nearer to {}", pressure_text(.extrapolated.pressure), format_si(*.value, .unit), range_text(.extrapolated.range))]
    ExtrapolatedTooFar {
        /// Pressure and table.
        extrapolated: Extrapolated,
        /// What is not positive.
        quantity: &'static str,
        /// Its value in `unit`.
        value: f64,
        /// SI unit.
        unit: &'static str,
    },
}

/// A pressure as people here read it: `15 psi (103.421 kPa)`.
pub(super) fn pressure_text(pascal: f64) -> String {
    format!("{} psi ({} kPa)", in_unit(pascal, "psi"), in_unit(pascal, "kPa"))
}

/// A range of pressures: `5 to 100 psi (34.474 to 689.476 kPa)`.
pub(super) fn range_text((low, high): (f64, f64)) -> String {
    let [psi, kpa] =
        ["psi", "kPa"].map(|unit| format!("{} to {} {unit}", in_unit(low, unit), in_unit(high, unit)));
    format!("{psi} ({kpa})")
}

/// To three decimals: fine enough to distinguish a pressure from the end of a table that it misses. A pressure that would be
/// left with less than two digits keeps four.
fn in_unit(pascal: f64, unit: &str) -> String {
    let value = pascal / Unit::parse(unit).map_or(1.0, |unit| unit.scale);
    match value.abs() {
        1e-2..1e9 => ((value * 1e3).round() / 1e3).to_string(),
        _ => format_si(value, ""),
    }
}

fn built_in() -> String {
    let names: Vec<&str> = BUILT_IN.iter().map(|muscle| muscle.0).collect();
    names.join(", ")
}

fn did_you_mean(name: &str, known: &[impl AsRef<str>]) -> String {
    let nearest = nearest(name, known.iter().map(AsRef::as_ref));
    nearest.map_or(String::new(), |nearest| format!("; did you mean \"{nearest}\"?"))
}
