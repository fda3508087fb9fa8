//! `efam diagnose` on experiments that say little, or nothing that makes sense.
//!
//! Goal: obstacles are reported before the search, by file, key and value, and leaves nothing
//! behind; what little data cannot determine is said beside the answer.
//! Setup: releases of the paper's muscle at 15 psi with air drag, simulated by the program on 64 nodes; a
//! hold of a second before them.

use serde_json::Value;

use crate::bench::{Bench, Noise};

const TRUTH: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 64\n\
    bending_stiffness = \"0.0074 N m^2\"\n[run]\nduration = \"3 s\"\n\
    [effects.rayleigh_mass]\nalpha = \"1.2 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"8 ms\"\n\
    [effects.air_drag]\n";

const EXPERIMENT: &str = "[muscle]\nname = \"garbulinski-2022\"\n[rod]\nnodes = 16\n\
    [effects.rayleigh_mass]\nalpha = \"1 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"10 ms\"\n\
    [[recording]]\nfile = \"15psi.csv\"\ntip = \"Tip\"\npressure = \"15 psi\"\nup = \"+z\"\nalong = \"+x\"\n\
    angle = \"0 deg\"\noffset = \"none\"\n";

/// A folder with the experiment and its recording, noise in m, which ends `seen` seconds after the release.
fn bench(name: &str, sigma: f64, seen: f64) -> Bench {
    let bench = Bench::new(name);
    bench.file("truth.toml", TRUTH);
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    let table = bench.text("truth/trajectory.csv");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let columns = ["time_s", "tip_x_m", "tip_z_m"]
        .map(|name| names.iter().position(|other| *other == name).expect("a column"));
    let row = |line: &str| -> [f64; 3] {
        let cells: Vec<&str> = line.split(',').collect();
        columns.map(|column| cells[column].parse().expect("a number"))
    };
    let run: Vec<[f64; 3]> = lines.map(row).filter(|[t, ..]| *t <= seen).collect();
    let hold = (0..100).map(|k| [0.01 * f64::from(k) - 1.0, run[0][1], run[0][2]]);
    let mut noise = Noise::new(3);
    let mut text = String::from("t_s,Tip_x_m,Tip_z_m\n");
    for [t, x, z] in hold.chain(run.iter().copied()) {
        let [x, z] = [x, z].map(|at| at + sigma * noise.normal());
        text += &format!("{:.4},{x},{z}\n", t + 1.0);
    }
    bench.file("15psi.csv", &text);
    bench.file("e.toml", EXPERIMENT);
    bench
}

fn warns(diagnosis: &Value, of: &str) -> bool {
    let all = diagnosis["warnings"].as_array().expect("a list");
    all.iter().any(|warning| warning.as_str().is_some_and(|warning| warning.contains(of)))
}

#[test]
fn one_short_release_says_what_it_cannot_tell() {
    let bench = bench("diagnose-short", 3e-4, 1.6);
    let drag = ["--set", "effects.air_drag.drag_coefficient=1.1"];
    let value = bench.json(&[&["diagnose", "e.toml", "--json", "--out", "out"], &drag[..]].concat());
    let diagnosis = &value["diagnosis"];
    assert_eq!(diagnosis["verdict"], "nothing_missing", "{diagnosis:#}");
    for warning in [
        "no release is held out",
        "one pressure only",
        "one release only",
        "one marker only",
        "no release is longer than",
    ] {
        assert!(warns(diagnosis, warning), "{warning}: {diagnosis:#}");
    }
    // What the model has is no candidate, and that is said.
    assert!(warns(diagnosis, "air_drag: already in the model"), "{diagnosis:#}");
    let round = &diagnosis["rounds"][0];
    let fitted: Vec<_> =
        round["candidates"].as_array().expect("a list").iter().map(|own| own["name"].clone()).collect();
    let others = round["others"].as_array().expect("a list");
    assert!(fitted.len() + others.len() > 20, "{round:#}");
    assert!(fitted.iter().chain(others).all(|name| name != "air_drag"), "{round:#}");
    for file in ["diagnosis.json", "repaired-1.toml", "experiment.toml", "summary.json"] {
        assert!(bench.0.join("out").join(file).is_file(), "{file}");
    }
}

