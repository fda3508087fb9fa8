//! Where a fit and its recordings disagree, before any name: at which multiple of the swing's frequency, at
//! which amplitude, across or along the rod, the same at all pressures or growing with them.
//!
//! The swing is followed by its amplitude A and phase φ, read off the predicted path of the tip. What the
//! residual may hold is written as `w(A) cos nφ` and `w(A) sin nφ`, n = 0 to 3, with basis functions w over the
//! logarithm of the amplitude, so that releases from several angles speak of the same place. Each is scored
//! as a candidate is, orthogonally to all that the fit may adjust, so that the shapes are heard only where
//! nothing in the model could make them. No name of an effect goes into them: where no candidate scores and
//! a shape does, the catalogue lacks something.

use std::f64::consts::FRAC_PI_2;

use efam_experiments::release::Point;

use super::design_matrix::{Column, in_noise};
use super::score::{RESOLVED, Subject, scores};
use super::swing::{share_of_largest, swing};
use super::verdict::Shape;
use crate::calibrate::joint::Joint;
use crate::calibrate::prediction::Prediction;

/// A residual pattern: its harmonic of the swing, its direction, its place, and whether it grows with the pressure.
#[derive(Clone, Copy)]
struct Pattern {
    words: &'static str,
    /// Multiple of the frequency.
    harmonic: u32,
    /// Along the line from the clamp, or across it.
    is_radial: bool,
    /// Only what markers on the body do beside the first mode.
    is_of_body: bool,
    /// In proportion to the pressure's distance from the mean.
    over_pressure: bool,
}

impl Pattern {
    const PLAIN: Self =
        Self { words: "", harmonic: 0, is_radial: false, is_of_body: false, over_pressure: false };
}

const PATTERNS: [Pattern; 9] = [
    Pattern { words: "the mean drifts with the amplitude", ..Pattern::PLAIN },
    Pattern { words: "amplitude and phase of the swing", harmonic: 1, ..Pattern::PLAIN },
    Pattern { words: "the swing's second harmonic", harmonic: 2, ..Pattern::PLAIN },
    Pattern { words: "the swing's third harmonic", harmonic: 3, ..Pattern::PLAIN },
    Pattern { words: "the distance from the clamp at rest", is_radial: true, ..Pattern::PLAIN },
    Pattern {
        words: "the distance from the clamp, twice a swing",
        is_radial: true,
        harmonic: 2,
        ..Pattern::PLAIN
    },
    Pattern { words: "the shape of the body", is_of_body: true, harmonic: 1, ..Pattern::PLAIN },
    Pattern { words: "the mean changes with the pressure", over_pressure: true, ..Pattern::PLAIN },
    Pattern {
        words: "amplitude and phase change with the pressure",
        over_pressure: true,
        harmonic: 1,
        ..Pattern::PLAIN
    },
];

/// Basis functions over the logarithm of the amplitude, from the largest down to a share of it.
const BASIS: usize = 4;
const SMALLEST_AMPLITUDE: f64 = 0.05;

