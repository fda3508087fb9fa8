//! What a simulation does wrong, in the words of swings: it loses energy too slowly or too fast, it swings
//! too slowly or too fast, at which amplitudes and pressures.
//!
//! In each cycle the measured angle is taken for `A (1 + e) cos(φ + p)`, with A and φ of the predicted swing;
//! e and p follow from the residual by least squares. Where e falls from cycle to cycle, the measured swing
//! decays faster than the simulated one; where p grows, it swings faster. Slopes are weighed by the noise.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::curve::{Curve, Sample};
use super::verdict::{Misfit, Wrong};
use crate::calibrate::prediction::LEAST_SAMPLES;
use crate::calibrate::problem::is_same_pressure;
use crate::normal::CLEAR;

/// Bounds of large, middle and small swings, as shares of the largest amplitude.
pub const BANDS: [[f64; 2]; 3] = [[0.4, 1.0], [0.15, 0.4], [0.05, 0.15]];
/// Standard errors from which on something is said.
const SAID: f64 = 6.0;

/// One cycle of a release: what the measured swing is beside the simulated one.
struct Cycle {
    number: f64,
    amplitude: f64,
    /// Amplitude, m.
    metres: f64,
    /// Share of the amplitude and angle of the phase, rad.
    ahead: [f64; 2],
    variance: f64,
}

/// A slope of a release in a band.
struct Slope {
    pressure: f64,
    value: [f64; 2],
    variance: f64,
    /// Cycles in the band and amplitude there, m.
    cycles: f64,
    metres: f64,
    before: f64,
}

/// All that is said of the fitted releases, the largest first.
pub(super) fn misfits(curves: &[Curve]) -> Vec<Misfit> {
    let fitted: Vec<(f64, Vec<Cycle>)> = curves
        .iter()
        .filter(|curve| curve.is_leading && !curve.held_out)
        .map(|curve| (curve.pressure.unwrap_or(0.0), cycles(curve)))
        .collect();
    let mut found: Vec<Misfit> = Vec::new();
    for band in BANDS {
        let slopes: Vec<Slope> =
            fitted.iter().filter_map(|(own, cycles)| slope(*own, cycles, band)).collect();
        found.extend((0..2).filter_map(|kind| misfit(&slopes, band, kind)));
    }
    found.sort_by(|a, b| b.size_mm.total_cmp(&a.size_mm));
    found
}

/// The cycles of a release, from one passing of phase zero to the next.
fn cycles(curve: &Curve) -> Vec<Cycle> {
    let (mut cycles, mut own): (Vec<Cycle>, Vec<&Sample>) = (Vec::new(), Vec::new());
    let (mut turned, mut last) = (0.0, None);
    for sample in curve.seen() {
        if let Some(last) = last {
            let step: f64 = sample.phase - last;
            turned += step - TAU * (step / TAU).round();
        }
        last = Some(sample.phase);
        if turned >= TAU {
            cycles.extend(cycle(&own, cycles.len() as f64, curve.noise));
            turned -= TAU;
            own.clear();
        }
        if !sample.is_held_back {
            own.push(sample);
        }
    }
    cycles
}

fn cycle(samples: &[&Sample], number: f64, noise: f64) -> Option<Cycle> {
    if samples.len() < LEAST_SAMPLES {
        return None;
    }
    let n = samples.len() as f64;
    let amplitude = samples.iter().map(|sample| sample.amplitude).sum::<f64>() / n;
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for sample in samples {
        let row = Vector3::new(sample.phase.cos(), -sample.phase.sin(), 1.0);
        matrix += row * row.transpose();
        right += row * sample.across(sample.before);
    }
    let inverse = matrix.try_inverse()?;
    let found = inverse * right;
    let metres = swept(samples);
    Some(Cycle {
        number,
        amplitude,
        metres,
        ahead: [found[0] / metres, found[1] / metres],
        variance: 0.5 * (inverse[(0, 0)] + inverse[(1, 1)]) * (noise / metres).powi(2),
    })
}

/// Half of what the point sweeps, m.
fn swept(samples: &[&Sample]) -> f64 {
    let first = samples[0].after;
    let far = |from: [f64; 2]| {
        let distance = |sample: &&&Sample| (sample.after[0] - from[0]).hypot(sample.after[1] - from[1]);
        let by_distance = |a: &&&Sample, b: &&&Sample| distance(a).total_cmp(&distance(b));
        samples.iter().max_by(by_distance).map_or(from, |sample| sample.after)
    };
    let (a, b) = (far(first), far(far(first)));
    (0.5 * (a[0] - b[0]).hypot(a[1] - b[1])).max(f64::MIN_POSITIVE)
}

/// How the measured swing changes against the simulated one from cycle to cycle in a band.
fn slope(pressure: f64, cycles: &[Cycle], [low, high]: [f64; 2]) -> Option<Slope> {
    let own: Vec<&Cycle> =
        cycles.iter().filter(|cycle| cycle.amplitude >= low && cycle.amplitude < high).collect();
    // A slope takes two.
    if own.len() < 2 {
        return None;
    }
    let weight = |cycle: &Cycle| cycle.variance.recip();
    let all: f64 = own.iter().map(|cycle| weight(cycle)).sum();
    let mean = own.iter().map(|cycle| weight(cycle) * cycle.number).sum::<f64>() / all;
    let spread: f64 = own.iter().map(|cycle| weight(cycle) * (cycle.number - mean).powi(2)).sum();
    let of = |kind: usize| {
        let pull = own.iter().map(|cycle| weight(cycle) * (cycle.number - mean) * cycle.ahead[kind]);
        pull.sum::<f64>() / spread
    };
    Some(Slope {
        pressure,
        value: [of(0), of(1)],
        variance: spread.recip(),
        cycles: own.len() as f64,
        metres: own.iter().map(|cycle| cycle.metres).sum::<f64>() / own.len() as f64,
        before: own[0].number,
    })
}

