//! README and the tutorials of the book, run without changes.
//!
//! Goal: who types what a tutorial shows gets what it shows. Setup: a folder with the project's `scenarios/`, and the
//! program on the PATH. A block `sh` is run with `efam` in the place of `cargo run --release --`, but for other lines of
//! `cargo` and `pip`, which `.ci/run` runs; a block with a file's name after its language is saved under that name, or
//! added to what is there; each line of a block `text` is in what the commands before it printed, `…` for whatever is
//! between. README's table of commands is run as well. The tutorial about effects builds the project anew, so
//! `.ci/run` does that.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::bench::Bench;

/// A fenced block: the words after the fence, and what is in it.
struct Block<'a> {
    language: &'a str,
    file: Option<&'a str>,
    text: &'a str,
}

fn blocks(page: &str) -> Vec<Block<'_>> {
    let parts: Vec<_> = page.split("\n```").collect();
    assert!(parts.len() % 2 == 1, "a block does not end");
    parts
        .iter()
        .skip(1)
        .step_by(2)
        .map(|part| {
            let (head, text) = part.split_once('\n').unwrap_or((part, ""));
            let (language, file) = head.split_once(' ').map_or((head, None), |(own, file)| (own, Some(file)));
            Block { language, file, text }
        })
        .collect()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Copies a folder and all below it.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("ours");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let to = to.join(path.file_name().expect("it has one"));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            fs::copy(&path, &to).expect("copied");
        }
    }
}

/// Whether a line of a page is in what was printed, `…` for whatever is between.
fn is_printed(line: &str, printed: &str) -> bool {
    printed.lines().any(|own| {
        let mut rest = own;
        line.split('…').all(|part| match rest.find(part.trim()) {
            Some(at) => {
                rest = &rest[at + part.trim().len()..];
                true
            }
            None => false,
        })
    })
}

/// A line of a shell as it is run here; none for what builds or installs.
fn of_the_program(line: &str) -> Option<String> {
    match line.strip_prefix("cargo run --release -- ") {
        Some(arguments) => Some(format!("efam {arguments}")),
        None => (!line.starts_with("cargo ") && !line.starts_with("pip ")).then(|| line.to_owned()),
    }
}

/// What a shell prints that runs some lines in a folder, with the program on its PATH.
fn run(bench: &Bench, lines: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_efam")).parent().expect("a folder").to_path_buf();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&others)));
    let mut shell = Command::new("sh");
    shell.args(["-eu", "-c", lines]).current_dir(&bench.0).env("PATH", path.expect("a PATH"));
    let output = shell.output().expect("there is a shell");
    let printed =
        [output.stdout, output.stderr].map(|own| String::from_utf8_lossy(&own).into_owned()).concat();
    assert!(output.status.success(), "{lines}\n{printed}");
    printed
}

/// Goes through a tutorial of at least three commands, block by block.
fn follow(name: &str) {
    let page = fs::read_to_string(root().join("docs/src/tutorials").join(format!("{name}.md")));
    let commands = follow_page(name, &page.expect("a page"));
    assert!(commands >= 3, "{name}.md: {commands} commands");
}

/// Goes through a page, block by block, and returns how many commands it ran.
fn follow_page(name: &str, page: &str) -> usize {
    let bench = Bench::new(&format!("tutorial-{name}"));
    copy(&root().join("scenarios"), &bench.0.join("scenarios"));
    let (mut printed, mut commands) = (String::new(), 0);
    for block in blocks(page) {
        match (block.language, block.file) {
            (_, Some(file)) => {
                let there = fs::read_to_string(bench.0.join(file)).unwrap_or_default();
                bench.file(file, &(there + block.text + "\n"));
            }
            ("sh", None) => {
                let own: Vec<String> = block.text.lines().filter_map(of_the_program).collect();
                if !own.is_empty() {
                    printed = run(&bench, &own.join("\n"));
                }
                commands += own.len();
            }
            ("text", None) => {
                for line in block.text.lines() {
                    assert!(is_printed(line, &printed), "{name}.md: not printed: {line}\n{printed}");
                }
            }
            // `sim/python/tests/test_documents.py` runs these.
            ("python", None) => {}
            (language, None) => panic!("{name}.md: what is to be done with a block of {language:?}?"),
        }
    }
    commands
}

/// README without its diagnosis, and the diagnosis, which takes longer.
fn readme() -> [String; 2] {
    let page = fs::read_to_string(root().join("README.md")).expect("it is there");
    let (head, rest) = page.split_once("\n## A diagnosis\n").expect("a diagnosis");
    let (diagnosis, tail) = rest.split_once("\n## ").expect("another section");
    [format!("{head}\n## {tail}"), diagnosis.to_owned()]
}

#[test]
fn the_readme() {
    let [page, _] = readme();
    assert_eq!(follow_page("README", &page), 2);
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn the_diagnosis_of_the_readme() {
    let [_, diagnosis] = readme();
    assert_eq!(follow_page("README-diagnosis", &diagnosis), 1);
}

/// The commands in the rows of README's table of commands.
fn commands_of_table(page: &str) -> Vec<&str> {
    let rows = page.lines().filter(|line| line.starts_with('|'));
    rows.filter_map(|row| row.split('`').nth(1)).filter(|code| code.starts_with("efam ")).collect()
}

/// Each command of README's table runs as it is, in the order of the rows. `efam watch` does not end by itself, so
/// `sim/tests/program/watched.rs` runs it.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn the_table_of_commands() {
    let page = fs::read_to_string(root().join("README.md")).expect("it is there");
    let bench = Bench::new("readme-table");
    copy(&root().join("scenarios"), &bench.0.join("scenarios"));
    let commands = commands_of_table(&page);
    for name in [
        "simulate",
        "statics",
        "modes",
        "predict",
        "calibrate",
        "diagnose",
        "sweep",
        "analyse",
        "watch",
        "figures",
        "export",
    ] {
        assert!(
            commands.iter().any(|own| own.starts_with(&format!("efam {name}"))),
            "no row has efam {name}"
        );
    }
    for command in commands.iter().filter(|own| !own.starts_with("efam watch ")) {
        run(&bench, command);
    }
}

#[test]
fn a_release() {
    follow("release");
}

#[test]
fn a_muscle_of_ones_own() {
    follow("muscle");
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_recording() {
    follow("recording");
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_diagnosis() {
    follow("diagnosis");
}

/// The page of the guide about laws as text.
#[test]
fn laws_as_text() {
    let page = fs::read_to_string(root().join("docs/src/guide/laws.md")).expect("it is there");
    assert_eq!(follow_page("laws", &page), 3);
}

#[test]
fn all_are_followed_and_name_one_another_rightly() {
    let folder = root().join("docs/src/tutorials");
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let page = fs::read_to_string(&path).expect("text");
        for link in page.split("](").skip(1).filter_map(|part| part.split(')').next()) {
            assert!(folder.join(link).is_file(), "{}: {link}", path.display());
        }
        names.push(path.file_stem().expect("a name").to_string_lossy().into_owned());
    }
    names.sort();
    assert_eq!(names, ["diagnosis", "effect", "muscle", "recording", "release"]);
}
