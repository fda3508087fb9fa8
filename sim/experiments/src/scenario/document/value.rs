//! Values of a TOML text, each with its place.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// The place of something.
#[derive(Clone, Debug)]
pub struct Place {
    /// Which of the document's.
    pub source: usize,
    /// Its bytes there.
    pub span: Range<usize>,
}

/// A value at its place.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub place: Place,
    pub value: Value,
}

/// What was written.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    /// Of an integer or a float, as written.
    Number(String),
    Flag(bool),
    /// What no key takes.
    Other,
    Array(Vec<Item>),
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub key_place: Place,
    pub item: Item,
}

impl Item {
    /// The same in a document that has its source at another number.
    pub fn moved(self, source: usize) -> Item {
        let place = |place: Place| Place { source, ..place };
        let value = match self.value {
            Value::Array(items) => Value::Array(items.into_iter().map(|item| item.moved(source)).collect()),
            Value::Table(entries) => Value::Table(
                (entries.into_iter())
                    .map(|Entry { key, key_place, item }| Entry {
                        key,
                        key_place: place(key_place),
                        item: item.moved(source),
                    })
                    .collect(),
            ),
            value => value,
        };
        Item { place: place(self.place), value }
    }
}

/// The keys of a table that was parsed; `place` gives the place of its bytes.
pub(super) fn entries(table: &DeTable, place: &dyn Fn(Range<usize>) -> Place) -> Vec<Entry> {
    let entry = |(key, value): (&toml::Spanned<_>, &toml::Spanned<DeValue>)| {
        let key: (&std::borrow::Cow<str>, _) = (key.get_ref(), place(key.span()));
        let item = Item { place: place(value.span()), value: of(value.get_ref(), place) };
        Entry { key: key.0.to_string(), key_place: key.1, item }
    };
    table.iter().map(entry).collect()
}

/// A value that was parsed, likewise.
pub(super) fn of(value: &DeValue, place: &dyn Fn(Range<usize>) -> Place) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => {
            let digits = number.as_str().replace('_', "");
            match i128::from_str_radix(&digits, number.radix()) {
                Ok(number) => Value::Number(number.to_string()),
                Err(_) => Value::Number(digits),
            }
        }
        DeValue::Float(number) => Value::Number(number.as_str().replace('_', "")),
        DeValue::Array(items) => Value::Array(
            items
                .iter()
                .map(|item| Item { place: place(item.span()), value: of(item.get_ref(), place) })
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(entries(table, place)),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(_) => Value::Other,
    }
}
