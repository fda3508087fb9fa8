//! The first commands of somebody new: a file to begin with, a run without files, the page in the browser.
//!
//! Goal: what `efam init` writes runs without changes; `--no-files` leaves nothing; `--trajectory` prints
//! every sample; `--open` starts the browser that BROWSER
//! names with the page, and its lack changes nothing but a warning.

use std::fs;

use crate::bench::Bench;

const SHORT: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
    [run]\nduration = \"0.1 s\"\naccuracy = \"1 mm\"\n";

#[test]
fn what_init_writes_runs_as_it_stands() {
    let bench = Bench::new("init");
    let (code, stdout, stderr) = bench.run(&["init"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert_eq!(stdout, "scenario.toml: written; try\n  efam simulate scenario.toml --open\n");
    assert_eq!(bench.run(&["init", "--muscle"]).0, 0);
    assert_eq!(bench.left(), ["muscle.toml", "scenario.toml"]);
    let run = |more: &[&str]| {
        let all =
            [&["simulate", "scenario.toml", "--no-files", "--json", "--duration", "2 s"], more].concat();
        bench.json(&all)["runs"][0]["rest"]["tip_z_m"].clone()
    };
    assert!(run(&[]).as_f64().expect("a height") < -0.1);
    assert_eq!(run(&[]), run(&["--muscle", "muscle.toml"]));
    // Every key that is commented out is one that there is.
    let whole = bench.text("scenario.toml").replace("# [", "[").replace("# base_angle", "base_angle");
    let keys = ["mass =", "center_of_mass", "drag_coefficient", "accuracy"];
    let whole = keys.iter().fold(whole, |text, key| text.replace(&format!("# {key}"), key));
    bench.file("whole.toml", &whole);
    bench.json(&["simulate", "whole.toml", "--no-files", "--json", "--duration", "0.1 s"]);
    // What is there stays.
    bench.file("scenario.toml", "mine");
    let (code, _, stderr) = bench.run(&["init"]);
    assert_eq!(code, 2);
    assert!(stderr.starts_with("error: scenario.toml: exists already"), "{stderr}");
    assert_eq!(bench.text("scenario.toml"), "mine");
}

#[test]
fn a_run_without_files_says_the_same_and_leaves_nothing() {
    let bench = Bench::new("no-files");
    bench.file("s.toml", SHORT);
    let before = bench.left();
    let printed = bench.json(&["simulate", "s.toml", "--no-files", "--json"]);
    assert!(printed["folder"].is_null());
    let (code, table, _) = bench.run(&["simulate", "s.toml", "--no-files"]);
    assert_eq!(code, 0);
    assert!(table.contains("tip error") && !table.contains("results in"), "{table}");
    assert_eq!(bench.left(), before);
    let with = bench.json(&["simulate", "s.toml", "--json", "--out", "out"]);
    for entry in ["rest", "peaks", "errors", "modes", "samples"] {
        assert_eq!(printed["runs"][0][entry], with["runs"][0][entry], "{entry}");
    }
    let (code, _, stderr) = bench.run(&["simulate", "s.toml", "--no-files", "--out", "there"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("cannot be used with"), "{stderr}");
}

/// What MATLAB reads by `jsondecode` is what a folder would hold, number by number.
#[test]
fn the_samples_are_printed_as_the_folder_has_them() {
    let bench = Bench::new("trajectory");
    bench.file("s.toml", SHORT);
    let all = ["simulate", "s.toml", "--json", "--no-files", "--trajectory=nodes"];
    let before = bench.left();
    let run = bench.json(&all)["runs"][0].clone();
    assert_eq!(bench.left(), before);
    bench.json(&["simulate", "s.toml", "--json", "--csv", "--out", "out"]);
    let table = bench.text("out/trajectory.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let printed = run["trajectory"].as_object().expect("an object of lists");
    assert_eq!(printed.len(), rows[0].len());
    assert_eq!(run["samples"], rows.len() - 1);
    for (k, name) in rows[0].iter().enumerate() {
        let written: Vec<f64> = rows[1..].iter().map(|row| row[k].parse().expect("a number")).collect();
        let list = printed[*name].as_array().unwrap_or_else(|| panic!("{name}"));
        assert_eq!(list.len(), written.len(), "{name}");
        for (own, due) in list.iter().zip(written) {
            // The JSON reader of these tests may miss the last bit.
            let own = own.as_f64().expect("a number");
            assert!((own - due).abs() <= 4e-16 * due.abs(), "{name}: {own} {due}");
        }
    }
    // Nodes take most of it, and are printed only where they are wanted.
    let tip = bench.json(&["simulate", "s.toml", "--json", "--no-files", "--trajectory"]);
    let tip = tip["runs"][0]["trajectory"].as_object().expect("an object of lists").clone();
    assert_eq!(tip["tip_z_m"], printed["tip_z_m"]);
    assert!(tip.contains_key("total_J") && !tip.contains_key("x_00_m"), "{:?}", tip.keys());
    assert!(bench.json(&["simulate", "s.toml", "--json", "--no-files"])["runs"][0]["trajectory"].is_null());
    let (code, _, stderr) = bench.run(&["simulate", "s.toml", "--no-files", "--trajectory"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("--json"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn the_page_is_shown_by_the_browser_that_is_named() {
    use std::os::unix::fs::PermissionsExt;
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    let bench = Bench::new("open");
    bench.file("s.toml", SHORT);
    let browser = bench.0.join("browser");
    bench.file("browser", "#!/bin/sh\necho \"$@\" > shown.part && mv shown.part shown\n");
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).expect("it is ours");
    let arguments = ["simulate", "s.toml", "--json", "--open", "--overwrite", "--out", "run"];
    let run = |browser: &std::path::Path| {
        let output = bench.command(&arguments).env("BROWSER", browser).output().expect("efam runs");
        (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
    };
    assert_eq!(run(&browser), (Some(0), String::new()));
    let begin = Instant::now();
    while !bench.0.join("shown").exists() && begin.elapsed() < Duration::from_secs(20) {
        sleep(Duration::from_millis(20));
    }
    let shown = bench.text("shown");
    assert!(shown.trim_end().ends_with("open/run/report.html") && shown.starts_with('/'), "{shown}");
    let (code, stderr) = run(&bench.0.join("none"));
    assert_eq!(code, Some(0));
    assert!(stderr.starts_with("warning: --open: no browser can be started ("), "{stderr}");
    assert!(stderr.ends_with("run/report.html yourself, or name a browser in BROWSER\n"), "{stderr}");
    // Without the option no browser is started.
    fs::remove_file(bench.0.join("shown")).expect("it is there");
    let quiet = bench.command(&arguments[..3]).env("BROWSER", &browser).output().expect("efam runs");
    assert!(quiet.status.success());
    sleep(Duration::from_millis(200));
    assert!(!bench.0.join("shown").exists());
}
