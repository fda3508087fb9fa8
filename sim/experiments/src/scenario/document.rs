//! A TOML text of which every value knows its place, and values that are set over it.

mod lists;
mod meant;
mod pushed_out;
mod sources;
mod value;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use efam_store::input;
use models::nearest::nearest;
use models::quantity::Quantity;
use toml::de::{DeTable, DeValue};

use super::error::{At, ScenarioError, ScenarioProblem};
use meant::meant;
use pushed_out::is_pushed_out;
pub use value::Place;
use value::{Entry, Item, Value, entries, of};

/// A scenario's text and what was set over it.
#[derive(Clone, Debug)]
pub struct Document {
    sources: Vec<Source>,
    root: Item,
}

/// A file, or the argument of a `--set`.
#[derive(Clone, Debug)]
struct Source {
    name: String,
    text: Arc<str>,
    /// What file names in it are relative to.
    base: PathBuf,
}

/// Name of what is set over the files.
const SET: &str = "--set";

/// Parts of a path that is set, at most; the deepest key of a scenario has five.
const DEEPEST: usize = 8;
impl Document {
    /// Reads a file and sets `overrides` over it, each as `path=value`.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Document, ScenarioError> {
        let text = input::text(path).map_err(|error| {
            let (file, reason) = (path.display().to_string(), error.to_string());
            ScenarioError { at: None, problem: ScenarioProblem::Unreadable { file, reason }.into() }
        })?;
        Document::parse(path, &text, overrides)
    }

    /// The same of a text; files that it names are relative to `path`.
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Document, ScenarioError> {
        let mut document = Document::plain(path, text)?;
        for argument in overrides {
            document.set(argument)?;
        }
        Ok(document)
    }

    fn plain(path: &Path, text: &str) -> Result<Document, ScenarioError> {
        let base = path.parent().unwrap_or(Path::new("")).to_owned();
        let source = Source { name: path.display().to_string(), text: text.into(), base };
        let place = Place { source: 0, span: 0..0 };
        let mut document =
            Document { sources: vec![source], root: Item { place, value: Value::Table(Vec::new()) } };
        match DeTable::parse(text) {
            Ok(table) => {
                document.root.value =
                    Value::Table(entries(table.get_ref(), &|span| Place { source: 0, span }));
                Ok(document)
            }
            Err(error) => {
                let place = Place { source: 0, span: error.span().unwrap_or(0..0) };
                Err(document.error(&place, "", ScenarioProblem::Toml { message: error.message().to_owned() }))
            }
        }
    }

    /// Sets `path=value`, as an argument `--set` gives it; file names in it are relative to the
    /// working directory. What is no TOML value is taken as text, so `payload.mass=50 g` needs no
    /// quotes.
    fn set(&mut self, argument: &str) -> Result<(), ScenarioError> {
        let source = self.sources.len();
        let (name, base) = (SET.to_owned(), PathBuf::new());
        self.sources.push(Source { name, text: argument.into(), base });
        let whole = Place { source, span: 0..argument.len() };
        let parts = argument.split_once('=').map(|(path, value)| (path.trim(), value));
        let is_path = |path: &str| path.split('.').all(is_key) && path.split('.').count() <= DEEPEST;
        let Some((path, value)) = parts.filter(|(path, _)| is_path(path)) else {
            return Err(self.error(&whole, "", ScenarioProblem::Override));
        };
        let at = argument.len() - value.len();
        let place = Place { source, span: at..argument.len() };
        let item = match DeValue::parse(value.trim()) {
            Ok(parsed) => Item { value: of(parsed.get_ref(), &|_| place.clone()), place },
            Err(_) => Item { place, value: Value::Text(value.trim().to_owned()) },
        };
        let key_place = Place { source, span: 0..path.len() };
        let mut table = &mut self.root;
        let mut keys: Vec<&str> = path.split('.').collect();
        let last = keys.pop().unwrap_or_default();
        for part in keys {
            let (key, member) = split_index(part);
            let Value::Table(entries) = &mut table.value else {
                return Err(self.error(&key_place, path, ScenarioProblem::WrongType { due: "a table" }));
            };
            if let Some(member) = member {
                let list =
                    entries.iter_mut().find(|entry| entry.key == key).map(|entry| &mut entry.item.value);
                let found = match list {
                    Some(Value::Array(items)) => items.get_mut(member.wrapping_sub(1)),
                    _ => None,
                };
                let Some(item) = found else {
                    let message = format!("there is no {part}; members count from one");
                    return Err(self.error(&key_place, "", ScenarioProblem::Other { message }));
                };
                table = item;
                continue;
            }
            let known = entries.iter().position(|entry| entry.key == key);
            let index = known.unwrap_or_else(|| {
                let item = Item { place: key_place.clone(), value: Value::Table(Vec::new()) };
                entries.push(Entry { key: key.to_owned(), key_place: key_place.clone(), item });
                entries.len() - 1
            });
            table = &mut entries[index].item;
        }
        let Value::Table(entries) = &mut table.value else {
            return Err(self.error(&key_place, path, ScenarioProblem::WrongType { due: "a table" }));
        };
        entries.retain(|entry| !is_pushed_out(entry, path, &item.value));
        entries.push(Entry { key: last.to_owned(), key_place, item });
        Ok(())
    }

    /// The text itself, without what is set over it.
    pub fn text(&self) -> &str {
        &self.sources[0].text
    }

    /// The whole document.
    pub fn keys(&self) -> Keys<'_> {
        Keys { document: self, path: String::new(), item: Some(&self.root), key_place: None }
    }

    /// The error that something is wrong at a place.
    pub fn error(&self, place: &Place, key: &str, problem: ScenarioProblem) -> ScenarioError {
        let source = &self.sources[place.source];
        ScenarioError {
            at: Some(At {
                file: source.name.clone(),
                text: source.text.clone(),
                span: place.span.clone(),
                key: key.to_owned(),
            }),
            problem: problem.into(),
        }
    }

    /// The error that the value of `path` is wrong, wherever it comes from.
    pub fn error_of(&self, path: &str, problem: ScenarioProblem) -> ScenarioError {
        match self.find(path).map(|item| item.place.clone()) {
            Some(place) => self.error(&place, path, problem),
            None => ScenarioError {
                at: Some(At {
                    file: self.sources[0].name.clone(),
                    text: "".into(),
                    span: 0..0,
                    key: path.to_owned(),
                }),
                problem: problem.into(),
            },
        }
    }

    /// The error that a part of the text of `path` is wrong; `text` is that text without its quotes.
    pub fn error_within(
        &self,
        path: &str,
        text: &str,
        part: Range<usize>,
        problem: ScenarioProblem,
    ) -> ScenarioError {
        let mut error = self.error_of(path, problem);
        if let Some(at) = error.at.as_mut()
            // A text with escapes is not in the source as it is.
            && let Some(start) = at.text.get(at.span.clone()).and_then(|source| source.find(text))
        {
            at.span = at.span.start + start + part.start..at.span.start + start + part.end;
        }
        error
    }

    /// Whether there is something at a path.
    pub fn has(&self, path: &str) -> bool {
        self.find(path).is_some()
    }

    /// The item at a path such as `recording[2].tip`; members of a list count from one.
    fn find(&self, path: &str) -> Option<&Item> {
        let mut item = &self.root;
        for part in path.split('.') {
            let (key, index) = split_index(part);
            let Value::Table(entries) = &item.value else { return None };
            item = &entries.iter().find(|entry| entry.key == key)?.item;
            if let Some(index) = index {
                let Value::Array(items) = &item.value else { return None };
                item = items.get(index.checked_sub(1)?)?;
            }
        }
        Some(item)
    }

    /// Where a file that is named at a place lies.
    pub fn file(&self, place: &Place, name: &str) -> PathBuf {
        self.sources[place.source].base.join(name)
    }
}

