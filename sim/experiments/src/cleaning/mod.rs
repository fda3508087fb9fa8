//! From recordings to releases: what is kept of a motion-capture recording, turned into the frame at
//! the clamp, and every decision on the way.
//!
//! ```text
//! Recording ─▶ points: spurious, bursts, masks ─▶ cycles ─▶ frame: base, up, plane ─▶ onset, noise
//!                                                                                        │
//!                                        Cleaned: releases, statistics, decisions ◀──────┘
//! ```
//!
//! Nothing is filled in: a sample that was lost or masked stays empty. Each decision is listed with
//! the key of the experiment file that decides otherwise.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, on the processing of its
//! recordings.

pub mod base;
mod bursts;
mod cycles;
mod decision;
mod frame;
mod held;
mod motion;
mod noise;
mod onset;
pub mod out_of_plane;
mod points;
mod recording;
mod release;
mod representative;
mod spurious;
mod steps;
mod up;

use efam_recordings::Recording;
use schemars::JsonSchema;
use serde::Serialize;

use crate::experiment::{Experiment, ExperimentError, Under};
use crate::release::Release;
use crate::scenario::Case;

pub use crate::error::CleaningError;
pub use base::BasePose;
pub use cycles::Cut;
pub use decision::{Decision, mm};
pub use frame::Frame;
pub use motion::Motion;
pub use onset::Onset;
pub use points::mask_spurious;
pub use recording::clean_recording;
pub use up::{IS_UP, SURELY};

/// All releases of an experiment.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// One for each recording.
    pub recordings: Vec<CleanRecording>,
    /// The releases of all recordings, dropped ones included.
    pub releases: Vec<CleanRelease>,
    /// What was decided.
    pub decisions: Vec<Decision>,
}

/// A recording and what was done with it.
#[derive(Clone, Debug)]
pub struct CleanRecording {
    /// Name of the file.
    pub name: String,
    /// As it was read.
    pub recording: Recording,
    /// The tip in the recording's frame, m, shape `[samples]`: the centroid of its markers where all
    /// were seen, ghosts included.
    pub tip: Vec<Option<[f64; 3]>>,
    /// Samples of the tip that are not used although they were seen.
    pub masked: Vec<bool>,
    /// The frame at the clamp.
    pub frame: Frame,
    /// Pose of the base, if there is one.
    pub base: Option<BasePose>,
    /// Releases in it.
    pub cuts: Vec<Cut>,
}

/// A release with its statistics.
#[derive(Clone, Debug)]
pub struct CleanRelease {
    /// What fits see of it.
    pub release: Release,
    /// Which recording it is from, from 0.
    pub recording: usize,
    /// Which of its releases, from 1.
    pub number: usize,
    /// Instant of release on the recording's clock, s.
    pub instant: f64,
    /// Time after the release, s, up to which the tip swings or rests and nobody raises it.
    pub swings_until: f64,
    /// Angle of the straight rod while it is held, rad, if it is given.
    pub angle: Option<f64>,
    /// Why it is not used, if it is not.
    pub dropped: Option<String>,
    /// Whether it represents the releases of the same pressure and payload.
    pub representative: bool,
    /// Its numbers.
    pub statistics: Statistics,
}

/// Numbers of a release; lengths in m, in W where nothing else is said.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Statistics {
    /// Samples of hold and swing.
    pub samples: usize,
    /// Samples in which the tip is lost or masked, in all.
    pub masked_share: f64,
    /// Samples in which it was seen and is masked.
    pub masked_samples: usize,
    /// Angle above the horizontal of the line from the clamp to the held tip, rad.
    pub hold_angle: f64,
    /// Tip while it is held, after its offset is taken off.
    pub hold: [f64; 2],
    /// Tip at rest, likewise.
    pub rest: [f64; 2],
    /// How far the tip sinks from hold to rest; none where the recording begins in mid-swing and shows no hold.
    pub static_drop: Option<f64>,
    /// What was taken off the tip as its offset from the rod.
    pub offset: [f64; 2],
    /// Drift of the tip over the last 0.3 s of the hold in the way from hold to rest.
    pub hold_drift_share: f64,
    /// Farthest distance of the tip from the vertical plane through the clamp's axis while it swings.
    pub out_of_plane: f64,
    /// The same over the active length or, without a model, over the distance of the held tip.
    pub out_of_plane_share: f64,
    /// Farthest distance of the tip from a plane beside that, through the mean of its swing; likewise a share.
    pub sway_share: f64,
    /// Standard error of the instant in sampling steps.
    pub instant_error_steps: f64,
    /// Noise of the tip.
    pub noise: f64,
}

