//! What an experiment has beside a scenario's keys: lists, tables in lists, and yes or no.

use super::{Entry, Item, Keys, Value};
use crate::scenario::{ScenarioError, ScenarioProblem};

impl<'a> Keys<'a> {
    /// The tables of a list, written `[[key]]` or as a list of `{ … }`; none where the key is not given.
    pub fn tables(&self, key: &str) -> Result<Vec<Keys<'a>>, ScenarioError> {
        let Some(entry) = self.entry(key) else { return Ok(Vec::new()) };
        let due = |item: &Item| {
            let message =
                format!("a list of tables is due; write [[{}]], and the keys under it", self.path_of(key));
            self.document.error(&item.place, &self.path_of(key), ScenarioProblem::Other { message })
        };
        let Value::Array(items) = &entry.item.value else { return Err(due(&entry.item)) };
        let table = |(k, item): (usize, &'a Item)| match &item.value {
            Value::Table(_) => Ok(Keys {
                document: self.document,
                path: format!("{}[{}]", self.path_of(key), k + 1),
                item: Some(item),
                key_place: Some(item.place.clone()),
            }),
            _ => Err(due(item)),
        };
        items.iter().enumerate().map(table).collect()
    }

    /// A text, or a list of texts.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<&'a str>>, ScenarioError> {
        let due = ScenarioProblem::WrongType { due: "a text in quotes, or a list of them," };
        match self.entry(key).map(|entry| &entry.item.value) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(vec![text])),
            Some(Value::Array(items)) => {
                let text = |item: &'a Item| match &item.value {
                    Value::Text(text) => Ok(text.as_str()),
                    _ => Err(self.document.error(&item.place, &self.path_of(key), due.clone())),
                };
                items.iter().map(text).collect::<Result<_, _>>().map(Some)
            }
            Some(_) => Err(self.wrong(key, due)),
        }
    }

    /// One of a few words, or a list of them.
    pub fn words<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<Vec<T>>, ScenarioError> {
        let Some(texts) = self.texts(key)? else { return Ok(None) };
        texts.into_iter().map(|text| self.meaning(key, text, words)).collect::<Result<_, _>>().map(Some)
    }

    /// The keys of the table, in the order of the text.
    pub fn children(&self) -> Vec<String> {
        let Some(Value::Table(entries)) = self.item.map(|item| &item.value) else { return Vec::new() };
        let mut keys: Vec<_> = entries.iter().map(|entry| (&entry.key_place, &entry.key)).collect();
        keys.sort_by_key(|(place, _)| (place.source, place.span.start));
        keys.into_iter().map(|(_, key)| key.clone()).collect()
    }

    /// A list of quantities in `unit`.
    pub fn quantities(&self, key: &str, unit: &str) -> Result<Option<Vec<f64>>, ScenarioError> {
        let Some(items) = self.items(key, "a list of quantities")? else { return Ok(None) };
        items.iter().map(|item| self.quantity_of(item, key, unit)).collect::<Result<_, _>>().map(Some)
    }

    /// A list of whole numbers.
    pub fn counts(&self, key: &str) -> Result<Option<Vec<usize>>, ScenarioError> {
        let due = "a list of whole numbers, such as [1, 3],";
        let Some(items) = self.items(key, due)? else { return Ok(None) };
        let count = |item: &Item| match &item.value {
            Value::Number(text) => text.parse().ok(),
            _ => None,
        };
        let wrong = || self.wrong(key, ScenarioProblem::WrongType { due });
        items.iter().map(|item| count(item).ok_or_else(wrong)).collect::<Result<_, _>>().map(Some)
    }

    /// Yes or no.
    pub fn flag(&self, key: &str) -> Result<Option<bool>, ScenarioError> {
        match self.entry(key).map(|entry| &entry.item.value) {
            None => Ok(None),
            Some(Value::Flag(flag)) => Ok(Some(*flag)),
            Some(_) => Err(self.wrong(key, ScenarioProblem::WrongType { due: "true or false" })),
        }
    }

    /// Whether a key has a list.
    pub fn is_list(&self, key: &str) -> bool {
        self.entry(key).is_some_and(|entry| matches!(entry.item.value, Value::Array(_)))
    }

    /// Whether a key has a text.
    pub fn is_text(&self, key: &str) -> bool {
        self.entry(key).is_some_and(|entry| matches!(entry.item.value, Value::Text(_)))
    }

    fn items(&self, key: &str, due: &'static str) -> Result<Option<&'a [Item]>, ScenarioError> {
        match self.entry(key) {
            None => Ok(None),
            Some(Entry { item: Item { value: Value::Array(items), .. }, .. }) => Ok(Some(items)),
            Some(_) => Err(self.wrong(key, ScenarioProblem::WrongType { due })),
        }
    }
}
