//! The program from outside: exit codes, messages, and what is left on the disk.
//!
//! Goal: whatever is wrong with the input is said with its place and the next move, and no run
//! leaves anything half-written. Expected: the texts below; they are golden.

use std::fs;
use std::process::Command;

use crate::bench::{Bench, skipped};

const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";
/// A run of a tenth of a second.
const SHORT: &str = "[run]\nduration = \"0.1 s\"\n";
const VERLET: &str = "error: s: integrator.method = \"verlet\" is for models without damping, memory or a changing pressure; take \"auto\"\n";

impl Bench {
    /// Exit code and stderr of `efam simulate s.toml` with that text.
    fn simulate(&self, scenario: &str, arguments: &[&str]) -> (i32, String) {
        self.file("s.toml", scenario);
        let (code, _, stderr) = self.run(&[&["simulate", "s.toml", "--out", "out"], arguments].concat());
        (code, stderr)
    }

    fn summary(&self) -> serde_json::Value {
        serde_json::from_str(&self.text("out/summary.json")).expect("it is JSON")
    }
}

#[test]
fn every_slip_in_a_scenario_has_its_message_and_code_2() {
    let bench = Bench::new("slips");
    let with = |text: &str| format!("{MUSCLE}{text}\n");
    for (scenario, expected) in [
        (
            with("presure = 1"),
            "error: s.toml:4:1: muscle.presure: unknown key; did you mean `pressure`?; known here are name, file, text, pressure, stiffness, extrapolation, mass\n",
        ),
        (
            with("[effects.payload]\nmass = \"80 psi\""),
            "error: s.toml:5:8: effects.payload.mass: \"80 psi\" is a pressure, but a mass is due, such as \"80 g\" or \"80 kg\"\n",
        ),
        (
            with("[effects.payload]\nmass = \"-80 g\""),
            "error: s.toml:5:8: effects.payload.mass = \"-80 g\": must lie in 0..=100 kg\n",
        ),
        (
            with("[effects.payload]\nmass = 80"),
            "error: s.toml:5:8: effects.payload.mass: 80: needs a unit of mass, such as \"80 g\" or \"80 kg\"\n",
        ),
        (
            with("[effects.payload]\nmass = nan"),
            "error: s.toml:5:8: effects.payload.mass: nan: the number must be finite\n",
        ),
        (
            with("[integrator]\ntolerance = nan"),
            "error: s.toml:5:13: integrator.tolerance: nan: the number must be finite\n",
        ),
        (
            with("[rod]\nnodes = 3"),
            "error: s.toml:5:9: rod.nodes = 3: must lie in 4..=2000; 16 resolve the paper's muscle to 0.02 mm\n",
        ),
        (with("[rod]\nnodes = 32.5"), "error: s.toml:5:9: rod.nodes = 32.5: a whole number is due\n"),
        (
            with("[integrator]\nmethod = \"rodas\""),
            "error: s.toml:5:10: integrator.method = \"rodas\": unknown; did you mean `rodas4`?; known here are auto, verlet, rodas4, tr_bdf2, esdirk34\n",
        ),
        (
            MUSCLE.replace("15 psi", "140 psi"),
            "error: s.toml:3:12: muscle.pressure = 140 psi (965.266 kPa): outside the table of garbulinski-2022, 5 to 100 psi (34.474 to 689.476 kPa); choose a pressure inside, or set extrapolation = \"allowed\"\n",
        ),
        (
            MUSCLE.replace("name = \"garbulinski-2022\"", "file = \"mine.toml\""),
            "error: s.toml:2:8: muscle.file: mine.toml: cannot be read (No such file or directory (os error 2)); check the path\n",
        ),
    ] {
        let (code, stderr) = bench.simulate(&scenario, &[]);
        assert_eq!((code, stderr.as_str()), (2, expected), "{scenario}");
    }
    let (code, stderr) = bench.simulate(
        &with("[effects.rayleigh_mass]\nalpha = \"0.5 1/s\"\n[integrator]\nmethod = \"verlet\""),
        &[],
    );
    assert_eq!((code, stderr.as_str()), (2, VERLET));
    // The reader of TOML may word it otherwise one day; the place is ours.
    let (code, stderr) = bench.simulate(&with("[rod\n"), &[]);
    assert_eq!(code, 2);
    assert!(stderr.starts_with("error: s.toml:4:5: "), "{stderr}");
    assert_eq!(bench.left(), ["s.toml"]);
}

