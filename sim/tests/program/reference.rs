//! The reference pages of the book that follow from the program: commands, effects, JSON schemas; and the keys.
//!
//! Goal: no page lags behind the code. Expected: each committed page is what the program says today, and the page of
//! keys names every key that the program accepts. To write the pages anew:
//!
//!     EFAM_WRITE_DOCS=1 cargo test --no-default-features reference

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::bench::Bench;

/// The head of a page, with how it is written anew.
fn head(title: &str, says: &str) -> String {
    format!(
        "# {title}\n\n<!-- Generated from the program; do not edit. To write it anew:\n     \
         EFAM_WRITE_DOCS=1 cargo test --no-default-features reference -->\n\n{says}\n"
    )
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/reference")
}

/// Holds a page against the committed one, or writes it.
fn settle(name: &str, text: &str) {
    let path = folder().join(name);
    if std::env::var_os("EFAM_WRITE_DOCS").is_some() {
        fs::write(&path, text).expect("the page can be written");
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    let differs = committed.lines().zip(text.lines()).find(|(was, is)| was != is);
    assert!(
        committed == text,
        "docs/src/reference/{name} lags behind the program, first at {differs:?}; write it anew:\n    \
         EFAM_WRITE_DOCS=1 cargo test --no-default-features reference"
    );
}

/// What a command that must succeed prints.
fn printed(bench: &Bench, arguments: &[&str]) -> String {
    let output = bench.command(arguments).env("COLUMNS", "100").output().expect("efam runs");
    assert!(output.status.success(), "efam {}", arguments.join(" "));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Text for a cell of a table.
fn cell(text: &str) -> String {
    text.split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .replace('|', "\\|")
        .replace('<', "&lt;")
        .replace("[`", "`")
        .replace("`]", "`")
}

fn texts(value: &Value) -> impl Iterator<Item = &str> {
    value.as_array().into_iter().flatten().filter_map(Value::as_str)
}

/// A number as briefly as it goes.
fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(own) if own != 0.0 && !(1e-3..1e5).contains(&own.abs()) => format!("{own:e}"),
        Some(own) => format!("{own}"),
        None => String::new(),
    }
}

#[test]
fn commands() {
    let bench = Bench::new("reference-commands");
    printed(&bench, &["man", "--out", "pages"]);
    let mut names: Vec<String> = (fs::read_dir(bench.0.join("pages")).expect("pages"))
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .map(|file| file.trim_end_matches(".1").replace('-', " "))
        .collect();
    names.sort();
    let says = "The help of every command. `efam COMMAND --help` prints the same.";
    let mut page = head("Commands", says);
    for name in names {
        let mut words: Vec<&str> = name.split(' ').skip(1).collect();
        words.push("--help");
        let help = printed(&bench, &words);
        let lines: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
        write!(page, "\n## {name}\n\n```text\n{}\n```\n", lines.join("\n")).expect("a string");
    }
    settle("commands.md", &page);
}

#[test]
fn effects() {
    let bench = Bench::new("reference-effects");
    let all: Value = serde_json::from_str(&printed(&bench, &["effects", "--json"])).expect("JSON");
    let effects = all["effects"].as_array().expect("a list");
    let list = printed(&bench, &["effects"]);
    let kinds = list.lines().filter(|line| !line.starts_with(' ')).filter_map(|line| line.split_once(": "));
    let says = "The catalogue, kind by kind. A scenario switches an effect on by `[effects.NAME]`. Values are in SI \
                units.\n`efam effects NAME` prints the page of one. [Effects and laws](../theory/effects.md) explains the \
                terms.";
    let (mut page, mut told) = (head("Catalogue of effects", says), 0);
    for (kind, title) in kinds {
        write!(page, "\n## {kind}: {title}\n").expect("a string");
        for effect in effects.iter().filter(|effect| effect["kind"] == kind) {
            told += 1;
            effect_section(&mut page, &bench, effect);
        }
    }
    assert_eq!(told, effects.len(), "every effect is of a kind that the list names");
    settle("effects.md", &page);
}

