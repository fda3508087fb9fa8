//! Which crate and which module may import which. An arrow that is not drawn here fails; one that nobody needs any more
//! is struck off.

use std::collections::BTreeSet;
use std::fs;

use super::{files, paths, root};

/// Our crates by their folders, from the ground up, each with those of ours that it depends on.
pub const CRATES: [(&str, &[&str]); 11] = [
    ("models", &[]),
    ("sim/core", &["models"]),
    ("sim/playground", &["efam_core"]),
    ("sim/store", &[]),
    ("sim/recordings", &["efam_core", "efam_store"]),
    ("sim/experiments", &["efam_core", "efam_recordings", "efam_store", "models"]),
    ("sim/inference", &["efam_core", "efam_experiments", "efam_store", "models"]),
    ("sim/sweeps", &["efam_core", "efam_experiments", "efam_inference", "efam_store", "models"]),
    (
        "sim/report",
        &[
            "efam_core",
            "efam_experiments",
            "efam_inference",
            "efam_recordings",
            "efam_store",
            "efam_sweeps",
            "models",
        ],
    ),
    (
        "sim",
        &[
            "efam_core",
            "efam_experiments",
            "efam_inference",
            "efam_recordings",
            "efam_report",
            "efam_store",
            "efam_sweeps",
            "models",
        ],
    ),
    (
        "sim/python",
        &[
            "efam_core",
            "efam_experiments",
            "efam_inference",
            "efam_recordings",
            "efam_report",
            "efam_store",
            "efam_sweeps",
            "models",
            "efam",
        ],
    ),
];

