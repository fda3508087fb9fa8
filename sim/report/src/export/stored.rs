//! The tables of a run folder, read back with their units.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use csv::Reader;
use efam_store::columns::{self, Found};
use efam_store::escape::from_cell;
use efam_store::folder::MARK;
use efam_store::input::{self, MOST_JSON, up_to};
use serde_json::Value;

use crate::SCENARIO;
use crate::calibrated::EXPERIMENT;
use crate::reread::RereadError;

/// Units by the end of a name, the longest first: text has no other place for them.
const UNITS: [(&str, &str); 14] = [
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_n_m2", "N m^2"),
    ("_n_m", "N m"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_pa", "Pa"),
    ("_mm", "mm"),
    ("_J", "J"),
    ("_m", "m"),
    ("_s", "s"),
];

/// A run folder: its tables, and what else says what it is.
#[derive(Clone, Debug)]
pub struct Stored {
    /// The folder.
    pub folder: PathBuf,
    /// Name, kind, command, when it was written, warnings: what is known of each, by a name.
    pub facts: Vec<(&'static str, String)>,
    /// Summary, and scenario or experiment, by their file names.
    pub files: Vec<(&'static str, String)>,
    /// The tables, by name.
    pub tables: Vec<Table>,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Path within the folder, without ending, such as `trajectory`.
    pub name: String,
    /// How many rows.
    pub rows: usize,
    /// Their content.
    pub series: Vec<Series>,
}

/// A column, or columns whose names differ in one number only, such as `x_00_m`, `x_01_m`, …, which become `x_m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name with unit.
    pub name: String,
    /// Unit, or nothing where there is none.
    pub unit: String,
    /// Row by row.
    pub cells: Cells,
}

/// The content of the rows.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// So many numbers a row, row after row; not a number where nothing is given.
    Numbers {
        /// Numbers in a row.
        width: usize,
        /// All of them.
        values: Vec<f64>,
    },
    /// A word a row.
    Words(Vec<String>),
}

impl Table {
    /// The time of each row, s.
    pub fn time(&self) -> Option<&[f64]> {
        self.series.iter().filter(|series| series.is_time()).find_map(|series| match &series.cells {
            Cells::Numbers { width: 1, values } => Some(&values[..]),
            _ => None,
        })
    }
}

impl Series {
    /// Whether it is called as the time of a row is.
    pub fn is_time(&self) -> bool {
        ["time_s", "t_s"].contains(&self.name.as_str())
    }
}

/// Reads the tables of a run.
/// # Errors
/// [`RereadError`].
pub fn read(folder: &Path) -> Result<Stored, RereadError> {
    if !folder.is_dir() {
        return Err(RereadError::NoFolder { folder: folder.to_owned() });
    }
    let mark = folder.join(MARK);
    if !mark.is_file() {
        return Err(RereadError::NoRun { folder: folder.to_owned() });
    }
    let mut files = Vec::new();
    for name in [MARK, SCENARIO, EXPERIMENT] {
        let file = folder.join(name);
        if file.is_file() {
            files.push((name, up_to(&file, MOST_JSON).map_err(unreadable(&file))?));
        }
    }
    let summary: Value = serde_json::from_str(&files[0].1).map_err(|error| broken(&mark, &error))?;
    let mut found = BTreeMap::new();
    list(folder, "", &mut found)?;
    let tables = found.into_iter().map(|(name, file)| table(name, &file)).collect::<Result<_, _>>()?;
    Ok(Stored { folder: folder.to_owned(), facts: facts(&summary), files, tables })
}

fn facts(summary: &Value) -> Vec<(&'static str, String)> {
    let text = |key: &str| summary[key].as_str().map(str::to_owned);
    let list = |key: &str, between: &str| -> Option<String> {
        let items = summary[key].as_array()?.iter().filter_map(Value::as_str);
        Some(items.collect::<Vec<_>>().join(between))
    };
    let kind = text("kind").or(Some("simulation".to_owned()));
    let all = [
        ("name", text("name")),
        ("kind", kind),
        ("command", list("argv", " ")),
        ("written_utc", text("written_utc")),
        ("warnings", list("warnings", "\n")),
        ("exported_by", Some(format!("efam {}", env!("CARGO_PKG_VERSION")))),
    ];
    all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

/// Tables below a folder, by name; of one that is there in both forms, Parquet.
fn list(folder: &Path, above: &str, found: &mut BTreeMap<String, PathBuf>) -> Result<(), RereadError> {
    for entry in fs::read_dir(folder).map_err(unreadable(folder))? {
        let path = entry.map_err(unreadable(folder))?.path();
        let part = |name: Option<&std::ffi::OsStr>| name.unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            list(&path, &format!("{above}{}/", part(path.file_name())), found)?;
            continue;
        }
        let name = format!("{above}{}", part(path.file_stem()));
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("parquet") => drop(found.insert(name, path)),
            Some("csv") => drop(found.entry(name).or_insert(path)),
            _ => {}
        }
    }
    Ok(())
}

fn table(name: String, file: &Path) -> Result<Table, RereadError> {
    let series = if file.extension().is_some_and(|ending| ending == "parquet") {
        of_parquet(file)?
    } else {
        of_csv(file)?
    };
    let rows = series.first().map_or(0, |series| match &series.cells {
        Cells::Numbers { values, .. } => values.len(),
        Cells::Words(words) => words.len(),
    });
    Ok(Table { name, rows, series: joined(series, rows) })
}

