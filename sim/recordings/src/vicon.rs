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
use super::names::{above, groups, some};

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
    let rate = in_header(rows.cell(0)).ok_or_else(|| expected(rows, "the sampling rate, such as 100"));
    if !rows.read()? {
        return Err(RecordingProblem::HeaderOnly { line: rows.line() });
    }
    let names = rows.keep();
    let names_line = rows.line();
    if !rows.read_filled()? {
        return Err(RecordingProblem::HeaderOnly { line: rows.line() });
    }
    let first = if is_nexus { "Frame" } else { "Field #" };
    if !rows.cell(0).eq_ignore_ascii_case(first) {
        return Err(expected(rows, &format!("a row `{first},…X,Y,Z,X,Y,Z`")));
    }
    let axes = rows.keep();
    let axes_line = rows.line();

    let groups = groups(&axes);
    if groups.is_empty() {
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
        true => units(rows, &groups, &names),
    };
    let all = above(&names, &groups, names_line, &mut findings)?;
    let points = all.into_iter().zip(groups).map(Columns::at).collect();
    Ok(Layout {
        width: Some(axes.len().max(names.len())),
        rate: rate.as_ref().ok().copied(),
        wrong_clock: rate.err(),
        frame: Some(0),
        // Nexus leaves the cells blank.
        zero_is_lost: !is_nexus,
        sections: true,
        ..Layout::new(format, unit, points, findings)
    })
}

/// The one unit of all positions, from the row of units.
fn units(rows: &Rows, groups: &[[usize; 3]], names: &[String]) -> Unit {
    let mut stated = Vec::new();
    for group in groups {
        for column in group {
            let cell = rows.cell(*column);
            if cell.is_empty() {
                continue;
            }
            let name = names.get(group[0]).map_or("", String::as_str);
            match Length::named(cell) {
                Some(unit) => stated.push((name, unit)),
                None => {
                    return Unit::Wrong(UnknownUnit {
                        place: format!("line {}, column {} ({name})", rows.line(), column + 1),
                        value: super::cells::short(cell),
                    });
                }
            }
        }
    }
    one_unit(stated, &format!("line {}", rows.line()))
        .unwrap_or(Unit::Assumed(Length::Millimetre, CONVENTION))
}
