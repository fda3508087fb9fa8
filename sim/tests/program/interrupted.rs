//! Ctrl-C, as a terminal sends it (SIGINT), and the signals by which systems and schedulers end a job.
//!
//! Goal: the first one ends what is going on soon, with code 128 and the signal's number and a word about it; a
//! simulation is saved up to there, of all else nothing is left behind.
//! Setup: work of minutes at least, interrupted when `-v` has said that it is under way.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use crate::bench::{Bench, program};

/// Longer than any interruption takes on a busy machine, and shorter than the work.
const SOON: Duration = Duration::from_secs(30);

/// Exit code, stdout, and stderr from the line on that has `ready` in it, when some signals are sent one after the
/// other.
fn ended_by(signals: &[&str], bench: &Bench, arguments: &[&str], ready: &str) -> (i32, String, String) {
    // Whoever runs the tests may have them ignore a signal, as nohup does.
    let mut command = Command::new("env");
    command.arg("--default-signal").arg(program()).args(arguments).arg("-v").current_dir(&bench.0);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("efam runs");
    let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut said = String::new();
    while !said.contains(ready) {
        let count = stderr.read_line(&mut said).expect("text");
        assert!(count > 0, "{arguments:?} ends before {ready:?}:\n{said}");
    }
    let begin = Instant::now();
    for signal in signals {
        send(signal, child.id());
        std::thread::sleep(Duration::from_millis(20));
    }
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

/// Sends a signal to a process.
pub fn send(signal: &str, process: u32) {
    let kill = Command::new("kill").args([&format!("-{signal}"), &process.to_string()]).status();
    assert!(kill.is_ok_and(|kill| kill.success()), "{signal} to {process}");
}

/// A bench with a run that takes minutes.
fn long(name: &str) -> Bench {
    let bench = Bench::new(name);
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n\
         [run]\nduration = \"3600 s\"\n[integrator]\nfixed_step = \"10 us\"\n\
         most_steps = 1000000000\n",
    );
    bench
}

/// Ctrl-C; a scheduler at the time limit; a closed terminal, which the kernel and the shell report; used-up processor
/// time; a scheduler that repeats itself.
#[test]
fn a_simulation_is_saved_up_to_there() {
    for (number, (signals, expected)) in [
        (&["INT"][..], 130),
        (&["TERM"], 143),
        (&["HUP", "HUP"], 129),
        (&["XCPU"], 152),
        (&["TERM", "TERM", "TERM"], 143),
    ]
    .into_iter()
    .enumerate()
    {
        let bench = long(&format!("interrupt-{number}"));
        let (code, stdout, stderr) =
            ended_by(signals, &bench, &["simulate", "s.toml", "--json", "--out", "out"], "to simulate");
        assert_eq!(code, expected, "{signals:?}: {stderr}");
        assert!(stderr.contains("\ninterrupted: s: the "), "{signals:?}: {stderr}");
        let object: serde_json::Value = serde_json::from_str(&stdout).expect("one JSON object");
        assert_eq!(object["runs"][0]["status"]["kind"], "cut_short");
        let summary: serde_json::Value = serde_json::from_str(&bench.text("out/summary.json")).expect("JSON");
        assert_eq!(summary["status"]["kind"], "cut_short");
        assert_eq!(bench.left(), ["out", "s.toml"]);
    }
}