#[test]
fn a_recording_without_noise_is_given_some_and_that_is_said() {
    let bench = bench("diagnose-noiseless", 0.0, 3.0);
    let drag = ["--set", "effects.air_drag.drag_coefficient=1.1"];
    let value = bench.json(&[&["diagnose", "e.toml", "--json", "--out", "out"], &drag[..]].concat());
    let diagnosis = &value["diagnosis"];
    let noise = diagnosis["gap"][0]["noise_mm"].as_f64().expect("a number");
    assert!((noise - 0.01).abs() < 1e-9, "{diagnosis:#}");
    assert!(warns(diagnosis, "less noise than a fit can resolve: 0.01 mm"), "{diagnosis:#}");
    assert!(!warns(diagnosis, "poorly determined; record until"), "{diagnosis:#}");
}

#[test]
fn what_cannot_be_diagnosed_is_said_before_the_search() {
    let bench = bench("diagnose-wrong", 3e-4, 3.0);
    bench.file("body.toml", &format!("{EXPERIMENT}body = [{{ marker = \"Tip\", at = \"400 mm\" }}]\n"));
    bench
        .file("twice.toml", &EXPERIMENT.replace("nodes = 16\n", "length = \"203 mm\"\nlength = \"20 cm\"\n"));
    let stated = |name: &str, lines: &str| bench.file(name, &format!("{EXPERIMENT}{lines}"));
    stated("without.toml", "[diagnose]\nwithout = [\"air_drg\"]\n");
    stated("path.toml", "[[diagnose.parameter]]\npath = \"effects.air_drag.coefficient\"\n");
    let mass = "[[diagnose.parameter]]\npath = \"effects.tip_mass.mass\"\n";
    stated("bounds.toml", &format!("{mass}bounds = [\"1 g\", \"1 mg\"]\n"));
    stated("unit.toml", &format!("{mass}bounds = [\"1 mm\", \"1 m\"]\n"));
    let before = bench.left();
    let refused = |expected: i32, arguments: &[&str]| {
        let out = ["--out", "out"];
        let out = if arguments.contains(&"--out") { &out[..0] } else { &out[..] };
        let (code, stdout, stderr) = bench.run(&[&["diagnose"], arguments, out].concat());
        assert_eq!((code, stdout.as_str()), (expected, ""), "{arguments:?}: {stderr}");
        assert_eq!(bench.left(), before, "{arguments:?} leaves something behind");
        stderr
    };
    let says = |code: i32, arguments: &[&str], expected: &str| {
        let stderr = refused(code, arguments);
        assert!(stderr.starts_with(&format!("error: {expected}")), "{arguments:?}\n{stderr}");
    };
    says(
        2,
        &["body.toml"],
        "body.toml:17:32: recording[1].body[1].at = \"400 mm\": must lie in 0..=202.9 mm, the rod's length",
    );
    says(
        3,
        &["e.toml", "--set", "rod.length=\"100 mm\""],
        "15psi.csv: release 1: held straight, the tip stands 219.8 mm from the clamp, and the rod with its \
         end fitting reaches 116.8 mm: check rod.length,",
    );
    says(
        2,
        &["e.toml", "--set", "recording[1].held_out=true"],
        "e.toml: every release is held out or dropped, and none is left to fit; take held_out, keep or drop",
    );
    says(
        2,
        &["without.toml"],
        "without.toml:18:11: diagnose.without = [\"air_drg\"]: there is no effect `air_drg`; did you mean `air_drag`?",
    );
    says(
        2,
        &["path.toml"],
        "path.toml:18:8: diagnose.parameter[1].path = \"effects.air_drag.coefficient\": no effect has a parameter",
    );
    says(
        2,
        &["e.toml", "--budget", "3 min"],
        "invalid value '3 min' for '--budget <NODE_STEPS>': it counts node steps",
    );
    says(2, &["bounds.toml"], "bounds.toml:19:10: diagnose.parameter[1].bounds");
    says(2, &["unit.toml"], "unit.toml:19:11: diagnose.parameter[1].bounds");
    says(
        2,
        &["e.toml", "--without", "air_drg"],
        "--without: there is no effect `air_drg`; did you mean `air_drag`?; `efam effects` lists all",
    );
    says(
        2,
        &["e.toml", "--out", "15psi.csv/out"],
        "15psi.csv: is a file where a folder is due; choose another --out",
    );
    says(
        2,
        &["--plan", "truth.toml", "--set", "rod.nodes=3"],
        "--set rod.nodes=3: rod.nodes = 3: must lie in",
    );
    says(
        4,
        &["--plan", "truth.toml", "--set", "integrator.most_steps=3"],
        "release truth: the model cannot be simulated",
    );
    says(2, &["--plan", "absent.toml"], "absent.toml: cannot be read (");
    says(2, &["twice.toml"], "twice.toml:5:1: duplicate key");
}
