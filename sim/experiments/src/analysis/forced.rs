//! Gain and phase of a coordinate under a periodic force.

use std::f64::consts::{PI, TAU};

use models::digits::significant;
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The answer of a coordinate at the frequency of a force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Response {
    /// Amplitude at that frequency.
    pub amplitude_m: f64,
    /// Amplitude over that of the force.
    pub gain_m_per_n: f64,
    /// Phase relative to the force; negative where the coordinate lags.
    pub phase_rad: f64,
}

/// Periods that are compared with as many before them, at least and at most.
const PERIODS: [f64; 2] = [1.0, 10.0];
/// Change of the amplitude from these to those, as a share, from which on the start is not over.
const STEADY: f64 = 0.005;

/// The answer of a coordinate, `(values, time of the first, spacing)`, to a force, `(times, values)`, at a frequency, Hz: over the
/// last whole periods.
/// # Errors
/// Why there is none, in words.
pub fn response(
    (values, begin, spacing): (&[f64], f64, f64),
    force: (&[f64], &[f64]),
    hertz: f64,
) -> Result<Response, String> {
    let end = begin + spacing * values.len().saturating_sub(1) as f64;
    let periods = (0.25 * (end - begin) * hertz).floor().min(PERIODS[1]);
    if periods < PERIODS[0] {
        return Err(format!(
            "fewer than four periods of the force, {} Hz, are simulated",
            significant(hertz, 3)
        ));
    }
    let length = periods / hertz;
    let of_tip = |from: f64, to: f64| {
        let points = values.iter().enumerate().map(|(k, value)| (begin + spacing * k as f64, *value));
        harmonic(points.filter(|(time, _)| (from..=to).contains(time)), hertz)
    };
    let last = of_tip(end - length, end).ok_or("too few samples in a period of the force")?;
    let before =
        of_tip(end - 2.0 * length, end - length).ok_or("too few samples in a period of the force")?;
    let size = |[cos, sin]: [f64; 2]| cos.hypot(sin);
    let change = (last[0] - before[0]).hypot(last[1] - before[1]) / size(last);
    if change.is_nan() || change > STEADY {
        let percent = significant(100.0 * change, 2);
        return Err(format!(
            "the answer is not steady yet: it changes by {percent} % in {periods} periods; try a longer run"
        ));
    }
    let points = force.0.iter().copied().zip(force.1.iter().copied());
    let own = harmonic(points.filter(|(time, _)| (end - length..=end).contains(time)), hertz)
        .ok_or("too few values of the force in its period")?;
    // Of A cos(ωt − φ): the phase is −φ.
    let phase = |[cos, sin]: [f64; 2]| -sin.atan2(cos);
    let turn = phase(last) - phase(own);
    Ok(Response {
        amplitude_m: size(last),
        gain_m_per_n: size(last) / size(own),
        phase_rad: turn - TAU * ((turn + PI) / TAU).floor(),
    })
}

/// Amplitudes of cosine and sine at a frequency, by least squares beside a constant.
fn harmonic(points: impl Iterator<Item = (f64, f64)>, hertz: f64) -> Option<[f64; 2]> {
    let (mut matrix, mut right) = (Matrix3::<f64>::zeros(), Vector3::zeros());
    for (time, value) in points {
        let (sin, cos) = (TAU * hertz * time).sin_cos();
        let row = Vector3::new(1.0, cos, sin);
        matrix += row * row.transpose();
        right += value * row;
    }
    let found = matrix.cholesky()?.solve(&right);
    Some([found[1], found[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_is_a_negative_phase() {
        let times: Vec<f64> = (0..=3000).map(|k| 0.01 * f64::from(k)).collect();
        let force: Vec<f64> = times.iter().map(|t| 0.02 * (TAU * t).sin()).collect();
        let tip: Vec<f64> =
            times.iter().map(|t| 0.3 + 0.005 * (TAU * t - 0.7).sin() + 0.02 * (-2.0 * t).exp()).collect();
        let found = response((&tip, 0.0, 0.01), (&times, &force), 1.0).unwrap();
        assert!((found.gain_m_per_n / 0.25 - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found.phase_rad + 0.7).abs() < 1e-3, "{found:?}");
        let early = response((&tip[..300], 0.0, 0.01), (&times, &force), 1.0);
        assert!(early.unwrap_err().contains("fewer than four periods"));
        let growing: Vec<f64> = times.iter().map(|t| 0.001 * t * (TAU * t).sin()).collect();
        let why = response((&growing, 0.0, 0.01), (&times, &force), 1.0).unwrap_err();
        assert!(why.starts_with("the answer is not steady yet"), "{why}");
    }
}
