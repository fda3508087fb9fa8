//! `efam export`: what is written can be read, and says the same as the run's own table.
//!
//! Goal: both formats hold the Parquet's numbers to the same bits, with names and units. The files are read back by
//! the packages that wrote them; `tests/readers/run` has them read by Octave, h5py and the reader of MCAP.

use std::fs;

use hdf5_pure::File;
use mcap::MessageStream;
use mcap::records::Record;
use serde_json::Value;

use crate::bench::Bench;

const SCENARIO: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
    [run]\nduration = \"0.1 s\"\n";

/// A short run, and columns of it from its own CSV.
fn simulated(name: &str) -> (Bench, impl Fn(&str) -> Vec<f64>) {
    let bench = Bench::new(name);
    bench.file("s.toml", SCENARIO);
    bench.json(&["simulate", "s.toml", "--csv", "--json", "--out", "run"]);
    let text = bench.text("run/trajectory.csv");
    let column = move |name: &str| {
        let place = text.lines().next().and_then(|head| head.split(',').position(|own| own == name));
        let place = place.unwrap_or_else(|| panic!("no column {name}"));
        let cell = |line: &str| line.split(',').nth(place).expect("a cell").parse().expect("a number");
        text.lines().skip(1).map(cell).collect::<Vec<f64>>()
    };
    (bench, column)
}

#[test]
fn mat_has_the_columns_by_name_with_units() {
    let (bench, column) = simulated("export-mat");
    let printed = bench.json(&["export", "run", "--to", "mat", "--json"]);
    assert_eq!(printed["file"], "run.mat");
    assert_eq!(printed["tables"][0]["rows"], 11);
    let file = File::from_bytes(fs::read(bench.0.join("run.mat")).expect("it was written")).expect("HDF5");
    let numbers = |path: &str| file.dataset(path).expect(path).read_f64().expect("numbers");
    let text = |path: &str| {
        String::from_utf16(&file.dataset(path).expect(path).read_u16().expect("text")).expect("UTF-16")
    };
    assert_eq!(numbers("trajectory/time_s"), column("time_s"));
    assert_eq!(numbers("trajectory/tip_z_m"), column("tip_z_m"));
    // Node by node, as MATLAB stores a matrix of samples by nodes.
    assert_eq!(
        numbers("trajectory/z_m"),
        (0..8).flat_map(|k| column(&format!("z_0{k}_m"))).collect::<Vec<_>>()
    );
    assert_eq!(text("unit/trajectory/body_rate_rad_s"), "rad/s");
    assert_eq!(text("about/name"), "s");
    assert_eq!(text("about/summary_json"), bench.text("run/summary.json"));
}

#[test]
fn mcap_has_a_channel_for_each_body_at_simulated_times() {
    let (bench, column) = simulated("export-mcap");
    bench.json(&["export", "run", "--to", "mcap", "--json", "--out", "below/run.mcap"]);
    let bytes = fs::read(bench.0.join("below/run.mcap")).expect("it was written");
    let mut tip = Vec::new();
    let mut instants = Vec::new();
    for message in MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("a message");
        let schema = message.channel.schema.as_ref().expect("a schema");
        let schema: Value = serde_json::from_slice(&schema.data).expect("JSON");
        let said: Value = serde_json::from_slice(&message.data).expect("JSON");
        match message.channel.topic.as_str() {
            "/trajectory/tip" => {
                assert_eq!(schema["properties"]["tip_z_m"]["unit"], "m");
                tip.push(said["tip_z_m"].as_f64().expect("a number"));
                instants.push(message.log_time);
            }
            "/trajectory/nodes" => assert_eq!(said["vx_m_s"].as_array().map(Vec::len), Some(8)),
            "/trajectory/energy" => assert!(said["total_J"].is_number()),
            topic => assert_eq!(topic, "/trajectory/body"),
        }
    }
    // serde_json reads a number to its last digit but one.
    for (own, due) in tip.iter().zip(column("tip_z_m")) {
        assert!((own - due).abs() <= 1e-15 * due.abs(), "{own} {due}");
    }
    assert_eq!(tip.len(), 11);
    assert_eq!(instants, (0..11).map(|k| k * 10_000_000).collect::<Vec<u64>>());
    let attached =
        |record| matches!(record, Ok(Record::Attachment { header, .. }) if header.name == "summary.json");
    assert!(mcap::read::LinearReader::new(&bytes).expect("MCAP").any(attached));
}

