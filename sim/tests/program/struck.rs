//! Every call that changes the disk fails once, or is the last of a program that is killed.
//!
//! Goal: whichever it is, what is under a name is whole, old or new; nothing that was there is lost; the message names
//! the file, and the exit code is not 0. Then the same command succeeds and tidies.
//! Setup: the store's calls are counted in a debug build, and `EFAM_FAULT` says which one fails (`store/src/disk.rs`).
//! The short test takes some calls of three commands; the long one every ninth of all commands, from the first that
//! `EFAM_SEED` says, and with `EFAM_STRIKES=1` all. `EFAM_WORK=simulate,sweep` takes these commands alone, and
//! `EFAM_WORK=diagnose--overwrite` the one with a name that is taken.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use efam_store::folder::admit;

use crate::bench::Bench;
use crate::strangers::tree;
use crate::work::{WORK, Work, bench};

/// How a call is struck.
const KINDS: [&str; 2] = ["fail", "kill"];

/// A command, what it makes, and the folder that is there before.
struct Case {
    arguments: Vec<String>,
    out: String,
    /// Whether its folder or file appears at once.
    at_once: bool,
    before: BTreeMap<PathBuf, Option<Vec<u8>>>,
    /// Names of all files that it leaves, or those and more that were there.
    whole: Vec<PathBuf>,
}

#[derive(Default)]
struct Counts {
    commands: usize,
    calls: usize,
    struck: usize,
}

fn files(of: &BTreeMap<PathBuf, Option<Vec<u8>>>) -> Vec<PathBuf> {
    of.iter().filter(|(_, bytes)| bytes.is_some()).map(|(path, _)| path.clone()).collect()
}

/// Puts back everything in the bench as it was.
fn restore(bench: &Bench, before: &BTreeMap<PathBuf, Option<Vec<u8>>>) {
    for name in bench.left() {
        let path = bench.0.join(name);
        let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
    }
    for (path, bytes) in before {
        match bytes {
            None => fs::create_dir_all(path).expect("made"),
            Some(bytes) => {
                fs::create_dir_all(path.parent().expect("a folder")).expect("made");
                fs::write(path, bytes).expect("written");
            }
        }
    }
}

/// The number of the first call in turn, and how many there are from one to the next.
fn turns(every: u64) -> (u64, u64) {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let every = number("EFAM_STRIKES").unwrap_or(every).max(1);
    (1 + number("EFAM_SEED").unwrap_or(3) % every, every)
}

impl Case {
    fn new(bench: &Bench, arguments: &[&str], out: &str, at_once: bool) -> Case {
        let arguments: Vec<String> =
            arguments.iter().chain(&["-q", "--out", out]).map(|word| (*word).to_owned()).collect();
        let before = tree(&bench.0);
        let mut case = Case { arguments, out: out.to_owned(), at_once, before, whole: Vec::new() };
        assert_eq!(case.run(bench, &[]), (0, String::new()), "{:?}", case.arguments);
        case.whole = files(&tree(&bench.0));
        case
    }

    fn run(&self, bench: &Bench, more: &[&str]) -> (i32, String) {
        let arguments: Vec<&str> =
            self.arguments.iter().map(String::as_str).chain(more.iter().copied()).collect();
        let (code, _, stderr) = bench.run(&arguments);
        (code, stderr)
    }

    /// Strikes calls in turn; how many there are, and how many were struck.
    fn struck(&self, bench: &Bench, every: u64, kinds: &[&str]) -> (u64, usize) {
        let log = bench.0.with_extension("struck");
        let (first, every) = turns(every);
        let mut struck = 0;
        for kind in kinds {
            let mut number = first;
            loop {
                restore(bench, &self.before);
                let _ = fs::remove_file(&log);
                let arguments: Vec<&str> = self.arguments.iter().map(String::as_str).collect();
                let mut command = bench.command(&arguments);
                // One thread: the calls of a sweep come in one order.
                command.env("EFAM_FAULT", format!("{number} {kind} {}", log.display()));
                command.env("RAYON_NUM_THREADS", "1");
                let end = command.output().expect("efam runs");
                let stderr = String::from_utf8(end.stderr).expect("UTF-8");
                let Ok(call) = fs::read_to_string(&log) else {
                    assert!(end.status.success(), "{:?}: {stderr}", self.arguments);
                    break;
                };
                let of = format!("{}, {kind} of call {number} ({call}): {stderr}", self.arguments.join(" "));
                self.look(bench, end.status.code(), &call, &stderr, &of);
                self.again(bench, &of);
                struck += 1;
                number += every;
            }
        }
        let _ = fs::remove_file(&log);
        // The last number is beyond the last call by one turn at most.
        let calls = struck as u64 / kinds.len() as u64 * every;
        (calls, struck)
    }

