//! Goal: what the README shows can be used as it stands.
//! Expected: every ```toml block in it is a scenario that is read without an error, and every file of
//! the project that it names is there.

use std::path::Path;

use sim::scenario::Scenario;

const README: &str = include_str!("../../../README.md");

/// Bodies of the fenced blocks of TOML.
fn scenarios() -> impl Iterator<Item = &'static str> {
    README.split("```toml\n").skip(1).map(|part| part.split("```").next().expect("a block ends"))
}

#[test]
fn its_scenarios_are_scenarios() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    assert!(scenarios().count() > 0, "there is one");
    for text in scenarios() {
        let scenario = Scenario::parse(&root.join("README.md"), text, &[]);
        let cases = scenario.and_then(|scenario| scenario.cases());
        assert!(cases.is_ok(), "{}\n{text}", cases.err().map_or(String::new(), |error| error.to_string()));
    }
}

#[test]
fn its_files_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let named = README.split(['`', '(', ')', ' ', '\n']).filter(|word| {
        let ending = word.rsplit('.').next().unwrap_or_default();
        ["scenarios/", "models/", "sim/", "tests/"].iter().any(|folder| word.starts_with(folder))
            && ["rs", "toml"].contains(&ending)
            && !word.contains('*')
    });
    let missing: Vec<_> = named.filter(|file| !root.join(file).is_file()).collect();
    assert!(missing.is_empty(), "README.md names {missing:?}");
}
