//! Names of markers, as tables, files and findings give them.

use std::collections::{BTreeMap, BTreeSet};

use super::cells::short;

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
