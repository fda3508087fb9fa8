//! Damping from the upper peaks of a swing: one ratio for all by the paper's fit, and one a cycle.
//!
//! ```text
//! A(t) = A0 / √(1 − ζ²) exp(−ζ ω_d t / √(1 − ζ²))     eq. 6
//! ω_n = ω_d / √(1 − ζ²)                               eq. 7
//! ```
//!
//! The exponent of eq. 6 is printed with the root and `t` out of place; so it must read, since
//! `ζ ω_n t` is meant. A fit of all peaks assumes a ratio that does not depend on amplitude. Where
//! air drag or friction act it does, and [`cycles`] shows it.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Modeling, eqs. 6 and 7.

use std::f64::consts::TAU;

use super::{
    AnalysisError,
    nelder_mead::{Stalled, minimize},
    peaks::Peak,
};

/// Eq. 6 fitted to upper peaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// A0 of eq. 6, m. Peaks lie below the envelope of a damped cosine by `√(1 − ζ²)`, so that of a
    /// linear swing released at rest from `z0` this is `z0 √(1 − ζ²)`.
    pub initial_amplitude: f64,
    /// ζ, dimensionless; negative if the swing grows.
    pub damping_ratio: f64,
    /// ω_d as given, rad/s.
    pub damped_frequency: f64,
    /// ω_n by eq. 7, rad/s.
    pub natural_frequency: f64,
    /// Root mean square distance of the peaks from the curve, m.
    pub rms_residual: f64,
}

impl Decay {
    /// A(t) of eq. 6, m, at a time since release, s.
    pub fn envelope(&self, time: f64) -> f64 {
        eq_6(self.initial_amplitude, self.damping_ratio, self.damped_frequency, time)
    }
}

fn eq_6(amplitude: f64, ratio: f64, damped_frequency: f64, time: f64) -> f64 {
    let root = (1.0 - ratio * ratio).sqrt();
    amplitude / root * (-ratio * damped_frequency * time / root).exp()
}

/// Eq. 6 fitted by least squares to the peaks above rest; damped frequency in rad/s.
///
/// # Errors
/// [`AnalysisError::TooFewPeaks`] below three, which two unknowns would fit without a residual;
/// [`AnalysisError::SearchStalled`].
pub fn fit_decay(peaks: &[Peak], damped_frequency: f64) -> Result<Decay, AnalysisError> {
    let peaks = above_rest(peaks, 3)?;
    let (first, last) = (peaks[0], peaks[peaks.len() - 1]);
    let squares = |amplitude: f64, ratio: f64| -> f64 {
        let model = |time| eq_6(amplitude, ratio, damped_frequency, time);
        peaks.iter().map(|peak| (peak.height - model(peak.time)).powi(2)).sum()
    };

    // First and last peak give a start; parameters and cost are then of order one.
    let rate = (first.height / last.height).ln() / (last.time - first.time);
    let start = rate / rate.hypot(damped_frequency);
    let scale = first.height * (rate * first.time).exp();
    let total: f64 = peaks.iter().map(|peak| peak.height * peak.height).sum();
    let per_cent = 0.01;
    let cost = |p: &[f64]| squares(scale * p[0], per_cent * p[1]) / total;
    let stalled = |Stalled { evaluations }| AnalysisError::SearchStalled {
        wanted: "amplitude and damping ratio",
        evaluations,
    };
    let minimum = minimize(&[1.0, start / per_cent], cost).map_err(stalled)?;

    let initial_amplitude = scale * minimum.parameters[0];
    let damping_ratio = per_cent * minimum.parameters[1];
    Ok(Decay {
        initial_amplitude,
        damping_ratio,
        damped_frequency,
        natural_frequency: natural_frequency(damped_frequency, damping_ratio),
        rms_residual: (squares(initial_amplitude, damping_ratio) / peaks.len() as f64).sqrt(),
    })
}

/// Eq. 7: ω_n from ω_d, both in rad/s.
pub fn natural_frequency(damped_frequency: f64, damping_ratio: f64) -> f64 {
    damped_frequency / (1.0 - damping_ratio * damping_ratio).sqrt()
}

/// From one upper peak to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Midway between the two peaks, s since release.
    pub time: f64,
    /// Geometric mean of their heights above rest, m.
    pub amplitude: f64,
    /// ζ from the logarithmic decrement δ of the two: `δ / √(4π² + δ²)`.
    pub damping_ratio: f64,
    /// ω_d: 2π over the time between the two, rad/s.
    pub damped_frequency: f64,
    /// ω_n by eq. 7, rad/s.
    pub natural_frequency: f64,
}

/// Damping and frequency cycle by cycle, hence against amplitude.
///
/// An error of the rest shifts every height, and matters most for the last, small ones.
/// # Errors
/// [`AnalysisError::TooFewPeaks`] below two peaks above rest.
pub fn cycles(peaks: &[Peak]) -> Result<Vec<Cycle>, AnalysisError> {
    let between = |pair: &[Peak]| {
        let [a, b] = [pair[0], pair[1]];
        let decrement = (a.height / b.height).ln();
        let damping_ratio = decrement / decrement.hypot(TAU);
        let damped_frequency = TAU / (b.time - a.time);
        Cycle {
            time: 0.5 * (a.time + b.time),
            amplitude: (a.height * b.height).sqrt(),
            damping_ratio,
            damped_frequency,
            natural_frequency: natural_frequency(damped_frequency, damping_ratio),
        }
    };
    Ok(above_rest(peaks, 2)?.windows(2).map(between).collect())
}

