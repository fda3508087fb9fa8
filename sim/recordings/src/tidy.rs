//! Tidy tables: one line of names, `t_s,tip_x_m,tip_y_m,tip_z_m,…`, then one line a sample.
//!
//! A position is `<marker>_<axis>_<unit>`, or `<marker>_<axis> (<unit>)`; an orientation is
//! `<body>_qw` to `<body>_qz`; time is `t_s`, `time_s`, `t_ms`, …. The columns `x_07_m`, `z_07_m` of a
//! run's own trajectory are the marker `node_07`. Other columns are passed over.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use super::Recording;
use super::cells::Rows;
use super::column::{AXES, Column, column};
use super::draft::{Draft, ReadOptions, Unit};
use super::error::{RecordingError, RecordingProblem};
use super::format::Format;
use super::layout::{Columns, Layout, one_unit};
use super::names::some;

/// Reads a table from its first line.
pub(super) fn read(rows: &mut Rows) -> Result<Draft, RecordingProblem> {
    while rows.read_filled()? {
        if !rows.cell(0).starts_with('#') {
            let names = rows.keep();
            return layout(&names, Format::Tidy)?.read(rows);
        }
    }
    Err(RecordingProblem::Empty)
}

/// Columns that a program has in memory, all of one length, by the names that such a table has: numbers, or the type of
/// something else. What is not finite is lost.
/// # Errors
/// As for a file: names without a marker or a unit, times that do not ascend.
/// # Panics
/// If there is not a column for each name, or one has another length.
pub fn table(
    names: &[String],
    columns: &[Result<Vec<f64>, String>],
    source: &Path,
    options: &ReadOptions,
) -> Result<Recording, RecordingError> {
    assert_eq!(names.len(), columns.len(), "a column for each name");
    let mut lengths = columns.iter().flatten().map(Vec::len);
    let first = lengths.next().unwrap_or_default();
    assert!(lengths.all(|length| length == first), "columns of one length");
    let read = || {
        let layout = layout(names, Format::Made)?;
        let mut draft = Draft::new(Format::Made, layout.unit.clone(), "row");
        draft.findings = layout.findings.clone();
        draft.markers = layout.points.iter().map(Columns::marker).collect();
        let wanted: BTreeSet<usize> = layout.columns().collect();
        let finite = |value: &f64| Some(*value).filter(|value| value.is_finite());
        let numbers = |(k, column): (usize, &Result<Vec<f64>, String>)| match column {
            Ok(numbers) => Ok(numbers.iter().map(finite).collect()),
            Err(kind) if wanted.contains(&k) => {
                Err(RecordingProblem::ColumnType { column: names[k].clone(), kind: kind.clone() })
            }
            Err(_) => Ok(vec![None; first]),
        };
        let columns = columns.iter().enumerate().map(numbers).collect::<Result<Vec<Vec<_>>, _>>()?;
        layout.rows(&|column| names[column].clone(), &columns, &mut draft)?;
        draft.finish(source, options)
    };
    read().map_err(|problem| RecordingError { file: source.to_owned(), problem })
}

/// Where things stand, by the names of the columns; those without a name have none.
pub(super) fn layout(names: &[String], format: Format) -> Result<Layout, RecordingProblem> {
    let columns: Vec<Column> = names.iter().map(|name| column(name)).collect();
    let with_unit = columns.iter().zip(names).filter_map(|(column, name)| match column {
        Column::Position { unit: Some(unit), .. } => Some((name.as_str(), *unit)),
        _ => None,
    });
    let unit = one_unit(with_unit, "the line of names")?;
    let is_stated = unit.is_some();

    let (mut points, mut index) = (Vec::<Columns>::new(), HashMap::new());
    let (mut time, mut frame, mut passed_over, mut bodies) = (None, None, Vec::new(), Vec::new());
    let (mut silent, mut findings) = (None, Vec::new());
    for (at, (column, name)) in columns.into_iter().zip(names).enumerate() {
        match column {
            Column::Time(second, is_stated) if time.is_none() => {
                time = Some((at, second));
                if !is_stated {
                    findings.push(format!("time: s is assumed, for column `{name}` states no unit"));
                }
            }
            Column::Frame if frame.is_none() => frame = Some(at),
            Column::Position { marker, axis, unit } if unit.is_some() == is_stated => {
                silent.get_or_insert_with(|| format!("column `{name}`"));
                let point = *index.entry(marker.clone()).or_insert_with(|| {
                    points.push(Columns { name: marker, position: [None; 3], orientation: None });
                    points.len() - 1
                });
                if let Some(first) = points[point].position[axis].replace(at) {
                    let what = format!("{} of marker `{}`", AXES[axis], points[point].name);
                    return Err(RecordingProblem::Twice { first: first + 1, second: at + 1, what });
                }
            }
            Column::Orientation { body, part } => bodies.push((body, part, at)),
            _ if name.is_empty() => {}
            _ => passed_over.push(name.clone()),
        }
    }
    orient(&mut points, &index, &bodies, names, &mut passed_over);
    if points.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: some(names) });
    }
    flat(&points, &mut findings)?;
    if !passed_over.is_empty() {
        findings.push(format!(
            "{} columns hold neither time nor position and were passed over: {}",
            passed_over.len(),
            some(&passed_over)
        ));
    }
    let unit = unit.or(silent.map(Unit::Silent)).expect("there are points, with a unit or silent");
    let (rate, samples) = (None, None);
    Ok(Layout {
        format,
        unit,
        rate,
        frame,
        time,
        points,
        zero_is_lost: false,
        sections: false,
        samples,
        findings,
    })
}

