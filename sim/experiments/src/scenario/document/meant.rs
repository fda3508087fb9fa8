//! What an unknown key means: one that is spelt almost so or, at the top of a file, one whose first tables were left out.

use models::nearest::nearest;

use super::super::units::whole_key;
use super::value::{Entry, Value};

/// What an entry of the table at `path` means: the whole key, such as `effects.payload.mass` of `payload.mass`, if one of
/// the `known` tables has it; or else the known key that is nearest.
pub fn meant(path: &str, entry: &Entry, known: &[&str]) -> Option<String> {
    let whole = if path.is_empty() { whole(entry, known) } else { None };
    whole.or_else(|| nearest(&entry.key, known.iter().copied()).map(str::to_owned))
}

fn whole(entry: &Entry, known: &[&str]) -> Option<String> {
    let mut path = entry.key.clone();
    let mut value = &entry.item.value;
    while let Value::Table(entries) = value {
        let first = entries.first()?;
        path = format!("{path}.{}", first.key);
        value = &first.item.value;
    }
    whole_key(&path).filter(|whole| known.iter().any(|own| whole.split('.').next() == Some(own)))
}
