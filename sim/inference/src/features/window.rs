//! A window of a few cycles: frequency, loss, amplitude and mean of a swing, with its second harmonic.
//!
//! The form is `c + e^(−δτ) (a cos ωτ + b sin ωτ) + e^(−2δτ) (a₂ cos 2ωτ + b₂ sin 2ωτ)`, τ from the middle of the window.
//! Frequency and loss come from the leading coordinate by variable projection; the others are linear. Weights rise smoothly
//! over half of a half period about the turns that bound the window, so all numbers are smooth in the track.
//! Source: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, 413-432.

use nalgebra::{SMatrix, SVector};

/// Rounds of the fit at most.
const MOST_ROUNDS: usize = 25;
/// Change of frequency and loss, relative, at which it ends: differences of features are taken over 1e-5.
const CONVERGED: f64 = 1e-11;
/// Samples in a window at least, for seven unknowns.
const LEAST_SAMPLES: usize = 9;

/// What a window shows: shape of `coefficients` `[coordinates][c, a, b, a₂, b₂]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Rate of decay δ, 1/s.
    pub loss: f64,
    pub coefficients: Vec<[f64; 5]>,
}

/// Where a window begins and ends, s, and the half period there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub begin: f64,
    pub end: f64,
    pub half_period: f64,
}

impl Span {
    /// Weight of a sample: a smooth step about each end.
    fn weight(&self, time: f64) -> f64 {
        let ramp = 0.5 * self.half_period;
        let step = |from: f64| {
            let x = (from / ramp + 0.5).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        };
        step(time - self.begin) * step(self.end - time)
    }

    fn middle(&self) -> f64 {
        0.5 * (self.begin + self.end)
    }
}

/// The form and its rates at one time.
pub fn basis(from: f64, frequency: f64, loss: f64) -> [f64; 5] {
    let decay = (-loss * from).exp();
    let (sin, cos) = (std::f64::consts::TAU * frequency * from).sin_cos();
    let (first, second) = (decay, decay * decay);
    [1.0, first * cos, first * sin, second * (cos * cos - sin * sin), second * 2.0 * sin * cos]
}

/// Fits a window; `start` is frequency and loss from elsewhere. None where it has too few samples or no swing.
pub fn fit(time: &[f64], coordinates: &[Vec<f64>], span: &Span, start: (f64, f64)) -> Option<Fitted> {
    let ramp = 0.25 * span.half_period;
    let first = time.partition_point(|t| *t <= span.begin - ramp);
    let last = time.partition_point(|t| *t < span.end + ramp);
    if last < first + LEAST_SAMPLES {
        return None;
    }
    let weights: Vec<f64> = time[first..last].iter().map(|t| span.weight(*t)).collect();
    let from: Vec<f64> = time[first..last].iter().map(|t| t - span.middle()).collect();
    let leading = &coordinates.first()?[first..last];
    let (mut frequency, mut loss) = start;
    let mut rows = vec![[0.0; 5]; from.len()];
    let at = |rows: &mut Vec<[f64; 5]>, frequency: f64, loss: f64| {
        rows.iter_mut().zip(&from).for_each(|(row, from)| *row = basis(*from, frequency, loss));
    };
    at(&mut rows, frequency, loss);
    for _ in 0..MOST_ROUNDS {
        let linear = solved(rows.iter().copied(), &weights, leading.iter().copied())?;
        let value = |row: &[f64; 5]| row.iter().zip(&linear).map(|(b, c)| b * c).sum::<f64>();
        let residuals = rows.iter().zip(leading).map(|(row, q)| q - value(row));
        let extended = rows.iter().zip(&from).map(|(row, from)| with_slopes(row, &linear, *from));
        let step: [f64; 7] = solved(extended, &weights, residuals)?;
        let (df, dl) = (
            step[5].clamp(-0.1 * frequency, 0.1 * frequency),
            step[6].clamp(-0.5 * frequency, 0.5 * frequency),
        );
        frequency += df;
        loss = (loss + dl).clamp(-2.0 * frequency, 6.0 * frequency);
        if !(frequency.is_finite() && loss.is_finite() && frequency > 0.0) {
            return None;
        }
        at(&mut rows, frequency, loss);
        if df.abs() <= CONVERGED * frequency && dl.abs() <= CONVERGED * frequency {
            break;
        }
    }
    let all = |q: &Vec<f64>| solved(rows.iter().copied(), &weights, q[first..last].iter().copied());
    let coefficients = coordinates.iter().map(all).collect::<Option<Vec<_>>>()?;
    Some(Fitted { frequency, loss, coefficients })
}