/// The modules of a crate by its folder, from the ground up, each with those that it imports.
type Floors = (&'static str, &'static [(&'static str, &'static [&'static str])]);

const FLOORS: [Floors; 5] = [
    (
        "sim/core/src/",
        &[
            ("integrate", &[]),
            ("levenberg_marquardt", &[]),
            ("linear", &[]),
            ("loss", &[]),
            ("point", &[]),
            ("quantile", &[]),
            ("rest", &[]),
            ("initial", &["integrate"]),
            ("pace", &["rest"]),
            ("work", &["integrate"]),
            ("run", &["initial", "integrate", "point", "work"]),
            ("trajectory", &["integrate", "run"]),
            ("left_out", &[]),
            ("limits", &["rest", "trajectory"]),
            ("observed", &["integrate", "point", "run", "trajectory"]),
            ("forward", &["initial", "integrate", "observed", "rest", "run", "trajectory"]),
            ("accuracy", &["forward", "integrate", "rest", "trajectory"]),
            ("stepper", &["forward", "integrate"]),
            ("example", &["forward", "trajectory"]),
        ],
    ),
    (
        "sim/store/src/",
        &[
            ("escape", &[]),
            ("footer", &[]),
            ("names", &[]),
            ("memory", &[]),
            ("sha", &[]),
            ("utc", &[]),
            ("input", &["memory", "sha"]),
            ("columns", &["escape", "footer", "input"]),
            ("disk", &[]),
            ("manifest", &["disk", "sha"]),
            ("error", &["manifest"]),
            ("partial", &["disk", "names", "manifest"]),
            ("atomic", &["disk", "partial"]),
            ("added", &["atomic", "disk", "manifest", "partial"]),
            ("folder", &["disk", "names", "manifest", "partial", "sha", "utc"]),
        ],
    ),
    (
        "sim/experiments/src/",
        &[
            ("kind", &[]),
            ("release", &[]),
            ("scenario", &[]),
            ("error", &["scenario"]),
            ("analysis", &["release", "scenario"]),
            ("experiment", &["error", "scenario"]),
            ("gathered", &["experiment"]),
            ("cleaning", &["error", "experiment", "release", "scenario"]),
            ("init", &["cleaning", "experiment", "scenario"]),
            ("drive", &[]),
            ("table", &["drive"]),
            ("events", &["analysis", "drive"]),
            ("summary", &["analysis", "drive", "events"]),
            ("analyse", &["analysis", "cleaning", "experiment", "summary"]),
        ],
    ),
    (
        "sim/inference/src/",
        &[
            ("example", &[]),
            ("listed", &[]),
            ("normal", &[]),
            ("ordered", &[]),
            ("convergence", &[]),
            ("nuts", &[]),
            ("calibrate", &["convergence", "listed", "normal", "nuts", "ordered"]),
            ("pressure_line", &["calibrate"]),
            ("features", &["normal"]),
            ("diagnose", &["calibrate", "features", "listed", "normal"]),
            ("predict", &["calibrate", "normal", "ordered"]),
        ],
    ),
    (
        "sim/src/",
        &[
            ("failure", &[]),
            ("observe", &[]),
            ("catalogue", &["failure"]),
            ("figures", &["failure"]),
            ("rest", &[]),
            ("simulate", &["failure"]),
            ("cli", &["catalogue", "failure", "figures", "observe", "rest", "simulate"]),
        ],
    ),
];

/// Modules of a crate that a text names without its tests.
fn imports(text: &str) -> BTreeSet<String> {
    let own = text.split("#[cfg(test)]").next().unwrap_or_default();
    let of_crate = |path: &String| {
        let mut parts = path.split("::");
        let is_own = matches!(parts.next(), Some("crate" | "efam"));
        parts.next().filter(|_| is_own).map(str::to_owned)
    };
    paths(own).iter().filter_map(of_crate).collect()
}

/// What a table of modules and the files of a folder disagree in: arrows that are not drawn, drawn ones that nobody
/// needs, and drawn ones that do not lead to a module before.
fn disagreements(table: &[(&str, &[&str])], files: &[(String, String)]) -> Vec<String> {
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
            if !table.iter().any(is_drawn) {
                found.push(format!("{file} imports {to}, and no arrow leads there"));
            }
            arrows.insert((module.to_owned(), to.clone()));
        }
    }
    let drawn = table.iter().flat_map(|(from, all)| all.iter().map(move |to| (*from, *to)));
    for (from, to) in drawn {
        if !arrows.contains(&(from.to_owned(), to.to_owned())) {
            found.push(format!("{from} does not import {to} any more: strike the arrow off"));
        }
        let floor = |module: &str| modules.iter().position(|other| *other == module);
        if floor(to) > floor(from) {
            found.push(format!("{from} -> {to} leads upwards"));
        }
    }
    found
}

#[test]
fn crates_depend_on_those_below() {
    let name = |folder: &str| match folder {
        "models" => folder.to_owned(),
        "sim" => "efam".to_owned(),
        folder => folder.replace("sim/", "efam_"),
    };
    let own: Vec<String> = CRATES.iter().map(|(folder, _)| name(folder)).collect();
    for (k, (member, below)) in CRATES.iter().enumerate() {
        let text = fs::read_to_string(root().join(member).join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = text.parse().expect("TOML");
        let packages = manifest["dependencies"].as_table().expect("a table").keys();
        let named: BTreeSet<String> = packages
            .map(|package| package.replace('-', "_"))
            .filter(|package| own.contains(package))
            .collect();
        let drawn: BTreeSet<String> = below.iter().map(|package| (*package).to_owned()).collect();
        assert_eq!(named, drawn, "{member} depends on other crates of ours than are drawn");
        assert!(
            drawn.iter().all(|package| own[..k].contains(package)),
            "{member} depends on a crate above it"
        );
    }
}

#[test]
fn nothing_imports_upwards() {
    for (folder, table) in FLOORS {
        let within = |(file, text): (String, String)| (file.replace(folder, ""), text);
        let files: Vec<_> = files(folder, ".rs").into_iter().map(within).collect();
        let found = disagreements(table, &files);
        assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
    }
}

#[test]
fn an_arrow_that_is_not_drawn_is_found() {
    let table: [(&str, &[&str]); 2] = [("ground", &[]), ("upper", &["ground"])];
    let house = |ground: &str, upper: &str| {
        let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        disagreements(&table, &[file("ground.rs", ground), file("upper/mod.rs", upper)])
    };
    let used = "use crate::{ground, other};";
    assert_eq!(house("", used), Vec::<String>::new());
    assert_eq!(house("#[cfg(test)] mod tests { use crate::upper::X; }", used), Vec::<String>::new());
    assert!(house("fn f() { crate::upper::x() }", used)[0].starts_with("ground.rs imports upper"));
    assert!(house("", "")[0].ends_with("strike the arrow off"));
}