/// Gives bodies their orientations; those without all four parts, or without a position, are passed over.
fn orient(
    points: &mut [Columns],
    index: &HashMap<String, usize>,
    bodies: &[(String, usize, usize)],
    names: &[String],
    passed_over: &mut Vec<String>,
) {
    let mut parts = HashMap::<&str, [Option<usize>; 4]>::new();
    for (body, part, at) in bodies {
        parts.entry(body).or_default()[*part] = Some(*at);
    }
    for (body, _, at) in bodies {
        match (parts[body.as_str()], index.get(body)) {
            ([Some(w), Some(x), Some(y), Some(z)], Some(point)) => {
                points[*point].orientation = Some([w, x, y, z]);
            }
            _ => passed_over.push(names[*at].clone()),
        }
    }
}

/// Checks that x and z are there, and says where y is not.
fn flat(points: &[Columns], findings: &mut Vec<String>) -> Result<(), RecordingProblem> {
    for Columns { name, position, .. } in points {
        let marker = name.clone();
        match position {
            [Some(_), _, Some(_)] => {}
            [Some(_), Some(_), None] => {
                let remedy = "in a plane, z is the height: call it so";
                return Err(RecordingProblem::MissingAxis { marker, axis: "z", remedy });
            }
            _ => {
                let axis = if position[0].is_none() { "x" } else { "z" };
                return Err(RecordingProblem::MissingAxis { marker, axis, remedy: "add the column" });
            }
        }
    }
    let in_plane = points.iter().filter(|point| point.position[1].is_none());
    let in_plane: Vec<String> = in_plane.map(|point| point.name.clone()).collect();
    if !in_plane.is_empty() {
        findings.push(format!("no y is given for {}; it is 0 here", some(&in_plane)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::length::Length;

    #[test]
    fn columns_in_memory_are_read_as_a_file_is() {
        let names = ["t_ms", "tip_x_mm", "tip_z_mm", "note"].map(str::to_owned);
        let columns =
            [vec![0.0, 10.0, 20.0], vec![1.0, 2.0, f64::NAN], vec![4.0, 5.0, 6.0], vec![0.0; 3]].map(Ok);
        let read = |options: &ReadOptions| table(&names, &columns, Path::new("made"), options);
        let made = read(&ReadOptions::default()).unwrap();
        assert_eq!(made.time, [0.0, 0.01, 0.02]);
        assert_eq!(made.markers[0].position, [Some([0.001, 0.0, 0.004]), Some([0.002, 0.0, 0.005]), None]);
        assert!(made.findings.iter().any(|finding| finding.contains("passed over: `note`")), "{made:?}");
        let rows = "t_ms,tip_x_mm,tip_z_mm,note\n0,1,4,0\n10,2,5,0\n20,,6,0\n";
        let file = super::super::parse(rows.into(), Path::new("a.csv"), &ReadOptions::default()).unwrap();
        assert_eq!((file.time, file.rate_hz), (made.time, made.rate_hz));
        assert_eq!(file.markers[0].position, made.markers[0].position);
        let metres = ReadOptions { unit: Some(Length::Metre), rate_hz: None };
        assert_eq!(read(&metres).unwrap().markers[0].position[0], Some([1.0, 0.0, 4.0]));
    }
}