/// The peaks before the first that does not rise above rest, from where on there is no swing left.
fn above_rest(peaks: &[Peak], least: usize) -> Result<&[Peak], AnalysisError> {
    let found = peaks.iter().take_while(|peak| peak.height > 0.0).count();
    if found < least {
        return Err(AnalysisError::TooFewPeaks { found, least });
    }
    Ok(&peaks[..found])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Excursion;
    use crate::analysis::peaks::{PeakRules, upper_peaks};
    use crate::analysis::spectrum::{Window, amplitude_spectrum};

    /// Free swing of a second-order system, released at rest from 0.2 m; in the trough a harmonic
    /// that vanishes at the upper peaks makes a bump.
    fn swing(zeta: f64, bump: f64) -> Excursion {
        let (step, natural) = (0.01, 8.3);
        let damped = natural * (1.0 - zeta * zeta).sqrt();
        let z: Vec<f64> = (0..2000)
            .map(|i| {
                let t = step * i as f64;
                let phase = damped * t - zeta.asin();
                let harmonic = bump * (1.0 - phase.cos()).powi(2);
                let envelope = (-zeta * natural * t).exp() / (1.0 - zeta * zeta).sqrt();
                0.2 * envelope * (phase.cos() + harmonic)
            })
            .collect();
        Excursion::about(0.0, &z, step).unwrap()
    }

    fn recovered(excursion: &Excursion) -> (Vec<Peak>, Decay) {
        let damped = amplitude_spectrum(excursion, Window::Hann, 8).peak().unwrap().frequency;
        let peaks = upper_peaks(excursion, TAU / damped, &PeakRules::default());
        let decay = fit_decay(&peaks, damped).unwrap();
        (peaks, decay)
    }

    #[test]
    fn the_whole_way_recovers_a_known_swing() {
        for zeta in [0.005, 0.03, 0.08] {
            let (peaks, decay) = recovered(&swing(zeta, 0.0));
            // The spectrum's bias, measured as 0.005 ζ² and a little more for peaks and padding.
            let tolerance = 0.01 * zeta * zeta + 1e-5;
            let [ratio, natural] = [decay.damping_ratio / zeta, decay.natural_frequency / 8.3];
            assert!((ratio - 1.0).abs() < tolerance, "{zeta}: {decay:?}");
            assert!((natural - 1.0).abs() < tolerance, "{zeta}: {decay:?}");
            assert!(decay.rms_residual < 1e-4 * 0.2, "{zeta}: {decay:?}");
            for cycle in cycles(&peaks).unwrap() {
                assert!((cycle.damping_ratio - zeta).abs() < 1e-4, "{zeta}: {cycle:?}");
                assert!((cycle.natural_frequency / 8.3 - 1.0).abs() < 1e-4, "{zeta}: {cycle:?}");
            }
        }
    }

    #[test]
    fn a_bump_in_the_trough_changes_nothing() {
        let (zeta, bump) = (0.03, 0.4);
        let excursion = swing(zeta, bump);
        let trough = excursion.values()[38];
        assert!(excursion.values()[28] < trough && excursion.values()[50] < trough, "a bump");
        let (_, decay) = recovered(&excursion);
        assert!((decay.damping_ratio / zeta - 1.0).abs() < 1e-2, "{decay:?}");
    }

    /// Exact peaks on eq. 6: the search itself, without the way there.
    #[test]
    fn the_fit_finds_the_curve_it_was_made_with() {
        let (amplitude, zeta, damped) = (0.11, 0.17, 7.0);
        let root = f64::sqrt(1.0 - zeta * zeta);
        let peaks: Vec<Peak> = (1..8)
            .map(|n| n as f64 * TAU / damped)
            .map(|time| Peak { time, height: amplitude / root * (-zeta * damped * time / root).exp() })
            .collect();
        let decay = fit_decay(&peaks, damped).unwrap();
        let tolerance = 1e-6; // where the simplex search calls itself settled
        assert!((decay.initial_amplitude / amplitude - 1.0).abs() < tolerance, "{decay:?}");
        assert!((decay.damping_ratio / zeta - 1.0).abs() < tolerance, "{decay:?}");
        assert!((decay.natural_frequency * root - damped).abs() < 1e-6, "{decay:?}");
    }

    /// Drag proportional to the square of velocity: `A_{n+1} = A_n / (1 + b A_n)`.
    #[test]
    fn damping_that_falls_with_amplitude_is_seen_cycle_by_cycle() {
        let mut height = 0.2;
        let peaks: Vec<Peak> = (1..20)
            .map(|n| {
                height /= 1.0 + 0.7 * height;
                Peak { time: 0.8 * n as f64, height }
            })
            .collect();
        let cycles = cycles(&peaks).unwrap();
        assert!(cycles.windows(2).all(|pair| pair[1].damping_ratio < pair[0].damping_ratio));
        for cycle in cycles {
            let expected = 0.7 * cycle.amplitude / TAU;
            assert!((cycle.damping_ratio / expected - 1.0).abs() < 0.01, "{cycle:?}");
        }
    }

    #[test]
    fn two_peaks_are_too_few_for_a_fit() {
        let peaks = [0.2, 0.1, -0.1].map(|height| Peak { time: 1.0 - height, height });
        assert_eq!(
            fit_decay(&peaks, 8.0).unwrap_err().to_string(),
            "2 upper peaks above rest: at least 3 are needed; try a longer recording, \
             a lower least prominence, or check the rest"
        );
        assert!(cycles(&peaks[..1]).is_err());
    }
}
