//! Upper peaks of a swing: the turning points at which the tip is highest.
//!
//! **Trap**: where the tip passes beyond straight down (15 psi in the paper), it rises again near
//! its lower turning point, and `z(t)` has a second local maximum in each swing, in the trough. It
//! may lie above the rest, when the rest hangs nearly straight down. Upper peaks are therefore
//! told by what they are: the highest within most of a period, and standing out.

use super::Excursion;

/// A local maximum of an excursion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Time since release, s.
    pub time: f64,
    /// Height above rest, m.
    pub height: f64,
}

/// What makes a local maximum an upper peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakRules {
    /// Least height above the higher of the two saddles around it, as a fraction of the range of
    /// the excursion; noise and the tail of a decay stay below it.
    pub least_prominence: f64,
    /// Least distance from a higher peak, in periods. At 0.7 the period may drift to between 0.7
    /// and 1.4 of what was given, before peaks are lost or bumps half a period away are kept.
    pub least_separation: f64,
}

impl Default for PeakRules {
    fn default() -> Self {
        Self { least_prominence: 0.01, least_separation: 0.7 }
    }
}

/// Upper peaks, in order of time; `period` in s, from the damped frequency.
///
/// Refined between samples by the parabola through the highest three. The release itself, the
/// first sample, is none. With fifty samples a period and a damping ratio of 0.05 the refined height
/// is good to 2e-5 of itself and the time to 4e-5 periods; both errors fall with damping.
pub fn upper_peaks(excursion: &Excursion, period: f64, rules: &PeakRules) -> Vec<Peak> {
    let values = excursion.values();
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (value.min(low), value.max(high)));
    let least = rules.least_prominence * (high - low);
    let mut candidates = local_maxima(values);
    candidates.retain(|&top| prominence(values, top) >= least);

    // The highest first: each rules over its surroundings.
    candidates.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let apart = rules.least_separation * period / excursion.step();
    let mut kept: Vec<usize> = Vec::new();
    for top in candidates {
        if kept.iter().all(|&other| top.abs_diff(other) as f64 >= apart) {
            kept.push(top);
        }
    }
    kept.sort_unstable();
    kept.into_iter().map(|top| refined(values, top, excursion.step())).collect()
}

/// Samples that rise above both sides; of a flat top the middle one.
fn local_maxima(values: &[f64]) -> Vec<usize> {
    let mut tops = Vec::new();
    let mut start = 1;
    while start + 1 < values.len() {
        let flat = values[start..].iter().take_while(|&&value| value == values[start]).count();
        let after = start + flat;
        let rises = values[start - 1] < values[start];
        if rises && after < values.len() && values[after] < values[start] {
            tops.push(start + (flat - 1) / 2);
        }
        start = after;
    }
    tops
}

/// Height above the higher of the lowest points on either side, up to where the signal is higher
/// than the peak: how far one must go down from it before one can go higher.
fn prominence(values: &[f64], top: usize) -> f64 {
    let height = values[top];
    let lowest = |side: &mut dyn Iterator<Item = &f64>| {
        side.take_while(|&&value| value <= height).fold(height, |low, &value| low.min(value))
    };
    let before = lowest(&mut values[..top].iter().rev());
    let after = lowest(&mut values[top + 1..].iter());
    height - before.max(after)
}

