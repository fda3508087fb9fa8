//! `efam sweep` over experiments: each row is what `efam diagnose` says, and an experiment that was changed since the
//! plan, or cannot be read, is a row as well.
//!
//! Setup: a drawn experiment of the worked examples, with a catalogue of three effects, so that it does not take long.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::bench::Bench;
use crate::sweep::{bytes, copied};

/// Effects that are not left out.
const ASKED: [&str; 3] = ["air_drag", "tip_drag", "viscoelastic"];

/// An empty bench, and the effects that are left out.
fn bench(name: &str) -> (Bench, Vec<String>) {
    let bench = Bench::new(name);
    let catalogue = bench.json(&["effects", "--json"]);
    let names = catalogue["effects"].as_array().expect("a list").iter();
    let names = names.map(|own| own["name"].as_str().expect("a name").to_owned());
    let without = names.filter(|name| !ASKED.contains(&name.as_str())).collect();
    (bench, without)
}

/// Puts a worked example into a folder of the bench.
pub fn example(bench: &Bench, name: &str, to: &str) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/diagnosis").join(name);
    fs::create_dir_all(bench.0.join(to)).expect("a new folder");
    for entry in fs::read_dir(from).expect("an example") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("text");
        // The hold and three swings, which is enough to find drag of its usual size.
        let is_table = path.extension().is_some_and(|own| own == "csv");
        let text =
            if is_table { text.lines().take(400).map(|line| format!("{line}\n")).collect() } else { text };
        fs::write(bench.0.join(to).join(path.file_name().expect("a name")), text).expect("written");
    }
}

fn sweep(without: &[String]) -> String {
    format!(
        "[sweep]\nexperiments = [\"set/*/experiment.toml\"]\ndiagnose = {{ most = 1, without = {without:?} }}\n"
    )
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_row_is_a_diagnosis() {
    let (bench, without) = bench("sweep-experiments");
    example(&bench, "air-drag", "set/drag");
    for name in ["broken", "changed", "robbed"] {
        example(&bench, "air-drag", &format!("set/{name}"));
    }
    bench.file("set/broken/40psi-1.csv", "");
    let robbed = "[[sweep.experiment]]\nfile = \"set/r*/experiment.toml\"\nwithout = \"air_drag\"\n";
    bench.file("sweep.toml", &(sweep(&without) + robbed));
    let planned = bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "out"]);
    assert_eq!(planned["shards"], 4, "each has a shard of its own");
    copied(&bench, "out", "other");
    let changed = bench.text("set/changed/15psi-1.csv");
    bench.file("set/changed/15psi-1.csv", &changed.replacen("0.010,", "0.011,", 1));
    bench.file("fresh.toml", &sweep(&without).replace("set/*/", "set/[bc]*/"));
    let value =
        bench.json(&["sweep", "fresh.toml", "--json", "--csv", "--out", "fresh", "--points-per-shard", "3"]);
    assert_eq!(value["sweep"]["failed"], 1, "a new plan takes it as it is now: {value}");
    bench.json(&["sweep", "run", "--plan", "out", "--json"]);
    let value = bench.json(&["sweep", "merge", "--plan", "out", "--json"]);
    let sweep = &value["sweep"];
    assert_eq!((&sweep["points"], &sweep["failed"]), (&4.into(), &2.into()), "{value}");
    let answers = sweep["diagnosed"]["experiments"].as_array().expect("rows");
    let [broken, changed, drag, robbed] = &answers[..] else { panic!("{answers:?}") };
    let why = |row: &Value| row["failed"].as_str().expect("a reason").to_owned();
    assert!(why(broken).contains("40psi-1.csv"), "{broken}");
    assert!(!why(broken).contains(&bench.0.display().to_string()), "a path of this machine: {broken}");
    assert!(
        why(changed).starts_with("set/changed/experiment.toml: it, a recording or a muscle"),
        "{changed}"
    );
    // What is said by the command that diagnoses one.
    let mut words = vec!["diagnose", "set/drag/experiment.toml", "--most", "1", "--json"];
    words.extend(without.iter().flat_map(|name| ["--without", name]));
    let alone = &bench.json(&words)["diagnosis"];
    assert_eq!((&drag["verdict"], &drag["effects"]), (&alone["verdict"], &alone["effects"]));
    let members: Vec<&Value> =
        alone["members"].as_array().expect("a list").iter().map(|own| &own["effect"]).collect();
    assert!(json!(drag["members"]) == json!(members) && !members.is_empty(), "{drag} {members:?}");
    let worst = |held_out: bool, key: &str| {
        let own = alone["gap"].as_array().expect("a list").iter().filter(|gap| gap["held_out"] == held_out);
        own.filter_map(|gap| gap[key].as_f64()).fold(0.0, f64::max)
    };
    assert_eq!(drag["gap"], json!([worst(false, "before"), worst(false, "after")]));
    assert_eq!(drag["held_out_gap"], json!([worst(true, "before"), worst(true, "after")]));
    assert!(drag["seconds"].as_f64().is_some_and(|seconds| seconds > 0.0), "{drag}");
    assert_eq!(robbed["effects"][0]["effect"], "tip_drag", "{robbed}");
    let page = bench.text("out/report.html");
    assert!(
        page.contains("4 experiments, at a false-alarm level of 0.01, with 1 added at most; 2 could not")
    );
    assert!(page.contains("set/robbed/experiment.toml") && page.contains("tip_drag"));
    // Alone on one thread, shard by shard: the same bytes.
    for shard in ["3", "0", "2", "1"] {
        let mut command = bench.command(&["sweep", "run", "--plan", "other", "-q", "--shard", shard]);
        assert!(command.env("RAYON_NUM_THREADS", "1").status().expect("efam runs").success());
    }
    bench.json(&["sweep", "merge", "--plan", "other", "--json"]);
    let parts = (0..4).map(|shard| format!("shard={shard:05}/part.parquet"));
    for file in parts.chain(["sweep.parquet".to_owned()]) {
        let [a, b] = ["out", "other"].map(|folder| bytes(&bench, &format!("{folder}/{file}")));
        assert!(a == b, "{file}");
    }
}

