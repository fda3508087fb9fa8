//! `efam linearise`: answers, files and refusals.
//!
//! Goal: numbers are those of `efam modes` and of closed forms, files hold them, and what cannot be is said.
//! Setup: a light steel ruler, which is a linear cantilever; the paper's muscle on few nodes.

use serde_json::Value;

use crate::bench::{Bench, without_scripts};

const RULER: &str = "[rod]\nlength = \"0.1 m\"\nmass = \"1 g\"\nbending_stiffness = \"0.05 N m^2\"\n\
    axial_stiffness = \"1e6 N\"\n[effects.rayleigh_mass]\nalpha = \"2 1/s\"\n";
const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"30 psi\"\n[rod]\nnodes = 8\n\
    [effects.rayleigh_mass]\nalpha = \"2 1/s\"\n";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_ruler_has_the_poles_of_its_modes_and_the_gain_of_a_cantilever() {
    let bench = Bench::new("linear-ruler");
    bench.file("s.toml", RULER);
    let value =
        bench.json(&["linearise", "s.toml", "--output", "tip_z", "--json", "--out", "o<b>", "--reduce", "2"]);
    let linear = &value["linear"];
    let modes = bench.json(&["modes", "s.toml", "--json"]);
    // The third damping ratio is 7e-5: rounding of that pole is two billionths of it.
    for (k, keys) in [
        (0, &["frequency_hz", "damping_ratio"][..]),
        (1, &["frequency_hz", "damping_ratio"]),
        (2, &["frequency_hz"]),
    ] {
        for key in keys.iter().copied() {
            let (own, due) = (number(&linear["poles"][k][key]), number(&modes["modes"][k][key]));
            assert!((own / due - 1.0).abs() < 1e-9, "{key} {k}: {own}, due {due}");
        }
    }
    // Second order in the edge length.
    let (gain, due) = (number(&linear["static_gain"][0][0]), 1e-3 / (3.0 * 0.05));
    assert!((gain / due - 1.0).abs() < 5e-3, "{gain}, due {due}");
    assert!((number(&linear["settling_5_percent_s"]) - 20.0_f64.ln()).abs() < 1e-9);
    let page = bench.text("o<b>/report.html");
    for holds in ["6.6", "mm/N", "Static gain", "Responses to force_z", "--out o&lt;b&gt;"] {
        assert!(page.contains(holds), "{holds}");
    }
    assert!(!page.contains("<b>") && !without_scripts(&page).contains("<script"));
    assert!(!bench.0.join("o<b>/linear.h").exists(), "the header needs samples");
    let stored: Value = serde_json::from_str(&bench.text("o<b>/linear.json")).expect("JSON");
    assert_eq!(stored, *linear);
}

#[test]
fn a_table_answers_in_the_units_of_the_user() {
    let bench = Bench::new("linear-table");
    bench.file("s.toml", MUSCLE);
    let (code, table, stderr) = bench.run(&[
        "linearise",
        "s.toml",
        "--input",
        "pressure,force_z",
        "--sample",
        "10ms",
        "--reduce",
        "4",
    ]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    for holds in
        ["frequency, Hz  damping ratio", "mm/psi", "mm/N", "reduced to 4 states", "results in outputs/"]
    {
        assert!(table.contains(holds), "{holds} in\n{table}");
    }
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
}

/// With friction the small motions stick, which a warning says; `--slipping` has the poles of the slipping modes.
#[test]
fn friction_sticks_or_slips() {
    let bench = Bench::new("linear-friction");
    bench.file("s.toml", &format!("{MUSCLE}[effects.braid_friction]\nfriction_moment = \"0.5 mN m\"\n"));
    let (code, _, stderr) = bench.run(&["linearise", "s.toml", "--out", "sticks"]);
    assert_eq!(code, 0);
    assert!(
        stderr.starts_with("warning: friction holds as a spring") && stderr.contains("--slipping"),
        "{stderr}"
    );
    let modes = bench.json(&["modes", "s.toml", "--json", "--count", "1"]);
    let due = modes["modes"].as_array().and_then(|all| all.iter().find(|own| own["friction"] == "slips"));
    let own = bench.json(&["linearise", "s.toml", "--slipping", "--out", "slips", "--json"]);
    let own = number(&own["linear"]["poles"][0]["frequency_hz"]);
    let due = number(&due.expect("a slipping mode")["frequency_hz"]);
    assert!((own / due - 1.0).abs() < 1e-6, "{own}, due {due}");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let bench = Bench::new("linear-refused");
    bench.file("s.toml", RULER);
    bench.file("m.toml", MUSCLE);
    for (arguments, message) in [
        (&["s.toml", "--input", "pressure"][..], "input pressure: the rod is no muscle"),
        (&["s.toml", "--input", "force_y"], "input force_y: no such input; did you mean `force_"),
        (&["s.toml", "--output", "tip"], "output tip: no such output; did you mean `tip_x`"),
        (&["s.toml", "--sample", "0 s"], "--sample 0 s: must be longer than zero"),
        (&["s.toml", "--sample", "3"], "--sample 3: "),
        (&["s.toml", "--reduce", "0"], "reduce to 0 states: must lie in 1..="),
        (
            &["s.toml", "--reduce", "2", "--set", "effects.rayleigh_mass.alpha=0"],
            "only a model whose every motion decays",
        ),
        (&["m.toml", "--set", "muscle.pressure=all rows"], "a linear model is of one pressure"),
        (&["m.toml", "--input", "rod.length"], "rod.length: a mass, a length"),
    ] {
        let (code, stdout, stderr) = bench.run(&[&["linearise", "--out", "out"], arguments].concat());
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments:?}: {stderr}");
        assert!(stderr.starts_with(&format!("error: {message}")), "{arguments:?}: {stderr}");
        assert!(!bench.0.join("out").exists());
    }
}

