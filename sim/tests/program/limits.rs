//! Limits of the system and inputs beyond measure.
//!
//! Goal: what cannot be had is said, or done without; what cannot be read is refused with a reason; numbers stay
//! readable however small or large they are.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, program, skipped};

const SCENARIO: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
    [run]\nduration = \"0.5 s\"\n[effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n";

/// Exit code, stdout and stderr of what has to end soon: a program that waits for ever is one that hangs.
fn soon(mut command: Command) -> (Option<i32>, String, String) {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("efam runs");
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            let _ = child.kill();
        }
        sleep(Duration::from_millis(5));
    }
    let Output { status, stdout, stderr } = child.wait_with_output().expect("it ended");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn a_number_of_threads_that_is_none_is_refused() {
    let bench = Bench::new("limits-threads");
    bench.file("s.toml", SCENARIO);
    for value in ["x", "0", "-1", "1.5", "2 3", "1000000", "99999999999999999999"] {
        let mut command = bench.command(&["simulate", "s.toml", "--out", "out"]);
        command.env("RAYON_NUM_THREADS", value);
        let (code, _, stderr) = soon(command);
        let expected = format!("error: RAYON_NUM_THREADS = {value}: must be a whole number from 1 to 1024; ");
        assert!(code == Some(2) && stderr.starts_with(&expected), "{value}: {code:?} {stderr}");
    }
    for value in ["1", "3", ""] {
        let mut command = bench.command(&["doctor"]);
        let (code, _, stderr) =
            soon(std::mem::replace(command.env("RAYON_NUM_THREADS", value), Command::new("true")));
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{value:?}");
    }
    assert_eq!(bench.left(), ["s.toml"]);
}

/// The program under a limit on processes. It counts all of a user, and does not bind root: who is root becomes a user
/// without any other process.
#[cfg(target_os = "linux")]
fn limited(bench: &Bench, processes: usize, arguments: &[&str]) -> Option<(Option<i32>, String, String)> {
    use std::os::unix::fs::PermissionsExt;

    let is_root = Command::new("id").arg("-u").output().is_ok_and(|id| id.stdout == b"0\n");
    let limit = ["prlimit".to_owned(), format!("--nproc={processes}"), program().display().to_string()];
    let mut words: Vec<String> =
        limit.into_iter().chain(arguments.iter().map(|own| (*own).to_owned())).collect();
    if is_root {
        fs::set_permissions(&bench.0, fs::Permissions::from_mode(0o777)).expect("it is ours");
        let user = 61_184 + std::process::id() % 4096;
        let become_user = ["setpriv".into(), format!("--reuid={user}"), "--clear-groups".into()];
        words = become_user.into_iter().chain(words).collect();
        let tried = Command::new(&words[0]).args(&words[1..3]).arg(program()).arg("--version").output();
        if !tried.is_ok_and(|tried| tried.status.success()) {
            skipped("user", "another user cannot run the program here");
            return None;
        }
    }
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).current_dir(&bench.0).env("RAYON_NUM_THREADS", "4");
    Some(soon(command))
}

/// Half of these runs get some of the threads that they request, the first none at all.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn without_threads_all_is_done_on_one() {
    let bench = crate::work::bench("limits-processes");
    let whole = bench.json(&["simulate", "s.toml", "--csv", "--json", "--out", "whole"]);
    assert_eq!(whole["runs"][0]["status"]["kind"], "complete");
    bench.json(&["sweep", "sweep.toml", "--points-per-shard", "2", "--csv", "--json", "--out", "swept"]);
    for processes in 1..6 {
        let out = format!("out-{processes}");
        let arguments = ["simulate", "s.toml", "--csv", "--json", "--out", &out];
        let Some((code, stdout, stderr)) = limited(&bench, processes, &arguments) else { return };
        assert_eq!(code, Some(0), "{processes} processes: {stderr}");
        assert!(serde_json::from_str::<serde_json::Value>(&stdout).is_ok(), "{stdout}");
        let is_told = stderr.contains("of 4 can be had (");
        assert_eq!(is_told, processes < 6, "{processes} processes: {stderr}");
        assert!(processes > 1 || stderr.starts_with("warning: one thread of 4 can be had"), "{stderr}");
        assert_eq!(bench.text(&format!("{out}/trajectory.csv")), bench.text("whole/trajectory.csv"));
        // Each of its shards is written by a thread of its own, if there is one.
        let out = format!("swept-{processes}");
        let arguments = ["sweep", "sweep.toml", "--points-per-shard", "2", "--csv", "-q", "--out", &out];
        let (code, _, stderr) = limited(&bench, processes, &arguments).expect("it could be limited");
        assert_eq!(code, Some(0), "{processes} processes: {stderr}");
        assert_eq!(bench.text(&format!("{out}/sweep.csv")), bench.text("swept/sweep.csv"));
    }
    for command in [&["calibrate", "e.toml"][..], &["analyse", "e.toml"], &["doctor"]] {
        let (code, _, stderr) =
            limited(&bench, 1, &[command, &["-q"]].concat()).expect("it could be limited");
        assert_eq!(code, Some(0), "{command:?}: {stderr}");
    }
}

