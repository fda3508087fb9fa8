//! What a motion-capture system saw: positions of markers over time, in the recording's own frame.

use std::path::PathBuf;

/// A recording as it was read: nothing is filtered, filled in or cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The file.
    pub source: PathBuf,
    /// Samples a second: as the file states them or, where it is silent, as its times show.
    pub rate_hz: f64,
    /// Time of each sample on the recording's own clock, s, ascending; where frame numbers jump,
    /// times jump as well.
    pub time: Vec<f64>,
    /// What was tracked, in the order of the file.
    pub markers: Vec<Marker>,
    /// What was found and decided in reading, in plain words: units, gaps, jumps, lost points.
    pub findings: Vec<String>,
}

/// One tracked point or rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// As the file names it.
    pub name: String,
    /// Position in the recording's frame, m, shape `[samples]`; nothing where it was lost.
    pub position: Vec<Option<[f64; 3]>>,
    /// Orientation of a rigid body as a unit quaternion `[w, x, y, z]`, shape `[samples]`; nothing
    /// for a point.
    pub orientation: Option<Vec<Option<[f64; 4]>>>,
}

// STUB
/// Stub.
#[derive(Debug, thiserror::Error)]
#[error("stub")]
pub struct RecordingError;
/// Stub.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Stub.
    pub unit: Option<Length>,
    /// Stub.
    pub rate_hz: Option<f64>,
}
/// Stub.
#[derive(Clone, Copy, Debug)]
pub struct Length;
impl std::str::FromStr for Length {
    type Err = RecordingError;
    fn from_str(_: &str) -> Result<Self, RecordingError> {
        Ok(Length)
    }
}
/// Stub.
/// # Errors
/// Stub.
pub fn read(_: &std::path::Path, _: &ReadOptions) -> Result<Recording, RecordingError> {
    Err(RecordingError)
}
