//! The swing of an excursion: its spectrum, damped frequency and upper peaks, which check each other.

use std::f64::consts::TAU;

use super::Excursion;
use super::peaks::{self, PeakRules, upper_peaks};
use super::settling::settling_time;
use super::spectrum::{Spectrum, Window, amplitude_spectrum};

/// Length of the transform in lengths of the recording.
const PADDING: usize = 8;
/// The spectrum sees the swing until it has decayed to this part of its first excursion.
const SWING_IS_OVER: f64 = 0.01;
/// By how much the time between upper peaks may differ from the period of the spectrum's peak: large
/// swings are slower or faster than small ones, harmonics differ by a half and more.
const MOST_DRIFT: f64 = 0.25;

/// The spectrum of the recording up to where the swing is over, if it is: beyond, there is nothing
/// but rounding to weigh.
pub fn swing_spectrum(excursion: &Excursion) -> Spectrum {
    let over = settling_time(excursion, SWING_IS_OVER).unwrap_or(f64::INFINITY);
    let samples = excursion.values().len();
    let kept = ((over / excursion.step()).ceil().min(samples as f64) as usize).max(samples.min(3));
    let part = Excursion::about(0.0, &excursion.values()[..kept], excursion.step());
    amplitude_spectrum(part.as_ref().unwrap_or(excursion), Window::default(), PADDING)
}

/// Damped frequency, rad/s, and upper peaks.
///
/// A recording of less than about two swings has side lobes of its window in the spectrum, or the
/// bump's harmonic, and no peak of the swing: a frequency counts if upper peaks above rest come with its period.
pub fn swing(
    excursion: &Excursion,
    spectrum: &Spectrum,
) -> (Result<f64, String>, Result<Vec<peaks::Peak>, String>) {
    let omega = match spectrum.peak() {
        Ok(peak) => peak.frequency,
        Err(error) => return (Err(error.to_string()), Err(format!("needs the damped frequency: {error}"))),
    };
    let period = TAU / omega;
    let upper = upper_peaks(excursion, period, &PeakRules::default());
    let above: Vec<_> = upper.iter().filter(|peak| peak.height > 0.0).collect();
    let why = match above.as_slice() {
        [] | [_] => format!("{} upper peaks above rest: two tell a swing; try a longer run", above.len()),
        [first, .., last] => {
            let between = (last.time - first.time) / (above.len() - 1) as f64;
            if (between / period - 1.0).abs() < MOST_DRIFT {
                return (Ok(omega), Ok(upper));
            }
            format!(
                "the spectrum has its peak at {:.3} Hz, but upper peaks are {between:.3} s apart; \
                 try a longer run",
                omega / TAU
            )
        }
    };
    (Err(why.clone()), Err(format!("needs the damped frequency: {why}")))
}
