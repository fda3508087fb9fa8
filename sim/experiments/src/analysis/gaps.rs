//! Short gaps bridged, for the spectrum alone: a transform needs every sample of an even clock.
//!
//! A gap of a few samples by the cubic through two samples on either side; a longer one, which would
//! magnify their noise, by a swing of the known frequency and its harmonic, growing or decaying, fitted
//! to what is seen within a period on either side. A gap that is longer than admitted is not bridged:
//! what comes after it is left out. Fits by least squares need none of this and see the gaps as they are.

use nalgebra::{DMatrix, DVector};

use super::AnalysisError;

/// Gap, in samples, up to which a cubic does.
const FEW: f64 = 6.5;
/// The same in periods.
const SHORT: f64 = 0.1;
/// Terms of the swing that is fitted.
const TERMS: usize = 8;

/// Evenly sampled values, and what of them was not measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridged {
    /// Values, one every `step` from time 0.
    pub values: Vec<f64>,
    /// Time between samples, s.
    pub step: f64,
    /// Samples that were lost and are bridged.
    pub filled: usize,
    /// Longest gap that was bridged, s; 0 if there is none.
    pub longest: f64,
    /// Time after which all is left out because a longer gap begins, s.
    pub cut_at: Option<f64>,
}

/// Values on an even clock from time 0 to the last that was seen; `longest` is the longest gap to
/// bridge, s; `frequency` that of the swing, rad/s, without which only a cubic is there.
/// # Errors
/// [`AnalysisError::TooShort`] below four samples from time 0 on; [`AnalysisError::Step`].
pub fn bridge(
    time: &[f64],
    values: &[Option<f64>],
    step: f64,
    longest: f64,
    frequency: Option<f64>,
) -> Result<Bridged, AnalysisError> {
    if !(step > 0.0 && step.is_finite()) {
        return Err(AnalysisError::Step { step });
    }
    let seen: Vec<(f64, f64)> = time.iter().zip(values).filter_map(|(t, v)| Some((*t, (*v)?))).collect();
    let after = seen.iter().filter(|(t, _)| *t >= -0.5 * step).count();
    if after < 4 {
        return Err(AnalysisError::TooShort { samples: after, least: 4 });
    }
    let end = seen[seen.len() - 1].0;
    let mut bridged = Bridged { values: Vec::new(), step, filled: 0, longest: 0.0, cut_at: None };
    for k in 0..=((end / step) * (1.0 + 1e-12)).floor() as usize {
        let at = step * k as f64;
        let next = seen.partition_point(|(t, _)| *t < at).clamp(1, seen.len() - 1);
        let (before, gap) = (seen[next - 1].0, seen[next].0 - seen[next - 1].0);
        if gap > longest.max(1.5 * step) && at > before && at < seen[next].0 {
            bridged.cut_at = Some(before);
            break;
        }
        let near = &seen[next.saturating_sub(2)..(next + 2).min(seen.len())];
        let is_long =
            |omega: &f64| gap > (FEW * step).min(SHORT * std::f64::consts::TAU / omega).max(1.5 * step);
        let fitted = frequency.filter(|omega| is_long(omega) && at > before);
        let value = fitted.and_then(|omega| swing(&seen, at, omega)).unwrap_or_else(|| cubic(near, at));
        bridged.values.push(value);
    }
    let until = bridged.cut_at.unwrap_or(end);
    for pair in seen.windows(2).filter(|pair| pair[1].0 > 0.0 && pair[1].0 <= until) {
        let gap = pair[1].0 - pair[0].0;
        if gap > 1.5 * step {
            bridged.filled += (gap / step).round() as usize - 1;
            bridged.longest = bridged.longest.max(gap);
        }
    }
    match bridged.values.len() {
        samples @ 0..4 => Err(AnalysisError::TooShort { samples, least: 4 }),
        _ => Ok(bridged),
    }
}

/// Stretches of values from time 0 on without a gap longer than that: the time of their first and last value.
pub fn stretches(time: &[f64], values: &[Option<f64>], longest: f64) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut last = None;
    for t in time.iter().zip(values).filter_map(|(t, value)| value.map(|_| *t)) {
        match found.last_mut().filter(|_| last.is_some_and(|last| t - last <= longest)) {
            Some(stretch) => stretch[1] = t,
            None => found.push([t, t]),
        }
        last = Some(t);
    }
    found.retain(|[_, to]| *to > 0.0);
    found.iter_mut().for_each(|[from, _]| *from = from.max(0.0));
    found
}

