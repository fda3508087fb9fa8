//! One release as the fit sees it: tracks of points in the plane of the swing, masked, not filled in.

pub use efam_core::point::Point;

/// A release, cut out of a recording and turned into the frame W at the clamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Release {
    /// Recording and number within it, such as `15psi.csv#3`.
    pub name: String,
    /// Time of each sample after the estimated instant of release, s, ascending; samples of the hold
    /// before it are negative.
    pub time: Vec<f64>,
    /// Standard error of the release instant, s; zero if time zero is a sample at which the rod is in motion.
    pub release_uncertainty: f64,
    /// What was tracked.
    pub tracks: Vec<Track>,
    /// Gauge pressure, Pa, if it is known.
    pub pressure: Option<f64>,
    /// Mass of the payload, kg.
    pub payload: f64,
    /// Locked away from every fit.
    pub held_out: bool,
    /// How far its tip is from the plane of the model.
    pub out_of_plane: OutOfPlane,
}

impl Release {
    /// Place of the track by which the swing is followed: the tip, or else the last one.
    pub fn leading_track(&self) -> usize {
        let tip = self.tracks.iter().position(|track| track.at == Point::Tip);
        tip.unwrap_or(self.tracks.len().saturating_sub(1))
    }
}

/// The path of one observed point.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Name of the marker, or of the group whose centroid it is.
    pub marker: String,
    /// Where on the rod it sits.
    pub at: Point,
    /// Position `[x, z]` in W, m, shape `[samples]`; nothing where it was lost or masked.
    pub position: Vec<Option<[f64; 2]>>,
    /// Standard deviation of the noise of each coordinate, m.
    pub noise: f64,
    /// Standard deviation of what no model predicts of each coordinate beside the noise, m, as if each sample had its
    /// own: what a whole swing shares is smaller, by the root of the samples that share it.
    pub discrepancy: f64,
}

/// How far a tip is from the vertical plane through the clamp's axis, at most while it swings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutOfPlane {
    /// Distance, m; zero where it is not known.
    pub distance: f64,
    /// The same over the active length or, without a model, over the distance of the held tip.
    pub share: f64,
}

impl OutOfPlane {
    /// How much nearer to the clamp the tip is seen in the plane, m: `y² / 2L`.
    pub fn shortening(&self) -> f64 {
        0.5 * self.distance * self.share
    }
}
