//! Amplitude spectrum of an excursion, and the damped frequency at its peak.

use std::f64::consts::{PI, TAU};

use realfft::RealFftPlanner;

use super::{AnalysisError, Excursion};

/// How samples are weighted before the transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// As they are, as the paper seems to have it. A recording that ends at rest has nothing to
    /// leak at its end; the jump at its start raises the peak's frequency, by 0.3 % at a damping
    /// ratio of 0.08 and 0.9 % at 0.15.
    Rectangular,
    /// Zero at both ends: of a linear decay it gives the frequency to `0.01 ζ²`. It weighs the middle
    /// of the recording most, hence smaller swings, and noise if they are over by then: cut the
    /// recording to a few decay times first.
    #[default]
    Hann,
    /// One at the release, zero at the end: keeps the strong first swings of a decay. The bias is
    /// that without a window and up to 0.2 % more.
    FallingHann,
}

impl Window {
    fn weight(self, i: usize, samples: usize) -> f64 {
        let turn = i as f64 / samples as f64;
        match self {
            Self::Rectangular => 1.0,
            Self::Hann => (PI * turn).sin().powi(2),
            Self::FallingHann => (0.5 * PI * turn).cos().powi(2),
        }
    }
}

/// Amplitude over angular frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Angular frequency from one bin to the next, rad/s; bin 0 is at zero.
    pub frequency_step: f64,
    /// Lowest angular frequency at which an oscillation can be distinguished from a drift, rad/s: two
    /// periods in the recording.
    pub lowest_frequency: f64,
    /// Amplitude, m, one a bin: a steady cosine shows its own amplitude.
    pub amplitude: Vec<f64>,
}

/// Where a spectrum is highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralPeak {
    /// Angular frequency, rad/s.
    pub frequency: f64,
    /// Amplitude, m.
    pub amplitude: f64,
}

/// Amplitude spectrum by a fast Fourier transform.
///
/// `padding`: length of the transform in lengths of the recording, at least 1, as a number whose only factors are two,
/// three and five; zeros fill it, and bins come to lie as much closer. Eight is plenty.
pub fn amplitude_spectrum(excursion: &Excursion, window: Window, padding: usize) -> Spectrum {
    let samples = excursion.values().len();
    let length = fast_length(samples * padding.max(1));
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let mut input = transform.make_input_vec();
    let mut output = transform.make_output_vec();
    let mut weights = 0.0;
    for (i, (slot, value)) in input.iter_mut().zip(excursion.values()).enumerate() {
        let weight = window.weight(i, samples);
        weights += weight;
        *slot = weight * value;
    }
    transform.process(&mut input, &mut output).expect("buffers come from the transform itself");

    let frequency_step = TAU / (length as f64 * excursion.step());
    Spectrum {
        frequency_step,
        lowest_frequency: 2.0 * TAU / (samples as f64 * excursion.step()),
        amplitude: output.iter().map(|bin| 2.0 * bin.norm() / weights).collect(),
    }
}

/// The least even number from one on that has no other prime factors than two, three and five: a transform of a length with
/// a large prime factor takes several times as long.
fn fast_length(least: usize) -> usize {
    let threes = |five: usize| {
        std::iter::successors(Some(five), |n| n.checked_mul(3)).take_while(move |n| *n <= 2 * least)
    };
    let fives = std::iter::successors(Some(2usize), |n| n.checked_mul(5)).take_while(|n| *n <= 2 * least);
    let up_to = |odd: usize| odd * least.div_ceil(odd).next_power_of_two();
    fives.flat_map(threes).map(up_to).min().unwrap_or(least)
}

impl Spectrum {
    /// Its highest local maximum from [`Self::lowest_frequency`] on, refined between bins by the
    /// parabola through the logarithms of the highest three.
    ///
    /// For a free decay that is the damped frequency. A local maximum, because the slow drift of an
    /// asymmetric decay may be higher at zero frequency than the swing is.
    /// # Errors
    /// [`AnalysisError::NoOscillation`] if there is none.
    pub fn peak(&self) -> Result<SpectralPeak, AnalysisError> {
        self.peak_between([0.0, f64::INFINITY])
    }

