//! Files of every dialect, by a writer of our own with drawn options.
//!
//! Goal: what a program may write is read back to the bit, or refused for a reason that is true.
//! Setup: two or three markers on a swing, in whole eighths of a millimetre or of another unit; drawn are the dialect,
//! separators, decimal signs, order of columns, places of names, units, rate, gaps, zeros or blanks for lost points, and the
//! encoding. `EFAM_DIALECTS` sets how many of each dialect are drawn.
//! Expected: the names, the rate, each position as written (one rounding to metres) and each loss; where a draw makes a
//! file that says less than it needs, the refusal that names what is missing.

mod swing;

use std::fmt::Write;
use std::path::Path;

use efam_recordings::{Length, ReadOptions, parse};
use swing::{Draw, Swing, compare, metres, number};

/// A column's name, and of which marker along which axis; none of a time and of others.
type Column = (String, Option<(usize, usize)>);

/// Files in the usual tests, of each dialect.
const USUAL: usize = 40;

struct Written {
    text: String,
    swing: Swing,
    options: ReadOptions,
    /// Words of the refusal that is due; nothing if the file can be read.
    refused: Option<&'static str>,
}

/// A table: names with units in any order, other columns between, names above axes, no names at all.
fn table(draw: &mut Draw) -> Written {
    let is_flat = draw.is();
    let swing = Swing::draw(draw);
    let swing = if is_flat { swing.flat() } else { swing };
    let separator = draw.of(&[',', ';', '\t', ' ']);
    let sign = if separator == ',' || draw.is() { '.' } else { ',' };
    let lost = if separator == ' ' { "nan" } else { draw.of(&["", "NaN", "nan"]) };
    let joint = draw.of(&["_", ".", ":"]);
    let is_stated = draw.is();
    let is_named = draw.below(4) > 0;
    let is_above = is_named && draw.below(3) == 0 && separator != ' ';
    let has_up = is_flat && draw.is();
    let axes: &[(usize, &str)] = match (is_flat, has_up) {
        (true, true) => &[(0, "x"), (2, "y")],
        (true, false) => &[(0, "x"), (2, "z")],
        _ => &[(0, "x"), (1, "y"), (2, "z")],
    };
    let mut swing = swing;
    let clean = |name: &String| if separator == ' ' { name.replace(' ', "-") } else { name.clone() };
    swing.names = swing.names.iter().map(clean).collect();
    let per_second = draw.of(&[("t_s", 1.0), ("time (s)", 1.0), ("t_ms", 1e3), ("Time", 1.0), ("sec", 1.0)]);
    let per_second = if separator == ' ' { ("t_s", 1.0) } else { per_second };
    // Column 0 is the time; of markers and axes in any order; then one that is no position.
    let mut columns: Vec<(String, Option<(usize, usize)>)> = vec![(per_second.0.to_owned(), None)];
    let symbol = swing.unit.symbol();
    for (k, name) in swing.names.iter().enumerate() {
        for (axis, letter) in axes {
            let own = match (is_stated, is_above) {
                (_, true) => (*letter).to_owned(),
                (true, _) => format!("{name}{joint}{letter}_{symbol}"),
                (false, _) => format!("{name}{joint}{letter}"),
            };
            columns.push((own, Some((k, *axis))));
        }
    }
    if !is_above {
        for at in (2..columns.len()).rev() {
            // The first column of each marker keeps their order.
            let other = 1 + draw.below(at);
            let whose = |of: &Column| of.1.map(|of| of.0);
            if whose(&columns[at]) == whose(&columns[other]) {
                columns.swap(at, other);
            }
        }
    }
    let others = ["acc_x", "gyr_z", "valve_V", "angle_x"];
    let other = (!is_above && draw.is()).then(|| draw.of(&others));
    columns.extend(other.map(|name| (name.to_owned(), None)));
    let mut text = String::new();
    if separator == ';' && draw.is() {
        text += "sep=;\n";
    }
    let join = |cells: Vec<String>| cells.join(&separator.to_string());
    let is_note = is_named && !is_above && separator != ' ' && draw.below(4) == 0;
    if is_above {
        let mut above = vec![String::new(); columns.len()];
        swing.names.iter().enumerate().for_each(|(k, name)| above[1 + k * axes.len()] = name.clone());
        text += &(join(above) + "\n");
    }
    if is_named {
        text += if is_note { "# " } else { "" };
        text += &(join(columns.iter().map(|column| column.0.clone()).collect()) + "\n");
    }
    for k in 0..swing.samples() {
        let cell = |(at, (_, of)): (usize, &Column)| match of {
            Some((marker, axis)) => {
                swing.places[*marker][k].map_or(lost.to_owned(), |at| number(at[*axis], sign))
            }
            None if at == 0 => number((per_second.1 * k as f64 / swing.rate * 1e6).round() / 1e6, sign),
            None => number(0.5 + k as f64, sign),
        };
        text += &(join(columns.iter().enumerate().map(cell).collect()) + draw.of(&["\n", "\r\n"]));
    }
    let is_said = is_stated && !is_above && is_named;
    let mut options = ReadOptions::default();
    let mut refused = None;
    if !is_said {
        if draw.below(4) == 0 {
            refused = Some(if is_named { "states no unit of length" } else { "is in no known format" });
        } else {
            options.unit = Some(swing.unit);
        }
    }
    if !is_named && refused.is_none() {
        options.columns = Some(columns.iter().map(|column| column.0.clone()).collect());
        if other.is_some() && draw.below(5) == 0 {
            options.columns.as_mut().expect("they are said").pop();
            refused = Some("and --columns names");
        }
    }
    if is_named && refused.is_none() && draw.below(10) == 0 {
        // Numbers of the rows, which have no name.
        let is_row = |line: &str| line.starts_with(|c: char| c.is_ascii_digit());
        let number = |(k, line): (usize, &str)| {
            if is_row(line) { format!("{k}{separator}{line}") } else { line.to_owned() }
        };
        text = text.lines().enumerate().map(number).collect::<Vec<_>>().join("\n");
        refused = Some(if is_note { "is in no known format" } else { "columns; give each column a name" });
    }
    Written { text, swing, options, refused }
}

