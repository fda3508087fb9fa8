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
    for times in ["0,0,0", "3,1,2", "a,b,c", ",,"] {
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
    // A name too many, so that each of the others is over its neighbour's cells, and times are read as frames.
    for names in ["frame,t_s,x_mm,z_mm", "t_s,note,x_mm,z_mm"] {
        let off = read(&format!("{names}\n0.00,1,4\n0.01,2,5\n0.02,3,6\n")).unwrap_err();
        assert!(off.contains("line 2 has 3 cells, and line 1 names 4 columns"), "{off}");
    }
    // The last name is of a column that is not read.
    assert_eq!(read("t_s,x_mm,z_mm,note\n0.00,1,4\n0.01,2,5\n").unwrap().time.len(), 2);
}

/// Tracker's own names of what it derives: none is a marker, and beside them x and y are the one that there is.
#[test]
fn what_is_derived_is_no_marker() {
    let rows = "mass A\nt,x,y,v_x,v_y,a_x,a_y,p_x,p_y\n0,1,2,0.1,0.2,0.3,0.4,0.5,0.6\n0.04,1,2,0.1,0.2,0.3,0.4,0.5,0.6\n";
    let metres = ReadOptions { unit: Some(Length::Metre), ..ReadOptions::default() };
    let names = |text: &str| -> Vec<String> {
        let recording = read_with(text, &metres).unwrap();
        recording.markers.iter().map(|marker| marker.name.clone()).collect()
    };
    assert_eq!(names(rows), ["mass A"]);
    assert_eq!(names(&rows.replace("v_", "tip_v_")), ["mass A"]);
    // Without a velocity beside it, a marker may be called so.
    assert_eq!(names("t,a_x,a_z,p_x,p_z\n0,1,2,3,4\n0.04,1,2,3,4\n"), ["a", "p"]);
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
        ["1709650797980", "1709650797990", "1709650798000"],
        ["1709650797980000", "1709650797990000", "1709650798000000"],
        ["1709650797980000000", "1709650797990000000", "1709650798000000000"],
    ] {
        let recording = table(times).unwrap();
        assert!((recording.rate_hz - 100.0).abs() < 1e-3, "{times:?}: {} Hz", recording.rate_hz);
    }
    // Milliseconds or frames; days, as of a spreadsheet: 0.01 s is 1.157e-7 of one.
    let days = ["46083.500000000", "46083.500000116", "46083.500000231"];
    for (times, is) in [(["0", "10", "20"], "long"), (days, "short")] {
        let refused = table(times).unwrap_err();
        let why = format!("which is {is} for seconds");
        assert!(
            refused.contains("`timestamp` states no unit of time") && refused.contains(&why),
            "{refused}"
        );
    }
    let rows = (0..900).map(|k| format!("{:.9},0.4,0.{k:03}\n", 46083.5 + f64::from(k) / 8_640_000.0));
    let of_days = read(&format!("t_days,tip_x_m,tip_z_m\n{}", rows.collect::<String>())).unwrap();
    assert!((of_days.rate_hz - 100.0).abs() < 1e-3, "{}", of_days.rate_hz);
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

/// Three samples of a tip at 100 Hz, with what is to be tried in place of the second z.
fn with_second(z: &str) -> Result<Recording, String> {
    read(&format!("t_s,tip_x_m,tip_z_m\n0.00,0.4,0.1\n0.01,0.4,{z}\n0.02,0.4,0.3\n"))
}

/// What programs write where they have no number counts as lost, and the first of it is said. A number that is spoilt is refused.
#[test]
fn words_in_place_of_numbers_are_losses() {
    for word in [
        "-nan(ind)",
        "1.#QNAN",
        "-1.#IND",
        "#NUM!",
        "#DIV/0!",
        "?",
        ".",
        "nil",
        "lost",
        "***",
        "<NA>",
        "undefined",
        "nan+nanj",
        "NAN",
        "inf",
        "-",
        "",
        "#WERT!",
    ] {
        let recording = with_second(word).unwrap_or_else(|error| panic!("{word}: {error}"));
        let z: Vec<_> = recording.markers[0].position.iter().map(|at| at.map(|at| at[2])).collect();
        assert_eq!((z, recording.time.len()), (vec![Some(0.1), None, Some(0.3)], 3), "{word}");
    }
    says(
        &with_second("lost").unwrap(),
        "1 cells have a word in place of a number, the first `lost` in line 3",
    );
    for (number, value) in [("\u{2212}0.2", -0.2), ("2.0D-01", 0.2), ("-2d-1", -0.2)] {
        assert_eq!(with_second(number).unwrap().markers[0].position[1], Some([0.4, 0.0, value]), "{number}");
    }
    assert!(with_second("0.2x").unwrap_err().contains("line 3, column 3 (tip z): `0.2x` is no number"));
    // Without a time, a row of words is a sample all the same.
    let rate = ReadOptions { rate_hz: Some(100.0), ..ReadOptions::default() };
    let silent = read_with("tip_x_m,tip_z_m\n0.4,0.1\nlost,lost\n0.4,0.3\n", &rate).unwrap();
    assert_eq!((silent.time.len(), silent.markers[0].position[1]), (3, None));
}

