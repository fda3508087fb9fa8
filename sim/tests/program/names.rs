//! Names that a stranger chose: of recordings, markers, scenarios, sweeps, columns.
//!
//! Goal: no name becomes a tag of a page or of a picture, none leads out of the folder of results, none breaks an
//! export; two names stay two.

use std::fs;
use std::path::{Path, PathBuf};

use efam_store::columns::{Cells, Column, Holds, ParquetFile};

use crate::bench::{Bench, without_scripts};
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};
use crate::export::messages;

/// Each is a file's name where a file system takes it, and a marker's.
const EVIL: [&str; 12] = [
    "../../x",
    "..",
    "-rf",
    ".hidden",
    "<script>alert(1)</script>",
    "\"><img src=x onerror=alert(1)>",
    "]]><!--",
    "CON",
    "ä 日本 \u{202e}gnp",
    "a/b",
    "%2F",
    "'; DROP TABLE runs",
];

/// Files below a folder, with their text.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path))
        } else {
            found.push((path.clone(), fs::read(&path).expect("a file")))
        }
    }
    found
}

/// No tag of ours begins so.
fn no_markup(bench: &Bench, folder: &str) {
    for (path, bytes) in files(&bench.0.join(folder)) {
        let text = String::from_utf8_lossy(&bytes);
        let text = if path.extension().is_some_and(|end| end == "html") {
            without_scripts(&text)
        } else {
            text.into()
        };
        let text = text.to_lowercase();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(name.bytes().all(|c| c.is_ascii_alphanumeric() || b"._-".contains(&c)), "{name}");
        assert!(!name.starts_with(['-', '.']) && !name.to_lowercase().starts_with("con."), "{name}");
        if name.ends_with(".html") || name.ends_with(".svg") {
            for tag in ["<script", "<img", "]]><!--"] {
                assert!(!text.contains(tag), "{tag} in {}", path.display());
            }
        }
    }
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn names_of_recordings_and_markers_stay_words() {
    let bench = Bench::new("names");
    bench.file("truth.toml", &scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    let text = recording(&simulated(&bench.text("truth/trajectory.csv")));
    let before = bench.left();
    for (k, evil) in EVIL.into_iter().chain([&*"x".repeat(5000), "bell \u{7} and NUL"]).enumerate() {
        // The name of the file, where that may be one, and of the marker, in quotes as spreadsheets write it.
        let file = format!("{}.csv", evil.replace('/', "_").chars().take(80).collect::<String>());
        let quoted = |end: &str| format!("\"{}_{end}\"", evil.replace('"', "\"\""));
        let header = ["x_m", "y_m", "z_m"].map(quoted).join(",");
        bench.file(&file, &text.replacen("Tip_x_m,Tip_y_m,Tip_z_m", &header, 1));
        let toml = |name: &str| toml::Value::from(name).to_string();
        let experiment = EXPERIMENT.replace("\"15psi.csv\"", &toml(&file)).replace("\"Tip\"", &toml(evil));
        bench.file("e.toml", &experiment);
        for command in ["analyse", "calibrate"] {
            let out = format!("{command}-{k}");
            let (code, _, stderr) = bench.run(&[command, "e.toml", "-q", "--out", &out]);
            if evil.contains('\u{7}') {
                assert!(code == 3 && stderr.contains("is binary (byte "), "{stderr}");
                continue;
            }
            assert_eq!(code, 0, "{command} of {evil:?}: {stderr}");
            no_markup(&bench, &out);
            for format in ["mat", "mcap"] {
                let (code, _, stderr) = bench.run(&["export", &out, "--to", format, "-q", "--overwrite"]);
                assert!(code == 0, "{format} of {command} of {evil:?}: {stderr}");
            }
        }
        let _ = fs::remove_file(bench.0.join(&file));
    }
    // Nothing but what was requested, here and above.
    let ours = |name: &String| ["analyse-", "calibrate-", "e.toml"].iter().any(|own| name.starts_with(own));
    let left: Vec<_> = bench.left().into_iter().filter(|name| !ours(name)).collect();
    assert_eq!(left, before);
    assert!(!bench.0.join("../../x").exists() && !bench.0.join("../x").exists());
}

#[test]
fn names_of_scenarios_and_sweeps_are_folders_or_refused() {
    let bench = crate::work::bench("names-scenarios");
    let (before, scenario) = (bench.left(), bench.text("s.toml"));
    let sweep = bench.text("sweep.toml");
    for evil in EVIL.into_iter().chain([&*"x".repeat(300), "", "a\0b", "a\nb"]) {
        let name = format!("name = {}\n", toml::Value::from(evil));
        bench.file("named.toml", &format!("{name}{scenario}"));
        bench.file("swept.toml", &format!("{name}{sweep}"));
        for command in [&["simulate", "named.toml", "-q"][..], &["sweep", "swept.toml", "-q"]] {
            let (code, _, stderr) = bench.run(command);
            let is_refused = code == 2
                && stderr.contains("name = ")
                && stderr.contains("because folders are named after it");
            assert!(code == 0 || is_refused, "{command:?} of {evil:?}: {code} {stderr}");
        }
        // A file may be called what a key may not.
        let file = format!("{}.toml", evil.replace(['/', '\0'], "_").chars().take(200).collect::<String>());
        bench.file(&file, &scenario);
        let (code, _, stderr) = bench.run(&["simulate", "-q", "--", &file]);
        assert_eq!(code, 0, "{file:?}: {stderr}");
        fs::remove_file(bench.0.join(&file)).expect("it was there");
    }
    for run in fs::read_dir(bench.0.join("outputs")).expect("runs") {
        let name = run.expect("an entry").file_name().into_string().expect("ASCII");
        let is_dated = name.starts_with("20") && name.as_bytes()[8] == b'T';
        assert!(is_dated && name.bytes().all(|c| c.is_ascii_alphanumeric() || b"._-".contains(&c)), "{name}");
    }
    no_markup(&bench, "outputs");
    let more = ["named.toml", "outputs", "swept.toml"].map(str::to_owned);
    let mut expected: Vec<String> = before.into_iter().chain(more).collect();
    expected.sort();
    assert_eq!(bench.left(), expected);
}

/// Words of a table are parts of a topic: `a` is not above `a/b`.
#[test]
fn topics_of_different_words_are_different() {
    let bench = Bench::new("names-topics");
    fs::create_dir_all(bench.0.join("run")).expect("the target folder can be written");
    bench.file("run/summary.json", "{ \"name\": \"a\", \"kind\": \"calibration\" }");
    bench.file("run/residuals.csv", "release,t_s,x_m\na,0,1\na/b,0,2\na%2Fb,0,3\n\"\",0,4\n../../x,0,5\n");
    bench.json(&["export", "run", "--to", "mcap", "--json"]);
    let mut said: Vec<_> =
        messages(&bench, "run.mcap").into_iter().map(|(topic, _, text)| (topic, text)).collect();
    said.sort();
    let expected = [("%", 4), ("..%2F..%2Fx", 5), ("a", 1), ("a%252Fb", 3), ("a%2Fb", 2)];
    let expected =
        expected.map(|(word, x)| (format!("/residuals/{word}"), format!("{{\"time_s\":0.0,\"x_m\":{x}.0}}")));
    assert_eq!(said, expected);
}

/// Signs with which spreadsheets begin a formula that they run.
const FORMULAS: [&str; 5] = ["=1+1", "+A1", "-2+3", "@SUM(A1)", "\u{ff1d}1"];

/// How many tables of a folder were looked at; none of their cells is run by a spreadsheet.
fn no_formula(folder: &Path) -> usize {
    let tables =
        files(folder).into_iter().filter(|(path, _)| path.extension().is_some_and(|end| end == "csv"));
    let mut count = 0;
    for (path, bytes) in tables {
        count += 1;
        let mut rows = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&bytes[..]);
        for row in rows.records() {
            let row = row.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let run = row.iter().find(|cell| {
                cell.parse::<f64>().is_err() && cell.starts_with(['=', '+', '-', '@', '\t', '\r', '\u{ff1d}'])
            });
            assert_eq!(run, None, "{}: {row:?}", path.display());
        }
    }
    count
}

#[test]
fn no_name_is_a_formula_of_a_spreadsheet() {
    let bench = Bench::new("names-formulas");
    bench.file("truth.toml", &scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    let tip = simulated(&bench.text("truth/trajectory.csv"));
    let text = recording(&tip);
    for (k, name) in FORMULAS.into_iter().enumerate() {
        let file = format!("{name}.csv");
        let header = ["x_m", "y_m", "z_m"].map(|end| format!("{name}_{end}")).join(",");
        bench.file(&file, &text.replacen("Tip_x_m,Tip_y_m,Tip_z_m", &header, 1));
        bench.file("e.toml", &EXPERIMENT.replace("15psi.csv", &file).replace("Tip", name));
        for command in ["analyse", "calibrate"] {
            let out = format!("{command}-{k}");
            let (code, _, stderr) = bench.run(&[command, "e.toml", "-q", "--out", &out]);
            assert_eq!(code, 0, "{command} of {name:?}: {stderr}");
            assert!(no_formula(&bench.0.join(&out)) > 0, "{command} has a table");
        }
        fs::create_dir(bench.0.join(name)).expect("made");
        for file in ["e.toml", &file] {
            fs::rename(bench.0.join(file), bench.0.join(name).join(file)).expect("moved");
        }
    }
    // The line that follows a line break is a row of its own. Text recordings hold no line break, Parquet does.
    let column = |name: &str| Column { name: name.to_owned(), unit: "m", holds: Holds::Numbers };
    let columns = ["t_s", "a\n=1+1_x_m", "a\n=1+1_y_m", "a\n=1+1_z_m"].map(column);
    let rows: Vec<Vec<f64>> = (text.lines().skip(1))
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let cells = |k: usize| Cells::from(rows.iter().map(|row| row[k]).collect::<Vec<f64>>());
    let mut bytes = Vec::new();
    let mut file = ParquetFile::begin(&mut bytes, &columns, &[]).expect("begun");
    file.write((0..4).map(cells).collect()).and_then(|()| file.finish()).expect("written");
    fs::write(bench.0.join("broken.parquet"), bytes).expect("written");
    bench.file(
        "e.toml",
        &EXPERIMENT.replace("15psi.csv", "broken.parquet").replace("\"Tip\"", "\"a\\n=1+1\""),
    );
    for command in ["analyse", "calibrate"] {
        let out = format!("{command}-broken");
        let (code, _, stderr) = bench.run(&[command, "e.toml", "-q", "--out", &out]);
        assert_eq!(code, 0, "{command}: {stderr}");
        assert!(no_formula(&bench.0.join(&out)) > 0, "{command} has a table");
    }
    // A folder's name in the lines of a plan, which is read back.
    bench.file("sweep.toml", "[sweep]\nexperiments = [\"*/e.toml\"]\n");
    bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "plan"]);
    assert_eq!(no_formula(&bench.0.join("plan")), 1);
    let status = bench.json(&["sweep", "status", "--plan", "plan", "--json"]);
    assert_eq!(status["status"]["points"], FORMULAS.len());
}
