//! MAT of version 7.3, which is HDF5: a struct for each table, with its columns by name.
//!
//! `run = load("release.mat"); plot(run.trajectory.time_s, run.trajectory.tip_z_m)`. The struct `unit` has the unit
//! of each column under the same names, `about` the facts of the run and its files as text. A column of words holds
//! numbers from 1 on; the struct `words` has the words, one a line: Octave reads no cell arrays of this format.

use std::collections::{HashMap, HashSet};
use std::io::{self, Write};

use hdf5_pure::mat::{InvalidNamePolicy, MatBuilder, MatError, Options, StructWriter};

use crate::export::stored::{Cells, Series, Stored, Table};

/// Letters of a name that every MATLAB admits.
pub(super) const MOST_LETTERS: usize = 63;

/// Writes the file.
/// # Errors
/// An error of the writer.
pub(super) fn write(run: &Stored, to: impl Write) -> io::Result<()> {
    let mut options = Options::default();
    options.invalid_name_policy = InvalidNamePolicy::Sanitize;
    let mut file = MatBuilder::new(options);
    filled(&mut file, run).map_err(io::Error::other)?;
    file.finish_to(to).map_err(io::Error::other)
}

fn filled(file: &mut MatBuilder, run: &Stored) -> Result<(), MatError> {
    let has_words =
        |table: &&Table| table.series.iter().any(|series| matches!(series.cells, Cells::Words(_)));
    for table in &run.tables {
        file.struct_(&variable(&table.name), |into| each(table, into, &numbers))?;
    }
    file.struct_("unit", |into| {
        let unit = |one: &Series, into: &mut StructWriter| text(into, &one.name, &one.unit);
        run.tables.iter().try_for_each(|table| within(table, into, &unit))
    })?;
    if run.tables.iter().any(|table| has_words(&table)) {
        file.struct_("words", |into| {
            run.tables.iter().filter(has_words).try_for_each(|table| within(table, into, &words_of))
        })?;
    }
    file.struct_("about", |into| {
        run.facts.iter().chain(&run.files).try_for_each(|(name, about)| text(into, name, about))
    })?;
    Ok(())
}

/// What is written of a column.
type Part<'a> = &'a dyn Fn(&Series, &mut StructWriter) -> Result<(), MatError>;

fn each(table: &Table, into: &mut StructWriter, part: Part) -> Result<(), MatError> {
    table.series.iter().try_for_each(|series| part(series, into))
}

fn within(table: &Table, into: &mut StructWriter, part: Part) -> Result<(), MatError> {
    into.struct_(&variable(&table.name), |into| each(table, into, part)).map(drop)
}

fn text(into: &mut StructWriter, name: &str, text: &str) -> Result<(), MatError> {
    into.write_char(&variable(name), text).map(drop)
}

/// A matrix with a row for each row of the table.
fn numbers(series: &Series, into: &mut StructWriter) -> Result<(), MatError> {
    let (width, values) = columns(series);
    into.write_f64(&variable(&series.name), &[values.len() / width, width], &values).map(drop)
}

/// How many columns a series has, and its numbers column by column, as MATLAB stores them; places among its words
/// instead, from one.
pub(super) fn columns(series: &Series) -> (usize, Vec<f64>) {
    match &series.cells {
        Cells::Numbers { width, values } => {
            let column = |k: usize| values.iter().skip(k).step_by(*width);
            (*width, (0..*width).flat_map(column).copied().collect())
        }
        Cells::Words(all) => {
            let distinct = distinct(all);
            let place: HashMap<&str, usize> = distinct.into_iter().zip(1..).collect();
            (1, all.iter().map(|word| place[word.as_str()] as f64).collect())
        }
    }
}

fn words_of(series: &Series, into: &mut StructWriter) -> Result<(), MatError> {
    words(series).map_or(Ok(()), |words| text(into, &series.name, &words))
}

/// The words of a series, one a line; none of numbers.
pub(super) fn words(series: &Series) -> Option<String> {
    match &series.cells {
        Cells::Words(all) => {
            let lines: Vec<String> =
                distinct(all).iter().map(|word| word.replace(['\n', '\r'], " ")).collect();
            Some(lines.join("\n"))
        }
        Cells::Numbers { .. } => None,
    }
}

/// Words in the order in which they come first.
fn distinct(all: &[String]) -> Vec<&str> {
    let mut known = HashSet::new();
    all.iter().map(String::as_str).filter(|word| known.insert(*word)).collect()
}

/// A name as short as MATLAB wants it; what else it does not admit the writer replaces.
fn variable(name: &str) -> String {
    name.chars().take(MOST_LETTERS - 1).collect() // it may put a letter in front
}
