//! Tables with a row for each marker, as programs write them that follow tags, bodies or tracks:
//!
//! ```text
//! t_s,marker,x_mm,y_mm,z_mm
//! 0.00,base,0.0,0.1,0.0
//! 0.00,tip,399.8,0.2,-0.1
//! 0.01,base,0.1,0.1,0.0
//! ```

use std::collections::BTreeMap;

use super::cells::{Numbers, Rows};
use super::column::{Column, column, words};
use super::kinovea::{MOST, Trajectory};
use super::layout::second_of;
use super::tidy;

/// Words in the name of a column that says whose place it is.
const WHOSE: [&str; 11] =
    ["marker", "id", "name", "label", "body", "object", "track", "point", "particle", "tag", "tid"];

/// The rows of each marker as a table of its own, each row in its line; none of a table in which times ascend, or without a
/// column of markers in which the times of each do.
pub(super) fn trajectories(text: &str) -> impl Iterator<Item = Trajectory> {
    let (first, names, whose) = whose(text).unwrap_or_default();
    names.into_iter().enumerate().map(move |(k, name)| {
        let is_own = |at: usize| at + 1 < first || whose.get(at) == Some(&Some(k as u8));
        let own = text.lines().enumerate().map(|(at, line)| if is_own(at) { line } else { "" });
        Trajectory { text: own.flat_map(|line| [line, "\n"]).collect(), name: Some(name) }
    })
}

/// A column that may say whose places are in its rows.
#[derive(Default)]
struct Whose {
    column: usize,
    /// The last time of each marker, and its number.
    markers: BTreeMap<String, (f64, u8)>,
    /// The number of the marker in each line that has one.
    lines: Vec<Option<u8>>,
}

impl Whose {
    /// Takes a row; false where the times of its marker do not ascend, or there are too many.
    fn take(&mut self, cell: &str, time: f64, line: usize) -> bool {
        let next = (f64::NEG_INFINITY, self.markers.len() as u8);
        let (last, number) = self.markers.entry(cell.to_owned()).or_insert(next);
        let ascends = time > *last;
        *last = time;
        self.lines.resize(line, None);
        self.lines[line - 1] = Some(*number);
        ascends && self.markers.len() <= MOST
    }
}

/// The line of the first row, from 1, the markers in the order of the file, and the number of the marker in each line.
fn whose(text: &str) -> Option<(usize, Vec<String>, Vec<Option<u8>>)> {
    let rows = &mut Rows::new(text);
    let (names, _) = tidy::names(rows).ok()?;
    let is = |of: fn(&Column) -> bool| names.iter().position(|name| of(&column(name)));
    let clock = is(|own| matches!(own, Column::Time(_, true)))
        .or_else(|| is(|own| matches!(own, Column::Frame)))
        .or_else(|| is(|own| matches!(own, Column::Time(..))))?;
    let is_whose = |name: &String| {
        let is_place = matches!(column(name), Column::Position { .. } | Column::Orientation { .. });
        !is_place && words(name).iter().any(|word| WHOSE.contains(&word.as_str()))
    };
    let columns = (0..names.len()).filter(|at| *at != clock && is_whose(&names[*at]));
    let mut all: Vec<Whose> = columns.map(|column| Whose { column, ..Whose::default() }).collect();
    let (mut first, mut last, mut ascends) = (0, f64::NEG_INFINITY, true);
    while !all.is_empty() && rows.read_filled().ok()? {
        let line = rows.line() as usize;
        first = if first == 0 { line } else { first };
        let time = second_of(rows.cell(clock), 1.0, &mut Numbers::default(), 0)?;
        ascends &= time > last;
        last = time;
        all.retain_mut(|own| own.take(rows.cell(own.column), time, line));
    }
    let own = all.into_iter().find(|own| own.markers.len() > 1 && !ascends)?;
    let named = |name: String| {
        let is_number = name.starts_with(|c: char| c.is_ascii_digit());
        if is_number { format!("{} {name}", names[own.column]) } else { name }
    };
    let mut markers: Vec<(u8, String)> =
        own.markers.into_iter().map(|(name, (_, number))| (number, named(name))).collect();
    markers.sort();
    Some((first, markers.into_iter().map(|(_, name)| name).collect(), own.lines))
}
