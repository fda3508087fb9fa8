//! Tables: one line of names, `t_s,tip_x_m,tip_y_m,tip_z_m,…`, then one line a sample.
//!
//! A position is `<marker>_<axis>_<unit>`, or `<marker>_<axis> (<unit>)`; an orientation is
//! `<body>_qw` to `<body>_qz`, or x, y and z beside w; time is `t_s`, `time_s`, `t_ms`, …. The columns `x_07_m`,
//! `z_07_m` of a run's own trajectory are the marker `node_07`. Other columns are passed over.
//!
//! Names may be above the axes, as Tracker, DeepLabCut and spreadsheets have them, and units below:
//!
//! ```text
//! cm_A               #multi:                scorer,DLC,DLC,DLC
//! t   x   y              tip     mid        bodyparts,tip,tip,tip
//! 0   1   2          t   x   y   x   y      coords,x,y,likelihood
//! ```
//! Source: Tracker 6 Help, on exporting data; DeepLabCut, Standard User Guide, on the analysis of videos.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use super::Recording;
use super::cells::{Rows, is_label};
use super::column::{AXES, Column, body, column, words};
use super::draft::{Draft, ReadOptions, Unit};
use super::error::{RecordingError, RecordingProblem};
use super::format::Format;
use super::layout::{Columns, Layout, one_unit};
use super::length::Length;
use super::names::some;

/// Lines above the samples at most.
const MOST_LINES: usize = 40;

/// Names of columns, from the lines above the samples.
struct Head {
    names: Vec<String>,
    line: u64,
    findings: Vec<String>,
}

/// Reads a table from its first line; `columns` are its names in place of those that it has.
pub(super) fn read(rows: &mut Rows, columns: Option<&[String]>) -> Result<Draft, RecordingProblem> {
    let (lines, notes) = above(rows)?;
    let head = match columns {
        Some(names) => Head { names: names.to_vec(), line: rows.line(), findings: Vec::new() },
        None => head(lines, notes, rows).ok_or(RecordingProblem::Empty)?,
    };
    let mut layout = layout(&head.names, Format::Tidy)?;
    layout.findings.splice(..0, head.findings);
    layout.width = Some(head.names.len());
    let read = layout.read_from(head.line, rows);
    read.map_err(|problem| match problem {
        RecordingProblem::Cells { line, cells, names, .. } if columns.is_some() => {
            RecordingProblem::Columns { line, cells, names }
        }
        other => other,
    })
}

/// Whether the lines up to the first sample name columns.
pub(super) fn is_table(rows: &mut Rows) -> Result<bool, RecordingProblem> {
    let (lines, notes) = above(rows)?;
    Ok(head(lines, notes, rows).is_some())
}

/// Names of columns, and their line; the rows then go on with the first sample.
pub(super) fn names(rows: &mut Rows) -> Result<(Vec<String>, u64), RecordingProblem> {
    let (lines, notes) = above(rows)?;
    head(lines, notes, rows).map(|head| (head.names, head.line)).ok_or(RecordingProblem::Empty)
}

type Line = (u64, Vec<String>);

/// The lines above the first sample, which is held: those of words, and those that a `#` begins.
fn above(rows: &mut Rows) -> Result<(Vec<Line>, Vec<Line>), RecordingProblem> {
    let (mut lines, mut notes) = (Vec::new(), Vec::new());
    while lines.len() + notes.len() < MOST_LINES && rows.read_filled()? {
        let mut cells = rows.keep();
        if let Some(note) = cells[0].strip_prefix('#') {
            cells[0] = note.trim().to_owned();
            // A blank after the sign is a cell of its own where blanks separate cells.
            if cells[0].is_empty() && cells.len() > 1 {
                cells.remove(0);
            }
            notes.push((rows.line(), cells));
        } else if !rows.is_data() {
            lines.push((rows.line(), cells));
        } else if is_label(rows.cell(0)) && !lines.iter().any(names_columns) {
            // A setting, such as `Samples,800`. What is above it names no columns.
            lines.clear();
        } else {
            rows.hold();
            break;
        }
    }
    Ok((lines, notes))
}

