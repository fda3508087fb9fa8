//! Whole command lines at random: arguments, environment, paths, and folders that hold other things.
//!
//! Goal: no panic, no code of its own beyond those that the help lists, no word that acts on a terminal, no number that
//! fills a page; and no file outside the requested place is created, changed or removed.
//! Setup: a house of folders, of which every entry is hashed before and after; commands that make sense, with words
//! put in, left out and replaced. 120 lines; `EFAM_LINES=10000` tries as many, `EFAM_SEED` others (see `draws.rs`).

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, program};
use crate::draws::{Draws, count};
use crate::strangers::tree;

/// Longer than any of these takes on a busy machine.
const SOON: Duration = Duration::from_secs(120);

/// Commands that make sense in the house.
const LINES: [&[&str]; 35] = [
    &["simulate", "s.toml"],
    &["simulate", "s.toml", "--csv", "--json"],
    &["simulate", "s.toml", "--overwrite", "--out", "run"],
    &["simulate", "s.toml", "--overwrite", "--out", "thesis"],
    &["simulate", "s.toml", "--out", "empty"],
    &["simulate", "s.toml", "--overwrite", "--out", "mixed"],
    &["simulate", "s.toml", "--pressure", "40psi", "--set", "effects.payload.mass=50 g"],
    &["calibrate", "e.toml", "--overwrite", "--out", "thesis"],
    &["calibrate", "broken.toml"],
    &["diagnose", "broken.toml", "--most", "1"],
    &["predict", "--muscle", "known.toml", "--pressure", "40psi", "--duration", "0.2 s", "--draws", "3"],
    &["sweep", "sweep.toml", "--out", "map", "--csv"],
    &["sweep", "sweep.toml", "--overwrite", "--out", "plan"],
    &["sweep", "plan", "sweep.toml", "--out", "map"],
    &["sweep", "run", "--plan", "plan", "--shard", "1"],
    &["sweep", "status", "--plan", "plan", "--json"],
    &["sweep", "submit", "--plan", "plan", "--dry-run"],
    &["sweep", "merge", "--plan", "plan"],
    &["view", "run"],
    &["report", "run", "run", "--out", "both"],
    &["report", "run", "thesis"],
    &["export", "run", "--to", "mat"],
    &["export", "run", "--to", "mcap", "--out", "thesis/x.mcap"],
    &["export", "run", "--to", "mat", "--overwrite", "--out", "notes.txt"],
    &["figures", "--set", "run.duration=0.1"],
    &["effects", "viscoelastic"],
    &["experiment", "init", "15psi.csv"],
    &["experiment", "init", "15psi.csv", "--overwrite", "--out", "notes.txt"],
    &["experiment", "check", "e.toml", "--out", "checked"],
    &["inspect", "15psi.csv", "--json"],
    &["statics", "s.toml"],
    &["modes", "s.toml", "--count", "2"],
    &["linearise", "s.toml", "--input", "force_z", "--sample", "10ms", "--reduce", "2", "--out", "linear"],
    &["man", "--out", "man1"],
    &["doctor"],
];

/// Words that are put in: options, paths, quantities, and what is none of these.
const WORDS: [&[u8]; 60] = [
    b"--json",
    b"-q",
    b"-v",
    b"--csv",
    b"--overwrite",
    b"--out",
    b"--set",
    b"--plan",
    b"--help",
    b"--color=always",
    b"--decisions",
    b"--points-per-shard",
    b"--no-error-estimate",
    b"--",
    b"-",
    b"",
    b" ",
    b".",
    b"..",
    b"/",
    b"../other",
    b"../../above.txt",
    b"thesis",
    b"thesis/.git",
    b"thesis/thesis.tex",
    b"run",
    b"run/summary.json",
    b"run/new",
    b"link",
    b"nowhere",
    b"pipe",
    b"empty",
    b"mixed",
    b"plan",
    b"plan/plan.json",
    b"s.toml",
    b"e.toml",
    b"broken.toml",
    b"sweep.toml",
    b"known.toml",
    b"15psi.csv",
    b"a b",
    b"new\nline",
    b"caf\xe9.csv",
    b"\xff",
    b"\x1b[31m",
    b"\xe2\x80\xae",
    b"-1",
    b"0",
    b"7",
    b"99999999999999999999",
    b"1e309",
    b"nan",
    b"15 psi",
    b"0.1 Pa",
    b"run.duration=0.05 s",
    b"rod.nodes=4",
    b"a.b.c.d=[[{",
    b"rod.length=",
    b"muscle.name=\x1b]0;x\x07",
];

