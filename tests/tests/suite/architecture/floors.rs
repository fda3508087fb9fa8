//! Which crate and which module may import which. An arrow that is not drawn here fails; one that nobody needs any more
//! is struck off.

use std::collections::BTreeSet;
use std::fs;

use super::{files, paths, root};

/// Our crates by their folders, from the ground up, each with those of ours that it may depend on.
pub const CRATES: [(&str, &[&str]); 5] = [
    ("models", &[]),
    ("sim/core", &["models"]),
    ("sim/playground", &["efam_core"]),
    ("sim", &["models", "efam_core"]),
    ("sim/python", &["models", "efam_core", "sim"]),
];

/// The modules of the core from the ground up, each with those that it imports.
const CORE: [(&str, &[&str]); 13] = [
    ("integrate", &[]),
    ("levenberg_marquardt", &[]),
    ("point", &[]),
    ("rest", &[]),
    ("initial", &["integrate"]),
    ("pace", &["rest"]),
    ("run", &["initial", "integrate", "point"]),
    ("trajectory", &["integrate", "run"]),
    ("limits", &["rest", "trajectory"]),
    ("observed", &["integrate", "point", "run", "trajectory"]),
    ("forward", &["initial", "integrate", "observed", "run", "trajectory"]),
    ("accuracy", &["forward", "integrate", "rest", "trajectory"]),
    ("stepper", &["forward", "integrate"]),
];

/// The same of sim, without the core's, which all may import.
const SIM: [(&str, &[&str]); 22] = [
    ("schema", &[]),
    ("escape", &[]),
    ("quantile", &[]),
    ("normal", &[]),
    ("memory", &[]),
    ("footer", &[]),
    ("input", &["memory"]),
    ("recording", &["escape", "footer", "memory", "quantile"]),
    ("scenario", &["input"]),
    ("analysis", &["quantile", "scenario"]),
    ("experiment", &["analysis", "escape", "quantile", "recording", "scenario", "schema"]),
    ("cleaning", &["escape", "experiment", "quantile", "recording", "scenario", "schema"]),
    ("calibrate", &["analysis", "cleaning", "experiment", "scenario", "schema"]),
    ("diagnose", &["calibrate", "cleaning", "experiment", "normal", "scenario", "schema"]),
    (
        "predict",
        &[
            "analysis",
            "calibrate",
            "cleaning",
            "experiment",
            "input",
            "normal",
            "quantile",
            "scenario",
            "schema",
        ],
    ),
    ("figures", &["analysis", "calibrate", "experiment", "scenario"]),
    (
        "sweep",
        &[
            "cleaning",
            "diagnose",
            "escape",
            "experiment",
            "input",
            "normal",
            "predict",
            "quantile",
            "scenario",
            "schema",
        ],
    ),
    (
        "results",
        &[
            "analysis",
            "calibrate",
            "cleaning",
            "diagnose",
            "escape",
            "experiment",
            "figures",
            "footer",
            "input",
            "predict",
            "quantile",
            "recording",
            "scenario",
            "schema",
            "sweep",
        ],
    ),
    ("failure", &["calibrate", "experiment", "predict", "recording", "results", "scenario", "sweep"]),
    ("simulate", &["failure", "results", "scenario"]),
    ("observe", &["calibrate", "diagnose", "predict", "quantile"]),
    (
        "cli",
        &[
            "analysis",
            "calibrate",
            "cleaning",
            "diagnose",
            "escape",
            "experiment",
            "failure",
            "figures",
            "input",
            "memory",
            "observe",
            "predict",
            "recording",
            "results",
            "scenario",
            "schema",
            "simulate",
            "sweep",
        ],
    ),
];

/// Arrows of sim that run back up: each is to go.
const UPWARDS: [(&str, &str); 9] = [
    ("input", "results"),
    ("analysis", "experiment"),
    ("experiment", "cleaning"),
    ("experiment", "results"),
    ("cleaning", "results"),
    ("diagnose", "results"),
    ("predict", "results"),
    ("figures", "results"),
    ("sweep", "results"),
];