/// What the slopes of all releases in a band say of the amplitude, `kind` 0, or the phase, 1.
fn misfit(slopes: &[Slope], amplitudes: [f64; 2], kind: usize) -> Option<Misfit> {
    let (value, error) = pooled(slopes.iter(), kind)?;
    if value.abs() < SAID * error {
        return None;
    }
    let mut there: Vec<f64> = slopes.iter().map(|slope| slope.pressure).collect();
    there.sort_by(f64::total_cmp);
    there.dedup_by(|a, b| is_same_pressure(*a, *b));
    let is_seen = |pressure: &f64| {
        let own = slopes.iter().filter(|slope| is_same_pressure(slope.pressure, *pressure));
        pooled(own, kind).is_some_and(|(own, error)| own * value.signum() > CLEAR * error)
    };
    let median = |of: fn(&Slope) -> f64| {
        let mut all: Vec<f64> = slopes.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let sizes = slopes.iter().map(|slope| (slope.value[kind] * slope.cycles * slope.metres).powi(2));
    Some(Misfit {
        what: match (kind, value < 0.0) {
            (0, true) => Wrong::LosesEnergyTooSlowly,
            (0, false) => Wrong::LosesEnergyTooFast,
            (_, true) => Wrong::SwingsTooFast,
            (_, false) => Wrong::SwingsTooSlowly,
        },
        amplitudes,
        per_cycle: value,
        standard_error: error,
        size_mm: 1e3 * (sizes.sum::<f64>() / slopes.len() as f64).sqrt(),
        cycles: [median(|slope| slope.cycles), median(|slope| slope.before)],
        pressures_pa: there.iter().copied().filter(is_seen).collect(),
        pressures_there_pa: there,
    })
}

/// The mean of slopes by their weights, and its standard error.
fn pooled<'a>(slopes: impl Iterator<Item = &'a Slope>, kind: usize) -> Option<(f64, f64)> {
    let (mut sum, mut weights) = (0.0, 0.0);
    for slope in slopes {
        sum += slope.value[kind] / slope.variance;
        weights += slope.variance.recip();
    }
    (weights > 0.0).then(|| (sum / weights, weights.recip().sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::swing::swing;

    /// A measured swing that decays by `decay`, 1/s, and turns by `rate`, rad/s, more than the simulated one,
    /// while it is larger than 0.4 of its first amplitude.
    fn curve(pressure: f64, decay: f64, rate: f64) -> Curve {
        let time: Vec<f64> = (0..600).map(|k| 0.01 * f64::from(k)).collect();
        let large = 0.4f64.ln() / -0.5;
        let place = |angle: f64| [0.3 * angle.cos(), 0.3 * angle.sin()];
        let after: Vec<[f64; 2]> =
            time.iter().map(|t| place(0.3 * (-0.5 * t).exp() * (9.0 * t).cos())).collect();
        let swings = swing(&time, &after);
        let sample = |k: usize| {
            let (t, own) = (time[k], time[k].min(large));
            let angle = 0.3 * (-0.5 * t).exp() * (1.0 - decay * own) * (9.0 * t + rate * own).cos();
            let [amplitude, phase] = swings[k];
            let (before, after) = (after[k], after[k]);
            let measured = place(angle);
            Some(Sample {
                time: t,
                measured,
                before,
                after,
                amplitude: amplitude / 0.3,
                phase,
                is_held_back: false,
            })
        };
        let samples = (0..600).map(sample).collect();
        Curve { pressure: Some(pressure), is_leading: true, noise: 3e-4, samples, ..Curve::default() }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_amplitude_and_pressures() {
        for (decay, rate, what) in [
            (0.04, 0.0, Wrong::LosesEnergyTooSlowly),
            (-0.04, 0.0, Wrong::LosesEnergyTooFast),
            (0.0, 0.04, Wrong::SwingsTooSlowly),
            (0.0, -0.04, Wrong::SwingsTooFast),
        ] {
            let curves = [curve(1e5, decay, rate), curve(2e5, decay, rate), curve(3e5, 0.0, 0.0)];
            let found = misfits(&curves);
            let first = found.first().expect("something is wrong");
            assert_eq!((first.what, first.amplitudes), (what, BANDS[0]), "{found:?}");
            assert_eq!(first.pressures_pa, [1e5, 2e5], "{found:?}");
            assert_eq!(first.pressures_there_pa.len(), 3);
            // A third of what changes at two of three pressures; 9 rad/s is a cycle in 0.7 s.
            let expected = (decay + rate) * TAU / 9.0 * 2.0 / 3.0;
            assert!((first.per_cycle.abs() / expected.abs() - 1.0).abs() < 0.2, "{found:?} {expected}");
        }
        assert!(misfits(&[curve(1e5, 0.0, 0.0)]).is_empty());
    }
}