fn effect_section(page: &mut String, bench: &Bench, effect: &Value) {
    let name = effect["name"].as_str().expect("a name");
    write!(page, "\n### {name}\n\n").expect("a string");
    let parameters = effect["parameters"].as_array().expect("a list");
    if !parameters.is_empty() {
        page.push_str(
            "| parameter | meaning | unit | default | range | null value |\n|---|---|---|---|---|---|\n",
        );
    }
    for own in parameters {
        let text = |key: &str| cell(own[key].as_str().expect("a text"));
        let range = format!("{} to {}", number(&own["range"][0]), number(&own["range"][1]));
        let (default, off) = (number(&own["default"]), number(&own["null_value"]));
        let row = [&format!("`{}`", text("name")), &text("meaning"), &text("unit"), &default, &range, &off];
        writeln!(page, "| {} |", row.map(String::as_str).join(" | ")).expect("a string");
    }
    if !parameters.is_empty() {
        page.push('\n');
    }
    writeln!(page, "Sign in a release: {}.", cell(effect["signature"].as_str().expect("a text")))
        .expect("a string");
    let similar: Vec<String> = texts(&effect["confounded_with"]).map(|own| format!("`{own}`")).collect();
    if !similar.is_empty() {
        write!(page, "\nEasily confounded with: {}.\n", similar.join(", ")).expect("a string");
    }
    let own = printed(bench, &["effects", name]);
    let lines: Vec<&str> = own.trim_end().lines().map(str::trim_end).collect();
    write!(page, "\n```text\n{}\n```\n", lines.join("\n")).expect("a string");
}

#[test]
fn schemas() {
    let bench = Bench::new("reference-schemas");
    let all: Value = serde_json::from_str(&printed(&bench, &["schema"])).expect("JSON");
    let says = "The entries of the object that each command prints with `--json`. The same types make the JSON files in \
                a run\nfolder. `efam schema COMMAND` prints the JSON Schema (2020-12). Entries marked * may be absent. \
                Entries may be\nadded from version to version.";
    let mut page = head("JSON schemas", says);
    let mut before: Vec<(String, Map<String, Value>)> = Vec::new();
    for (command, schema) in all.as_object().expect("an object") {
        write!(page, "\n## efam {command}\n\n").expect("a string");
        let mut schema = schema.as_object().expect("a schema").clone();
        schema.remove("title");
        if let Some((same, _)) = before.iter().find(|(_, own)| *own == schema) {
            writeln!(page, "The same as of `efam {same}`.").expect("a string");
            continue;
        }
        let types = schema.get("$defs").and_then(Value::as_object).cloned().unwrap_or_default();
        schema_section(&mut page, &Value::Object(schema.clone()));
        for (name, own) in &types {
            write!(page, "\n**{name}**\n\n").expect("a string");
            schema_section(&mut page, own);
        }
        before.push((command.clone(), schema));
    }
    settle("schemas.md", &page);
}

/// A type: its description, and a row for each entry.
fn schema_section(page: &mut String, schema: &Value) {
    if let Some(says) = schema["description"].as_str() {
        writeln!(page, "{}\n", cell(says)).expect("a string");
    }
    let alternatives = ["anyOf", "oneOf"].into_iter().find_map(|key| schema[key].as_array());
    if let Some(all) = alternatives {
        for own in all {
            let says = own["description"].as_str().map_or(String::new(), |says| format!(": {}", cell(says)));
            writeln!(page, "- {}{says}", kind(own)).expect("a string");
        }
        if all.iter().any(|own| own.get("properties").is_some()) {
            page.push('\n');
        }
    }
    let mut rows = Vec::new();
    alternatives.into_iter().flatten().chain([schema]).for_each(|own| entries(own, "", &mut rows));
    if rows.is_empty() {
        if alternatives.is_none() {
            writeln!(page, "{}", kind(schema)).expect("a string");
        }
        return;
    }
    page.push_str("| entry | type | meaning |\n|---|---|---|\n");
    for [name, kind, says] in rows {
        writeln!(page, "| `{name}` | {kind} | {says} |").expect("a string");
    }
}

/// The entries of an object, and of objects within it.
fn entries(schema: &Value, path: &str, rows: &mut Vec<[String; 3]>) {
    let required: BTreeSet<&str> = texts(&schema["required"]).collect();
    for (key, own) in schema["properties"].as_object().into_iter().flatten() {
        let name = format!("{path}{key}");
        let star = if required.contains(key.as_str()) { "" } else { " *" };
        let says = cell(own["description"].as_str().unwrap_or_default());
        rows.push([name.clone(), format!("{}{star}", kind(own)), says]);
        entries(own, &format!("{name}."), rows);
        entries(&own["items"], &format!("{name}[]."), rows);
    }
}