/// A table of a document, or none where it is not given.
#[derive(Clone)]
pub struct Keys<'a> {
    document: &'a Document,
    /// Path of the table, empty for the root.
    pub path: String,
    item: Option<&'a Item>,
    key_place: Option<Place>,
}

impl<'a> Keys<'a> {
    fn entry(&self, key: &str) -> Option<&'a Entry> {
        match self.item.map(|item| &item.value) {
            Some(Value::Table(entries)) => entries.iter().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// Path of a key in this table.
    pub fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Whether the table is given.
    pub fn is_given(&self) -> bool {
        self.item.is_some()
    }

    /// Whether a key is given.
    pub fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    /// The table of a key.
    pub fn table(&self, key: &str) -> Result<Keys<'a>, ScenarioError> {
        let entry = self.entry(key);
        if let Some(Entry { item: Item { value: Value::Table(_), .. }, .. }) | None = entry {
            return Ok(Keys {
                document: self.document,
                path: self.path_of(key),
                item: entry.map(|entry| &entry.item),
                key_place: entry.map(|entry| entry.key_place.clone()),
            });
        }
        let path = self.path_of(key);
        let due = format!("a table is due; write [{path}] on a line of its own, and the keys under it");
        Err(self.wrong(key, ScenarioProblem::Other { message: due }))
    }

    /// Refuses keys that are not known.
    pub fn only(&self, known: &[&str]) -> Result<(), ScenarioError> {
        let Some(Value::Table(entries)) = self.item.map(|item| &item.value) else { return Ok(()) };
        let Some(entry) = entries.iter().find(|entry| !known.contains(&entry.key.as_str())) else {
            return Ok(());
        };
        let problem = ScenarioProblem::UnknownKey {
            nearest: meant(&self.path, entry, known),
            known: known.iter().map(|key| (*key).to_owned()).collect(),
        };
        Err(self.document.error(&entry.key_place, &self.path_of(&entry.key), problem))
    }

