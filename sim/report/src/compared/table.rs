//! A comparison as people read it.

use std::fmt::Write;

use models::digits::significant_or_dash;

use super::Comparison;
use crate::aligned::{Aligned, Side};

/// The runs by their letters, where their scenarios differ, and their numbers.
pub fn comparison_table(comparison: &Comparison) -> String {
    let mut out = String::new();
    for run in &comparison.runs {
        writeln!(out, "{}  {}, {}", run.letter, run.name, run.kind).expect("a string");
    }
    let letters = || comparison.runs.iter().map(|run| run.letter.as_str());
    let with_heads = |side: Side| {
        let own = letters().map(|letter| (letter, side));
        Aligned::new(
            &[("", Side::Words)].into_iter().chain(own).chain([("", Side::Name)]).collect::<Vec<_>>(),
        )
    };
    let mut differences = with_heads(Side::Words);
    for of in &comparison.differences {
        let values = of.values.iter().map(|value| value.as_deref().unwrap_or("-"));
        differences.row([of.key.as_str()].into_iter().chain(values));
    }
    if !comparison.differences.is_empty() {
        write!(out, "\n{differences}").expect("a string");
    }
    let mut numbers = with_heads(Side::Number);
    let rows =
        [&comparison.quantities, &comparison.over_pressure, &comparison.predictions, &comparison.analyses];
    for row in rows.into_iter().flatten() {
        let values = row.values.iter().map(|value| significant_or_dash(*value, 4));
        numbers.row([row.name.clone()].into_iter().chain(values).chain([row.unit.clone()]));
    }
    for one in &comparison.parameters {
        let values = one.values.iter().map(|value| significant_or_dash(*value, 5));
        numbers.row([one.name.clone()].into_iter().chain(values).chain([one.unit.clone()]));
    }
    write!(out, "\n{numbers}").expect("a string");
    for of in &comparison.verdicts {
        writeln!(out, "{}  {}: {}", of.letter, of.verdict, of.effects.join(", ")).expect("a string");
    }
    out
}
