//! SIGTERM in each phase of each command: reading, integration or search, analysis, tables and pages, export.
//!
//! Goal: the command ends within two seconds. What has a name is whole; what is hidden was left by a command that does not listen,
//! and the next one removes it.
//! Setup: each command is run once, then again and again with a signal at another share of that time, so that all phases are
//! reached. `-v` says which one it was. Three signals a command; `EFAM_TERMS=50` takes 50.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, program};
use crate::draws::count;
use crate::experiment::made_up;
use crate::interrupted::send;

/// Longest time from a signal to the end.
const SOON: Duration = Duration::from_secs(2);
const NAME: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = ";
const LOSS: &str =
    "[effects.rayleigh_mass]\nalpha = \"0.1 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n";
const RELEASES: &str = "[rod]\nlength = \"200 mm\"\nmass = \"55 g\"\nbending_stiffness = \"0.0075 N m^2\"\n\
    [effects.gravity]\nacceleration = \"9.81 m/s^2\"\n[[recording]]\nfile = \"releases.csv\"\ntip = \"Tip\"\n\
    base = \"Base\"\npressure = \"15 psi\"\n";

/// What is typed, with what it writes, and a file that ends a command that ends by a signal alone.
const COMMANDS: [(&[&str], Option<&str>); 17] = [
    (&["simulate", "long.toml", "--csv", "--out", "out"], None),
    (&["simulate", "long.toml", "--no-files", "--json", "--trajectory"], None),
    (&["simulate", "rows.toml", "--out", "out"], None),
    (&["calibrate", "e.toml", "--out", "out"], None),
    (&["diagnose", "e.toml", "--out", "out"], None),
    (
        &[
            "predict",
            "--muscle",
            "known.toml",
            "--pressure",
            "40 psi",
            "--draws",
            "20",
            "--duration",
            "2 s",
            "--out",
            "out",
        ],
        None,
    ),
    (
        &[
            "predict",
            "known.toml",
            "--pressure",
            "20psi,40psi",
            "--payload",
            "0g,50g",
            "--duration",
            "2 s",
            "--out",
            "out",
        ],
        None,
    ),
    (&["sweep", "sweep.toml", "--csv", "--out", "out"], None),
    (&["experiment", "check", "releases.toml", "--out", "out"], None),
    (&["analyse", "releases.toml", "--out", "out"], None),
    (&["figures", "--set", "run.duration=\"1 s\"", "--out", "out"], None),
    (&["figures", "--experiment", "releases.toml", "--out", "out"], None),
    (&["export", "run", "--to", "mat", "--out", "out.mat"], None),
    (&["export", "run", "--to", "gif", "--out", "out.gif"], None),
    (&["watch", "lab", "--every", "50 ms", "--out", "out"], Some("out/report.html")),
    (&["statics", "rows.toml", "--set", "rod.nodes=800"], None),
    (&["modes", "rows.toml", "--set", "rod.nodes=800"], None),
];

fn bench() -> Bench {
    let bench = crate::work::bench("terminated-phases");
    let run = |rest: &str| format!("[rod]\nnodes = 8\n{LOSS}[run]\n{rest}");
    let long = run("duration = \"20 s\"\nrate = \"500 Hz\"\n");
    bench.file("long.toml", &format!("{NAME}\"15 psi\"\n{long}"));
    bench.file("rows.toml", &format!("{NAME}\"all rows\"\n{}", run("duration = \"3 s\"\n")));
    bench.file("releases.csv", &made_up(4, |_| false, |_| 0.0));
    bench.file("releases.toml", RELEASES);
    fs::create_dir_all(bench.0.join("lab")).expect("the target folder can be written");
    bench.file("lab/releases.csv", &bench.text("releases.csv"));
    bench.file("lab/experiment.toml", RELEASES);
    bench
}

fn begin(bench: &Bench, arguments: &[&str]) -> Child {
    let said = File::create(bench.0.join("said")).expect("the target folder can be written");
    let mut command = Command::new("env");
    // Whoever runs the tests may have them ignore a signal.
    command.arg("--default-signal").arg(program()).args(arguments).arg("-v").current_dir(&bench.0);
    command.stdout(Stdio::null()).stderr(said).spawn().expect("efam runs")
}

/// How long a command takes undisturbed.
fn whole(bench: &Bench, arguments: &[&str], until: Option<&str>) -> Duration {
    let begun = Instant::now();
    let mut child = begin(bench, arguments);
    let is_over = |child: &mut Child| match until {
        Some(file) => bench.0.join(file).exists(),
        None => child.try_wait().expect("a child").is_some(),
    };
    while !is_over(&mut child) {
        assert!(begun.elapsed() < Duration::from_secs(300), "{arguments:?} hangs");
        sleep(Duration::from_millis(2));
    }
    if until.is_some() {
        send("TERM", child.id());
    }
    let status = child.wait().expect("it ends");
    assert!(status.success(), "{arguments:?}: {status:?} {}", bench.text("said"));
    begun.elapsed()
}

/// Removes what a command wrote.
fn tidy(bench: &Bench) {
    for name in bench.left().into_iter().filter(|name| name.starts_with("out") || name.starts_with('.')) {
        let path = bench.0.join(name);
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

/// What is left of a command is whole, or hidden where a signal killed it.
fn is_whole(bench: &Bench, arguments: &[&str], is_killed: bool) {
    for name in bench.left() {
        if name.starts_with('.') {
            assert!(is_killed, "{arguments:?} leaves {name}");
        } else if name == "out" && arguments[0] != "sweep" {
            assert!(bench.0.join("out/efam-files.json").is_file(), "{arguments:?}");
            assert!(bench.0.join("out/summary.json").is_file(), "{arguments:?}");
        }
    }
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn every_command_ends_soon_in_every_phase() {
    let bench = bench();
    let (wanted, mut all) = (count("EFAM_TERMS", 3), 0);
    let mut late = Vec::new();
    for (arguments, until) in COMMANDS {
        tidy(&bench);
        let takes = whole(&bench, arguments, until);
        let mut phases: BTreeMap<String, Duration> = BTreeMap::new();
        for k in 0..wanted {
            tidy(&bench);
            let mut child = begin(&bench, arguments);
            sleep(takes.mul_f64((k as f64 + 0.5) / wanted as f64));
            if child.try_wait().expect("a child").is_some() {
                continue;
            }
            let said = bench.text("said");
            send("TERM", child.id());
            let sent = Instant::now();
            let status = child.wait().expect("it ends");
            let took = sent.elapsed();
            assert!(
                matches!(status.code(), Some(0 | 143)) || status.signal() == Some(15),
                "{arguments:?}: {status:?} {}",
                bench.text("said")
            );
            is_whole(&bench, arguments, status.signal().is_some());
            let last = said.lines().last().unwrap_or_default();
            // Without the time and the numbers of that line.
            let words = last.rsplit_once("s] ").map_or(last, |(_, words)| words);
            let phase: String = words.chars().filter(|own| !own.is_ascii_digit()).collect();
            let longest = phases.entry(phase).or_default();
            *longest = took.max(*longest);
            if took > SOON {
                late.push(format!("{arguments:?} in {last:?}: {took:?}"));
            }
        }
        all += phases.len();
        println!("{}: {takes:.1?} in all, {phases:.3?}", arguments.join(" "));
    }
    println!("{} commands, {all} phases", COMMANDS.len());
    assert!(late.is_empty(), "{late:#?}");
}
