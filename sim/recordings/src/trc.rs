//! TRC, as OpenSim and Cortex use it: three lines of keys and values, a line of names over a line of
//! axes, then one line a sample, between tabs or commas.

use super::cells::{Rows, in_header};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::layout::{Columns, Layout};
use super::names::{above, groups};

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
    let filled = |row: Vec<String>| row.into_iter().filter(|cell| !cell.is_empty()).collect::<Vec<_>>();
    // Counted, not by place: tabs between them may be doubled.
    let keys = filled(next(rows)?);
    let values = next(rows)?;
    let values_line = rows.line();
    let counted = filled(values.clone());
    let values = if counted.len() == keys.len() { counted } else { values };
    let value = |key: &str| {
        let at = keys.iter().position(|cell| cell.eq_ignore_ascii_case(key))?;
        values.get(at).map(String::as_str)
    };
    let number = |key: &str| value(key).and_then(in_header);
    let silent = Unit::Silent("Units in the header".to_owned());
    let unit = Unit::stated(value("Units"), &format!("Units in line {values_line}"), silent);
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
    let names_line = rows.line();
    let mut axes = next(rows)?;
    if rows.is_numeric() {
        rows.hold();
        let columns = names.len().max(rows.filled());
        axes = (0..columns)
            .map(|at| if at < 2 { "" } else { ["X", "Y", "Z"][(at - 2) % 3] }.to_owned())
            .collect();
    } else if !axes.first().is_some_and(String::is_empty) {
        // Without the two blank cells over frame and time.
        axes.splice(..0, [String::new(), String::new()]);
    }
    let groups = groups(&axes);
    if groups.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: format!("`{}`", rows.start()) });
    }
    let mut findings = Vec::new();
    let of_markers: Vec<String> =
        [String::new(), String::new()].into_iter().chain(names.into_iter().skip(2)).collect();
    let all = above(&of_markers, &groups, names_line, &mut findings)?;
    if let Some(stated) = number("NumMarkers").filter(|stated| *stated != groups.len() as f64) {
        findings.push(format!("the header states {stated} markers, the file has {}", groups.len()));
    }
    let points = all.into_iter().zip(groups).map(Columns::at).collect();
    Layout {
        width: Some(axes.len().max(of_markers.len())),
        rate: number("DataRate"),
        frame: Some(0),
        time: Some((1, 1.0)),
        zero_is_lost: true,
        samples: number("NumFrames"),
        ..Layout::new(Format::Trc, unit, points, findings)
    }
    .read(rows)
}
