//! Noise of a recording, from what its end is off a decaying swing: how large it is, and how much of it is slow.
//!
//! Neighbouring samples show only what is fast in the noise. A camera's filter, a floor that shakes and a base that wanders are
//! slower, and look like a misfit of the model. At the end of a record the swing is small, and over two cycles it has one form, so
//! what is off this form is noise. Its periodogram up to a few times the frequency of the swing, less what the form takes, is the
//! density that parameters and misfits are compared with; that of white noise would be the same at all frequencies.
//! Source: Priestley (1981), Spectral Analysis and Time Series, chapter 6.

use std::f64::consts::TAU;

use super::window::{Span, basis, fit};

/// Share of the record at its end that is looked at. A swing that is followed to its rest is small there, and there are enough
/// samples to know a deviation to some per cent.
const END: f64 = 0.3;
/// Cycles of a window there: over more of them a frequency that depends on the amplitude is seen, over fewer the form takes all that
/// is slow.
const CYCLES: f64 = 2.0;
/// Frequencies that count as slow, over that of the swing: its second harmonic and what beats with it lie below.
const SLOW: f64 = 3.0;
/// Residuals of more than this many times what neighbours show are motion.
const MOTION: f64 = 3.0;
/// Density of slow noise over the mean, where a recording does not show it: neighbours correlated by a half, which filters of cameras
/// leave.
const USUAL: f64 = 3.0;

/// Noise of the coordinates of a release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of a coordinate, m.
    pub deviation: f64,
    /// Spectral density at the frequencies of a swing over the mean of all frequencies: 1 of white noise.
    pub slow: f64,
}

impl Noise {
    /// Of coordinates `[coordinate][sample]`, m, that swing with a frequency, Hz. `known` is the deviation that is stated or that
    /// neighbours show: it is no less, and it is this where the end of the recording is no noise.
    pub fn of(time: &[f64], coordinates: &[Vec<f64>], frequency: f64, known: f64) -> Self {
        match Self::at_the_end(time, coordinates, frequency) {
            Some([variance, slow]) if variance < (MOTION * known).powi(2) => {
                let variance = variance.max(known.powi(2));
                Self { deviation: variance.sqrt(), slow: (slow / variance).max(1.0) }
            }
            _ => Self { deviation: known, slow: USUAL },
        }
    }

    /// Correlation of neighbours of the process of first order that has this share of slow noise.
    pub fn correlation(&self) -> f64 {
        (self.slow - 1.0) / (self.slow + 1.0)
    }

    /// Variance of a coordinate, and what it would be if all frequencies had the density of the slow ones, m²; none where the end
    /// of the record has too few samples or no swing.
    fn at_the_end(time: &[f64], coordinates: &[Vec<f64>], frequency: f64) -> Option<[f64; 2]> {
        let samples = coordinates[0].len();
        let end = samples - (END * samples as f64) as usize;
        let interval = (time[samples - 1] - time[0]) / (samples - 1) as f64;
        let window = (CYCLES / (frequency * interval)) as usize;
        let mut seen = Seen::default();
        let mut last = samples;
        // The last window always, and those that lie in the end.
        while last >= window + 2 && (last == samples || last - window >= end) {
            let first = last - window;
            let own: Vec<Vec<f64>> = coordinates.iter().map(|q| q[first..last].to_vec()).collect();
            seen.add(&time[first..last], &own, frequency);
            last = first;
        }
        // What the form takes was slow.
        let slow = (seen.left > 0.0).then(|| seen.slow / seen.left)?;
        let numbers = seen.left + seen.taken;
        Some([(numbers * slow + seen.fast) / (numbers + seen.fast_numbers), slow])
    }
}

/// What windows are off their forms.
#[derive(Default)]
struct Seen {
    /// Squares of what is slow and fast, m².
    slow: f64,
    fast: f64,
    /// Independent numbers that are slow, those of them that the form takes, and those that are fast.
    left: f64,
    taken: f64,
    fast_numbers: f64,
}

