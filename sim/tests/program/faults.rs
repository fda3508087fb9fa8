//! A disk that is full or cannot be written, a name that two want, a clock that is wrong.
//!
//! Goal: every command that writes says which file and why, ends with a code, and leaves nothing half-written; once
//! the fault is gone it succeeds. Setup: small disks of memory, where this user may mount them.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::bench::{Bench, program, skipped};
use crate::work::{WORK, Work, bench};

/// A disk of memory in the bench's folder `disk`.
#[cfg(target_os = "linux")]
struct Disk(PathBuf);

#[cfg(target_os = "linux")]
impl Disk {
    fn mount(bench: &Bench, size: &str) -> Option<Disk> {
        let path = bench.0.join("disk");
        fs::create_dir_all(&path).expect("made");
        let size = format!("size={size}");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&path).output();
        if mount.is_ok_and(|mount| mount.status.success()) {
            return Some(Disk(path));
        }
        skipped("disk", "no small disk can be mounted here");
        None
    }

    fn again(&self, option: &str) {
        let mount = Command::new("mount").args(["-o", &format!("remount,{option}")]).arg(&self.0).status();
        assert!(mount.is_ok_and(|mount| mount.success()), "{option}");
    }

    /// Every file and folder on it.
    fn left(&self) -> Vec<PathBuf> {
        let mut found = vec![self.0.clone()];
        let mut next = 0;
        while next < found.len() {
            if found[next].is_dir() {
                let entries = fs::read_dir(&found[next]).expect("a folder");
                found.extend(entries.map(|entry| entry.expect("an entry").path()));
            }
            next += 1;
        }
        found.retain(|path| *path != self.0 && !path.ends_with("ballast"));
        found
    }
}

#[cfg(target_os = "linux")]
impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

fn done(bench: &Bench, work: &Work, out: &str) -> (i32, String) {
    let (code, _, stderr) = bench.run(&[work.arguments, &["-q", "--out", out]].concat());
    (code, stderr)
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_disk_that_is_full_or_read_only_is_named_and_nothing_is_left() {
    let bench = bench("faults");
    for (kind, work) in WORK.iter().enumerate() {
        let Some(disk) = Disk::mount(&bench, "4k") else { return };
        // Its only page.
        fs::write(disk.0.join("ballast"), [0; 4096]).expect("there is room for it");
        let out = format!("disk/out-{kind}{}", work.ending);
        let fails = |cause: &str| {
            let (code, stderr) = done(&bench, work, &out);
            let what = work.arguments.join(" ");
            assert_eq!(code, 1, "{what}: {stderr}");
            assert!(stderr.starts_with("error: disk/out-") && stderr.contains(cause), "{what}: {stderr}");
            assert!(
                stderr.contains("cannot be written: ") && stderr.contains("choose another --out"),
                "{stderr}"
            );
            // Whole shards of a sweep stay, and its plan.
            let left = disk.left();
            let is_half =
                |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes()[0] == b'.');
            assert!(
                if work.at_once { left.is_empty() } else { !left.iter().any(is_half) },
                "{what}: {left:?}"
            );
        };
        fails("No space left on device");
        disk.again("ro");
        fails("Read-only file system");
        disk.again("rw,size=64m");
        assert_eq!(done(&bench, work, &out), (0, String::new()), "{}", work.arguments.join(" "));
    }
}

/// Each of them either has the name or a message that it is taken; none disturbs another.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn of_two_that_want_one_name_one_gets_it() {
    let bench = bench("faults-rivals");
    // What takes minutes for many ends in the same kind of folder as what does not.
    let is_short = |work: &Work| work.at_once && !["calibrate", "diagnose"].contains(&work.arguments[0]);
    for (kind, work) in WORK.iter().enumerate().filter(|(_, work)| is_short(work)) {
        let out = format!("out-{kind}{}", work.ending);
        let rivals = |more: &[&str]| {
            let arguments = [work.arguments, &["-q", "--out", &out], more].concat();
            let start = |_| bench.command(&arguments).stderr(Stdio::piped()).spawn().expect("efam runs");
            let rivals: Vec<_> = (0..3).map(start).collect();
            let ends = rivals.into_iter().map(|rival| rival.wait_with_output().expect("it ends"));
            ends.map(|end| (end.status.code(), String::from_utf8_lossy(&end.stderr).into_owned()))
                .collect::<Vec<_>>()
        };
        let ends = rivals(&[]);
        assert!(ends.iter().any(|end| *end == (Some(0), String::new())), "{ends:?}");
        for (code, stderr) in ends.iter().filter(|(code, _)| *code != Some(0)) {
            assert!(stderr.contains(": exists already; choose another --out"), "{stderr}");
            // At the beginning, or at the end, when what was computed is kept beside it.
            let kept = stderr.split("; the results are in ").nth(1).map(str::trim_end);
            assert_eq!(*code, Some(if kept.is_some() { 1 } else { 2 }), "{stderr}");
            assert!(kept.is_none_or(|kept| bench.0.join(kept).join("efam-files.json").is_file()), "{stderr}");
        }
        if work.ending.is_empty() {
            assert_eq!(ends.iter().filter(|(code, _)| *code == Some(0)).count(), 1, "{ends:?}");
        }
        let ends = rivals(&["--overwrite"]);
        assert!(ends.iter().all(|end| *end == (Some(0), String::new())), "{ends:?}");
    }
    assert!(bench.left().iter().all(|name| !name.starts_with('.')), "{:?}", bench.left());
}

/// Names carry the time, but order and freedom of names do not rest on it.
#[cfg(target_os = "linux")]
#[test]
fn a_clock_that_is_set_back_harms_no_run() {
    let bench = bench("faults-clock");
    if Command::new("faketime").arg("--version").stdout(Stdio::null()).status().is_err() {
        skipped("faketime", "faketime is not there; apt install faketime");
        return;
    }
    for time in ["2026-05-01 12:00:00", "2026-05-01 12:00:00", "2020-01-01 00:00:00", "1969-12-31 23:00:00"] {
        let mut command = Command::new("faketime");
        command.arg(time).arg(program()).args(["simulate", "s.toml", "-q"]).current_dir(&bench.0);
        let end = command.env("TZ", "UTC").output().expect("faketime runs");
        assert!(end.status.success(), "{time}: {}", String::from_utf8_lossy(&end.stderr));
    }
    let runs = fs::read_dir(bench.0.join("outputs")).expect("runs");
    let mut names: Vec<_> =
        runs.map(|run| run.expect("an entry").file_name().into_string().expect("ASCII")).collect();
    names.sort();
    assert_eq!(names.len(), 4, "{names:?}");
    let begins = ["19700101T000000Z_s_", "20200101T0000", "20260501T1200", "20260501T1200"];
    assert!(names.iter().zip(begins).all(|(name, begin)| name.starts_with(begin)), "{names:?}");
}