    /// The same within a range of angular frequencies, rad/s.
    /// # Errors
    /// As [`Self::peak`].
    pub fn peak_between(&self, [from, to]: [f64; 2]) -> Result<SpectralPeak, AnalysisError> {
        let bin = |frequency: f64| (frequency / self.frequency_step).round() as usize;
        let lowest = from.max(self.lowest_frequency);
        let end = self.amplitude.len().saturating_sub(1).min(bin(to).saturating_add(1));
        let top = (bin(lowest).max(1)..end)
            .filter(|&k| self.amplitude[k - 1] < self.amplitude[k])
            .filter(|&k| self.amplitude[k + 1] <= self.amplitude[k])
            .max_by(|&a, &b| self.amplitude[a].total_cmp(&self.amplitude[b]))
            .ok_or(AnalysisError::NoOscillation { lowest })?;
        // Zero beside a peak has no logarithm; a millionth of the peak serves as well.
        let floor = 1e-6 * self.amplitude[top];
        let [before, here, after] = [top - 1, top, top + 1].map(|k| self.amplitude[k].max(floor).ln());
        let shift = 0.5 * (before - after) / (before - 2.0 * here + after);
        Ok(SpectralPeak {
            frequency: (top as f64 + shift) * self.frequency_step,
            amplitude: (here - 0.25 * (before - after) * shift).exp(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(samples: usize, z: impl Fn(f64) -> f64) -> Excursion {
        let z: Vec<f64> = (0..samples).map(|i| z(0.01 * i as f64)).collect();
        Excursion::about(0.0, &z, 0.01).unwrap()
    }

    #[test]
    fn a_steady_cosine_shows_its_amplitude_and_frequency() {
        let cosine = |omega: f64| sampled(1000, move |t| 0.07 * (omega * t + 0.4).cos());
        // Between two bins, where a spectrum that is not refined is off by half a bin.
        let omega = TAU * 1.25 + 0.5 * TAU / 10.0;
        for (window, padding, tolerance) in [
            (Window::Hann, 1, 2e-2),        // log-parabola on a main lobe four bins wide
            (Window::Hann, 8, 1e-4),        // the same on bins eight times as close
            (Window::FallingHann, 8, 5e-2), // the jump at the start leaks from negative frequency
            (Window::Rectangular, 8, 5e-2),
        ] {
            let peak = amplitude_spectrum(&cosine(omega), window, padding).peak().unwrap();
            let bins = (peak.frequency - omega) / (TAU / 10.0);
            assert!(bins.abs() < tolerance, "{window:?} {padding}: off by {bins} bins");
            assert!((peak.amplitude / 0.07 - 1.0).abs() < tolerance, "{window:?} {padding}: {peak:?}");
        }
    }

    #[test]
    fn a_damped_cosine_shows_its_damped_frequency() {
        // Tolerances are twice the bias that was measured; it grows with the square of damping.
        let omega = 8.1;
        for (zeta, hann, falling) in [(0.01, 2e-6, 1e-3), (0.05, 1e-5, 2e-3), (0.1, 5e-5, 6e-3)] {
            let decay = zeta * omega / f64::sqrt(1.0 - zeta * zeta);
            let excursion = sampled(2000, |t| 0.2 * (-decay * t).exp() * (omega * t).cos());
            for (window, tolerance) in [(Window::Hann, hann), (Window::FallingHann, falling)] {
                let peak = amplitude_spectrum(&excursion, window, 8).peak().unwrap();
                let error = peak.frequency / omega - 1.0;
                assert!(error.abs() < tolerance, "{window:?} at {zeta}: off by {error:e}");
            }
        }
    }

    #[test]
    fn a_drift_higher_than_the_swing_is_not_taken_for_it() {
        let decay = |t: f64| (-0.3 * t).exp();
        let swing = |t: f64| 0.05 * (8.0 * t).cos();
        let decaying = sampled(2000, |t| decay(t) * (swing(t) + 0.3));
        let wandering = sampled(2000, |t| swing(t) + 0.3 * (TAU * 1.3 * t / 20.0).sin());
        for excursion in [decaying, wandering] {
            let spectrum = amplitude_spectrum(&excursion, Window::Hann, 4);
            let peak = spectrum.peak().unwrap();
            let highest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
            assert!(highest > peak.amplitude, "a drift to be passed over");
            assert!((peak.frequency / 8.0 - 1.0).abs() < 1e-3, "{peak:?}");
        }
    }

    #[test]
    fn lengths_of_transforms_are_fast_and_little_longer() {
        for least in [1, 2, 3, 7, 97, 1601, 16_008, 400_008, 4_000_037] {
            let length = fast_length(least);
            assert!(length >= least && length.is_multiple_of(2), "{least}: {length}");
            assert!(least < 100 || length as f64 <= 1.07 * least as f64, "{least}: {length}");
            let rest = [2, 3, 5].iter().fold(length, |mut rest, factor| {
                while rest % factor == 0 {
                    rest /= factor;
                }
                rest
            });
            assert_eq!(rest, 1, "{least}: {length}");
        }
    }

    #[test]
    fn a_constant_has_no_oscillation() {
        let error = amplitude_spectrum(&sampled(100, |_| 0.0), Window::Hann, 1).peak().unwrap_err();
        assert_eq!(
            error.to_string(),
            "no oscillation: the spectrum has no peak above 12.566 rad/s; \
             try a recording of more than two periods"
        );
    }
}