/// The content of the environment.
const ENVIRONMENT: [(&str, &[&[u8]]); 9] = [
    ("RAYON_NUM_THREADS", &[b"1", b"2", b"3", b"0", b"x", b"1000000", b"\xff"]),
    ("NO_COLOR", &[b"", b"1"]),
    ("SLURM_ARRAY_TASK_ID", &[b"0", b"1", b"-1", b"x", b"99999999999999999999", b"\xff"]),
    ("HOME", &[b"", b"/", b"nowhere", b"\xff"]),
    ("TMPDIR", &[b"", b"/nowhere", b"pipe", b"\xff"]),
    ("COLUMNS", &[b"0", b"1", b"-1", b"99999999999999999999", b"x"]),
    ("TERM", &[b"", b"dumb", b"\x1b[31m", b"\xff"]),
    ("PATH", &[b"", b".", b"/nowhere"]),
    ("LC_ALL", &[b"C", b"\xff"]),
];

/// Builds the house; the commands run in `house/work`.
fn built(bench: &Bench) -> PathBuf {
    let house = bench.0.join("house");
    let _ = fs::remove_dir_all(&house);
    let work = house.join("work");
    fs::create_dir_all(work.join("thesis/.git")).expect("made");
    let put = |name: &str, text: &[u8]| fs::write(house.join(name), text).expect("written");
    fs::create_dir_all(house.join("other")).expect("made");
    put("above.txt", b"above");
    put("other/notes.txt", b"other");
    // It calls itself a run, and holds years.
    put("work/thesis/summary.json", b"{\"kind\": \"set\"}");
    put("work/thesis/thesis.tex", b"ten years");
    put("work/thesis/.git/HEAD", b"ref: refs/heads/main");
    put("work/notes.txt", b"mine");
    put("work/broken.toml", b"[[recording]]\nfile = \"nowhere.csv\"\ntip = \"Tip\"\n");
    fs::create_dir(work.join("empty")).expect("made");
    for file in ["s.toml", "e.toml", "15psi.csv", "known.toml", "sweep.toml"] {
        fs::copy(bench.0.join(file), work.join(file)).expect("copied");
    }
    let copy = |from: &str, to: &str| {
        for (path, bytes) in tree(&bench.0.join(from)) {
            let to = work.join(to).join(path.strip_prefix(bench.0.join(from)).expect("below it"));
            match bytes {
                None => fs::create_dir_all(to).expect("made"),
                Some(bytes) => {
                    fs::create_dir_all(to.parent().expect("a folder")).expect("made");
                    fs::write(to, bytes).expect("written");
                }
            }
        }
    };
    copy("run", "run");
    copy("planned", "plan");
    // A run into which somebody put more.
    copy("run", "mixed");
    put("work/mixed/figures-for-the-paper.tex", b"mine");
    std::os::unix::fs::symlink("thesis", work.join("link")).expect("made");
    std::os::unix::fs::symlink("gone", work.join("dangling")).expect("made");
    assert!(Command::new("mkfifo").arg(work.join("pipe")).status().expect("mkfifo runs").success());
    fs::write(
        work.join(OsStr::from_bytes(b"caf\xe9.csv")),
        fs::read(work.join("15psi.csv")).expect("it is there"),
    )
    .expect("written");
    house
}

/// A command line: one that makes sense, with some words put in, left out, replaced or doubled.
fn drawn(draws: &mut Draws) -> Vec<OsString> {
    let mut words: Vec<OsString> = draws.one(&LINES).iter().map(Into::into).collect();
    for _ in 0..[0, 1, 1, 2, 3][draws.below(5)] {
        let word = OsStr::from_bytes(draws.one(&WORDS)).to_owned();
        let at = draws.below(words.len() + 1);
        match draws.below(4) {
            0 if at < words.len() => drop(words.remove(at)),
            1 if at < words.len() => words[at] = word,
            2 if at < words.len() => words.insert(at, words[at].clone()),
            _ => words.insert(at, word),
        }
    }
    words
}

