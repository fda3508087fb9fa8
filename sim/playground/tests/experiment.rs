//! The experiment that a page saves beside its scenario.
//!
//! Goal: `efam calibrate` takes the text as it is, and finds the rod that the recording was made with.
//! Setup: a release at 15 psi by the playground's own core, held for half a second before, as a table in mm with a
//! noise of 0.05 mm; its axes are turned, so that a wrong one is noticed. The saved setup starts elsewhere.
//! Expected: EI within 0.5 %, four standard errors and more. The noise alone gives some 0.1 %.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use efam_experiments::cleaning::clean_all;
use efam_experiments::experiment::{Experiment, Offset, Start};
use efam_inference::calibrate::{calibrate, problem};
use efam_playground::Playground;
use serde_json::{Value, json};

/// The row of the muscle's table at 15 psi, N m².
const EI: f64 = 0.00709;
const PRESSURE: f64 = 103_421.359_397_525_4;

fn ask(request: &Value) -> Value {
    let answer: Value = serde_json::from_str(&Playground::default().answer(&request.to_string())).unwrap();
    answer.get("ok").cloned().unwrap_or_else(|| panic!("{request}: {answer}"))
}

fn setup(alpha: f64, beta: f64) -> Value {
    json!({
        "muscle": "garbulinski-2022", "pressure": PRESSURE, "duration": 8.0,
        "effects": { "rayleigh_mass": { "alpha": alpha }, "rayleigh_stiffness": { "beta": beta } },
    })
}

fn recording() -> Value {
    json!({
        "file": "day 1 \"a\".csv", "tip": ["Tip 1"], "along": "-y", "up": "+x", "unit": null, "instant": 0.5,
        "is_placed": true, "fitted": ["rod.bending_stiffness"],
    })
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("efam-playground-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The release as motion capture would see it: forwards is -y, up is +x.
fn measured() -> String {
    let path = ask(&json!({ "ask": "release", "setup": setup(1.0, 2e-3) }));
    let number = |value: &Value| value.as_f64().unwrap();
    let tip: Vec<[f64; 2]> =
        path["tip"].as_array().unwrap().iter().map(|tip| [number(&tip[0]), number(&tip[1])]).collect();
    let held = (0..50).map(|_| tip[0]);
    let mut text = String::from("time_s,Tip 1_x_mm,Tip 1_y_mm,Tip 1_z_mm\n");
    // A linear congruential generator: twelve uniform numbers make a normal one.
    let mut state = 1_u64;
    let mut normal = || {
        let uniform = (0..12).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        });
        uniform.sum::<f64>() - 6.0
    };
    for (k, [x, z]) in held.chain(tip.iter().copied()).enumerate() {
        let mut seen = |at: f64| 1e3 * at + 0.05 * normal();
        let (up, forward, aside) = (seen(z), seen(x), seen(0.0));
        let _ = writeln!(text, "{:.3},{up:.4},{:.4},{aside:.4}", 0.01 * k as f64, -forward);
    }
    text
}

#[test]
fn a_saved_experiment_is_calibrated_as_it_is() {
    let folder = folder("calibrate");
    fs::write(folder.join("day 1 \"a\".csv"), measured()).unwrap();
    let mut start = setup(0.7, 3e-3);
    start["rod"] = json!({ "bending_stiffness": 0.0075 });
    let text = ask(&json!({ "ask": "experiment", "setup": start, "recording": recording() }));
    let file = folder.join("experiment.toml");
    fs::write(&file, text.as_str().unwrap()).unwrap();

    let experiment = Experiment::load(&file, &[]).unwrap();
    let cleaned = clean_all(&experiment, vec![experiment.read(0).unwrap()]).unwrap();
    assert_eq!(cleaned.releases.len(), 1);
    let (problem, settings) = problem(&experiment, &cleaned).unwrap();
    let model = &problem.trials[0].model;
    for (path, due) in [
        ("rod.bending_stiffness", 0.0075),
        ("effects.rayleigh_mass.alpha", 0.7),
        ("effects.rayleigh_stiffness.beta", 3e-3),
    ] {
        assert_eq!(model.value(path).unwrap(), due, "{path} starts where the page was");
    }
    let outcome = calibrate(&problem, &settings, &|_: &str| {}).unwrap();
    let found = &outcome.calibration.parameters;
    let stiffness = found.iter().find(|own| own.name.starts_with("rod.bending_stiffness")).unwrap();
    assert!((stiffness.value / EI - 1.0).abs() < 5e-3, "{stiffness:?}");
    fs::remove_dir_all(&folder).unwrap();
}

/// The file contains what the page knows, and nothing else.
#[test]
fn an_experiment_says_what_is_known() {
    let read = |setup: &Value, recording: &Value| {
        let text = ask(&json!({ "ask": "experiment", "setup": setup, "recording": recording }));
        Experiment::parse(Path::new("experiment.toml"), text.as_str().unwrap(), &[]).unwrap()
    };
    let mut inclined = setup(1.0, 2e-3);
    inclined["base_angle"] = json!(-0.4);
    let all = read(&inclined, &recording());
    let entry = &all.recordings[0];
    assert_eq!((entry.name.as_str(), &entry.tip[..]), ("day 1 \"a\".csv", &["Tip 1".to_owned()][..]));
    let near =
        |value: Option<f64>, due: f64| value.is_some_and(|value| (value - due).abs() <= 1e-14 * due.abs());
    assert!(near(entry.pressure, PRESSURE) && near(entry.base_angle, -0.4) && near(entry.angle, -0.4));
    assert_eq!((entry.instants.clone(), entry.offset), (Some(vec![0.5]), Some(Offset::Hold)));

    let mut silent = recording();
    silent["instant"] = Value::Null;
    silent["is_placed"] = json!(false);
    silent["unit"] = json!("mm");
    let plain = json!({ "rod": { "length": 0.1, "mass": 0.09, "bending_stiffness": 0.016 } });
    let entry = &read(&plain, &silent).recordings[0];
    assert!(entry.instants.is_none() && entry.pressure.is_none() && entry.unit.is_some());
    assert_eq!(entry.offset, Some(Offset::None));

    // A string that holds the tip bends the rod: it has no angle.
    let mut held = setup(1.0, 2e-3);
    held["angle"] = json!(0.3);
    let entry = &read(&held, &silent).recordings[0];
    assert_eq!((entry.start, entry.angle), (Some(Start::Held), None));
}