impl Seen {
    /// Adds a window, unless it shows no swing.
    fn add(&mut self, time: &[f64], coordinates: &[Vec<f64>], frequency: f64) {
        let (begin, end) = (time[0], time[time.len() - 1]);
        // Weights are even over the window: the ramps lie outside.
        let half_period = 0.5 / frequency;
        let span = Span { begin: begin - half_period, end: end + half_period, half_period };
        let Some(found) = fit(time, coordinates, &span, (frequency, 0.0)) else { return };
        // Cosines and sines of whole cycles over the window, up to the slow ones.
        let harmonics = (SLOW * frequency * (end - begin)).ceil();
        let numbers = 2.0 * harmonics + 1.0;
        if time.len() as f64 <= numbers {
            return;
        }
        let form = |t: &f64| basis(t - 0.5 * (begin + end), found.frequency, found.loss);
        let form: Vec<[f64; 5]> = time.iter().map(form).collect();
        for (q, coefficients) in coordinates.iter().zip(&found.coefficients) {
            let value = |row: &[f64; 5]| row.iter().zip(coefficients).map(|(b, c)| b * c).sum::<f64>();
            let residual: Vec<f64> = form.iter().zip(q).map(|(row, q)| q - value(row)).collect();
            let slow = power(time, &residual, harmonics as usize);
            self.slow += slow;
            self.fast += (residual.iter().map(|r| r * r).sum::<f64>() - slow).max(0.0);
        }
        let count = coordinates.len() as f64;
        // Five coefficients of each coordinate; frequency and loss.
        let taken = 5.0 * count + 2.0;
        self.taken += taken;
        self.left += count * numbers - taken;
        self.fast_numbers += count * (time.len() as f64 - numbers);
    }
}

/// Sum of the squares of a path's parts of up to so many cycles over its time.
fn power(time: &[f64], path: &[f64], cycles: usize) -> f64 {
    let count = path.len() as f64;
    let length = (time[time.len() - 1] - time[0]) * count / (count - 1.0);
    let of = |k: usize| {
        let part = |k: usize| -> [f64; 2] {
            time.iter().zip(path).fold([0.0; 2], |[a, b], (t, x)| {
                let (sin, cos) = (TAU * k as f64 * (t - time[0]) / length).sin_cos();
                [a + x * cos, b + x * sin]
            })
        };
        let [a, b] = part(k);
        (a * a + b * b) * if k == 0 { 1.0 } else { 2.0 } / count
    };
    (0..=cycles).map(of).sum()
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    use super::super::Plan;
    use super::super::tests::swing;
    use super::*;
    use crate::normal::normal;

    /// A process of first order of 0.1 mm whose neighbours are correlated by r has the density
    /// `(1 − r²) / (1 − 2 r cos ω + r²)`, whose mean up to ω is `2 arctan((1 + r) / (1 − r) tan ω/2) / ω`. The mean of forty recordings,
    /// each of which knows the density from some thirty numbers; a form takes more of what is slowest.
    #[test]
    fn size_and_colour_of_noise_are_seen() {
        for correlation in [0.0, 0.6] {
            let (mut deviation, mut slow) = (0.0, 0.0);
            for seed in 0..40 {
                let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
                let mut state = [0.0; 2];
                let fresh = f64::sqrt(1.0 - correlation * correlation);
                let noise: Vec<[f64; 2]> = (0..800)
                    .map(|_| {
                        state = state.map(|x: f64| correlation * x + fresh * normal(&mut random));
                        state.map(|x| 1e-4 * x)
                    })
                    .collect();
                let plan = Plan::of(&swing(1.4, 0.5, |k| noise[k]), false).unwrap();
                deviation += plan.noise.deviation / 40.0;
                slow += plan.noise.slow / 40.0;
            }
            let highest = SLOW * TAU * 1.4 * 0.01;
            let due =
                2.0 * ((1.0 + correlation) / (1.0 - correlation) * f64::tan(0.5 * highest)).atan() / highest;
            assert!((deviation / 1e-4 - 1.0).abs() < 0.05, "{correlation}: {deviation}");
            assert!((slow / due - 1.0).abs() < 0.18, "{correlation}: {slow}, due {due}");
        }
    }
}