#[test]
fn a_missing_scenario_and_broken_data_are_told_apart() {
    let bench = Bench::new("missing");
    let (code, _, stderr) = bench.run(&["simulate", "none.toml"]);
    assert_eq!(code, 2);
    assert_eq!(
        stderr,
        "error: none.toml: cannot be read (No such file or directory (os error 2)); check the path\n"
    );
    bench.file("mine.toml", "name = 3\n");
    let (code, stderr) = bench.simulate(MUSCLE, &["--muscle", "mine.toml"]);
    assert_eq!(code, 3, "{stderr}");
    assert!(
        stderr.starts_with("error: --set muscle.file=\"mine.toml\": muscle.file: mine.toml: "),
        "{stderr}"
    );
    bench.file("points.csv", "0,0\n0.1\n");
    let (code, stderr) = bench.simulate(MUSCLE, &["--set", "release.posture=points.csv"]);
    assert_eq!(code, 3);
    assert!(stderr.contains("points.csv:2: 1 values, not 2 or 4; the form is x_m,z_m"), "{stderr}");
}

#[test]
fn a_run_leaves_its_results_and_one_object_on_stdout() {
    let bench = Bench::new("run");
    bench.file("s.toml", &format!("{MUSCLE}{SHORT}"));
    let run = |out: &str, more: &[&str]| {
        let (code, stdout, stderr) =
            bench.run(&[&["simulate", "s.toml", "--json", "--csv", "--out", out], more].concat());
        assert_eq!((code, stderr.as_str()), (0, ""));
        serde_json::from_str::<serde_json::Value>(&stdout).expect("one JSON object")
    };
    let first = run("one", &["--pressure", "40psi", "--set", "effects.payload.mass=50 g"]);
    assert_eq!(first["runs"][0]["status"]["kind"], "complete");
    assert_eq!(first["runs"][0]["samples"], 11);
    // What was resolved is a scenario, and gives the same bits.
    fs::copy(bench.0.join("one/scenario.resolved.toml"), bench.0.join("s.toml")).expect("copied");
    run("two", &[]);
    for file in ["trajectory.csv", "scenario.resolved.toml"] {
        let read = |run: &str| fs::read_to_string(bench.0.join(run).join(file)).expect("written");
        assert_eq!(read("one"), read("two"));
    }
    let (code, _, stderr) = bench.run(&["simulate", "s.toml", "--out", "one"]);
    assert_eq!(code, 2);
    assert_eq!(stderr, "error: one: exists already; choose another --out, or replace it with --overwrite\n");
    assert_eq!(bench.run(&["simulate", "s.toml", "--out", "one", "--overwrite", "-q"]).0, 0);
    assert!(!bench.0.join("one/trajectory.csv").exists());
}

#[test]
fn extrapolation_warns_on_stderr_and_in_the_summary() {
    let bench = Bench::new("extrapolation");
    let (code, stderr) = bench.simulate(
        &format!("{MUSCLE}extrapolation = \"allowed\"\n{SHORT}"),
        &["--set", "muscle.pressure=140 psi"],
    );
    let text = "muscle.pressure: 140 psi (965.266 kPa) lies outside the table, 5 to 100 psi \
                (34.474 to 689.476 kPa): extrapolated along straight lines";
    assert_eq!((code, stderr), (0, format!("warning: {text}\n")));
    assert_eq!(bench.summary()["warnings"][0], text);
}

