//! README and the tutorials of the book, run as they stand.
//!
//! Goal: who types what a tutorial shows gets what it shows. Setup: a folder with the project's `scenarios/`, and the
//! program on the PATH. A block `sh` is run, but for lines of `cargo`, which `.ci/run` runs; a block with a file's name
//! after its language is saved under that name, or added to what is there; each line of a block `text` stands in what the
//! commands before it printed, `…` for whatever is between. The tutorial about effects builds the project anew, so
//! `.ci/run` does that.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::bench::Bench;

/// A fenced block: what stands behind the fence, and what is in it.
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

/// Whether a line of a page stands in what was printed, `…` for whatever is between.
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
    let program = Path::new(env!("CARGO_BIN_EXE_efam")).parent().expect("a folder").to_path_buf();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&others)));
    let path = path.expect("a PATH");
    let (mut printed, mut commands) = (String::new(), 0);
    for block in blocks(page) {
        match (block.language, block.file) {
            (_, Some(file)) => {
                let there = fs::read_to_string(bench.0.join(file)).unwrap_or_default();
                bench.file(file, &(there + block.text + "\n"));
            }
            ("sh", None) => {
                let own: Vec<&str> = block.text.lines().filter(|line| !line.starts_with("cargo ")).collect();
                let mut shell = Command::new("sh");
                shell.args(["-eu", "-c", &own.join("\n")]).current_dir(&bench.0).env("PATH", &path);
                let output = shell.output().expect("there is a shell");
                printed = [output.stdout, output.stderr]
                    .map(|own| String::from_utf8_lossy(&own).into_owned())
                    .concat();
                assert!(output.status.success(), "{name}.md:\n{}\n{printed}", block.text);
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

#[test]
fn the_readme() {
    let page = fs::read_to_string(root().join("README.md")).expect("it is there");
    assert_eq!(follow_page("README", &page), 1);
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
#[ignore = "long; .ci/run runs it"]
fn a_recording() {
    follow("recording");
}

#[test]
#[ignore = "long; .ci/run runs it"]
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
