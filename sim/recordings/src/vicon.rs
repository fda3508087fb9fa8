//! Vicon's text exports: section `Trajectories` of Nexus, `TRAJECTORIES` of older programs.
//!
//! ```text
//! Trajectories                     TRAJECTORIES
//! 100                              100,Hz
//! ,,Arm:tip,,,Arm:elbow,,          ,tip,,,elbow,,
//! Frame,Sub Frame,X,Y,Z,X,Y,Z      Field #,X,Y,Z,X,Y,Z
//! ,,mm,mm,mm,mm,mm,mm              1,174.57,324.51,1728.94,…
//! 1,0,44.16,-276.86,675.69,…
//! ```
//! Other sections may come before and after. Rows are ragged: that of the names may be longer or
//! shorter than that of the axes, which says how many markers there are.

use super::cells::{Rows, in_header};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::{Format, NEXUS_SECTIONS};
use super::layout::{Columns, Layout, one_unit};
use super::length::{Length, UnknownUnit};
use super::names::{distinct, some};

const CONVENTION: &str = "Vicon writes millimetres";

/// Reads an export of Nexus.
pub(super) fn nexus(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    let mut before = Vec::new();
    while rows.read_filled()? {
        let title = rows.cell(0);
        if title == "Trajectories" {
            let mut layout = section(rows, Format::ViconNexus)?;
            if !before.is_empty() {
                layout
                    .findings
                    .push(format!("sections before the trajectories were passed over: {}", some(&before)));
            }
            return layout.read(rows);
        }
        if NEXUS_SECTIONS.contains(&title) {
            before.push(title.to_owned());
        }
    }
    Err(RecordingProblem::NoTrajectories { sections: some(&before) })
}

/// Reads an export of an older program.
pub(super) fn legacy(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    while rows.read_filled()? {
        if rows.cell(0) == "TRAJECTORIES" {
            return section(rows, Format::ViconLegacy)?.read(rows);
        }
    }
    Err(RecordingProblem::Empty)
}

/// The header of a section of trajectories, whose title has been read.
fn section(rows: &mut Rows, format: Format) -> Result<Layout, RecordingProblem> {
    let is_nexus = format == Format::ViconNexus;
    let expected = |rows: &Rows, expected: &str| RecordingProblem::Header {
        line: rows.line(),
        expected: expected.to_owned(),
        met: format!("`{}`", rows.start()),
    };
    if !rows.read()? {
        return Err(RecordingProblem::HeaderOnly { line: rows.line() });
    }
    let rate = in_header(rows.cell(0));
    let rate = rate.ok_or_else(|| expected(rows, "the sampling rate, such as 100"))?;
    if !rows.read()? {
        return Err(RecordingProblem::HeaderOnly { line: rows.line() });
    }
    let names = rows.keep();
    if !rows.read_filled()? {
        return Err(RecordingProblem::HeaderOnly { line: rows.line() });
    }
    let first = if is_nexus { "Frame" } else { "Field #" };
    if !rows.cell(0).eq_ignore_ascii_case(first) {
        return Err(expected(rows, &format!("a row `{first},…X,Y,Z,X,Y,Z`")));
    }
    let axes = rows.keep();
    let axes_line = rows.line();

    let is_point = |at: &usize| {
        ["X", "Y", "Z"].iter().enumerate().all(|(k, axis)| axes.get(at + k).is_some_and(|cell| cell == axis))
    };
    let starts: Vec<usize> = (1..axes.len()).filter(is_point).collect();
    if starts.is_empty() {
        return Err(RecordingProblem::Header {
            line: axes_line,
            expected: "columns X,Y,Z".to_owned(),
            met: format!("`{}`", rows.start()),
        });
    }
    let mut findings = Vec::new();
    let unit = match is_nexus && rows.read()? {
        false => Unit::Assumed(Length::Millimetre, CONVENTION),
        true if rows.is_numeric() => {
            rows.hold();
            Unit::Assumed(Length::Millimetre, CONVENTION)
        }
        true => units(rows, &starts, &names)?,
    };
    let named = |at: &usize| names.get(*at).filter(|name| !name.is_empty()).cloned();
    let unnamed = starts.iter().filter(|at| named(at).is_none()).count();
    if unnamed > 0 {
        findings.push(format!(
            "{unnamed} markers have no name; they are called by their column, such as `column 3`"
        ));
    }
    let surplus: Vec<String> = names
        .iter()
        .enumerate()
        .filter(|(at, name)| !name.is_empty() && starts.binary_search(at).is_err())
        .map(|(_, name)| name.clone())
        .collect();
    if !surplus.is_empty() {
        findings.push(format!("names without columns X,Y,Z below them were passed over: {}", some(&surplus)));
    }
    let all = distinct(
        starts.iter().map(|at| named(at).unwrap_or_else(|| format!("column {}", at + 1))),
        &mut findings,
    );
    let points = all.into_iter().zip(starts).map(Columns::from_x).collect();
    Ok(Layout {
        format,
        unit,
        rate: Some(rate),
        frame: Some(0),
        time: None,
        points,
        // Nexus leaves the cells blank.
        zero_is_lost: !is_nexus,
        sections: true,
        samples: None,
        findings,
    })
}

/// The one unit of all positions, from the row of units.
fn units(rows: &Rows, starts: &[usize], names: &[String]) -> Result<Unit, RecordingProblem> {
    let mut stated = Vec::new();
    for start in starts {
        for column in *start..start + 3 {
            let cell = rows.cell(column);
            if cell.is_empty() {
                continue;
            }
            let name = names.get(*start).map_or("", String::as_str);
            let unknown = || UnknownUnit {
                place: format!("line {}, column {} ({name})", rows.line(), column + 1),
                value: super::cells::short(cell),
            };
            stated.push((name, Length::named(cell).ok_or_else(unknown)?));
        }
    }
    let unit = one_unit(stated, &format!("line {}", rows.line()))?;
    Ok(unit.unwrap_or(Unit::Assumed(Length::Millimetre, CONVENTION)))
}
