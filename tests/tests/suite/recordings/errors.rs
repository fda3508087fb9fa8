//! Goal: a recording that cannot be read says why, where, and what to do.
//! Expected: the whole message, word for word; and for lies about sizes, a refusal before memory is
//! taken.

use std::path::Path;

use efam_recordings::{ReadOptions, parse, read};
use tests::recordings::{C3d, millimetres, motive, nexus, qualisys, tidy, trc};

fn message(bytes: impl Into<Vec<u8>>, name: &str) -> String {
    match parse(bytes.into(), Path::new(name), &ReadOptions::default()) {
        Ok(recording) => panic!("read, with {} markers", recording.markers.len()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn files_that_are_none() {
    assert_eq!(message("", "a.csv"), "a.csv: is empty; export the recording again");
    assert_eq!(message("\n\n,,\n", "a.csv"), "a.csv: is empty; export the recording again");
    let folder =
        read(Path::new(env!("CARGO_MANIFEST_DIR")), &ReadOptions::default()).unwrap_err().to_string();
    assert!(
        folder.ends_with("is no file; name a recording, such as the trajectory.parquet in a run's folder"),
        "{folder}"
    );
    let absent = read(Path::new("absent.csv"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(
        absent.starts_with("absent.csv: cannot be read: ")
            && absent.ends_with("check the path and its permissions")
    );
}

/// Ten gigabytes that take no room on the disk: refused by their length, before a byte is read.
#[test]
fn a_recording_of_10_gb_is_refused() {
    let path = std::env::temp_dir().join(format!("efam-long-{}.csv", std::process::id()));
    let file = std::fs::File::create(&path).unwrap();
    if file.set_len(10_000_000_000).is_err() {
        tests::skipped("sparse", "no file of 10 GB can be made here");
        return;
    }
    let error = read(&path, &ReadOptions::default()).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(
        error.problem.to_string(),
        "has 10.00 GB, and at most 2.15 GB are read; cut it into shorter pieces, or record it anew at a lower rate"
    );
}

#[test]
fn headers_without_samples() {
    let header = |text: String, lines: usize| text.split_inclusive('\n').take(lines).collect::<String>();
    for (text, name, line) in [
        (header(tidy(), 1), "a.csv", 1),
        (header(nexus(), 5), "a.csv", 5),
        (header(nexus(), 3), "a.csv", 3),
        (header(motive(), 7), "a.csv", 7),
        (header(qualisys(), 10), "a.tsv", 10),
        (header(trc(), 5), "a.trc", 5),
    ] {
        let expected =
            format!("{name}: ends after its header (line {line}): no samples; export the recording again");
        assert_eq!(message(text, name), expected);
    }
    assert_eq!(
        message(header(tidy(), 2), "a.csv"),
        "a.csv: has one sample; at least 2 are needed; export a longer piece"
    );
    let lost = "t_s,tip_x_m,tip_z_m\n0,,\n1,,\n";
    assert_eq!(
        message(lost, "a.csv"),
        "a.csv: all 1 markers are lost in all 2 samples; check them in the capture program"
    );
}

#[test]
fn units() {
    assert_eq!(
        message("t_s,tip_x_mm,tip_z_m\n0,0,0\n1,0,0\n", "a.csv"),
        "a.csv: mixes units: tip_x_mm is in mm, tip_z_m in m; export all positions in one unit"
    );
    assert_eq!(
        message(nexus().replace("mm,mm\n", "m,m\n"), "a.csv"),
        "a.csv: mixes units: My Arm:tip is in mm, My Arm:base in m; export all positions in one unit"
    );
    assert_eq!(
        message(nexus().replace(",,mm", ",,deg"), "a.csv"),
        "a.csv: line 5, column 3 (My Arm:tip): `deg` is no unit of length; it must be one of m, cm, mm, um, in, ft, or a length such as `0.42 mm` to a pixel"
    );
    assert_eq!(
        message("t_s,tip_x,tip_z\n0,0,0\n1,0,0\n", "a.csv"),
        "a.csv: column `tip_x` states no unit of length; name it, such as tip_x_mm, or say --unit mm"
    );
}

#[test]
fn clocks() {
    assert_eq!(
        message(tidy().replace("\n0.05,", "\n0.03,"), "a.csv"),
        "a.csv: line 7: time in s is 0.03 after 0.04: it must ascend; sort the samples, or leave out the repeated ones, or say --rate to count them"
    );
    assert_eq!(
        message(nexus().replace("\n697,", "\n696,"), "a.csv"),
        "a.csv: line 8: frame is 696 after 696: it must ascend; sort the samples, or leave out the repeated ones, or say --rate to count them"
    );
    assert_eq!(
        message("tip_x_m,tip_z_m\n0,0\n1,0\n", "a.csv"),
        "a.csv: states neither times nor a sampling rate; add a column t_s, or say --rate with the rate in Hz"
    );
    assert_eq!(
        message(tidy().replace("\n0.05,", "\n,"), "a.csv"),
        "a.csv: line 7, column 1 (time): `` is no number; correct it, or leave it blank if it was lost"
    );
    let options = ReadOptions { rate_hz: Some(-1.0), ..Default::default() };
    let error = parse(nexus().into(), Path::new("a.csv"), &options).unwrap_err().to_string();
    assert_eq!(error, "a.csv: --rate -1: must be a positive number of samples a second");
}

#[test]
fn cells_and_columns() {
    assert_eq!(
        message(tidy().replace("\n0.05,0.095", "\n0.05,0.0q5"), "a.csv"),
        "a.csv: line 7, column 2 (tip x): `0.0q5` is no number; correct it, or leave it blank if it was lost"
    );
    assert_eq!(
        message("t_s,tip_x_m,tip_y_m,base_x_m,base_z_m\n0,0,0,0,0\n1,0,0,0,0\n", "a.csv"),
        "a.csv: marker `tip` has no z (x and z are needed, only y may be missing); add the column"
    );
    assert_eq!(
        message("t_s;tip_x_m;tip_z_m\n0,0;1.5;2\n1,0;1,5;2\n", "a.csv"),
        "a.csv: mixes decimal signs: `1.5` in line 2, `0,0` in line 2; save it with one of them, \
         and without separators of thousands"
    );
    assert_eq!(
        message("t_s,tip_x_m,tip_z_m,tip_x_m\n0,0,0,0\n1,0,0,0\n", "a.csv"),
        "a.csv: columns 2 and 4 both give x of marker `tip`; leave one of them out"
    );
    assert_eq!(
        message("time_s,pressure_psi\n0,15\n1,15\n", "a.csv"),
        "a.csv: names no marker; expected columns such as tip_x_m, tip_y_m, tip_z_m (accelerations, rates and angles \
         are no positions), met `time_s`, `pressure_psi`; or say what they hold, such as --columns t_s,z_mm"
    );
}

#[test]
fn other_formats() {
    let known = "tidy table, Parquet, Vicon Nexus trajectories, older Vicon trajectories, OptiTrack Motive CSV, \
                 Qualisys TSV, TRC, C3D";
    assert_eq!(
        message("\nHIERARCHY\nROOT Hips\n", "a.bvh"),
        format!(
            "a.bvh: is in no known format: line 2 is `HIERARCHY`; known are {known}; a table needs a line of \
             names, such as t_s,tip_x_m,tip_y_m,tip_z_m, or --columns t_s,x_mm,z_mm"
        )
    );
    assert_eq!(
        message(nexus().replace("Trajectories", "Model Outputs"), "a.csv"),
        "a.csv: holds `Model Outputs` and no `Trajectories`, so there are no marker positions in it; \
         export again from Nexus with Trajectories ticked"
    );
    let of_bodies = qualisys().replace("DATA_INCLUDED\t3D\n", "").replace("MARKER_NAMES", "BODY_NAMES");
    for text in [qualisys().replace("DATA_INCLUDED\t3D", "DATA_INCLUDED\t6D"), of_bodies] {
        assert_eq!(
            message(text, "a.tsv"),
            "a.tsv: holds 6D data of Qualisys, which is not read; export 3D data of markers as TSV, or C3D"
        );
    }
}

#[test]
fn binary_garbage_under_each_name() {
    let mut state = 7_u32;
    let garbage: Vec<u8> = (0..5000)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    let is_binary =
        "is binary (byte 2 is 0x04), and neither C3D nor Parquet; export as C3D, or as text in UTF-8";
    let mut text = garbage.clone();
    text[..3].copy_from_slice(&[b'a', b'b', 4]);
    for name in ["a.csv", "a.tsv", "a.trc"] {
        assert_eq!(message(text.as_slice(), name), format!("{name}: {is_binary}"));
    }
    assert!(
        message(text.as_slice(), "a.c3d").starts_with("a.c3d: cannot be read as C3D: byte 2 is 98, not 80")
    );
    assert!(
        message(text.as_slice(), "a.parquet")
            .starts_with("a.parquet: cannot be read as Parquet: it begins with 0x61 0x62 0x04")
    );
    let mut parquet = garbage;
    parquet[..4].copy_from_slice(b"PAR1");
    assert!(message(parquet, "a.parquet").starts_with("a.parquet: cannot be read as Parquet: "));
}

#[test]
fn c3d_that_lies() {
    let whole = C3d::small(84, true).bytes(millimetres);
    let with = |place: usize, word: u16| {
        let mut file = whole.clone();
        file[place..place + 2].copy_from_slice(&word.to_le_bytes());
        message(file, "a.c3d")
    };
    let again = "; export it again from the capture program";
    let start = "a.c3d: cannot be read as C3D: ";
    // 8 frames of 2 points and 3 analog samples, 44 bytes each, and padding up to 512.
    let cut = message(&whole[..whole.len() - 300], "a.c3d");
    assert_eq!(cut, format!("{start}it states 8 frames, and there is room for 4: it is cut short{again}"));
    assert_eq!(
        message(&whole[..300], "a.c3d"),
        format!("{start}it has 300 bytes, less than its header of 512{again}")
    );
    assert_eq!(
        with(2, 65_535),
        format!("{start}it states 8 frames, and there is room for 0: it is cut short{again}"),
        "points"
    );
    assert_eq!(
        with(4, 65_535),
        format!("{start}it states 8 frames, and there is room for 0: it is cut short{again}"),
        "analog"
    );
    assert_eq!(with(2, 0), format!("{start}it has no points, only analog samples or nothing{again}"));
    assert_eq!(
        with(16, 9_999),
        format!("{start}its data should begin in block 9999, and it has 3 blocks{again}")
    );
    assert_eq!(
        with(0, 0x50c8),
        format!("{start}its parameters should be in block 200, beyond its end{again}")
    );
    let mut kind = whole.clone();
    kind[515] = 9;
    assert_eq!(
        message(kind, "a.c3d"),
        format!("{start}its processor is 9; known are 84, 85 and 86 (Intel, DEC, MIPS){again}")
    );
    let at = whole.windows(6).position(|name| name == b"LABELS").expect("a parameter");
    let mut labels = whole.clone();
    labels[at + 10..at + 12].copy_from_slice(&[255, 255]);
    assert_eq!(
        message(labels, "a.c3d"),
        format!("{start}parameter POINT:LABELS reaches beyond its place{again}")
    );
}

#[test]
fn rows_cut_short_cannot_fill_the_memory() {
    // 3333 markers and 100 000 rows of two bytes would take 10 GB.
    let names: Vec<_> = (0..3333).map(|k| format!("m{k}_x_m,m{k}_z_m")).collect();
    let rows: String = (0..100_000).map(|k| format!("{k}\n")).collect();
    let text = format!("t_s,{}\n{rows}", names.join(","));
    let message = message(text, "a.csv");
    assert!(message.starts_with("a.csv: has 3333 markers and "), "{message}");
    assert!(message.ends_with(" bytes: most rows are cut short; export it again"), "{message}");
}

#[test]
fn ten_thousand_columns_are_read() {
    let names: Vec<_> = (0..3333).map(|k| format!("m{k}_x_m,m{k}_y_m,m{k}_z_m")).collect();
    let row: Vec<_> = (0..9999).map(|k| (k as f64 * 0.001).to_string()).collect();
    let row = row.join(",");
    let rows: String = (0..20).map(|k| format!("{k},{row}\n")).collect();
    let text = format!("t_s,{}\n{rows}", names.join(","));
    let recording = parse(text.into(), Path::new("a.csv"), &ReadOptions::default()).expect("it is read");
    assert_eq!(recording.markers.len(), 3333);
    assert_eq!(recording.markers[3332].position[19], Some([9.996, 9.997, 9.998]));
}
