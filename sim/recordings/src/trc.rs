//! TRC, as OpenSim and Cortex use it: three lines of keys and values, a line of names over a line of
//! axes, then one line a sample, between tabs or commas.

use super::cells::{Rows, in_header};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::layout::{Columns, Layout};
use super::names::distinct;

/// Reads a file.
pub(super) fn read(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    let next = |rows: &mut Rows| {
        if rows.read_filled()? {
            Ok(rows.keep())
        } else {
            Err(RecordingProblem::HeaderOnly { line: rows.line() })
        }
    };
    next(rows)?;
    let keys = next(rows)?;
    let values = next(rows)?;
    let values_line = rows.line();
    let value = |key: &str| {
        let at = keys.iter().position(|cell| cell.eq_ignore_ascii_case(key))?;
        values.get(at).map(String::as_str)
    };
    let number = |key: &str| value(key).and_then(in_header);
    let silent = Unit::Silent("Units in the header".to_owned());
    let unit = Unit::stated(value("Units"), &format!("Units in line {values_line}"), silent)?;
    let names = next(rows)?;
    let first = names.first().map_or("", String::as_str);
    if !first.to_lowercase().starts_with("frame") {
        let expected = "a row `Frame#`, `Time` and names".to_owned();
        return Err(RecordingProblem::Header {
            line: rows.line(),
            expected,
            met: format!("`{}`", rows.start()),
        });
    }
    let axes = next(rows)?;
    let is_named = |at: &usize| names.get(*at).is_some_and(|name| !name.is_empty());
    let has_axes = |at: &usize| axes.get(*at).is_some_and(|axis| axis.to_lowercase().starts_with('x'));
    let all = (2..names.len().max(axes.len())).step_by(3);
    let starts: Vec<usize> = if rows.is_numeric() {
        rows.hold();
        all.take_while(is_named).collect()
    } else {
        all.take_while(has_axes).collect()
    };
    if starts.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: format!("`{}`", rows.start()) });
    }
    let mut findings = Vec::new();
    if let Some(stated) = number("NumMarkers").filter(|stated| *stated != starts.len() as f64) {
        findings.push(format!("the header states {stated} markers, the file has {}", starts.len()));
    }
    let name = |at: &usize| if is_named(at) { names[*at].clone() } else { format!("column {}", at + 1) };
    let all = distinct(starts.iter().map(name), &mut findings);
    Layout {
        format: Format::Trc,
        unit,
        rate: number("DataRate"),
        frame: Some(0),
        time: Some((1, 1.0)),
        points: all.into_iter().zip(starts).map(Columns::from_x).collect(),
        zero_is_lost: true,
        sections: false,
        samples: number("NumFrames"),
        findings,
    }
    .read(rows)
}
