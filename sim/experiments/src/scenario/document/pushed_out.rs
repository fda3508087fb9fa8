//! Keys that give way to one that is set over them.

use super::value::{Entry, Value};

/// Keys of which only one can be meant: one that is set pushes the others out.
const ALTERNATIVES: [&[&str]; 2] = [&["name", "file", "text"], &["from", "posture", "nodes"]];
/// The start that goes with a hold; with it, an angle means nothing.
const EQUILIBRIUM: &str = "equilibrium";

/// Whether an entry of the table of `path` gives way to a value that is set there.
pub(super) fn is_pushed_out(entry: &Entry, path: &str, value: &Value) -> bool {
    let own = entry.key.as_str();
    let (table, last) = path.rsplit_once('.').unwrap_or(("", path));
    let is_alternative = |all: &[&str]| all.contains(&own) && all.contains(&last);
    let is_equilibrium = |value: &Value| matches!(value, Value::Text(word) if word == EQUILIBRIUM);
    let is_other_start = match (table, last) {
        // The angle of a release that started from something else says that it starts from the angle.
        ("release", "angle") => {
            ["posture", "nodes", "hold"].contains(&own)
                || (own == "from" && is_equilibrium(&entry.item.value))
        }
        ("release", "posture" | "nodes") => own == "hold",
        ("release", "from") => own == "hold" && !is_equilibrium(value),
        _ => false,
    };
    own == last || is_other_start || (!table.is_empty() && ALTERNATIVES.into_iter().any(is_alternative))
}
