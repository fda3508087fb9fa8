//! The swing of a coordinate about its rest: frequency, upper peaks and decay, which check one another. The one place where
//! these are computed, of what is simulated and of what was measured.

use std::f64::consts::TAU;

use super::coordinate::Coordinate;
use super::decay::{self, Cycle, Decay};
use super::peaks::{Peak, upper_peaks};
use super::spectrum::{Spectrum, Window, amplitude_spectrum};
use super::{AnalysisError, Excursion};

/// Length of the transform in lengths of the recording.
const PADDING: usize = 8;
/// The spectrum sees the swing until this part of its sum of squares is left. Of an exponential decay that is a hundredth of
/// the amplitude. Unlike the last crossing of a band it moves continuously with every parameter.
const LEFT_OVER: f64 = 1e-4;
/// Samples of a period that the spectrum needs; of more it takes every so-many-th.
const IN_A_PERIOD: f64 = 50.0;
/// Range of the damped frequency about that of the first mode: large swings are slower or faster than small ones, harmonics
/// differ by a half and more.
const ABOUT_THE_MODE: [f64; 2] = [0.5, 1.5];
/// By how much the time between upper peaks may differ from the period of the spectrum's peak.
const MOST_DRIFT: f64 = 0.25;

/// What a swing comes to; what it does not has its reason.
#[derive(Clone, Debug)]
pub struct Swing {
    /// Amplitude over frequency, up to where the swing is over.
    pub spectrum: Spectrum,
    /// Damped angular frequency, rad/s: where the spectrum is highest.
    pub damped_frequency: Result<f64, String>,
    /// Upper peaks, one in a period.
    pub peaks: Result<Vec<Peak>, String>,
    /// Eq. 6 fitted to them.
    pub decay: Result<Decay, String>,
    /// From each upper peak to the next.
    pub cycles: Result<Vec<Cycle>, String>,
}

/// What is known of a swing beforehand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known {
    /// Damped angular frequency of the first mode, rad/s; without it the highest peak of the spectrum counts.
    pub mode: Option<f64>,
    /// Standard deviation of the noise, m.
    pub noise: f64,
    /// Standard error of the rest, m.
    pub rest_error: f64,
    /// Whether troughs may have bumps, as those of the height have.
    pub has_bumps: bool,
}

/// Amplitude at which peaks are no longer counted: so many standard deviations of the noise.
const LEAST_PEAK: f64 = 6.0;

/// The swing of an evenly sampled path about its rest along a coordinate, m.
/// # Errors
/// [`AnalysisError`] if there are too few samples.
pub fn swing_along(
    path: &[[f64; 2]],
    step: f64,
    rest: [f64; 2],
    coordinate: Coordinate,
    known: &Known,
) -> Result<(Excursion, Swing), AnalysisError> {
    let values: Vec<f64> = path.iter().map(|at| coordinate.of(*at)).collect();
    let excursion = Excursion::about(coordinate.of(rest), &values, step)?;
    let swing = swing(&excursion, known);
    Ok((excursion, swing))
}

/// The swing of an excursion.
pub fn swing(excursion: &Excursion, known: &Known) -> Swing {
    let spectrum = swing_spectrum(excursion, known.mode);
    let (damped_frequency, peaks) = match frequency_and_peaks(excursion, &spectrum, known) {
        Ok((frequency, peaks)) => (Ok(frequency), Ok(peaks)),
        Err(why) => (Err(why.clone()), Err(format!("needs the damped frequency: {why}"))),
    };
    let error = decay::HeightError { noise: known.noise, rest: known.rest_error };
    let decay = peaks.clone().and_then(|peaks| {
        let frequency = damped_frequency.clone()?;
        decay::fit_decay(&peaks, frequency, error).map_err(|error| error.to_string())
    });
    let cycles =
        peaks.clone().and_then(|peaks| decay::cycles(&peaks, error).map_err(|error| error.to_string()));
    Swing { spectrum, damped_frequency, peaks, decay, cycles }
}

