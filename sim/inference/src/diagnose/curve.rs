//! What was measured beside what is predicted, before an effect is added and after.

use rayon::prelude::*;

use super::hypothesis::Settled;
use super::swing::{share_of_largest, swing};
use super::verdict::Gap;

/// One track as it was measured, and as the model has it without and with what was added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name of the release.
    pub release: String,
    /// Whether it is held out.
    pub held_out: bool,
    /// Its pressure, Pa.
    pub pressure: Option<f64>,
    /// Name of the marker.
    pub marker: String,
    /// Whether it is the track by which the swing of its release is followed.
    pub is_leading: bool,
    /// Standard deviation of the noise of a coordinate, m.
    pub noise: f64,
    /// Its samples; nothing where the marker was lost.
    pub samples: Vec<Option<Sample>>,
}

/// One sample of a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time after the release as it is recorded, s.
    pub time: f64,
    /// Measured position, m.
    pub measured: [f64; 2],
    /// Position that the model predicts without what was added, m.
    pub before: [f64; 2],
    /// And with it, m.
    pub after: [f64; 2],
    /// Amplitude of the swing as a share of the largest of all releases.
    pub amplitude: f64,
    /// Phase of the swing, rad, growing with time.
    pub phase: f64,
}

/// The predicted position of a sample.
pub type Predicted = fn(&Sample) -> [f64; 2];

/// The two predictions, before an effect is added and after.
pub const BEFORE_AND_AFTER: [Predicted; 2] = [|sample| sample.before, |sample| sample.after];

impl Curve {
    /// The samples that were seen.
    pub fn seen(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().flatten()
    }
}

impl Sample {
    /// Measurement minus prediction, m.
    pub fn residual(&self, predicted: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.measured[axis] - predicted[axis])
    }

    /// The part of that which lies across the line from the clamp, along the swing, m.
    pub fn across(&self, predicted: [f64; 2]) -> f64 {
        let [x, z] = self.after;
        let [dx, dz] = self.residual(predicted);
        (x * dz - z * dx) / x.hypot(z).max(f64::MIN_POSITIVE)
    }
}

/// The curves of releases as a model has them before and after; those of releases that cannot be run are not there.
pub(super) fn curves(pairs: &[(&Settled, &Settled)]) -> Vec<Curve> {
    let of = |(before, after): &(&Settled, &Settled)| -> Option<Vec<Curve>> {
        let release = &after.trial.release;
        let [before, after] = [before.positions()?, after.positions()?];
        let leading = release.leading_track();
        let curve = |t: usize| {
            let track = &release.tracks[t];
            // Before the release a hand has the rod.
            let sample = |k: usize| {
                Some(Sample {
                    time: Some(release.time[k]).filter(|time| *time >= 0.0)?,
                    measured: track.position[k]?,
                    before: before[k][t],
                    after: after[k][t],
                    ..Sample::default()
                })
            };
            Curve {
                release: release.name.clone(),
                held_out: release.held_out,
                pressure: release.pressure,
                marker: track.marker.clone(),
                is_leading: t == leading,
                noise: track.noise,
                samples: (0..release.time.len()).map(sample).collect(),
            }
        };
        Some((0..release.tracks.len()).map(curve).collect())
    };
    let found: Vec<_> = pairs.par_iter().filter_map(of).collect();
    let mut curves: Vec<Curve> = found.into_iter().flatten().collect();
    follow_swings(&mut curves);
    curves
}

/// The gap of each release, from its curves.
pub(super) fn gaps(curves: &[Curve]) -> Vec<Gap> {
    let mut gaps = Vec::new();
    for leading in curves.iter().filter(|curve| curve.is_leading) {
        let own: Vec<&Curve> = curves.iter().filter(|curve| curve.release == leading.release).collect();
        let count = own.iter().map(|curve| curve.seen().count()).sum::<usize>().max(1) as f64;
        let [before, after] = BEFORE_AND_AFTER.map(|predicted| {
            let square = |sample: &Sample| {
                let [x, z] = sample.residual(predicted(sample));
                x * x + z * z
            };
            let (mut sum, mut over) = (0.0, 0.0);
            for curve in &own {
                let squares: f64 = curve.seen().map(square).sum();
                sum += squares;
                over += squares / (2.0 * curve.noise * curve.noise);
            }
            [1e3 * (sum / count).sqrt(), (over / count).sqrt()]
        });
        let noise = own.iter().map(|curve| curve.noise).sum::<f64>() / own.len().max(1) as f64;
        gaps.push(Gap {
            release: leading.release.clone(),
            held_out: leading.held_out,
            before_mm: before[0],
            after_mm: after[0],
            before: before[1],
            after: after[1],
            noise_mm: 1e3 * noise,
        });
    }
    gaps
}

/// Reads amplitude and phase off the leading track of each release, and gives them to all its tracks.
fn follow_swings(curves: &mut [Curve]) {
    let leading: Vec<usize> = (0..curves.len()).filter(|c| curves[*c].is_leading).collect();
    let of_leading = |c: &usize| {
        let (time, path): (Vec<f64>, Vec<_>) =
            curves[*c].seen().map(|sample| (sample.time, sample.after)).unzip();
        swing(&time, &path)
    };
    let mut swings: Vec<Vec<[f64; 2]>> = leading.iter().map(of_leading).collect();
    share_of_largest(&mut swings);
    for (c, swing) in leading.into_iter().zip(swings) {
        let (time, release): (Vec<f64>, _) =
            (curves[c].seen().map(|sample| sample.time).collect(), curves[c].release.clone());
        let own = curves.iter_mut().filter(|curve| curve.release == release);
        for sample in own.flat_map(|curve| curve.samples.iter_mut().flatten()) {
            // Where the leading track has a gap: its last sample before it.
            let k = time.partition_point(|time| *time <= sample.time).saturating_sub(1);
            if let Some(at) = swing.get(k) {
                [sample.amplitude, sample.phase] = *at;
            }
        }
    }
}