    /// What is there after a call was struck.
    fn look(&self, bench: &Bench, code: Option<i32>, call: &str, stderr: &str, of: &str) {
        let now = tree(&bench.0);
        let out = bench.0.join(&self.out);
        for (path, bytes) in self.before.iter().filter(|(path, _)| !path.starts_with(&out)) {
            assert!(now.get(path) == Some(bytes), "lost: {}; {of}", path.display());
        }
        let names = files(&now);
        let was_there = self.before.contains_key(&out);
        let is_whole = || {
            let below = |path: &&PathBuf| path.starts_with(&out);
            self.whole.iter().filter(below).all(|path| names.contains(path))
        };
        assert!(out.exists() || !was_there, "lost: {}; {of}", out.display());
        // Whatever has a name, of the command or beside it, is whole.
        for name in bench.left().iter().filter(|name| name.starts_with(&self.out)) {
            let path = bench.0.join(name);
            if path.is_dir() && !self.at_once && code.is_none() {
                // What a killed sweep left in its shards is tidied by the next.
            } else if path.is_dir() {
                admit(&path, true).unwrap_or_else(|torn| panic!("torn: {torn}; {of}"));
            } else {
                let bytes = fs::read(&path).expect("a file");
                let is_old = self.before.get(&path) == Some(&Some(bytes.clone()));
                assert!(is_old || is_complete(&bytes, name), "torn: {name}; {of}");
            }
        }
        assert!(!out.exists() || !self.at_once || is_whole(), "torn: {}; {of}", out.display());
        let (kind, at) = call.split_once(' ').expect("two words");
        match code {
            None => assert!(stderr.is_empty(), "{of}"),
            Some(0) => {
                // The folder has its name by then, or names could not be exchanged, and it took the free name or went aside.
                let is_folder = bench.0.join(at).is_dir();
                let is_due = kind == "remove"
                    || kind == "fsync" && is_folder
                    || kind == "rename" && bench.0.join(at) == out;
                assert!(is_due && is_whole(), "not noticed: {of}");
            }
            Some(_) => {
                let stem = self.out.split('.').next().expect("a name");
                // What could not be removed is named, too, and the new folder is written.
                let is_told =
                    stderr.contains("the disk failed") || kind == "remove" && stderr.contains("is written");
                assert!(is_told && stderr.contains(stem), "unnamed: {of}");
                let left = names.iter().filter(|path| {
                    path.strip_prefix(&bench.0)
                        .expect("below")
                        .components()
                        .any(|part| part.as_os_str().to_string_lossy().starts_with('.'))
                });
                let left: Vec<_> = left.collect();
                assert!(kind == "remove" || left.is_empty(), "left: {left:?}; {of}");
            }
        }
    }

    /// The disk is mended.
    fn again(&self, bench: &Bench, of: &str) {
        let overwrites = self.arguments.iter().any(|word| word == "--overwrite");
        let is_there = self.at_once && bench.0.join(&self.out).exists() && !overwrites;
        let (code, stderr) = self.run(bench, if is_there { &["--overwrite"] } else { &[] });
        assert_eq!((code, &*stderr), (0, ""), "again after {of}");
        let out = bench.0.join(&self.out);
        let torn = out.is_dir().then(|| admit(&out, true).err()).flatten();
        assert!(torn.is_none(), "again: {torn:?}; {of}");
        let names = files(&tree(&bench.0));
        for path in &self.whole {
            assert!(names.contains(path), "again: {} is not there; {of}", path.display());
        }
        let more = names.iter().filter(|path| !self.whole.contains(path));
        let beside = bench.0.join(format!("{}_2", self.out));
        let more: Vec<_> = more.filter(|path| !path.starts_with(&beside)).collect();
        assert!(more.is_empty(), "again: {more:?} stay; {of}");
    }
}

/// Whether a file of its own is there to its end.
fn is_complete(bytes: &[u8], name: &str) -> bool {
    match name.rsplit('.').next() {
        // Both ends of an MCAP are its sign; HDF5 states its length.
        Some("mcap") => bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n"),
        Some("mat") => {
            let length = bytes.len() as u64;
            bytes
                .windows(8)
                .take(1024)
                .any(|own| u64::from_le_bytes(own.try_into().expect("eight")) == length)
                || bytes
                    .windows(8)
                    .take(1024)
                    .any(|own| u64::from_le_bytes(own.try_into().expect("eight")) + 512 == length)
        }
        _ => bytes.ends_with(b"\n"),
    }
}