/// Scores all shapes at a fit whose predictions are given.
pub(super) fn shapes(fit: &Joint, off: &[Prediction], round: usize, false_alarm: f64) -> Vec<Shape> {
    let swings = swings(fit, off);
    let columns: Vec<Column> = PATTERNS
        .iter()
        .enumerate()
        .flat_map(|(f, pattern)| of_pattern(fit, off, &swings, f, pattern))
        .collect();
    let scores = scores(
        fit,
        &[Subject { own: RESOLVED, ..Subject::default() }; PATTERNS.len()],
        &columns,
        false_alarm,
    );
    let mut shapes = Vec::new();
    for (pattern, score) in PATTERNS.iter().zip(&scores.each) {
        if score.columns.is_empty() {
            continue;
        }
        let of_basis = |basis: usize| {
            let own = score.columns.iter().zip(&score.estimates);
            let own = own.filter(|(column, _)| columns[**column].part % BASIS == basis);
            own.map(|(_, size)| size * size).sum::<f64>().sqrt()
        };
        let (basis, size) = (0..BASIS)
            .map(|basis| (basis, of_basis(basis)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .expect("there are basis functions");
        let at_amplitude = SMALLEST_AMPLITUDE.powf(basis as f64 / (BASIS - 1) as f64);
        let swinging = if pattern.harmonic == 0 { 1.0 } else { at_amplitude };
        shapes.push(Shape {
            round,
            what: pattern.words.to_owned(),
            score: score.size,
            threshold: scores.threshold,
            at_amplitude,
            size_mm: 1e3 * size * swinging,
        });
    }
    shapes
}

/// Columns of a pattern: one for each basis function, and for cosine and sine.
fn of_pattern(
    fit: &Joint,
    off: &[Prediction],
    swings: &[Vec<[f64; 2]>],
    of: usize,
    pattern: &Pattern,
) -> Vec<Column> {
    let members = &fit.objective.part.members;
    let pressures: Vec<f64> = members.iter().map(|trial| trial.release.pressure.unwrap_or(0.0)).collect();
    let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
    let widest = pressures.iter().map(|p| (p - mean).abs()).fold(0.0, f64::max);
    let has_body =
        members.iter().any(|trial| trial.release.tracks.iter().any(|track| track.at != Point::Tip));
    if (pattern.over_pressure && widest < 1e-3 * mean) || (pattern.is_of_body && !has_body) {
        return Vec::new();
    }
    let quarters = if pattern.harmonic == 0 { 1 } else { 2 };
    let shape = |part: usize, r: usize, t: usize, k: usize| {
        let track = &members[r].release.tracks[t];
        let [amplitude, phase] = swings[r][k];
        let quarter = (part / BASIS) as f64;
        let harmonic = (f64::from(pattern.harmonic) * phase - quarter * FRAC_PI_2).cos();
        let over_pressure = if pattern.over_pressure { (pressures[r] - mean) / widest } else { 1.0 };
        // A phase is nothing where nothing swings.
        let swinging = if pattern.harmonic == 0 { 1.0 } else { amplitude };
        over_pressure
            * swinging
            * harmonic
            * basis(amplitude, part % BASIS)
            * place(track.at, pattern.is_of_body)
    };
    let moved = |part: usize, r: usize, t: usize, k: usize| {
        let [x, z] = off[r].position[t][k];
        let distance = x.hypot(z).max(f64::MIN_POSITIVE);
        let direction = if pattern.is_radial { [x, z] } else { [-z, x] };
        direction.map(|d| shape(part, r, t, k) * d / distance)
    };
    (0..quarters * BASIS)
        .map(|part| Column {
            of,
            part,
            slopes: (0..members.len()).map(|r| in_noise(fit, r, |t, k| moved(part, r, t, k))).collect(),
        })
        .collect()
}

/// How far a point goes when the tip goes by one: as in the first mode, roughly, or beside it.
fn place(at: Point, is_of_body: bool) -> f64 {
    match (at, is_of_body) {
        (Point::Tip, false) => 1.0,
        (Point::Tip, true) => 0.0,
        (Point::Along(s), false) => s * s,
        (Point::Along(s), true) => 4.0 * s * (1.0 - s),
    }
}

/// The `k`-th basis over the logarithm of the amplitude; the first and the last stay up beyond the ends.
fn basis(amplitude: f64, k: usize) -> f64 {
    let place = amplitude.max(f64::MIN_POSITIVE).ln() / SMALLEST_AMPLITUDE.ln() * (BASIS - 1) as f64;
    (1.0 - (place.clamp(0.0, (BASIS - 1) as f64) - k as f64).abs()).max(0.0)
}

/// Amplitude, as a share of the largest of all releases, and phase of all samples, from the tip or else the
/// last track.
fn swings(fit: &Joint, off: &[Prediction]) -> Vec<Vec<[f64; 2]>> {
    let of_release = |r: usize| {
        let release = &fit.objective.part.members[r].release;
        let time: Vec<f64> = fit.objective.measured[r].samples.iter().map(|k| release.time[*k]).collect();
        swing(&time, &off[r].position[release.leading_track()])
    };
    let mut all: Vec<Vec<[f64; 2]>> = (0..off.len()).map(of_release).collect();
    share_of_largest(&mut all);
    all
}
