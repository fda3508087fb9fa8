//! What the name of a column says: a time, a frame number, or a coordinate of a marker.

use super::cells::Rows;
use super::length::Length;

pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// What a column holds.
#[derive(Debug, PartialEq)]
pub(super) enum Column {
    /// Time, with the length of its unit, s, and whether that is stated.
    Time(f64, bool),
    Frame,
    Position {
        marker: String,
        axis: usize,
        unit: Option<Length>,
    },
    Orientation {
        body: String,
        part: usize,
    },
    Other,
}

/// Whether a row names columns of a tidy table.
pub(super) fn is_header(rows: &Rows) -> bool {
    rows.cells().any(|name| matches!(column(name), Column::Time(..) | Column::Position { .. }))
}

/// What a column's name says.
pub(super) fn column(name: &str) -> Column {
    let lower = name.to_lowercase();
    let words: Vec<&str> =
        lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    match words.as_slice() {
        ["t" | "time" | "timestamp"] => return Column::Time(1.0, false),
        ["t" | "time" | "timestamp", unit] => match *unit {
            "s" | "sec" | "second" | "seconds" => return Column::Time(1.0, true),
            "ms" | "millisecond" | "milliseconds" => return Column::Time(1e-3, true),
            "us" | "µs" | "microsecond" | "microseconds" => return Column::Time(1e-6, true),
            "min" | "minute" | "minutes" => return Column::Time(60.0, true),
            _ => {}
        },
        ["frame"] | ["frame", "number"] => return Column::Frame,
        _ => {}
    }
    if let Some((body, part)) = name.rsplit_once('_')
        && let Some(part) = ["qw", "qx", "qy", "qz"].iter().position(|q| part.eq_ignore_ascii_case(q))
    {
        return Column::Orientation { body: body.to_owned(), part };
    }
    position(name).unwrap_or(Column::Other)
}

fn position(name: &str) -> Option<Column> {
    let (stem, unit) = match name.strip_suffix([')', ']']) {
        Some(rest) => {
            let (stem, unit) = rest.rsplit_once(['(', '['])?;
            (stem.trim_end_matches([' ', '_']), Some(Length::named(unit)?))
        }
        None => match name.rsplit_once('_').map(|(stem, unit)| (stem, Length::named(unit))) {
            Some((stem, Some(unit))) => (stem, Some(unit)),
            _ => (name, None),
        },
    };
    let axis = |word: &str| AXES.iter().position(|axis| word.eq_ignore_ascii_case(axis));
    if let Some(axis) = axis(stem) {
        return Some(Column::Position { marker: "point".to_owned(), axis, unit });
    }
    if let Some((marker, last)) = stem.rsplit_once(['_', '.', ':', ' '])
        && let Some(axis) = axis(last)
    {
        return Some(Column::Position { marker: marker.to_owned(), axis, unit });
    }
    let (first, node) = stem.split_once('_')?;
    let is_number = !node.is_empty() && node.bytes().all(|byte| byte.is_ascii_digit());
    let axis = axis(first).filter(|_| is_number && unit.is_some())?;
    Some(Column::Position { marker: format!("node_{node}"), axis, unit })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_say_what_they_hold() {
        let at = |marker: &str, axis, unit| Column::Position { marker: marker.to_owned(), axis, unit };
        for (name, expected) in [
            ("t_s", Column::Time(1.0, true)),
            ("Time (ms)", Column::Time(1e-3, true)),
            ("time", Column::Time(1.0, false)),
            ("Frame", Column::Frame),
            ("tip_x_m", at("tip", 0, Some(Length::Metre))),
            ("left_arm_Z_mm", at("left_arm", 2, Some(Length::Millimetre))),
            ("tip_y [cm]", at("tip", 1, Some(Length::Centimetre))),
            ("tip.x", at("tip", 0, None)),
            ("z_07_m", at("node_07", 2, Some(Length::Metre))),
            ("x_m", at("point", 0, Some(Length::Metre))),
            ("body_qz", Column::Orientation { body: "body".to_owned(), part: 3 }),
            ("tip_vx_m_s", Column::Other),
            ("vx_07_m_s", Column::Other),
            ("kinetic_J", Column::Other),
            ("body_angle_rad", Column::Other),
            ("", Column::Other),
        ] {
            assert_eq!(column(name), expected, "{name}");
        }
    }
}
