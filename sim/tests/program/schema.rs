//! What `--json` prints, against the schema that `efam schema` publishes.
//!
//! Goal: who writes a program after the schema can read what ours prints. Expected: every entry that is printed is
//! described, every entry that must be there is, and each is of its type. The check here is stricter than
//! JSON Schema: an entry that is not described is an error, and so is a keyword that it does not know.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::bench::Bench;
use crate::sweep_experiments::example;

/// Keywords that describe, and bind nobody.
const WORDS: [&str; 6] = ["$schema", "title", "description", "format", "default", "$defs"];

/// What is wrong with a value, at its place.
fn wrong(root: &Value, schema: &Value, value: &Value, at: &str) -> Option<String> {
    let Some(keywords) = schema.as_object() else {
        return (schema != true).then(|| format!("{at}: {schema} is no schema"));
    };
    let deeper = |schema: &Value, value: &Value, at: &str| wrong(root, schema, value, at);
    let list = |of: &Value| of.as_array().cloned().unwrap_or_default();
    for (keyword, rule) in keywords {
        let found = match keyword.as_str() {
            "$ref" => {
                let path = rule.as_str().and_then(|path| path.strip_prefix('#')).expect("within the schema");
                deeper(root.pointer(path).unwrap_or_else(|| panic!("{at}: no {path}")), value, at)
            }
            "anyOf" | "oneOf" => {
                let all: Vec<_> = list(rule).iter().map(|schema| deeper(schema, value, at)).collect();
                (!all.contains(&None)).then(|| format!("{at}: none of {all:?}"))
            }
            "const" => (rule != value).then(|| format!("{at}: {value} is not {rule}")),
            "enum" => (!list(rule).contains(value)).then(|| format!("{at}: {value} is not in {rule}")),
            "type" => {
                let names = if rule.is_array() { list(rule) } else { vec![rule.clone()] };
                let fits = names.iter().any(|name| is_of(value, name.as_str().expect("a name")));
                (!fits).then(|| format!("{at}: {value} is not of type {rule}"))
            }
            "minimum" => value
                .as_f64()
                .filter(|own| *own < rule.as_f64().expect("a number"))
                .map(|own| format!("{at}: {own} is less than {rule}")),
            "required" => (list(rule).iter())
                .find(|key| value.is_object() && value.get(key.as_str().expect("a key")).is_none())
                .map(|key| format!("{at}: {key} is missing")),
            "properties" => value.as_object().and_then(|object| {
                object.iter().find_map(|(key, own)| {
                    match (rule.get(key), keywords.get("additionalProperties")) {
                        (Some(rule), _) => deeper(rule, own, &format!("{at}.{key}")),
                        (None, Some(_)) => None,
                        (None, None) => Some(format!("{at}.{key} is not described")),
                    }
                })
            }),
            "additionalProperties" => value.as_object().and_then(|object| {
                let known =
                    |key: &String| keywords.get("properties").is_some_and(|own| own.get(key).is_some());
                let others = object.iter().filter(|(key, _)| !known(key));
                others.map(|(key, own)| deeper(rule, own, &format!("{at}.{key}"))).find_map(|found| found)
            }),
            "items" => value.as_array().and_then(|all| {
                let first = keywords.get("prefixItems").map_or(0, |own| list(own).len());
                let rest = all.iter().enumerate().skip(first);
                rest.map(|(k, own)| deeper(rule, own, &format!("{at}[{k}]"))).find_map(|found| found)
            }),
            "prefixItems" => value.as_array().and_then(|all| {
                let pairs = list(rule).into_iter().zip(all);
                pairs.map(|(rule, own)| deeper(&rule, own, at)).find_map(|found| found)
            }),
            "minItems" | "maxItems" => value.as_array().and_then(|all| {
                let (count, bound) = (all.len() as u64, rule.as_u64().expect("a count"));
                let fits = if keyword == "minItems" { count >= bound } else { count <= bound };
                (!fits).then(|| format!("{at}: {count} items, and {keyword} is {bound}"))
            }),
            word if WORDS.contains(&word) => None,
            _ => Some(format!("{at}: this check does not know the keyword {keyword}")),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn is_of(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => panic!("{name} is no type of JSON"),
    }
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn what_is_printed_fits_its_schema() {
    let bench = Bench::new("schema");
    for name in ["nothing", "air-drag"] {
        example(&bench, name, name);
    }
    let path = |name: &str| bench.0.join(name).display().to_string();
    let (nothing, recording) = (path("nothing/experiment.toml"), path("nothing/15psi-1.csv"));
    let drag = path("air-drag/experiment.toml");
    let muscle = "[muscle]\nname = \"garbulinski-2022\"\n[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n";
    bench.file("s.toml", &format!("{muscle}[run]\nduration = \"4 s\"\n"));
    bench.file("short.toml", &format!("{muscle}[run]\nduration = \"0.1 s\"\n"));
    let at = |file: &'static str| [file, "--pressure", "15psi"];
    let schemas = bench.json(&["schema"]);
    // A class of two, and one more, so that it does not take long.
    let catalogue = bench.json(&["effects", "--json"]);
    let names =
        catalogue["effects"].as_array().expect("a list").iter().filter_map(|own| own["name"].as_str());
    let others = names.filter(|name| !["air_drag", "tip_drag", "viscoelastic"].contains(name));
    let without: Vec<&str> = others.flat_map(|name| ["--without", name]).collect();
    let mut tried = BTreeSet::new();
    let mut try_one = |command: &str, arguments: &[&str]| {
        let words: Vec<&str> = command.split(' ').collect();
        let printed = bench.json(&[&words, arguments, &["--json"]].concat());
        let schema = schemas.get(command).unwrap_or_else(|| panic!("{command} has no schema"));
        if let Some(wrong) = wrong(schema, schema, &printed, command) {
            panic!("{command} {arguments:?}: {wrong}");
        }
        tried.insert(command.to_owned());
        // What is requested alone is the same.
        assert_eq!(bench.json(&[&["schema"], &words[..]].concat()), *schema);
    };
    try_one("simulate", &at("s.toml"));
    try_one("simulate", &[&at("short.toml")[..], &["--trajectory=nodes"]].concat());
    try_one("simulate", &["s.toml", "--set", "muscle.pressure=all rows", "--set", "run.duration=0.1 s"]);
    try_one("calibrate", &[&nothing, "--profile", "--set", "rod.nodes=16"]);
    try_one("diagnose", &[&[drag.as_str(), "--most", "1"], &without[..]].concat());
    // A rod that does not move shows nothing of drag: infinite strengths.
    let still = ["--plan", "s.toml", "--set", "muscle.pressure=15 psi", "--set", "release.from=equilibrium"];
    try_one("diagnose", &still);
    try_one("predict", &["--muscle", "garbulinski-2022", "--pressure", "15psi", "--duration", "3 s"]);
    let grid = ["--pressure", "15psi,40psi", "--payload", "0g..80g:3", "--duration", "2 s"];
    try_one("predict", &[&["--muscle", "garbulinski-2022"], &grid[..]].concat());
    let simulated = |name: &str, pressure: &str| {
        bench.json(&["simulate", "short.toml", "--pressure", pressure, "--json", "--out", name]);
    };
    simulated("first", "15psi");
    simulated("second", "40psi");
    try_one("report", &["first", "second"]);
    try_one("export", &["first", "--to", "mat"]);
    try_one("figures", &["--set", "run.duration=3 s", "--set", "integrator.tolerance=1e-4"]);
    let design = "[sweep]\nscenario = \"short.toml\"\ndesign = \"grid\"\n[[sweep.parameter]]\npath = \"muscle.pressure\"\n";
    bench.file("sweep.toml", &format!("{design}values = [\"15 psi\", \"400 psi\"]\n"));
    try_one("sweep", &["sweep.toml", "--out", "swept"]);
    try_one("sweep plan", &["sweep.toml", "--out", "plan", "--points-per-shard", "1"]);
    try_one("sweep run", &["--plan", "plan", "--shard", "1"]);
    try_one("sweep status", &["--plan", "plan"]);
    try_one("sweep submit", &["--plan", "plan", "--dry-run"]);
    try_one("sweep run", &["--plan", "plan"]);
    try_one("sweep merge", &["--plan", "plan"]);
    let named: Vec<String> = without.iter().skip(1).step_by(2).map(|name| format!("{name:?}")).collect();
    let settings = format!("diagnose = {{ most = 1, without = [{}] }}", named.join(", "));
    bench.file("diagnoses.toml", &format!("[sweep]\nexperiments = [{drag:?}]\n{settings}\n"));
    try_one("sweep plan", &["diagnoses.toml", "--out", "diagnoses"]);
    try_one("sweep", &["diagnoses.toml", "--out", "diagnoses"]);
    try_one("effects", &[]);
    try_one("effects", &["viscoelastic"]);
    try_one("experiment init", &[&recording, "--out", "e.toml"]);
    try_one("experiment check", &[&nothing]);
    try_one("analyse", &[&nothing, "--nodes", "8"]);
    try_one("inspect", &[&recording]);
    try_one("statics", &at("s.toml"));
    try_one("modes", &at("s.toml"));
    try_one("linearise", &[&at("s.toml")[..], &["--reduce", "2", "--sample", "10ms"]].concat());
    try_one("doctor", &[]);
    let published: BTreeSet<_> = schemas.as_object().expect("an object").keys().cloned().collect();
    assert_eq!(tried, published);
}

#[test]
fn the_check_finds_what_is_wrong() {
    let schema = json!({
        "type": "object",
        "properties": { "a": { "$ref": "#/$defs/A" }, "b": { "items": { "type": ["integer", "null"] }, "maxItems": 2 } },
        "required": ["a"],
        "$defs": { "A": { "anyOf": [{ "const": "x" }, { "type": "number", "minimum": 0 }] } },
    });
    let says = |value: Value| wrong(&schema, &schema, &value, "it").unwrap_or_default();
    for right in [json!({ "a": "x", "b": [1, null] }), json!({ "a": 0.5 })] {
        assert_eq!(says(right), "");
    }
    assert!(says(json!({ "a": "y" })).starts_with("it.a: none of "));
    assert!(says(json!({ "a": -1 })).contains("-1 is less than 0"));
    assert_eq!(says(json!({ "b": [] })), "it: \"a\" is missing");
    assert_eq!(says(json!({ "a": 1, "c": 1 })), "it.c is not described");
    assert!(says(json!({ "a": 1, "b": [0.5] })).starts_with("it.b[0]: 0.5 is not of type "));
    assert!(says(json!({ "a": 1, "b": [1, 2, 3] })).starts_with("it.b: 3 items"));
    assert!(wrong(&schema, &json!({ "pattern": "x" }), &json!(1), "it").is_some(), "an unknown keyword");
}

#[test]
fn what_has_no_schema_is_said() {
    let bench = Bench::new("schema-wrong");
    let (code, stdout, stderr) = bench.run(&["schema", "simulat"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(
        stderr.starts_with("error: no JSON printed by `simulat`; did you mean `simulate`?; there are "),
        "{stderr}"
    );
}
