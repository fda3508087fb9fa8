//! Goal: one swing, written in every format, is read alike.
//! Expected: the same rate, markers, positions and lost samples; exactly, since all positions are
//! multiples of 1/8 mm and only the conversion to metres rounds.

use std::path::Path;

use efam_recordings::{Format, Length, ReadOptions, Recording, RecordingError, parse};
use tests::recordings::{
    C3d, LOST, SAMPLES, legacy, millimetres, motive, nexus, parquet, qualisys, says, tidy, trc,
};

fn read(bytes: impl Into<Vec<u8>>, name: &str) -> Recording {
    parse(bytes.into(), Path::new(name), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn read_with(bytes: impl Into<Vec<u8>>, options: ReadOptions) -> Result<Recording, RecordingError> {
    parse(bytes.into(), Path::new("recording"), &options)
}

/// Whether a recording is the small swing, under these names.
fn is_the_swing(recording: &Recording, format: Format, names: [&str; 2]) {
    assert_eq!(recording.format, format);
    assert_eq!(recording.rate_hz, 100.0);
    assert_eq!(recording.time.len(), SAMPLES);
    let found: Vec<_> = recording.markers.iter().map(|marker| marker.name.as_str()).collect();
    assert_eq!(found, names);
    for (index, marker) in recording.markers.iter().enumerate() {
        for sample in 0..SAMPLES {
            let expected = millimetres(index, sample);
            let met = marker.position[sample];
            assert_eq!(met.is_some(), expected.is_some(), "{} in sample {sample}", marker.name);
            for (met, expected) in met.into_iter().flatten().zip(expected.into_iter().flatten()) {
                // One rounding in writing metres, one in converting.
                assert!(
                    (met - 1e-3 * expected).abs() <= 4.0 * f64::EPSILON * met.abs(),
                    "{met}, {expected} mm"
                );
            }
        }
    }
    let said = recording.findings.iter().any(|finding| {
        finding.starts_with(&format!("marker `{}`: 2 of 8 samples lost (25.00 %), longest gap 2", names[0]))
    });
    assert!(said, "{:?}", recording.findings);
}

#[test]
fn tidy_as_spreadsheets_save_it() {
    let plain = tidy();
    let reference = read(plain.as_str(), "a.csv");
    is_the_swing(&reference, Format::Tidy, ["tip", "base"]);
    assert_eq!(reference.time[7], 0.07);
    let german = plain.replace(',', ";").replace('.', ",");
    let wide: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(plain.replace(',', "\t").encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    let variants: [(&str, Vec<u8>); 7] = [
        ("BOM", format!("\u{feff}{plain}").into()),
        ("CRLF", plain.replace('\n', "\r\n").into()),
        ("tabs", plain.replace(',', "\t").into()),
        ("decimal commas", german.clone().into()),
        ("all of it", format!("\u{feff}{}", german.replace('\n', "\r\n")).into()),
        ("comments above", format!("# pressure: 15 psi\n\n{plain}").into()),
        ("UTF-16", wide),
    ];
    for (what, bytes) in variants {
        let recording = read(bytes, "a.txt");
        is_the_swing(&recording, Format::Tidy, ["tip", "base"]);
        assert_eq!(recording.markers, reference.markers, "{what}");
    }
    says(&read(german, "a.csv"), "decimal sign: a comma, as in `0,00` in line 2");
}

#[test]
fn tidy_in_other_units() {
    let mut text =
        "time (ms),tip_x_mm,tip_y_mm,tip_z_mm,base x [mm],base y [mm],base z [mm],valve_V\n".to_owned();
    for sample in 0..SAMPLES {
        let cell = |marker, axis: usize| {
            millimetres(marker, sample).map_or("NaN".to_owned(), |at| at[axis].to_string())
        };
        let cells: Vec<_> = (0..6).map(|k| cell(k / 3, k % 3)).collect();
        text += &format!("{},{},5\n", 10 * sample, cells.join(","));
    }
    let recording = read(text.as_str(), "a.csv");
    is_the_swing(&recording, Format::Tidy, ["tip", "base"]);
    says(&recording, "unit: mm, as the line of names states");
    says(&recording, "1 columns hold neither time nor position and were passed over: `valve_V`");
    assert_eq!(recording.time[7], 0.07);
}

#[test]
fn a_plane_has_y_of_zero_and_says_so() {
    let text = "t_s,tip_x_m,tip_z_m\n0,0.1,0\n0.01,0.1,-0.01\n0.02,0.09,-0.02\n";
    let recording = read(text, "a.csv");
    assert_eq!(recording.markers[0].position[1], Some([0.1, 0.0, -0.01]));
    says(&recording, "no y is given for `tip`; it is 0 here");
    says(&recording, "rate: 100 Hz, as the times show");
}

#[test]
fn units_and_rates_can_be_said() {
    let silent = "frame,tip_x,tip_z\n1,1,2\n2,2,2\n5,3,2\n";
    let options = ReadOptions { unit: Some(Length::Inch), rate_hz: Some(50.0), ..Default::default() };
    let recording = read_with(silent, options).unwrap();
    assert_eq!(recording.markers[0].position[1], Some([2.0 * 0.0254, 0.0, 2.0 * 0.0254]));
    assert_eq!(recording.time, [0.0, 0.02, 0.08]);
    says(&recording, "samples are left out in 1 places, 2 in all");

    let over = read_with(
        qualisys(),
        ReadOptions { unit: Some(Length::Metre), rate_hz: Some(200.0), ..Default::default() },
    )
    .unwrap();
    assert_eq!(over.markers[1].position[0], Some([-5.0, 0.0, 12.0]));
    assert_eq!((over.rate_hz, over.time[1]), (200.0, 0.005));
    says(&over, "the file's own times are set aside");
    let trc = read_with(trc(), ReadOptions { unit: Some(Length::Metre), ..Default::default() }).unwrap();
    says(&trc, "unit: m, as requested, though Units in line 3 states mm");
}

#[test]
fn quaternions_of_a_tidy_table() {
    let text = "t_s,b_x_m,b_y_m,b_z_m,b_qw,b_qx,b_qy,b_qz\n0,0,0,0,1,0,0,0\n1,1,0,0,0,2,0,0\n2,2,0,0,,,,\n3,2,0,0,0,0,0.99,0\n";
    let recording = read(text, "a.csv");
    let expected = [Some([1.0, 0.0, 0.0, 0.0]), None, None, Some([0.0, 0.0, 1.0, 0.0])];
    assert_eq!(recording.markers[0].orientation.as_deref(), Some(expected.as_slice()));
    says(&recording, "1 quaternions are no rotations");
}

#[test]
fn nexus_plain_and_resaved() {
    let names = ["My Arm:tip", "My Arm:base"];
    let plain = nexus();
    let recording = read(plain.as_str(), "a.csv");
    is_the_swing(&recording, Format::ViconNexus, names);
    says(&recording, "frame 695 is time 0");
    says(&recording, "unit: mm, as line 5 states");
    is_the_swing(&read(format!("\u{feff}{plain}"), "a.csv"), Format::ViconNexus, names);
    // Re-saved by a spreadsheet: all rows of one length, CRLF; or with semicolons.
    let padded: String = plain
        .lines()
        .map(|line| line.to_owned() + &",".repeat(9 - line.matches(',').count()) + "\r\n")
        .collect();
    is_the_swing(&read(padded.as_str(), "a.csv"), Format::ViconNexus, names);
    is_the_swing(&read(padded.replace(',', ";"), "a.csv"), Format::ViconNexus, names);
    // Names may go on beyond the axes, and other sections may surround them.
    let longer = plain.replace("My Arm:base", "My Arm:base,,,My Arm:angle");
    let around = format!(
        "Model Outputs\n100\n,,a:b\nFrame,Sub Frame,X\n,,deg\n1,0,5\n\n{longer}\nDevices\n1000\n1,0,7\n"
    );
    let recording = read(around, "a.csv");
    is_the_swing(&recording, Format::ViconNexus, names);
    says(&recording, "names without columns X,Y,Z below them were passed over: `My Arm:angle`");
    says(&recording, "sections before the trajectories were passed over: `Model Outputs`");
    says(&recording, "section `Devices` from line 22 on was passed over");
    let shorter = plain.replace(",,,My Arm:base", "");
    says(&read(shorter, "a.csv"), "1 markers have no name");
}

#[test]
fn older_vicon() {
    let recording = read(legacy(), "a.csv");
    is_the_swing(&recording, Format::ViconLegacy, ["tip", "base"]);
    says(&recording, "unit: mm is assumed, for the file states none: Vicon writes millimetres");
}

#[test]
fn motive_with_a_rigid_body_and_a_jump() {
    let recording = read(motive(), "a.csv");
    is_the_swing(&recording, Format::Motive, ["tip", "base"]);
    assert_eq!(recording.time[..4], [0.1, 0.11, 0.12, 0.2]);
    says(
        &recording,
        "samples are left out in 1 places, 7 in all; the longest jump is 7 samples, from frame 12 to 20",
    );
    let turns = recording.markers[0].orientation.as_ref().unwrap();
    assert_eq!(turns[0], Some([0.0, 0.0, 1.0, 0.0]));
    assert_eq!(turns[LOST[0]], None);
    assert_eq!(recording.markers[1].orientation, None);
    let silent = motive().replace(",Length Units,Millimeters", "");
    says(&read(silent, "a.csv"), "unit: m is assumed");
}

#[test]
fn qualisys_with_and_without_a_line_of_columns() {
    let with = qualisys();
    let recording = read(with.as_str(), "a.tsv");
    is_the_swing(&recording, Format::Qualisys, ["tip", "base"]);
    assert_eq!(recording.time[0], 8.25);
    says(&recording, "unit: mm is assumed");
    let without: String =
        with.lines().filter(|line| !line.starts_with("Frame")).map(|line| format!("{line}\r\n")).collect();
    assert_eq!(read(without.as_str(), "a.tsv").markers, recording.markers);
    let zeros = with.replace("nan", "0.000");
    let recording = read(zeros, "a.tsv");
    is_the_swing(&recording, Format::Qualisys, ["tip", "base"]);
    says(&recording, "2 times a marker stood at exactly 0, 0, 0");
    let codes = read(with.replace("nan", "-9999.000"), "a.tsv");
    is_the_swing(&codes, Format::Qualisys, ["tip", "base"]);
    says(&codes, "2 times a marker stood at exactly -9999, -9999, -9999");
    says(
        &read(with.replace("NO_OF_FRAMES\t8", "NO_OF_FRAMES\t900"), "a.tsv"),
        "the header states 900 samples, the file has 8",
    );
}

#[test]
fn trc_with_tabs_and_commas() {
    for text in [trc(), trc().replace('\t', ",")] {
        let recording = read(text, "a.trc");
        is_the_swing(&recording, Format::Trc, ["tip", "base"]);
        says(&recording, "unit: mm, as Units in line 3 states");
    }
}

#[test]
fn c3d_in_all_six_encodings() {
    for processor in [84, 85, 86] {
        for floats in [false, true] {
            let file = C3d::small(processor, floats).bytes(millimetres);
            let recording = read(file, "a.bin");
            is_the_swing(&recording, Format::C3d, ["tip", "base"]);
            says(&recording, "frame 1 is time 0");
            let is_coarse =
                recording.findings.iter().any(|finding| finding.contains("whole multiples of 0.1250"));
            assert_eq!(is_coarse, !floats);
        }
    }
    let silent = C3d { units: String::new(), ..C3d::small(84, true) }.bytes(millimetres);
    says(&read(silent, "a.c3d"), "unit: mm is assumed");
}

/// Word 3 of the header may count channels, its scale may be another than POINT:SCALE, and a unit may be cut off.
#[test]
fn c3d_whose_header_is_wrong() {
    let mut channels = C3d { analog: 10, ..C3d::small(84, true) }.bytes(millimetres);
    channels[4..6].copy_from_slice(&5u16.to_le_bytes());
    channels[18..20].copy_from_slice(&2u16.to_le_bytes());
    let recording = read(channels, "a.c3d");
    is_the_swing(&recording, Format::C3d, ["tip", "base"]);
    says(&recording, "shows 10 analog samples in a frame and points as floats; the header's word 3 is 5");

    let mut scaled = C3d::small(84, true).bytes(millimetres);
    scaled[12..16].copy_from_slice(&0.5f32.to_le_bytes());
    let recording = read(scaled, "a.c3d");
    is_the_swing(&recording, Format::C3d, ["tip", "base"]);
    says(&recording, "the header states a scale of 0.5, POINT:SCALE one of -0.125");

    let cut_off = |units: &str| C3d { units: units.to_owned(), ..C3d::small(84, true) }.bytes(millimetres);
    let recording = read(cut_off("mill"), "a.c3d");
    is_the_swing(&recording, Format::C3d, ["tip", "base"]);
    says(&recording, "unit: mm, as POINT:UNITS, `mill`, cut off, states");
    let why = read_with(cut_off("me"), ReadOptions::default()).unwrap_err().to_string();
    assert!(why.contains("`me` is no unit of length"), "{why}");
    let requested = ReadOptions { unit: Some(Length::Millimetre), ..ReadOptions::default() };
    for units in ["mete", "me"] {
        is_the_swing(&read_with(cut_off(units), requested.clone()).unwrap(), Format::C3d, ["tip", "base"]);
    }
}

#[test]
fn c3d_of_many_points() {
    let labels: Vec<_> = (0..300).map(|k| format!("P{k}")).collect();
    let file =
        C3d { labels, ..C3d::small(86, false) }.bytes(|point, _| Some([0.125 * point as f64, 0.0, 100.0]));
    let recording = read(file, "a.c3d");
    assert_eq!((recording.markers.len(), recording.markers[299].name.as_str()), (300, "P299"));
    assert_eq!(recording.markers[299].position[7], Some([0.125 * 299.0 * 1e-3, 0.0, 0.1]));
}

#[test]
fn c3d_of_more_frames_than_a_word_holds() {
    let long = C3d {
        labels: vec!["tip".to_owned()],
        frames: 70_000,
        analog: 0,
        first_frame: 5,
        ..C3d::small(84, false)
    };
    let recording = read(long.bytes(|_, frame| Some([frame as f64 * 0.125 % 1000.0, 0.0, 0.0])), "a.c3d");
    assert_eq!(recording.time.len(), 70_000);
    assert_eq!(recording.time[69_999], 699.99);
    says(&recording, "frame 5 is time 0");
}

#[test]
fn the_trajectory_of_a_run() {
    let recording = read(parquet(), "trajectory.parquet");
    assert_eq!(recording.format, Format::Parquet);
    assert_eq!((recording.rate_hz, recording.time.len()), (100.0, 6));
    let names: Vec<_> = recording.markers.iter().map(|marker| marker.name.as_str()).collect();
    assert_eq!(names[..2], ["tip", "node_00"]);
    assert_eq!(recording.markers[1].position[0], Some([0.0; 3]));
    let fall = recording.markers[0].position[5].expect("seen")[2];
    // A free end falls a little faster than a stone, which falls 12.3 mm in 50 ms.
    assert!((-0.025..-0.0123).contains(&fall), "{fall}");
    says(&recording, "no y is given for `tip`, `node_00`");
}