/// Comments, names that come again, and means at the foot are no samples; nothing else of the file changes.
#[test]
fn rows_without_a_time_are_passed_over() {
    let text = "t_s,tip_x_m,tip_z_m\n0.00,0.4,0.1\n# touched, twice, by hand, here\n0.01,0.4,0.2\n\
                t_s,tip_x_m,tip_z_m\n0.02,0.4,0.3\nMean,0.4,0.2\n";
    let recording = read(text).unwrap();
    assert_eq!((recording.time.len(), recording.rate_hz), (3, 100.0));
    says(
        &recording,
        "3 rows are no samples and were passed over, the first `# touched,twice,by hand,here` in line 3",
    );
    // A clock that begins anew is another recording.
    let anew = read("t_s,tip_x_m,tip_z_m\n0.00,0.4,0.1\n0.01,0.4,0.2\nt_s,tip_x_m,tip_z_m\n0.00,0.4,0.3\n");
    assert!(anew.unwrap_err().contains("line 5: time in s is 0 after 0.01"));
}

/// Rows that come twice are one sample, and a file from its end to its start is turned; any other order is refused.
#[test]
fn rows_that_come_twice_or_backwards_are_put_in_order() {
    let table = |rows: [usize; 5]| {
        let row = |k: usize| format!("0.0{k},0.4,0.{k}\n");
        read(&format!("t_s,tip_x_m,tip_z_m\n{}", rows.map(row).concat()))
    };
    let z = |recording: &Recording| -> Vec<f64> {
        recording.markers[0].position.iter().flatten().map(|at| at[2]).collect()
    };
    let twice = table([1, 1, 2, 3, 3]).unwrap();
    assert_eq!((twice.time.as_slice(), z(&twice)), (&[0.01, 0.02, 0.03][..], vec![0.1, 0.2, 0.3]));
    says(&twice, "2 lines have the time and the places of the one before");
    let turned = table([5, 4, 3, 2, 1]).unwrap();
    assert_eq!((turned.time[0], z(&turned)), (0.01, vec![0.1, 0.2, 0.3, 0.4, 0.5]));
    says(&turned, "the last sample comes first");
    assert!(table([1, 2, 3, 2, 4]).unwrap_err().contains("line 5: time in s is 0.02 after 0.03"));
    // The same time with another place is no repetition, and rows that a rate counts are all samples.
    assert!(read("t_s,tip_x_m,tip_z_m\n0,0.4,0.1\n0,0.4,0.2\n1,0.4,0.3\n").is_err());
    let rate = ReadOptions { rate_hz: Some(100.0), ..ReadOptions::default() };
    let counted = read_with("t_s,tip_x_m,tip_z_m\n0,0.4,0.1\n0,0.4,0.1\n0,0.4,0.1\n", &rate).unwrap();
    assert_eq!(counted.time.len(), 3);
}

/// Settings above the names, names with their unit behind a stroke, and two rows of names.
#[test]
fn names_are_found_below_settings_and_beside_units() {
    let rows = |first: &str| format!("{first}0.00,400,100\n0.01,400,200\n0.02,400,300\n");
    for head in [
        "t / s,tip x / mm,tip z / mm\n",
        "time in s,tip x in mm,tip z in mm\n",
        "Model,IL-1000\nDate,2026/03/02 14:11:32\nSamples,3,3\nX0,0.0,0.0\nt_s,tip_x_mm,tip_z_mm\n",
        "POSITION_T,POSITION_X,POSITION_Z\nT,X,Z\n(sec),(mm),(mm)\n",
        "Time - s,Tip X - mm,Tip Z - mm\n",
        ",tip,tip\n,x_mm,z_mm\nt_s,,\n",
    ] {
        let recording = read(&rows(head)).unwrap_or_else(|error| panic!("{head}: {error}"));
        assert_eq!((recording.rate_hz, recording.markers.len()), (100.0, 1), "{head}");
        assert_eq!(recording.markers[0].position[2], Some([0.4, 0.0, 0.3]), "{head}");
    }
    // Of two columns that may be a time, the one with a unit: the other counts tracks.
    let tracks = read("TID,x [mm],z [mm],t [sec]\n1,400,100,0\n1,400,200,0.01\n1,400,300,0.02\n").unwrap();
    assert_eq!(tracks.rate_hz, 100.0);
    // Beside x and y alone, w and h are a box.
    let picture = ReadOptions { unit: Some(Length::Of(1e-3)), rate_hz: Some(100.0), columns: None };
    let boxed = read_with("frame,x,y,w,h\n0,400,100,20,30\n1,400,200,20,30\n", &picture).unwrap();
    assert_eq!(boxed.markers[0].position[1], Some([0.4, 0.0, 0.2]));
    // Of a table of other things its names are said.
    let laser = read("Model,IL-1000\nNo.,Time[s],OUT1[mm]\n1,0.00,12.1\n2,0.01,12.2\n").unwrap_err();
    assert!(laser.contains("names no marker") && laser.contains("`OUT1[mm]`"), "{laser}");
    let columns = Some(["-", "t_s", "z_mm"].map(str::to_owned).to_vec());
    let named = ReadOptions { columns, ..ReadOptions::default() };
    let laser =
        read_with("Model,IL-1000\nSamples,2\nNo.,Time[s],OUT1[mm]\n1,0.00,12.5\n2,0.01,12.25\n", &named);
    assert_eq!(laser.unwrap().markers[0].position[1], Some([0.0, 0.0, 0.01225]));
}

