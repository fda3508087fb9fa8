//! What was measured beside what is predicted, before an effect is added and after.

use super::swing::{share_of_largest, swing};
use crate::calibrate::joint::Joint;
use crate::calibrate::view::Series;

/// How a model meets releases.
#[derive(Clone)]
pub(super) struct Agreement {
    /// Of each release: its name, root mean square distance of all samples but ghosts in mm, and, without what the robust loss holds
    /// back, over the noise; noise in mm.
    pub gaps: Vec<(String, f64, f64, f64)>,
    /// Of each release and track: what was seen, and what is predicted.
    pub paths: Vec<Path>,
}

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
    /// Time after the estimated release, s.
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
    /// Whether it lies so far from the prediction, as a ghost does, that a fit hardly hears it.
    pub is_held_back: bool,
}

/// Where a prediction stands in a sample.
pub type Predicted = fn(&Sample) -> [f64; 2];

/// The two predictions, before an effect is added and after.
pub const BEFORE_AND_AFTER: [Predicted; 2] = [|sample| sample.before, |sample| sample.after];

impl Curve {
    /// The samples that were seen.
    pub fn seen(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().flatten()
    }

    /// Those of them that are not held back.
    pub fn heard(&self) -> impl Iterator<Item = &Sample> {
        self.seen().filter(|sample| !sample.is_held_back)
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

/// A track beside what one fit predicts of it.
#[derive(Clone)]
pub(super) struct Path {
    curve: Curve,
    predicted: Vec<[f64; 2]>,
}

/// The tracks of a fit's releases with what it predicts, mesh and step removed.
pub(super) fn paths(fit: &Joint) -> Vec<Path> {
    let of_release = |(r, block): (usize, &Vec<Series>)| {
        let (release, measured) = (&fit.objective.part.members[r].release, &fit.objective.measured[r]);
        let threshold = fit.found.view.loss[r].threshold;
        let path = |(t, series): (usize, &Series)| {
            let (track, noise) = (&release.tracks[t], measured.noise[t]);
            let mut samples = vec![None; release.time.len()];
            let mut predicted = Vec::with_capacity(series.samples.len());
            for (k, residual) in series.samples.iter().zip(&series.residual) {
                let place = measured.samples[*k];
                let Some(seen) = track.position[place] else { continue };
                samples[place] = Some(Sample {
                    time: release.time[place],
                    measured: seen,
                    is_held_back: residual[0].hypot(residual[1]) > threshold,
                    ..Sample::default()
                });
                predicted.push([0, 1].map(|axis| seen[axis] - noise * residual[axis]));
            }
            let curve = Curve {
                release: release.name.clone(),
                held_out: false,
                pressure: release.pressure,
                marker: track.marker.clone(),
                is_leading: t == release.leading_track(),
                noise: measured.camera_noise[t],
                samples,
            };
            Path { curve, predicted }
        };
        block.iter().enumerate().map(path).collect::<Vec<_>>()
    };
    fit.found.at.carried.blocks.iter().enumerate().flat_map(of_release).collect()
}

/// The curves of pairs of agreements of the same releases, before and after, with whether they were held
/// out.
pub(super) fn curves(pairs: &[(&Agreement, &Agreement, bool)]) -> Vec<Curve> {
    let curve = |before: &Path, after: &Path, held_out: bool| {
        let mut curve = Curve { held_out, ..after.curve.clone() };
        let predicted = before.predicted.iter().zip(&after.predicted);
        for (sample, (before, after)) in curve.samples.iter_mut().flatten().zip(predicted) {
            (sample.before, sample.after) = (*before, *after);
        }
        curve
    };
    let of_pair = |(before, after, held_out): &(&Agreement, &Agreement, bool)| {
        let both = before.paths.iter().zip(&after.paths);
        both.map(|(before, after)| curve(before, after, *held_out)).collect::<Vec<_>>()
    };
    let mut curves: Vec<Curve> = pairs.iter().flat_map(of_pair).collect();
    follow_swings(&mut curves);
    curves
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
        let held_out = curves[c].held_out;
        let own = curves.iter_mut().filter(|curve| curve.release == release && curve.held_out == held_out);
        for sample in own.flat_map(|curve| curve.samples.iter_mut().flatten()) {
            // Where the leading track has a gap: its last sample before it.
            let k = time.partition_point(|time| *time <= sample.time).saturating_sub(1);
            if let Some(at) = swing.get(k) {
                [sample.amplitude, sample.phase] = *at;
            }
        }
    }
}

/// Mean square of residuals over that of the stated noise up to which they may be noise: it is estimated from third
/// differences, which see little of noise that is slow.
const NOISE: f64 = 4.0;

/// Means of the squares of distances, and of what noise of both coordinates makes of them, mm².
pub(super) fn mean_square(own: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let (mut sum, mut count) = ([0.0; 2], 0.0f64);
    for [distance, noise] in own {
        sum = [sum[0] + distance * distance, sum[1] + 2.0 * noise * noise];
        count += 1.0;
    }
    sum.map(|sum| sum / count.max(1.0))
}

/// Mean square distance of all releases, and of noise alone, mm².
pub(super) fn of_all(agreement: &Agreement) -> [f64; 2] {
    mean_square(agreement.gaps.iter().map(|(_, distance, _, noise)| [*distance, *noise]))
}

/// Whether what a model misses is noise, or no more than what releases of one condition differ by, mm.
pub(super) fn is_noise(met: &Agreement, repeats: f64) -> bool {
    let [distance, noise] = of_all(met);
    distance <= NOISE * noise + repeats * repeats
}
