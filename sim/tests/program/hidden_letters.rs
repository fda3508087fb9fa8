//! Names and values that would act on a terminal, or that are no text at all.
//!
//! Goal: no argument makes the program panic, no control character of a name reaches stdout or stderr raw, and no name
//! becomes configuration. Expected: `\u{1b}` and the like in place of the character, in tables, messages and JSON.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use crate::bench::Bench;

/// Sets a colour, moves the writing direction, a C1 control that some terminals take for ESC [, the end of a line.
const EVIL: [&str; 5] = ["\u{1b}[31mred\u{1b}[0m", "\u{202e}gnp.exe", "\u{9b}2J", "a\rb", "tip\u{7f}"];

/// Characters that act on a terminal; a line's end only where a message is one line.
fn hidden(text: &str) -> Option<char> {
    text.chars().find(|c| {
        c.is_control() && *c != '\n' && *c != '\t'
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}')
            || ('\u{202a}'..='\u{202e}').contains(c)
            || ('\u{2066}'..='\u{2069}').contains(c)
    })
}

/// Runs the program; nothing that it says may act on a terminal.
fn said(bench: &Bench, arguments: &[&str]) -> (i32, String, String) {
    let (code, stdout, stderr) = bench.run(arguments);
    for (stream, text) in [("stdout", &stdout), ("stderr", &stderr)] {
        let raw = hidden(text);
        assert_eq!(raw, None, "{arguments:?}: {raw:?} on {stream}:\n{text:?}");
    }
    assert!((0..=4).contains(&code), "{arguments:?}: {code}\n{stderr}");
    (code, stdout, stderr)
}

#[cfg(unix)]
#[test]
fn an_argument_that_is_no_text_never_panics() {
    use std::os::unix::ffi::OsStrExt;

    let bench = Bench::new("no-text");
    let name = OsStr::from_bytes(b"caf\xe9.csv");
    for words in [
        &["simulate"][..],
        &["calibrate"],
        &["diagnose"],
        &["predict"],
        &["sweep"],
        &["sweep", "plan"],
        &["sweep", "run", "--plan"],
        &["sweep", "submit", "--plan"],
        &["sweep", "status", "--plan"],
        &["sweep", "merge", "--plan"],
        &["view"],
        &["report"],
        &["export", "--to", "mat"],
        &["figures", "--set"],
        &["effects"],
        &["experiment", "init"],
        &["experiment", "check"],
        &["analyse"],
        &["inspect"],
        &["statics"],
        &["modes"],
        &["linearise"],
        &["doctor"],
        &["schema"],
        &["completions"],
        &["man"],
        &["simulate", "--color"],
        &[],
    ] {
        let output = bench.command(words).arg(name).output().expect("efam runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(!stderr.contains("panicked"), "{words:?}: {stderr}");
        assert!(matches!(output.status.code(), Some(2 | 3)), "{words:?}: {:?} {stderr}", output.status);
    }
    // And is a file like any other where it may be one.
    fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/cases/inj3.parquet"),
        bench.0.join(name),
    )
    .expect("copied");
    let output = bench.command(&["inspect"]).arg(name).output().expect("efam runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output =
        bench.command(&["experiment", "init", "--out", "e.toml"]).arg(name).output().expect("efam runs");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(3) && stderr.contains("is not UTF-8"), "{stderr}");
    assert!(!bench.0.join("e.toml").exists());
}

#[test]
fn what_is_typed_is_shown_and_not_obeyed() {
    let bench = Bench::new("hidden-arguments");
    bench.file("s.toml", "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n");
    bench.file("e.toml", "[[recording]]\nfile = \"a.csv\"\ntip = \"Tip\"\n");
    for evil in EVIL {
        for arguments in [
            &[evil][..],
            &["simulate", evil],
            &["simulate", "s.toml", "--set", evil],
            &["simulate", "s.toml", "--pressure", evil],
            &["simulate", "s.toml", "--muscle", evil],
            &["simulate", "s.toml", "--color", evil],
            &["--color=always", "simulate", evil],
            &["--color=always", "simulate", "s.toml", "--pressure", evil],
            &["simulate", "s.toml", &format!("--{evil}")],
            &["diagnose", "e.toml", "--without", evil],
            &["sweep", "run", "--plan", evil],
            &["effects", evil],
            &["schema", evil],
            &["man", evil],
            &["report", evil],
        ] {
            let (code, stdout, stderr) = match arguments[0] {
                // Our own colours are wanted there.
                "--color=always" => {
                    let (code, stdout, stderr) = bench.run(arguments);
                    let evil = hidden(evil).expect("it has one");
                    let bare = stderr.replace("\u{1b}[", "").replace("\u{1b}", "\u{7}");
                    assert!(
                        !bare.contains(evil) || evil == '\u{1b}' && !bare.contains('\u{7}'),
                        "{stderr:?}"
                    );
                    assert!(!stderr.contains("[31mred\u{1b}"), "{stderr:?}");
                    (code, stdout, stderr)
                }
                _ => said(&bench, arguments),
            };
            assert!((2..=3).contains(&code) && stdout.is_empty(), "{arguments:?}: {code} {stderr}");
            assert!(stderr.contains("\\u{"), "{arguments:?}: {stderr}");
        }
    }
    assert_eq!(bench.left(), ["e.toml", "s.toml"]);
}