/// Vertex of the parabola through a local maximum and its neighbours.
fn refined(values: &[f64], top: usize, step: f64) -> Peak {
    let [before, here, after] = [values[top - 1], values[top], values[top + 1]];
    let bend = before - 2.0 * here + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Peak { time: (top as f64 + shift) * step, height: here - 0.25 * (before - after) * shift }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const STEP: f64 = 0.01;

    fn sampled(z: impl Fn(f64) -> f64) -> Excursion {
        let z: Vec<f64> = (0..2000).map(|i| z(STEP * i as f64)).collect();
        Excursion::about(0.0, &z, STEP).unwrap()
    }

    #[test]
    fn peaks_of_a_damped_cosine_are_where_they_must_be() {
        let (period, decay) = (0.8173, 0.31);
        let omega = TAU / period;
        let peaks = upper_peaks(
            &sampled(|t| 0.2 * (-decay * t).exp() * (omega * t).cos()),
            period,
            &PeakRules::default(),
        );
        // cos is past its top when the product is: tan(omega t) = −decay / omega.
        let shift = -(decay / omega).atan() / omega;
        assert!(peaks.len() > 10);
        for (n, peak) in peaks.iter().enumerate() {
            let time = (n + 1) as f64 * period + shift;
            let height = 0.2 * (-decay * time).exp() * (omega * shift).cos();
            // What the parabola neglects: third derivative by damping, fourth by the cosine.
            let tolerance = decay * STEP.powi(2) / 3.0 + (omega * STEP).powi(2) / 24.0 * STEP;
            assert!((peak.time - time).abs() < tolerance, "{n}: {peak:?}");
            assert!((peak.height / height - 1.0).abs() < 1e-5, "{n}: {peak:?}");
        }
    }

    /// A tip that swings about nearly straight down on a circle: with each swing it passes the
    /// lowest point twice, and rises between.
    fn beyond_straight_down(t: f64, period: f64) -> f64 {
        let rest = 75f64.to_radians();
        let angle = rest - rest * (-0.12 * t).exp() * (TAU * t / period).cos();
        -0.2 * (angle.sin() - rest.sin())
    }

    #[test]
    fn a_bump_in_the_trough_is_no_upper_peak_even_above_rest() {
        let period = 0.83;
        let excursion = sampled(|t| beyond_straight_down(t, period));
        let bump = local_maxima(excursion.values())[0];
        assert!(bump.abs_diff(42) < 5 && excursion.values()[bump] > 0.05, "a bump to be refused");
        // The spectrum gives the period well; a fifth beyond it, either way, changes nothing.
        for given in [0.8 * period, period, 1.2 * period] {
            let peaks = upper_peaks(&excursion, given, &PeakRules::default());
            assert!(peaks.len() >= 15, "{}", peaks.len());
            for (n, peak) in peaks.iter().enumerate() {
                let error = peak.time - (n + 1) as f64 * period;
                assert!(error.abs() < 0.02 * period, "{n}: {peak:?}, given {given}");
            }
        }
    }

    /// A swing with a bump, whose period falls from 0.99 to 0.8 s as it decays.
    #[test]
    fn a_period_that_drifts_loses_no_peak() {
        let decay = |t: f64| (-0.12 * t).exp();
        let turns = |t: f64| t / 0.8 - 2.0 * (1.0 - decay(t));
        let excursion = sampled(|t| {
            let phase = TAU * turns(t);
            decay(t) * (phase.cos() + 0.4 * (2.0 * phase).cos())
        });
        let peaks = upper_peaks(&excursion, 0.85, &PeakRules::default());
        assert_eq!(peaks.len(), turns(excursion.duration()).floor() as usize);
        assert!(peaks.windows(2).all(|pair| pair[1].height < pair[0].height));
    }

    #[test]
    fn noise_adds_no_peak_to_a_swing_that_dies_in_it() {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64 - 0.5
        };
        let z: Vec<f64> =
            (0..6000).map(|i| beyond_straight_down(STEP * i as f64, 0.83) + 1e-3 * noise()).collect();
        let excursion = Excursion::about(0.0, &z, STEP).unwrap();
        let peaks = upper_peaks(&excursion, 0.83, &PeakRules::default());
        assert!(peaks.len() > 13, "{}", peaks.len());
        for (n, peak) in peaks.iter().enumerate() {
            let error = peak.time / 0.83 - (n + 1) as f64;
            assert!(error.abs() < 0.25, "{n}: {peak:?}"); // the last tops are flat as the noise
        }
    }

    #[test]
    fn prominence_counts_down_to_the_higher_saddle() {
        let values = [0.0, 5.0, 1.0, 3.0, 2.0, 7.0, 0.0];
        assert_eq!(local_maxima(&values), [1, 3, 5]);
        assert_eq!([1, 3, 5].map(|top| prominence(&values, top)), [4.0, 1.0, 7.0]);
    }

    #[test]
    fn a_flat_top_is_one_peak_in_its_middle() {
        let values = [0.0, 2.0, 2.0, 2.0, 0.0, 1.0, 1.0];
        assert_eq!(local_maxima(&values), [2]);
        let peak = refined(&[0.0, 3.0, 3.0, 0.0], 1, 1.0);
        assert!((peak.time - 1.5).abs() < 1e-15 && peak.height > 3.0, "{peak:?}");
    }
}
