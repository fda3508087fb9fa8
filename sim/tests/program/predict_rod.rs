//! `efam calibrate` on a rod that is no muscle, and `efam predict` with what it writes.
//!
//! Goal: what a calibration of an unloaded rod predicts of it with a payload is what it then does, and what is seen of
//! it: a marker that was off the rod's end is off it again.
//! Setup: a release of a plain rod on 16 nodes with both losses, simulated by the program; a hold of a second before
//! it, noise of 0.05 mm over it; fitted on the same mesh from an EI that is off by a sixth.
//! Expected: the frequency that the true rod has with 40 g at its end, within four of the standard errors that are
//! stated; and an interval narrower than a hundredth. The payload is a point, which is said by a tiny inertia.

use serde_json::Value;

use crate::bench::Bench;
use crate::calibrate::{recording, simulated};

/// The rotary inertia of a point: a payload without any has an unknown one.
const POINT: &str = "1e-12 kg m^2";

fn rod(stiffness: f64) -> String {
    format!(
        "[rod]\nlength = \"300 mm\"\nmass = \"30 g\"\nbending_stiffness = \"{stiffness} N m^2\"\n\
         axial_stiffness = \"1000 N\"\nnodes = 16\n[effects.end_fitting]\nmass = \"10 g\"\n\
         [effects.rayleigh_mass]\nalpha = \"0.8 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"4 ms\"\n"
    )
}

/// An experiment with one recording of a rod with a payload.
fn experiment(stiffness: f64, recording: &str, payload: &str) -> String {
    rod(stiffness)
        + &format!(
            "[[recording]]\nfile = \"{recording}.csv\"\npayload = {{ mass = \"{payload}\", rotary_inertia = \"{POINT}\" }}\ntip = \"Tip\"\nup = \"+z\"\n\
             along = \"+x\"\nangle = \"0 deg\"\noffset = \"none\"\n[calibrate]\nmesh = \"kept\"\n"
        )
}

/// A recording of the true rod with a payload; its marker is so high over the rod's end, m.
fn recorded(bench: &Bench, name: &str, payload: &str, above: f64) {
    let payload = format!("effects.payload.mass=\"{payload}\"");
    bench.json(&["simulate", "truth.toml", "--set", &payload, "--csv", "--json", "--out", name]);
    let mut run = simulated(&bench.text(&format!("{name}/trajectory.csv")));
    run.iter_mut().for_each(|[_, _, z]| *z += above);
    bench.file(&format!("{name}.csv"), &recording(&run));
}

/// 1.2 mm: more than the half that is a marker's prior offset.
#[test]
fn a_marker_that_stood_off_the_rods_end_stands_off_it_again() {
    let bench = Bench::new("predict-marker");
    bench.file("truth.toml", &(rod(0.05) + "[run]\nduration = \"4 s\"\n"));
    recorded(&bench, "bare", "0 g", 1.2e-3);
    recorded(&bench, "loaded", "40 g", 1.2e-3);
    bench.file("bare.toml", &experiment(0.058, "bare", "0 g"));
    bench.file("loaded.toml", &experiment(0.058, "loaded", "40 g"));
    bench.json(&["calibrate", "bare.toml", "--json", "--out", "out"]);
    let asked =
        ["predict", "out/rod.toml", "--check", "loaded.toml", "--json", "--out", "checked", "--draws", "60"];
    let checked = bench.json(&asked)["check"].clone();
    let numbers = checked["releases"][0]["numbers"].as_array().expect("a list");
    let rest = numbers.iter().find(|own| own["name"] == "seen_rest_z_m").expect("where its marker is seen");
    let [measured, predicted] = ["measured", "predicted"].map(|key| rest[key].as_f64().expect("a number"));
    assert!((measured - predicted).abs() < 0.2e-3, "{measured} for {predicted} m");
    assert_eq!(checked["held"], checked["compared"], "{checked}");
}

#[test]
fn a_calibrated_rod_foretells_what_a_payload_makes_of_it() {
    let bench = Bench::new("predict-rod");
    bench.file("truth.toml", &(rod(0.05) + "[run]\nduration = \"4 s\"\n"));
    recorded(&bench, "rod", "0 g", 0.0);
    bench.file("e.toml", &experiment(0.058, "rod", "0 g"));
    bench.json(&["calibrate", "e.toml", "--json", "--out", "out"]);
    assert!(bench.text("out/rod.toml").contains("[[calibration.parameter]]"));
    let truth =
        ["simulate", "truth.toml", "--set", "effects.payload.mass=\"40 g\"", "--json", "--out", "loaded"];
    let modes = bench.json(&truth)["runs"][0]["modes"].clone();
    let truth = modes[0]["natural_frequency_hz"].as_f64().expect("a number");
    let asked = [
        "predict",
        "out/rod.toml",
        "--payload",
        "40g",
        "--payload-inertia",
        POINT,
        "--json",
        "--out",
        "predicted",
        "--draws",
        "100",
    ];
    let predicted = bench.json(&asked);
    let quantities = predicted["prediction"]["quantities"].as_array().expect("a list");
    let own = quantities.iter().find(|own| own["name"] == "small_frequency_hz").expect("it is told");
    let number = |value: &Value| value.as_f64().expect("a number");
    let (value, half) =
        (number(&own["value"]), 0.5 * (number(&own["interval_95"][1]) - number(&own["interval_95"][0])));
    assert!((value - truth).abs() < 4.0 * half / 1.96, "{value} ± {half} for {truth}");
    assert!(half < 0.01 * truth, "{half} of {truth}");
    // It is a scenario like others.
    bench.json(&["simulate", "out/rod.toml", "--json", "--out", "again"]);
    let (code, _, stderr) = bench.run(&["predict", "out/rod.toml", "--pressure", "40psi", "--out", "none"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("no muscle"), "{stderr}");
}
