//! SIGTERM at random moments, by which schedulers end a job at its time limit.
//!
//! Goal: what was integrated is there and marked; of a search nothing is left; of a sweep whole shards; and what is
//! done again ends as if nothing had happened.
//! Setup: half of the signals come at any moment of the run, half while it writes; a run that ends before its signal is
//! followed by another. Four a command;
//! `EFAM_TERMS=50 cargo test --workspace --no-default-features --test program terminated -- --nocapture` takes 50 of
//! each, 200 in all.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, program};
use crate::draws::{Draws, count};
use crate::interrupted::send;

/// A bench on which each command takes a second or so.
fn bench(name: &str) -> Bench {
    let bench = crate::work::bench(name);
    let slow = bench.text("s.toml").replace("[run]", "[integrator]\nfixed_step = \"0.02 ms\"\n[run]");
    bench.file("s.toml", &slow.replace("duration = \"1 s\"", "duration = \"2 s\""));
    bench
}

fn begin(bench: &Bench, arguments: &[&str]) -> Child {
    let mut command = Command::new("env");
    // Whoever runs the tests may have them ignore a signal.
    command.arg("--default-signal").arg(program()).args(arguments).current_dir(&bench.0);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("efam runs")
}

/// How a run ends on a signal at a random moment, and whether it was still there for it.
fn terminated(bench: &Bench, arguments: &[&str], takes: Duration, draws: &mut Draws) -> (ExitStatus, bool) {
    let mut child = begin(bench, arguments);
    let share = |draws: &mut Draws| draws.below(1000) as f64 / 1000.0;
    if draws.percent(50) {
        sleep(takes.mul_f64(share(draws)));
    } else {
        let begin = Instant::now();
        let writes = || {
            let hidden = bench.left().into_iter().filter(|name| name.starts_with('.'));
            hidden
                .map(|name| bench.0.join(name))
                .any(|path| fs::read_dir(path).is_ok_and(|mut all| all.next().is_some()))
        };
        while !writes() && child.try_wait().expect("a child").is_none() {
            assert!(begin.elapsed() < 20 * takes + Duration::from_secs(60), "it hangs");
            sleep(Duration::from_micros(200));
        }
        sleep(takes.mul_f64(0.05 * share(draws)));
    }
    let is_there = child.try_wait().expect("a child").is_none();
    if is_there {
        send("TERM", child.id());
    }
    let told = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("a child") {
            return (status, is_there);
        }
        assert!(told.elapsed() < Duration::from_secs(60), "it does not end");
        sleep(Duration::from_millis(2));
    }
}

/// In order, in time, or before it could listen.
fn is_known(status: ExitStatus) -> bool {
    matches!(status.code(), Some(0 | 143)) || status.signal() == Some(15)
}

fn timed(bench: &Bench, arguments: &[&str]) -> Duration {
    let begun = Instant::now();
    assert!(begin(bench, arguments).wait().expect("it ends").success(), "{arguments:?}");
    begun.elapsed()
}

/// Counts runs from 0 until so many signals have come in time.
struct Signals {
    wanted: usize,
    sent: usize,
    runs: usize,
}

impl Signals {
    fn new() -> Self {
        Self { wanted: count("EFAM_TERMS", 2), sent: 0, runs: 0 }
    }