/// A muscle that was calibrated at 30 and 50 psi, on 8 nodes; standard errors of EI and of the damping over their values, and
/// the correlation of the two stiffnesses.
fn calibrated(stiffness: f64, damping: f64, correlation: f64) -> String {
    let pressures = [30.0, 50.0].map(|psi| psi * 6_894.757_293_168);
    let parameter = |path: &str, pressure: Option<f64>, value: f64, error: f64, correlations: [f64; 3]| {
        let pressure = pressure.map_or(String::new(), |pressure| format!("pressure_pa = {pressure}\n"));
        format!(
            "[[calibration.parameter]]\npath = \"{path}\"\n{pressure}value = {value}\nstandard_error = {}\n\
             correlations = {correlations:?}\n",
            error * value
        )
    };
    [
        MUSCLE.replace("30 psi", "40 psi").replace("nodes = 8\n", ""),
        format!(
            "[calibration]\nreleases = 4\npressure_pa = {pressures:?}\npayload_kg = [0.0, 0.1]\nexcursion_m = 0.5\n\
             nodes = 8\n[[calibration.interpolation]]\npath = \"rod.bending_stiffness\"\nshape = \"pder_32\"\n\
             variance_per_pa = 0.0\n"
        ),
        parameter("rod.bending_stiffness", Some(pressures[0]), 6e-3, stiffness, [1.0, correlation, 0.0]),
        parameter("rod.bending_stiffness", Some(pressures[1]), 8e-3, stiffness, [correlation, 1.0, 0.0]),
        parameter("effects.rayleigh_mass.alpha", None, 2.0, damping, [0.0, 0.0, 1.0]),
    ]
    .concat()
}

fn ends(value: &Value) -> [f64; 2] {
    [number(&value[0]), number(&value[1])]
}

/// The intervals are those of `efam predict` at a pressure that was not calibrated and with a payload, and are in the table,
/// on the page and in the file.
#[test]
fn a_calibrated_rod_has_intervals() {
    let bench = Bench::new("linear-intervals");
    bench.file("rod.toml", &calibrated(0.02, 0.1, 0.3));
    let command = ["linearise", "rod.toml", "--payload", "80g", "--out", "out"];
    let value = bench.json(&[&command[..], &["--json"]].concat());
    let linear = &value["linear"];
    let predicted = bench.json(&["predict", "rod.toml", "--payload", "80g", "--json"]);
    let predicted = predicted["prediction"]["quantities"].as_array().expect("quantities");
    for (key, name) in [("frequency_hz", "small_frequency_hz"), ("damping_ratio", "small_damping_ratio")] {
        let due = predicted.iter().find(|own| own["name"] == name).expect("predicted");
        let (own, own_due) = (number(&linear["poles"][0][key]), number(&due["value"]));
        assert!((own / own_due - 1.0).abs() < 1e-6, "{key}: {own}, due {own_due}");
        let (found, due) = (ends(&linear["poles"][0][&format!("{key}_95")]), ends(&due["interval_95"]));
        assert!(
            found.iter().zip(due).all(|(end, due)| (end / due - 1.0).abs() < 1e-6),
            "{key}: {found:?}, {due:?}"
        );
        assert!(found[0] < own && own < found[1] && found[1] / found[0] > 1.005, "{key}: {found:?}");
    }
    let gain = &linear["static_gain_95"][1][0];
    let response = &linear["responses"][1];
    assert_eq!((&response["output"], number(&linear["draws"])), (&Value::from("tip_z"), 200.0));
    let (first, last) = (&response["gain_95"][0], &response["step_95"][599]);
    for (ends, due) in [(first, number(&response["gain"][0])), (last, number(&response["step"][599]))] {
        let [low, high] = [number(&ends[0]), number(&ends[1])];
        assert!(low < due && due < high, "{low} {due} {high}");
    }
    // At a twentieth of the first frequency the gain is that at rest, but for a four-hundredth.
    assert!((number(&first[1]) / number(&gain[0]).abs() - 1.0).abs() < 0.01, "{first} {gain}");
    let page = bench.text("out/report.html");
    assert!(page.contains("Bands hold 95 %") && page.contains("draws from the errors"), "{page}");
    let (code, table, _) = bench.run(&[&command[..], &["--overwrite"]].concat());
    assert_eq!(code, 0);
    assert!(table.contains("95 % intervals: 200 draws") && table.contains(" to "), "{table}");
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
}

/// Two stiffnesses with opposite errors leave the one between them as it is, and turn its slope over pressure: poles have no
/// width, and the gain has that of the slope times what the tip does by EI.
#[test]
fn the_gain_has_the_error_of_the_slope_over_pressure() {
    let bench = Bench::new("linear-slope");
    bench.file("rod.toml", &calibrated(0.02, 0.0, -1.0));
    let inputs = ["--input", "pressure,rod.bending_stiffness", "--output", "tip_z", "--draws", "800"];
    let value = bench.json(&[&["linearise", "rod.toml", "--json"], &inputs[..]].concat());
    let linear = &value["linear"];
    let [low, high] = ends(&linear["poles"][0]["frequency_hz_95"]);
    assert!(high / low - 1.0 < 1e-6, "{low} to {high}");
    let [low, high] = ends(&linear["static_gain_95"][0][0]);
    let stiffness = number(&linear["inputs"][1]["at_rest"]);
    let slope = 0.02 / (10.0 * 6_894.757_293_168);
    let due = 1.96 * slope * stiffness * number(&linear["static_gain"][0][1]).abs();
    // The ends of 800 draws are known to a twentieth of the width.
    assert!((0.5 * (high - low) / due - 1.0).abs() < 0.1, "{low} to {high}, due {due}");
}