/// Whether `EFAM_WORK` takes a command, with a free name or with one that is taken.
fn is_taken(only: &str, command: &str, overwrites: bool) -> bool {
    let is_own = |own: &str| own == command || overwrites && own.strip_suffix("--overwrite") == Some(command);
    only.is_empty() || only.split(',').any(is_own)
}

/// Every case of a command that `only` takes: with a free name, and with one that is taken.
fn cases(bench: &Bench, work: &Work, only: &str, count: &mut Counts, every: u64, kinds: &[&str]) {
    let (arguments, out) = (work.arguments, format!("out{}", work.ending));
    let begin = tree(&bench.0);
    let mut variants = vec![arguments.to_vec()];
    if !arguments.contains(&"--overwrite") {
        variants.push([arguments, &["--overwrite"]].concat());
    }
    for (k, arguments) in variants.iter().enumerate().filter(|(k, _)| is_taken(only, arguments[0], *k == 1)) {
        restore(bench, &begin);
        if k == 1 {
            let (code, _, stderr) = bench.run(&[&variants[0][..], &["-q", "--out", &out]].concat());
            assert_eq!(code, 0, "{stderr}");
        }
        let case = Case::new(bench, arguments, &out, work.at_once);
        let (calls, struck) = case.struck(bench, every, kinds);
        println!("{:70} some {calls} calls, {struck} struck, 0 torn, 0 lost", arguments.join(" "));
        count.commands += 1;
        count.calls += calls as usize;
        count.struck += struck;
    }
    restore(bench, &begin);
}

#[test]
fn some_calls_fail_and_nothing_is_torn_or_lost() {
    let bench = bench("struck-some");
    let mut count = Counts::default();
    let of = |words: &[&str]| WORK.iter().find(|work| work.arguments.starts_with(words)).expect("a command");
    for (words, every) in [(&["simulate"][..], 13), (&["export"], 5), (&["sweep"], 59)] {
        cases(&bench, of(words), "", &mut count, every, &KINDS[..1]);
    }
    println!("{} commands x failure points: {} struck, 0 torn, 0 lost", count.commands, count.struck);
    assert!(count.struck >= 12, "{}", count.struck);
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn every_call_fails_and_nothing_is_torn_or_lost() {
    let only = std::env::var("EFAM_WORK").unwrap_or_default();
    // Several may run at one time, each with other commands.
    let bench = bench(&format!("struck-{only}"));
    let mut count = Counts::default();
    WORK.iter().for_each(|work| cases(&bench, work, &only, &mut count, 9, &KINDS));
    println!("{} commands x failure points: {} struck, 0 torn, 0 lost", count.commands, count.struck);
}

/// A page that cannot be written is written at the next look.
#[cfg(unix)]
#[test]
fn watch_writes_its_page_when_the_disk_is_mended() {
    let bench = bench("struck-watch");
    fs::create_dir(bench.0.join("lab")).expect("made");
    fs::copy(bench.0.join("15psi.csv"), bench.0.join("lab/15psi.csv")).expect("copied");
    let log = bench.0.join("log");
    let (first, every) = turns(29);
    let mut struck = 0;
    for number in (first..).step_by(every as usize) {
        let _ = (fs::remove_dir_all(bench.0.join("page")), fs::remove_file(&log));
        let mut command = bench.command(&["watch", "lab", "-q", "--every", "20 ms", "--out", "page"]);
        command.env("EFAM_FAULT", format!("{number} fail {}", log.display()));
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("efam runs");
        let begin = Instant::now();
        while !bench.0.join("page/report.html").exists() {
            assert!(begin.elapsed() < Duration::from_secs(100), "no page came after call {number}");
            assert!(child.try_wait().expect("a child").is_none(), "it ended");
            sleep(Duration::from_millis(10));
        }
        crate::interrupted::send("INT", child.id());
        let end = child.wait_with_output().expect("it ends");
        let stderr = String::from_utf8(end.stderr).expect("UTF-8");
        assert!(end.status.success(), "{number}: {stderr}");
        assert_eq!(admit(&bench.0.join("page"), true).map_err(|error| error.to_string()), Ok(()));
        let Ok(call) = fs::read_to_string(&log) else { break };
        let is_told = stderr.contains("page") && stderr.contains("the disk failed");
        // A page that cannot change places with another takes the free name.
        let is_late = call.starts_with("fsync") && bench.0.join(&call[6..]).is_dir()
            || call.starts_with("remove")
            || call == "rename page";
        assert!(is_told || is_late, "{call}: {stderr}");
        struck += 1;
    }
    println!("watch: {struck} calls failed, the page came each time");
    assert!(struck > 0);
}
