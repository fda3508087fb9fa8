//! The form of a muscle file, and its way into SI units.

use std::collections::BTreeSet;

use serde::Deserialize;

use super::{EndFitting, Known, Muscle, MuscleError, Rest};
use crate::interpolate::Pchip;
use crate::quantity::Quantity;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    gravity: Quantity,
    rest: RestKeys,
    end_fitting: EndFittingKeys,
    table: Table,
    calibration: Option<Known>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RestKeys {
    length: Quantity,
    mass_per_length: Quantity,
    inner_diameter: Option<Quantity>,
    outer_diameter: Option<Quantity>,
    braid_angle: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EndFittingKeys {
    mass: Quantity,
    center_of_mass: Quantity,
    rotary_inertia: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    columns: Vec<String>,
    units: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// Rows of a table, at most: "all rows" is a model for each.
const MOST_ROWS: usize = 1000;

/// What a number may be.
#[derive(Clone, Copy, PartialEq)]
enum Must {
    BePositive,
    NotBeNegative,
    BeFinite,
    BeAcute,
}
use Must::{BeAcute, BeFinite, BePositive, NotBeNegative};

/// Columns that a table may have: name, SI unit, admissible values. Behind a name that ends with an
/// underscore goes the name of an estimate.
const COLUMNS: &[(&str, &str, Must)] = &[
    ("pressure", "Pa", BeFinite),
    ("length", "m", BePositive),
    ("inner_diameter", "m", NotBeNegative),
    ("outer_diameter", "m", BePositive),
    ("axial_stiffness", "N", BePositive),
    (BENDING_STIFFNESS, "N m^2", BePositive),
    ("rayleigh_mass", "1/s", NotBeNegative),
    ("rayleigh_stiffness", "s", NotBeNegative),
    (VISCOELASTIC[0], "", NotBeNegative),
    (VISCOELASTIC[1], "s", BePositive),
];

/// Columns of a viscoelastic branch, which belong together.
pub(super) const VISCOELASTIC: [&str; 2] = ["viscoelastic_branch_stiffness", "viscoelastic_relaxation_time"];

const BENDING_STIFFNESS: &str = "bending_stiffness_";

pub(super) fn muscle(text: &str) -> Result<Muscle, MuscleError> {
    let file: File = toml::from_str(text)?;
    let (rest, end_fitting) = (&file.rest, &file.end_fitting);
    let rest = Rest {
        length: constant("rest.length", &rest.length, "m", BePositive)?,
        mass_per_length: constant("rest.mass_per_length", &rest.mass_per_length, "kg/m", BePositive)?,
        inner_diameter: optional("rest.inner_diameter", &rest.inner_diameter, "m", NotBeNegative)?,
        outer_diameter: optional("rest.outer_diameter", &rest.outer_diameter, "m", BePositive)?,
        braid_angle: optional("rest.braid_angle", &rest.braid_angle, "rad", BeAcute)?,
    };
    if let (Some(inner), Some(outer)) = (rest.inner_diameter, rest.outer_diameter)
        && inner >= outer
    {
        let value = file.rest.inner_diameter.as_ref().map_or(String::new(), Quantity::to_string);
        let must = "be smaller than rest.outer_diameter";
        return Err(MuscleError::Constant { key: "rest.inner_diameter", value, must });
    }
    let end_fitting = EndFitting {
        mass: constant("end_fitting.mass", &end_fitting.mass, "kg", NotBeNegative)?,
        center_of_mass: constant("end_fitting.center_of_mass", &end_fitting.center_of_mass, "m", BeFinite)?,
        rotary_inertia: constant(
            "end_fitting.rotary_inertia",
            &end_fitting.rotary_inertia,
            "kg m^2",
            NotBeNegative,
        )?,
    };
    let gravity = constant("gravity", &file.gravity, "m/s^2", NotBeNegative)?;

    file.calibration.as_ref().map_or(Ok(()), Known::check)?;
    let table = file.table;
    table.check_shape()?;
    let pressure = table.pressure()?;
    let curve = |values: Vec<f64>| Pchip::new(pressure.clone(), values).expect("the table is checked");
    let needed = |column| table.needed(column, "every muscle needs it");
    let length = needed("length")?;
    let (inner_diameter, outer_diameter) = table.diameters(&rest, &length)?;
    let axial_stiffness = table.axial_stiffness(&inner_diameter, &outer_diameter)?;
    let mut bending_stiffness = Vec::new();
    for (column, name) in table.columns.iter().enumerate() {
        if let Some(source) = name.strip_prefix(BENDING_STIFFNESS) {
            bending_stiffness.push((source.to_string(), curve(table.column(column)?)));
        }
    }
    if bending_stiffness.is_empty() {
        let why = "give at least one, such as bending_stiffness_euler";
        return Err(MuscleError::MissingColumn { column: BENDING_STIFFNESS, why });
    }
    Ok(Muscle {
        name: file.name,
        source: file.source,
        rest,
        end_fitting,
        gravity,
        known: file.calibration,
        length: curve(length),
        inner_diameter: curve(inner_diameter),
        outer_diameter: curve(outer_diameter),
        axial_stiffness: curve(axial_stiffness),
        bending_stiffness,
        rayleigh_mass: table.find("rayleigh_mass")?.map(curve),
        rayleigh_stiffness: table.find("rayleigh_stiffness")?.map(curve),
        viscoelastic: table.viscoelastic()?.map(|pair| pair.map(curve)),
        pressure,
    })
}

fn constant(key: &'static str, quantity: &Quantity, unit: &str, must: Must) -> Result<f64, MuscleError> {
    let value =
        quantity.to(unit).map_err(|problem| MuscleError::Quantity { key: key.to_string(), problem })?;
    if must.admits(value) {
        return Ok(value);
    }
    Err(MuscleError::Constant { key, value: quantity.to_string(), must: must.text() })
}

fn optional(
    key: &'static str,
    quantity: &Option<Quantity>,
    unit: &str,
    must: Must,
) -> Result<Option<f64>, MuscleError> {
    let quantity = quantity.as_ref();
    quantity.map(|quantity| constant(key, quantity, unit, must)).transpose()
}

impl Must {
    fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                BePositive => value > 0.0,
                NotBeNegative => value >= 0.0,
                BeFinite => true,
                BeAcute => value > 0.0 && value < std::f64::consts::FRAC_PI_2,
            }
    }

    fn text(self) -> &'static str {
        match self {
            BePositive => "be positive",
            NotBeNegative => "not be negative",
            BeFinite => "be finite",
            BeAcute => "lie between 0 and 90 deg",
        }
    }
}