/// Eight times as many markers take 8 times as long if all is linear, and 64 times if all are compared with all.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn time_grows_with_the_number_of_markers_and_no_faster() {
    let bench = Bench::new("limits-markers");
    let table = |count: usize| {
        let names: String = (0..count).map(|k| format!(",m{k}_x_m,m{k}_z_m")).collect();
        // All move as one body, or each by itself.
        let row = |t: usize| {
            let cells: String = (0..count).map(|k| format!(",0.{t},{}", t * (k % 2))).collect();
            format!("0.0{t}{cells}\n")
        };
        format!("t_s{names}\n{}", (0..3).map(row).collect::<String>())
    };
    let trc = |count: usize| {
        let names = "A\t\t\t".repeat(count);
        let axes: String = (1..=count).map(|k| format!("\tX{k}\tY{k}\tZ{k}")).collect();
        let row = |t: usize| format!("{t}\t0.0{t}{}\n", format!("\t{t}\t1\t0").repeat(count));
        format!(
            "PathFileType\t4\t(X/Y/Z)\tx.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t\
             OrigDataStartFrame\tOrigNumFrames\n100\t100\t3\t{count}\tmm\t100\t1\t3\nFrame#\tTime\t{names}\n\t{axes}\n{}",
            (1..=3).map(row).collect::<String>()
        )
    };
    for (name, count) in [("few", 8_000), ("many", 64_000)] {
        bench.file(&format!("{name}.csv"), &table(count));
        bench.file(&format!("{name}.trc"), &trc(count));
    }
    for ending in ["csv", "trc"] {
        for command in [&["inspect", "--json"][..], &["experiment", "init", "--overwrite"]] {
            let time = |name: &str| {
                let (file, begin) = (format!("{name}.{ending}"), Instant::now());
                let done = bench.command(&[command, &[&file]].concat()).output().expect("efam runs");
                assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
                begin.elapsed().as_secs_f64()
            };
            // The machine has other work at times: the shortest of each, measured in turns.
            let [few, many] = (0..3).fold([f64::INFINITY; 2], |least, _| {
                let [few, many]: [f64; 2] = least;
                [few.min(time("few")), many.min(time("many"))]
            });
            let ratio = many / few;
            assert!(
                ratio < 22.0,
                "{command:?} of {ending}: {ratio:.1} times as long for 8 times as many markers"
            );
        }
    }
}