#[test]
fn a_run_that_cannot_go_on_keeps_what_there_is() {
    let bench = Bench::new("steps");
    let (code, stderr) = bench.simulate(MUSCLE, &["--set", "integrator.most_steps=50"]);
    assert_eq!(code, 4);
    assert!(stderr.starts_with("error: 50 steps brought the run only to t = "), "{stderr}");
    assert!(stderr.contains("raise integrator.most_steps"), "{stderr}");
    assert!(stderr.trim_end().ends_with("are in out, marked in summary.json"), "{stderr}");
    assert_eq!(bench.summary()["status"]["kind"], "failed");
}

#[test]
fn more_damping_than_any_muscle_has_is_only_slow() {
    let bench = Bench::new("damping");
    let damped =
        "[effects.rayleigh_mass]\nalpha = \"1e6 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"1e3 s\"\n";
    let (code, stderr) = bench.simulate(&format!("{MUSCLE}{SHORT}{damped}"), &[]);
    assert!(matches!((code, stderr.as_str()), (0, "")) || code == 4, "{code}: {stderr}");
    let kind = bench.summary()["status"]["kind"].clone();
    assert!(if code == 0 { kind == "complete" } else { kind == "failed" }, "{kind}");
}

/// A terabyte, or whatever this machine has: refused before it begins.
#[cfg(target_os = "linux")]
#[test]
fn a_run_that_memory_cannot_hold_is_refused() {
    let bench = Bench::new("long");
    let (code, stderr) = bench.simulate(
        &format!("{MUSCLE}[rod]\nnodes = 2000\n[run]\nduration = \"99999 s\"\nrate = \"100 Hz\"\n"),
        &[],
    );
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.starts_with("error: s: 9999901 samples of this rod take some 128"), "{stderr}");
    let next = "are free; lower run.rate, run.duration or rod.nodes, or keep none: --rerun HOW --watch-only";
    assert!(stderr.trim_end().ends_with(next), "{stderr}");
    assert_eq!(bench.left(), ["s.toml"]);
}

