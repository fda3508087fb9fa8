//! How the code is laid out: nothing imports upwards, each outside package has one door, models and core know no file,
//! clock, thread or random number, every effect is registered, files stay short, scenarios say what they
//! are for. A rule that is in the way is changed here, with its reason.

mod floors;

use std::collections::BTreeSet;
use std::fs;
use std::iter::Peekable;
use std::path::{Path, PathBuf};
use std::str::Chars;

use models::effects::CATALOGUE;

use floors::CRATES;

/// The files, by the beginning of their path, that may name an outside package. A package of its own
/// kind of work has one door; the two that need more room have a file and a folder of the same name, and
/// Parquet is written in one file and read in two, strictly where it may be anybody's; a test of our own tables reads back
/// what was written. argmin has a file a search.
const DOORS: [(&str, &[&str]); 35] = [
    ("ab_glyph", &["sim/report/src/export/font.rs"]),
    ("argmin", &["sim/experiments/src/analysis/nelder_mead.rs", "sim/experiments/src/analysis/brent.rs"]),
    (
        "arrow",
        &[
            "sim/store/src/columns.rs",
            "sim/store/src/columns/",
            "sim/experiments/src/table.rs",
            "sim/recordings/src/columnar.rs",
        ],
    ),
    ("bytes", &["sim/store/src/columns/", "sim/experiments/src/table.rs", "sim/recordings/src/columnar.rs"]),
    ("clap", &["sim/src/cli.rs", "sim/src/cli/", "tests/src/bin/blind_bench.rs"]),
    ("clap_complete", &["sim/src/cli/completions.rs"]),
    ("clap_mangen", &["sim/src/cli/man.rs"]),
    (
        "csv",
        &[
            "sim/recordings/src/cells.rs",
            "sim/store/src/columns.rs",
            "sim/report/src/export/stored.rs",
            "sim/tests/program/names.rs",
        ],
    ),
    ("comfy_table", &["sim/report/src/aligned.rs"]),
    ("diffsol", &["sim/core/src/integrate/diffsol.rs", "sim/core/src/integrate/diffsol/"]),
    ("gif", &["sim/report/src/export/animated.rs", "sim/tests/program/slides.rs"]),
    ("glob", &["sim/sweeps/src/experiments.rs"]),
    ("hdf5_pure", &["sim/report/src/export/mat.rs", "sim/tests/program/export.rs"]),
    ("indicatif", &["sim/src/cli/progress.rs"]),
    ("base64", &["sim/store/src/sha.rs"]),
    ("mcap", &["sim/report/src/export/mcap.rs", "sim/tests/program/export.rs"]),
    ("miette", &["sim/src/cli/failure.rs"]),
    (
        "multiversion",
        &["models/src/effects/packed.rs", "models/src/rods.rs", "sim/core/src/integrate/side_by_side.rs"],
    ),
    ("numpy", &["sim/python/src/"]),
    ("opener", &["sim/src/cli/browser.rs"]),
    ("os_display", &["sim/store/src/escape.rs"]),
    (
        "parquet",
        &[
            "sim/store/src/columns.rs",
            "sim/store/src/columns/",
            "sim/experiments/src/table.rs",
            "sim/recordings/src/columnar.rs",
        ],
    ),
    ("nuts_rs", &["sim/inference/src/nuts.rs"]),
    ("plotters", &["sim/report/src/picture.rs", "sim/report/src/picture/"]),
    ("pyo3", &["sim/python/src/"]),
    ("rand_chacha", &["tests/src/twin/random.rs"]),
    (
        "rand_xoshiro",
        &[
            "sim/inference/src/normal.rs",
            "sim/inference/src/convergence.rs",
            "sim/inference/src/pressure_line.rs",
            "sim/inference/src/features/",
            "sim/inference/src/predict/errors.rs",
            "sim/inference/src/calibrate/",
            "sim/sweeps/src/design.rs",
            "tests/tests/suite/inverse/small_cases.rs",
        ],
    ),
    ("realfft", &["sim/experiments/src/analysis/spectrum.rs"]),
    ("rerun", &["sim/src/observe/rerun.rs", "sim/src/observe/rerun/"]),
    ("rustix", &["sim/store/src/names.rs", "sim/store/src/partial.rs"]),
    ("sha2", &["sim/store/src/sha.rs"]),
    ("signal_hook", &["sim/src/cli/signals.rs"]),
    ("sobol_burley", &["sim/sweeps/src/design.rs"]),
    ("strsim", &["models/src/nearest.rs"]),
    ("tiny_skia", &["sim/report/src/export/raster.rs", "sim/tests/program/slides.rs"]),
];