/// TRC, with its names by place, one or two tabs apart, and lines between tabs, doubled tabs, commas or blanks.
fn trc(draw: &mut Draw) -> Written {
    let mut swing = Swing::draw(draw);
    let separator = draw.of(&["\t", "\t", ",", " "]);
    if separator == " " {
        swing.names = swing.names.iter().map(|name| name.replace(' ', "-")).collect();
    }
    let apart = draw.of(&[1, 2, 3, 3]);
    let first = draw.of(&[
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "PathFileType  4\t(X/Y/Z) C:\\a",
        "PathFileType 4 (X/Y/Z) a.trc",
    ]);
    let first = first.replace('\t', separator);
    let double = if separator == "\t" && draw.is() { "\t\t" } else { separator };
    let keys = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"].join(double);
    let (rate, samples, markers) = (swing.rate, swing.samples(), swing.names.len());
    let unit = match swing.unit {
        Length::Metre => draw.of(&["m", "meters", "mete"]).to_owned(),
        other => other.symbol(),
    };
    let values =
        [rate.to_string(), rate.to_string(), samples.to_string(), markers.to_string(), unit].join(separator);
    let mut text = format!("{first}\n{keys}\n{values}\nFrame#{separator}Time");
    for (k, name) in swing.names.iter().enumerate() {
        let times = if k == 0 || separator == " " { 1 } else { apart };
        text += &(separator.repeat(times) + name);
    }
    text += &format!("\n{}", if separator == " " { "" } else { separator });
    for k in 1..=markers {
        text += &["X", "Y", "Z"].map(|axis| format!("{separator}{axis}{k}")).concat();
    }
    text += if draw.is() { "\n\n" } else { "\n" };
    let lost = if separator == " " { "nan" } else { draw.of(&["", "0", "nan"]) };
    for k in 0..samples {
        let _ = write!(text, "{}{separator}{:.6}", k + 1, k as f64 / rate);
        for places in &swing.places {
            for axis in 0..3 {
                text += separator;
                text += &places[k].map_or(lost.to_owned(), |at| number(at[axis], '.'));
            }
        }
        text += "\n";
    }
    Written { text, swing, options: ReadOptions::default(), refused: None }
}