/// The type of a value in words.
fn kind(schema: &Value) -> String {
    if let Some(name) = schema["$ref"].as_str() {
        return format!("**{}**", name.rsplit('/').next().unwrap_or(name));
    }
    if let Some(all) = ["anyOf", "oneOf"].into_iter().find_map(|key| schema[key].as_array()) {
        return all.iter().map(kind).collect::<Vec<_>>().join(" or ");
    }
    if let Some(value) = schema.get("const") {
        return format!("`{value}`");
    }
    if let Some(all) = schema["enum"].as_array() {
        return all.iter().map(|own| format!("`{own}`")).collect::<Vec<_>>().join(", ");
    }
    let one = |name: &str| match name {
        "array" => match (&schema["items"], schema["prefixItems"].as_array(), schema["maxItems"].as_u64()) {
            (_, Some(all), _) => format!("({})", all.iter().map(kind).collect::<Vec<_>>().join(", ")),
            (items, None, Some(count)) => format!("list of {count}: {}", kind(items)),
            (items, None, None) => format!("list of {}", kind(items)),
        },
        "object" if schema.get("additionalProperties").is_some_and(Value::is_object) => {
            format!("object with values of {}", kind(&schema["additionalProperties"]))
        }
        name => name.to_owned(),
    };
    match &schema["type"] {
        Value::String(name) => one(name),
        Value::Array(names) => {
            names.iter().filter_map(Value::as_str).map(one).collect::<Vec<_>>().join(" or ")
        }
        _ => "any".to_owned(),
    }
}

/// A file with a key that nobody knows in each of its sections, and the command that reads it.
const SECTIONS: [(&str, &str, &str); 13] = [
    ("statics", "zz = 1\n[rod]\nlength = \"1 m\"", "Scenarios"),
    ("statics", "[muscle]\nzz = 1", "`[muscle]`"),
    ("statics", "[rod]\nzz = 1", "`[rod]`"),
    ("statics", "[release]\nzz = 1", "`[release]`"),
    ("statics", "[run]\nzz = 1", "`[run]`"),
    ("statics", "[integrator]\nzz = 1", "`[integrator]`"),
    ("statics", "[release]\nhistory = { zz = 1 }", "`[release]`"),
    ("experiment check", "zz = 1", "Experiments"),
    ("experiment check", "[[recording]]\nzz = 1", "`[[recording]]`"),
    ("experiment check", "[[recording]]\nfile = \"a\"\ntip = \"t\"\npayload = { zz = 1 }", "`[[recording]]`"),
    ("sweep", "zz = 1", "Sweeps"),
    ("sweep", "[sweep]\nzz = 1", "Sweeps"),
    (
        "sweep",
        "[sweep]\nscenario = \"s.toml\"\ndesign = \"grid\"\n[[sweep.parameter]]\nzz = 1",
        "`[sweep]`, over a scenario",
    ),
];

/// The same in a worked example, where recordings are read first.
const OVERRIDES: [(&str, &str); 2] =
    [("calibrate.zz=1", "`[calibrate]`"), ("calibrate.parameter=[{zz=1}]", "`[[calibrate.parameter]]`")];

/// The page of keys is written by hand. What the program offers in place of a wrong key has to be on it, in the
/// section of that key.
#[test]
fn keys() {
    let page = fs::read_to_string(folder().join("keys.md")).expect("the page");
    let bench = Bench::new("reference-keys");
    bench.file("s.toml", "[rod]\nlength = \"1 m\"\nmass = \"1 g\"\nbending_stiffness = \"1 N m^2\"\n");
    for (command, text, heading) in SECTIONS {
        bench.file("wrong.toml", text);
        let arguments: Vec<&str> = command.split(' ').chain(["wrong.toml"]).collect();
        hold(&page, heading, &bench.run(&arguments));
    }
    let example = folder().join("../../../scenarios/diagnosis/nothing/experiment.toml");
    for (set, heading) in OVERRIDES {
        let arguments = ["calibrate", example.to_str().expect("UTF-8"), "--set", set];
        hold(&page, heading, &bench.run(&arguments));
    }
}

