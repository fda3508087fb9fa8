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
    /// Standard error of ζ: from the scatter of the peaks about the curve, or from the noise where that is larger, and from
    /// that of the rest.
    pub ratio_error: f64,
}

/// Standard errors of the heights of peaks, m.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeightError {
    /// Of each by itself.
    pub noise: f64,
    /// Of the rest, which all have in common.
    pub rest: f64,
}

impl Decay {
    /// The same curve with its clock set back, s.
    pub fn later(self, by: f64) -> Self {
        Self { initial_amplitude: self.envelope(-by) * (1.0 - self.damping_ratio.powi(2)).sqrt(), ..self }
    }

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
pub fn fit_decay(peaks: &[Peak], damped_frequency: f64, error: HeightError) -> Result<Decay, AnalysisError> {
    let peaks = above_rest(peaks, 3)?;
    let (first, last) = (peaks[0], peaks[peaks.len() - 1]);
    let squares = |amplitude: f64, ratio: f64| -> f64 {
        let model = |time| eq_6(amplitude, ratio, damped_frequency, time);
        peaks.iter().map(|peak| (peak.height - model(peak.turn)).powi(2)).sum()
    };

    // First and last peak give a start; parameters and cost are then of order one.
    let rate = (first.height / last.height).ln() / (last.turn - first.turn);
    let start = rate / rate.hypot(damped_frequency);
    let scale = first.height * (rate * first.turn).exp();
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
    let sum = squares(initial_amplitude, damping_ratio);
    let scatter = (sum / (peaks.len() - 2) as f64).sqrt().max(error.noise);
    let model = |ratio: f64, time: f64| eq_6(initial_amplitude, ratio, damped_frequency, time);
    let ratio_error = ratio_error(peaks, damping_ratio, model, HeightError { noise: scatter, ..error });
    Ok(Decay {
        initial_amplitude,
        damping_ratio,
        damped_frequency,
        natural_frequency: natural_frequency(damped_frequency, damping_ratio),
        rms_residual: (sum / peaks.len() as f64).sqrt(),
        ratio_error,
    })
}

/// Standard error of the ratio: least squares in two unknowns, the height of the curve at the release and its ratio.
fn ratio_error(peaks: &[Peak], ratio: f64, model: impl Fn(f64, f64) -> f64, error: HeightError) -> f64 {
    const STEP: f64 = 1e-6;
    let slopes = peaks.iter().map(|peak| {
        let by_ratio = (model(ratio + STEP, peak.turn) - model(ratio - STEP, peak.turn)) / (2.0 * STEP);
        // Of the logarithm of the amplitude.
        (model(ratio, peak.turn), by_ratio)
    });
    let [mut aa, mut ar, mut rr, mut a, mut r] = [0.0; 5];
    for (by_amplitude, by_ratio) in slopes {
        aa += by_amplitude * by_amplitude;
        ar += by_amplitude * by_ratio;
        rr += by_ratio * by_ratio;
        a += by_amplitude;
        r += by_ratio;
    }
    let determinant = aa * rr - ar * ar;
    if determinant <= 0.0 {
        return f64::INFINITY;
    }
    // A rest that is off by a length shifts all heights by it.
    let by_rest = (aa * r - ar * a) / determinant * error.rest;
    (error.noise * (aa / determinant).sqrt()).hypot(by_rest)
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
    /// Standard error of ζ, from those of the two heights.
    pub ratio_error: f64,
}

/// Damping and frequency cycle by cycle, hence against amplitude.
///
/// An error of the rest shifts every height, and matters most for the last, small ones.
/// # Errors
/// [`AnalysisError::TooFewPeaks`] below two peaks above rest.
pub fn cycles(peaks: &[Peak], error: HeightError) -> Result<Vec<Cycle>, AnalysisError> {
    let between = |pair: &[Peak]| {
        let [a, b] = [pair[0], pair[1]];
        let decrement = (a.height / b.height).ln();
        let damping_ratio = decrement / decrement.hypot(TAU);
        let damped_frequency = TAU / (b.turn - a.turn);
        Cycle {
            time: 0.5 * (a.turn + b.turn),
            amplitude: (a.height * b.height).sqrt(),
            damping_ratio,
            damped_frequency,
            natural_frequency: natural_frequency(damped_frequency, damping_ratio),
            // That of the decrement over 2π: noise changes both heights, an error of the rest shifts them by the same.
            ratio_error: (error.noise * a.height.recip().hypot(b.height.recip()))
                .hypot(error.rest * (b.height.recip() - a.height.recip()))
                / TAU,
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
    use crate::analysis::peaks::upper_peaks;
    use crate::analysis::spectrum::{Window, amplitude_spectrum};

    const EXACT: HeightError = HeightError { noise: 0.0, rest: 0.0 };

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
        let peaks = upper_peaks(excursion, TAU / damped);
        let decay = fit_decay(&peaks, damped, EXACT).unwrap();
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
            for cycle in cycles(&peaks, EXACT).unwrap() {
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
            .map(|time| Peak {
                time,
                turn: time,
                height: amplitude / root * (-zeta * damped * time / root).exp(),
            })
            .collect();
        let decay = fit_decay(&peaks, damped, EXACT).unwrap();
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
                Peak { time: 0.8 * n as f64, turn: 0.8 * n as f64, height }
            })
            .collect();
        let cycles = cycles(&peaks, EXACT).unwrap();
        assert!(cycles.windows(2).all(|pair| pair[1].damping_ratio < pair[0].damping_ratio));
        for cycle in cycles {
            let expected = 0.7 * cycle.amplitude / TAU;
            assert!((cycle.damping_ratio / expected - 1.0).abs() < 0.01, "{cycle:?}");
        }
    }

    /// The errors are those by which noise and an error of the rest move the ratios: drawn, and by differences.
    #[test]
    fn errors_are_the_spread_of_drawn_noise() {
        let (zeta, damped, noise) = (0.03, 8.0, 4e-4);
        let root = f64::sqrt(1.0 - zeta * zeta);
        let exact: Vec<Peak> = (1..14)
            .map(|n| f64::from(n) * TAU / damped)
            .map(|time| Peak { time, turn: time, height: 0.05 * (-zeta * damped * time / root).exp() })
            .collect();
        let error = HeightError { noise, rest: 0.0 };
        let mut state = 7u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64 - 0.5
        };
        // A sum of twelve has the variance one.
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>();
        let (mut all, mut last) = (Vec::new(), Vec::new());
        for _ in 0..400 {
            let noisy: Vec<Peak> =
                exact.iter().map(|peak| Peak { height: peak.height + noise * normal(), ..*peak }).collect();
            all.push(fit_decay(&noisy, damped, error).unwrap().damping_ratio);
            last.push(cycles(&noisy, error).unwrap()[11].damping_ratio);
        }
        let spread = |of: &[f64]| {
            let mean = of.iter().sum::<f64>() / of.len() as f64;
            (of.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (of.len() - 1) as f64).sqrt()
        };
        // A standard deviation of 400 draws is good to 3.5 %; three times that.
        for (said, drawn) in [
            (fit_decay(&exact, damped, error).unwrap().ratio_error, spread(&all)),
            (cycles(&exact, error).unwrap()[11].ratio_error, spread(&last)),
        ] {
            assert!((said / drawn - 1.0).abs() < 0.11, "{said:e} {drawn:e}");
        }
        // What a rest that is off by a micrometre does.
        let shifted: Vec<Peak> =
            exact.iter().map(|peak| Peak { height: peak.height + 1e-6, ..*peak }).collect();
        let of_rest = HeightError { noise: 0.0, rest: 1e-6 };
        let said = [
            fit_decay(&exact, damped, of_rest).unwrap().ratio_error,
            cycles(&exact, of_rest).unwrap()[11].ratio_error,
        ];
        let moved = [
            fit_decay(&shifted, damped, EXACT).unwrap().damping_ratio - zeta,
            cycles(&shifted, EXACT).unwrap()[11].damping_ratio
                - cycles(&exact, EXACT).unwrap()[11].damping_ratio,
        ];
        for (said, moved) in said.into_iter().zip(moved) {
            assert!((said / moved.abs() - 1.0).abs() < 0.05, "{said:e} {moved:e}");
        }
    }

    #[test]
    fn two_peaks_are_too_few_for_a_fit() {
        let peaks = [0.2, 0.1, -0.1].map(|height| Peak { time: 1.0 - height, turn: 1.0 - height, height });
        assert_eq!(
            fit_decay(&peaks, 8.0, EXACT).unwrap_err().to_string(),
            "2 upper peaks above rest: at least 3 are needed; try a longer recording, \
             a lower least prominence, or check the rest"
        );
        assert!(cycles(&peaks[..1], EXACT).is_err());
    }
}
