//! Upper peaks of a swing: in each period the turning point that is farthest on the positive side.
//!
//! **Trap**: where the tip passes beyond straight down (15 psi in the paper), it rises again near its lower turning point,
//! and `z(t)` has a second local maximum in each swing, which may lie above the rest. Higher modes add ripples. So the
//! excursion is first smoothed over one period, which removes all harmonics of the swing and most of the higher modes.
//! What is left has one maximum in each period. The upper peak is the highest sample within a quarter of a period of it. Both
//! move continuously with every parameter of a model.

use std::f64::consts::PI;

use super::Excursion;

/// A local maximum of an excursion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Time since release, s.
    pub time: f64,
    /// Distance from the rest, m, positive on the side of the coordinate.
    pub height: f64,
    /// Where the swing turns, s: the maximum of the smoothed excursion, moved by what all of them lie before or after their
    /// highest samples in the median. A crest with two tops of nearly the same height moves it little, and `time` by their
    /// distance. Periods are measured between turns.
    pub turn: f64,
}

/// Least swing of a peak, as a fraction of the range of the excursion: noise and the tail of a decay stay below it.
const LEAST_SWING: f64 = 0.01;
/// Share of a steady swing that smoothing over its period leaves.
const LEFT: f64 = 0.5;

/// Upper peaks, in order of time; `period` in s, from the damped frequency. The period may differ by a quarter from it.
///
/// Refined between samples by the parabola through the highest three. The release itself, the first sample, is none. With
/// fifty samples a period and a damping ratio of 0.05 the refined height is good to 2e-5 of itself and the time to 4e-5
/// periods; both errors fall with damping. A peak in the last quarter of a period is left out: what follows is not known.
/// Linear in the number of samples.
pub fn upper_peaks(excursion: &Excursion, period: f64) -> Vec<Peak> {
    let values = excursion.values();
    let half = (0.5 * period / excursion.step()).round() as usize;
    if half == 0 || half >= values.len() {
        return Vec::new();
    }
    let smooth = smoothed(values, half);
    let [low, high] = extremes(values);
    let least = LEAST_SWING * LEFT * (high - low);
    // A quarter of a period on either side, and three samples.
    let reach = (half / 2).max(1);
    let is_top = |&i: &usize| smooth[i - 1] < smooth[i] && smooth[i] >= smooth[i + 1];
    let swings = |&i: &usize| {
        let around = &smooth[i.saturating_sub(half)..(i + half + 1).min(smooth.len())];
        smooth[i] - extremes(around)[0] >= least
    };
    let tops = (reach..(values.len() - 1).max(reach)).filter(is_top).filter(swings);
    let is_whole = |i: usize| i >= half && i + half < values.len();
    // Each with the time of its smoothed maximum, where no reflection at an end is in that.
    let mut found: Vec<(Peak, Option<f64>)> = tops
        .filter_map(|i| {
            let (time, height) = refined(values, highest(values, [i - reach, i + reach])?, excursion.step());
            let smooth = is_whole(i).then(|| refined(&smooth, i, excursion.step()).0);
            Some((Peak { time, height, turn: time }, smooth))
        })
        .collect();
    let mut shifts: Vec<f64> =
        found.iter().filter_map(|(peak, smooth)| Some(peak.time - (*smooth)?)).collect();
    shifts.sort_by(f64::total_cmp);
    if let Some(&shift) = shifts.get(shifts.len() / 2) {
        for (peak, smooth) in &mut found {
            peak.turn = smooth.map_or(peak.time, |time| time + shift);
        }
    }
    found.into_iter().map(|(peak, _)| peak).collect()
}

/// The highest sample between two, where it is a local maximum.
fn highest(values: &[f64], [first, last]: [usize; 2]) -> Option<usize> {
    let [first, last] = [first.max(1), last.min(values.len() - 2)];
    let top = (first..=last).max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a)))?;
    let flat = values[top..].iter().take_while(|&&value| value == values[top]).count();
    let after = top + flat;
    let is_peak = values[top - 1] < values[top] && after < values.len() && values[after] < values[top];
    is_peak.then_some(top + (flat - 1) / 2)
}

fn extremes(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| [low.min(value), high.max(value)])
}

/// The mean about each sample, weighted by `1 + cos(π j / half)` over `half` samples to either side; beyond its ends the
/// excursion is reflected. By running sums: linear in the number of samples, whatever the width.
fn smoothed(values: &[f64], half: usize) -> Vec<f64> {
    let samples = values.len();
    let turn = PI / half as f64;
    let reflected = |i: usize| match i {
        before if before < half => values[half - before],
        after if after >= samples + half => values[2 * (samples - 1) - (after - half)],
        inside => values[inside - half],
    };
    // Angles are reduced to one period, so that they stay exact.
    let angle = |i: usize| (turn * (i % (2 * half)) as f64).sin_cos();
    let mut sums = Vec::with_capacity(samples + 2 * half + 1);
    let mut sum = [0.0; 3];
    sums.push(sum);
    for i in 0..samples + 2 * half {
        let (value, (sin, cos)) = (reflected(i), angle(i));
        sum = [sum[0] + value, sum[1] + value * cos, sum[2] + value * sin];
        sums.push(sum);
    }
    let at = |i: usize| {
        let [mean, even, odd] = [0, 1, 2].map(|k| sums[i + 2 * half + 1][k] - sums[i][k]);
        let (sin, cos) = angle(i + half);
        (mean + cos * even + sin * odd) / (2 * half) as f64
    };
    (0..samples).map(at).collect()
}

