//! What the name of a column says: a time, a frame number, or a coordinate of a marker.

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
    /// A coordinate in a name that may mean another thing, such as `x1`, `x_tip` or `tipX`: one where it has a second axis.
    Perhaps {
        marker: String,
        axis: usize,
        unit: Option<Length>,
    },
    /// A part of a quaternion: w, x, y or z.
    Orientation {
        body: String,
        part: usize,
    },
    /// w, beside which x, y and z of the same name are a quaternion.
    W {
        body: String,
    },
    /// How likely a place is right.
    Likelihood {
        marker: String,
    },
    Other,
}

/// What a coordinate without a unit of length is, if its name has one of these words: no position.
const QUANTITIES: [&str; 45] = [
    "acc",
    "accel",
    "accelerometer",
    "acceleration",
    "accelerations",
    "gyr",
    "gyro",
    "gyroscope",
    "angular",
    "rate",
    "rates",
    "v",
    "vel",
    "velocity",
    "speed",
    "mag",
    "magn",
    "magnetometer",
    "magnetic",
    "ang",
    "angle",
    "angles",
    "euler",
    "rot",
    "rotation",
    "rotvec",
    "orientation",
    "quat",
    "quaternion",
    "attitude",
    "force",
    "torque",
    "moment",
    "gravity",
    "jerk",
    "residual",
    "error",
    "err",
    "std",
    "sigma",
    "var",
    "covariance",
    "normal",
    "axis",
    "strain",
];
/// Words that a body's name may have for its position, and for its orientation.
const ASIDE: [&str; 14] = [
    "pos",
    "position",
    "trans",
    "translation",
    "loc",
    "location",
    "quat",
    "quaternion",
    "q",
    "rot",
    "rotation",
    "orientation",
    "attitude",
    "pose",
];
/// What joins the name of a marker to its axis.
const JOINTS: [char; 6] = ['_', '.', ':', ' ', '/', '-'];

/// What a time is called, in the languages of spreadsheets.
const TIMES: [&str; 10] =
    ["t", "time", "timestamp", "elapsed", "zeit", "temps", "tiempo", "tempo", "tijd", "tid"];

/// What a column's name says.
pub(super) fn column(name: &str) -> Column {
    // Programs put the name of a run before it, such as `Data Set 1:Time(s)`.
    let mut own = words(name.rsplit_once(':').map_or(name, |(_, own)| own));
    own.retain(|word| word != "in");
    match own.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["elapsed", word] | [word] if TIMES.contains(&word) => return Column::Time(1.0, false),
        ["elapsed", word, unit] | [word, unit] if TIMES.contains(&word) && second(unit).is_some() => {
            return Column::Time(second(unit).expect("it is one"), true);
        }
        // A single letter may be anything: an arc length, a mass.
        [unit] if second(unit).is_some() && unit.len() > 1 => {
            return Column::Time(second(unit).expect("it is one"), true);
        }
        ["frame" | "coords" | "bodyparts"] | ["frame", "number" | "idx" | "index" | "no" | "nr"] => {
            return Column::Frame;
        }
        _ => {}
    }
    let (stem, last) = name.rsplit_once(JOINTS).unwrap_or(("", name));
    let body = || if stem.is_empty() { "point".to_owned() } else { stem.to_owned() };
    match last.to_lowercase().as_str() {
        "w" => return Column::W { body: body() },
        "likelihood" | "confidence" | "score" => return Column::Likelihood { marker: body() },
        last => {
            if let Some(part) = ["qw", "qx", "qy", "qz"].iter().position(|q| *q == last) {
                return Column::Orientation { body: body(), part };
            }
        }
    }
    position(name).unwrap_or(Column::Other)
}

/// The length of a unit of time, s.
fn second(unit: &str) -> Option<f64> {
    match unit {
        "s" | "sec" | "secs" | "second" | "seconds" => Some(1.0),
        "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => Some(1e-3),
        "us" | "µs" | "microsecond" | "microseconds" => Some(1e-6),
        "ns" | "nanosecond" | "nanoseconds" => Some(1e-9),
        "min" | "minute" | "minutes" => Some(60.0),
        "h" | "hour" | "hours" => Some(3600.0),
        "d" | "day" | "days" => Some(86_400.0),
        _ => None,
    }
}

