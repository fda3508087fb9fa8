//! `efam inspect`: what is in a recording, as a table that can be quoted.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use efam_experiments::kind::FileKind;
use efam_recordings::{Marker, Recording, read};
use efam_report::aligned::{Aligned, Side};
use efam_store::escape::escaped;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Form, OfRecording};
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::{say, stdout};

const HELP: &str = "Examples:
  efam inspect trial.c3d
  efam inspect swing.csv --unit mm --rate 100
  efam inspect 15psi.csv 40psi.csv --json
  efam inspect laser.txt --columns t_s,z_mm

Exit codes: 3 if a recording cannot be read; the others are shown all the same.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Inspect {
    /// Recordings: tables as text or Parquet, Vicon, Motive, Qualisys, TRC, C3D, Tracker, Kinovea, DeepLabCut.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    of: OfRecording,
    #[command(flatten)]
    form: Form,
}

/// Markers in a table; all are in the JSON.
const MOST_ROWS: usize = 100;

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed {
    /// Those that could be read.
    recordings: Vec<Inspected>,
}

/// A recording.
#[derive(Serialize, JsonSchema)]
struct Inspected {
    /// Its path.
    file: String,
    /// Its format.
    format: &'static str,
    /// Samples a second.
    rate_hz: f64,
    /// From the first sample to the last.
    duration_s: f64,
    /// How many.
    samples: usize,
    /// Time of the first sample.
    first_time_s: Option<f64>,
    /// What was tracked.
    markers: Vec<Tracked>,
    /// What was found out about the file, in words.
    findings: Vec<String>,
}

/// A marker or a rigid body.
#[derive(Serialize, JsonSchema)]
struct Tracked {
    /// Its name.
    name: String,
    /// Whether it has an orientation.
    rigid_body: bool,
    /// Samples without a position.
    lost: usize,
    /// The same over all samples.
    lost_share: f64,
    /// The longest gap.
    longest_gap_samples: usize,
    /// The longest gap.
    longest_gap_s: f64,
    /// Lowest and highest value of each coordinate; none if it was never seen.
    lowest_and_highest_m: Option<[[f64; 2]; 3]>,
    /// Standard deviation of the noise of each coordinate, at most; none if it was hardly seen.
    noise_m: Option<[f64; 3]>,
}

/// Shows each file; those that cannot be read are reported after the others.
pub fn run(args: &Inspect, console: &Console) -> Result<ExitCode, Failure> {
    let options = args.of.options();
    let (mut values, mut failures) = (Vec::new(), Vec::new());
    for file in &args.files {
        console.detail(format!("reading {}", file.display()));
        match read(file, &options) {
            Ok(recording) if args.form.json => values.push(of_recording(&recording)),
            Ok(recording) if !console.quiet => table(&mut stdout(), &recording)?,
            Ok(_) => {}
            Err(error) => failures.push(another_kind(file).unwrap_or_else(|| error.to_string())),
        }
    }
    if args.form.json {
        print(&Printed { recordings: values })?;
    }
    let Some(last) = failures.pop() else { return Ok(ExitCode::SUCCESS) };
    failures.iter().for_each(|failure| say(format_args!("error: {failure}")));
    Err(Failure::Data(last))
}

/// What a file is that cannot be read as a recording, and the command that takes it.
fn another_kind(file: &Path) -> Option<String> {
    let found = FileKind::of(file).filter(|found| *found != FileKind::Recording)?;
    Some(found.instead_of(FileKind::Recording, file))
}

fn table(out: &mut impl Write, recording: &Recording) -> io::Result<()> {
    let samples = recording.time.len();
    writeln!(
        out,
        "{}\n  {}, {} Hz, {} s, {samples} samples, {} markers\n",
        escaped(&recording.source.to_string_lossy()),
        recording.format,
        decimals((recording.rate_hz * 1e3).round() / 1e3, None),
        decimals(duration(recording), Some(3)),
        recording.markers.len()
    )?;
    let heads = ["lost", "longest gap", "x mm", "y mm", "z mm", "noise mm"].map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("marker", Side::Words)], &heads[..]].concat()).indented(2);
    for marker in recording.markers.iter().take(MOST_ROWS) {
        let quality = marker.quality();
        let lost = format!("{:.2} %", 100.0 * quality.lost as f64 / samples as f64);
        let gap = match quality.longest_gap {
            0 => "-".to_owned(),
            gap => format!("{gap} ({} s)", decimals(gap as f64 / recording.rate_hz, Some(3))),
        };
        let none = || "-".to_owned();
        let of_axis = |[low, high]: [f64; 2]| decimals(1e3 * (high - low), Some(2));
        let [x, y, z] = quality.extent.map_or([(); 3].map(|()| none()), |extent| extent.map(of_axis));
        let worst = |noise: [f64; 3]| decimals(1e3 * noise.into_iter().fold(0.0, f64::max), Some(4));
        table.row([marker.name.clone(), lost, gap, x, y, z, quality.noise.map_or_else(none, worst)]);
    }
    write!(out, "{table}")?;
    if recording.markers.len() > MOST_ROWS {
        writeln!(out, "  and {} more markers; --json has all", recording.markers.len() - MOST_ROWS)?;
    }
    writeln!(
        out,
        "\n  x, y, z: how far a marker moves along each axis; noise: that of its worst axis, at most\n"
    )?;
    for finding in &recording.findings {
        writeln!(out, "  - {finding}")?;
    }
    writeln!(out)
}

/// A number with so many decimals, or as many as it has; with an exponent where it would be longer than a column.
fn decimals(value: f64, count: Option<usize>) -> String {
    match count {
        _ if value.abs() >= 1e7 => format!("{value:.2e}"),
        Some(count) => format!("{value:.count$}"),
        None => value.to_string(),
    }
}

fn of_recording(recording: &Recording) -> Inspected {
    Inspected {
        file: recording.source.display().to_string(),
        format: recording.format.name(),
        rate_hz: recording.rate_hz,
        duration_s: duration(recording),
        samples: recording.time.len(),
        first_time_s: recording.time.first().copied(),
        markers: recording.markers.iter().map(|marker| of_marker(marker, recording)).collect(),
        findings: recording.findings.clone(),
    }
}

fn of_marker(marker: &Marker, recording: &Recording) -> Tracked {
    let quality = marker.quality();
    Tracked {
        name: marker.name.clone(),
        rigid_body: marker.orientation.is_some(),
        lost: quality.lost,
        lost_share: quality.lost as f64 / recording.time.len() as f64,
        longest_gap_samples: quality.longest_gap,
        longest_gap_s: quality.longest_gap as f64 / recording.rate_hz,
        lowest_and_highest_m: quality.extent,
        noise_m: quality.noise,
    }
}

/// From the first sample to the last, s.
fn duration(recording: &Recording) -> f64 {
    let ends = recording.time.first().zip(recording.time.last());
    ends.map_or(0.0, |(first, last)| last - first)
}