/// Signals after the last step: in the analysis, in the tables, and on the pages. The run is complete and saved; pictures and
/// pages may be missing.
#[test]
fn a_signal_after_the_last_step_keeps_the_run() {
    let bench = Bench::new("interrupt-after");
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
         [effects.rayleigh_mass]\nalpha = \"0.01 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n\
         [run]\nduration = \"40 s\"\nrate = \"1000 Hz\"\n",
    );
    let arguments = ["simulate", "s.toml", "--no-error-estimate", "--csv", "--overwrite", "--out", "out"];
    let mut without_a_page = 0;
    for (wait, signal, expected) in
        [(0, "INT", 130), (100, "TERM", 143), (400, "TERM", 143), (1500, "INT", 130)]
    {
        let mut command = Command::new("env");
        command.arg("--default-signal").arg(program()).args(arguments).arg("-v").current_dir(&bench.0);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("efam runs");
        let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
        let mut said = String::new();
        while !said.contains("analysis, tables and pages") {
            assert!(stderr.read_line(&mut said).expect("text") > 0, "{said}");
        }
        std::thread::sleep(Duration::from_millis(wait));
        let in_time = child.try_wait().expect("a child").is_none();
        if in_time {
            send(signal, child.id());
        }
        let begin = Instant::now();
        stderr.read_to_string(&mut said).expect("text");
        let code = child.wait().expect("it ends").code();
        assert!(begin.elapsed() < SOON, "{wait} ms: {:?}", begin.elapsed());
        assert!(code == Some(expected) || code == Some(0), "{wait} ms: {code:?} {said}");
        let summary: serde_json::Value = serde_json::from_str(&bench.text("out/summary.json")).expect("JSON");
        assert_eq!(summary["status"]["kind"], "complete", "{wait} ms");
        assert_eq!(bench.text("out/trajectory.csv").lines().count(), 40_002, "{wait} ms");
        without_a_page += usize::from(!bench.0.join("out/report.html").exists());
    }
    assert!(without_a_page > 0, "no signal came before the pages");
}

/// As it was found: a rod of 2000 nodes without damping, whose samples are a minute of work apart, was ended 601 s after
/// Ctrl-C. Here the signal comes in the search for the rest, in the first steps, and later.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_signal_between_two_samples_is_noticed() {
    for wait in [0, 1, 4] {
        let bench = Bench::new("interrupt-between");
        bench.file(
            "s.toml",
            "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 2000\n\
             [run]\nduration = \"60 s\"\nrate = \"1 Hz\"\n",
        );
        let mut command = Command::new("env");
        command.arg("--default-signal").arg(program()).args(["simulate", "s.toml", "-q", "--out", "out"]);
        let mut child = command.current_dir(&bench.0).stderr(Stdio::null()).spawn().expect("efam runs");
        // Its folder is there once it is under way.
        while !bench.left().iter().any(|name| name.starts_with(".out.partial-")) {
            assert!(child.try_wait().expect("a child").is_none(), "it ends before it begins");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_secs(wait));
        send("INT", child.id());
        let begin = Instant::now();
        while child.try_wait().expect("a child").is_none() {
            if begin.elapsed() > SOON {
                let _ = child.kill();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let took = begin.elapsed();
        assert_eq!(child.wait().expect("it ended").code(), Some(130), "{wait} s after its begin: {took:?}");
        // A second on an idle machine.
        assert!(took < Duration::from_secs(10), "{wait} s after its begin: {took:?}");
        let summary: serde_json::Value = serde_json::from_str(&bench.text("out/summary.json")).expect("JSON");
        assert_eq!(summary["status"]["kind"], "cut_short");
    }
}

/// A run of minutes says so after two seconds, so that nobody waits for it unasked.
#[test]
fn a_long_run_says_how_long_it_takes() {
    let bench = long("interrupt-cost");
    let mut command = Command::new("env");
    command.arg("--default-signal").arg(program()).args(["simulate", "s.toml", "--out", "out"]);
    let mut child = command
        .current_dir(&bench.0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("efam runs");
    let stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let (tell, told) = mpsc::channel();
    std::thread::spawn(move || stderr.lines().map_while(Result::ok).try_for_each(|line| tell.send(line)));
    let line = told.recv_timeout(SOON);
    send("INT", child.id());
    assert!(line.as_ref().is_ok_and(|line| line.starts_with("s: about ")), "{line:?}");
    assert_eq!(child.wait().expect("it ended").code(), Some(130));
}

/// A program that was started to outlive its terminal does so.
#[cfg(target_os = "linux")]
#[test]
fn under_nohup_a_closed_terminal_ends_nothing() {
    let bench = Bench::new("interrupt-nohup");
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n\
         [run]\nduration = \"1 s\"\n[integrator]\nfixed_step = \"0.1 ms\"\n\
         [effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n",
    );
    let mut command = Command::new("nohup");
    command.arg(program()).args(["simulate", "s.toml", "-v", "--out", "out"]).current_dir(&bench.0);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("nohup runs");
    let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut said = String::new();
    while !said.contains("to simulate") {
        assert!(stderr.read_line(&mut said).expect("text") > 0, "{said}");
    }
    send("HUP", child.id());
    stderr.read_to_string(&mut said).expect("text");
    assert!(child.wait().expect("it ends").success(), "{said}");
    let summary: serde_json::Value = serde_json::from_str(&bench.text("out/summary.json")).expect("JSON");
    assert_eq!(summary["status"]["kind"], "complete");
}

/// What `ulimit -f` admits is too short for the results: that is an error of writing, with its file and its reason.
#[test]
fn a_file_that_may_not_grow_is_an_error_of_writing() {
    let bench = Bench::new("interrupt-long-file");
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[run]\nduration = \"2 s\"\n",
    );
    // In blocks of 512 or 1024 bytes, as the shell likes; the table has more.
    let script = format!("ulimit -f 16; exec '{}' simulate s.toml -q --out out", program().display());
    let mut command = Command::new("sh");
    let output = command.args(["-c", &script]).current_dir(&bench.0).output().expect("sh runs");
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{:?} {stderr}", output.status);
    assert!(
        stderr.starts_with("error: out/") && stderr.contains("cannot be written: File too large"),
        "{stderr}"
    );
    assert_eq!(bench.left(), ["s.toml"]);
}