/// The words of a name, in small letters: `FreeAcc_X` is of three.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_small = false;
    for letter in name.chars() {
        if !letter.is_alphanumeric() || was_small && letter.is_uppercase() {
            words.push(String::new());
        }
        was_small = letter.is_lowercase();
        if letter.is_alphanumeric() {
            words.last_mut().expect("there is one").extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// What a body is called, without the words for its position or orientation.
pub(super) fn body(name: &str) -> String {
    let words = words(name);
    let kept = words.into_iter().filter(|word| word != "point" && !ASIDE.contains(&word.as_str()));
    kept.collect::<Vec<_>>().join(" ")
}

fn position(name: &str) -> Option<Column> {
    let (stem, unit) = match name.strip_suffix([')', ']']) {
        Some(rest) => {
            let (stem, unit) = rest.rsplit_once(['(', '['])?;
            (stem.trim_end_matches([' ', '_']), Some(Length::named(unit)?))
        }
        None => match name.rsplit_once(['_', ' ', '/']).map(|(stem, unit)| (stem, Length::named(unit))) {
            // `x / mm`, `x, mm`, `x - mm` and `x in mm`.
            Some((stem, Some(unit))) => {
                let stem = stem.trim_end_matches([' ', '/', ',', '-']);
                (stem.strip_suffix(" in").unwrap_or(stem), Some(unit))
            }
            _ => (name, None),
        },
    };
    let axis = |word: &str| AXES.iter().position(|axis| word.eq_ignore_ascii_case(axis));
    if let Some(axis) = axis(stem) {
        return Some(Column::Position { marker: "point".to_owned(), axis, unit });
    }
    if let Some((marker, last)) = stem.rsplit_once(JOINTS)
        && let Some(axis) = axis(last)
    {
        let is_other = || words(marker).iter().any(|word| QUANTITIES.contains(&word.as_str()));
        let marker = marker.trim_end_matches([' ', '-', '/']).to_owned();
        return (unit.is_some() || !is_other()).then_some(Column::Position { marker, axis, unit });
    }
    if let Some((first, node)) = stem.split_once('_')
        && let Some(axis) = axis(first).filter(|_| is_number(node) && unit.is_some())
    {
        return Some(Column::Position { marker: format!("node_{node}"), axis, unit });
    }
    let (marker, axis) = perhaps(stem)?;
    let is_other = words(&marker).iter().any(|word| QUANTITIES.contains(&word.as_str()));
    (!is_other).then_some(Column::Perhaps { marker, axis, unit })
}

fn is_number(word: &str) -> bool {
    !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Marker and axis of `x1`, `x_tip` and `tipX`.
fn perhaps(stem: &str) -> Option<(String, usize)> {
    let axis = |letter: char| AXES.iter().position(|axis| axis.starts_with(letter.to_ascii_lowercase()));
    let (first, last) = (stem.chars().next()?, stem.chars().next_back()?);
    let after = &stem[first.len_utf8()..];
    let marker = after.strip_prefix(JOINTS).filter(|marker| !marker.is_empty());
    if let Some((axis, marker)) = axis(first).zip(marker.or(Some(after).filter(|after| is_number(after)))) {
        return Some((marker.to_owned(), axis));
    }
    let before = &stem[..stem.len() - last.len_utf8()];
    let is_small = before.ends_with(|c: char| c.is_lowercase() || c.is_ascii_digit());
    Some((before.to_owned(), axis(last).filter(|_| is_small && last.is_uppercase())?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_say_what_they_hold() {
        let at = |marker: &str, axis, unit| Column::Position { marker: marker.to_owned(), axis, unit };
        let perhaps = |marker: &str, axis, unit| Column::Perhaps { marker: marker.to_owned(), axis, unit };
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
            ("sec", Column::Time(1.0, true)),
            ("time_stamp", Column::Other),
            ("frame_idx", Column::Frame),
            ("Zeit [s]", Column::Time(1.0, true)),
            ("Video Analysis: Time (s)", Column::Time(1.0, true)),
            ("Data Set 1:X(m)", at("Data Set 1", 0, Some(Length::Metre))),
            ("x_tip_mm", perhaps("tip", 0, Some(Length::Millimetre))),
            ("Y2", perhaps("2", 1, None)),
            ("markerZ", perhaps("marker", 2, None)),
            ("x_velocity", Column::Other),
            ("v_x", Column::Other),
            ("v_x_mm", at("v", 0, Some(Length::Millimetre))),
            ("a_x", at("a", 0, None)),
            ("index", Column::Other),
            ("MAX", Column::Other),
            ("s", Column::Other),
            ("qw", Column::Orientation { body: "point".to_owned(), part: 0 }),
            ("pose.orientation.w", Column::W { body: "pose.orientation".to_owned() }),
            ("tip_likelihood", Column::Likelihood { marker: "tip".to_owned() }),
            ("FreeAcc_X", Column::Other),
            ("gyr_z", Column::Other),
            ("linear_acceleration.y", Column::Other),
            ("Angle X (deg)", Column::Other),
            ("force_x_mm", at("force", 0, Some(Length::Millimetre))),
            ("x_px", at("point", 0, Some(Length::Pixel))),
            ("Tip 1 - X (cm)", at("Tip 1", 0, Some(Length::Centimetre))),
            ("tip x / mm", at("tip", 0, Some(Length::Millimetre))),
            ("tip_x/mm", at("tip", 0, Some(Length::Millimetre))),
            ("tip z in mm", at("tip", 2, Some(Length::Millimetre))),
            ("tip y, cm", at("tip", 1, Some(Length::Centimetre))),
            ("pose/x", at("pose", 0, None)),
            ("Tip X - mm", at("Tip", 0, Some(Length::Millimetre))),
            ("t / s", Column::Time(1.0, true)),
            ("time in ms", Column::Time(1e-3, true)),
            ("Elapsed", Column::Time(1.0, false)),
            ("t_days", Column::Time(86_400.0, true)),
        ] {
            assert_eq!(column(name), expected, "{name}");
        }
    }
}
