//! `efam calibrate` on a small experiment, from the recording to the muscle file that `simulate` takes.
//!
//! Goal: what made a recording is found by the program, and what is found is what is simulated next.
//! Setup: a release of the paper's muscle at 15 psi on 16 nodes, with an EI of its own and both losses,
//! simulated by the program; a hold of a second before it, noise of 0.05 mm over it; fitted on the same mesh.

use serde_json::Value;

use crate::bench::{Bench, Noise};

const EI: f64 = 0.0085;
const ALPHA: f64 = 1.2;
const BETA: f64 = 0.008;
const SIGMA: f64 = 5e-5;
/// Time of the release on the recording's clock, s.
const INSTANT: f64 = 1.0;

pub fn scenario() -> String {
    format!(
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 16\n\
         bending_stiffness = \"{EI} N m^2\"\n[run]\nduration = \"3 s\"\n\
         [effects.rayleigh_mass]\nalpha = \"{ALPHA} 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"{BETA} s\"\n"
    )
}

/// Losses are off by a half; the muscle's own EI, which the fit starts from, by a sixth.
pub const EXPERIMENT: &str = "[muscle]\nname = \"garbulinski-2022\"\n[rod]\nnodes = 16\n\
    [effects.rayleigh_mass]\nalpha = \"1.8 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"4 ms\"\n\
    [[recording]]\nfile = \"15psi.csv\"\ntip = \"Tip\"\npressure = \"15 psi\"\nup = \"+z\"\nalong = \"+x\"\n\
    angle = \"0 deg\"\noffset = \"none\"\n[calibrate]\nmesh = \"kept\"\n";

/// Times, and tips in the plane, of a run's own table.
pub fn simulated(csv: &str) -> Vec<[f64; 3]> {
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let columns = ["time_s", "tip_x_m", "tip_z_m"].map(|name| {
        names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name} in {names:?}"))
    });
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        columns.map(|column| cells[column].parse().expect("a number"))
    };
    lines.map(row).collect()
}

/// The run with a hold before it, and noise over both.
pub fn recording(run: &[[f64; 3]]) -> String {
    let mut noise = Noise::new(3);
    let mut text = String::from("t_s,Tip_x_m,Tip_y_m,Tip_z_m\n");
    let hold = (0..100).map(|k| [0.01 * f64::from(k), run[0][1], run[0][2]]);
    for [t, x, z] in hold.chain(run.iter().map(|[t, x, z]| [t + INSTANT, *x, *z])) {
        let [x, y, z] = [x, 0.0, z].map(|at| at + SIGMA * noise.normal());
        text += &format!("{t:.4},{x},{y},{z}\n");
    }
    text
}

