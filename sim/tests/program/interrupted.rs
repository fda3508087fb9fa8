//! Ctrl-C, as a terminal sends it: SIGINT.
//!
//! Goal: the first one ends what is going on soon, with code 130 and a word about it; a simulation is saved up to
//! there, of all else nothing is left behind.
//! Setup: work of minutes at least, interrupted when `-v` has said that it is under way.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::bench::Bench;

/// Longer than any interruption takes on a busy machine, and shorter than the work.
const SOON: Duration = Duration::from_secs(30);

/// Exit code, stdout, and stderr from the line on that has `ready` in it, when SIGINT is sent.
fn interrupted(bench: &Bench, arguments: &[&str], ready: &str) -> (i32, String, String) {
    let mut child = bench
        .command(&[arguments, &["-v"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("efam runs");
    let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut said = String::new();
    while !said.contains(ready) {
        let count = stderr.read_line(&mut said).expect("text");
        assert!(count > 0, "{arguments:?} ends before {ready:?}:\n{said}");
    }
    let begin = Instant::now();
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.is_ok_and(|kill| kill.success()));
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > SOON {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut rest = String::new();
    stderr.read_to_string(&mut rest).expect("text");
    let output = child.wait_with_output().expect("it ended");
    let stdout = String::from_utf8(output.stdout).expect("UTF-8");
    (output.status.code().unwrap_or(-1), stdout, rest)
}

#[test]
fn a_simulation_is_saved_up_to_there() {
    let bench = Bench::new("interrupt");
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n\
         [run]\nduration = \"3600 s\"\n[integrator]\nfixed_step = \"10 us\"\n",
    );
    let (code, stdout, stderr) =
        interrupted(&bench, &["simulate", "s.toml", "--json", "--out", "out"], "to simulate");
    assert_eq!(code, 130, "{stderr}");
    assert!(stderr.contains("\ninterrupted: s: the "), "{stderr}");
    let object: serde_json::Value = serde_json::from_str(&stdout).expect("one JSON object");
    assert_eq!(object["runs"][0]["status"]["kind"], "cut_short");
    let summary: serde_json::Value = serde_json::from_str(&bench.text("out/summary.json")).expect("JSON");
    assert_eq!(summary["status"]["kind"], "cut_short");
    assert_eq!(bench.left(), ["out", "s.toml"]);
}

#[test]
fn of_all_else_nothing_is_left() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/diagnosis/viscoelastic");
    let example = example.join("experiment.toml").display().to_string();
    let bench = Bench::new("interrupt-search");
    let release = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";
    bench.file("s.toml", release);
    let known = "releases = 1\npressure_pa = [1e5, 1e5]\npayload_kg = [0.0, 0.0]\nexcursion_m = 0.2\n\
                 [[calibration.parameter]]\npath = \"rod.bending_stiffness\"\nvalue = 0.0074\n\
                 standard_error = 7e-5\ncorrelations = [1.0]\n";
    let muscle = include_str!("../../../models/muscles/garbulinski-2022.toml");
    bench.file("known.toml", &format!("{muscle}\n[calibration]\n{known}"));
    let meshes = vec!["2000"; 200].join(",");
    for (arguments, ready) in [
        (&["analyse", &example, "--nodes", &meshes, "--out", "out"][..], "frequency, damping and stiffness"),
        (&["calibrate", &example, "--set", "rod.nodes=400", "--out", "out"], "reading and cleaning"),
        (&["diagnose", &example, "--set", "rod.nodes=200", "--out", "out"], "reading and cleaning"),
        (
            &[
                "predict",
                "--muscle",
                "known.toml",
                "--pressure",
                "15psi",
                "--draws",
                "1000000",
                "--out",
                "out",
            ],
            " threads",
        ),
        (&["diagnose", "--plan", "s.toml", "--set", "rod.nodes=200"], "] hose"),
    ] {
        let (code, stdout, stderr) = interrupted(&bench, arguments, ready);
        assert_eq!((code, stdout.as_str()), (130, ""), "{arguments:?}: {stderr}");
        assert!(stderr.ends_with("interrupted: nothing was saved\n"), "{arguments:?}: {stderr}");
        assert_eq!(bench.left(), ["known.toml", "s.toml"], "{arguments:?} leaves something behind");
    }
}