#[test]
fn names_and_values_of_files_are_shown_and_not_obeyed() {
    let bench = Bench::new("hidden-names");
    let rows = "0,0.1,0,0\n0.01,0.1,0,0.01\n0.02,0.1,0,0.03\n";
    for evil in EVIL.into_iter().filter(|evil| !evil.contains('/')) {
        // A file's name, in a message and in a table.
        let file = format!("{evil}.csv");
        bench.file(&file, &format!("t_s,A_x_m,A_y_m,A_z_m\n{rows}"));
        assert!(said(&bench, &["inspect", &file]).1.contains("\\u{"));
        assert_eq!(said(&bench, &["inspect", &file, "--json"]).0, 0);
        bench.file(&file, "no recording\n");
        assert_eq!(said(&bench, &["inspect", &file]).0, 3);
        fs::remove_file(bench.0.join(&file)).expect("it was there");
        // A key, a value, a unit, as TOML may hold them.
        let escaped: String = evil.chars().map(|c| format!("\\u{:04x}", u32::from(c))).collect();
        for text in [
            format!("\"{escaped}\" = 1\n"),
            format!("name = \"{escaped}\"\n"),
            format!("[muscle]\nname = \"{escaped}\"\npressure = \"15 psi\"\n"),
            format!("[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 {escaped}\"\n"),
            format!("[muscle]\nfile = \"{escaped}\"\npressure = \"15 psi\"\n"),
            format!("[rod]\n\"{escaped}\" = \"{escaped}\"\n"),
            format!("# {evil}\n[rod]\nlength = \"1 s\"\n"),
        ] {
            bench.file("evil.toml", &text);
            for command in
                [&["simulate"][..], &["experiment", "check"], &["sweep"], &["--color=never", "statics"]]
            {
                assert_eq!(said(&bench, &[command, &["evil.toml"]].concat()).0, 2, "{text:?}");
            }
        }
    }
    // A cell, a unit of a column and a marker's name; text recordings hold no C0, but C1 and writing direction.
    for evil in ["\u{202e}gnp", "\u{9b}2J", "a\u{85}b"] {
        bench.file("cell.csv", &format!("t_s,A_x_m,A_y_m,A_z_m\n{evil},0,0,0\n{rows}"));
        assert!(said(&bench, &["inspect", "cell.csv"]).2.contains("\\u{"));
        bench.file("marker.csv", &format!("t_s,{evil}_x_m,{evil}_y_m,{evil}_z_m,{evil} note\n{rows}"));
        let (code, stdout, stderr) = said(&bench, &["inspect", "marker.csv"]);
        assert!(code == 0 && stdout.contains("\\u{"), "{stdout} {stderr}");
        // The experiment that names it so is understood.
        let marker: String = evil.chars().map(|c| format!("\\u{:04x}", u32::from(c))).collect();
        bench.file("e.toml", &format!("[[recording]]\nfile = \"marker.csv\"\ntip = \"{marker}\"\n"));
        let (code, _, stderr) = said(&bench, &["experiment", "check", "e.toml"]);
        assert!(
            code == 3 && stderr.contains("20 are needed") || !stderr.contains("has no marker"),
            "{stderr}"
        );
    }
}

/// Labels of a C3D file and columns of a Parquet file hold any byte; kept are the files that showed it.
#[test]
fn a_name_in_a_recording_is_no_configuration() {
    let bench = Bench::new("hidden-configuration");
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/cases");
    for case in ["inj3.parquet", "lab_esc.c3d"] {
        fs::copy(cases.join(case), bench.0.join(case)).expect("copied");
        said(&bench, &["inspect", case]);
        said(&bench, &["inspect", case, "--json"]);
        let (code, _, stderr) =
            said(&bench, &["experiment", "init", case, "--out", "draft.toml", "--overwrite"]);
        assert_eq!(code, 0, "{stderr}");
        let text = bench.text("draft.toml");
        assert_eq!(hidden(&text), None, "{text}");
        let table: toml::Table = text.parse().expect("TOML");
        let recording = table["recording"][0].as_table().expect("a table");
        let keys: Vec<&str> = recording.keys().map(String::as_str).collect();
        // Of the names in the file became keys: pressure, spurious.
        let ours = ["angle", "base", "body", "file", "tip", "up"];
        assert!(keys.iter().all(|key| ours.contains(key)), "{keys:?}\n{text}");
        // And what it wrote it can check.
        let (code, _, stderr) =
            said(&bench, &["experiment", "check", "draft.toml", "-q", "--out", "checked", "--overwrite"]);
        assert!(code != 2, "{stderr}\n{text}");
    }
}
