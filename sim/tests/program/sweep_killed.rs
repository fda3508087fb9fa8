//! `efam sweep` killed and interrupted at any moment.
//!
//! Goal: what is left is whole shards; the same command, or `run`, goes on and ends with the same bytes.
//! Setup: the sweep of twenty points in five shards, stretched so that a run takes a second or two.

use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::Bench;
#[cfg(unix)]
use crate::interrupted::send;
use crate::sweep::{bench, bytes, copied};

/// The bench with a longer run.
fn slow(name: &str) -> Bench {
    let bench = bench(name);
    let scenario = bench.text("s.toml").replace("[run]", "[integrator]\nfixed_step = \"0.2 ms\"\n[run]");
    bench.file("s.toml", &scenario);
    bench
}

const SHARDS: [&str; 2] = ["--points-per-shard", "4"];

/// As random as two runs of a program are: a fixed sequence of delays, on a machine that is never the same.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn killed_at_any_moment_it_ends_with_the_same_bytes() {
    let bench = slow("sweep-killed");
    bench.json(&[&["sweep", "sweep.toml", "--json", "--out", "whole"][..], &SHARDS].concat());
    copied(&bench, "whole", "killed");
    let begin = Instant::now();
    copied(&bench, "whole", "once");
    bench.json(&["sweep", "run", "--plan", "once", "--json"]);
    let whole = begin.elapsed();
    let mut killed = 0;
    for k in 0..6u32 {
        let run = ["sweep", "run", "--plan", "killed", "-q"];
        let mut child = bench.command(&run).stderr(Stdio::null()).spawn().expect("efam runs");
        sleep(whole.mul_f64(0.05 + 0.37 * f64::from(k * 5 % 6) / 6.0));
        killed += u32::from(child.try_wait().expect("a child").is_none());
        let _ = child.kill();
        let _ = child.wait();
    }
    assert!(killed > 0, "every one was faster than its killer");
    bench.json(&["sweep", "run", "--plan", "killed", "--json"]);
    bench.json(&["sweep", "merge", "--plan", "killed", "--json"]);
    let parts = (0..5).map(|shard| format!("shard={shard:05}/part.parquet"));
    for file in parts.chain(["sweep.parquet".to_owned()]) {
        let [a, b] = ["whole", "killed"].map(|folder| bytes(&bench, &format!("{folder}/{file}")));
        assert!(a == b, "{file}");
    }
}

/// Ctrl-C keeps what is whole, and says how to go on; the same command does.
#[cfg(unix)]
#[test]
fn interrupted_it_goes_on_with_the_same_command() {
    let bench = slow("sweep-interrupted");
    // Some minutes, if nobody interrupts.
    let long = ["--set", "sweep.points=4000", "--points-per-shard", "4", "--out", "out"];
    let mut command = bench.command(&[&["sweep", "sweep.toml"], &long[..]].concat());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("efam runs");
    let first = bench.0.join("out/shard=00000/part.parquet");
    let begin = Instant::now();
    while !first.is_file() {
        assert!(begin.elapsed() < Duration::from_secs(120), "no shard came");
        sleep(Duration::from_millis(5));
    }
    send("INT", child.id());
    let output = child.wait_with_output().expect("it ends");
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!((output.status.code(), output.stdout.len()), (Some(130), 0), "{stderr}");
    assert!(
        stderr.starts_with("interrupted: ") && stderr.ends_with("efam sweep run --plan out\n"),
        "{stderr}"
    );
    let status = bench.json(&["sweep", "status", "--plan", "out", "--json"]);
    assert!(status["status"]["shards_done"].as_u64() >= Some(1) && status["status"]["shards"] == 1000);
    assert_eq!(bench.left(), ["out", "s.toml", "sweep.toml"]);
    let again = bench.json(&["sweep", "run", "--plan", "out", "--shard", "0", "--json"]);
    assert_eq!(again["skipped"], 1);
}

/// As a hostile round found it: 209 points were one shard, and Ctrl-C at the 66th kept none; here they are 100.
#[cfg(unix)]
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn what_is_done_is_kept_without_a_word_about_shards() {
    let bench = slow("sweep-kept");
    let arguments = ["sweep", "sweep.toml", "--set", "sweep.points=100", "-v", "--out", "out"];
    let mut command = bench.command(&arguments);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("efam runs");
    let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    // It says every tenth of the points.
    let mut said = String::new();
    while !said.contains(" of 100 points") {
        assert!(stderr.read_line(&mut said).expect("text") > 0, "{said}");
    }
    send("INT", child.id());
    stderr.read_to_string(&mut said).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{said}");
    let status = bench.json(&["sweep", "status", "--plan", "out", "--json"]);
    let kept = status["status"]["points_done"].as_u64().expect("a number");
    // A tenth, less those in progress on each thread.
    assert!((6..100).contains(&kept), "{kept} points are kept: {said}");
    bench.json(&["sweep", "run", "--plan", "out", "--json"]);
    bench.json(&["sweep", "merge", "--plan", "out", "--json"]);
}

/// A plan is a function of its file: it holds no time, so that it is the same on every machine.
#[test]
fn a_plan_is_the_same_whenever_it_is_made() {
    let bench = slow("sweep-plan");
    let plan = |out: &str, threads: &str| {
        let mut command = bench.command(&["sweep", "plan", "sweep.toml", "-q", "--out", out]);
        assert!(command.env("RAYON_NUM_THREADS", threads).status().expect("efam runs").success());
        bytes(&bench, &format!("{out}/plan.json"))
    };
    let first = plan("first", "1");
    for k in 0..3 {
        assert!(plan(&format!("again-{k}"), "2") == first, "another plan: {}", bench.text("first/plan.json"));
    }
    assert!(!bench.text("first/plan.json").contains("second"), "{}", bench.text("first/plan.json"));
}
