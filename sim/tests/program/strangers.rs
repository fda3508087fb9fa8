//! `--overwrite`, and folders that hold other things than a run.
//!
//! Goal: only a folder whose every entry efam wrote is replaced. A stranger's file is named in the message and stays as
//! it is, whether it was there before the run or comes while it goes on; what was computed is kept beside it.
//! Setup: each command that makes a folder; strangers of several kinds. Expected: the tree of the folder is the same,
//! byte for byte, before and after.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::Bench;
use crate::work::{WORK, bench};

/// Everything below a folder, with the bytes of each file.
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let kind = fs::symlink_metadata(&path).expect("it is there").file_type();
            if kind.is_dir() {
                open.push(path.clone());
            }
            found.insert(path.clone(), kind.is_file().then(|| fs::read(&path).expect("a file")));
        }
    }
    found
}

#[test]
fn a_strangers_folder_is_never_replaced() {
    let bench = Bench::new("strangers");
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[run]\nduration = \"0.1 s\"\n",
    );
    // As a hostile round found it: what calls itself a run, with years of work in it.
    fs::create_dir_all(bench.0.join("thesis/.git")).expect("made");
    bench.file("thesis/summary.json", "{\"kind\": \"set\"}");
    bench.file("thesis/thesis.tex", "ten years");
    bench.file("thesis/.git/HEAD", "ref: refs/heads/main");
    let before = tree(&bench.0.join("thesis"));
    let (code, _, stderr) = bench.run(&["simulate", "s.toml", "--out", "thesis", "--overwrite"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.starts_with("error: thesis: holds other files than those of a run"), "{stderr}");
    assert_eq!(tree(&bench.0.join("thesis")), before);
    assert_eq!(bench.left(), ["s.toml", "thesis"]);
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn every_command_names_what_it_did_not_write() {
    let bench = bench("strangers-all");
    // What takes minutes for many ends in the same kind of folder as what does not.
    let is_short = |name: &str| !["calibrate", "diagnose"].contains(&name);
    let works = WORK.iter().filter(|work| work.ending.is_empty() && is_short(work.arguments[0]));
    for (kind, work) in works.enumerate() {
        let out = format!("out-{kind}");
        let run = |more: &[&str]| bench.run(&[work.arguments, &["-q", "--out", &out], more].concat());
        assert_eq!(run(&[]), (0, String::new(), String::new()), "{:?}", work.arguments);
        assert_eq!(run(&["--overwrite"]).0, 0, "{:?}: a run is replaced", work.arguments);
        let folder = bench.0.join(&out);
        let first = fs::read_dir(&folder).expect("a run").map(|entry| entry.expect("an entry").path());
        let within = first.filter(|path| path.is_dir()).min().unwrap_or_else(|| folder.clone());
        for stranger in [folder.join("thesis.tex"), within.join(".hidden"), folder.join("over-the-years.txt")]
        {
            fs::write(&stranger, "mine").expect("written");
            let before = tree(&folder);
            let (code, _, stderr) = run(&["--overwrite"]);
            let name = stranger.strip_prefix(&folder).expect("below it").display().to_string();
            assert_eq!(code, 2, "{:?}: {stderr}", work.arguments);
            assert!(
                stderr.contains(&format!("holds {name}, which efam did not write; it stays")),
                "{stderr}"
            );
            assert!(tree(&folder) == before, "{:?}: {name}", work.arguments);
            fs::remove_file(&stranger).expect("it was there");
        }
        // An edited result is no longer what efam wrote.
        let edited = folder.join("report.html");
        let text = fs::read_to_string(&edited).expect("text");
        fs::write(&edited, format!("{text}<!-- my notes -->")).expect("written");
        let (code, _, stderr) = run(&["--overwrite"]);
        assert!(code == 2 && stderr.contains("which was changed since efam wrote it; it stays"), "{stderr}");
        fs::write(&edited, text).expect("written");
        assert_eq!(run(&["--overwrite"]).0, 0, "{:?}", work.arguments);
    }
    assert!(bench.left().iter().all(|name| !name.starts_with('.')), "{:?}", bench.left());
}

/// An empty folder, or the run that is to be replaced, gets a file while the new run goes on.
#[test]
fn what_comes_while_a_run_goes_on_stays() {
    let bench = Bench::new("strangers-late");
    // Some seconds, of which the file needs a few thousandths.
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n\
         [run]\nduration = \"2 s\"\n[integrator]\nfixed_step = \"0.05 ms\"\n",
    );
    for (number, more) in [&["--overwrite"][..], &[]].into_iter().enumerate() {
        let out = format!("out-{number}");
        fs::create_dir(bench.0.join(&out)).expect("made");
        let arguments = [&["simulate", "s.toml", "-q", "--no-error-estimate", "--out", &out], more].concat();
        let mut command = bench.command(&arguments);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("efam runs");
        let begin = Instant::now();
        while !bench.left().iter().any(|name| name.starts_with(&format!(".{out}.partial-"))) {
            assert!(begin.elapsed() < Duration::from_secs(60), "it does not begin");
            assert!(child.try_wait().expect("a child").is_none(), "it ends before it begins");
            sleep(Duration::from_micros(200));
        }
        bench.file(&format!("{out}/notes.txt"), "mine");
        let end = child.wait_with_output().expect("it ends");
        let stderr = String::from_utf8(end.stderr).expect("UTF-8");
        assert_eq!(end.status.code(), Some(1), "{stderr}");
        let kept = format!("the results are in {}", bench.0.join(format!("{out}_2")).display());
        assert!(
            stderr.trim_end().ends_with(&kept) || stderr.trim_end().ends_with(&format!("{out}_2")),
            "{stderr}"
        );
        assert_eq!(fs::read_dir(bench.0.join(&out)).expect("a folder").count(), 1);
        assert_eq!(bench.text(&format!("{out}/notes.txt")), "mine");
        let summary: serde_json::Value =
            serde_json::from_str(&bench.text(&format!("{out}_2/summary.json"))).expect("JSON");
        assert_eq!(summary["status"]["kind"], "complete");
    }
    assert_eq!(bench.left(), ["out-0", "out-0_2", "out-1", "out-1_2", "s.toml"]);
}

