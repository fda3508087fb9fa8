//! What the paper states of its measurements, by the program itself.
//!
//! Goal: the paper's statistics and trends come out of the program. Setup: a release at 15 psi that hangs beside the plane,
//! and the muscle in motion at all pressures of Table 2. Source: Garbulinski and Wereley (2022), Bending Properties of an
//! Extensile Fluidic Artificial Muscle.

use serde_json::Value;

use crate::bench::Bench;
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};

/// How far the tip hangs beside the plane, m.
const BESIDE: f64 = 0.03;
/// Active length at 15 psi, m.
const LENGTH: f64 = 7.99 * 0.0254;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The paper's muscle hung 20 mm beside the plane on average. The distance from the plane of the swing itself, which was
/// printed instead, is the noise alone: 0.2 mm.
#[test]
fn a_tip_that_hangs_beside_the_plane_is_measured_and_warned_of() {
    let bench = Bench::new("sideways");
    bench.file("truth.toml", &scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    let aside = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let y = cells[2].parse().map_or(cells[2].to_owned(), |y: f64| (y + BESIDE).to_string());
        [cells[0], cells[1], &y, cells[3]].join(",")
    };
    let text = recording(&simulated(&bench.text("truth/trajectory.csv")));
    let text: Vec<String> = text.lines().map(aside).collect();
    bench.file("15psi.csv", &text.join("\n"));
    bench.file("e.toml", &EXPERIMENT.replace("offset =", "clamp = [\"0 m\", \"0 m\", \"0 m\"]\noffset ="));
    let analysed = bench.json(&["analyse", "e.toml", "--json", "--nodes", "8", "--out", "analysed"]);
    let statistics = &analysed["releases"][0]["statistics"];
    // Four standard deviations of the noise, which is added to the largest of 300 samples.
    let near = |found: &Value, expected: f64| (number(found) - expected).abs() < 2e-4 * expected / BESIDE;
    assert!(near(&statistics["out_of_plane"], BESIDE), "{statistics}");
    assert!(near(&statistics["out_of_plane_share"], BESIDE / LENGTH), "{statistics}");
    assert!(number(&statistics["sway_share"]) * LENGTH < 2.5e-4, "{statistics}");
    let over = &analysed["out_of_plane"];
    assert!(near(&over["distance_m"]["largest"], BESIDE) && over["pressures"] == 1, "{over}");
    let warns = |value: &Value| {
        let all: Vec<&str> = value.as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        let own = "1 of 1 releases leave the plane of the model: 15psi.csv#1 by 30.";
        assert!(all.iter().any(|warning| warning.starts_with(own)), "{all:?}");
    };
    warns(&analysed["warnings"]);
    let (_, table, stderr) = bench.run(&["analyse", "e.toml", "--nodes", "8", "--out", "again"]);
    assert!(table.contains("from the vertical plane through the clamp's axis: 30."), "{table}");
    assert!(stderr.contains("warning: 1 of 1 releases leave the plane"), "{stderr}");
    warns(&bench.json(&["calibrate", "e.toml", "--json", "--out", "out"])["calibration"]["warnings"]);
    let diagnosed = bench.json(&["diagnose", "e.toml", "--budget", "1e6", "--json", "--out", "diagnosed"]);
    warns(&diagnosed["diagnosis"]["warnings"]);
}

/// The trends of Figure 9 as the text states them, from simulated swings, by eq. 6 and 7: the static muscle has 59 % and
/// 1.6 times instead. At rest both muscles are the same.
#[test]
fn the_muscle_in_motion_has_the_trends_of_figure_9() {
    let bench = Bench::new("figure-9");
    let scenario = |name: &str| format!("{}/../scenarios/{name}", env!("CARGO_MANIFEST_DIR"));
    let value = bench.json(&["simulate", &scenario("figure-9.toml"), "--json", "--out", "out"]);
    let runs = value["runs"].as_array().expect("rows");
    assert_eq!(runs.len(), 20);
    let of = |key: &str| -> Vec<f64> { runs.iter().map(|run| number(&run["height"][key])).collect() };
    // Row k is that of 5 (k + 1) psi.
    let (frequency, damping) = (of("natural_frequency_hz"), of("damping_ratio"));
    let extreme = |values: &[f64], sign: f64| {
        let at = (0..20).max_by(|a, b| (sign * values[*a]).total_cmp(&(sign * values[*b])));
        5 * (at.expect("rows") + 1)
    };
    assert_eq!(extreme(&frequency, 1.0), 10, "{frequency:?}");
    assert!((30..=40).contains(&extreme(&frequency, -1.0)), "{frequency:?}");
    let spread = frequency[1] / frequency.iter().copied().fold(f64::INFINITY, f64::min);
    // The text has two digits.
    assert!((spread - 1.20).abs() < 0.005, "{spread}");
    for (k, found) in frequency.iter().enumerate().skip(7) {
        let line = frequency[7] + (frequency[19] - frequency[7]) * (k - 7) as f64 / 12.0;
        assert!((found / line - 1.0).abs() < 5e-3 && *found >= frequency[7], "{k}: {found} for {line}");
    }
    assert!(damping.windows(2).all(|pair| pair[0] < pair[1]), "{damping:?}");
    let (times, share) = (damping[19] / damping[0], damping[5] / damping[19]);
    assert!((times - 4.5).abs() < 0.05 && (share - 2.0 / 3.0).abs() < 0.01, "{times} {share}");
    let statics = |name: &str| bench.json(&["statics", &scenario(name), "--set", "rod.nodes=12", "--json"]);
    let tips = |value: &Value| -> Vec<f64> {
        value["statics"].as_array().expect("rows").iter().map(|row| number(&row["tip_z_m"])).collect()
    };
    // To the rounding of the search for the rest.
    for (own, at_rest) in tips(&statics("figure-9.toml")).iter().zip(tips(&statics("all-rows.toml"))) {
        assert!((own / at_rest - 1.0).abs() < 1e-12, "{own} {at_rest}");
    }
}
