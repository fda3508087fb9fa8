//! What someone most likely meant who wrote a unit that is none.

use super::names::{known, named};
use crate::nearest::nearest;

/// What someone who wrote the unknown `name` most likely meant.
pub(super) fn meant(name: &str) -> Option<String> {
    let known = || known().chain(PREFIXED.iter().copied());
    if let Some(symbol) = known().find(|symbol| symbol.eq_ignore_ascii_case(name)) {
        return Some(symbol.to_string());
    }
    let lower = name.to_lowercase();
    if let Some((_, symbol)) = WORDS.iter().find(|(word, _)| *word == lower) {
        return Some((*symbol).to_string());
    }
    // m2 for m^2, Nm for N m, Nm2 for N m^2.
    let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &name[letters.len()..];
    let power = if digits.is_empty() { String::new() } else { format!("^{digits}") };
    if !power.is_empty() && named(letters).is_some() {
        return Some(format!("{letters}{power}"));
    }
    let mut cuts = letters.char_indices().skip(1).map(|(at, _)| letters.split_at(at));
    if let Some((left, right)) = cuts.find(|(left, right)| named(left).is_some() && named(right).is_some()) {
        return Some(format!("{left} {right}{power}"));
    }
    nearest(name, known()).map(str::to_string)
}

/// Words and spellings that people write for a unit, and the name that this table has for it.
const WORDS: &[(&str, &str)] = &[
    ("inch", "in"),
    ("inches", "in"),
    ("foot", "ft"),
    ("feet", "ft"),
    ("meter", "m"),
    ("metre", "m"),
    ("meters", "m"),
    ("metres", "m"),
    ("gram", "g"),
    ("grams", "g"),
    ("kgs", "kg"),
    ("bars", "bar"),
    ("degs", "deg"),
    ("mins", "min"),
    ("rads", "rad"),
    ("pound", "lb"),
    ("pounds", "lb"),
    ("lbs", "lb"),
    ("ounce", "oz"),
    ("newton", "N"),
    ("newtons", "N"),
    ("pascal", "Pa"),
    ("joule", "J"),
    ("watt", "W"),
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("minute", "min"),
    ("minutes", "min"),
    ("hr", "h"),
    ("hour", "h"),
    ("hours", "h"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("percent", "%"),
    ("torr", "mmHg"),
];

/// Prefixed names that a misspelt one may have meant.
const PREFIXED: &[&str] = &[
    "kg", "mg", "mm", "cm", "km", "ms", "us", "mN", "kN", "kPa", "MPa", "kJ", "mJ", "kW", "mW", "kHz", "mrad",
];