/// Once the baseline is fitted, a search has an answer; a time limit and the budget end it as a signal does.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_diagnosis_is_saved_as_far_as_it_came() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/diagnosis/viscoelastic");
    let example = example.join("experiment.toml").display().to_string();
    let bench = Bench::new("interrupt-diagnosis");
    let is_cut_short = |out: &str, by: &str| {
        let text = bench.text(&format!("{out}/diagnosis.json"));
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!((&found["cut_short"]["round"], &found["verdict"]), (&1.into(), &"unknown".into()));
        assert_eq!(found["cut_short"]["by"], by);
        let not_fitted = found["cut_short"]["not_fitted"].as_array().expect("names");
        assert!(not_fitted.iter().any(|name| name == "viscoelastic"), "{not_fitted:?}");
        let warning = found["warnings"].as_array().expect("warnings")[0].as_str().expect("words").to_owned();
        assert!(warning.starts_with("the search was cut short in round 1"), "{warning}");
    };
    for (signal, expected) in [("INT", 130), ("TERM", 143)] {
        let arguments = ["diagnose", &example, "--out", signal];
        let (code, _, stderr) = ended_by(&[signal], &bench, &arguments, "round 1: score");
        assert_eq!(code, expected, "{stderr}");
        assert!(stderr.contains("\ninterrupted: the results up to then are saved\n"), "{stderr}");
        is_cut_short(signal, "interruption");
    }
    let (code, _, stderr) = bench.run(&["diagnose", &example, "--budget", "1", "--out", "budget"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.starts_with("budget: 1 node steps, about "), "{stderr}");
    is_cut_short("budget", "budget");
    let (code, stdout, stderr) = bench.run(&["diagnose", &example, "--time-limit", "1 ms", "--out", "time"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("time limit: 0.0010 s, by which the answer depends on this machine"), "{stderr}");
    assert!(stdout.contains("so another machine may give another answer"), "{stdout}");
    is_cut_short("time", "interruption");
    assert_eq!(bench.left(), ["INT", "TERM", "budget", "time"]);
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
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
        for (signal, expected) in [("INT", 130), ("TERM", 143)] {
            let (code, stdout, stderr) = ended_by(&[signal], &bench, arguments, ready);
            assert_eq!((code, stdout.as_str()), (expected, ""), "{arguments:?}: {stderr}");
            assert!(stderr.ends_with("interrupted: nothing was saved\n"), "{arguments:?}: {stderr}");
            assert_eq!(bench.left(), ["known.toml", "s.toml"], "{arguments:?} leaves something behind");
        }
    }
}
