//! What an unknown key at the top of a file means: one whose first tables were left out.

use super::super::units::whole_key;
use super::value::{Entry, Value};

/// The whole key that an entry means, such as `effects.payload.mass` of `payload.mass`, if one of the `known` tables has
/// it.
pub fn meant(entry: &Entry, known: &[&str]) -> Option<String> {
    let mut path = entry.key.clone();
    let mut value = &entry.item.value;
    while let Value::Table(entries) = value {
        let first = entries.first()?;
        path = format!("{path}.{}", first.key);
        value = &first.item.value;
    }
    whole_key(&path).filter(|whole| known.iter().any(|own| whole.split('.').next() == Some(own)))
}