/// Where a command line may write: what follows `--out` or `--plan`, and its default place.
fn asked(words: &[OsString], work: &Path) -> Vec<PathBuf> {
    let mut places: Vec<PathBuf> = ["outputs", "experiment.toml"].map(|name| work.join(name)).into();
    for (k, word) in words.iter().enumerate() {
        let bytes = word.as_bytes();
        for option in ["--out", "--plan"] {
            let value = match bytes.strip_prefix(option.as_bytes()) {
                Some(b"") => words.get(k + 1).cloned(),
                Some([b'=', rest @ ..]) => Some(OsStr::from_bytes(rest).to_owned()),
                _ => None,
            };
            places.extend(value.map(|value| plain(&work.join(value))));
        }
        // An export goes beside its run.
        let beside = plain(&work.join(word));
        if words.iter().any(|word| word == "export") && beside.file_name().is_some() {
            places.extend(["mat", "mcap"].map(|ending| {
                let mut name = beside.file_name().expect("it has one").to_owned();
                name.push(format!(".{ending}"));
                beside.with_file_name(name)
            }));
        }
    }
    places
}

/// A path without `.` and `..`; a link to a folder leads to it, and the file of a plan to its folder.
fn plain(path: &Path) -> PathBuf {
    if let Ok(whole) = fs::canonicalize(path) {
        return if whole.ends_with("plan.json") {
            whole.parent().expect("a folder").to_owned()
        } else {
            whole
        };
    }
    let mut whole = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(whole.pop()),
            part => whole.push(part),
        }
    }
    whole
}

/// Whether something may be new: it is requested, or a folder on the way to that, or has its name and a number.
fn may_be_new(path: &Path, places: &[PathBuf]) -> bool {
    places.iter().any(|place| {
        let numbered = path.ancestors().any(|path| {
            let [own, asked] =
                [path, place].map(|path| path.file_name().unwrap_or_default().to_string_lossy());
            let number = own.strip_prefix(&*asked).and_then(|rest| rest.strip_prefix('_'));
            path.parent() == place.parent() && number.is_some_and(|number| number.parse::<u32>().is_ok())
        });
        path.starts_with(place) || place.starts_with(path) || numbered
    })
}

type Tree = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// What of the house is not as it may be after a command line.
fn wrong(before: &Tree, after: &Tree, words: &[OsString], work: &Path) -> Vec<String> {
    let places = asked(words, work);
    let overwrites = words.iter().any(|word| word == "--overwrite");
    let is_plan = words.iter().any(|word| word == "sweep");
    let mut wrong = Vec::new();
    for (path, bytes) in before {
        if after.get(path) == Some(bytes) {
            continue;
        }
        // A run that efam wrote, or the one file that is named, and only if that is requested; a sweep goes on in its folder.
        let is_run = |place: &PathBuf| {
            let strangers =
                ["thesis", "mixed", "other"].iter().any(|name| place.starts_with(work.join(name)));
            path.starts_with(place) && before.contains_key(&place.join("efam-files.json")) && !strangers
        };
        let may = places.iter().any(|place| {
            (overwrites || is_plan) && is_run(place) || overwrites && place == path && bytes.is_some()
        });
        if !may {
            let what = if after.contains_key(path) { "changed" } else { "removed" };
            wrong.push(format!("{what}: {}", path.display()));
        }
    }
    let new = after.keys().filter(|path| !before.contains_key(*path));
    for path in new {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !may_be_new(path, &places) || name.contains(".partial-") || name.contains(".unheld-") {
            wrong.push(format!("created: {}", path.display()));
        }
    }
    wrong
}

/// Letters that act on a terminal.
fn hidden(text: &str, is_coloured: bool) -> Option<char> {
    let acts = |c: &char| {
        c.is_control() && *c != '\n' && *c != '\t' && !(is_coloured && *c == '\u{1b}')
            || ('\u{202a}'..='\u{202e}').contains(c)
            || ('\u{2066}'..='\u{2069}').contains(c)
    };
    text.chars().find(acts)
}