/// Packages that are part of the language here: linear algebra, dual numbers, errors, the reading and
/// writing of data, their schemas, parallel loops.
const EVERYWHERE: [&str; 8] =
    ["nalgebra", "num_dual", "rayon", "schemars", "serde", "serde_json", "thiserror", "toml"];

/// What models and core must not name: they are functions of their inputs.
const NOT_BELOW: [&str; 8] = [
    "std::env",
    "std::fs",
    "std::net",
    "std::process",
    "std::thread",
    "std::time::Instant",
    "std::time::SystemTime",
    "rand",
];

const MOST_LINES: usize = 450;
/// Files that are longer, and why.
const LONG: [(&str, &str); 3] = [
    ("models/src/quantity.rs", "half of it tests of its messages"),
    ("models/tests/statics.rs", "one case builder for all closed forms"),
    ("sim/experiments/src/summary.rs", "most of it says what each entry of summary.json means"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files below a folder of the project whose name ends so, with their path from the root and text.
fn files(folder: &str, ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the project") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.to_string_lossy().ends_with(ending) {
                let name = path.strip_prefix(root()).expect("below the root").to_string_lossy();
                found.push((name.replace('\\', "/"), fs::read_to_string(&path).expect("text")));
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "{folder} has files *{ending}");
    found
}

fn sources() -> Vec<(String, String)> {
    ["models", "sim", "tests"].into_iter().flat_map(|member| files(member, ".rs")).collect()
}

/// Every path of a source text, such as `std::fs::read`, with the braces of `use` multiplied out;
/// without comments and string literals.
fn paths(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    walk(&mut text.chars().peekable(), "", &mut found);
    found
}

/// Up to the brace that closes `prefix::{`, or to the end.
fn walk(text: &mut Peekable<Chars>, prefix: &str, found: &mut BTreeSet<String>) {
    let mut last = ' ';
    while let Some(c) = text.next() {
        match c {
            '}' if !prefix.is_empty() => return,
            '/' if text.peek() == Some(&'/') => while text.next().is_some_and(|c| c != '\n') {},
            '"' if last == '#' => while text.next().is_some_and(|c| c != '"' || text.peek() != Some(&'#')) {},
            '"' if last != '\'' => skip_string(text),
            c if c.is_alphabetic() || "_:".contains(c) => {
                let mut path = format!("{prefix}{c}");
                while let Some(c) = text.next_if(|c| c.is_alphanumeric() || "_:".contains(*c)) {
                    path.push(c);
                }
                if path.ends_with("::") && text.next_if_eq(&'{').is_some() {
                    walk(text, &path, found);
                }
                found.insert(path);
            }
            _ => {}
        }
        last = c;
    }
}

fn skip_string(text: &mut Peekable<Chars>) {
    while let Some(c) = text.next() {
        match c {
            '\\' => drop(text.next()),
            '"' => return,
            _ => {}
        }
    }
}

/// Whether a file names an outside package, and not a module of ours that is called the same.
fn names(paths: &BTreeSet<String>, text: &str, package: &str) -> bool {
    let has_own = text.contains(&format!("mod {package};"));
    paths.iter().any(|path| {
        let (outside, path) = path.strip_prefix("::").map_or((false, path.as_str()), |path| (true, path));
        let first = path.split("::").next().unwrap_or_default();
        // Packages of one family, such as diffsol_la.
        let family =
            first == package || first.strip_prefix(package).is_some_and(|rest| rest.starts_with('_'));
        path.contains("::") && family && (outside || !has_own)
    })
}

#[test]
fn paths_are_found_where_they_stand() {
    let text = r#"
        use std::{fs, io::{self, Write}}; // not std::thread::spawn
        /// See clap::Parser.
        const S: &str = "plotters::prelude \" csv::x \\"; const Q: char = '"';
        fn f(x: ::rerun::Y) { argmin::core::go() }
    "#;
    let found = paths(text);
    for path in ["std::fs", "std::io::self", "std::io::Write", "::rerun::Y", "argmin::core::go"] {
        assert!(found.contains(path), "{path} in {found:?}");
    }
    for package in ["clap", "plotters", "csv"] {
        assert!(!names(&found, text, package), "{package} stands in a comment or a string");
    }
    assert!(names(&found, "mod rerun;", "rerun"), ":: leads outside");
    assert!(!names(&paths("rerun::Stream"), "mod rerun;", "rerun"), "a module of ours");
    assert!(names(&paths("use diffsol_la::LinearSolver;"), "", "diffsol"), "of one family");
}

#[test]
fn each_outside_package_has_one_door() {
    for (file, text) in sources() {
        let paths = paths(&text);
        for (package, doors) in DOORS {
            let is_door = doors.iter().any(|door| file.starts_with(door));
            assert!(
                is_door || !names(&paths, &text, package),
                "{file} names {package}, whose door is {}",
                doors[0]
            );
        }
    }
}

#[test]
fn every_dependency_has_a_door_or_is_for_all() {
    let is_own = |package: &str| ["models", "efam"].contains(&package) || package.starts_with("efam_");
    for (member, _) in CRATES {
        let text = fs::read_to_string(root().join(member).join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = text.parse().expect("TOML");
        for package in manifest["dependencies"].as_table().expect("a table").keys() {
            let package = package.replace('-', "_");
            let is_of = |door: &str| package == door || package.split('_').next() == Some(door);
            let has_door = DOORS.iter().any(|(door, _)| is_of(door));
            assert!(
                has_door || EVERYWHERE.contains(&package.as_str()) || is_own(&package),
                "{member}/Cargo.toml: {package} has no door; give it one in DOORS"
            );
        }
    }
}

#[test]
fn models_and_core_know_no_file_clock_thread_or_random_number() {
    for (file, text) in ["models/src", "sim/core/src"].into_iter().flat_map(|folder| files(folder, ".rs")) {
        let paths = paths(&text);
        for name in NOT_BELOW {
            let within = |path: &str| path == name || path.starts_with(&format!("{name}::"));
            // A word alone is no path: `rand` may be anything.
            let named =
                paths.iter().find(|path| path.contains("::") && within(path.trim_start_matches("::")));
            assert!(named.is_none(), "{file} names {named:?}");
        }
    }
}

/// rayon ends a collection into a `Result` by the failure that comes first in time, and leaves out the rest: answers and
/// counts of work would depend on the threads. `inference/src/ordered.rs` says more.
#[test]
fn parallel_parts_are_all_done_and_taken_in_order() {
    const BY_TIME: [&str; 5] =
        ["try_for_each", "try_reduce", "find_any", "collect::<Result", "collect::<Option"];
    const IN_ORDER: [&str; 2] = ["in_order", "collect::<Vec"];
    let has = |statement: &str, words: &[&str]| words.iter().any(|word| statement.contains(word));
    for (file, text) in sources().iter().filter(|(file, _)| !file.starts_with("tests/")) {
        for statement in text.split(';').filter(|own| has(own, &["par_iter", "par_chunks", "par_bridge"])) {
            let is_by_time = has(statement, &BY_TIME) && !has(statement, &IN_ORDER);
            assert!(!is_by_time, "{file}: collect into a Vec first, or by in_order: {statement}");
        }
    }
}

/// Text reaches a terminal through one door, which shows control characters instead of sending them. Arguments are read
/// as they are, for not all are text.
#[test]
fn text_and_arguments_have_one_door() {
    let door = "sim/src/cli/terminal.rs";
    let is_of_the_program = |file: &str| file.contains("/src/") && !file.starts_with("sim/python/");
    let all = files("sim", ".rs").into_iter().filter(|(file, _)| is_of_the_program(file) && file != door);
    for (file, text) in all {
        let own = text.split("#[cfg(test)]").next().unwrap_or_default();
        let is_test = file.contains("/tests");
        for word in ["println!", "print!", "io::stdout", "io::stderr", "stdout().lock", "env::args()"] {
            let calls = own.lines().filter(|line| !line.trim_start().starts_with("//"));
            let found = calls.filter(|line| !is_test && line.contains(word)).find(|line| {
                // `eprintln!` has `println!` in it, and `myprint!` would be another word.
                !line.contains(&format!("\"{word}"))
            });
            assert!(
                found.is_none(),
                "{file}: {found:?}; text goes through {door}, arguments through args_os"
            );
        }
    }
}

#[test]
fn every_effect_is_registered() {
    let of_the_contract =
        ["about", "catalogue", "erased", "instance", "law", "memory", "mod", "packed", "registered"];
    for (file, _) in files("models/src/effects", ".rs") {
        let name = file.rsplit('/').next().and_then(|name| name.strip_suffix(".rs")).expect("a file name");
        let is_registered = CATALOGUE.iter().any(|effect| effect.about().name == name);
        assert!(
            is_registered || of_the_contract.contains(&name),
            "{file}: no effect of this name is registered; add it to catalogue! in effects/mod.rs"
        );
    }
}

/// A long test is left out of the README's command, and of nothing else.
#[test]
fn every_long_test_runs_in_ci() {
    let listed = fs::read_to_string(root().join(".ci/long")).expect("a list");
    let listed: Vec<&str> = listed.lines().filter(|line| !line.starts_with('#')).collect();
    let mut found = 0;
    for folder in ["tests/tests", "sim", "models"] {
        for (file, text) in files(folder, ".rs") {
            for (at, _) in text.match_indices("#[ignore = \"long; .ci/thorough runs it\"]\n") {
                let (_, name) = text[at..].split_once("fn ").expect("a function");
                let name = name.split('(').next().expect("a name");
                let is_listed = listed.iter().any(|line| line.ends_with(&format!("::{name}")));
                assert!(is_listed, "{file}: {name} is long and not in .ci/long: nothing runs it");
                found += 1;
            }
        }
    }
    assert_eq!(found, listed.len(), "tests in .ci/long that are not ignored as long");
}

#[test]
fn files_stay_short() {
    for (file, text) in sources() {
        let lines = text.lines().count();
        let reason = LONG.iter().find(|(long, _)| *long == file);
        assert!(
            lines <= MOST_LINES || reason.is_some(),
            "{file} has {lines} lines; look for the second idea in it"
        );
        assert!(lines > MOST_LINES || reason.is_none(), "{file} is short; it needs no entry in LONG");
    }
}

#[test]
fn every_scenario_says_what_it_is_for() {
    for (file, text) in files("scenarios", ".toml") {
        let head: Vec<_> = text.lines().take_while(|line| line.starts_with('#')).collect();
        let says = |word: &str| head.iter().any(|line| line.starts_with(&format!("# {word}: ")));
        assert!(
            head.first().is_some_and(|line| line.starts_with("# Purpose: ")),
            "{file}: first its purpose"
        );
        assert!(says("Expected"), "{file}: then what to expect of it");
    }
}
