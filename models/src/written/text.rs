//! A law as its table `[laws.NAME]`, from which it can be read again: what results keep of it.

use std::fmt::Write;

use super::names::{OUTPUTS, PLACES};
use super::{Definition, KINDS, NOTES, OwnParameter, PER, REACHES, SEPARATORS};
use crate::effects::{Per, Reach};

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn list<'a>(words: impl Iterator<Item = &'a str>) -> String {
    format!("[{}]", words.map(quoted).collect::<Vec<_>>().join(", "))
}

fn word<T: PartialEq + Copy>(table: &[(&'static str, T)], of: T) -> &'static str {
    table.iter().find(|(_, known)| *known == of).map_or("", |(word, _)| word)
}

/// A number that is read back to the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}

impl Definition {
    /// The law as a table of TOML.
    pub fn text(&self) -> String {
        let mut out = format!("[laws.{}]\n", self.name);
        let mut put = |key: &str, value: String| {
            let _ = writeln!(out, "{key} = {value}");
        };
        put("meaning", quoted(&self.meaning));
        put("place", list(self.places.iter().map(|place| word(&PLACES, *place))));
        for (k, formula) in &self.formulas {
            put(OUTPUTS[*k].key, quoted(formula));
        }
        if !self.memory_unit.is_empty() {
            put("memory_unit", quoted(&self.memory_unit));
        }
        if let Some(kind) = self.kind {
            put("kind", quoted(word(&KINDS, kind)));
        }
        if self.reach != Reach::Muscle {
            put("reach", quoted(word(&REACHES, self.reach)));
        }
        if !self.signature.is_empty() {
            put("signature", quoted(&self.signature));
        }
        if !self.confounded_with.is_empty() {
            put("confounded_with", list(self.confounded_with.iter().map(String::as_str)));
        }
        if !self.separated_by.is_empty() {
            put("separated_by", list(self.separated_by.iter().map(|own| word(&SEPARATORS, *own))));
        }
        for (key, note) in NOTES.into_iter().zip(&self.notes) {
            if let Some(note) = note {
                put(key, quoted(note));
            }
        }
        for own in &self.parameters {
            let _ = writeln!(out, "parameters.{} = {{ {} }}", own.name, fields(own));
        }
        out
    }
}

fn fields(own: &OwnParameter) -> String {
    let pair = |(low, high): (f64, f64)| format!("[{}, {}]", number(low), number(high));
    let mut all = Vec::new();
    let mut put = |key: &str, value: String| all.push(format!("{key} = {value}"));
    if !own.meaning.is_empty() {
        put("meaning", quoted(&own.meaning));
    }
    if !own.unit.is_empty() {
        put("unit", quoted(&own.unit));
    }
    put("default", number(own.default));
    put("range", pair(own.range));
    if let Some(scale) = own.scale {
        put("scale", number(scale));
    }
    if let Some(off) = own.null_value {
        put("off", number(off));
    }
    if own.is_part {
        put("part", "true".to_owned());
    }
    if own.is_friction {
        put("friction", "true".to_owned());
    }
    if let Some(plausible) = own.plausible {
        put("plausible", pair(plausible));
    }
    if own.per != Per::Unit {
        put("per", quoted(word(&PER, own.per)));
    }
    if !own.tries.is_empty() {
        let tries: Vec<String> = own.tries.iter().map(|value| number(*value)).collect();
        put("tries", format!("[{}]", tries.join(", ")));
    }
    all.join(", ")
}