/// Cleans all recordings of an experiment.
/// # Errors
/// [`ExperimentError`]: of a file, of a recording, of the model.
pub fn clean(experiment: &Experiment) -> Result<Cleaned, ExperimentError> {
    let recordings =
        (0..experiment.recordings.len()).map(|k| experiment.read(k)).collect::<Result<_, _>>()?;
    clean_all(experiment, recordings)
}

/// Cleans recordings that are read already, one for each of the experiment.
/// # Errors
/// As [`clean`].
/// # Panics
/// If there are not as many as the experiment has.
pub fn clean_all(experiment: &Experiment, recordings: Vec<Recording>) -> Result<Cleaned, ExperimentError> {
    assert_eq!(recordings.len(), experiment.recordings.len(), "one for each");
    let mut cleaned = Cleaned { recordings: Vec::new(), releases: Vec::new(), decisions: Vec::new() };
    for (k, recording) in recordings.into_iter().enumerate() {
        let (clean, releases) = clean_recording(experiment, k, recording, &mut cleaned.decisions)?;
        cleaned.recordings.push(clean);
        cleaned.releases.extend(releases);
    }
    representative::choose(&mut cleaned.releases);
    for release in cleaned.releases.iter().filter(|release| release.representative) {
        let what = "the cleanest release of its pressure and payload, hence the one that stands for them";
        let about = release.release.name.clone();
        cleaned.decisions.push(Decision { about, what: what.to_owned(), key: "keep" });
    }
    Ok(cleaned)
}

impl Cleaned {
    /// The releases that are used, held-out ones included.
    pub fn used(&self) -> impl Iterator<Item = &CleanRelease> {
        self.releases.iter().filter(|release| release.dropped.is_none())
    }

    /// Caveats of every answer of a planar model.
    pub fn warnings(&self) -> Vec<String> {
        let moves = |of: &CleanRecording| {
            let base = of.base.as_ref().filter(|base| base.is_followed())?;
            let has_two_markers = base.followed_turn.is_some() && base.orientation.is_none();
            let unseen = if has_two_markers {
                "; two markers show no turn about their own line, so measure a third"
            } else {
                ""
            };
            Some(format!(
                "{}: the base moves by up to {} and turns by up to {:.2} deg: that is taken off sample by sample, and no model \
                 has the forces of its acceleration{unseen}",
                of.name,
                mm(base.moved),
                base.turned.to_degrees()
            ))
        };
        let out_of_plane = out_of_plane::warning(self.used().map(|used| &used.release));
        self.recordings.iter().filter_map(moves).chain(out_of_plane).collect()
    }
}

impl CleanRecording {
    /// Whether all its swings are as even as swings are.
    pub fn is_even(&self) -> bool {
        let seen = self.tip.iter().zip(&self.masked).map(|(at, masked)| at.filter(|_| !masked));
        let seen: Vec<_> = seen.collect();
        self.cuts.iter().all(|cut| cut.is_even(&self.recording.time, &seen))
    }
}

impl CleanRelease {
    /// The case of this release, with the pressure over its time; nothing if the experiment has no model.
    /// # Errors
    /// [`ExperimentError`] for what the muscle or the model refuses.
    pub fn case(&self, experiment: &Experiment) -> Result<Option<Case>, ExperimentError> {
        experiment.case_at(self.recording, self.angle, None, Under::Since(self.instant))
    }

    /// The case under the pressure at which the tip comes to rest, with another angle and number of nodes; likewise.
    /// # Errors
    /// [`ExperimentError`] for what the muscle or the model refuses.
    pub fn case_at_rest(
        &self,
        experiment: &Experiment,
        angle: Option<f64>,
        nodes: Option<usize>,
    ) -> Result<Option<Case>, ExperimentError> {
        experiment.case_at(self.recording, angle, nodes, Under::At(self.instant + self.swings_until))
    }

    /// The model of this release; nothing if the experiment has none.
    /// # Errors
    /// [`ExperimentError`] for what the muscle or the model refuses.
    pub fn model(&self, experiment: &Experiment) -> Result<Option<models::model::Model>, ExperimentError> {
        Ok(self.case(experiment)?.map(|case| case.model))
    }
}

/// Distance of two points.
pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
pub(crate) mod tests;