#[test]
fn what_made_a_recording_is_found_and_simulated_again() {
    let bench = Bench::new("calibrate");
    bench.file("truth.toml", &scenario());
    let truth = bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    bench.file("15psi.csv", &recording(&simulated(&bench.text("truth/trajectory.csv"))));
    bench.file("e.toml", EXPERIMENT);
    let value = bench.json(&["calibrate", "e.toml", "--json", "--out", "out"]);
    let parameters = value["calibration"]["parameters"].as_array().expect("rows");
    let found = |name: &str| {
        let row = parameters.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name}"));
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"));
        (number("value"), number("standard_error"))
    };
    assert_eq!(parameters.len(), 3, "{parameters:?}");
    for (name, truth) in [
        ("rod.bending_stiffness", EI),
        ("effects.rayleigh_mass.alpha", ALPHA),
        ("effects.rayleigh_stiffness.beta", BETA),
    ] {
        let (value, error) = found(name);
        // One estimate in 16 000 is off by four standard errors.
        assert!((value - truth).abs() < 4.0 * error, "{name}: {value} ± {error} for {truth}");
        assert!(error < 0.1 * truth, "{name}: {value} ± {error} says nothing");
    }
    let track = &value["calibration"]["releases"][0]["tracks"][0];
    let noise = track["noise_mm"].as_f64().expect("a number");
    // 600 residuals: 3 % of their deviation, three times.
    assert!((noise / (1e3 * SIGMA) - 1.0).abs() < 0.09, "{track}");
    for file in ["calibration.json", "muscle.toml", "residuals.csv", "fit-01.svg", "summary.json"] {
        assert!(bench.0.join("out").join(file).is_file(), "{file}");
    }
    assert_eq!(bench.text("out/experiment.toml"), EXPERIMENT);
    let written: Value = serde_json::from_str(&bench.text("out/calibration.json")).expect("JSON");
    assert_eq!(written, value["calibration"]);

    // Nothing of the losses is said here: they come with the muscle.
    bench.file(
        "again.toml",
        "[muscle]\npressure = \"15 psi\"\n[rod]\nnodes = 16\n[run]\nduration = \"3 s\"\n",
    );
    let muscle = ["--muscle", "out/muscle.toml", "--json", "--out", "again"];
    let again = bench.json(&[&["simulate", "again.toml"], &muscle[..]].concat());
    let resolved: toml::Table = bench.text("again/scenario.resolved.toml").parse().expect("TOML");
    let quantity = |table: &toml::Value, key: &str| -> f64 {
        let text = table[key].as_str().unwrap_or_else(|| panic!("{key} in {table}"));
        text.split(' ').next().and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{text}"))
    };
    for (path, simulated) in [
        ("rod.bending_stiffness", quantity(&resolved["rod"], "bending_stiffness")),
        ("effects.rayleigh_mass.alpha", quantity(&resolved["effects"]["rayleigh_mass"], "alpha")),
        ("effects.rayleigh_stiffness.beta", quantity(&resolved["effects"]["rayleigh_stiffness"], "beta")),
    ] {
        assert!((simulated / found(path).0 - 1.0).abs() < 1e-12, "{path}: {simulated}");
    }
    let hertz = |run: &Value| run["runs"][0]["damped_frequency_hz"].as_f64().expect("a number");
    // Half of the relative error of EI, which is below a thousandth.
    assert!((hertz(&again) / hertz(&truth) - 1.0).abs() < 1e-3, "{} {}", hertz(&again), hertz(&truth));

    // With a payload that nobody calibrated: what is found predicts it, and a rod that is too soft does not.
    let loaded = ["--set", "effects.payload.mass=\"40 g\"", "--csv", "--out", "loaded"];
    bench.json(&[&["simulate", "truth.toml", "--json"], &loaded[..]].concat());
    bench.file("loaded.csv", &recording(&simulated(&bench.text("loaded/trajectory.csv"))));
    let experiment = EXPERIMENT.replace("15psi.csv", "loaded.csv");
    bench.file("loaded.toml", &experiment.replace("tip =", "payload = \"40 g\"\ntip ="));
    let counts = |experiment: &str, more: &[&str]| {
        let asked =
            ["predict", "--muscle", "out/muscle.toml", "--check", experiment, "--draws", "60", "--json"];
        let value = bench.json(&[&asked[..], more, &["--overwrite", "--out", "check"]].concat());
        ["compared", "held"].map(|key| value["check"][key].as_u64().expect("a count"))
    };
    let [compared, held] = counts("loaded.toml", &[]);
    // Each of 95 intervals in 100 holds.
    assert!(compared >= 3 && held + 1 >= compared, "{held} of {compared}");
    let soft = format!("rod.bending_stiffness=\"{} N m^2\"", 0.9 * EI);
    let [compared, held] = counts("loaded.toml", &["--set", &soft]);
    assert!(held + 2 <= compared, "{held} of {compared}");
    assert_eq!(counts("e.toml", &[]), [0, 0], "it took part");
}

#[test]
fn what_cannot_be_calibrated_is_said_before_the_search() {
    let bench = Bench::new("calibrate-wrong");
    bench.file("e.toml", EXPERIMENT);
    let refused = |arguments: &[&str]| {
        let (code, stdout, stderr) = bench.run(&[&["calibrate"], arguments, &["--out", "out"]].concat());
        assert!(stdout.is_empty() && !bench.0.join("out").exists(), "nothing half-written");
        (code, stderr)
    };
    let (code, stderr) = refused(&["absent.toml"]);
    let absent =
        "error: absent.toml: cannot be read (No such file or directory (os error 2)); check the path\n";
    assert_eq!((code, stderr.as_str()), (2, absent));
    let (code, stderr) = refused(&["e.toml"]);
    assert_eq!(code, 2);
    assert!(
        stderr.starts_with("error: e.toml:10:8: recording[1].file: 15psi.csv: cannot be read"),
        "{stderr}"
    );
    let still: String = (0..300).map(|k| format!("{:.2},0.1,0,0\n", 0.01 * f64::from(k))).collect();
    bench.file("15psi.csv", &format!("t_s,Tip_x_m,Tip_y_m,Tip_z_m\n{still}"));
    let (code, stderr) = refused(&["e.toml"]);
    assert_eq!(code, 3);
    assert!(stderr.starts_with("error: 15psi.csv: no release in it:"), "{stderr}");
}
