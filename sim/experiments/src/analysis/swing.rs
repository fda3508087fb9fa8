//! The swing of an excursion: its spectrum, damped frequency and upper peaks, which check each other.

use std::f64::consts::TAU;

use super::Excursion;
use super::peaks::{Peak, PeakRules, upper_peaks};
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
pub fn swing(excursion: &Excursion, spectrum: &Spectrum) -> (Result<f64, String>, Result<Vec<Peak>, String>) {
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

/// The same of a level coordinate, which has no bumps in its troughs: the frequency does not count if an upper peak is missing
/// because it lies too near to another for that period.
pub fn level_swing(
    excursion: &Excursion,
    spectrum: &Spectrum,
) -> (Result<f64, String>, Result<Vec<Peak>, String>) {
    let (omega, upper) = swing(excursion, spectrum);
    if let (Ok(omega), Ok(upper)) = (&omega, &upper)
        && let Some(missing) = missing_peak(excursion, upper, TAU / omega)
    {
        let why = format!(
            "the spectrum has its peak at {:.3} Hz, but the upper peak at {:.3} s lies nearer to others than \
             that period; small swings are faster than the first ones",
            omega / TAU,
            missing.time
        );
        return (Err(why.clone()), Err(format!("needs the damped frequency: {why}")));
    }
    (omega, upper)
}

/// An upper peak that is not among those found with a period. Upper peaks descend: a maximum between two of them that is higher
/// than the second is one as well, unless it belongs to the top of either.
fn missing_peak(excursion: &Excursion, upper: &[Peak], period: f64) -> Option<Peak> {
    let rules = PeakRules::default();
    // Half of the least distance at which a maximum is a peak of its own.
    let own_top = 0.5 * rules.least_separation * period;
    let all = upper_peaks(excursion, period, &PeakRules { least_separation: 0.0, ..rules });
    let above: Vec<&Peak> = upper.iter().filter(|peak| peak.height > 0.0).collect();
    all.into_iter().find(|peak| {
        let is_apart = above.iter().all(|own| (own.time - peak.time).abs() > own_top);
        let is_between = |pair: &[&Peak]| (pair[0].time..pair[1].time).contains(&peak.time);
        is_apart && above.windows(2).any(|pair| is_between(pair) && peak.height > pair[1].height)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half swings from 0.53 s down to 0.2 s, each smaller than the one before, like those of a hanging arm that a hand lets go. The
    /// spectrum has its peak at the slow ones. An upper peak of the fast ones is nearer to another than that period.
    #[test]
    fn a_frequency_that_rises_by_too_much_is_refused() {
        let step = 0.01;
        let mut z = Vec::new();
        for n in 0..16 {
            let turn = |n: i32| (-1f64).powi(n) * (0.15 * 0.5f64.powi(n) + 0.02 * 0.75f64.powi(n));
            let half = 0.2 + 0.33 * 0.6f64.powi(n);
            let (from, to) = (turn(n), turn(n + 1));
            let samples = (half / step).round() as usize;
            let share = |i: usize| 0.5 * (1.0 - (0.5 * TAU * i as f64 / samples as f64).cos());
            z.extend((0..samples).map(|i| from + (to - from) * share(i)));
        }
        let excursion = Excursion::about(0.0, &z, step).unwrap();
        let spectrum = swing_spectrum(&excursion);
        assert!(swing(&excursion, &spectrum).0.is_ok());
        let found = level_swing(&excursion, &spectrum).0;
        assert!(found.unwrap_err().contains("nearer"));
    }
}