/// The names that lines above the samples give; nothing if none of them names a time or a position.
fn head(mut lines: Vec<Line>, notes: Vec<Line>, rows: &Rows) -> Option<Head> {
    let mut findings = Vec::new();
    let is_wide = |line: &&Line| line.1.len() >= rows.filled();
    let mut is_named = lines.iter().any(names_columns);
    if !is_named {
        // Programs that write numbers alone put the names behind a sign of comment.
        if let Some(note) = notes.into_iter().rev().find(|line| names_columns(line) && is_wide(&line)) {
            findings.push(format!("names of columns are taken from line {}, which begins with #", note.0));
            lines.push(note);
            is_named = true;
        } else if !rows.is_data() || lines.last().filter(is_wide).is_none() {
            return None;
        }
    }
    let units = lines.last().filter(|line| lines.len() > 1 && is_of_units(&line.1)).cloned();
    lines.truncate(lines.len() - usize::from(units.is_some()));
    // Names of other things are said when no marker is found in them.
    let (line, mut names) = lines.pop().filter(|line| !is_named || names_columns(line))?;
    // A table with an index names it in a line of its own, below the others.
    let is_apart = |above: &Line| {
        names_columns(above)
            && above.1.iter().zip(&names).all(|(above, own)| above.is_empty() || own.is_empty())
    };
    if let Some((_, above)) = lines.pop_if(|above| is_apart(above)) {
        for (own, above) in names.iter_mut().zip(above).filter(|(own, _)| own.is_empty()) {
            *own = above;
        }
    }
    name_by_groups(&mut names, lines, &mut findings);
    if let Some((_, units)) = units {
        for (name, unit) in names.iter_mut().zip(units) {
            let unit = unit.trim_matches(['(', ')', '[', ']']);
            if !name.is_empty() && !unit.is_empty() {
                *name = format!("{name} ({unit})");
            }
        }
    }
    Some(Head { names, line, findings })
}

/// Whether a line has the name of a time or of a position.
fn names_columns(line: &Line) -> bool {
    let is_known =
        |column| matches!(column, Column::Time(..) | Column::Position { .. } | Column::Perhaps { .. });
    line.1.iter().any(|name| is_known(column(name)))
}

/// Whether a line holds units below names.
fn is_of_units(cells: &[String]) -> bool {
    let is_length = |cell: &String| Length::named(cell.trim_matches(['(', ')', '[', ']'])).is_some();
    cells.iter().any(is_length) && !cells.iter().any(|cell| matches!(column(cell), Column::Position { .. }))
}

