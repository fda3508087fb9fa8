//! Files that were read wrongly once, each with what is right.
//!
//! Goal: what is wrong with a file, or looks wrong, is found, and changes no number silently.
//! Setup: small files, written here, after reports of users.
//! Expected: positions, rates and losses as the head of each test says.

use std::fmt::Write;
use std::path::Path;

use efam_recordings::{Length, ReadOptions, Recording, parse};

fn read_with(text: &str, options: &ReadOptions) -> Result<Recording, String> {
    parse(text.into(), Path::new("a.csv"), options).map_err(|error| error.to_string())
}

fn read(text: &str) -> Result<Recording, String> {
    read_with(text, &ReadOptions::default())
}

fn says(recording: &Recording, what: &str) {
    assert!(
        recording.findings.iter().any(|finding| finding.contains(what)),
        "{what}: {:?}",
        recording.findings
    );
}

fn swing(t: f64) -> [f64; 2] {
    [0.4 - 0.02 * (10.0 * t).cos(), -0.1 * (10.0 * t).cos()]
}

#[test]
fn x_y_and_z_beside_w_are_no_position() {
    let text = "sec,pos_x,pos_y,pos_z,w,x,y,z\n0,0.4,0,0,1,0,0,0\n0.02,0.4,0,0.1,0.6,0.8,0,0\n";
    let metres = ReadOptions { unit: Some(Length::Metre), ..ReadOptions::default() };
    let recording = read_with(text, &metres).unwrap();
    assert_eq!((recording.rate_hz, recording.markers.len()), (50.0, 1));
    assert_eq!(recording.markers[0].orientation.as_ref().unwrap()[1], Some([0.6, 0.8, 0.0, 0.0]));
    let inertial =
        read_with("t_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n0,0,0,9.8,0,0,0\n1,0,0,9.8,0,0,0\n", &metres);
    assert!(inertial.unwrap_err().contains("names no marker"));
}

/// 50 Hz, each sample six times at 300 Hz: 50 Hz, and the swing as it was taken.
#[test]
fn repeated_samples_are_left_out() {
    let mut text = "t_s,tip_x_m,tip_z_m\n".to_owned();
    for k in 0..600 {
        let [x, z] = swing(f64::from(k / 6) * 0.02);
        let _ = writeln!(text, "{:.5},{x:.6},{z:.6}", f64::from(k) / 300.0);
    }
    let recording = read(&text).unwrap();
    assert_eq!((recording.rate_hz.round(), recording.time.len()), (50.0, 100));
    says(&recording, "each sample is repeated, 6 times on the whole");
}

/// A sample in ten is 0, 0, 0 in a format that leaves lost cells blank.
#[test]
fn zeros_between_places_far_away_are_losses() {
    let mut text = "t_s,tip_x_m,tip_y_m,tip_z_m\n".to_owned();
    for k in 0..200 {
        let [x, z] = swing(f64::from(k) * 0.01);
        let [x, z] = if k % 10 == 3 { [0.0; 2] } else { [x, z] };
        let _ = writeln!(text, "{:.2},{x:.5},0,{z:.5}", f64::from(k) * 0.01);
    }
    let recording = read(&text).unwrap();
    assert_eq!(recording.markers[0].quality().lost, 20);
    says(&recording, "20 times a marker stood at exactly 0, 0, 0, far from");
}

/// What the person says overrules times that do not ascend or are none, and units that are none.
#[test]
fn a_rate_and_a_unit_that_are_said_overrule_the_file() {
    let rate = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    for times in ["0,0,0", "3,2,1", "a,b,c", ",,"] {
        let rows = times.split(',').map(|time| format!("{time},1,2\n")).collect::<String>();
        let text = format!("t_s,tip_x_m,tip_z_m\n{rows}");
        assert!(read(&text).is_err(), "{times}");
        assert_eq!(read_with(&text, &rate).unwrap().time, [0.0, 0.02, 0.04], "{times}");
    }
    let mixed = "t_s,tip_x_mm,tip_z_m\n0,1,2\n1,1,2\n";
    let inches = ReadOptions { unit: Some(Length::Inch), ..ReadOptions::default() };
    assert_eq!(read_with(mixed, &inches).unwrap().markers[0].position[0], Some([0.0254, 0.0, 0.0508]));
}

#[test]
fn what_programs_for_video_write_is_read() {
    let scale = ReadOptions { unit: Some(Length::Of(1e-3)), ..ReadOptions::default() };
    let kinovea =
        "#Kinovea Trajectory data export\n#T X Y\n\n0:00:00:00 866.00 320.00 \n0:00:00:04 847.00 321.00 \n";
    let recording = read_with(kinovea, &scale).unwrap();
    assert_eq!((recording.rate_hz, recording.markers[0].position[1]), (25.0, Some([0.847, 0.0, 0.321])));
    let tracker = "mass A\nt\tx\ty\n0.0\t1.5E0\t-2.5E-1\n4.0E-2\t1.25E0\t\n";
    let recording = read_with(tracker, &scale).unwrap();
    assert_eq!(recording.markers[0].name, "mass A");
    assert_eq!(recording.markers[0].position, [Some([1.5e-3, 0.0, -2.5e-4]), None]);
    says(&recording, "y is taken for the height, which counts up");
    let units = "Time\tX\tY\n(s)\t(cm)\t(cm)\n0\t1\t2\n0.04\t2\t2\n";
    assert_eq!(read(units).unwrap().markers[0].position[1], Some([0.02, 0.0, 0.02]));
    let laser = ReadOptions {
        columns: Some(["t_ms", "-", "z_mm"].map(str::to_owned).into()),
        ..ReadOptions::default()
    };
    let recording = read_with("0;7;1,5\n10;8;2,5\n", &laser).unwrap();
    assert_eq!(recording.markers[0].position[1], Some([0.0, 0.0, 0.0025]));
    says(&recording, "one coordinate alone is given, z");
}

