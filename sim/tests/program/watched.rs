//! `efam watch`: recordings that are saved while it looks.
//!
//! Goal: each recording has its line as soon as it is whole, a broken one has its message, and the page holds all good
//! ones. Setup: a folder with an experiment file, into which recordings are written one by one; the last ends it.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::bench::Bench;

const EXPERIMENT: &str = "name = \"lab\"\n[[recording]]\nfile = \"first.csv\"\ntip = \"Tip\"\nup = \"+z\"\n\
    along = \"+x\"\nunit = \"mm\"\nangle = \"0 deg\"\noffset = \"none\"\n";

/// A hold and a swing of 220 mm at a frequency, in millimetres.
fn recording(hertz: f64) -> String {
    let mut text = String::from("t_s,Tip_x_m,Tip_y_m,Tip_z_m\n");
    for k in 0..900 {
        let t = 0.01 * f64::from(k);
        let after = (t - 1.0).max(0.0);
        let swing = 0.9 * (1.0 - (std::f64::consts::TAU * hertz * after).cos() * (-0.6 * after).exp());
        text += &format!("{t:.2},{:.4},0,{:.4}\n", 220.0 * swing.cos(), -220.0 * swing.sin());
    }
    text
}

#[test]
fn each_recording_has_its_line_and_all_are_on_one_page() {
    let bench = Bench::new("watched");
    fs::create_dir_all(bench.0.join("lab")).expect("the target folder can be written");
    bench.file("lab/experiment.toml", EXPERIMENT);
    bench.file("lab/notes.md", "no recording");
    let mut child = bench
        .command(&["watch", "lab", "--every", "50 ms", "--out", "page"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("efam runs");
    let (to, lines) = mpsc::channel();
    let stdout = BufReader::new(child.stdout.take().expect("a pipe"));
    let reader =
        thread::spawn(move || stdout.lines().map_while(Result::ok).try_for_each(|line| to.send(line)));
    let next = || lines.recv_timeout(Duration::from_secs(60)).expect("a line in time");
    bench.file("lab/first.csv", &recording(1.4));
    let line = next();
    assert!(
        line.starts_with("first.csv: release 1: 1.4") && line.contains(" Hz, damping ratio 0."),
        "{line}"
    );
    bench.file("lab/broken.csv", "t_s,Tip_x_m\n0,1\n");
    let line = next();
    assert!(line.starts_with("broken.csv: not analysed: "), "{line}");
    // With the facts of the recording that the experiment names.
    bench.file("lab/second.csv", &recording(1.1));
    let line = next();
    assert!(line.starts_with("second.csv: release 1: 1."), "{line}");
    // Saved again, analysed again; then both are on the page before the next line is printed.
    bench.file("lab/broken.csv", &recording(0.9));
    let line = next();
    assert!(line.starts_with("broken.csv: release 1: 0."), "{line}");
    bench.file("lab/last.csv", "t_s,Tip_x_m\n0,1\n");
    next();
    let page = bench.text("page/report.html");
    assert!(page.contains("first") && page.contains("second") && !page.contains("notes"));
    interrupt(child.id());
    assert!(child.wait().expect("it ends").success());
    drop(reader.join());
    assert!(bench.text("page/report.html").contains("broken"));
    assert_eq!(bench.left(), ["lab", "page"]);
}

/// Without an experiment file, the options of reading say what tables without names hold, and in which unit.
#[test]
fn recordings_are_read_as_the_options_say() {
    let bench = Bench::new("watched-read");
    fs::create_dir_all(bench.0.join("lab")).expect("made");
    // Time in ms, then z and x in pixels of 0.5 mm.
    let rows = recording(1.4);
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        format!("{},{},{}\n", 1e3 * cells[0], 2.0 * cells[3], 2.0 * cells[1])
    };
    bench.file("lab/bare.csv", &rows.lines().skip(1).map(row).collect::<String>());
    let columns = ["--columns", "t_ms,z,x"];
    let mut child = bench
        .command(
            &[&["watch", "lab", "--every", "50 ms", "--out", "page", "--unit", "0.5 mm"], &columns[..]]
                .concat(),
        )
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("efam runs");
    let mut line = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
    interrupt(child.id());
    assert!(child.wait().expect("it ends").success());
    assert!(line.starts_with("bare.csv: release 1: 1.4"), "{line}");
    // An experiment file states it itself.
    bench.file("lab/experiment.toml", EXPERIMENT);
    let (code, _, stderr) = bench.run(&["watch", "lab", "--rate", "200", "--out", "page"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("experiment.toml: states how recordings are read"), "{stderr}");
}

/// Ctrl-C for a process.
fn interrupt(process: u32) {
    let done = Command::new("kill").args(["-INT", &process.to_string()]).status().expect("kill runs");
    assert!(done.success());
}

#[test]
fn a_folder_that_is_none_and_an_experiment_that_is_wrong_are_said_first() {
    let bench = Bench::new("watched-wrong");
    let (code, _, stderr) = bench.run(&["watch", "none"]);
    assert_eq!(code, 2);
    assert_eq!(stderr, "error: none: is no folder; give the one in which recordings are saved\n");
    fs::create_dir_all(bench.0.join("lab")).expect("the target folder can be written");
    bench.file("lab/experiment.toml", "[[recordin]]\n");
    let (code, _, stderr) = bench.run(&["watch", "lab"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("did you mean `recording`?"), "{stderr}");
    let (code, _, stderr) = bench.run(&["watch", "lab", "--every", "0 s"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("10 ms..=1 h"), "{stderr}");
}
