//! What can be wrong with a recording.

use std::io;
use std::path::PathBuf;

use super::length::{Length, UnknownUnit};

/// Why a recording was not read: the file, and what is wrong with it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct RecordingError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong.
    pub problem: RecordingProblem,
}

/// What is wrong with a recording. Lines, frames and columns count as the file's own programs count
/// them: lines and columns from 1.
#[derive(Debug, thiserror::Error)]
pub enum RecordingProblem {
    /// The file system refused.
    #[error("cannot be read: {0}; check the path and its permissions")]
    Unreadable(io::Error),
    /// A folder or a device.
    #[error("is no file; name a recording, such as the trajectory.parquet in a run's folder")]
    NotAFile,
    /// More than this program takes into memory.
    #[error("has {}, and at most {} are read; cut it into shorter pieces, or record it anew at a lower rate",
        gigabytes(*bytes), gigabytes(*most))]
    TooLarge {
        /// Its length.
        bytes: u64,
        /// The limit.
        most: u64,
    },
    /// More than this machine has memory for.
    #[error("has {}, which takes some {} of memory, and {} are free; cut it into shorter pieces, \
             or record it anew at a lower rate", gigabytes(*bytes), gigabytes(*needed), gigabytes(*free))]
    NoMemory {
        /// Its length.
        bytes: u64,
        /// Memory that reading takes.
        needed: u64,
        /// Memory that is there.
        free: u64,
    },
    /// Nothing in it.
    #[error("is empty; export the recording again")]
    Empty,
    /// Binary, and none of the binary formats.
    #[error(
        "is binary (byte {offset} is {byte:#04x}), and neither C3D nor Parquet; \
         export as C3D, or as text in UTF-8"
    )]
    NotText {
        /// Place of the first byte that no text has, from 0.
        offset: usize,
        /// That byte.
        byte: u8,
    },
    /// Text that begins as none of the formats does.
    #[error(
        "is in no known format: line {line} is `{text}`; known are {known}; \
         a table needs a line of names, such as t_s,tip_x_m,tip_y_m,tip_z_m, or --columns t_s,x_mm,z_mm"
    )]
    UnknownFormat {
        /// First line that is not blank.
        line: u64,
        /// The text there, cut short.
        text: String,
        /// Names of the formats.
        known: String,
    },
    /// A Nexus export of other things than trajectories.
    #[error(
        "holds {sections} and no `Trajectories`, so there are no marker positions in it; \
         export again from Nexus with Trajectories ticked"
    )]
    NoTrajectories {
        /// Titles of its sections.
        sections: String,
    },
    /// A kind of data of a known format that is not read.
    #[error("holds {what}, which is not read; {remedy}")]
    NotRead {
        /// The kind of data.
        what: String,
        /// What to export instead.
        remedy: &'static str,
    },
    /// The header is not as its format has it.
    #[error("line {line}: expected {expected}, met {met}; export it again, or repair that line")]
    Header {
        /// Where.
        line: u64,
        /// The text expected there.
        expected: String,
        /// The text found there.
        met: String,
    },
    /// A header, and nothing after it.
    #[error("ends after its header (line {line}): no samples; export the recording again")]
    HeaderOnly {
        /// Last line of the header.
        line: u64,
    },
    /// Too little to be a recording.
    #[error("has one sample; at least 2 are needed; export a longer piece")]
    OneSample,
    /// No column names a position.
    #[error(
        "names no marker; expected columns such as tip_x_m, tip_y_m, tip_z_m (accelerations, rates and angles are no \
         positions), met {met}; or say what they hold, such as --columns t_s,z_mm"
    )]
    NoMarkers {
        /// Columns found.
        met: String,
    },
    /// A marker without all of its coordinates.
    #[error("marker `{marker}` has no {axis} (x and z are needed, only y may be missing); {remedy}")]
    MissingAxis {
        /// The marker.
        marker: String,
        /// `x` or `z`.
        axis: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Two columns for one thing.
    #[error("columns {first} and {second} both give {what}; leave one of them out")]
    Twice {
        /// Number of the first column.
        first: usize,
        /// Number of the second column.
        second: usize,
        /// What both give.
        what: String,
    },
    /// Every sample of every marker is lost.
    #[error("all {markers} markers are lost in all {samples} samples; check them in the capture program")]
    AllLost {
        /// Markers.
        markers: usize,
        /// Samples.
        samples: usize,
    },
    /// Positions in different units.
    #[error("mixes units: {first} is in {}, {other} in {}; export all positions in one unit",
        units[0].symbol(), units[1].symbol())]
    MixedUnits {
        /// A column.
        first: String,
        /// A column in another unit.
        other: String,
        /// Their units.
        units: [Length; 2],
    },
    /// A unit that is none of length.
    #[error(transparent)]
    UnknownUnit(#[from] UnknownUnit),
    /// Positions in a picture.
    #[error("positions are in pixels ({place}); say how long one is, such as --unit '0.42 mm'")]
    Pixels {
        /// What states it.
        place: String,
    },
    /// No unit, in a format that has no fixed one.
    #[error("{place} states no unit of length; name it, such as tip_x_mm, or say --unit mm")]
    NoUnit {
        /// What is silent.
        place: String,
    },
    /// A time without a unit whose steps are long for seconds.
    #[error(
        "column `{column}` states no unit of time, and its steps are {step}, which is {is} for seconds; name it, such as t_s, \
         t_ms, t_us, t_ns or t_days (as spreadsheets count), or say --rate"
    )]
    TimeUnit {
        /// Name of the column.
        column: String,
        /// Mean step, in the column's own unit.
        step: String,
        /// `long` or `short`.
        is: &'static str,
    },
    /// No clock at all.
    #[error("states neither times nor a sampling rate; add a column t_s, or say --rate with the rate in Hz")]
    NoRate,
    /// A rate that is none.
    #[error("--rate {value}: must be a positive number of samples a second")]
    Rate {
        /// What was requested.
        value: f64,
    },
    /// A cell that should be a number.
    #[error(
        "line {line}, column {column} ({name}): `{value}` is no number; correct it, or leave it blank if it was lost"
    )]
    NotANumber {
        /// Its line.
        line: u64,
        /// Its column.
        column: usize,
        /// What the column holds.
        name: String,
        /// The text found there.
        value: String,
    },
    /// A row that is not as long as the header.
    #[error(
        "line {line} has {cells} cells, and line {header} names {names} columns; give each column a name and each \
         name a cell, and put semicolons or tabs between cells where commas are decimal signs"
    )]
    Cells {
        /// Its line.
        line: u64,
        /// Its cells.
        cells: usize,
        /// Line of the names.
        header: u64,
        /// Columns that it names.
        names: usize,
    },
    /// Columns that the person names, and no such number of them.
    #[error(
        "line {line} has {cells} cells, and --columns names {names}; name each, with `-` for one to pass over"
    )]
    Columns {
        /// Its line.
        line: u64,
        /// Its cells.
        cells: usize,
        /// Columns that are named.
        names: usize,
    },
    /// Decimal points and decimal commas.
    #[error(
        "mixes decimal signs: `{point}` in line {point_line}, `{comma}` in line {comma_line}; \
         save it with one of them, and without separators of thousands"
    )]
    MixedDecimals {
        /// A number with a point.
        point: String,
        /// Its line.
        point_line: u64,
        /// A number with a comma.
        comma: String,
        /// Its line.
        comma_line: u64,
    },
    /// Times so far from zero that numbers do not resolve neighbours.
    #[error(
        "has times of up to {time} s, where a number does not resolve a step of {step} s; let its clock begin near \
         the recording"
    )]
    Unresolved {
        /// The largest time, s.
        time: String,
        /// A step, s.
        step: String,
    },
    /// Time does not go on.
    #[error(
        "{place}: {what} is {} after {}: it must ascend; sort the samples, or leave out the repeated ones, \
         or say --rate to count them",
        number(*after), number(*before)
    )]
    Order {
        /// Line, row or sample.
        place: String,
        /// `time` or `frame`, with its unit.
        what: &'static str,
        /// Value of the sample before.
        before: f64,
        /// Value found.
        after: f64,
    },
    /// Rows so short that a small file would fill the memory.
    #[error(
        "has {markers} markers and {samples} samples in only {bytes} bytes: most rows are cut short; \
         export it again"
    )]
    ShortRows {
        /// Markers that the header names.
        markers: usize,
        /// Samples up to here.
        samples: usize,
        /// Length of the file.
        bytes: usize,
    },
    /// A column of Parquet that holds no numbers.
    #[error("column {column} is of type {kind}; it must hold numbers; convert it before saving")]
    ColumnType {
        /// Its name.
        column: String,
        /// Its type.
        kind: String,
    },
    /// Parquet that does not hold together.
    #[error("cannot be read as Parquet: {0}; write it again, uncompressed or with Snappy")]
    Parquet(String),
    /// C3D that does not hold together.
    #[error("cannot be read as C3D: {0}; export it again from the capture program")]
    C3d(String),
}

/// All digits of a number, with an exponent where most of them would be zeros.
fn number(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && !(1e-9..1e15).contains(&size) => format!("{value:e}"),
        _ => value.to_string(),
    }
}

fn gigabytes(bytes: u64) -> String {
    format!("{:.2} GB", bytes as f64 / 1e9)
}
