//! Releases of rods that a hand holds bent, as real laboratories make them.
//!
//! Goal: the effect is named though the rod is not held straight, and is not held in the file at all.
//! Setup: stand-ins of two recordings that others made, drawn by the program on a finer mesh than the diagnosis takes: a
//! cable that hangs, is pulled aside and let go at the first sample, with friction in its sections; a strip of card that is
//! lifted at its end and falls through the air. Noise of 0.3 mm, 30 frames a second.
//! Expected: friction of the size that was drawn, the drag coefficient that was drawn. Before the posture followed from
//! the markers, both rods started straight, and neither answer was right.

use serde_json::Value;

use crate::bench::{Bench, Noise};

const CABLE: &str = "[rod]\nlength = \"400 mm\"\nmass = \"420 g\"\nbending_stiffness = \"0.10 N m^2\"\n\
    diameter = \"20 mm\"\nbase_angle = \"-90 deg\"\n[effects.end_fitting]\nmass = \"230 g\"\n";
/// Candidates, so that it does not take long: what was drawn, and what others have mistaken it for.
const ASKED: [&str; 8] = [
    "air_drag",
    "braid_friction",
    "clamp_friction",
    "dahl",
    "hysteresis",
    "marker_offset",
    "tip_drag",
    "viscoelastic",
];
const STRIP: &str = "[rod]\nlength = \"185 mm\"\nmass = \"1.3 g\"\nbending_stiffness = \"100 N mm^2\"\n\
    diameter = \"51 mm\"\n[effects.end_fitting]\nmass = \"1.2 g\"\n";

/// Times and points of a run: the tip, then the node in the middle of 33.
fn run(bench: &Bench, scenario: &str) -> Vec<[f64; 5]> {
    bench.file("truth.toml", scenario);
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--no-error-estimate", "--out", "truth"]);
    let table = bench.text("truth/trajectory.csv");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let columns = ["time_s", "tip_x_m", "tip_z_m", "x_16_m", "z_16_m"]
        .map(|name| names.iter().position(|other| *other == name).expect("a column"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        columns.map(|column| cells[column].parse().expect("a number"))
    };
    lines.map(row).collect()
}

fn recording(bench: &Bench, run: &[[f64; 5]]) {
    let mut noise = Noise::new(5);
    let mut text = String::from("t_s,end_x_m,end_z_m,mid_x_m,mid_z_m\n");
    for [t, places @ ..] in run {
        let seen = places.map(|at| format!("{:.6}", at + 3e-4 * noise.normal()));
        text += &format!("{t:.4},{}\n", seen.join(","));
    }
    bench.file("r.csv", &text);
}

/// The first effect that is named, and the value of its first parameter.
fn answer(bench: &Bench, experiment: &str) -> (String, f64, Value) {
    let catalogue = bench.json(&["effects", "--json"]);
    let names =
        catalogue["effects"].as_array().expect("a list").iter().filter_map(|own| own["name"].as_str());
    let without: Vec<&str> = names.filter(|name| !ASKED.contains(name)).collect();
    bench.file("e.toml", &format!("{experiment}[diagnose]\nwithout = {without:?}\n"));
    let diagnosis =
        bench.json(&["diagnose", "e.toml", "--most", "1", "--json", "--out", "out"])["diagnosis"].clone();
    let first = &diagnosis["effects"][0];
    let value = first["parameters"][0]["value"].as_f64();
    (first["effect"].as_str().unwrap_or("none").to_owned(), value.unwrap_or(f64::NAN), diagnosis)
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_cable_that_is_pulled_aside_has_friction() {
    let bench = Bench::new("bent-cable");
    let truth = format!(
        "{CABLE}[run]\nduration = \"4 s\"\nrate = \"30 Hz\"\n[release]\nfrom = \"equilibrium\"\n\
         [release.hold.effects.tip_load]\nforce_x = \"3 N\"\n\
         [effects.dahl]\nfriction_moment = \"50 N mm\"\nyield_curvature = \"0.03 1/m\"\n\
         [effects.rayleigh_mass]\nalpha = \"0.3 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n"
    )
    .replace("[rod]\n", "[rod]\nnodes = 33\n");
    recording(&bench, &run(&bench, &truth));
    let experiment = format!(
        "{CABLE}[[recording]]\nfile = \"r.csv\"\ntip = \"end\"\nbody = [{{ marker = \"mid\", at = 0.5 }}]\n\
         up = \"+z\"\nalong = \"+x\"\ninstants = [\"0 s\"]\n"
    );
    let (effect, moment, diagnosis) = answer(&bench, &experiment);
    let frictions = ["dahl", "braid_friction", "clamp_friction", "hysteresis"];
    assert!(frictions.contains(&effect.as_str()), "{diagnosis:#}");
    assert!((0.04..0.06).contains(&moment), "{effect}: {moment} N m");
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_strip_that_is_lifted_has_drag() {
    let bench = Bench::new("bent-strip");
    let truth = format!(
        "{STRIP}[run]\nduration = \"8 s\"\nrate = \"30 Hz\"\n[release]\nfrom = \"equilibrium\"\n\
         [release.hold.effects.tip_load]\nforce_z = \"17 mN\"\n\
         [effects.air_drag]\ndrag_coefficient = 2.5\n\
         [effects.rayleigh_mass]\nalpha = \"0.3 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"2 ms\"\n"
    )
    .replace("[rod]\n", "[rod]\nnodes = 33\n");
    let run = run(&bench, &truth);
    let held = (0..30).map(|k| {
        let [_, places @ ..] = run[0];
        let [x, z, of_x, of_z] = places;
        [f64::from(k) / 30.0, x, z, of_x, of_z]
    });
    let swing = run.iter().map(|[t, x, z, of_x, of_z]| [t + 1.0, *x, *z, *of_x, *of_z]);
    recording(&bench, &held.chain(swing).collect::<Vec<_>>());
    let experiment =
        format!("{STRIP}[[recording]]\nfile = \"r.csv\"\ntip = \"end\"\nup = \"+z\"\nalong = \"+x\"\n");
    let (effect, coefficient, diagnosis) = answer(&bench, &experiment);
    assert_eq!(effect, "air_drag", "{diagnosis:#}");
    assert!((2.2..2.8).contains(&coefficient), "{coefficient}");
}
