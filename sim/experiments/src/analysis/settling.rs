//! How long the tip takes to come to rest.

use super::{AnalysisError, Excursion};

/// Time after which the tip stays within a `fraction` of its largest excursion from the rest, s.
///
/// The last crossing of the band's edge, between samples by a straight line; 0.02 and 0.05 are
/// usual fractions. The first sample is the release.
/// # Errors
/// [`AnalysisError::BeginsAtRest`]; [`AnalysisError::NotSettled`] if the last sample is outside.
pub fn settling_time(excursion: &Excursion, fraction: f64) -> Result<f64, AnalysisError> {
    let largest = excursion.values().iter().fold(0.0f64, |most, value| most.max(value.abs()));
    if largest == 0.0 {
        return Err(AnalysisError::BeginsAtRest);
    }
    settles_within(excursion, fraction * largest)
}

/// The same within a band on either side of the rest, m.
/// # Errors
/// [`AnalysisError::NotSettled`] if the last sample is outside.
pub fn settles_within(excursion: &Excursion, band: f64) -> Result<f64, AnalysisError> {
    let values = excursion.values();
    let Some(last) = values.iter().rposition(|value| value.abs() > band) else {
        return Ok(0.0);
    };
    if last + 1 == values.len() {
        let end = excursion.duration();
        return Err(AnalysisError::NotSettled { last: values[last].abs(), end, band });
    }
    let (outside, inside) = (values[last], values[last + 1]);
    let edge = band.copysign(outside);
    let part = (outside - edge) / (outside - inside);
    Ok((last as f64 + part) * excursion.step())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pure_decay_settles_after_its_logarithm() {
        let step = 0.01;
        let z: Vec<f64> = (0..1000).map(|i| -0.2 * (-1.3 * step * i as f64).exp()).collect();
        let excursion = Excursion::about(0.0, &z, step).unwrap();
        for fraction in [0.02, 0.05] {
            let time = settling_time(&excursion, fraction).unwrap();
            // A chord instead of the exponential: (1.3 step)² / 8 of the band.
            assert!((time + f64::ln(fraction) / 1.3).abs() < (1.3 * step).powi(2) / 8.0 / 1.3);
        }
    }

    /// The last time outside counts, also below the rest and after the first time inside.
    #[test]
    fn the_last_crossing_counts_on_either_side() {
        let z = [1.0, 0.01, -0.5, 0.02, -0.10, 0.0, 0.04];
        let excursion = Excursion::about(0.0, &z, 1.0).unwrap();
        assert!((settling_time(&excursion, 0.05).unwrap() - 4.5).abs() < 1e-15);
    }

    #[test]
    fn a_swing_that_goes_on_and_a_tip_at_rest_are_errors() {
        let swinging = Excursion::about(0.0, &[1.0, -0.9, 0.8], 0.5).unwrap();
        assert_eq!(
            settling_time(&swinging, 0.02).unwrap_err().to_string(),
            "not settled: 8.000e-1 m from rest at the end, 1.000 s, outside of 2.000e-2 m; \
             try a longer recording or check the rest"
        );
        let resting = Excursion::about(0.0, &[0.0; 3], 0.5).unwrap();
        assert_eq!(settling_time(&resting, 0.02), Err(AnalysisError::BeginsAtRest));
    }
}
