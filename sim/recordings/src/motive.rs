//! OptiTrack Motive's CSV.
//!
//! ```text
//! Format Version,1.23,…,Export Frame Rate,120,…,Rotation Type,Quaternion,Length Units,Meters,…
//!
//! ,Type,Rigid Body,…        what each column belongs to: row by row its type, name, number,
//! ,Name,Base,…              then Rotation or Position
//! ,ID,1,…
//! ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,…
//! Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,…
//! 0,0.000000,…
//! ```
//! A lost body leaves its cells blank. Version 1.21 leaves the second column, `Type` to `ID`, blank. Source: OptiTrack, Motive documentation, Data Export: CSV.

use std::collections::HashMap;

use super::cells::{Rows, in_header};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::layout::{Columns, Layout};
use super::length::Length;
use super::names::distinct;

/// Rows of the header at most, so that a long file without one is soon refused.
const MOST_ROWS: usize = 12;

/// Reads an export.
pub(super) fn read(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    rows.read_filled()?;
    let pairs = rows.keep();
    let value = |key: &str| {
        let at = pairs.iter().step_by(2).position(|cell| cell == key)?;
        pairs.get(2 * at + 1).map(String::as_str)
    };
    let number = |key: &str| value(key).and_then(in_header);
    let silent = Unit::Assumed(Length::Metre, "Motive writes metres");
    let unit = Unit::stated(value("Length Units"), "Length Units in line 1", silent);

    let mut above: Vec<Vec<String>> = Vec::new();
    loop {
        if !rows.read_filled()? || above.len() > MOST_ROWS {
            let (line, expected) = (rows.line(), "a row `Frame,Time (Seconds),X,Y,Z,…`".to_owned());
            return Err(RecordingProblem::Header { line, expected, met: "none".to_owned() });
        }
        if rows.cell(0) == "Frame" {
            break;
        }
        above.push(rows.keep());
    }
    // Version 1.21 has the same rows without their labels.
    let is_labelled = above.iter().any(|row| row.iter().take(2).any(|cell| !cell.is_empty()));
    let row = |label: &str| match ["Type", "Name", "ID"].iter().position(|own| *own == label) {
        Some(at) if !is_labelled => above.get(at).filter(|_| above.len() == 4),
        _ => above.iter().find(|row| row.iter().take(2).any(|cell| cell == label)),
    };
    let cell = |label: &str, at: usize| row(label).and_then(|row| row.get(at)).map_or("", String::as_str);
    let kinds = above.last().filter(|row| row.iter().any(|cell| cell == "Position"));
    let Some(kinds) = kinds.filter(|_| row("Name").is_some()) else {
        let (line, expected) = (rows.line(), "rows of names and of Rotation or Position above it".to_owned());
        return Err(RecordingProblem::Header { line, expected, met: "others".to_owned() });
    };

    let (mut bodies, mut index) = (Vec::<Body>::new(), HashMap::new());
    for at in 2..rows.width() {
        let kind = kinds.get(at).map_or("", String::as_str);
        let axis = ["X", "Y", "Z", "W"].iter().position(|axis| rows.cell(at) == *axis);
        let (Some(axis), "Position" | "Rotation") = (axis, kind) else { continue };
        let key = (cell("Type", at), cell("Name", at), cell("ID", at));
        let body = *index.entry(key).or_insert_with(|| {
            bodies.push(Body { kind: key.0, name: key.1, position: [None; 4], rotation: [None; 4] });
            bodies.len() - 1
        });
        let place = if kind == "Position" { &mut bodies[body].position } else { &mut bodies[body].rotation };
        if let Some(first) = place[axis].replace(at) {
            let what = format!("{} {} of `{}`", kind.to_lowercase(), rows.cell(at), key.1);
            return Err(RecordingProblem::Twice { first: first + 1, second: at + 1, what });
        }
    }
    let mut findings =
        vec!["axes: Motive's own have y upwards, unless others were chosen in the export".to_owned()];
    let points = points(&bodies, &mut findings)?;
    if points.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: format!("`{}`", rows.start()) });
    }
    let time = rows.cell(1).to_lowercase().starts_with("time").then_some((1, 1.0));
    Layout {
        width: Some(rows.width()),
        rate: number("Export Frame Rate").or_else(|| number("Capture Frame Rate")),
        frame: Some(0),
        time,
        samples: number("Total Exported Frames"),
        ..Layout::new(Format::Motive, unit, points, findings)
    }
    .read(rows)
}

/// A marker or rigid body, and its columns: X, Y, Z, W.
struct Body<'a> {
    kind: &'a str,
    name: &'a str,
    position: [Option<usize>; 4],
    rotation: [Option<usize>; 4],
}

fn points(bodies: &[Body], findings: &mut Vec<String>) -> Result<Vec<Columns>, RecordingProblem> {
    let names = distinct(bodies.iter().map(|body| body.name.to_owned()), findings);
    let (mut points, mut euler) = (Vec::new(), 0);
    for (body, name) in bodies.iter().zip(names) {
        let [x, y, z, _] = body.position;
        if let Some(axis) = [x, y, z].iter().position(Option::is_none) {
            let axis = ["x", "y", "z"][axis];
            return Err(RecordingProblem::MissingAxis { marker: name, axis, remedy: "export it again" });
        }
        let orientation = match body.rotation {
            [Some(x), Some(y), Some(z), Some(w)] => Some([w, x, y, z]),
            [None, None, None, None] => None,
            _ => {
                euler += 1;
                None
            }
        };
        points.push(Columns { name, position: [x, y, z], orientation, likelihood: None });
    }
    if euler > 0 {
        findings.push(format!(
            "{euler} orientations are angles and were passed over; export with Rotation Type Quaternion to have them"
        ));
    }
    let expected =
        bodies.iter().filter(|body| matches!(body.kind, "Rigid Body Marker" | "Bone Marker")).count();
    if expected > 0 {
        findings.push(format!(
            "{expected} markers are of a rigid body: where Motive expects them, which may not be where they were seen"
        ));
    }
    Ok(points)
}