/// Time and height of the vertex of the parabola through a local maximum and its neighbours.
pub(super) fn refined(values: &[f64], top: usize, step: f64) -> (f64, f64) {
    let [before, here, after] = [values[top - 1], values[top], values[top + 1]];
    let bend = before - 2.0 * here + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    ((top as f64 + shift) * step, here - 0.25 * (before - after) * shift)
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
        let peaks = upper_peaks(&sampled(|t| 0.2 * (-decay * t).exp() * (omega * t).cos()), period);
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
            assert!((peak.turn - time).abs() < 1e-4 * period, "{n}: {peak:?}");
        }
    }

    /// A crest whose two tops are of the same height: the higher one changes with a share of one in a thousand, and with it the
    /// time of the peak, but not where the swing turns.
    #[test]
    fn a_swing_turns_between_the_two_tops_of_a_crest() {
        let period = 0.8;
        let turns = |tilt: f64| -> Vec<Peak> {
            let swing = |t: f64| {
                let phase = TAU * t / period;
                (-0.1 * t).exp() * (phase.cos() - 0.4 * (3.0 * phase + tilt).cos())
            };
            upper_peaks(&sampled(swing), period)
        };
        let (a, b) = (turns(-0.05), turns(0.05));
        assert!(a.len() > 10 && a.len() == b.len());
        let most = |of: fn(&Peak) -> f64| {
            let periods =
                |all: &[Peak]| all.windows(2).map(|two| of(&two[1]) - of(&two[0])).collect::<Vec<_>>();
            let between = periods(&a).into_iter().zip(periods(&b));
            between.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!((a[3].time - b[3].time).abs() > 0.1 * period, "two tops: {:?} {:?}", a[3], b[3]);
        assert!(most(|peak| peak.turn) < 0.005 * period, "{}", most(|peak| peak.turn));
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
        let bump = highest(excursion.values(), [30, 55]).unwrap();
        assert!(bump.abs_diff(42) < 5 && excursion.values()[bump] > 0.05, "a bump to be refused");
        // The spectrum gives the period well; a fifth beyond it, either way, changes nothing.
        for given in [0.8 * period, period, 1.2 * period] {
            let peaks = upper_peaks(&excursion, given);
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
        let period = 0.85;
        let peaks = upper_peaks(&excursion, period);
        assert_eq!(peaks.len(), turns(excursion.duration() - 0.25 * period).floor() as usize);
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
        let peaks = upper_peaks(&excursion, 0.83);
        assert!(peaks.len() > 13, "{}", peaks.len());
        for (n, peak) in peaks.iter().enumerate() {
            let error = peak.time / 0.83 - (n + 1) as f64;
            assert!(error.abs() < 0.25, "{n}: {peak:?}"); // the last tops are flat as the noise
        }
    }

    /// A ripple of six times the frequency, and one at which each bump in the trough is as high as the peaks: heights move as
    /// little as the signal does.
    #[test]
    fn heights_are_continuous_in_what_is_added() {
        let heights = |second: f64, sixth: f64| -> Vec<f64> {
            let swing = |t: f64| {
                let phase = TAU * t / 0.8;
                (-0.2 * t).exp() * (phase.cos() + second * (2.0 * phase).cos() + sixth * (6.3 * phase).cos())
            };
            upper_peaks(&sampled(swing), 0.8).iter().map(|peak| peak.height).collect()
        };
        for k in 0..200 {
            let share = f64::from(k) / 200.0;
            let (here, next) = (heights(share, 0.3 * share), heights(share + 0.005, 0.3 * share + 0.0015));
            assert_eq!(here.len(), next.len(), "{share}");
            // Each moves by what is added, and by the parabola's error in a ripple.
            assert!(
                here.iter().zip(&next).all(|(a, b)| (a - b).abs() < 0.0065 + 0.01),
                "{share}: {here:?} {next:?}"
            );
        }
    }

    /// The weights of the mean add up to one, and a running sum is as good as the sum itself.
    #[test]
    fn smoothing_is_a_weighted_mean() {
        let values: Vec<f64> = (0..200).map(|i| f64::from(i * i % 37)).collect();
        let (half, smooth) = (11usize, smoothed(&values, 11));
        for i in half..values.len() - half {
            let weight = |j: usize| 1.0 + (PI * (j as f64 - half as f64) / half as f64).cos();
            let sum: f64 = (0..=2 * half).map(|j| weight(j) * values[i + j - half]).sum();
            assert!((smooth[i] - sum / (2 * half) as f64).abs() < 1e-10);
        }
        assert!(smoothed(&[3.0; 50], 7).iter().all(|value| (value - 3.0).abs() < 1e-12));
    }

    #[test]
    fn a_flat_top_is_one_peak_in_its_middle() {
        let values = [0.0, 2.0, 2.0, 2.0, 0.0, 1.0, 1.0];
        assert_eq!(highest(&values, [1, 4]), Some(2));
        assert_eq!(highest(&values, [4, 6]), None);
        let (time, height) = refined(&[0.0, 3.0, 3.0, 0.0], 1, 1.0);
        assert!((time - 1.5).abs() < 1e-15 && height > 3.0, "{time} {height}");
    }

    /// Half a million samples with a maximum in every other one. Work that grows with the square of that takes minutes.
    #[test]
    fn half_a_million_samples_are_no_work() {
        let z: Vec<f64> =
            (0..500_000).map(|i| (0.02 * f64::from(i)).cos() + 0.2 * f64::from(i % 2)).collect();
        let excursion = Excursion::about(0.0, &z, 1.0).unwrap();
        assert_eq!(upper_peaks(&excursion, TAU / 0.02).len(), 1591);
    }
}
