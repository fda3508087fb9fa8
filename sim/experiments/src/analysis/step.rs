//! The numbers of a step response, by the definitions of MATLAB's `stepinfo`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Excursion, peaks::refined, settling::settles_within};

/// A coordinate from an event on, with a known steady state. Times count from the event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Step {
    /// At the event.
    pub start_m: f64,
    /// Where it comes to rest.
    pub steady_m: f64,
    /// From a tenth to nine tenths of the way, first crossings; none where nine tenths are not reached.
    pub rise_s: Option<f64>,
    /// How far it goes beyond the steady state, over the way.
    pub overshoot_percent: f64,
    /// The place farthest from the start, on the side of the steady state.
    pub peak_m: f64,
    /// When it is there.
    pub peak_s: f64,
    /// After which it stays within 2 % of the way about the steady state; none where it does not.
    pub settling_2_percent_s: Option<f64>,
    /// The same for 5 %.
    pub settling_5_percent_s: Option<f64>,
}

impl Step {
    /// The same with its times later by the time from the event to the first sample, s.
    pub fn later(self, by: f64) -> Self {
        let later = |time: Option<f64>| time.map(|time| time + by);
        Self {
            peak_s: self.peak_s + by,
            settling_2_percent_s: later(self.settling_2_percent_s),
            settling_5_percent_s: later(self.settling_5_percent_s),
            ..self
        }
    }
}

/// The response of samples `spacing` apart, s, to a steady state; `least` is the way below which there is none, m.
///
/// # Errors
/// Why there is none, in words.
pub fn step(values: &[f64], spacing: f64, steady: f64, least: f64) -> Result<Step, String> {
    let Some(&start) = values.first() else { return Err("no sample was reached".to_owned()) };
    let way = steady - start;
    if way.abs() <= least {
        let way = models::digits::short(1e3 * way.abs());
        return Err(format!("its steady state is {way} mm from its start: there is no step"));
    }
    // One at the steady state, zero at the start.
    let shares: Vec<f64> = values.iter().map(|value| (value - start) / way).collect();
    let crossing = |level: f64| {
        let k = (1..shares.len()).find(|&k| shares[k] >= level)?;
        let [before, after] = [shares[k - 1], shares[k]];
        Some((k as f64 - (after - level) / (after - before)) * spacing)
    };
    let (at, peak) = vertex(&shares);
    let off = Excursion::about(1.0, &shares, spacing).map_err(|error| error.to_string())?;
    let settling = |band| settles_within(&off, band).ok();
    Ok(Step {
        start_m: start,
        steady_m: steady,
        rise_s: crossing(0.9).zip(crossing(0.1)).map(|(high, low)| high - low),
        overshoot_percent: 100.0 * (peak - 1.0).max(0.0),
        peak_m: start + way * peak,
        peak_s: at * spacing,
        settling_2_percent_s: settling(0.02),
        settling_5_percent_s: settling(0.05),
    })
}

/// Place, in samples, and height of the highest, between samples by a parabola.
fn vertex(values: &[f64]) -> (f64, f64) {
    let top = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a))).unwrap_or(0);
    if top == 0 || top + 1 == values.len() {
        return (top as f64, values[top]);
    }
    refined(values, top, 1.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A second-order system: overshoot `exp(−π ζ/√(1 − ζ²))` at `π/ω_d`.
    #[test]
    fn a_second_order_system_has_its_closed_form() {
        let (zeta, omega, spacing) = (0.2f64, 7.0, 1e-3);
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let values: Vec<f64> = (0..8000)
            .map(|k| spacing * f64::from(k))
            .map(|t| {
                let swing = (damped * t).cos() + zeta * omega / damped * (damped * t).sin();
                0.3 - 0.1 * (1.0 - (-zeta * omega * t).exp() * swing)
            })
            .collect();
        let found = step(&values, spacing, 0.2, 1e-9).unwrap();
        let overshoot = 100.0 * (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((found.overshoot_percent / overshoot - 1.0).abs() < 1e-6, "{found:?} {overshoot}");
        assert!((found.peak_s * damped / PI - 1.0).abs() < 1e-5, "{found:?}");
        assert!((found.peak_m - (0.2 - 1e-3 * overshoot)).abs() < 1e-8, "{found:?}");
        let rise = rise_by_bisection(zeta, omega);
        assert!((found.rise_s.unwrap() - rise).abs() < 1e-5, "{found:?} {rise}");
        let (two, five) = (found.settling_2_percent_s.unwrap(), found.settling_5_percent_s.unwrap());
        // Within half a period of where the envelope crosses the band.
        for (time, band) in [(two, 0.02f64), (five, 0.05)] {
            let envelope = -(band * (1.0 - zeta * zeta).sqrt()).ln() / (zeta * omega);
            assert!(time <= envelope && time > envelope - PI / damped, "{time} {envelope}");
        }
    }

    /// Time from a tenth to nine tenths, by bisection in the closed form.
    fn rise_by_bisection(zeta: f64, omega: f64) -> f64 {
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let share = |t: f64| {
            1.0 - (-zeta * omega * t).exp()
                * ((damped * t).cos() + zeta * omega / damped * (damped * t).sin())
        };
        let crossing = |level: f64| {
            let (mut low, mut high) = (0.0, PI / damped);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if share(middle) < level { low = middle } else { high = middle }
            }
            low
        };
        crossing(0.9) - crossing(0.1)
    }

    #[test]
    fn no_way_is_no_step_and_a_short_window_does_not_settle() {
        assert!(step(&[0.1; 10], 0.1, 0.1, 1e-6).unwrap_err().contains("there is no step"));
        assert!(step(&[], 0.1, 0.1, 1e-6).is_err());
        let rising = step(&[0.0, 0.1, 0.2, 0.3], 0.1, 1.0, 1e-6).unwrap();
        assert_eq!((rising.rise_s, rising.settling_2_percent_s), (None, None));
    }
}