impl Table {
    fn check_shape(&self) -> Result<(), MuscleError> {
        let columns = self.columns.len();
        let mut known = BTreeSet::new();
        for column in &self.columns {
            declared(column)?;
            if !known.insert(column) {
                return Err(MuscleError::ColumnTwice { column: column.clone() });
            }
        }
        if self.units.len() != columns {
            let units = self.units.len();
            return Err(MuscleError::UnitsDiffer { units, columns });
        }
        if self.rows.len() < 2 {
            let rows = self.rows.len();
            return Err(MuscleError::TooFewRows { rows });
        }
        if self.rows.len() > MOST_ROWS {
            return Err(MuscleError::TooManyRows { rows: self.rows.len(), most: MOST_ROWS });
        }
        match self.rows.iter().position(|row| row.len() != columns) {
            None => Ok(()),
            Some(row) => Err(MuscleError::RowLength { row: row + 1, found: self.rows[row].len(), columns }),
        }
    }

    /// Pressures, Pa, increasing.
    fn pressure(&self) -> Result<Vec<f64>, MuscleError> {
        let pressure = self.needed("pressure", "every other column is over it")?;
        match pressure.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(pressure),
            Some(row) => Err(self.value_error(row + 1, "pressure", "be larger than in the row before")),
        }
    }

    /// Inner and outer diameter, m: their own columns, or from the resting ones by braid and wall.
    fn diameters(&self, rest: &Rest, length: &[f64]) -> Result<(Vec<f64>, Vec<f64>), MuscleError> {
        let outer = match self.find("outer_diameter")? {
            Some(measured) => measured,
            None if rest.braid_angle.is_none() || rest.outer_diameter.is_none() => {
                let why = "or give rest.braid_angle and rest.outer_diameter, from which it follows";
                return Err(MuscleError::MissingColumn { column: "outer_diameter", why });
            }
            None => self.by_length(
                length,
                &|row| rest.outer_diameter_at(length[row]),
                "be less than rest.length / sin(rest.braid_angle), at which the fibres are straight",
            )?,
        };
        let inner = match self.find("inner_diameter")? {
            Some(measured) => measured,
            None if rest.inner_diameter.is_none() || rest.outer_diameter.is_none() => {
                let why = "or give rest.inner_diameter and rest.outer_diameter, from which it follows";
                return Err(MuscleError::MissingColumn { column: "inner_diameter", why });
            }
            None => self.by_length(
                length,
                &|row| rest.inner_diameter_at(length[row], outer[row]),
                "leave room inside a wall that keeps its volume; check the diameters and rest.braid_angle",
            )?,
        };
        match inner.iter().zip(&outer).position(|(inner, outer)| inner >= outer) {
            None => Ok((inner, outer)),
            Some(row) => Err(self.value_error(row, "inner_diameter", "be smaller than outer_diameter")),
        }
    }

    /// Axial stiffness EA, N: its own column, or from the bending stiffness of axial tests.
    ///
    /// `EA = 16 EI / (D² + d²)`, the section a ring of one isotropic material.
    /// Source: Garbulinski and Wereley (2022), eq. 8.
    fn axial_stiffness(&self, inner: &[f64], outer: &[f64]) -> Result<Vec<f64>, MuscleError> {
        if let Some(measured) = self.find("axial_stiffness")? {
            return Ok(measured);
        }
        let why = "the axial stiffness follows from it; or give axial_stiffness itself";
        let bending = self.needed("bending_stiffness_axial", why)?;
        let rows = bending.iter().zip(inner.iter().zip(outer));
        let axial: Vec<f64> = rows.map(|(ei, (d, big_d))| 16.0 * ei / (big_d * big_d + d * d)).collect();
        match axial.iter().position(|ea| !BePositive.admits(*ea)) {
            None => Ok(axial),
            Some(row) => {
                let must = "give a finite axial stiffness, 16 EI / (D² + d²), with the diameters";
                Err(self.value_error(row, "bending_stiffness_axial", must))
            }
        }
    }

    /// A number of each row that follows from its length; one that cannot be is an error of the length.
    fn by_length(
        &self,
        length: &[f64],
        of: &dyn Fn(usize) -> Option<f64>,
        must: &'static str,
    ) -> Result<Vec<f64>, MuscleError> {
        let value = |row| of(row).ok_or_else(|| self.value_error(row, "length", must));
        (0..length.len()).map(value).collect()
    }

    /// Branch stiffness over EI and relaxation time, s; none without both columns.
    fn viscoelastic(&self) -> Result<Option<[Vec<f64>; 2]>, MuscleError> {
        let [stiffness, time] = VISCOELASTIC;
        let why = "a viscoelastic branch has a stiffness and a time; give both columns, or none";
        match (self.find(stiffness)?, self.find(time)?) {
            (None, None) => Ok(None),
            (Some(stiffness), Some(time)) => Ok(Some([stiffness, time])),
            (None, Some(_)) => Err(MuscleError::MissingColumn { column: stiffness, why }),
            (Some(_), None) => Err(MuscleError::MissingColumn { column: time, why }),
        }
    }

    fn needed(&self, column: &'static str, why: &'static str) -> Result<Vec<f64>, MuscleError> {
        self.find(column)?.ok_or(MuscleError::MissingColumn { column, why })
    }

    fn find(&self, name: &str) -> Result<Option<Vec<f64>>, MuscleError> {
        let column = self.columns.iter().position(|column| column == name);
        column.map(|column| self.column(column)).transpose()
    }

    /// Values of a column in SI units.
    fn column(&self, column: usize) -> Result<Vec<f64>, MuscleError> {
        let name = &self.columns[column];
        let (si_unit, must) = declared(name)?;
        let one = Quantity::parse(&format!("1 {}", self.units[column]));
        let scale = one
            .and_then(|one| one.to(si_unit))
            .map_err(|problem| MuscleError::Quantity { key: format!("table.units, {name}"), problem })?;
        // A number may be finite, and no longer so in SI.
        match self.rows.iter().position(|row| !must.admits(row[column] * scale)) {
            None => Ok(self.rows.iter().map(|row| row[column] * scale).collect()),
            Some(row) => Err(self.value_error(row, name, must.text())),
        }
    }

    /// The value in row `row`, from zero, is not what it must be.
    fn value_error(&self, row: usize, column: &str, must: &'static str) -> MuscleError {
        let index = self.columns.iter().position(|name| name == column).expect("a column of the table");
        MuscleError::Value {
            row: row + 1,
            column: column.to_string(),
            value: format!("{} {}", self.rows[row][index], self.units[index]),
            must,
        }
    }
}

/// SI unit and admissible values of a column.
fn declared(name: &str) -> Result<(&'static str, Must), MuscleError> {
    let is_it = |known: &str| match known.strip_suffix('_') {
        Some(_) => name.len() > known.len() && name.starts_with(known),
        None => name == known,
    };
    let known = COLUMNS.iter().find(|column| is_it(column.0));
    known.map(|column| (column.1, column.2)).ok_or_else(|| MuscleError::UnknownColumn {
        column: name.to_string(),
        known: COLUMNS.iter().map(|column| column.0).collect(),
    })
}