/// Nexus, with its names by place or one after another, blanks or zeros where lost, perhaps in pixels.
fn nexus(draw: &mut Draw) -> Written {
    let swing = Swing::draw(draw);
    let separator = draw.of(&[",", ";", "\t"]);
    let apart = draw.of(&[1, 3, 3]);
    let is_pixel = draw.below(5) == 0;
    let unit = if is_pixel { "px".to_owned() } else { swing.unit.symbol() };
    let is_bad_rate = draw.below(6) == 0;
    let rate = if is_bad_rate { "?".to_owned() } else { swing.rate.to_string() };
    let names = swing.names.join(&separator.repeat(apart));
    let mut text = format!("Trajectories\n{rate}\n{0}{0}{names}\nFrame{0}Sub Frame", separator);
    swing
        .names
        .iter()
        .for_each(|_| text += &["X", "Y", "Z"].map(|axis| format!("{separator}{axis}")).concat());
    text += &format!("\n{separator}");
    swing.names.iter().for_each(|_| text += &format!("{separator}{unit}").repeat(3));
    text += "\n";
    let lost = draw.of(&["", "0"]);
    for k in 0..swing.samples() {
        let _ = write!(text, "{}{separator}0", 17 + k);
        for places in &swing.places {
            for axis in 0..3 {
                text += separator;
                text += &places[k].map_or(lost.to_owned(), |at| number(at[axis], '.'));
            }
        }
        text += "\n";
    }
    let mut options = ReadOptions::default();
    let mut refused = None;
    if is_bad_rate {
        options.rate_hz = draw.is().then_some(swing.rate);
        refused = options.rate_hz.is_none().then_some("expected the sampling rate");
    }
    if is_pixel {
        options.unit = draw.is().then_some(swing.unit);
        refused = if options.unit.is_none() { Some("are in pixels") } else { refused };
    }
    Written { text, swing, options, refused }
}

/// Motive, with and without the labels of its rows.
fn motive(draw: &mut Draw) -> Written {
    let swing = Swing::draw(draw);
    let is_labelled = draw.is();
    let (unit, length) = draw.of(&[
        ("Meters", Length::Metre),
        ("Millimeters", Length::Millimetre),
        ("Centimeters", Length::Centimetre),
    ]);
    let swing = Swing { unit: length, ..swing };
    let mut text = format!(
        "Format Version,1.21,Take Name,a,Export Frame Rate,{:.6},Total Exported Frames,{},Length Units,{unit}\n\n",
        swing.rate,
        swing.samples()
    );
    let has_quality = draw.is();
    let own = if has_quality { 4 } else { 3 };
    for (row, label) in ["Type", "Name", "ID", ""].iter().enumerate() {
        text += if is_labelled { "," } else { ",," };
        text += if is_labelled { label } else { "" };
        text += if is_labelled { "," } else { "" };
        let cell = |(k, name): (usize, &String)| match row {
            0 => vec!["Marker".to_owned(); own],
            1 => vec![name.clone(); own],
            2 => vec![format!("\"{k}\""); own],
            _ => ["Position", "Position", "Position", "Marker Quality"][..own]
                .iter()
                .map(|kind| (*kind).to_owned())
                .collect(),
        };
        text += &swing.names.iter().enumerate().flat_map(cell).collect::<Vec<_>>().join(",");
        text += "\n";
    }
    text += draw.of(&["Frame,Time", "Frame,Time (Seconds)"]);
    swing.names.iter().for_each(|_| text += [",X,Y,Z", ",X,Y,Z,"][usize::from(has_quality)]);
    text += "\n";
    for k in 0..swing.samples() {
        let _ = write!(text, "{k},{:.6}", k as f64 / swing.rate);
        for places in &swing.places {
            (0..3).for_each(|axis| {
                text += &(",".to_owned() + &places[k].map_or(String::new(), |at| number(at[axis], '.')))
            });
            text += if has_quality { ",0.99" } else { "" };
        }
        text += "\n";
    }
    Written { text, swing, options: ReadOptions::default(), refused: None }
}