#[test]
fn files_of_other_programs_are_named() {
    for (bytes, name, what) in [
        (
            &b"PK\x03\x04........xl/workbook.xml"[..],
            "a.csv",
            "holds a spreadsheet, which is not read; save it as CSV",
        ),
        (b"PK\x03\x04", "a.xlsx", "holds a spreadsheet, which is not read; save it as CSV"),
        (
            b"<?xml version=\"1.0\"?><object/>",
            "a.trk",
            "holds a project of Tracker, which is not read; in Tracker, export",
        ),
        (b"\x89HDF\r\n", "a.h5", "holds HDF5, which is not read; save it as CSV"),
    ] {
        let message = parse(bytes.into(), Path::new(name), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains(what), "{message}");
    }
    let ragged = read("x_m,z_m\n1,0.4,0\n2,0.4,0.1\n").unwrap_err();
    assert!(ragged.contains("line 2 has 3 cells, and line 1 names 2 columns"), "{ragged}");
}

/// A time of day with a date, a zone, AM or PM, and over midnight: steps of 10 ms. One without a unit whose steps are whole
/// numbers is refused, since they may be milliseconds, nanoseconds or frames.
#[test]
fn clocks_of_loggers_are_read_or_refused() {
    let table = |times: [&str; 3]| {
        read(&format!(
            "timestamp,tip_x_m,tip_z_m\n{}",
            times.map(|time| format!("{time},0.4,0.1\n")).concat()
        ))
    };
    for times in [
        ["2024-03-05 14:59:57.98", "2024-03-05 14:59:57.99", "2024-03-05 14:59:58.00"],
        ["2024-03-05T14:59:57.98Z", "2024-03-05T14:59:57.99Z", "2024-03-05T14:59:58.00Z"],
        ["2024-03-05T14:59:57.98+01:00", "2024-03-05T14:59:57.99+01:00", "2024-03-05T14:59:58.00+01:00"],
        ["11:59:59.99 AM", "12:00:00.00 PM", "12:00:00.01 PM"],
        ["03/05/2024 11:59:59.98 PM", "03/05/2024 11:59:59.99 PM", "03/06/2024 12:00:00.00 AM"],
        ["23:59:59.98", "23:59:59.99", "00:00:00.00"],
        ["1709650797.98", "1709650797.99", "1709650798.00"],
    ] {
        let recording = table(times).unwrap();
        assert!((recording.rate_hz - 100.0).abs() < 1e-3, "{times:?}: {} Hz", recording.rate_hz);
    }
    for times in [["0", "10", "20"], ["1709650797980000000", "1709650797990000000", "1709650798000000000"]] {
        let refused = table(times).unwrap_err();
        assert!(refused.contains("`timestamp` states no unit of time"), "{refused}");
    }
    let rate = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    let told = read_with("time,tip_x_m,tip_z_m\n0,1,2\n10,1,2\n", &rate).unwrap();
    assert_eq!(told.time, [0.0, 0.02]);
}

/// Names with the axis first, at the end without a joint, or with a number; names of runs before a colon; other languages; names
/// over the time of each body, as in tables that were pasted side by side.
#[test]
fn names_of_other_programs_are_read() {
    let metres = ReadOptions { unit: Some(Length::Metre), ..ReadOptions::default() };
    for (names, marker) in [
        ("t_s,x_tip_m,z_tip_m", "tip"),
        ("t_s,tipX,tipZ", "tip"),
        ("t_s,x1,z1", "1"),
        ("Zeit [s],tip x [m],tip z [m]", "tip"),
        ("Latest: Time (s),Latest: X (m),Latest: Y (m)", "Latest"),
        ("Data Set 1:Time(s),Data Set 1:X(m),Data Set 1:Y(m)", "Data Set 1"),
    ] {
        let recording = read_with(&format!("{names}\n0,0.4,0.1\n0.02,0.4,0.2\n"), &metres)
            .unwrap_or_else(|error| panic!("{names}: {error}"));
        assert_eq!(recording.markers[0].name.trim_end_matches(':'), marker, "{names}");
        assert_eq!((recording.rate_hz, recording.markers[0].position[1]), (50.0, Some([0.4, 0.0, 0.2])));
    }
    // One axis alone of such a name is another quantity.
    let offset = read("t_s,tip_x_m,tip_z_m,z_offset_m\n0,0.4,0.1,9\n1,0.4,0.2,9\n").unwrap();
    assert_eq!(offset.markers.len(), 1);
    let pasted = "mass_A;;;;mass_B;;\nt;x;y;;t;x;y\n0;0,4;0,1;;0;0,2;0\n0,02;0,4;0,2;;0,02;0,2;0\n";
    let recording = read_with(pasted, &metres).unwrap();
    let names: Vec<&str> = recording.markers.iter().map(|marker| marker.name.as_str()).collect();
    assert_eq!((names, recording.rate_hz), (vec!["mass_A", "mass_B"], 50.0));
}