/// A link to a device that never ends takes neither time nor memory, in the place of any file of a folder.
#[cfg(target_os = "linux")]
#[test]
fn a_link_to_a_device_that_never_ends_is_refused() {
    let bench = Bench::new("limits-endless");
    bench.file("s.toml", SCENARIO);
    bench.file(
        "sweep.toml",
        "[sweep]\nscenario = \"s.toml\"\ndesign = \"grid\"\n[[sweep.parameter]]\n\
         path = \"effects.payload.mass\"\nvalues = [\"0 g\", \"9 g\"]\n",
    );
    bench.json(&["simulate", "s.toml", "--csv", "--json", "--out", "run"]);
    bench.json(&["sweep", "sweep.toml", "--json", "--out", "sweep"]);
    let endless = |file: &str| {
        fs::remove_file(bench.0.join(file)).expect("it is there");
        std::os::unix::fs::symlink("/dev/zero", bench.0.join(file)).expect("a link");
    };
    let limited = |arguments: &[&str]| {
        // The program itself maps some 0.6 GB.
        let mut command = Command::new("prlimit");
        command.arg("--as=2000000000").arg(program()).args(arguments).current_dir(&bench.0);
        soon(command)
    };
    for (file, arguments) in [
        ("run/trajectory.parquet", &["export", "run", "--to", "mat"][..]),
        ("run/trajectory.parquet", &["inspect", "run/trajectory.parquet"]),
        ("sweep/shard=00001/part.parquet", &["sweep", "merge", "--plan", "sweep"]),
        ("sweep/points.csv", &["sweep", "status", "--plan", "sweep"]),
        ("run/summary.json", &["report", "run"]),
        ("s.toml", &["simulate", "s.toml"]),
    ] {
        endless(file);
        let (code, _, stderr) = limited(arguments);
        assert!(matches!(code, Some(1..=3)), "{arguments:?}: {code:?} {stderr}");
        let name = file.rsplit('/').next().expect("a name");
        assert!(stderr.starts_with("error: ") && stderr.contains(name), "{arguments:?}: {stderr}");
        assert!(!stderr.contains("out of memory"), "{arguments:?}: {stderr}");
    }
    fs::remove_file(bench.0.join("s.toml")).expect("a link");
    bench.file("s.toml", SCENARIO);
    // What efam writes does not take it for its own either.
    endless("sweep/sweep.json");
    let (code, _, stderr) = limited(&["sweep", "sweep.toml", "-q", "--out", "sweep", "--overwrite"]);
    assert!(code == Some(2) && stderr.contains("which efam did not write"), "{stderr}");
}