/// The form at one time, and its derivatives by frequency and loss with the linear coefficients.
fn with_slopes(b: &[f64; 5], linear: &[f64; 5], from: f64) -> [f64; 7] {
    let by_phase = linear[2] * b[1] - linear[1] * b[2] + 2.0 * (linear[4] * b[3] - linear[3] * b[4]);
    let by_decay = linear[1] * b[1] + linear[2] * b[2] + 2.0 * (linear[3] * b[3] + linear[4] * b[4]);
    [b[0], b[1], b[2], b[3], b[4], std::f64::consts::TAU * from * by_phase, -from * by_decay]
}

/// Weighted least squares of rows; none where they do not determine the solution.
fn solved<const N: usize>(
    rows: impl Iterator<Item = [f64; N]>,
    weights: &[f64],
    values: impl Iterator<Item = f64>,
) -> Option<[f64; N]> {
    let (mut normal, mut right) = ([[0.0; N]; N], [0.0; N]);
    for ((row, weight), value) in rows.zip(weights).zip(values) {
        for a in 0..N {
            let weighted = weight * row[a];
            right[a] += weighted * value;
            for b in 0..=a {
                normal[a][b] += weighted * row[b];
            }
        }
    }
    let normal = SMatrix::<f64, N, N>::from_fn(|a, b| normal[a.max(b)][a.min(b)]);
    let found: [f64; N] = normal.cholesky()?.solve(&SVector::from(right)).into();
    found.iter().all(|c| c.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(f: f64, loss: f64, span: &Span) -> (Vec<f64>, Vec<Vec<f64>>) {
        let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        let of = |c: [f64; 5]| {
            let value = |t: &f64| basis(t - span.middle(), f, loss).iter().zip(&c).map(|(b, c)| b * c).sum();
            time.iter().map(value).collect()
        };
        let all = vec![of([0.3, 1.0, -0.4, 0.05, 0.02]), of([-0.1, 0.2, 0.1, 0.0, 0.01])];
        (time, all)
    }

    /// A track of the very form is found to all digits, from a start a tenth off.
    #[test]
    fn a_track_of_its_form_is_found() {
        let span = Span { begin: 0.5, end: 3.1, half_period: 0.35 };
        let (time, all) = made(1.43, 0.5, &span);
        let found = fit(&time, &all, &span, (1.3, 0.0)).unwrap();
        assert!((found.frequency - 1.43).abs() < 1e-9 && (found.loss - 0.5).abs() < 1e-8, "{found:?}");
        assert!(
            (found.coefficients[0][1] - 1.0).abs() < 1e-8 && (found.coefficients[1][4] - 0.01).abs() < 1e-9
        );
    }

    #[test]
    fn a_window_without_samples_shows_nothing() {
        let span = Span { begin: 10.0, end: 12.0, half_period: 0.5 };
        let (time, all) = made(1.0, 0.1, &span);
        assert_eq!(fit(&time, &all, &span, (1.0, 0.0)), None);
        let still = vec![vec![0.0; time.len()]];
        let there = Span { begin: 0.5, end: 2.5, half_period: 0.5 };
        // A rod that does not swing has no frequency: no panic, and nothing or a number.
        let _ = fit(&time, &still, &there, (1.0, 0.0));
    }
}
