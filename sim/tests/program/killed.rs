//! `kill -9` at random moments of every command that writes.
//!
//! Goal: what a name holds is whole, whenever the program was killed; what was there is replaced at once or
//! not at all; the next run succeeds, and tidies what the dead left.
//! Setup: half of the kills come at any moment of the run, half while it writes; half of the runs have a name that
//! is free, half replace a run. Two kills a command; `EFAM_KILLS=50 cargo test --workspace --no-default-features
//! --test program killed -- --nocapture` takes 50 of each,
//! `EFAM_WORK=simulate,sweep` of these alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::bench::{Bench, Noise};
use crate::work::{WORK, Work, bench};

/// These contain times, or their hash; of all others every byte is a function of the inputs.
const OF_THE_RUN: [&str; 3] = ["efam-files.json", "summary.json", "report.html"];

/// Files below a path by name; of those that differ from run to run, whether they are whole.
fn found(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![path.to_path_buf()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path()));
        } else if let Ok(bytes) = fs::read(&path) {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            let is_whole = match name.rsplit('.').next() {
                Some("json") => serde_json::from_slice::<serde_json::Value>(&bytes).is_ok(),
                Some("html") => bytes.ends_with(b"</html>\n"),
                _ => bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"),
            };
            let is_of_the_run = OF_THE_RUN.iter().any(|own| name.ends_with(own));
            let said = if is_of_the_run { vec![u8::from(is_whole)] } else { bytes };
            found.insert(
                format!(
                    "{}/{name}",
                    path.parent()
                        .expect("a folder")
                        .file_name()
                        .map_or("".into(), |own| own.to_string_lossy())
                ),
                said,
            );
        }
    }
    found
}

/// Whether two trees have the same files but for the name of their own folder.
fn is_same(bench: &Bench, a: &str, b: &str) -> Result<(), String> {
    let of = |name: &str| -> Vec<(String, Vec<u8>)> {
        // A file of its own has no name but that which the command was given.
        if let Ok(bytes) = fs::read(bench.0.join(name)) {
            return vec![(String::new(), bytes)];
        }
        found(&bench.0.join(name))
            .into_iter()
            .map(|(file, bytes)| (file.replace(&format!("{name}/"), ""), bytes))
            .collect()
    };
    let (mut a, mut b) = (of(a), of(b));
    a.sort();
    b.sort();
    let names = |all: &[(String, Vec<u8>)]| all.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    if names(&a) != names(&b) {
        return Err(format!("{:?} and {:?}", names(&a), names(&b)));
    }
    match a.iter().zip(&b).find(|(a, b)| a.1 != b.1) {
        Some((differs, _)) => Err(format!("{} differs", differs.0)),
        None => Ok(()),
    }
}

fn hidden(bench: &Bench) -> Vec<String> {
    bench.left().into_iter().filter(|name| name.starts_with('.')).collect()
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn what_is_under_a_name_is_whole_whenever_it_was_killed() {
    let kills = std::env::var("EFAM_KILLS").ok().and_then(|count| count.parse().ok()).unwrap_or(2);
    let only = std::env::var("EFAM_WORK").unwrap_or_default();
    // An experiment's first file has the name that it is given in it, so no two are the same.
    let is_asked = |work: &Work| {
        work.arguments[0] != "experiment"
            && (only.is_empty() || only.split(',').any(|own| own == work.arguments[0]))
    };
    let bench = bench("killed");
    let (mut begun, mut killed, mut writing) = (0, 0, 0);
    for (kind, work) in WORK.iter().enumerate().filter(|(_, work)| is_asked(work)) {
        let of = disturbed(&bench, kind, work, kills);
        println!(
            "{:60} {} runs, {} killed, {} of them while they wrote",
            work.arguments.join(" "),
            kills,
            of.0,
            of.1
        );
        (begun, killed, writing) = (begun + kills, killed + of.0, writing + of.1);
    }
    println!("{begun} runs, {killed} killed, {writing} of them while they wrote");
    assert!(2 * killed >= begun, "{killed} of {begun} were slower than their killer");
}

/// How many of the runs were killed, and how many of these left something behind.
fn disturbed(bench: &Bench, kind: usize, work: &Work, kills: usize) -> (usize, usize) {
    let name = |what: &str| format!("{what}-{kind}{}", work.ending);
    // A sweep goes on where it was; all else is done anew.
    let overwrite: &[&str] = if work.at_once { &["--overwrite"] } else { &[] };
    let command = |out: &str| {
        let mut command = bench.command(&[work.arguments, overwrite, &["-q", "--out", out]].concat());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let whole = name("whole");
    let begin = Instant::now();
    assert!(command(&whole).status().is_ok_and(|status| status.success()), "{}", work.arguments.join(" "));
    let first = begin.elapsed();
    let replaced = name("replaced");
    let begin = Instant::now();
    assert!(command(&replaced).status().is_ok_and(|status| status.success()));
    // The machine has other work at times.
    let takes = first.min(begin.elapsed());
    is_same(bench, &whole, &replaced).expect("the same command leaves the same");
    let mut random = Noise::new(7 + kind as u64);
    let mut uniform = move || (0.5 + random.normal() * 0.4).rem_euclid(1.0);
    let (mut killed, mut writing) = (0, 0);
    for k in 0..kills {
        let is_new = k % 2 == 0 || !work.at_once;
        let out = if is_new { name(&format!("new-{k}")) } else { replaced.clone() };
        let mut child = command(&out).spawn().expect("efam runs");
        let begin = Instant::now();
        if k / 2 % 2 == 0 {
            sleep(takes.mul_f64(uniform()));
        } else {
            while writes(bench, &out).is_none() && child.try_wait().expect("a child").is_none() {
                assert!(begin.elapsed() < 20 * takes + Duration::from_secs(60), "it hangs");
                sleep(Duration::from_micros(200));
            }
            sleep(takes.mul_f64(0.05 * uniform()));
        }
        let in_time = child.try_wait().expect("a child").is_none();
        let _ = child.kill();
        let _ = child.wait();
        killed += usize::from(in_time);
        writing += usize::from(!hidden(bench).is_empty());
        let there = bench.0.join(&out).exists();
        assert!(there || is_new, "kill {k} of {:?}: nothing is under the name", work.arguments);
        if there && work.at_once {
            is_same(bench, &whole, &out)
                .unwrap_or_else(|why| panic!("kill {k} of {:?}: {why}", work.arguments));
        }
        // The same command goes on, or does it again.
        if !work.at_once || k + 2 >= kills {
            assert!(command(&out).status().is_ok_and(|status| status.success()), "after kill {k}");
            is_same(bench, &whole, &out).unwrap_or_else(|why| panic!("after kill {k}: {why}"));
            assert_eq!(hidden(bench), [""; 0], "after kill {k} of {:?}", work.arguments);
        }
    }
    (killed, writing)
}

/// What a run that is going on has written already, beside its place or in its folder.
fn writes(bench: &Bench, out: &str) -> Option<()> {
    let partial = hidden(bench).into_iter().next()?;
    let path = bench.0.join(partial);
    let some = path.is_file() || fs::read_dir(path).ok()?.next().is_some();
    (some || bench.0.join(out).join("plan.json").exists()).then_some(())
}
