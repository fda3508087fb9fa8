//! Text of Qualisys Track Manager: lines of a key and its values, then perhaps a line of column
//! names, then one line a sample. The unit is never stated.

use std::collections::HashMap;

use super::cells::{Rows, in_header};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::layout::{Columns, Layout};
use super::length::Length;
use super::names::{distinct, groups, some};

/// Reads an export of 3D data.
pub(super) fn read(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    let mut keys = HashMap::<String, Vec<String>>::new();
    let mut columns = None;
    let mut line = 1;
    loop {
        if !rows.read_filled()? {
            return Err(RecordingProblem::HeaderOnly { line });
        }
        line = rows.line();
        if rows.is_numeric() {
            rows.hold();
            break;
        }
        if matches!(rows.cell(0), "Frame" | "Time") || rows.cell(0).ends_with(" X") {
            columns = Some(rows.keep());
            break;
        }
        let mut cells = rows.keep();
        let values = cells.split_off(1.min(cells.len()));
        keys.insert(cells.concat(), values);
    }
    let number = |key: &str| in_header(keys.get(key)?.first()?);
    let usual = if keys.contains_key("BODY_NAMES") { "6D" } else { "3D" };
    let included = keys.get("DATA_INCLUDED").and_then(|values| values.first()).map_or(usual, String::as_str);
    if included != "3D" || usual != "3D" {
        let what = format!("{included} data of Qualisys");
        return Err(RecordingProblem::NotRead { what, remedy: "export 3D data of markers as TSV, or C3D" });
    }
    let Some(names) = keys.get("MARKER_NAMES") else {
        let expected = "a line MARKER_NAMES above the samples".to_owned();
        return Err(RecordingProblem::Header { line, expected, met: "none".to_owned() });
    };
    let mut names: Vec<String> = names.clone();
    while names.last().is_some_and(String::is_empty) {
        names.pop();
    }
    if names.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: "an empty line MARKER_NAMES".to_owned() });
    }

    let mut findings = Vec::new();
    let (frame, time, groups, width) = match columns {
        Some(columns) => by_names(&columns, names.len(), line, &mut findings)?,
        None => by_count(rows.filled(), names.len(), line)?,
    };
    if let Some(stated) = number("NO_OF_MARKERS").filter(|stated| *stated != names.len() as f64) {
        findings.push(format!("the header states {stated} markers and names {}", names.len()));
    }
    let names = distinct(names, &mut findings);
    let points = names.into_iter().zip(groups).map(Columns::at).collect();
    let unit = Unit::Assumed(Length::Millimetre, "Qualisys Track Manager writes millimetres");
    Layout {
        width: Some(width),
        rate: number("FREQUENCY"),
        frame,
        time: time.map(|time| (time, 1.0)),
        zero_is_lost: true,
        samples: number("NO_OF_FRAMES"),
        ..Layout::new(Format::Qualisys, unit, points, findings)
    }
    .read(rows)
}

/// Columns of frame and time, of each marker, and how many there are in all.
type Places = (Option<usize>, Option<usize>, Vec<[usize; 3]>, usize);

/// Places by the names of the columns.
fn by_names(
    columns: &[String],
    markers: usize,
    line: u64,
    findings: &mut Vec<String>,
) -> Result<Places, RecordingProblem> {
    let at = |name: &str| columns.iter().position(|column| column == name);
    let (frame, time) = (at("Frame"), at("Time"));
    // Each name ends with its axis: other columns, such as residuals, have others.
    let axes: Vec<String> =
        columns.iter().map(|name| name.rsplit(' ').next().unwrap_or_default().to_owned()).collect();
    let groups = groups(&axes);
    if groups.len() != markers {
        let expected = format!("columns X, Y and Z of each of {markers} markers");
        return Err(RecordingProblem::Header {
            line,
            expected,
            met: format!("{} such groups", groups.len()),
        });
    }
    let is_read = |at: &usize| groups.iter().flatten().chain(&frame).chain(&time).any(|own| own == at);
    let others = (0..columns.len()).filter(|at| !is_read(at) && !columns[*at].is_empty());
    let others: Vec<String> = others.map(|at| columns[at].clone()).collect();
    if !others.is_empty() {
        findings.push(format!(
            "{} columns hold neither time nor position and were passed over: {}",
            others.len(),
            some(&others)
        ));
    }
    Ok((frame, time, groups, columns.len()))
}

/// Places in a file without names of columns: positions behind frame and time, if these are there.
fn by_count(width: usize, markers: usize, line: u64) -> Result<Places, RecordingProblem> {
    let first = match width as i64 - 3 * markers as i64 {
        first @ 0..=2 => first as usize,
        _ => {
            let expected = format!("3 numbers for each of {markers} markers");
            return Err(RecordingProblem::Header { line, expected, met: format!("{width} cells") });
        }
    };
    let groups = (0..markers).map(|k| [0, 1, 2].map(|axis| first + 3 * k + axis)).collect();
    Ok(((first > 0).then_some(0), (first > 1).then_some(1), groups, width))
}
