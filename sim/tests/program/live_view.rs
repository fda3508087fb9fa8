//! A recording of a rod that falls from the horizontal and swings: made up, but its energies add up.
//!
//! Goal: a saved run is complete under its own name, equal runs are one recording, and what is
//! wrong with a destination is said before the run. Expected: no number; what the viewer shows is
//! looked at by eye.

use std::fs;
use std::net::{Ipv4Addr, TcpListener};
use std::process::Command;

use efam::observe::rerun::{RerunError, Scene, Sink, Stream};
use models::snapshot::{EffectForce, Energy, Snapshot};

use crate::bench::{Bench, skipped};

const LENGTH: f64 = 0.2;
const EDGES: usize = 31;
const FITTING: f64 = 0.02;
const NODE_MASS: f64 = 0.05 / EDGES as f64;
const END_MASS: f64 = 0.03;
const EFFECTS: [&str; 4] = ["bend", "stretch", "gravity", "rayleigh_mass"];

#[test]
fn saved_run_is_complete_under_its_name() {
    let bench = Bench::new("saved-run");
    let path = bench.0.join("run.rrd");
    let mut stream = Stream::open(&Sink::Save(path.clone()), &scene()).unwrap();
    for sample in 0..50 {
        stream.log(&snapshot(0.01 * f64::from(sample))).unwrap();
    }
    assert!(!path.exists(), "an unfinished run must not look finished");
    stream.finish().unwrap();

    let bytes = fs::read(&path).unwrap();
    assert_eq!(&bytes[..4], b"RRF2");
    let end = &bytes[bytes.len() - 32..];
    assert!(end.windows(8).any(|part| part == b"RRF2FOOT"), "no footer");
    assert!(bytes.windows(8).any(|part| part == b"same-run"));
    assert_eq!(fs::read_dir(&bench.0).unwrap().count(), 1);
}

#[test]
fn wrong_destinations_say_what_to_do() {
    let bench = Bench::new("wrong-destinations");
    let missing = bench.0.join("missing").join("run.rrd");
    let text = message(&Sink::Save(missing));
    assert!(text.contains("missing/run.rrd: cannot be written"), "{text}");
    let text = message(&Sink::Save(bench.0.join("run.csv")));
    assert!(text.contains("try") && text.ends_with("run.rrd"), "{text}");

    let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = taken.local_addr().unwrap().port();
    let bind = Ipv4Addr::LOCALHOST.into();
    let text = message(&Sink::Serve { bind, port });
    assert!(text.starts_with(&format!("127.0.0.1:{port}: cannot listen")), "{text}");
    drop(taken);
    let text = message(&Sink::Connect(Some(format!("127.0.0.1:{port}"))));
    assert!(text.contains("no viewer answers"), "{text}");
    let text = message(&Sink::Connect(Some("http://somewhere/else".into())));
    assert!(text.contains("rerun+http://HOST:PORT/proxy"), "{text}");
}

/// The README's run with its recording beside it.
#[test]
fn efam_saves_the_recording_with_its_results() {
    let bench = Bench::new("release");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/release-15psi.toml");
    let (code, _, stderr) = bench.run(&["simulate", scenario, "--out", "run", "--rerun", "save"]);
    assert_eq!(code, 0, "{stderr}");
    for file in ["scenario.resolved.toml", "summary.json", "trajectory.parquet", "release.svg", "run.rrd"] {
        assert!(bench.0.join("run").join(file).metadata().is_ok_and(|file| file.len() > 0), "{file}");
    }
    match Command::new("rerun").args(["rrd", "verify"]).arg(bench.0.join("run/run.rrd")).status() {
        Ok(status) => assert!(status.success(), "the viewer's own check"),
        Err(_) => skipped("viewer", "rerun rrd verify needs the viewer: pip install rerun-sdk==0.36.3"),
    }
}

