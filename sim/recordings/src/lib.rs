//! What a motion-capture system saw: positions of markers over time, in the recording's own frame.
//!
//! ```text
//! file ─▶ read ─▶ which format? ─┬─▶ cells ─▶ a header's Layout ─┐
//!                                ├─▶ c3d                         ├─▶ Draft ─▶ Recording
//!                                └─▶ columnar ───────────────────┘   (units, clock, checks)
//! ```
//!
//! Nothing is guessed silently: what a file leaves open is an error, or is assumed by the convention
//! of its format and said in [`Recording::findings`]; [`ReadOptions`] overrides both.

mod c3d;
mod cells;
mod clock;
mod column;
mod columnar;
mod draft;
mod error;
mod format;
mod kinovea;
mod layout;
mod length;
mod long;
mod lost;
mod motive;
mod names;
pub mod noise;
mod order;
mod qualisys;
mod quality;
mod read;
mod repeats;
mod series;
mod tidy;
mod trc;
mod vicon;

use std::path::PathBuf;

pub use draft::ReadOptions;
pub use error::{RecordingError, RecordingProblem};
pub use format::Format;
pub use length::{Length, TOO_FAR, UnknownUnit};
pub use quality::Quality;
pub use read::{parse, read};
pub use series::{Series, quantities, series};
pub use tidy::table;

/// A recording as it was read: nothing is filtered, filled in or cut, but for samples that only repeat the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The file.
    pub source: PathBuf,
    /// What wrote it.
    pub format: Format,
    /// Samples a second: as the file states them or, where it is silent or its own times contradict
    /// it, as its times show.
    pub rate_hz: f64,
    /// Time of each sample on the recording's own clock, s, ascending; where frame numbers jump,
    /// times jump as well. A file without times begins at 0.
    pub time: Vec<f64>,
    /// What was tracked, in the order of the file.
    pub markers: Vec<Marker>,
    /// What was found and decided in reading, in plain words: units, gaps, jumps, lost points.
    pub findings: Vec<String>,
}

impl Recording {
    /// Whether all places are on one axis of the file, as those of a laser, so that the others were not measured.
    pub fn has_one_coordinate(&self) -> bool {
        let seen = || self.markers.iter().flat_map(|marker| marker.position.iter().flatten());
        (0..3).filter(|axis| seen().any(|at| at[*axis] != 0.0)).count() < 2
    }
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