fn of_parquet(file: &Path) -> Result<Vec<Series>, RereadError> {
    let found = columns::table(file).map_err(|error| broken(file, &error))?;
    let one = |Found { name, unit, cells }| {
        let numbers = |values| Cells::Numbers { width: 1, values };
        let cells = match cells {
            columns::Cells::Numbers(values) => numbers(values),
            columns::Cells::Counts(counts) => numbers(counts.into_iter().map(|count| count as f64).collect()),
            columns::Cells::Texts(texts) => {
                Cells::Words(texts.into_iter().map(Option::unwrap_or_default).collect())
            }
        };
        Series { name, unit, cells }
    };
    Ok(found.into_iter().map(one).collect())
}

fn of_csv(file: &Path) -> Result<Vec<Series>, RereadError> {
    let of = |error: csv::Error| broken(file, &error);
    let bytes = input::table(file).map_err(unreadable(file))?;
    let mut reader = Reader::from_reader(&bytes[..]);
    let names: Vec<String> =
        reader.headers().map_err(of)?.iter().map(|name| from_cell(name).to_owned()).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for row in reader.records() {
        let row = row.map_err(of)?;
        columns.iter_mut().zip(&row).for_each(|(column, cell)| column.push(from_cell(cell).to_owned()));
    }
    let one = |(name, words): (String, Vec<String>)| {
        let number = |word: &String| if word.is_empty() { Some(f64::NAN) } else { word.parse().ok() };
        let cells = match words.iter().map(number).collect() {
            Some(values) => Cells::Numbers { width: 1, values },
            None => Cells::Words(words),
        };
        Series { unit: unit(&name).to_owned(), name, cells }
    };
    Ok(names.into_iter().zip(columns).map(one).collect())
}

/// The unit that a name ends in; the ends of intervals follow it.
fn unit(name: &str) -> &'static str {
    let bare = name.trim_end_matches("_95").trim_end_matches("_low").trim_end_matches("_high");
    UNITS.iter().find(|(end, _)| bare.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// Columns whose names differ by one number alone, from 0 without a gap, become one of that width.
fn joined(series: Vec<Series>, rows: usize) -> Vec<Series> {
    let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (place, one) in series.iter().enumerate() {
        if let (Some((base, number)), Cells::Numbers { .. }) = (numbered(&one.name), &one.cells) {
            let group = groups.entry(base).or_default();
            if group.len() == number {
                group.push(place);
            }
        }
    }
    let names: BTreeSet<&str> = series.iter().map(|one| one.name.as_str()).collect();
    groups.retain(|base, group| group.len() > 1 && !names.contains(base.as_str()));
    let of: BTreeMap<usize, &String> =
        groups.iter().flat_map(|(base, group)| group.iter().map(move |place| (*place, base))).collect();
    let values = |place: usize| match &series[place].cells {
        Cells::Numbers { values, .. } => &values[..],
        Cells::Words(_) => &[],
    };
    let mut result = Vec::new();
    for (place, one) in series.iter().enumerate() {
        let Some(base) = of.get(&place) else {
            result.push(one.clone());
            continue;
        };
        let group = &groups[*base];
        if group[0] == place {
            let columns: Vec<&[f64]> = group.iter().map(|place| values(*place)).collect();
            let values = (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
            let cells = Cells::Numbers { width: columns.len(), values };
            result.push(Series { name: (*base).clone(), unit: one.unit.clone(), cells });
        }
    }
    result
}

/// A name without the one part that is a number of two digits at least, and that number.
fn numbered(name: &str) -> Option<(String, usize)> {
    let is_number = |part: &&str| part.len() > 1 && part.bytes().all(|byte| byte.is_ascii_digit());
    let number = name.split('_').find(is_number)?;
    let others: Vec<&str> = name.split('_').filter(|part| !is_number(part)).collect();
    Some((others.join("_"), number.parse().ok()?))
}

fn unreadable(file: &Path) -> impl Fn(std::io::Error) -> RereadError {
    let file = file.to_owned();
    move |source| RereadError::Unreadable { file: file.clone(), source }
}

fn broken(file: &Path, reason: &dyn std::fmt::Display) -> RereadError {
    RereadError::Broken { file: file.to_owned(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_one_number_tells_apart_become_one() {
        let one = |name: &str, value: f64| Series {
            name: name.to_owned(),
            unit: "m".to_owned(),
            cells: Cells::Numbers { width: 1, values: vec![value, -value] },
        };
        let names =
            ["x_00_m", "tip_x_m", "x_01_m", "rest_x_m_low_95", "z_00_m", "z_02_m", "y_00_m", "y_01_m", "y_m"];
        let series = names.iter().enumerate().map(|(k, name)| one(name, k as f64)).collect();
        let joined = joined(series, 2);
        let found: Vec<&str> = joined.iter().map(|series| series.name.as_str()).collect();
        // A gap, an interval's level and a name that is taken join nothing.
        let expected = ["x_m", "tip_x_m", "rest_x_m_low_95", "z_00_m", "z_02_m", "y_00_m", "y_01_m", "y_m"];
        assert_eq!(found, expected);
        assert_eq!(joined[0].cells, Cells::Numbers { width: 2, values: vec![0.0, 2.0, 0.0, -2.0] });
    }

    #[test]
    fn names_end_in_their_unit() {
        for (name, expected) in [
            ("tip_vx_m_s", "m/s"),
            ("body_rate_rad_s", "rad/s"),
            ("root_moment_n_m_high_95", "N m"),
            ("t_s", "s"),
            ("total_J", "J"),
            ("damping_ratio", ""),
        ] {
            assert_eq!(unit(name), expected, "{name}");
        }
    }
}