/// Nothing but what the viewer reads, however long the run was; and nothing at all where it was only served.
#[test]
fn efam_keeps_only_what_is_watched() {
    let bench = Bench::new("watched");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/release-15psi.toml");
    let asked = ["simulate", scenario, "--watch-only", "--set", "run.duration=2 s", "--out", "run"];
    let (code, stdout, stderr) = bench.run(&[&asked[..], &["--rerun", "save"]].concat());
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("what was seen is in run"), "{stdout}");
    let run = Bench(bench.0.join("run"));
    let kept = ["efam-files.json", "run.rrd", "scenario.resolved.toml", "summary.json"];
    assert_eq!(run.left(), kept);
    assert!(run.text("summary.json").contains("\"kind\": \"watched\""));
    let (code, _, stderr) = bench.run(&asked);
    assert!(code == 2 && stderr.contains("--rerun"), "{stderr}");
}

/// A worked example of a diagnosis with its recording: the search, and each release before and after.
#[test]
fn efam_saves_the_recording_of_a_diagnosis() {
    let bench = Bench::new("diagnosis-recording");
    let experiment = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/diagnosis/nothing/experiment.toml");
    let (code, _, stderr) = bench.run(&["diagnose", experiment, "--out", "run", "--rerun", "save"]);
    assert_eq!(code, 0, "{stderr}");
    let recording = bench.0.join("run/run.rrd");
    let bytes = fs::read(&recording).unwrap();
    for part in ["search/ranking", "search/answer", "40psi-1.csv"] {
        assert!(bytes.windows(part.len()).any(|found| found == part.as_bytes()), "{part}");
    }
    assert!(!bench.0.join("run/run.partial.rrd").exists());
    match Command::new("rerun").args(["rrd", "verify"]).arg(&recording).status() {
        Ok(status) => assert!(status.success(), "the viewer's own check"),
        Err(_) => skipped("viewer", "rerun rrd verify needs the viewer: pip install rerun-sdk==0.36.3"),
    }
    // A plan has nothing to show.
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/release-15psi.toml");
    assert_eq!(bench.run(&["diagnose", "--plan", scenario, "--rerun", "save"]).0, 2);
}

/// A calibration as it converges, with each release; and the predicted rods of its muscle.
#[test]
fn efam_saves_the_recordings_of_a_calibration_and_of_a_prediction() {
    let bench = Bench::new("fit-recording");
    let experiment = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/diagnosis/nothing/experiment.toml");
    let asked = ["--payload", "0g,80g", "--duration", "3 s", "--out", "family", "--rerun", "save", "--quiet"];
    let predict = ["predict", "--muscle", "fit/muscle.toml", "--pressure", "40psi"];
    let calibrate = ["calibrate", experiment, "--out", "fit", "--rerun", "save", "--quiet"];
    for (arguments, parts) in [
        (calibrate.to_vec(), ["fit/run.rrd", "fit/residuals", "40psi-1.csv", "fit/parameters"]),
        ([&predict[..], &asked].concat(), ["family/run.rrd", "ensemble", "height", "80 g"]),
    ] {
        let (code, _, stderr) = bench.run(&arguments);
        assert_eq!(code, 0, "{stderr}");
        let bytes = fs::read(bench.0.join(parts[0])).unwrap();
        for part in &parts[1..] {
            assert!(bytes.windows(part.len()).any(|found| found == part.as_bytes()), "{part}");
        }
    }
}

/// A viewer that accepts and then says nothing, or goes, must not stop a run.
#[test]
fn dead_viewer_stops_no_run() {
    let viewer = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = viewer.local_addr().unwrap().port();
    let sink = Sink::Connect(Some(format!("127.0.0.1:{port}")));
    let mut stream = Stream::open(&sink, &scene()).unwrap();
    stream.log(&snapshot(0.0)).unwrap();
    drop(viewer);
    for sample in 1..200 {
        stream.log(&snapshot(0.01 * f64::from(sample))).unwrap();
    }
    let error = stream.finish().unwrap_err();
    assert!(matches!(error, RerunError::ViewerLost { .. }), "{error}");
}

fn message(sink: &Sink) -> String {
    match Stream::open(sink, &scene()) {
        Ok(_) => panic!("{sink:?} opened"),
        Err(error) => error.to_string(),
    }
}

