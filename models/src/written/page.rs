//! The page of a law as text, like those of the catalogue.

use std::fmt::Write;

use super::names::{OUTPUTS, names};
use super::{Definition, NOTES};
use crate::effects::About;

/// Blanks before a table of symbols.
const INDENT: &str = "  ";

impl Definition {
    /// What `efam effects` prints of it.
    pub(super) fn page(&self, about: &About) -> String {
        let mut out = format!("{}: {}.\n\n", self.name.replace('_', " "), self.meaning.trim_end_matches('.'));
        for (head, (k, formula)) in
            ["Law:      "].into_iter().chain(std::iter::repeat("          ")).zip(&self.formulas)
        {
            let equals = if OUTPUTS[*k].key == "memory" { "memory rate" } else { OUTPUTS[*k].key };
            let _ = writeln!(out, "{head}{equals} = {formula}");
        }
        let given = self.formulas.iter().map(|(k, _)| OUTPUTS[*k]);
        let symbol = |name: &str, meaning: &str, unit: &str| [name, meaning, unit].map(str::to_owned);
        let mut rows: Vec<[String; 3]> = given
            .clone()
            .filter(|own| own.key != "memory")
            .map(|own| symbol(own.key, own.meaning, own.unit))
            .collect();
        rows.extend(self.parameters.iter().map(|own| symbol(&own.name, &own.meaning, &own.unit)));
        let is_named = |name: &str| {
            let is_part = |c: char| c == '_' || c.is_alphanumeric();
            self.formulas.iter().any(|(_, text)| text.split(|c| !is_part(c)).any(|word| word == name))
        };
        for (_, seen) in
            self.places.iter().flat_map(|place| names(*place)).filter(|(_, seen)| is_named(seen.name))
        {
            let unit = if seen.name == "memory" { &self.memory_unit } else { seen.unit };
            if !rows.iter().any(|row| row[0] == seen.name) {
                rows.push(symbol(seen.name, seen.meaning, unit));
            }
        }
        let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
        let [name, meaning] = [width(0), width(1)];
        out.push('\n');
        for row in &rows {
            let unit = if row[2].is_empty() { "–" } else { &row[2] };
            let _ = writeln!(out, "{INDENT}{:name$}   {:meaning$}   {unit}", row[0], row[1]);
        }
        out.push('\n');
        let off: Vec<String> =
            about.parameters.iter().filter_map(|p| Some(format!("{} = {}", p.name, p.null_value?))).collect();
        let off = if off.is_empty() { "Never.".to_owned() } else { format!("{}.", off.join(", ")) };
        let note = |k: usize| {
            let own = self.notes[k].as_deref().unwrap_or("Its author does not say.");
            (NOTES[k], own.to_owned())
        };
        for (head, text) in [note(0), ("off", off), note(1), note(2)] {
            let title = format!("{}{}:", head[..1].to_uppercase(), &head[1..]);
            let _ = writeln!(out, "{title:10}{text}");
        }
        out.trim_end().to_owned()
    }
}
