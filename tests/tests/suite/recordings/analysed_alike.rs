//! Goal: one swing, written in every format, is analysed alike.
//! Setup: a release of four seconds behind a hold, with lost samples of the tip, all positions multiples of 1/8 mm, as a table, in
//! Parquet, as C3D of integers and of floats, as TRC and as columns in memory, which Python's arrays, tables and masks become.
//! Expected: the same cuts, statistics and numbers of the swing, to the bit: positions differ by no rounding.

use std::fmt::Write;
use std::path::Path;

use efam_experiments::analyse::analyse;
use efam_experiments::cleaning::clean_all;
use efam_experiments::experiment::Experiment;
use efam_recordings::{ReadOptions, Recording, parse, table};
use efam_store::columns::{Cells, Column, Holds, ParquetFile};
use tests::recordings::C3d;

const FRAMES: usize = 480;

/// Place of the tip or the base, mm.
fn place(marker: usize, frame: usize) -> Option<[f64; 3]> {
    let t = 0.01 * frame as f64 - 0.8;
    let u = if t < 0.0 { 1.0 } else { (-0.4 * t).exp() * (9.0 * t).cos() };
    let eighth = |x: f64| (8.0 * x).round() / 8.0;
    match marker {
        0 if (140..144).contains(&frame) => None,
        0 => Some([eighth(190.0 - 4.0 * u * u), 0.125, eighth(-60.0 + 60.0 * u)]),
        // Not at the origin, where TRC has points that are lost.
        _ => Some([0.0, 0.125 * (1 + frame % 2) as f64, 0.0]),
    }
}

fn frames() -> impl Iterator<Item = (f64, Vec<Option<f64>>)> {
    (0..FRAMES).map(|frame| {
        let cells = (0..2).flat_map(|marker| match place(marker, frame) {
            Some(at) => at.map(Some),
            None => [None; 3],
        });
        (frame as f64 / 100.0, cells.collect())
    })
}

const NAMES: [&str; 7] = ["t_s", "tip_x_mm", "tip_y_mm", "tip_z_mm", "base_x_mm", "base_y_mm", "base_z_mm"];

fn text(head: &str, mark: &str, counts: bool) -> Vec<u8> {
    let mut text = head.to_owned();
    for (frame, (t, cells)) in frames().enumerate() {
        let cells = cells.iter().map(|cell| cell.map_or(String::new(), |x| x.to_string()));
        let number = if counts { format!("{}{mark}", frame + 1) } else { String::new() };
        let _ = writeln!(text, "{number}{t}{mark}{}", cells.collect::<Vec<_>>().join(mark));
    }
    text.into_bytes()
}

/// The columns, lost places as no numbers.
fn columns() -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = frames()
        .map(|(t, cells)| [t].into_iter().chain(cells.into_iter().map(|x| x.unwrap_or(f64::NAN))).collect())
        .collect();
    (0..NAMES.len()).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

fn parquet() -> Vec<u8> {
    let head = NAMES.map(|name| Column { name: name.to_owned(), unit: "", holds: Holds::NumbersOrNone });
    let mut bytes = Vec::new();
    let mut file = ParquetFile::begin(&mut bytes, &head, &[]).expect("memory takes it");
    file.write(columns().into_iter().map(Cells::Numbers).collect()).expect("memory takes it");
    file.finish().expect("memory takes it");
    bytes
}

/// All that is said of a recording and of its release.
fn said(recording: Recording) -> String {
    let text = "name = \"e\"\n[rod]\nlength = \"190 mm\"\nmass = \"30 g\"\nbending_stiffness = \"0.01 N m^2\"\n\
                [[recording]]\nfile = \"a\"\ntip = \"tip\"\nbase = \"base\"\nup = \"+z\"\n";
    let experiment = Experiment::parse(Path::new("e.toml"), text, &[]).unwrap();
    let cleaned = clean_all(&experiment, vec![recording]).unwrap();
    let analysed = analyse(&experiment, &cleaned, &[8]).unwrap();
    assert_eq!(analysed.len(), 1);
    let of = &cleaned.releases[0];
    let own = analysed[0].said();
    assert!(own.damped_frequency_hz.is_some_and(|f| (f / (9.0 / std::f64::consts::TAU) - 1.0).abs() < 5e-3));
    assert!(own.damping_ratio.is_some_and(|ratio| (ratio / (0.4 / 9.0) - 1.0).abs() < 0.05), "{own:?}");
    format!("{:?} ± {:?}\n{:?}\n{:?}", of.instant, of.release.release_uncertainty, of.statistics, own)
}

#[test]
fn a_recording_is_analysed_alike_in_every_format() {
    let read = |bytes: Vec<u8>, name: &str| {
        said(
            parse(bytes, Path::new(name), &ReadOptions::default())
                .unwrap_or_else(|why| panic!("{name}: {why}")),
        )
    };
    let expected = read(text(&format!("{}\n", NAMES.join(",")), ",", false), "a.csv");
    let trc = format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t\
         OrigDataStartFrame\tOrigNumFrames\n100\t100\t{FRAMES}\t2\tmm\t100\t1\t{FRAMES}\n\
         Frame#\tTime\ttip\t\t\tbase\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    );
    let c3d = |floats| C3d { frames: FRAMES, ..C3d::small(84, floats) }.bytes(place);
    let names = NAMES.map(str::to_owned);
    let made = table(
        &names,
        &columns().into_iter().map(Ok).collect::<Vec<_>>(),
        Path::new("a"),
        &ReadOptions::default(),
    );
    for (what, found) in [
        ("semicolons", read(text(&format!("{}\n", NAMES.join(";")), ";", false), "a.csv")),
        ("TRC", read(text(&trc, "\t", true), "a.trc")),
        ("Parquet", read(parquet(), "a.parquet")),
        ("C3D of integers", read(c3d(false), "a.c3d")),
        ("C3D of floats", read(c3d(true), "a.c3d")),
        ("columns in memory", said(made.unwrap())),
    ] {
        assert_eq!(found, expected, "{what}");
    }
}