fn scene() -> Scene {
    Scene {
        run_name: "made-up fall".into(),
        recording_id: "same-run".into(),
        duration_s: 20.0,
        rod_length_m: LENGTH,
        body_length_m: FITTING,
        payload_kg: 0.02,
        payload_com_m: 0.025,
        effects: EFFECTS.to_vec(),
        properties: vec![
            ("scenario".into(), "scenarios/made_up.toml".into()),
            ("payload".into(), "20 g".into()),
        ],
    }
}

/// The rod turned by an angle that grows along it and swings in time.
fn snapshot(time: f64) -> Snapshot {
    let dt = 1e-5;
    let (nodes, body_angle) = posture(time);
    let (before, angle_before) = posture(time - dt);
    let velocities: Vec<_> = (nodes.iter().zip(&before))
        .map(|(now, then)| [(now[0] - then[0]) / dt, (now[1] - then[1]) / dt])
        .collect();
    let mass = |i: usize| NODE_MASS + if i == EDGES { END_MASS } else { 0.0 };
    let angle = |s: f64| swing(time) * bent(s);
    let curvature = |i: usize| {
        let s = i as f64 / EDGES as f64;
        (angle(s + 1e-4) - angle(s - 1e-4)) / 2e-4 / LENGTH
    };
    let stiffness = 1.2e-3;
    let edge = LENGTH / EDGES as f64;
    let bending_moment: Vec<_> = (0..=EDGES).map(|i| -stiffness * curvature(i)).collect();
    let kinetic = (0..=EDGES).map(|i| 0.5 * mass(i) * velocities[i][0].hypot(velocities[i][1]).powi(2)).sum();
    let potential = (0..=EDGES).map(|i| mass(i) * 9.81 * nodes[i][1]).sum();
    let elastic = (0..=EDGES).map(|i| 0.5 * stiffness * curvature(i).powi(2) * edge).sum();
    let tip = along(nodes[EDGES], body_angle, FITTING);
    let force = |law: &dyn Fn(usize) -> [f64; 2]| (0..=EDGES).map(law).collect();
    let forces: [Vec<[f64; 2]>; 4] = [
        force(&|i| along([0.0; 2], angle(i as f64 / EDGES as f64) + 1.57, 1e-3 * curvature(i))),
        force(&|i| along([0.0; 2], angle(i as f64 / EDGES as f64), -mass(i) * 6.0)),
        force(&|i| [0.0, -9.81 * mass(i)]),
        force(&|i| velocities[i].map(|v| -3.0 * mass(i) * v)),
    ];
    Snapshot {
        time,
        body_angle,
        body_angular_velocity: (body_angle - angle_before) / dt,
        body_center: along(nodes[EDGES], body_angle, 0.5 * FITTING),
        tip,
        tip_velocity: velocities[EDGES],
        bending_moment,
        effect_forces: (EFFECTS.into_iter().zip(forces))
            .map(|(effect, force)| EffectForce { effect, force })
            .collect(),
        energy: Energy {
            kinetic,
            elastic,
            potential,
            dissipated: -(kinetic + elastic + potential),
            supplied: 0.0,
        },
        nodes,
        velocities,
    }
}

fn posture(time: f64) -> (Vec<[f64; 2]>, f64) {
    let mut nodes = vec![[0.0; 2]];
    for j in 0..EDGES {
        let middle = (j as f64 + 0.5) / EDGES as f64;
        let angle = swing(time) * bent(middle);
        nodes.push(along(nodes[j], angle, LENGTH / EDGES as f64));
    }
    (nodes, swing(time))
}

fn swing(time: f64) -> f64 {
    -1.4 * (1.0 - (-0.2 * time.max(0.0)).exp() * (6.5 * time).cos())
}

fn bent(s: f64) -> f64 {
    (1.0 - (-4.0 * s).exp()) / (1.0 - (-4.0_f64).exp())
}

fn along([x, z]: [f64; 2], angle: f64, length: f64) -> [f64; 2] {
    [x + length * angle.cos(), z + length * angle.sin()]
}
