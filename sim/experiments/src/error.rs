//! Why an experiment has no releases.

use efam_recordings::{Length, RecordingError};

use crate::scenario::ScenarioError;

/// An experiment that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// Its file.
    #[error(transparent)]
    Document(#[from] ScenarioError),
    /// A recording that cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording that can be read, and has not in it what is due.
    #[error(transparent)]
    Cleaning(#[from] CleaningError),
}

/// Why there is nothing to fit in a recording.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CleaningError {
    /// Too few samples.
    #[error("{file}: {samples} samples; a release needs at least {least}: export the whole recording")]
    TooShort {
        /// The recording.
        file: String,
        /// Samples found.
        samples: usize,
        /// Samples needed.
        least: usize,
    },
    /// No sample of the tip is left.
    #[error(
        "{file}: the tip ({marker}) is seen in {seen} of {samples} samples; \
         a release needs at least {least}: choose another marker as {key}.tip, or leave the recording out"
    )]
    TipLost {
        /// The recording.
        file: String,
        /// The markers.
        marker: String,
        /// Samples in which it is seen.
        seen: usize,
        /// All samples.
        samples: usize,
        /// Samples needed.
        least: usize,
        /// Key of the recording in the experiment file.
        key: String,
    },
    /// No release.
    #[error(
        "{file}: no release in it: {why}; check that {key}.tip is the marker at the tip, or give the \
         instant yourself, such as {key}.instants = [\"0.71 s\"]"
    )]
    NoRelease {
        /// The recording.
        file: String,
        /// What was seen instead.
        why: String,
        /// Key of the recording in the experiment file.
        key: String,
    },
    /// An instant of release that the recording does not have.
    #[error(
        "{file}: {key}.instants: {instant} s is not inside the recording, which lasts from {from:.3} to {to:.3} s"
    )]
    InstantOutside {
        /// The recording.
        file: String,
        /// Key of the recording in the experiment file.
        key: String,
        /// The instant, s.
        instant: f64,
        /// First sample, s.
        from: f64,
        /// Last sample, s.
        to: f64,
    },
    /// A release that there is not.
    #[error("{file}: {key}: there is no release {number}; {found} were found")]
    NoSuchRelease {
        /// The recording.
        file: String,
        /// Key of the number in the experiment file.
        key: String,
        /// The number, from one.
        number: usize,
        /// Releases in the recording.
        found: usize,
    },
    /// A tip that is held beside the straight rod.
    #[error(
        "{file}: release {number}: a straight rod at {:.1} deg ends {:.1} mm from where the tip is held, {:.0} % of its \
         reach: check up, unit, angle and clamp under {key}; without angle its posture follows from the markers",
        angle.to_degrees(), 1e3 * off, 1e2 * off / reach
    )]
    OffPlace {
        /// The recording.
        file: String,
        /// Key of the recording in the experiment file.
        key: String,
        /// The release, from one.
        number: usize,
        /// The angle, rad.
        angle: f64,
        /// Distance of the two, m.
        off: f64,
        /// Reach of the rod, m.
        reach: f64,
    },
    /// A tip that cannot be that of the rod.
    #[error(
        "{file}: release {number}: held straight, the tip stands {:.1} mm from the clamp, and the rod with its \
         end fitting reaches {:.1} mm: {}",
        1e3 * seen, 1e3 * reach, off_reach(*seen, *reach, key)
    )]
    OffReach {
        /// The recording.
        file: String,
        /// Key of the recording in the experiment file.
        key: String,
        /// The release, from one.
        number: usize,
        /// Distance from the clamp, m.
        seen: f64,
        /// The same by the model, m.
        reach: f64,
    },
    /// The data do not determine the direction of gravity.
    #[error("{file}: which way is up cannot be seen in it: {why}; say it, such as {key}.up = \"+z\"")]
    NoVertical {
        /// The recording.
        file: String,
        /// What was seen instead.
        why: String,
        /// Key of the recording in the experiment file.
        key: String,
    },
}

/// What to do about a tip that cannot be the rod's.
fn off_reach(seen: f64, reach: f64, key: &str) -> String {
    match Length::doubt(seen, reach) {
        Some(doubt) => format!("{doubt} Say {key}.unit = \"mm\", or the unit that the numbers are in"),
        None => format!(
            "check rod.length, rod.tip and {key}.clamp, say {key}.offset where the marker stands off that far, or \
             leave {key}.angle out if the rod was not held straight"
        ),
    }
}