/// A sweep's folder gets files after its plan, by several programs; it deletes none that has no hash in a manifest.
#[test]
fn a_sweep_deletes_only_what_it_wrote() {
    let bench = crate::sweep::bench("strangers-sweep");
    let sweep = |more: &[&str]| {
        let whole = ["sweep", "sweep.toml", "-q", "--set", "sweep.points=4", "--points-per-shard", "2"];
        bench.run(&[&whole[..], &["--out", "out"], more].concat())
    };
    let submit = || bench.run(&["sweep", "submit", "--plan", "out", "--dry-run", "-q"]);
    let done = (0, String::new(), String::new());
    assert_eq!(sweep(&[]), done);
    assert_eq!(submit(), done);
    // Its own files are no strangers, also after a second merge.
    assert_eq!(sweep(&["--csv"]), done);
    let rows = bench.text("out/sweep.csv");
    assert_eq!(sweep(&["--overwrite"]), done);
    assert!(!bench.0.join("out/sweep.csv").exists());
    assert_eq!(submit(), done);
    for (name, reason) in [
        ("log/notes.txt", "efam did not write"),
        ("shard=mine/part.parquet", "efam did not write"),
        ("shard=00001/notes.txt", "efam did not write"),
        ("over-my-drawing.svg", "efam did not write"),
        ("sweep.csv", "efam did not write"),
        (".thesis.partial-host-1-1", "efam did not write"),
        ("shard=00001/.thesis.partial-host-1-1", "efam did not write"),
        ("array.sh", "was changed since efam wrote it"),
        ("shard=00001/part.parquet", "was changed since efam wrote it"),
        ("sweep.json", "was changed since efam wrote it"),
        ("report.html", "was changed since efam wrote it"),
    ] {
        let file = bench.0.join("out").join(name);
        let before = fs::read(&file).ok();
        fs::create_dir_all(file.parent().expect("a folder")).expect("made");
        fs::write(&file, "mine").expect("written");
        let all = tree(&bench.0.join("out"));
        let (code, _, stderr) = sweep(&["--overwrite"]);
        assert_eq!(code, 2, "{name}: {stderr}");
        assert!(stderr.contains(&format!("holds {name}, which {reason}; it stays")), "{stderr}");
        assert!(tree(&bench.0.join("out")) == all, "{name}");
        // Nor do the commands that add to the folder replace it.
        let (code, _, stderr) = match name {
            "array.sh" => submit(),
            "sweep.csv" | "sweep.json" | "report.html" => sweep(&["--csv"]),
            _ => (2, String::new(), format!("holds {name}, which ")),
        };
        assert!(code != 0 && stderr.contains(&format!("holds {name}, which ")), "{name}: {stderr}");
        assert_eq!(fs::read(&file).expect("it stays"), b"mine", "{name}");
        match before {
            Some(before) => fs::write(&file, before).expect("written"),
            None => fs::remove_file(&file).expect("it was there"),
        }
        if name.starts_with("shard=mine") {
            fs::remove_dir(file.parent().expect("a folder")).expect("it is empty");
        }
    }
    assert_eq!(sweep(&["--csv"]), done);
    assert_eq!(bench.text("out/sweep.csv"), rows);
    assert_eq!(sweep(&["--overwrite"]), done);
}