/// UTF-16 without a mark, and logs of programs that were cut off: zeros at the end, and a last row or number that is not whole.
#[test]
fn texts_that_were_cut_off_are_read_up_to_there() {
    let text = "t_s,tip_x_m,tip_z_m\n0.00,0.401,0.125\n0.01,0.402,0.225\n0.02,0.403,0.325\n";
    let whole = read(text).unwrap();
    let of = |bytes: Vec<u8>| parse(bytes, Path::new("a.csv"), &ReadOptions::default()).unwrap();
    for order in [u16::to_le_bytes, u16::to_be_bytes] {
        let wide: Vec<u8> = text.encode_utf16().flat_map(order).collect();
        assert_eq!(of(wide).markers, whole.markers);
    }
    let zeros = of([text.as_bytes(), &[0; 512]].concat());
    assert_eq!(zeros.markers, whole.markers);
    says(&zeros, &format!("from byte {} on the file has zeros", text.len()));
    // Without the end of its last line the file is whole, if its last number is.
    assert_eq!(of(text.trim_end().into()).markers, whole.markers);
    let row = text.lines().last().unwrap().len() + 1;
    for short in 2..row {
        let cut = of(text.as_bytes()[..text.len() - short].into());
        assert_eq!(cut.time.len(), 2, "{short}");
        says(&cut, "line 4, the last, is cut off");
    }
}

/// 100 Hz, put on lines at 1000 Hz by another program: 100 Hz, and the swing as it was taken.
#[test]
fn samples_on_lines_between_others_are_left_out() {
    let noise = |k: usize| 1e-4 * ((k * k * 7 % 19) as f64 / 18.0 - 0.5);
    let taken = |k: usize| swing(k as f64 * 0.01).map(|at| at + noise(k));
    let mut text = "t_s,tip_x_m,tip_z_m\n".to_owned();
    for k in 0..4000 {
        let (a, b, share) = (taken(k / 10), taken(k / 10 + 1), (k % 10) as f64 / 10.0);
        let [x, z] = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
        let _ = writeln!(text, "{:.3},{x:.7},{z:.7}", k as f64 / 1000.0);
    }
    let recording = read(&text).unwrap();
    assert_eq!((recording.rate_hz, recording.time.len()), (100.0, 400));
    assert_eq!(recording.markers[0].position[7].map(|at| at[2]), Some((1e7 * taken(7)[1]).round() / 1e7));
    says(&recording, "each sample is followed by points on the line to the next, 10 times on the whole");
}

/// A row for each marker, by names, by numbers and frames, and one track after the other: a marker each.
#[test]
fn a_row_for_each_marker_is_read() {
    let rate = ReadOptions { rate_hz: Some(100.0), ..ReadOptions::default() };
    let usual = ReadOptions::default();
    let by_name = "t_s,marker,x_mm,z_mm\n0.00,base,0,1\n0.00,tip,400,10\n0.01,base,0,2\n0.01,tip,399,11\n0.02,tip,398,12\n";
    let by_number = "frame,tag_id,x_mm,z_mm\n7,3,0,1\n7,5,400,10\n8,3,0,2\n8,5,399,11\n9,5,398,12\n";
    let by_track =
        "track,t_s,x_mm,z_mm\n0,0.00,0,1\n0,0.01,0,2\n1,0.00,400,10\n1,0.01,399,11\n1,0.02,398,12\n";
    for (text, options, names) in [
        (by_name, &usual, ["base", "tip"]),
        (by_number, &rate, ["tag_id 3", "tag_id 5"]),
        (by_track, &usual, ["track 0", "track 1"]),
    ] {
        let recording = read_with(text, options).unwrap_or_else(|error| panic!("{text}: {error}"));
        let met: Vec<&str> = recording.markers.iter().map(|marker| marker.name.as_str()).collect();
        assert_eq!((met, recording.rate_hz), (names.to_vec(), 100.0));
        assert_eq!(recording.markers[0].position, [Some([0.0, 0.0, 0.001]), Some([0.0, 0.0, 0.002]), None]);
        assert_eq!(recording.markers[1].position[2], Some([0.398, 0.0, 0.012]));
        says(&recording, "2 trajectories in the same columns, a marker each");
    }
    // A number of the row beside times that ascend is no marker.
    let plain = read("id,t_s,x_mm,z_mm\n0,0.00,0,1\n1,0.01,0,2\n0,0.02,0,3\n").unwrap();
    assert_eq!((plain.markers.len(), plain.time.len()), (1, 3));
}