/// Qualisys, with residuals, and axes in any order where they are named.
fn qualisys(draw: &mut Draw) -> Written {
    let swing = Swing { unit: Length::Millimetre, ..Swing::draw(draw) };
    let order = draw.of(&[[0, 1, 2], [0, 2, 1], [2, 0, 1]]);
    let (is_named, has_residual, lost) = (draw.is(), draw.is(), draw.of(&["nan", "0.000", ""]));
    let (order, has_residual) = if is_named { (order, has_residual) } else { ([0, 1, 2], false) };
    let mut text = format!(
        "NO_OF_FRAMES\t{}\nNO_OF_MARKERS\t{}\nFREQUENCY\t{}\nDATA_INCLUDED\t3D\nMARKER_NAMES\t{}\n",
        swing.samples(),
        swing.names.len(),
        swing.rate,
        swing.names.join("\t")
    );
    if is_named {
        text += "Frame\tTime";
        for name in &swing.names {
            order.iter().for_each(|axis| text += &format!("\t{name} {}", ["X", "Y", "Z"][*axis]));
            text += if has_residual { "\tResidual" } else { "" };
        }
        text += "\n";
    }
    for k in 0..swing.samples() {
        let _ = write!(text, "{}\t{:.5}", 1 + k, k as f64 / swing.rate);
        for places in &swing.places {
            let cell = |axis: &usize| {
                format!("\t{}", places[k].map_or(lost.to_owned(), |at| number(at[*axis], '.')))
            };
            order.iter().for_each(|axis| text += &cell(axis));
            text += if has_residual { "\t0.31" } else { "" };
        }
        text += "\n";
    }
    Written { text, swing, options: ReadOptions::default(), refused: None }
}

/// DeepLabCut: pixels and likelihoods under two lines of names, with y downwards.
fn deeplabcut(draw: &mut Draw) -> Written {
    let swing = Swing { unit: Length::Of(5e-4), ..Swing::draw(draw).flat() };
    let line = |first: &str, cell: &dyn Fn(&String) -> [String; 3]| {
        let cells: Vec<String> = swing.names.iter().flat_map(cell).collect();
        format!("{first},{}\n", cells.join(","))
    };
    let mut text = line("scorer", &|_| ["DLC_resnet50"; 3].map(str::to_owned));
    text += &line("bodyparts", &|name| [name, name, name].map(String::clone));
    text += &line("coords", &|_| ["x", "y", "likelihood"].map(str::to_owned));
    for k in 0..swing.samples() {
        text += &k.to_string();
        for places in &swing.places {
            let _ = match places[k] {
                Some([x, _, z]) => write!(text, ",{x},{},0.98", -z),
                None => write!(text, ",3.5,700.25,0.02"),
            };
        }
        text += "\n";
    }
    let (has_unit, has_rate) = (draw.below(4) > 0, draw.below(4) > 0);
    let options = ReadOptions {
        unit: has_unit.then_some(swing.unit),
        rate_hz: has_rate.then_some(swing.rate),
        columns: None,
    };
    let refused = match (has_unit, has_rate) {
        (false, _) => Some("are in pixels"),
        (true, false) => Some("neither times nor a sampling rate"),
        _ => None,
    };
    Written { text, swing, options, refused }
}