/// The swing fitted to the points within a period of a time; nothing if there are too few.
fn swing(seen: &[(f64, f64)], at: f64, omega: f64) -> Option<f64> {
    let period = std::f64::consts::TAU / omega;
    // What is held before the release is no swing.
    let from = seen.partition_point(|(t, _)| *t < (at - period).max(0.0));
    let to = seen.partition_point(|(t, _)| *t <= at + period);
    let near = seen.get(from..to)?;
    if near.len() < 2 * TERMS {
        return None;
    }
    let row = |t: f64| -> [f64; TERMS] {
        let (u, phase) = ((t - at) / period, omega * (t - at));
        let (sin, cos) = phase.sin_cos();
        let (sin_2, cos_2) = (2.0 * phase).sin_cos();
        [1.0, u, cos, sin, u * cos, u * sin, cos_2, sin_2]
    };
    let matrix = DMatrix::from_fn(near.len(), TERMS, |i, k| row(near[i].0)[k]);
    let right = DVector::from_iterator(near.len(), near.iter().map(|point| point.1));
    let terms = matrix.svd(true, true).solve(&right, 1e-9).ok()?;
    Some(row(at).iter().zip(terms.iter()).map(|(a, b)| a * b).sum())
}

/// The polynomial through some points.
fn cubic(points: &[(f64, f64)], at: f64) -> f64 {
    let weight = |k: usize| -> f64 {
        let others = points.iter().enumerate().filter(|(other, _)| *other != k);
        others.map(|(_, other)| (at - other.0) / (points[k].0 - other.0)).product()
    };
    points.iter().enumerate().map(|(k, point)| weight(k) * point.1).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decaying(t: f64) -> f64 {
        (-0.2 * t).exp() * (8.0 * t).cos()
    }

    #[test]
    fn gaps_and_an_uneven_start_are_bridged_and_counted() {
        let time: Vec<f64> = (0..500).map(|i| 0.01 * i as f64 - 0.2037).collect();
        let lost = |i: usize| (100..106).contains(&i) || i == 200;
        let values: Vec<_> = time.iter().enumerate().map(|(i, t)| (!lost(i)).then(|| decaying(*t))).collect();
        let bridged = bridge(&time, &values, 0.01, 0.1, None).unwrap();
        assert_eq!((bridged.filled, bridged.cut_at), (7, None));
        assert!((bridged.longest - 0.07).abs() < 1e-9, "{bridged:?}");
        for (k, value) in bridged.values.iter().enumerate() {
            // A cubic's error, (8 rad/s)⁴/4! of the product of distances: at most 35 ms twice, 45 ms twice.
            assert!((value - decaying(0.01 * k as f64)).abs() < 4e-4, "{k}");
        }
    }

    /// A fifth of a period is lost, under noise of a hundredth of the swing: what two samples on either
    /// side say of the slope would be off by a tenth.
    #[test]
    fn a_longer_gap_is_bridged_by_the_swing_itself() {
        let mut noise = crate::cleaning::tests::Noise::new(4);
        let time: Vec<f64> = (0..500).map(|i| 0.01 * i as f64).collect();
        let lost = |i: usize| (100..120).contains(&i) || (203..223).contains(&i);
        let values: Vec<_> = time
            .iter()
            .enumerate()
            .map(|(i, t)| (!lost(i)).then(|| decaying(*t) + 0.01 * noise.normal()))
            .collect();
        let bridged = bridge(&time, &values, 0.01, 0.3, Some(8.1)).unwrap();
        assert_eq!((bridged.filled, bridged.cut_at), (40, None));
        for i in (0..500).filter(|i| lost(*i)) {
            assert!((bridged.values[i] - decaying(time[i])).abs() < 0.03, "{i}: {}", bridged.values[i]);
        }
    }

    #[test]
    fn a_long_gap_ends_what_is_used() {
        let time: Vec<f64> = (0..300).map(|i| 0.01 * i as f64).collect();
        let values: Vec<_> =
            time.iter().enumerate().map(|(i, t)| (!(150..190).contains(&i)).then(|| decaying(*t))).collect();
        let bridged = bridge(&time, &values, 0.01, 0.1, None).unwrap();
        assert_eq!(bridged.values.len(), 150);
        assert_eq!(bridged.cut_at, Some(time[149]));
        assert!(bridge(&time, &vec![None; 300], 0.01, 0.1, None).is_err());
    }
}
