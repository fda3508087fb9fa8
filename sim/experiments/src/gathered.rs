//! The experiment of all recordings of a folder: facts of an experiment file, and recordings that come one by one.

use std::path::Path;

use toml::{Table, Value};

use crate::experiment::{Experiment, ExperimentError};

/// Text of the experiment of `files`, each by its path from the experiment file: what `text` says of a file, or else what
/// it says of its last recording, with the file in its place. A text that is no experiment is returned as it is, so that
/// its reader says what is wrong.
pub fn gathered(text: &str, files: &[String]) -> String {
    let Ok(mut table) = text.parse::<Table>() else { return text.to_owned() };
    let stated: Vec<Table> = match table.get("recording") {
        Some(Value::Array(all)) => all.iter().filter_map(Value::as_table).cloned().collect(),
        _ => Vec::new(),
    };
    let Some(last) = stated.last() else { return text.to_owned() };
    let of = |file: &String| {
        let name = |file: &str| Path::new(file).file_name().map(ToOwned::to_owned);
        let is_own = |own: &&Table| own.get("file").and_then(Value::as_str).and_then(name) == name(file);
        let mut own = stated.iter().find(is_own).unwrap_or(last).clone();
        own.insert("file".to_owned(), Value::String(file.clone()));
        Value::Table(own)
    };
    table.insert("recording".to_owned(), Value::Array(files.iter().map(of).collect()));
    toml::to_string(&table).unwrap_or_else(|_| text.to_owned())
}

/// The experiment of `files` with the facts of another one.
/// # Errors
/// As [`Experiment::parse`].
pub fn experiment(path: &Path, text: &str, files: &[String]) -> Result<Experiment, ExperimentError> {
    Experiment::parse(path, &gathered(text, files), &[])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = \"a\"\n[[recording]]\nfile = \"1.csv\"\ntip = \"T\"\nangle = \"0 deg\"\n\
        [[recording]]\nfile = \"2.csv\"\ntip = \"T\"\nangle = \"5 deg\"\n";

    #[test]
    fn a_file_that_is_not_stated_has_the_facts_of_the_last_one() {
        let text = gathered(TEXT, &["/in/1.csv".to_owned(), "3.csv".to_owned()]);
        let table: Table = text.parse().expect("TOML");
        let recordings = table["recording"].as_array().expect("a list");
        let of = |k: usize, key: &str| recordings[k][key].as_str().expect("a text").to_owned();
        assert_eq!(recordings.len(), 2);
        assert_eq!((of(0, "file"), of(0, "angle")), ("/in/1.csv".to_owned(), "0 deg".to_owned()));
        assert_eq!((of(1, "file"), of(1, "angle")), ("3.csv".to_owned(), "5 deg".to_owned()));
        assert_eq!(table["name"].as_str(), Some("a"));
        assert_eq!(gathered("[rod", &["1.csv".to_owned()]), "[rod");
        let experiment = experiment(Path::new("e.toml"), TEXT, &["3.csv".to_owned()]).expect("it is read");
        assert_eq!(experiment.recordings.len(), 1);
    }
}