/// 3 GB of nothing, which takes no room on the disk.
#[test]
fn a_summary_beyond_measure_is_refused_before_it_is_read() {
    let bench = Bench::new("limits-summary");
    fs::create_dir(bench.0.join("run")).expect("made");
    let file = File::create(bench.0.join("run/summary.json")).expect("made");
    file.set_len(3 << 30).expect("a file system with holes");
    for arguments in [&["report", "run"][..], &["export", "run", "--to", "mat"]] {
        let mut command = Command::new("sh");
        // A gigabyte is enough for what is admitted.
        let script = "ulimit -v 1500000; exec \"$@\"";
        command.args(["-c", script, "sh"]).arg(program()).args(arguments).current_dir(&bench.0);
        let (code, _, stderr) = soon(command);
        assert_eq!(code, Some(3), "{arguments:?}: {stderr}");
        assert!(stderr.contains("run/summary.json: cannot be read (it has more than "), "{stderr}");
    }
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_not_waited_for_and_one_of_the_shell_is_read() {
    let bench = Bench::new("limits-pipe");
    assert!(Command::new("mkfifo").arg(bench.0.join("pipe")).status().expect("mkfifo runs").success());
    bench.file("s.toml", SCENARIO);
    bench.file("with-pipe.toml", &SCENARIO.replace("name = \"garbulinski-2022\"", "file = \"pipe\""));
    for arguments in [
        &["simulate", "pipe"][..],
        &["statics", "pipe"],
        &["simulate", "with-pipe.toml"],
        &["simulate", "s.toml", "--muscle", "pipe"],
        &["predict", "pipe"],
        &["predict", "--muscle", "pipe", "--pressure", "15psi"],
        &["experiment", "check", "pipe"],
        &["calibrate", "pipe"],
        &["sweep", "pipe"],
        &["inspect", "pipe"],
    ] {
        let (code, _, stderr) = soon(bench.command(arguments));
        assert!(matches!(code, Some(2 | 3)), "{arguments:?}: {code:?} {stderr}");
        assert!(
            stderr.contains("is a named pipe") || stderr.contains("is no file"),
            "{arguments:?}: {stderr}"
        );
    }
    let mut command = bench.command(&["simulate", "/dev/stdin", "-q", "--out", "out"]);
    let mut child = command.stdin(Stdio::piped()).spawn().expect("efam runs");
    child.stdin.take().expect("it is piped").write_all(SCENARIO.as_bytes()).expect("it reads");
    assert!(child.wait().expect("it ends").success());
    assert!(bench.0.join("out/summary.json").is_file());
}

/// In a folder of results, too: what is read is a file.
#[cfg(unix)]
#[test]
fn a_named_pipe_among_results_is_not_waited_for() {
    let bench = crate::work::bench("limits-pipes");
    bench.json(&["simulate", "s.toml", "--json", "--out", "swung"]);
    bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "plan"]);
    bench.json(&["sweep", "sweep.toml", "--json", "--out", "swept"]);
    for (file, arguments) in [
        ("swung/trajectory.parquet", &["export", "swung", "--to", "mat"][..]),
        ("swung/summary.json", &["report", "swung"]),
        ("plan/points.csv", &["sweep", "run", "--plan", "plan"]),
        ("plan/plan.json", &["sweep", "status", "--plan", "plan"]),
        ("swept/shard=00000/part.parquet", &["sweep", "status", "--plan", "swept"]),
    ] {
        let file = bench.0.join(file);
        fs::remove_file(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(Command::new("mkfifo").arg(&file).status().expect("mkfifo runs").success());
        let (code, stdout, stderr) = soon(bench.command(arguments));
        assert!(matches!(code, Some(0..=4)), "{arguments:?}: {code:?} {stderr}");
        let said = stdout + &stderr;
        assert!(
            ["is a named pipe", "is no run"].iter().any(|text| said.contains(text)),
            "{arguments:?}: {said}"
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_is_an_error() {
    let bench = Bench::new("limits-full");
    for arguments in
        [&["--help"][..], &["--version"], &["simulate", "--help"], &["effects"], &["man"], &["doctor"]]
    {
        let full = File::options().write(true).open("/dev/full").expect("Linux has it");
        let mut child =
            bench.command(arguments).stdout(full).stderr(Stdio::piped()).spawn().expect("efam runs");
        let mut stderr = String::new();
        child.stderr.take().expect("it is piped").read_to_string(&mut stderr).expect("text");
        let code = child.wait().expect("it ends").code();
        assert_eq!(code, Some(1), "{arguments:?}: {stderr}");
        assert!(
            stderr.starts_with("error: stdout: cannot be written (No space left"),
            "{arguments:?}: {stderr}"
        );
    }
}

/// The longest run of digits in a text.
fn digits(text: &str) -> usize {
    text.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0)
}

#[test]
fn times_that_cannot_be_are_refused_and_no_number_fills_a_page() {
    let bench = Bench::new("limits-times");
    let recording = |times: [&str; 4]| {
        let row = |(k, time): (usize, &str)| format!("{time},0.{k},0,0.{}\n", k * k);
        format!("t_s,A_x_m,A_y_m,A_z_m\n{}", times.into_iter().enumerate().map(row).collect::<String>())
    };
    // An unset clock; a clock in which 10 ms are no difference; two that are all right.
    for (times, expected) in [
        (["-5e303", "0", "0.01", "0.02"], Some("does not resolve a step of 0.01 s")),
        (["0", "0.01", "0.02", "1e300"], Some("does not resolve a step")),
        (["3.1e12", "3.1000000000005e12", "3.100000000001e12", "3.1000000000015e12"], None),
        (["1763900000.00", "1763900000.01", "1763900000.02", "1763900000.03"], None),
    ] {
        bench.file("a.csv", &recording(times));
        let (code, stdout, stderr) = bench.run(&["inspect", "a.csv"]);
        assert_eq!(code, if expected.is_some() { 3 } else { 0 }, "{times:?}: {stdout}{stderr}");
        assert!(expected.is_none_or(|text| stderr.contains(text)), "{stderr}");
        assert!(digits(&stdout).max(digits(&stderr)) <= 18, "{stdout}{stderr}");
    }
    // Places and orders beyond measure are said in few digits.
    for text in [
        "t_s,A_x_m,A_y_m,A_z_m\n0,1e300,0,0\n0.01,-1e300,0,0\n0.02,0,0,0\n",
        "t_s,A_x_m,A_y_m,A_z_m\n0,1,0,0\n-1e300,2,0,0\n0.02,0,0,0\n",
        "t_s,A_x_m,A_y_m,A_z_m\n0,1,0,0\n1e-300,2,0,0\n2e-300,0,0,0\n",
    ] {
        bench.file("a.csv", text);
        let (_, stdout, stderr) = bench.run(&["inspect", "a.csv"]);
        assert!(digits(&stdout).max(digits(&stderr)) <= 18, "{stdout}{stderr}");
    }
}

#[test]
fn a_c3d_whose_first_frame_is_after_its_last_is_refused() {
    let bench = Bench::new("limits-frames");
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/cases/lab_esc.c3d");
    let mut bytes = fs::read(case).expect("it is kept");
    // Words 4 and 5 of the header, Intel's order: first and last frame. Source: C3D User Guide, the header.
    bytes[6..8].copy_from_slice(&900_u16.to_le_bytes());
    bytes[8..10].copy_from_slice(&12_u16.to_le_bytes());
    fs::write(bench.0.join("a.c3d"), bytes).expect("written");
    let (code, stdout, stderr) = bench.run(&["inspect", "a.c3d"]);
    assert_eq!(code, 3, "{stdout}");
    assert!(stderr.contains("its last frame, 12, is before its first, 900"), "{stderr}");
}

#[test]
fn numbers_stay_readable_however_small_they_are() {
    let bench = crate::work::bench("limits-small");
    bench.file("small.toml", &SCENARIO.replace("15 psi", "0.1 Pa"));
    let (code, _, stderr) = bench.run(&["statics", "small.toml"]);
    assert!(code == 2 && stderr.contains("muscle.pressure = 1.45e-5 psi (0.0001 kPa)"), "{stderr}");
    // A rod of a millionth of the mass: its EI is a millionth of the muscle's.
    let rod = "[rod]\nlength = \"203 mm\"\nmass = \"24.18 ug\"\nbending_stiffness = \"7e-9 N m^2\"\n\
               axial_stiffness = \"3e-4 N\"\nnodes = 16\n[effects.end_fitting]\nmass = \"54.92 ug\"\n\
               center_of_mass = \"17 mm\"\n";
    let recording = bench.text("e.toml");
    let recording =
        &recording[recording.find("[[recording]]").expect("one")..recording.find("[calibrate]").expect("it")];
    bench.file("light.toml", &format!("{rod}{}", recording.replace("pressure = \"15 psi\"\n", "")));
    let (code, stdout, stderr) = bench.run(&["analyse", "light.toml", "--out", "analysed"]);
    assert_eq!(code, 0, "{stderr}");
    let of = |label: &str| {
        stdout.lines().find(|line| line.trim().starts_with(label)).unwrap_or_else(|| panic!("{stdout}"))
    };
    assert!(of("EI from the frequency").contains("e-9 N m^2"), "{stdout}");
    assert!(of("PDER, 16 nodes").matches("e-9").count() == 2, "{stdout}");
    assert!(!stdout.contains(" 0.00000"), "{stdout}");
}

/// A loss that the recording would have below zero ends on its bound; an error has no share of zero.
#[test]
fn an_error_of_zero_is_no_share_of_it() {
    let bench = crate::work::bench("limits-zero");
    let parameters = ["rod.bending_stiffness", "effects.rayleigh_mass.alpha"]
        .map(|path| format!("[[calibrate.parameter]]\npath = \"{path}\"\n"));
    bench.file("zero.toml", &(bench.text("e.toml").replace("\"4 ms\"", "\"40 ms\"") + &parameters.concat()));
    let (code, stdout, stderr) = bench.run(&["calibrate", "zero.toml", "--out", "zero"]);
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value =
        serde_json::from_str(&bench.text("zero/calibration.json")).expect("it is JSON");
    assert_eq!(found["parameters"][1]["value"], 0.0, "{found}");
    for text in [&stdout, &bench.text("zero/report.html")] {
        let line = text.lines().find(|line| line.contains("inf ") || line.contains("inf<"));
        assert_eq!(line, None);
    }
}

#[test]
fn the_list_of_effects_is_a_table() {
    let bench = Bench::new("limits-effects");
    let (code, stdout, _) = bench.run(&["effects"]);
    assert_eq!(code, 0);
    assert!(!stdout.contains("..=") && !stdout.contains("e0"), "{stdout}");
    assert!(stdout.lines().all(|line| line.chars().count() <= 120 && line == line.trim_end()), "{stdout}");
    let effects = bench.json(&["effects", "--json"]);
    for effect in effects["effects"].as_array().expect("all") {
        let rows = effect["parameters"].as_array().expect("all").iter().chain([effect]);
        for name in rows.map(|own| own["name"].as_str().expect("a name")) {
            // Whatever follows is two blanks away.
            let is_apart =
                |line: &str| line.trim_start().strip_prefix(name).is_some_and(|rest| rest.starts_with("  "));
            assert!(stdout.lines().any(is_apart), "{name}:\n{stdout}");
        }
    }
}