/// Tracker: one body under its name, or several under `#multi:`; y upwards.
fn tracker(draw: &mut Draw) -> Written {
    let mut swing = Swing::draw(draw).flat();
    let is_multi = draw.is();
    let separator = draw.of(&["\t", ",", ";"]);
    if !is_multi {
        swing.names.truncate(1);
        swing.places.truncate(1);
    }
    let mut text = if is_multi { format!("#multi:\n{separator}") } else { format!("{}\nt", swing.names[0]) };
    if is_multi {
        text += &(swing.names.join(&separator.repeat(2)) + "\nt");
    }
    swing.names.iter().for_each(|_| text += &format!("{separator}x{separator}y"));
    text += "\n";
    for k in 0..swing.samples() {
        let _ = write!(text, "{:.9E}", k as f64 / swing.rate);
        for places in &swing.places {
            let _ = match places[k] {
                Some([x, _, z]) => write!(text, "{separator}{x:E}{separator}{z:E}"),
                None => write!(text, "{separator}{separator}"),
            };
        }
        text += "\n";
    }
    let options = ReadOptions { unit: Some(swing.unit), ..ReadOptions::default() };
    Written { text, swing, options, refused: None }
}

/// A text as a program may write it, in UTF-8 or UTF-16, with a mark or without one, or with zeros behind it.
fn encoded(draw: &mut Draw, text: &str) -> Vec<u8> {
    let wide = |order: fn(u16) -> [u8; 2], mark: &str| {
        (mark.to_owned() + text).encode_utf16().flat_map(order).collect::<Vec<u8>>()
    };
    match draw.below(8) {
        0 => format!("\u{feff}{text}").into(),
        1 => wide(u16::to_le_bytes, "\u{feff}"),
        2 => wide(u16::to_be_bytes, "\u{feff}"),
        3 => wide(u16::to_le_bytes, ""),
        4 => [text.as_bytes(), &[0; 700]].concat(),
        _ => text.into(),
    }
}

#[test]
fn every_dialect_is_read_back_or_refused_for_a_true_reason() {
    let count = std::env::var("EFAM_DIALECTS").ok().and_then(|count| count.parse().ok()).unwrap_or(USUAL);
    type Writer = fn(&mut Draw) -> Written;
    let writers: [(&str, Writer); 7] = [
        ("table", table),
        ("TRC", trc),
        ("Nexus", nexus),
        ("Motive", motive),
        ("Qualisys", qualisys),
        ("DeepLabCut", deeplabcut),
        ("Tracker", tracker),
    ];
    let mut wrong = Vec::new();
    for (name, write) in writers {
        let (mut read, mut refused, before) = (0, 0, wrong.len());
        for number in 0..count {
            let mut draw = Draw::new(number as u64);
            let written = write(&mut draw);
            let bytes = encoded(&mut draw, &written.text);
            let found = parse(bytes, Path::new("a.csv"), &written.options);
            let verdict = match (found, written.refused) {
                (Ok(found), None) => {
                    read += 1;
                    compare(&written.swing, &found, metres(written.swing.unit))
                }
                (Err(error), Some(why)) => {
                    refused += 1;
                    let is_true = error.to_string().contains(why);
                    if is_true { Ok(()) } else { Err(format!("{error}, for {why}")) }
                }
                (Err(error), None) => Err(error.to_string()),
                (Ok(_), Some(why)) => Err(format!("read, though {why}")),
            };
            if let Err(verdict) = verdict {
                let head: String = written.text.lines().take(9).collect::<Vec<_>>().join("\n");
                wrong.push(format!("{number} ({name}): {verdict}\n{head}\n"));
            }
        }
        println!("{name}: {count} files, {read} read, {refused} refused, {} wrong", wrong.len() - before);
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong[..wrong.len().min(6)].join("\n"));
}