/// The spectrum of an excursion up to where the swing is over, if it is: beyond, there is nothing but rounding to weigh.
pub fn swing_spectrum(excursion: &Excursion, mode: Option<f64>) -> Spectrum {
    let every = mode.map_or(1, |mode| (TAU / mode / IN_A_PERIOD / excursion.step()).max(1.0) as usize);
    let kept: Vec<f64> = excursion.values()[..over(excursion)].iter().copied().step_by(every).collect();
    let part = Excursion::about(0.0, &kept, every as f64 * excursion.step());
    amplitude_spectrum(part.as_ref().unwrap_or(excursion), Window::default(), PADDING)
}

/// Number of samples up to where the swing is over; at least three, where there are.
fn over(excursion: &Excursion) -> usize {
    let values = excursion.values();
    let total: f64 = values.iter().map(|value| value * value).sum();
    let mut left = 0.0;
    let tail = values.iter().rev().take_while(|value| {
        left += **value * **value;
        left < LEFT_OVER * total
    });
    (values.len() - tail.count()).max(values.len().min(3))
}

/// Damped frequency, rad/s, and upper peaks.
///
/// A recording of less than about two swings has side lobes of its window in the spectrum, or a harmonic, and no peak of
/// the swing: a frequency counts if upper peaks above rest come with its period.
fn frequency_and_peaks(
    excursion: &Excursion,
    spectrum: &Spectrum,
    known: &Known,
) -> Result<(f64, Vec<Peak>), String> {
    let found = match known.mode {
        Some(mode) => {
            spectrum.peak_between(ABOUT_THE_MODE.map(|share| share * mode)).map_err(|error| match error {
                AnalysisError::NoOscillation { .. } if mode > spectrum.lowest_frequency => {
                    format!("no oscillation near the first mode, {:.3} Hz, in the spectrum", mode / TAU)
                }
                error => error.to_string(),
            })
        }
        None => spectrum.peak().map_err(|error| error.to_string()),
    };
    let omega = found?.frequency;
    let period = TAU / omega;
    let mut upper = upper_peaks(excursion, period);
    let above: Vec<Peak> = upper.iter().copied().filter(|peak| peak.height > 0.0).collect();
    let ([first, .., last], hertz) = (above.as_slice(), omega / TAU) else {
        return Err(format!(
            "{} upper peaks above rest: a swing has two at least; try a longer run",
            above.len()
        ));
    };
    let between = (last.time - first.time) / (above.len() - 1) as f64;
    if (between / period - 1.0).abs() >= MOST_DRIFT {
        return Err(format!(
            "the spectrum has its peak at {hertz:.3} Hz, but upper peaks are {between:.3} s apart; try a longer run"
        ));
    }
    if let Some(missing) = missing_peak(excursion, &above, period).filter(|_| !known.has_bumps) {
        return Err(format!(
            "the spectrum has its peak at {hertz:.3} Hz, but the upper peak at {:.3} s lies nearer to others than \
             that period; small swings are faster than the first ones",
            missing.time
        ));
    }
    let least = LEAST_PEAK * known.noise;
    upper.truncate(upper.iter().position(|peak| peak.height < least).unwrap_or(upper.len()));
    Ok((omega, upper))
}

/// Least distance of two upper peaks, in periods.
const LEAST_DISTANCE: f64 = 0.7;

/// An upper peak that the period does not admit: nearer than most of it to the one before, or not among those found with it. Upper
/// peaks descend: a maximum between two of them that is higher than the second is one as well, unless it belongs to the top of
/// either.
fn missing_peak(excursion: &Excursion, upper: &[Peak], period: f64) -> Option<Peak> {
    let is_near = |pair: &&[Peak]| pair[1].time - pair[0].time < LEAST_DISTANCE * period;
    if let Some(pair) = upper.windows(2).find(is_near) {
        return Some(pair[1]);
    }
    let own_top = 0.5 * LEAST_DISTANCE * period;
    upper_peaks(excursion, 0.5 * period).into_iter().find(|peak| {
        let after = upper.partition_point(|own| own.time <= peak.time);
        let Some([before, next]) = after.checked_sub(1).and_then(|before| upper.get(before..=after)) else {
            return false;
        };
        let is_apart = peak.time - before.time > own_top && next.time - peak.time > own_top;
        is_apart && peak.height > next.height
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
        let found = |has_bumps| swing(&excursion, &Known { has_bumps, ..Known::default() }).damped_frequency;
        assert!(found(true).is_ok());
        assert!(found(false).unwrap_err().contains("nearer"));
    }
}
