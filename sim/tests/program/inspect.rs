//! `efam inspect` on a small file of each text format.
//!
//! Goal: whatever system wrote it, a file is shown with its rate, its markers in metres and what is lost;
//! a broken one is said, and hides none of the others. Expected: what the files below are written with.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::bench::Bench;

/// Samples of each file.
const SAMPLES: usize = 6;
/// Samples in which `Tip` is lost.
const LOST: [usize; 2] = [1, 3];

/// A file, and what must be found in it.
struct File {
    name: &'static str,
    format: &'static str,
    text: String,
    rate: f64,
    unit: &'static str,
}

/// A header with rows under it: what a row begins with, then `Tip` 100 to 105 mm, 20 mm, -40 mm, and `Base`
/// at rest; `mm` is a millimetre in the file's unit, `lost` is the text of a coordinate that is not there.
fn table(header: &str, begins: impl Fn(usize) -> String, delimiter: &str, mm: f64, lost: &str) -> String {
    let mut text = header.to_owned();
    for k in 0..SAMPLES {
        let tip = [100.0 + k as f64, 20.0, -40.0].map(|at| (!LOST.contains(&k)).then_some(at));
        text += &begins(k);
        for at in tip.into_iter().chain([1.0, 2.0, 3.0].map(Some)) {
            let cell = at.map_or(lost.to_owned(), |at| format!("{:.5}", mm * at));
            let _ = write!(text, "{delimiter}{cell}");
        }
        text += "\n";
    }
    text
}

fn files() -> [File; 6] {
    let time = |k: usize, rate: f64| format!("{:.6}", k as f64 / rate);
    let tidy = "t_s,Tip_x_cm,Tip_y_cm,Tip_z_cm,Base_x_cm,Base_y_cm,Base_z_cm\n";
    let nexus = "Trajectories\n200\n,,Tip,,,Base,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n";
    let legacy = "Title\nDate:\n\nTRAJECTORIES\n100,Hz\n,Tip,,,Base,,\nField #,X,Y,Z,X,Y,Z\n";
    let motive = "Format Version,1.23,Export Frame Rate,120,Length Units,Meters\n\n\
        ,Type,Marker,Marker,Marker,Marker,Marker,Marker\n,Name,Tip,Tip,Tip,Base,Base,Base\n,ID,1,1,1,2,2,2\n\
        ,,Position,Position,Position,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,X,Y,Z\n";
    let qualisys = "NO_OF_MARKERS\t2\nFREQUENCY\t150\nDATA_INCLUDED\t3D\nMARKER_NAMES\tTip\tBase\n\
        Frame\tTime\tTip X\tTip Y\tTip Z\tBase X\tBase Y\tBase Z\n";
    let trc = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n250\t6\t2\tin\n\
        Frame#\tTime\tTip\t\t\tBase\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n";
    let of = |name, format, text, rate, unit| File { name, format, text, rate, unit };
    [
        of(
            "tidy.csv",
            "tidy table",
            table(tidy, |k| time(k, 50.0), ",", 0.1, ""),
            50.0,
            "cm, as the line of names states",
        ),
        of(
            "nexus.csv",
            "Vicon Nexus trajectories",
            table(nexus, |k| format!("{},0", 11 + k), ",", 1.0, ""),
            200.0,
            "mm, as line 5 states",
        ),
        of(
            "legacy.csv",
            "older Vicon trajectories",
            table(legacy, |k| format!("{}", 1 + k), ",", 1.0, "0"),
            100.0,
            "mm is assumed, for the file states none: Vicon writes millimetres",
        ),
        of(
            "motive.csv",
            "OptiTrack Motive CSV",
            table(motive, |k| format!("{k},{}", time(k, 120.0)), ",", 1e-3, ""),
            120.0,
            "m, as Length Units in line 1 states",
        ),
        of(
            "qualisys.tsv",
            "Qualisys TSV",
            table(qualisys, |k| format!("{}\t{}", 1 + k, time(k, 150.0)), "\t", 1.0, "0.000"),
            150.0,
            "mm is assumed, for the file states none: Qualisys Track Manager writes millimetres",
        ),
        of(
            "swing.trc",
            "TRC",
            table(trc, |k| format!("{}\t{}", 1 + k, time(k, 250.0)), "\t", 1.0 / 25.4, "0"),
            250.0,
            "in, as Units in line 3 states",
        ),
    ]
}

/// Whether lowest and highest values are those, mm; files have five decimals of an inch at worst.
fn spans(marker: &Value, expected: [[f64; 2]; 3]) -> bool {
    let near = |found: &Value, mm: &f64| found.as_f64().is_some_and(|m| (1e3 * m - mm).abs() < 1e-3);
    (0..3).all(|axis| (0..2).all(|k| near(&marker["lowest_and_highest_m"][axis][k], &expected[axis][k])))
}