    /// The number of the next run.
    fn another(&mut self) -> Option<usize> {
        assert!(
            self.runs < 20 * self.wanted,
            "{} signals in {} runs: the others ended before it",
            self.sent,
            self.runs
        );
        self.runs += 1;
        (self.sent < self.wanted).then_some(self.runs - 1)
    }
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_simulation_keeps_what_was_integrated() {
    let bench = bench("terminated-simulate");
    let arguments = ["simulate", "s.toml", "--csv", "--no-error-estimate", "-q", "--out"];
    let takes = timed(&bench, &[&arguments[..], &["whole"]].concat());
    let whole = bench.text("whole/trajectory.csv");
    let mut draws = Draws::new("terminated simulate");
    let (mut early, mut cut, mut complete, mut signals) = (0, 0, 0, Signals::new());
    while let Some(k) = signals.another() {
        let out = format!("out-{k}");
        let (status, in_time) = terminated(&bench, &[&arguments[..], &[&out]].concat(), takes, &mut draws);
        signals.sent += usize::from(in_time);
        assert!(is_known(status), "{k}: {status:?}");
        if status.signal().is_some() {
            early += 1;
            continue;
        }
        let summary: serde_json::Value =
            serde_json::from_str(&bench.text(&format!("{out}/summary.json"))).expect("JSON");
        let kind = summary["status"]["kind"].as_str().expect("a word");
        let csv = bench.text(&format!("{out}/trajectory.csv"));
        let rows = csv.lines().count() - 1;
        assert_eq!(summary["samples"].as_u64(), Some(rows as u64), "{k}");
        assert!(whole.starts_with(&csv), "{k}: what was integrated is the beginning of the whole");
        match (status.code(), kind) {
            (Some(143), "cut_short") => {
                cut += 1;
                let time = summary["status"]["time"].as_f64().expect("a time");
                let last = csv.lines().last().and_then(|line| line.split(',').next()?.parse::<f64>().ok());
                assert!(rows == 0 || last.is_some_and(|last| last <= time + 1e-9), "{k}: {last:?} of {time}");
            }
            // The signal came when all was integrated already.
            (Some(0 | 143), "complete") => complete += 1,
            other => panic!("{k}: {other:?}"),
        }
        // It is a run like any other.
        assert_eq!(bench.run(&["report", &out, "-q", "--out", "report", "--overwrite"]).0, 0, "{k}");
        fs::remove_dir_all(bench.0.join(&out)).expect("it is there");
    }
    let sent = signals.sent;
    println!("simulate: {sent} signals, {cut} cut short, {complete} complete, {early} before they began");
    // A program listens before it has read its scenario: hardly any signal comes before that.
    assert!(5 * early <= cut + complete + 4, "{early} were killed");
    // What came before it could listen left nothing but what the next run tidies.
    bench.json(&["simulate", "s.toml", "--json", "--out", "last"]);
    assert!(bench.left().iter().all(|name| !name.starts_with('.')), "{:?}", bench.left());
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn of_a_search_nothing_is_left_or_all_that_it_found() {
    let bench = bench("terminated-search");
    let mut draws = Draws::new("terminated search");
    for command in ["calibrate", "diagnose"] {
        let arguments = [command, "e.toml", "-q", "--out"];
        let takes = timed(&bench, &[&arguments[..], &[command]].concat());
        let before = bench.left();
        let (mut told, mut complete, mut early, mut signals) = (0, 0, 0, Signals::new());
        while let Some(k) = signals.another() {
            let out = format!("out-{k}");
            let (status, in_time) =
                terminated(&bench, &[&arguments[..], &[&out]].concat(), takes, &mut draws);
            signals.sent += usize::from(in_time);
            assert!(is_known(status), "{command} {k}: {status:?}");
            let saved = bench.0.join(&out);
            let is_left = saved.is_dir();
            if is_left {
                assert!(saved.join("efam-files.json").is_file(), "{command} {k}: {status:?}");
                fs::remove_dir_all(saved).expect("it is there");
            }
            if status.code() == Some(0) {
                complete += 1;
                assert!(is_left, "{command} {k}");
            } else if status.code() == Some(143) {
                told += 1;
                // A diagnosis whose baseline is fitted has an answer.
                assert!(!is_left || command == "diagnose", "{command} {k}");
            } else {
                early += 1;
                // The next run tidies.
                assert_eq!(bench.run(&["report", "run", "-q", "--out", "report", "--overwrite"]).0, 0);
                let _ = fs::remove_dir_all(bench.0.join("report"));
            }
            assert_eq!(bench.left(), before, "{command} {k}");
        }
        let sent = signals.sent;
        println!(
            "{command}: {sent} signals, {told} ended in order, {complete} complete, {early} before they began"
        );
        assert!(5 * early <= told + complete + 4, "{early} were killed");
    }
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_sweep_keeps_whole_shards() {
    let bench = bench("terminated-sweep");
    let fast = bench.text("s.toml").replace("0.02 ms", "0.2 ms");
    bench.file("s.toml", &fast);
    let arguments = ["sweep", "sweep.toml", "--csv", "-q", "--out"];
    let takes = timed(&bench, &[&arguments[..], &["whole"]].concat());
    let mut draws = Draws::new("terminated sweep");
    let (mut told, mut kept, mut complete, mut early, mut signals) = (0, 0, 0, 0, Signals::new());
    while let Some(k) = signals.another() {
        let out = format!("out-{k}");
        let (status, in_time) = terminated(&bench, &[&arguments[..], &[&out]].concat(), takes, &mut draws);
        signals.sent += usize::from(in_time);
        assert!(is_known(status), "{k}: {status:?}");
        match status.code() {
            Some(143) => told += 1,
            Some(_) => complete += 1,
            None => early += 1,
        }
        if bench.0.join(&out).join("plan.json").exists() {
            let status = bench.json(&["sweep", "status", "--plan", &out, "--json"]);
            kept += status["status"]["shards_done"].as_u64().expect("a number");
            assert_eq!(status["status"]["faults"], serde_json::json!([]), "{k}");
        }
        assert_eq!(bench.run(&[&arguments[..], &[&out]].concat()).0, 0, "{k}: it goes on");
        assert_eq!(bench.text(&format!("{out}/sweep.csv")), bench.text("whole/sweep.csv"), "{k}");
        fs::remove_dir_all(bench.0.join(&out)).expect("it is there");
    }
    println!(
        "sweep: {} signals, {told} ended in order, {complete} complete, {early} before they began; {kept} shards kept",
        signals.sent
    );
    assert!(5 * early <= told + complete + 4, "{early} were killed");
    assert!(bench.left().iter().all(|name| !name.starts_with('.')), "{:?}", bench.left());
}
