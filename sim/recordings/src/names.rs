//! Names of markers, as tables, files and findings give them.

use std::collections::{BTreeMap, BTreeSet};

use super::cells::short;
use super::error::RecordingProblem;

/// Names that may come twice, made different.
pub(super) fn distinct(names: impl IntoIterator<Item = String>, findings: &mut Vec<String>) -> Vec<String> {
    let mut seen = BTreeMap::<String, usize>::new();
    let mut taken = BTreeSet::new();
    let mut again = Vec::new();
    let mut distinct = Vec::new();
    for name in names {
        let count = seen.entry(name.clone()).or_default();
        *count += 1;
        let mut unique = if *count == 1 { name.clone() } else { format!("{name} ({count})") };
        while !taken.insert(unique.clone()) {
            *count += 1;
            unique = format!("{name} ({count})");
        }
        if unique != name {
            again.push(unique.clone());
        }
        distinct.push(unique);
    }
    if !again.is_empty() {
        findings.push(format!(
            "{} markers have the name of another; they are called {} here",
            again.len(),
            some(&again)
        ));
    }
    distinct
}

/// Some names for a finding, and how many more there are.
pub(super) fn some(names: &[String]) -> String {
    const SHOWN: usize = 6;
    let shown: Vec<_> = names.iter().take(SHOWN).map(|name| format!("`{}`", short(name))).collect();
    let more = names.len().saturating_sub(SHOWN);
    let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
    shown.join(", ") + &tail
}

/// Which axis a cell names: x, y or z, perhaps with a number as in `X1`.
fn axis(cell: &str) -> Option<usize> {
    let mut letters = cell.chars();
    let first = letters.next()?.to_ascii_lowercase();
    let is_numbered = letters.all(|letter| letter.is_ascii_digit());
    ['x', 'y', 'z'].iter().position(|axis| *axis == first).filter(|_| is_numbered)
}

/// The columns of x, y and z of each marker, from a row of axes in any order.
pub(super) fn groups(axes: &[String]) -> Vec<[usize; 3]> {
    let (mut groups, mut at) = (Vec::new(), 0);
    while at < axes.len() {
        let mut group = [None; 3];
        for (column, cell) in axes.iter().enumerate().skip(at).take(3) {
            if let Some(axis) = axis(cell) {
                group[axis] = Some(column);
            }
        }
        match group {
            [Some(x), Some(y), Some(z)] => {
                groups.push([x, y, z]);
                at += 3;
            }
            _ => at += 1,
        }
    }
    groups
}

/// The names of markers above their columns: by place or, where names are not above the first column of a marker, in
/// order if there are as many as markers.
/// # Errors
/// Other names than markers, whose markers cannot be determined.
pub(super) fn above(
    names: &[String],
    groups: &[[usize; 3]],
    line: u64,
    findings: &mut Vec<String>,
) -> Result<Vec<String>, RecordingProblem> {
    let starts: Vec<usize> = groups.iter().map(|group| group[0].min(group[1]).min(group[2])).collect();
    let last = starts.last().map_or(0, |start| start + 2);
    let named: Vec<usize> = (0..names.len()).filter(|at| !names[*at].is_empty()).collect();
    let is_placed = |at: &usize| starts.binary_search(at).is_ok();
    let in_place = named.iter().all(|at| is_placed(at) || *at > last);
    if !in_place {
        if named.len() != groups.len() {
            return Err(RecordingProblem::Header {
                line,
                expected: format!("a name above the first column of each of {} markers", groups.len()),
                met: format!("{} names, some of them above other columns", named.len()),
            });
        }
        findings.push(format!(
            "names are not above the first column of their markers; there are as many as markers, {}, and they are \
             taken in order",
            named.len()
        ));
        return Ok(distinct(named.into_iter().map(|at| names[at].clone()), findings));
    }
    let surplus: Vec<String> =
        named.iter().filter(|at| !is_placed(at)).map(|at| names[*at].clone()).collect();
    let name = |at: &usize| names.get(*at).filter(|name| !name.is_empty()).cloned();
    let unnamed = starts.iter().filter(|at| name(at).is_none()).count();
    if unnamed > 0 {
        findings.push(format!(
            "{unnamed} markers have no name; they are called by their column, such as `column 3`"
        ));
    }
    if !surplus.is_empty() {
        findings.push(format!("names without columns X,Y,Z below them were passed over: {}", some(&surplus)));
    }
    let all = starts.iter().map(|at| name(at).unwrap_or_else(|| format!("column {}", at + 1)));
    Ok(distinct(all.collect::<Vec<_>>(), findings))
}