#[test]
fn every_text_format_is_told_with_rate_unit_markers_and_losses() {
    let bench = Bench::new("inspect");
    let files = files();
    files.iter().for_each(|file| bench.file(file.name, &file.text));
    let names: Vec<&str> = files.iter().map(|file| file.name).collect();
    let value = bench.json(&[&["inspect", "--json"], &names[..]].concat());
    let recordings = value["recordings"].as_array().expect("rows");
    assert_eq!(recordings.len(), files.len());
    for (found, file) in recordings.iter().zip(&files) {
        assert_eq!((&found["file"], &found["format"]), (&json!(file.name), &json!(file.format)));
        assert_eq!((&found["rate_hz"], &found["samples"]), (&json!(file.rate), &json!(SAMPLES)), "{found}");
        let duration = found["duration_s"].as_f64().expect("a number");
        // Times have six decimals.
        assert!((duration - (SAMPLES - 1) as f64 / file.rate).abs() < 2e-6, "{found}");
        let [tip, base] = found["markers"].as_array().expect("markers").as_slice() else {
            panic!("two markers in {found}")
        };
        assert_eq!((&tip["name"], &base["name"]), (&json!("Tip"), &json!("Base")), "{}", file.name);
        for (marker, lost, gap) in [(tip, 2, 1), (base, 0, 0)] {
            assert_eq!((&marker["lost"], &marker["longest_gap_samples"]), (&json!(lost), &json!(gap)));
            assert_eq!(marker["lost_share"], json!(f64::from(lost) / SAMPLES as f64));
        }
        assert!(spans(tip, [[100.0, 105.0], [20.0; 2], [-40.0; 2]]), "{tip} in {}", file.name);
        assert!(spans(base, [[1.0; 2], [2.0; 2], [3.0; 2]]), "{base} in {}", file.name);
        let unit = format!("unit: {}", file.unit);
        assert!(found["findings"].as_array().expect("rows").contains(&json!(unit)), "{unit} in {found}");
    }

    let (code, stdout, stderr) = bench.run(&[&["inspect"], &names[..]].concat());
    assert_eq!((code, stderr.as_str()), (0, ""));
    for file in &files {
        let head = format!("{}\n  {}, {} Hz, ", file.name, file.format, file.rate);
        assert!(stdout.contains(&head), "{head} in\n{stdout}");
    }
    // A third of the samples, one of 20 ms at a time.
    assert!(stdout.contains("\n  Tip     33.33 %  1 (0.020 s)  5.00  0.00"), "{stdout}");
}

#[test]
fn what_is_said_on_the_command_line_stands_above_the_file() {
    let bench = Bench::new("inspect-overrides");
    let [tidy, ..] = files();
    bench.file(tidy.name, &tidy.text);
    let value = bench.json(&["inspect", tidy.name, "--unit", "m", "--rate", "25", "--json"]);
    let found = &value["recordings"][0];
    assert_eq!(found["rate_hz"], 25.0);
    assert!(spans(&found["markers"][0], [[1e4, 1.05e4], [2e3; 2], [-4e3; 2]]), "{found}");
    let (code, _, stderr) = bench.run(&["inspect", tidy.name, "--unit", "furlong"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("`furlong` is no unit of length"), "{stderr}");
    assert_eq!(bench.run(&["inspect"]).0, 2, "a file is due");
}

#[test]
fn a_broken_file_is_said_and_hides_none_of_the_others() {
    let bench = Bench::new("inspect-broken");
    let [tidy, nexus, ..] = files();
    bench.file(nexus.name, &nexus.text);
    bench.file("word.csv", &tidy.text.replacen("10.00000", "1o.0", 1));
    let arguments = ["inspect", "word.csv", "absent.csv", nexus.name];
    let expected = "error: word.csv: line 2, column 2 (Tip x): `1o.0` is no number; correct it, or leave it blank \
                    if it was lost\nerror: absent.csv: cannot be read: ";
    let (code, stdout, stderr) = bench.run(&arguments);
    assert_eq!(code, 3);
    assert!(stderr.starts_with(expected), "{stderr}");
    assert!(stdout.starts_with("nexus.csv\n"), "{stdout}");
    let (code, stdout, stderr) = bench.run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(code, 3);
    assert!(stderr.starts_with(expected), "{stderr}");
    let value: Value = serde_json::from_str(&stdout).expect("JSON on stdout");
    assert_eq!(value["recordings"].as_array().map(Vec::len), Some(1));
}
