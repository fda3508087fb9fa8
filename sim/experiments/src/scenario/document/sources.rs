//! The files of which a document is made.

use std::path::Path;

use super::value::{Entry, Item, Value};
use super::{Document, SET};
use crate::scenario::{ScenarioError, ScenarioProblem};

impl Document {
    /// The files that were read, each with its text: the document's own, and those that it includes.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        let files = self.sources.iter().filter(|source| source.name != SET);
        files.map(|source| (source.name.as_str(), &*source.text))
    }

    /// Takes in the tables of another file under `key`; it has nothing else. Two of one name are refused.
    pub fn include(&mut self, path: &Path, key: &str) -> Result<(), ScenarioError> {
        let other = Document::load(path, &[])?;
        other.keys().only(&[key])?;
        other.keys().table(key)?;
        let source = self.sources.len();
        self.sources.extend(other.sources);
        let Some(tables) = within(other.root, key).map(|item| item.moved(source)) else { return Ok(()) };
        let Value::Table(own) = &mut self.root.value else { return Ok(()) };
        let known = own.iter().position(|entry| entry.key == key);
        let index = known.unwrap_or_else(|| {
            let (place, value) = (tables.place.clone(), Value::Table(Vec::new()));
            let (key, key_place) = (key.to_owned(), tables.place.clone());
            own.push(Entry { key, key_place, item: Item { place, value } });
            own.len() - 1
        });
        let (Value::Table(own), Value::Table(more)) = (&mut own[index].item.value, tables.value) else {
            return Ok(());
        };
        for entry in more {
            if own.iter().any(|known| known.key == entry.key) {
                let message = "another file has one of this name; keep one of them, or rename it".to_owned();
                let path = format!("{key}.{}", entry.key);
                return Err(self.error(&entry.key_place, &path, ScenarioProblem::Other { message }));
            }
            own.push(entry);
        }
        Ok(())
    }
}

/// The value of a key of a table.
fn within(table: Item, key: &str) -> Option<Item> {
    match table.value {
        Value::Table(entries) => entries.into_iter().find(|entry| entry.key == key).map(|entry| entry.item),
        _ => None,
    }
}
