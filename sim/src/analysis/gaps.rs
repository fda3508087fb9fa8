//! Short gaps bridged, for the spectrum alone: a transform needs every sample of an even clock.
//!
//! A cubic through two samples on either side. A gap that is longer than admitted is not bridged: what
//! comes after it is left out. Fits by least squares need none of this and see the gaps as they are.

use super::AnalysisError;

/// Evenly sampled values, and what of them was not measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridged {
    /// Values, one every `step` from time 0.
    pub values: Vec<f64>,
    /// Time between samples, s.
    pub step: f64,
    /// Samples that fall into gaps.
    pub filled: usize,
    /// Longest gap that was bridged, s; 0 if there is none.
    pub longest: f64,
    /// Time after which all is left out because a longer gap begins, s.
    pub cut_at: Option<f64>,
}

/// Values on an even clock from time 0 to the last that was seen; `longest` is the longest gap to
/// bridge, s, over which a cubic must still be good.
/// # Errors
/// [`AnalysisError::TooShort`] below four samples from time 0 on; [`AnalysisError::Step`].
pub fn bridge(
    time: &[f64],
    values: &[Option<f64>],
    step: f64,
    longest: f64,
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
        if gap > longest.max(1.5 * step) && at > before {
            bridged.cut_at = Some(before);
            break;
        }
        if gap > 1.5 * step && at > before + 0.25 * step && at < seen[next].0 - 0.25 * step {
            bridged.filled += 1;
            bridged.longest = bridged.longest.max(gap);
        }
        bridged.values.push(cubic(&seen[next.saturating_sub(2)..(next + 2).min(seen.len())], at));
    }
    match bridged.values.len() {
        samples @ 0..4 => Err(AnalysisError::TooShort { samples, least: 4 }),
        _ => Ok(bridged),
    }
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

    fn swing(t: f64) -> f64 {
        (-0.2 * t).exp() * (8.0 * t).cos()
    }

    #[test]
    fn gaps_and_an_uneven_start_are_bridged_and_counted() {
        let time: Vec<f64> = (0..500).map(|i| 0.01 * i as f64 - 0.2037).collect();
        let lost = |i: usize| (100..106).contains(&i) || i == 200;
        let values: Vec<_> = time.iter().enumerate().map(|(i, t)| (!lost(i)).then(|| swing(*t))).collect();
        let bridged = bridge(&time, &values, 0.01, 0.1).unwrap();
        assert_eq!((bridged.filled, bridged.cut_at), (7, None));
        assert!((bridged.longest - 0.07).abs() < 1e-9, "{bridged:?}");
        for (k, value) in bridged.values.iter().enumerate() {
            // A cubic's error, (8 rad/s)⁴/4! of the product of distances: at most 35 ms twice, 45 ms twice.
            assert!((value - swing(0.01 * k as f64)).abs() < 4e-4, "{k}");
        }
    }

    #[test]
    fn a_long_gap_ends_what_is_used() {
        let time: Vec<f64> = (0..300).map(|i| 0.01 * i as f64).collect();
        let values: Vec<_> =
            time.iter().enumerate().map(|(i, t)| (!(150..190).contains(&i)).then(|| swing(*t))).collect();
        let bridged = bridge(&time, &values, 0.01, 0.1).unwrap();
        assert_eq!(bridged.values.len(), 150);
        assert_eq!(bridged.cut_at, Some(time[149]));
        assert!(bridge(&time, &vec![None; 300], 0.01, 0.1).is_err());
    }
}
