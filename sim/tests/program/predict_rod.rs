//! `efam calibrate` on a rod that is no muscle, and `efam predict` with what it writes.
//!
//! Goal: what a calibration of an unloaded rod foretells of it with a payload is what it then does.
//! Setup: a release of a plain rod on 16 nodes with both losses, simulated by the program; a hold of a second before
//! it, noise of 0.05 mm over it; fitted on the same mesh from an EI that is off by a sixth.
//! Expected: the frequency that the true rod has with 40 g at its end, within four of the standard errors that are
//! stated; and an interval narrower than a hundredth.

use crate::bench::Bench;
use crate::calibrate::{recording, simulated};

fn rod(stiffness: f64) -> String {
    format!(
        "[rod]\nlength = \"300 mm\"\nmass = \"30 g\"\nbending_stiffness = \"{stiffness} N m^2\"\n\
         axial_stiffness = \"1000 N\"\nnodes = 16\n[effects.end_fitting]\nmass = \"10 g\"\n\
         [effects.rayleigh_mass]\nalpha = \"0.8 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"4 ms\"\n"
    )
}

#[test]
fn a_calibrated_rod_foretells_what_a_payload_makes_of_it() {
    let bench = Bench::new("predict-rod");
    bench.file("truth.toml", &(rod(0.05) + "[run]\nduration = \"4 s\"\n"));
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    bench.file("rod.csv", &recording(&simulated(&bench.text("truth/trajectory.csv"))));
    bench.file(
        "e.toml",
        &(rod(0.058)
            + "[[recording]]\nfile = \"rod.csv\"\ntip = \"Tip\"\nup = \"+z\"\nalong = \"+x\"\n\
               angle = \"0 deg\"\noffset = \"none\"\n[calibrate]\nmesh = \"kept\"\n"),
    );
    bench.json(&["calibrate", "e.toml", "--json", "--out", "out"]);
    assert!(bench.text("out/rod.toml").contains("[[calibration.parameter]]"));
    let truth =
        ["simulate", "truth.toml", "--set", "effects.payload.mass=\"40 g\"", "--json", "--out", "loaded"];
    let modes = bench.json(&truth)["runs"][0]["modes"].clone();
    let truth = modes[0]["natural_frequency_hz"].as_f64().expect("a number");
    let asked =
        ["predict", "out/rod.toml", "--payload", "40g", "--json", "--out", "predicted", "--draws", "100"];
    let predicted = bench.json(&asked);
    let quantities = predicted["prediction"]["quantities"].as_array().expect("a list");
    let own = quantities.iter().find(|own| own["name"] == "small_frequency_hz").expect("it is told");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
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