/// Holds the keys that a message offers against a section of the page.
fn hold(page: &str, heading: &str, (code, _, message): &(i32, String, String)) {
    assert_eq!(*code, 2, "{heading}\n{message}");
    let known = known(message);
    assert!(known.len() >= 2, "{heading}\n{message}");
    let start = page.find(&format!("# {heading}\n")).unwrap_or_else(|| panic!("a heading {heading}"));
    let level = page[..=start].chars().rev().take_while(|c| *c == '#').count();
    let section = &page[start + 1..];
    let end = (1..=level).filter_map(|level| section.find(&format!("\n{} ", "#".repeat(level)))).min();
    let section = &section[..end.unwrap_or(section.len())];
    for key in known {
        let stands = ["`{}`", "[{}]", "[{}."].map(|form| form.replace("{}", &key));
        assert!(stands.iter().any(|own| section.contains(own)), "keys.md, {heading}: `{key}` is missing");
    }
}

/// The keys that a message offers.
fn known(message: &str) -> Vec<String> {
    let flat = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let list = flat.split("known here are ").nth(1).unwrap_or_default();
    list.split(", ").map(str::to_owned).filter(|own| !own.is_empty()).collect()
}

/// A number of the inference that is chosen and not computed: its place, its name, its value, and why.
struct Chosen {
    file: String,
    name: String,
    value: String,
    why: String,
}

/// The numbers of a file, without those of its tests. One without words of its own has those of the line before.
fn chosen(file: &str, text: &str) -> Vec<Chosen> {
    let mut all: Vec<Chosen> = Vec::new();
    let mut why: Vec<&str> = Vec::new();
    for line in text.lines().take_while(|line| !line.starts_with("#[cfg(test)]")).map(str::trim) {
        if let Some(words) = line.strip_prefix("///") {
            why.push(words.trim());
            continue;
        }
        let number = line.split_once("const ").and_then(|(_, rest)| {
            let (name, rest) = rest.split_once(": ")?;
            let (kind, value) = rest.strip_suffix(';')?.split_once(" = ")?;
            ["f64", "usize", "u32", "i32"].contains(&kind).then_some((name, value))
        });
        if let Some((name, value)) = number {
            let before = || all.last().map_or(String::new(), |before| before.why.clone());
            let why = if why.is_empty() { before() } else { why.join(" ") };
            let [file, name, value] = [file, name, value].map(str::to_owned);
            all.push(Chosen { file, name, value, why });
        }
        why.clear();
    }
    all
}

/// Every number of the calibration and the diagnosis that somebody chose, with its reason.
#[test]
fn the_page_of_chosen_numbers_is_that_of_the_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("inference/src");
    let mut all = Vec::new();
    for folder in ["calibrate", "diagnose", "features"] {
        let entries = fs::read_dir(root.join(folder)).expect("a folder").flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.sort();
        for file in files.iter().filter(|file| file.is_file()) {
            let name = format!("{folder}/{}", file.file_name().expect("a name").to_string_lossy());
            all.extend(chosen(&name, &fs::read_to_string(file).expect("a file")));
        }
    }
    let normal = chosen("normal.rs", &fs::read_to_string(root.join("normal.rs")).expect("a file"));
    all.extend(normal.into_iter().filter(|own| !own.name.starts_with("NORMAL")));
    let loss = root.join("../../core/src/loss.rs");
    all.extend(chosen("core/loss.rs", &fs::read_to_string(loss).expect("a file")));
    // What is computed from others is not chosen.
    let names: Vec<String> = all.iter().map(|own| own.name.clone()).collect();
    let word = |c: char| !(c.is_alphanumeric() || c == '_');
    all.retain(|own| !own.value.split(word).any(|part| names.iter().any(|name| name == part)));
    let without: Vec<_> = all.iter().filter(|own| own.why.is_empty()).map(|own| &own.name).collect();
    assert!(without.is_empty(), "numbers without a reason: {without:?}");
    let says = format!(
        "Calibration and diagnosis have {} numbers that are chosen and not computed: thresholds, limits of a search, \
         tolerances. Each has its reason in the code, from physics or statistics.",
        all.len()
    );
    let mut text = head("Chosen numbers", &says);
    let mut folder = "";
    for Chosen { file, name, value, why } in &all {
        let stem = file.trim_end_matches(".rs");
        let (own, module) = stem.split_once('/').unwrap_or(("inference", stem));
        if own != folder {
            let _ = writeln!(
                text,
                "\n## {own}\n\n| number | value | file | what it is, and why |\n|---|---|---|---|"
            );
            folder = own;
        }
        let _ = writeln!(text, "| `{name}` | {} | {module} | {} |", cell(value), cell(why));
    }
    settle("chosen-numbers.md", &text);
}