/// Puts the names of markers from lines above before axes that have none.
fn name_by_groups(names: &mut [String], lines: Vec<Line>, findings: &mut Vec<String>) {
    let is_bare = |name: &String| match column(name) {
        Column::Position { marker, .. } | Column::Likelihood { marker } => marker == "point",
        _ => false,
    };
    let places: Vec<usize> = (0..names.len()).filter(|at| is_bare(&names[*at])).collect();
    let mut groups = vec![String::new(); names.len()];
    let mut passed_over = 0;
    for (_, cells) in lines {
        let filled: Vec<usize> = (0..cells.len()).filter(|at| !cells[*at].is_empty()).collect();
        // A name may begin over the time before its axes.
        let place = |at: &usize| {
            let is_time = names.get(*at).is_some_and(|name| matches!(column(name), Column::Time(..)));
            let place = if is_time { at + 1 } else { *at };
            Some(place).filter(|place| places.contains(place) && (place == at || !filled.contains(place)))
        };
        let over = |at: usize| filled.iter().find(|own| place(own) == Some(at)).map(|own| &cells[*own]);
        let above: Vec<usize> = filled.iter().filter_map(place).collect();
        // A title that is alone names all; names over axes begin at one and go on to the next.
        let is_title = filled.len() == 1 && above.is_empty();
        let first = above.first().and_then(|at| over(*at));
        let says_one =
            above.len() == places.len() && above.iter().all(|at| over(*at) == first) && places.len() > 3;
        // Programs may give their columns two names.
        let is_axes = cells.iter().any(|cell| matches!(column(cell), Column::Position { .. }));
        if above.is_empty() && !is_title || says_one || is_axes {
            passed_over += 1;
            continue;
        }
        let mut group = if is_title { cells[filled[0]].clone() } else { String::new() };
        for at in &places {
            if let Some(cell) = over(*at).filter(|_| !is_title) {
                group.clone_from(cell);
            }
            if !group.is_empty() {
                groups[*at] =
                    if groups[*at].is_empty() { group.clone() } else { format!("{} {group}", groups[*at]) };
            }
        }
    }
    for at in places {
        if !groups[at].is_empty() {
            names[at] = format!("{}_{}", groups[at], names[at]);
        }
    }
    if passed_over > 0 {
        findings.push(format!("{passed_over} lines above the names were passed over"));
    }
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
        let mut draft = layout.draft("row");
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

/// The layout, by the names of the columns; those without a name have none.
pub(super) fn layout(names: &[String], format: Format) -> Result<Layout, RecordingProblem> {
    let mut columns: Vec<Column> = names.iter().map(|name| column(name)).collect();
    quaternions(&mut columns);
    decide(&mut columns);
    derived(names, &mut columns);
    let with_unit = columns.iter().zip(names).filter_map(|(column, name)| match column {
        Column::Position { unit: Some(unit), .. } => Some((name.as_str(), *unit)),
        _ => None,
    });
    let unit = one_unit(with_unit, "the line of names");
    let is_stated = unit.is_some();

    let (mut points, mut index) = (Vec::<Columns>::new(), HashMap::new());
    let (mut time, mut frame, mut passed_over, mut bodies) = (None, None, Vec::new(), Vec::new());
    let (mut silent, mut findings, mut likely, mut assumed_second) = (None, Vec::new(), Vec::new(), None);
    // Of several times the first that states its unit, or the first.
    let is_time =
        |is_sure: bool| move |own: &Column| matches!(own, Column::Time(_, sure) if *sure || !is_sure);
    let clock = columns.iter().position(is_time(true)).or_else(|| columns.iter().position(is_time(false)));
    for (at, (column, name)) in columns.into_iter().zip(names).enumerate() {
        match column {
            Column::Time(second, is_stated) if clock == Some(at) => {
                time = Some((at, second));
                if !is_stated {
                    assumed_second = Some(name.clone());
                }
            }
            Column::Frame if frame.is_none() => frame = Some(at),
            Column::Position { marker, axis, unit } if unit.is_some() == is_stated => {
                silent.get_or_insert_with(|| format!("column `{name}`"));
                let point = *index.entry(marker.clone()).or_insert_with(|| {
                    points.push(Columns {
                        name: marker,
                        position: [None; 3],
                        orientation: None,
                        likelihood: None,
                    });
                    points.len() - 1
                });
                if let Some(first) = points[point].position[axis].replace(at) {
                    let what = format!("{} of marker `{}`", AXES[axis], points[point].name);
                    return Err(RecordingProblem::Twice { first: first + 1, second: at + 1, what });
                }
            }
            Column::Orientation { body, part } => bodies.push((body, part, at)),
            Column::Likelihood { marker } => likely.push((marker, at)),
            _ if name.is_empty() || name == "-" => {}
            _ => passed_over.push(name.clone()),
        }
    }
    orient(&mut points, &bodies, names, &mut passed_over);
    let mut is_picture = false;
    for (marker, at) in likely {
        match index.get(&marker) {
            Some(point) => {
                points[*point].likelihood = Some(at);
                is_picture = true;
            }
            None => passed_over.push(names[at].clone()),
        }
    }
    if points.is_empty() {
        return Err(RecordingProblem::NoMarkers { met: some(names) });
    }
    let is_picture = flat(&mut points, is_picture, &mut findings)?;
    if !passed_over.is_empty() {
        findings.push(format!(
            "{} columns hold neither time nor position and were passed over: {}",
            passed_over.len(),
            some(&passed_over)
        ));
    }
    let pixels = || Unit::Stated(Length::Pixel, "places have a likelihood, as in a picture".to_owned());
    let unit = unit.or_else(|| is_picture.then(pixels)).or(silent.map(Unit::Silent));
    let unit = unit.expect("there are points, with a unit or silent");
    Ok(Layout { frame, time, assumed_second, is_picture, ..Layout::new(format, unit, points, findings) })
}

/// Takes x, y and z beside a w of the same name for a quaternion, unless they are lengths. Beside x and y alone it is the width
/// of a box.
fn quaternions(columns: &mut [Column]) {
    let has = |body: &String, axis: usize| {
        let is_axis = |own: &Column| matches!(own, Column::Position { marker, axis: of, unit: None } if marker == body && *of == axis);
        columns.iter().any(is_axis)
    };
    let bodies: Vec<String> = (columns.iter())
        .filter_map(|column| match column {
            Column::W { body } => Some(body.clone()).filter(|body| (0..3).all(|axis| has(body, axis))),
            _ => None,
        })
        .collect();
    for column in columns {
        let part = match column {
            Column::W { body } => Some((body.clone(), 0)),
            Column::Position { marker, axis, unit: None } => Some((marker.clone(), *axis + 1)),
            _ => None,
        };
        if let Some((body, part)) = part.filter(|(own, _)| bodies.contains(own)) {
            *column = Column::Orientation { body, part };
        }
    }
}

/// Beside a velocity `v_x`, `a_x` is an acceleration and `p_x` a momentum, as Tracker writes them, unless they are lengths.
fn derived(names: &[String], columns: &mut [Column]) {
    if !names.iter().any(|name| words(name).iter().any(|word| word == "v")) {
        return;
    }
    for column in columns {
        if matches!(&*column, Column::Position { marker, unit: None, .. } if ["a", "p"].contains(&marker.as_str()))
        {
            *column = Column::Other;
        }
    }
}

/// Takes what may be a coordinate for one if its marker has another axis.
fn decide(columns: &mut [Column]) {
    let of = |column: &Column| match column {
        Column::Perhaps { marker, axis, .. } => Some((marker.clone(), *axis)),
        _ => None,
    };
    let met: Vec<(String, usize)> = columns.iter().filter_map(of).collect();
    for column in columns {
        let Column::Perhaps { marker, axis, unit } = &*column else { continue };
        let has_other = met.iter().any(|(own, other)| own == marker && other != axis);
        let position = || Column::Position { marker: marker.clone(), axis: *axis, unit: *unit };
        *column = if has_other { position() } else { Column::Other };
    }
}

/// Gives bodies their orientations; those without all four parts, or without a position, are passed over.
fn orient(
    points: &mut [Columns],
    bodies: &[(String, usize, usize)],
    names: &[String],
    passed_over: &mut Vec<String>,
) {
    let mut parts = BTreeMap::<&str, [Option<usize>; 4]>::new();
    for (body, part, at) in bodies {
        parts.entry(body).or_default()[*part] = Some(*at);
    }
    let mut places = HashMap::new();
    for (k, point) in points.iter().enumerate() {
        places.entry(point.name.clone()).or_insert(k);
        places.entry(body(&point.name)).or_insert(k);
    }
    for (of, _, at) in bodies {
        let point = places.get(of).or_else(|| places.get(&body(of)));
        match (parts[of.as_str()], point) {
            ([Some(w), Some(x), Some(y), Some(z)], Some(point)) => {
                points[*point].orientation = Some([w, x, y, z]);
            }
            _ => passed_over.push(names[*at].clone()),
        }
    }
}

/// Puts the coordinates of a plane or a line in their place, and says which are not there; returns whether heights count
/// downwards, as those of a picture do.
fn flat(
    points: &mut [Columns],
    is_picture: bool,
    findings: &mut Vec<String>,
) -> Result<bool, RecordingProblem> {
    let has = |points: &[Columns], axis: usize| points.iter().any(|point| point.position[axis].is_some());
    let is_upright = !has(points, 2) && has(points, 1);
    if is_upright {
        points.iter_mut().for_each(|point| point.position.swap(1, 2));
        let counts = if is_picture { "counts down, as the rows of a picture do" } else { "counts up" };
        findings.push(format!("no z is given: y is taken for the height, which {counts}"));
    }
    let is_line = !has(points, 0) || !has(points, 2);
    for Columns { name, position, .. } in points.iter().filter(|_| !is_line) {
        let missing = if position[0].is_none() { Some("x") } else { position[2].is_none().then_some("z") };
        if let Some(axis) = missing {
            let axis = if axis == "z" && is_upright { "y" } else { axis };
            let remedy = "add the column";
            return Err(RecordingProblem::MissingAxis { marker: name.clone(), axis, remedy });
        }
    }
    if is_line {
        let axis = if has(points, 0) {
            "x"
        } else if is_upright {
            "y"
        } else {
            "z"
        };
        findings.push(format!(
            "one coordinate alone is given, {axis}; the others are 0 here: frequency and damping can be analysed, and a \
             fit of a model would take the others for measured"
        ));
        return Ok(is_picture && is_upright);
    }
    let in_plane = points.iter().filter(|point| point.position[1].is_none() && !is_upright);
    let in_plane: Vec<String> = in_plane.map(|point| point.name.clone()).collect();
    if !in_plane.is_empty() {
        findings.push(format!("no y is given for {}; it is 0 here", some(&in_plane)));
    }
    Ok(is_picture && is_upright)
}

#[cfg(test)]
mod tests;
