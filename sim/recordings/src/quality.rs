//! How well a marker was seen: lost samples, gaps, extent, noise.

use super::Marker;
use super::clock::plain;
use super::noise::variances;

/// Differences that an estimate of noise needs.
const LEAST_DIFFERENCES: usize = 20;
/// Markers with losses that findings name one by one.
const NAMED: usize = 10;

/// How well a marker was seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Samples without a position.
    pub lost: usize,
    /// Samples in the longest gap.
    pub longest_gap: usize,
    /// First sample of the longest gap.
    pub longest_gap_at: usize,
    /// Lowest and highest value of each coordinate, m; nothing if it was never seen.
    pub extent: Option<[[f64; 2]; 3]>,
    /// Standard deviation of the noise of each coordinate, m; nothing if it was hardly seen.
    ///
    /// By the median of third differences, so that the quiet parts count and swings do not. What moves
    /// fast against the sampling all the time is taken for noise: an upper estimate.
    pub noise: Option<[f64; 3]>,
}

impl Marker {
    /// How well it was seen.
    pub fn quality(&self) -> Quality {
        let (longest_gap, longest_gap_at) = longest_gap(&self.position);
        Quality {
            lost: lost(&self.position),
            longest_gap,
            longest_gap_at,
            extent: extent(&self.position),
            noise: variances(&self.position, LEAST_DIFFERENCES, |_| true).map(|v| v.map(f64::sqrt)),
        }
    }
}

fn lost(position: &[Option<[f64; 3]>]) -> usize {
    position.iter().filter(|position| position.is_none()).count()
}

/// Length and first sample.
fn longest_gap(position: &[Option<[f64; 3]>]) -> (usize, usize) {
    let (mut longest, mut run) = ((0, 0), 0);
    for (sample, position) in position.iter().enumerate() {
        run = if position.is_none() { run + 1 } else { 0 };
        if run > longest.0 {
            longest = (run, sample + 1 - run);
        }
    }
    longest
}

pub(super) fn extent(position: &[Option<[f64; 3]>]) -> Option<[[f64; 2]; 3]> {
    let mut seen = position.iter().flatten();
    let first = seen.next()?.map(|value| [value, value]);
    Some(seen.fold(first, |mut extent, position| {
        for (range, value) in extent.iter_mut().zip(position) {
            *range = [range[0].min(*value), range[1].max(*value)];
        }
        extent
    }))
}

/// What is to be said of lost samples, those with most of them first.
pub(super) fn losses(markers: &[Marker], time: &[f64]) -> Vec<String> {
    let mut lossy: Vec<(usize, &Marker)> =
        markers.iter().map(|marker| (lost(&marker.position), marker)).filter(|(lost, _)| *lost > 0).collect();
    lossy.sort_by_key(|(lost, _)| std::cmp::Reverse(*lost));
    let samples = time.len();
    let mut findings: Vec<String> = (lossy.iter().take(NAMED))
        .map(|(lost, marker)| {
            let (gap, at) = longest_gap(&marker.position);
            if *lost == samples {
                format!("marker `{}` is lost in all samples", marker.name)
            } else {
                format!(
                    "marker `{}`: {lost} of {samples} samples lost ({:.2} %), longest gap {gap} from {} s on",
                    marker.name,
                    100.0 * *lost as f64 / samples as f64,
                    plain(time[at]),
                )
            }
        })
        .collect();
    if lossy.len() > NAMED {
        let others = &lossy[NAMED..];
        let sum: usize = others.iter().map(|(lost, _)| lost).sum();
        findings.push(format!("{} other markers lost {sum} samples in all", others.len()));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_found_under_a_slow_swing() {
        // Uniform in ±1e-5 m by a linear congruence, on a swing of 1 Hz, 50 mm, at 100 Hz.
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let position: Vec<_> = (0..2000)
            .map(|k| {
                let swing = 0.05 * (0.01 * k as f64 * std::f64::consts::TAU).sin();
                Some([swing + 1e-5 * (2.0 * random() - 1.0), 0.0, 3e-4 * (2.0 * random() - 1.0)])
            })
            .collect();
        let marker = Marker { name: "tip".to_owned(), position, orientation: None };
        let noise = marker.quality().noise.unwrap();
        // Deviation of a uniform distribution: half its width over √3. The swing leaves third
        // differences of 0.05 (0.01 · 2π)³ = 1.2e-5 m at most, as much as a quarter of the noise's.
        let expected = [1e-5 / 3.0_f64.sqrt(), 0.0, 3e-4 / 3.0_f64.sqrt()];
        for axis in 0..3 {
            let tolerance = 0.15 * expected[axis]; // median of 2000, and the uniform's flatter shape
            assert!((noise[axis] - expected[axis]).abs() <= tolerance, "{noise:?}");
        }
    }

    #[test]
    fn gaps_and_extents() {
        let at = |x: f64| Some([x, 0.0, -x]);
        let position = vec![at(1.0), None, at(2.0), None, None, at(-1.0), None];
        let quality = Marker { name: String::new(), position, orientation: None }.quality();
        assert_eq!((quality.lost, quality.longest_gap, quality.longest_gap_at), (4, 2, 3));
        assert_eq!(quality.extent, Some([[-1.0, 2.0], [0.0, 0.0], [-2.0, 1.0]]));
        assert_eq!(quality.noise, None);
    }
}