#[test]
fn nothing_is_harmed_by_any_command_line() {
    let bench = crate::work::bench("command-lines");
    let short = bench.text("s.toml").replace("duration = \"1 s\"", "duration = \"0.05 s\"");
    bench.file("s.toml", &short);
    bench.file("sweep.toml", &bench.text("sweep.toml").replace("points = 8", "points = 3"));
    bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "planned"]);
    let house = built(&bench);
    let work = house.join("work");
    let whole = tree(&house);
    let mut draws = Draws::new("command lines");
    let mut codes: BTreeMap<String, usize> = BTreeMap::new();
    for k in 0..count("EFAM_LINES", 120) {
        let words = drawn(&mut draws);
        let mut command = Command::new(program());
        command.args(&words).current_dir(&work).stdin(Stdio::null()).env("RAYON_NUM_THREADS", "1");
        command.env("HOME", house.join("other")).env_remove("NO_COLOR");
        let mut environment = Vec::new();
        while draws.percent(12) {
            let (name, values) = ENVIRONMENT[draws.below(ENVIRONMENT.len())];
            let value = OsStr::from_bytes(draws.one(values));
            command.env(name, value);
            environment.push((name, value));
        }
        let line = format!("line {k}: {environment:?} efam {words:?}");
        let (stdout, stderr) = (bench.0.join("stdout"), bench.0.join("stderr"));
        let to = |path: &Path| fs::File::create(path).expect("made");
        let mut child = command.stdout(to(&stdout)).stderr(to(&stderr)).spawn().expect("efam runs");
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            if begin.elapsed() > SOON {
                let _ = child.kill();
                panic!("{line}: it hangs");
            }
            sleep(Duration::from_millis(1));
        };
        let [stdout, stderr] = [stdout, stderr]
            .map(|path| String::from_utf8_lossy(&fs::read(path).expect("it is there")).into_owned());
        let code = status.code();
        *codes.entry(format!("{code:?}")).or_default() += 1;
        assert!(matches!(code, Some(0..=4)), "{line}: {status:?}\n{stderr}");
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        assert!(code == Some(0) || !stderr.is_empty(), "{line}: ends with {code:?} and no word");
        assert!(code != Some(0) || !stderr.starts_with("error"), "{line}: ends well, with {stderr}");
        let is_coloured = words.iter().any(|word| word.as_bytes().starts_with(b"--color"));
        for text in [&stdout, &stderr] {
            assert_eq!(hidden(text, is_coloured), None, "{line}: {text:?}");
            // Seventeen digits count, and up to five zeros come before them.
            let digits = text.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
            assert!(
                digits <= 22 || text.contains("sha256") || words.iter().any(|word| word.len() > 18),
                "{line}: {text}"
            );
        }
        let after = tree(&house);
        if after != whole {
            let wrong = wrong(&whole, &after, &words, &work);
            assert!(wrong.is_empty(), "{line}\n{}\n{stderr}", wrong.join("\n"));
            assert_eq!(built(&bench), house);
        }
    }
    println!("{codes:?}");
}

/// The check of the test above finds harm.
#[test]
fn what_is_harmed_is_noticed() {
    let work = Path::new("/house/work");
    let tree = |all: &[(&str, &[u8])]| -> Tree {
        all.iter().map(|(name, bytes)| (work.join(name), Some(bytes.to_vec()))).collect()
    };
    let before =
        tree(&[("run/efam-files.json", b"{}"), ("run/a", b"1"), ("thesis/a", b"1"), ("notes.txt", b"1")]);
    let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
    let seen = |line: &str, after: &[(&str, &[u8])]| wrong(&before, &tree(after), &words(line), work);
    let run: [(&str, &[u8]); 4] =
        [("run/efam-files.json", b"{}"), ("run/a", b"2"), ("thesis/a", b"1"), ("notes.txt", b"1")];
    assert_eq!(seen("simulate s --out run --overwrite", &run), [""; 0]);
    assert_eq!(seen("simulate s --out run", &run), ["changed: /house/work/run/a"]);
    assert_eq!(seen("simulate s --out thesis --overwrite", &run), ["changed: /house/work/run/a"]);
    let gone = seen("simulate s --out thesis --overwrite", &run[..2]);
    assert_eq!(gone.len(), 3, "{gone:?}");
    let new = [&run[..1], &[("run/a", &b"1"[..]), ("thesis/a", b"1"), ("notes.txt", b"1"), ("stray", b"")]]
        .concat();
    assert_eq!(seen("simulate s", &new), ["created: /house/work/stray"]);
    assert_eq!(seen("simulate s --out stray", &new), [""; 0]);
}