/// Topic, instant and text of each message of a file.
pub fn messages(bench: &Bench, file: &str) -> Vec<(String, u64, String)> {
    let bytes = fs::read(bench.0.join(file)).expect("it was written");
    let said = MessageStream::new(&bytes).expect("MCAP").map(|message| {
        let message = message.expect("a message");
        (message.channel.topic.clone(), message.log_time, String::from_utf8_lossy(&message.data).into_owned())
    });
    said.collect()
}

#[test]
fn recordings_that_begin_before_their_release_and_words_are_written_too() {
    let bench = Bench::new("export-words");
    fs::create_dir_all(bench.0.join("run")).expect("the target folder can be written");
    bench.file("run/summary.json", "{ \"name\": \"a\", \"kind\": \"calibration\" }");
    bench.file("run/residuals.csv", "release,t_s,x_m,fitted_x_m\n\"a, b\",-1.25,0.5,\nc,0.5,0.25,0.125\n");
    bench.json(&["export", "run", "--to", "mcap", "--json"]);
    let expected = [
        ("/residuals/a, b", 750_000_000, r#"{"time_s":-1.25,"x_m":0.5}"#),
        ("/residuals/a, b/fitted", 750_000_000, r#"{"time_s":-1.25}"#),
        ("/residuals/c", 2_500_000_000, r#"{"time_s":0.5,"x_m":0.25}"#),
        ("/residuals/c/fitted", 2_500_000_000, r#"{"fitted_x_m":0.125,"time_s":0.5}"#),
    ];
    let expected = expected.map(|(topic, time, text)| (topic.to_owned(), time, text.to_owned()));
    assert_eq!(messages(&bench, "run.mcap"), expected);
    bench.json(&["export", "run", "--to", "mat", "--json"]);
    let file = File::from_bytes(fs::read(bench.0.join("run.mat")).expect("it was written")).expect("HDF5");
    assert_eq!(file.dataset("residuals/release").unwrap().read_f64().unwrap(), [1.0, 2.0]);
    let words = file.dataset("words/residuals/release").unwrap().read_u16().unwrap();
    assert_eq!(String::from_utf16(&words).expect("UTF-16"), "a, b\nc");
}

#[test]
fn what_cannot_be_exported_is_said_and_leaves_nothing() {
    let (bench, _) = simulated("export-wrong");
    let says = |arguments: &[&str], code: i32, expected: &str| {
        let (found, stdout, stderr) = bench.run(&[&["export"], arguments].concat());
        assert_eq!((found, stdout.as_str()), (code, ""), "{stderr}");
        assert!(stderr.contains(expected), "{stderr}");
    };
    bench.file("run.mat", "mine");
    says(
        &["run", "--to", "mat"],
        2,
        "run.mat: exists already; choose another --out, or replace it with --overwrite",
    );
    assert_eq!(bench.text("run.mat"), "mine");
    says(&["absent", "--to", "mat"], 2, "absent: is no folder");
    says(&["s.toml", "--to", "fmu"], 2, "efam.to_fmu(\"s.toml\", \"rod.fmu\")");
    says(&["run", "--to", "mat", "--out", "run"], 2, "run: is no place for a file");
    says(&["run", "--to", "mat", "--out", "s.toml/x.mat"], 1, "s.toml/x.mat: cannot be written");
    fs::create_dir_all(bench.0.join("empty")).expect("the target folder can be written");
    bench.file("empty/summary.json", "{}");
    says(&["empty", "--to", "mat"], 2, "empty: holds no table");
    bench.file("empty/grid.csv", "payload_kg\n1\n");
    says(&["empty", "--to", "mcap"], 2, "take --to mat");
    bench.file("empty/grid.parquet", "PAR1");
    says(&["empty", "--to", "mat"], 3, "grid.parquet: is not what efam");
    bench.json(&["export", "run", "--to", "mat", "--json", "--overwrite"]);
    assert_eq!(bench.left(), ["empty", "run", "run.mat", "s.toml"]);
}