#[test]
fn what_is_wrong_with_it_is_said_and_nothing_is_written() {
    let (bench, without) = bench("sweep-experiments-wrong");
    example(&bench, "nothing", "set/good");
    bench.file("set/good/empty.toml", "");
    let right = sweep(&without);
    let before = {
        bench.file("sweep.toml", "");
        bench.left()
    };
    let says = |text: &str, expected: &str| {
        bench.file("sweep.toml", text);
        let (code, stdout, stderr) = bench.run(&["sweep", "plan", "sweep.toml", "--out", "out"]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{text}\n{stderr}");
        assert!(stderr.contains(expected), "{text}\n{stderr}");
        assert_eq!(bench.left(), before, "{text}: leaves something behind");
    };
    says(&right.replace("set/*", "sets/*"), ": no file is like `sets/*/experiment.toml`, seen from");
    says(&right.replace("set/*", "set/**x"), "`set/**x/experiment.toml` is no pattern (");
    says("[sweep]\nexperiments = []\n", "sweep.experiments = []: must name one file at least");
    says(
        &right.replace("/experiment.toml", "/empty.toml"),
        "none of 1 can be diagnosed, the first because of this: ",
    );
    says(
        &(right.clone() + "seed = 1\n"),
        "sweep.seed = 1: belongs to a sweep over a scenario, and this one has",
    );
    says(
        "[sweep]\nscenario = \"s.toml\"\ndiagnose = {}\n",
        "sweep.diagnose = {}: belongs to a sweep over experiments",
    );
    says(&right.replace("most = 1", "moist = 1"), "sweep.diagnose.moist: unknown key; did you mean `most`?");
    says(
        &right.replace("most = 1", "budget = 0"),
        "sweep.diagnose.budget = 0: must be a number of node steps",
    );
    says(
        &right.replace("most = 1", "false_alarm = 1"),
        "sweep.diagnose.false_alarm = 1: must lie between 0 and 1",
    );
    let robbed = |text: &str| right.clone() + "[[sweep.experiment]]\n" + text;
    says(&robbed("without = \"dahl\"\n"), "sweep.experiment[1].file: is missing");
    let file = "file = \"set/good/experiment.toml\"\n";
    says(
        &robbed(&format!("{file}without = \"dahll\"\n")),
        "there is no effect `dahll`; did you mean `dahl`?",
    );
    fs::copy(bench.0.join("set/good/experiment.toml"), bench.0.join("set/good/a,b.toml")).expect("copied");
    says(&right.replace("experiment.toml", "a*.toml"), "`set/good/a,b.toml` has a comma");
    // One that cannot be read beside one that can is a warning now, and a row later.
    let both = right.replace("experiment.toml", "e*.toml");
    bench.file("sweep.toml", &both);
    let (code, _, stderr) = bench.run(&["sweep", "plan", "sweep.toml", "--out", "out"]);
    assert!(code == 0 && stderr.contains("warning: 1 of 2 experiments cannot be diagnosed"), "{stderr}");
}