/// Modules of a crate that a text names without its tests.
fn imports(text: &str) -> BTreeSet<String> {
    let own = text.split("#[cfg(test)]").next().unwrap_or_default();
    let of_crate = |path: &String| {
        let mut parts = path.split("::");
        let is_own = matches!(parts.next(), Some("crate" | "sim"));
        parts.next().filter(|_| is_own).map(str::to_owned)
    };
    paths(own).iter().filter_map(of_crate).collect()
}

/// What a table of modules and the files of a folder disagree in: arrows that are not drawn, drawn ones that nobody
/// needs, and drawn ones that do not lead to a module before.
fn disagreements(
    table: &[(&str, &[&str])],
    upwards: &[(&str, &str)],
    files: &[(String, String)],
) -> Vec<String> {
    let modules: Vec<&str> = table.iter().map(|(module, _)| *module).collect();
    let mut arrows = BTreeSet::new();
    let mut found = Vec::new();
    for (file, text) in files {
        let module = file.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if ["lib", "main"].contains(&module) || file.contains("/tests") {
            continue;
        }
        if !modules.contains(&module) {
            found.push(format!("{module} has no floor"));
        }
        for to in imports(text).iter().filter(|to| modules.contains(&to.as_str()) && *to != module) {
            let is_drawn =
                |(from, to_all): &(&str, &[&str])| *from == module && to_all.contains(&to.as_str());
            if !table.iter().any(is_drawn) && !upwards.contains(&(module, to)) {
                found.push(format!("{file} imports {to}, and no arrow leads there"));
            }
            arrows.insert((module.to_owned(), to.clone()));
        }
    }
    let drawn = table.iter().flat_map(|(from, all)| all.iter().map(move |to| (*from, *to)));
    for (from, to) in drawn.chain(upwards.iter().copied()) {
        if !arrows.contains(&(from.to_owned(), to.to_owned())) {
            found.push(format!("{from} does not import {to} any more: strike the arrow off"));
        }
        let floor = |module: &str| modules.iter().position(|other| *other == module);
        if (floor(to) > floor(from)) != upwards.contains(&(from, to)) {
            found.push(format!("{from} -> {to} does not run as it is drawn"));
        }
    }
    found
}

#[test]
fn crates_depend_on_those_below() {
    let own = ["models", "efam-core", "sim", "tests"];
    for (member, below) in CRATES {
        let text = fs::read_to_string(root().join(member).join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = text.parse().expect("TOML");
        for package in manifest["dependencies"].as_table().expect("a table").keys() {
            let is_below = below.contains(&package.replace('-', "_").as_str());
            assert!(!own.contains(&package.as_str()) || is_below, "{member} must not depend on {package}");
        }
    }
}

#[test]
fn nothing_imports_upwards() {
    let tables: [(&str, &[_], &[_]); 2] = [("sim/core/src/", &CORE, &[]), ("sim/src/", &SIM, &UPWARDS)];
    for (folder, table, upwards) in tables {
        let within = |(file, text): (String, String)| (file.replace(folder, ""), text);
        let files: Vec<_> = files(folder, ".rs").into_iter().map(within).collect();
        let found = disagreements(table, upwards, &files);
        assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
    }
}

#[test]
fn an_arrow_that_is_not_drawn_is_found() {
    let table: [(&str, &[&str]); 2] = [("ground", &[]), ("upper", &["ground"])];
    let house = |ground: &str, upper: &str| {
        let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        disagreements(&table, &[], &[file("ground.rs", ground), file("upper/mod.rs", upper)])
    };
    let used = "use crate::{ground, other};";
    assert_eq!(house("", used), Vec::<String>::new());
    assert_eq!(house("#[cfg(test)] mod tests { use crate::upper::X; }", used), Vec::<String>::new());
    assert!(house("fn f() { crate::upper::x() }", used)[0].starts_with("ground.rs imports upper"));
    assert!(house("", "")[0].ends_with("strike the arrow off"));
}