#[test]
fn outputs_that_cannot_be_written_leave_nothing() {
    let bench = Bench::new("unwritable");
    bench.file("outputs", "a file where the folder should be");
    bench.file("s.toml", &format!("{MUSCLE}{SHORT}"));
    let (code, stdout, stderr) = bench.run(&["simulate", "s.toml"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(
        stderr.starts_with("error: outputs: is a file where a folder is due; choose another --out"),
        "{stderr}"
    );
    assert_eq!(bench.left(), ["outputs", "s.toml"]);
    // A full device in place of stdout.
    #[cfg(target_os = "linux")]
    {
        let full = fs::File::options().write(true).open("/dev/full").expect("Linux has it");
        let output = bench.command(&["effects"]).stdout(full).output().expect("efam runs");
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: stdout: cannot be written ("));
    }
}

/// A disk of 32 kB, where this user may mount one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_half_written() {
    let bench = Bench::new("full");
    bench.file("s.toml", MUSCLE);
    let disk = bench.0.join("disk");
    fs::create_dir(&disk).expect("made");
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=32k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|mount| mount.status.success()) {
        skipped("disk", "no small disk can be mounted here");
        return;
    }
    let (code, stdout, stderr) = bench.run(&["simulate", "s.toml", "--csv", "--out", "disk/out"]);
    let left = fs::read_dir(&disk).expect("the disk is there").count();
    let _ = Command::new("umount").arg(&disk).status();
    assert_eq!((code, stdout.as_str(), left), (1, "", 0), "{stderr}");
    assert!(stderr.contains("error: disk/out/"), "{stderr}");
    assert!(stderr.contains(": cannot be written: No space left on device"), "{stderr}");
}

#[test]
fn all_rows_are_the_same_on_any_number_of_threads() {
    let bench = Bench::new("threads");
    bench.file("s.toml", &format!("{}{SHORT}", MUSCLE.replace("15 psi", "all rows")));
    for threads in ["1", "3"] {
        let run = bench
            .command(&["simulate", "s.toml", "--csv", "-q", "--out", threads])
            .env("RAYON_NUM_THREADS", threads)
            .status();
        assert!(run.is_ok_and(|run| run.success()));
    }
    for case in ["s-005psi", "s-040psi", "s-100psi"] {
        for file in ["trajectory.csv", "release.svg", "scenario.resolved.toml"] {
            let read = |threads: &str| {
                fs::read_to_string(bench.0.join(threads).join(case).join(file)).expect("it was written")
            };
            assert_eq!(read("1"), read("3"));
        }
    }
}

#[test]
fn effects_are_listed_and_their_pages_shown() {
    let bench = Bench::new("effects");
    let (code, stdout, _) = bench.run(&["effects"]);
    assert_eq!(code, 0);
    assert!(stdout.contains("elastic: gives back what it stores\n  stretch "), "{stdout}");
    let row = stdout.lines().find(|line| line.trim_start().starts_with("air_density ")).expect("a row");
    assert!(row.contains("  1.2 kg/m^3  ") && row.contains("  0 to 2000 kg/m^3  "), "{row}");
    assert!(row.ends_with("  off at 0"), "{row}");
    let (code, stdout, _) = bench.run(&["effects", "payload"]);
    assert_eq!(code, 0);
    assert!(stdout.starts_with("Payload: a rigid body is carried at the tip."), "{stdout}");
    let (code, stdout, stderr) = bench.run(&["effects", "payoad"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(stderr.starts_with("error: no effect `payoad`; did you mean `payload`?; there are "), "{stderr}");
    let (_, stdout, _) = bench.run(&["effects", "--json"]);
    let object: serde_json::Value = serde_json::from_str(&stdout).expect("one JSON object");
    assert_eq!(object["effects"][0]["name"], "stretch");
}

#[test]
fn the_command_line_itself_is_checked() {
    let bench = Bench::new("usage");
    assert_eq!(bench.run(&["simulat"]).0, 2);
    assert_eq!(bench.run(&["simulate", "s.toml", "--rerun", "show"]).0, 2);
    let (code, stdout, _) = bench.run(&["--help"]);
    assert_eq!(code, 0);
    assert!(stdout.contains("130  Ctrl-C: ") && stdout.contains("143  the same by SIGTERM"), "{stdout}");
}

#[test]
fn how_much_is_said_is_for_the_user_to_say() {
    let bench = Bench::new("manner");
    bench.file("s.toml", &format!("{MUSCLE}{SHORT}"));
    let said = |arguments: &[&str]| {
        let (code, stdout, stderr) = bench.run(arguments);
        assert_eq!(code, 0, "{arguments:?}: {stderr}");
        (stdout, stderr)
    };
    let (table, nothing) = said(&["simulate", "s.toml", "--out", "plain"]);
    assert!(table.starts_with("run  ") && nothing.is_empty(), "{table}{nothing}");
    let (table, details) = said(&["-v", "simulate", "s.toml", "--out", "verbose"]);
    assert!(table.starts_with("run  "), "{table}");
    for part in
        [" s] s.toml: 1 to simulate, on ", " s: 0.1 s with ", " nodes by Verlet: ", "written to verbose"]
    {
        assert!(details.contains(part), "{part}\n{details}");
    }
    for arguments in [&["statics", "s.toml"][..], &["modes", "s.toml"], &["effects"], &["effects", "payload"]]
    {
        assert!(said(arguments).0.len() > 50, "{arguments:?}");
        let quiet = said(&[arguments, &["--quiet"]].concat());
        assert_eq!(quiet, (String::new(), String::new()), "{arguments:?}");
        let json = said(&[arguments, &["--quiet", "--json"]].concat());
        assert!(json.0.starts_with('{'), "{arguments:?}: {}", json.0);
    }
    assert_eq!(bench.run(&["effects", "-q", "-v"]).0, 2, "one or the other");
}

#[test]
fn colours_are_used_where_they_are_wanted() {
    let bench = Bench::new("colour");
    bench.file("s.toml", &format!("{MUSCLE}presure = 1\n"));
    let is_colored = |arguments: &[&str]| {
        let (code, _, stderr) = bench.run(arguments);
        assert_eq!(code, 2, "{stderr}");
        stderr.contains('\u{1b}')
    };
    for wrong in [&["simulat"][..], &["simulate", "s.toml"]] {
        assert!(!is_colored(wrong), "{wrong:?}: nobody looks");
        assert!(is_colored(&[wrong, &["--color", "always"]].concat()), "{wrong:?}");
        assert!(!is_colored(&[wrong, &["--color=never"]].concat()), "{wrong:?}");
    }
}

#[test]
fn statics_and_modes_of_a_ruler() {
    let bench = Bench::new("ruler");
    // A light steel ruler is a linear cantilever: m g l^3 / 8 EI down, 3.516 / 2 pi sqrt(EI / m l^3).
    bench.file(
        "s.toml",
        "[rod]\nlength = \"0.1 m\"\nmass = \"1 g\"\nbending_stiffness = \"0.05 N m^2\"\naxial_stiffness = \"1e6 N\"\n",
    );
    let object = |command: &str| {
        let (code, stdout, stderr) = bench.run(&[command, "s.toml", "--json"]);
        assert_eq!((code, stderr.as_str()), (0, ""));
        serde_json::from_str::<serde_json::Value>(&stdout).expect("one JSON object")
    };
    let sag = object("statics")["statics"][0]["tip_z_m"].as_f64().expect("a number");
    let expected = -1e-3 * 9.81 * 1e-3 / (8.0 * 0.05);
    // Second order in the edge length, 31 edges.
    assert!((sag / expected - 1.0).abs() < 2e-3, "{sag} {expected}");
    let frequency = object("modes")["modes"][0]["frequency_hz"].as_f64().expect("a number");
    let expected = 3.516 / std::f64::consts::TAU * (0.05_f64 / (1e-3 * 1e-3)).sqrt();
    assert!((frequency / expected - 1.0).abs() < 2e-3, "{frequency} {expected}");
}

/// The flags of `efam predict` say the same to `efam simulate`, as the keys of a scenario do; a key by
/// both is refused.
#[test]
fn a_release_is_said_by_flags_as_by_keys() {
    let bench = Bench::new("flags");
    let text = format!("{MUSCLE}[rod]\nnodes = 8\n[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n");
    let flags = ["--payload", "80g", "--duration", "0.2s", "--angle=-20deg", "--payload-center", "1 in"];
    let (code, stderr) = bench.simulate(&text, &[&flags[..], &["--payload-inertia", "1e-5 kg m^2"]].concat());
    assert_eq!(code, 0, "{stderr}");
    let by_flags = bench.summary();
    let keys = "[release]\nangle = \"-20 deg\"\n[run]\nduration = \"0.2 s\"\n[effects.payload]\nmass = \"80 g\"\n\
                center_of_mass = \"1 in\"\nrotary_inertia = \"1e-5 kg m^2\"\n";
    assert_eq!(bench.simulate(&format!("{text}{keys}"), &["--overwrite"]).0, 0);
    let by_keys = bench.summary();
    for entry in ["parameters", "lowest", "rest", "simulated_s"] {
        assert_eq!(by_flags[entry], by_keys[entry], "{entry}");
    }
    let both =
        ["--payload", "80g", "--set", "effects.payload.mass=\"30 g\"", "--duration", "0.1 s", "--overwrite"];
    let (code, stderr) = bench.simulate(&text, &both);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("both give effects.payload.mass; keep one of them"), "{stderr}");
    for (flag, expected) in [
        (["--payload", "-5 g"], "error: --payload -5 g: it must not be negative"),
        (["--payload", "5 m"], "error: --payload 5 m: \"5 m\" is a length, but a mass is due"),
        (["--duration", "5"], "error: --duration 5:"),
        (["--angle", "3 kg"], "error: --angle 3 kg: \"3 kg\" is a mass, but an angle is due"),
    ] {
        let (code, stderr) = bench.simulate(&text, &flag);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.starts_with(expected), "{stderr}");
    }
}
