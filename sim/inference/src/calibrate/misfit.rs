//! Differences of a fit and its recording in the quantities that are predicted later. Both are analysed alike.
//!
//! Predictions add them to their intervals. The part that noise explains is left out: the errors of the parameters hold
//! it already.

use efam_experiments::analysis::measured::{Measured, analyse};
use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One track beside what the fit predicts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name of the release.
    pub release: String,
    /// Its pressure, Pa.
    pub pressure: Option<f64>,
    /// Name of the marker.
    pub marker: String,
    /// Time of the recording, s after its estimated release.
    pub time: Vec<f64>,
    /// Measured position, m.
    pub measured: Vec<[f64; 2]>,
    /// Predicted position, offset included, m.
    pub predicted: Vec<[f64; 2]>,
}

/// How a tip swings, as `efam analyse` reads it off a path; none where the path does not determine it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrequencyAndDamping {
    /// Frequency as released, Hz.
    pub frequency_hz: Option<f64>,
    /// Damping ratio by eq. 6.
    pub damping_ratio: Option<f64>,
}

/// How far a fit is from a recording of the tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Misfit {
    /// Root mean square distance over all samples without noise, mm.
    pub distance_mm: f64,
    /// Distance of the means over the last fifth, mm.
    pub rest_mm: f64,
    /// Measured frequency as released, Hz.
    pub frequency_hz: Option<f64>,
    /// Frequency as fitted over that, less one.
    pub frequency: Option<f64>,
    /// Damping ratio by eq. 6 as fitted over that measured, less one.
    pub damping_ratio: Option<f64>,
}

impl Misfit {
    /// Of the track of a tip without its ghosts, by the deviations of what a fit misses of it and by which its samples are
    /// weighed, m. Where nothing is missed all differences are noise.
    pub(super) fn of(
        curve: &Curve,
        [measured, fitted]: [FrequencyAndDamping; 2],
        missed: f64,
        noise: f64,
    ) -> Self {
        let frequency_hz = measured.frequency_hz;
        if missed == 0.0 {
            return Self { frequency_hz, ..Self::default() };
        }
        let ratio = |of: fn(FrequencyAndDamping) -> Option<f64>| Some(of(fitted)? / of(measured)? - 1.0);
        let [seen, met] = [&curve.measured, &curve.predicted].map(|path| rest(path));
        let square = (seen[0] - met[0]).powi(2) + (seen[1] - met[1]).powi(2);
        let by_chance = 2.0 * noise * noise / (REST * curve.time.len() as f64).max(1.0);
        Self {
            distance_mm: 1e3 * (2.0 * missed * missed).sqrt(),
            rest_mm: 1e3 * (square - by_chance).max(0.0).sqrt(),
            frequency_hz,
            frequency: ratio(|swing| swing.frequency_hz),
            damping_ratio: ratio(|swing| swing.damping_ratio),
        }
    }
}

impl FrequencyAndDamping {
    /// Of a path of a track.
    pub(super) fn of(curve: &Curve, path: &[[f64; 2]]) -> Self {
        let Some(swing) = swing_of(curve, path) else { return Self::default() };
        Self {
            frequency_hz: swing.damped_frequency.ok().map(|omega| omega / std::f64::consts::TAU),
            damping_ratio: swing.decay.ok().map(|decay| decay.damping_ratio),
        }
    }
}

/// Share of a recording, at its end, whose mean counts as the rest.
const REST: f64 = 0.2;

fn rest(path: &[[f64; 2]]) -> [f64; 2] {
    let late = path.len() - (REST * path.len() as f64) as usize;
    let tail = &path[late.min(path.len().saturating_sub(1))..];
    [0, 1].map(|axis| tail.iter().map(|x| x[axis]).sum::<f64>() / tail.len().max(1) as f64)
}

/// The swing of a path of a track about where it comes to rest; nothing where it has none.
pub fn swing_of(curve: &Curve, path: &[[f64; 2]]) -> Option<Measured> {
    if path.is_empty() {
        return None;
    }
    let track = Track {
        marker: curve.marker.clone(),
        at: Point::Tip,
        position: path.iter().map(|x| Some(*x)).collect(),
        noise: 1e-4,
        discrepancy: 0.0,
    };
    let release = Release {
        name: curve.release.clone(),
        time: curve.time.clone(),
        release_uncertainty: 0.0,
        tracks: vec![track],
        pressure: None,
        payload: 0.0,
        held_out: false,
        out_of_plane: OutOfPlane::default(),
    };
    analyse(&release, rest(path)).ok()
}
