//! `efam doctor`, `completions` and `man`: what a program says of itself.

use std::fs;

use crate::bench::Bench;

#[test]
fn a_doctor_finds_what_is_there_and_leaves_no_trace() {
    let bench = Bench::new("doctor");
    let value = bench.json(&["doctor", "--json"]);
    assert_eq!(value["efam"], env!("CARGO_PKG_VERSION"));
    assert_eq!(value["features"][1]["name"], "rerun");
    assert_eq!(value["features"][1]["compiled_in"], cfg!(feature = "rerun"));
    assert_eq!(value["muscles"][0], "garbulinski-2022");
    assert_eq!(value["outputs"]["writable"], true);
    assert_eq!(value["faults"], serde_json::json!([]));
    assert!(bench.left().is_empty(), "{:?}", bench.left());
    let two = bench.command(&["doctor"]).env("RAYON_NUM_THREADS", "2").output().expect("efam runs");
    let table = String::from_utf8(two.stdout).expect("UTF-8");
    assert!(table.contains("\nthreads     2, on ") && table.ends_with("all is well\n"), "{table}");
}

#[test]
fn what_every_run_needs_is_a_fault() {
    let bench = Bench::new("doctor-fault");
    bench.file("outputs", "a file where the folder should be");
    let (code, stdout, stderr) = bench.run(&["doctor"]);
    assert_eq!(code, 1, "{stdout}");
    assert!(stderr.starts_with("error: outputs: is a file where a folder is due"), "{stderr}");
    assert!(stdout.contains("outputs cannot be written\n"), "{stdout}");
    assert!(stdout.ends_with("not all is well\n"), "{stdout}");
    let (code, stdout, _) = bench.run(&["doctor", "--json"]);
    assert_eq!((code, stdout.contains("\"writable\":false")), (1, true), "{stdout}");
}

/// A program called `rerun` that says another version.
#[cfg(all(unix, feature = "rerun"))]
#[test]
fn a_viewer_of_another_version_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new("doctor-viewer");
    bench.file("rerun", "#!/bin/sh\necho rerun-cli 0.20.1\n");
    fs::set_permissions(bench.0.join("rerun"), fs::Permissions::from_mode(0o755)).expect("ours");
    let output = bench.command(&["doctor"]).env("PATH", &bench.0).output().expect("efam runs");
    let table = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(output.status.success() && table.contains("0.20.1, but "), "{table}");
}

/// A viewer that writes its settings when it starts, as that of 0.36 does.
#[cfg(unix)]
#[test]
fn a_viewer_that_is_asked_for_its_version_leaves_no_trace() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new("doctor-settings");
    let script = "#!/bin/sh\nmkdir -p \"${XDG_CONFIG_HOME:-$HOME/settings}/rerun\"\necho rerun-cli 0.36.3\n";
    bench.file("rerun", script);
    fs::set_permissions(bench.0.join("rerun"), fs::Permissions::from_mode(0o755)).expect("ours");
    let path = format!("{}:/usr/bin:/bin", bench.0.display());
    let mut command = bench.command(&["doctor", "--json"]);
    let output = command.env("PATH", path).env("HOME", &bench.0).env_remove("XDG_CONFIG_HOME").output();
    let output = output.expect("efam runs");
    assert!(String::from_utf8_lossy(&output.stdout).contains("\"found\":\"0.36.3\""), "{output:?}");
    assert!(!bench.0.join("settings").exists(), "the viewer wrote its settings");
}

#[test]
fn completions_know_commands_and_options() {
    let bench = Bench::new("completions");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let (code, stdout, stderr) = bench.run(&["completions", shell]);
        assert_eq!((code, stderr.as_str()), (0, ""), "{shell}");
        for word in ["calibrate", "false-alarm", "payload-center"] {
            assert!(stdout.contains(word), "{shell}: {word}");
        }
    }
    assert_eq!(bench.run(&["completions", "cmd"]).0, 2);
}

#[test]
fn manual_pages_are_written_once() {
    let bench = Bench::new("man");
    let (code, page, _) = bench.run(&["man", "experiment", "check"]);
    assert_eq!(code, 0);
    for part in [".TH efam-experiment-check 1", "\\-\\-decisions", "efam experiment check beam.toml"] {
        assert!(page.contains(part), "{part}\n{page}");
    }
    let (code, _, stderr) = bench.run(&["man", "experimnt", "check"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("did you mean `experiment check`?"), "{stderr}");
    let (code, stdout, _) = bench.run(&["man", "--out", "man1"]);
    assert_eq!(code, 0);
    let count = fs::read_dir(bench.0.join("man1")).expect("made").count();
    assert_eq!(stdout, format!("{count} pages in man1\n"));
    assert_eq!(bench.text("man1/efam-experiment-check.1"), page);
    bench.file("man1/efam-modes.1", "mine");
    fs::remove_file(bench.0.join("man1/efam.1")).expect("it is there");
    let (code, _, stderr) = bench.run(&["man", "--out", "man1"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("exists already"), "{stderr}");
    assert_eq!(bench.text("man1/efam-modes.1"), "mine");
    assert!(!bench.0.join("man1/efam.1").exists(), "none is written where one is there");
    assert_eq!(bench.run(&["man", "--out", "man1", "--overwrite", "-q"]).1, "");
    assert!(bench.text("man1/efam-modes.1").starts_with(".ie"), "{}", bench.text("man1/efam-modes.1"));
}