    /// The error that the value of a key is wrong.
    pub fn wrong(&self, key: &str, problem: ScenarioProblem) -> ScenarioError {
        match self.entry(key) {
            Some(entry) => self.document.error(&entry.item.place, &self.path_of(key), problem),
            None => self.document.error_of(&self.path_of(key), problem),
        }
    }

    /// The error that a key is missing.
    pub fn missing(&self, key: &'static str, example: &'static str) -> ScenarioError {
        let place = self.key_place.clone().unwrap_or(Place { source: 0, span: 0..0 });
        self.document.error(&place, &self.path_of(key), ScenarioProblem::Missing { example })
    }

    /// A quantity in `unit`.
    pub fn quantity(&self, key: &str, unit: &str) -> Result<Option<f64>, ScenarioError> {
        match self.entry(key) {
            Some(entry) => self.quantity_of(&entry.item, key, unit).map(Some),
            None => Ok(None),
        }
    }

    /// A quantity in `unit` that satisfies a condition.
    pub fn quantity_that(
        &self,
        key: &str,
        unit: &str,
        must: &'static str,
        holds: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, ScenarioError> {
        match self.quantity(key, unit)? {
            Some(value) if !holds(value) => Err(self.wrong(key, ScenarioProblem::Must { must })),
            value => Ok(value),
        }
    }

    fn quantity_of(&self, item: &Item, key: &str, unit: &str) -> Result<f64, ScenarioError> {
        let text = match &item.value {
            Value::Text(text) | Value::Number(text) => text.as_str(),
            _ => {
                let due = if unit.is_empty() { "a number" } else { "a number with its unit" };
                let problem = ScenarioProblem::WrongType { due };
                return Err(self.document.error(&item.place, &self.path_of(key), problem));
            }
        };
        let quantity = Quantity::parse(text).and_then(|quantity| quantity.to(unit));
        quantity.map_err(|problem| {
            let problem = ScenarioProblem::Quantity(problem);
            self.document.error(&item.place, &self.path_of(key), problem)
        })
    }

    /// A whole number.
    pub fn count(&self, key: &str) -> Result<Option<usize>, ScenarioError> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        let count = match &entry.item.value {
            Value::Number(text) => text.parse().ok(),
            _ => None,
        };
        count.map(Some).ok_or_else(|| self.wrong(key, ScenarioProblem::WrongType { due: "a whole number" }))
    }

    /// A text.
    pub fn text(&self, key: &str) -> Result<Option<(&'a str, &'a Place)>, ScenarioError> {
        match self.entry(key).map(|entry| &entry.item) {
            None => Ok(None),
            Some(Item { value: Value::Text(text), place }) => Ok(Some((text, place))),
            Some(_) => Err(self.wrong(key, ScenarioProblem::WrongType { due: "a text in quotes" })),
        }
    }

    /// One of a few words.
    pub fn word<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<T>, ScenarioError> {
        let Some((text, _)) = self.text(key)? else { return Ok(None) };
        self.meaning(key, text, words).map(Some)
    }

    fn meaning<T: Copy>(&self, key: &str, text: &str, words: &[(&str, T)]) -> Result<T, ScenarioError> {
        let found = words.iter().find(|(word, _)| *word == text).map(|(_, meaning)| *meaning);
        found.ok_or_else(|| {
            let unknown = ScenarioProblem::UnknownWord {
                nearest: nearest(text, words.iter().map(|(word, _)| *word)).map(str::to_owned),
                known: words.iter().map(|(word, _)| (*word).to_owned()).collect(),
            };
            self.wrong(key, unknown)
        })
    }

    /// Rows of quantities in `units`, if the key has an array; a row may be shorter by whole `units`
    /// that are optional.
    pub fn rows(
        &self,
        key: &str,
        units: &[&str],
        form: &'static str,
    ) -> Result<Option<Vec<Vec<f64>>>, ScenarioError> {
        let Some(Item { value: Value::Array(rows), .. }) = self.entry(key).map(|entry| &entry.item) else {
            return Ok(None);
        };
        let row = |row: &Item| match &row.value {
            Value::Array(row) if row.len() == units.len() => {
                row.iter().zip(units).map(|(item, unit)| self.quantity_of(item, key, unit)).collect()
            }
            _ => {
                let problem = ScenarioProblem::WrongType { due: form };
                Err(self.document.error(&row.place, &self.path_of(key), problem))
            }
        };
        rows.iter().map(row).collect::<Result<_, _>>().map(Some)
    }
}

/// `recording[2]` into `recording` and 2.
fn split_index(part: &str) -> (&str, Option<usize>) {
    let inside = part.strip_suffix(']').and_then(|part| part.split_once('['));
    match inside.and_then(|(key, index)| Some((key, index.parse().ok()?))) {
        Some((key, index)) => (key, Some(index)),
        None => (part, None),
    }
}

fn is_key(part: &str) -> bool {
    let key = split_index(part).0;
    !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
}
