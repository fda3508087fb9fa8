//! One column of a table over its time, such as a pressure that was recorded beside the markers.

use std::path::Path;

use super::cells::{Numbers, Rows, decode, without_blanks};
use super::column::{Column, column};
use super::error::{RecordingError, RecordingProblem};
use super::layout::second_of;
use super::{read, tidy};

/// A column over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its whole name, such as `p_bar`.
    pub name: String,
    /// Unit at the end of the name, if there is one.
    pub unit: Option<String>,
    /// On the file's own clock, s, ascending.
    pub time: Vec<f64>,
    /// In its own unit.
    pub values: Vec<f64>,
}

/// Reads a column of a text by its name, with or without its unit. Rows without a number are passed over.
/// # Errors
/// [`RecordingError`], also where no column has the name, or no other one is a time.
pub fn series(path: &Path, name: &str) -> Result<Series, RecordingError> {
    table(path, |text| of_text(text, name))
}

/// What a table in text says.
fn table<T>(path: &Path, of: impl Fn(String) -> Result<T, RecordingProblem>) -> Result<T, RecordingError> {
    let read = || {
        let bytes = read::load(path)?;
        if bytes.starts_with(b"PAR1") {
            let what = "a table in Parquet, of which markers alone are read".to_owned();
            return Err(RecordingProblem::NotRead { what, remedy: "save the table as CSV" });
        }
        let text = decode(bytes)?.0;
        of(without_blanks(&text).unwrap_or(text))
    };
    read().map_err(|problem| RecordingError { file: path.to_owned(), problem })
}

/// The columns of a text by their whole names, each with the unit at its end.
/// # Errors
/// As [`series`].
pub fn quantities(path: &Path) -> Result<Vec<(String, Option<String>)>, RecordingError> {
    let names = table(path, |text| Ok(tidy::names(&mut Rows::new(&text))?.0))?;
    Ok(names.into_iter().map(|name| (name.clone(), stem(&name).1.map(str::to_owned))).collect())
}

fn of_text(text: String, wanted: &str) -> Result<Series, RecordingProblem> {
    let rows = &mut Rows::new(&text);
    let (names, line) = tidy::names(rows)?;
    let of = |name: &str| {
        let (stem, unit) = stem(name);
        (name == wanted || stem == wanted).then(|| (name.to_owned(), unit.map(str::to_owned)))
    };
    let missing = |expected: String| RecordingProblem::Header { line, expected, met: names.join(", ") };
    let found = names.iter().enumerate().find_map(|(at, name)| Some((at, of(name)?)));
    let (at, (name, unit)) = found.ok_or_else(|| missing(format!("a column `{wanted}`")))?;
    let clock = names.iter().enumerate().find_map(|(at, name)| match column(name) {
        Column::Time(second, _) => Some((at, second)),
        _ => None,
    });
    let (clock, second) = clock.ok_or_else(|| missing("a column of times, such as t_s,".to_owned()))?;
    let (mut time, mut values, mut numbers) = (Vec::new(), Vec::new(), Numbers::default());
    while rows.read_filled()? {
        let line = rows.line();
        let wrong = |column: usize, name: &str| RecordingProblem::NotANumber {
            line,
            column: column + 1,
            name: name.to_owned(),
            value: super::cells::short(rows.cell(column)),
        };
        let Some(value) = numbers.read(rows.cell(at), line).map_err(|_| wrong(at, &name))? else { continue };
        let now = second_of(rows.cell(clock), second, &mut numbers, line);
        let now = now.ok_or_else(|| wrong(clock, &names[clock]))?;
        if time.last().is_some_and(|before| now <= *before) {
            let (expected, met) = ("times that ascend".to_owned(), format!("{now} s"));
            return Err(RecordingProblem::Header { line, expected, met });
        }
        time.push(now);
        values.push(value);
    }
    numbers.finding()?;
    match time.len() {
        0 => Err(RecordingProblem::HeaderOnly { line }),
        1 => Err(RecordingProblem::OneSample),
        _ => Ok(Series { name, unit, time, values }),
    }
}

/// A name without the unit at its end: `p_bar`, `p (bar)`.
fn stem(name: &str) -> (&str, Option<&str>) {
    let bracketed = name.strip_suffix([')', ']']).and_then(|rest| rest.rsplit_once(['(', '[']));
    match bracketed.or_else(|| name.rsplit_once(['_', ' '])) {
        Some((stem, unit)) => (stem.trim_end_matches([' ', '_']), Some(unit)),
        None => (name, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_read_by_its_name() {
        let read = |text: &str, name: &str| of_text(text.to_owned(), name).map_err(|error| error.to_string());
        let text = "t_ms,tip_x_m,p_bar\n0,1,1.5\n10,1,\n20,1,2\n";
        for name in ["p", "p_bar"] {
            let found = read(text, name).unwrap();
            assert_eq!((found.time, found.values), (vec![0.0, 0.02], vec![1.5, 2.0]));
            assert_eq!((found.name.as_str(), found.unit.as_deref()), ("p_bar", Some("bar")));
        }
        assert_eq!(read("t_s;p (mbar)\n0;1,5\n1;2,5\n", "p").unwrap().values, [1.5, 2.5]);
        assert!(read(text, "q").unwrap_err().contains("a column `q`, met t_ms, tip_x_m, p_bar"));
        assert!(read("p_bar,tip_x_m\n0,1\n1,1\n", "p").unwrap_err().contains("a column of times"));
        assert!(read("t_s,p\n0,1\n0,1\n", "p").unwrap_err().contains("times that ascend"));
        assert!(read("t_s,p\n0,1\n1,much\n", "p").unwrap_err().contains("much"));
    }
}
