//! Turns: the instants at which a swing reverses.
//!
//! They are found with a hysteresis, which noise does not pass, and then refined by least squares of a constant, a cosine
//! and a sine over about a quarter of the period to each side. The weights fall smoothly to zero, so the instants are smooth
//! functions of the track.

use nalgebra::{Matrix3, Vector3};

/// Half the width of the local fit, over the period: a little more than a quarter, so that the turn is well inside.
const HALF_WIDTH: f64 = 0.27;
/// The same in sample intervals at least: five samples determine three numbers.
const LEAST_HALF_WIDTH: f64 = 2.6;
/// Change of an instant, over the period, at which the refinement ends: differences of features are taken over 1e-5.
const CONVERGED: f64 = 1e-12;
/// Rounds of the refinement at most; each gains a digit or more.
const MOST_ROUNDS: usize = 30;

/// Places of the turns of a track whose swing reverses by more than `hysteresis`. The first sample is none.
pub fn find(q: &[f64], hysteresis: f64) -> Vec<usize> {
    let Some(first) = q.first().copied() else { return Vec::new() };
    let (mut high, mut low) = ((first, 0), (first, 0));
    let mut rising: Option<bool> = None;
    let mut turns = Vec::new();
    for (k, &value) in q.iter().enumerate().skip(1) {
        if value > high.0 {
            high = (value, k);
        }
        if value < low.0 {
            low = (value, k);
        }
        let falls = high.0 - value > hysteresis;
        let rises = value - low.0 > hysteresis;
        match rising {
            None if falls && high.1 > 0 && high.0 - first > hysteresis => {
                turns.push(high.1);
                (rising, low) = (Some(false), (value, k));
            }
            None if rises && low.1 > 0 && first - low.0 > hysteresis => {
                turns.push(low.1);
                (rising, high) = (Some(true), (value, k));
            }
            Some(true) if falls => {
                turns.push(high.1);
                (rising, low) = (Some(false), (value, k));
            }
            Some(false) if rises => {
                turns.push(low.1);
                (rising, high) = (Some(true), (value, k));
            }
            _ => {}
        }
    }
    turns
}

/// Constant, cosine and sine about `center` by weighted least squares; none where too few samples are near.
pub fn local(time: &[f64], q: &[f64], center: f64, period: f64, interval: f64) -> Option<[f64; 3]> {
    let half = (HALF_WIDTH * period).max(LEAST_HALF_WIDTH * interval);
    let rate = std::f64::consts::TAU / period;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let first = time.partition_point(|t| *t <= center - half);
    for (t, q) in time[first..].iter().zip(&q[first..]) {
        let from = t - center;
        if from >= half {
            break;
        }
        let weight = (1.0 - (from / half).powi(2)).powi(2);
        let row = Vector3::new(1.0, (rate * from).cos(), (rate * from).sin());
        normal += weight * row * row.transpose();
        right += weight * *q * row;
    }
    let found = normal.cholesky()?.solve(&right);
    found.iter().all(|c| c.is_finite()).then(|| [found[0], found[1], found[2]])
}

/// Periods about each turn, from its neighbours.
pub fn periods(turns: &[f64]) -> Vec<f64> {
    let half = |k: usize| turns[k + 1] - turns[k];
    let last = turns.len() - 1;
    (0..=last)
        .map(|k| match k {
            0 => 2.0 * half(0),
            k if k == last => 2.0 * half(k - 1),
            k => half(k - 1) + half(k),
        })
        .collect()
}

/// Refines instants of turns until they no longer change. Fewer than two are returned as they are.
pub fn refine(time: &[f64], q: &[f64], turns: &mut [f64], interval: f64) {
    if turns.len() < 2 {
        return;
    }
    for _ in 0..MOST_ROUNDS {
        let periods = periods(turns);
        let mut moved: f64 = 0.0;
        for (turn, period) in turns.iter_mut().zip(periods) {
            let Some([_, cosine, sine]) = local(time, q, *turn, period, interval) else { continue };
            let phase = if cosine == 0.0 { 0.0 } else { (sine / cosine).atan().clamp(-0.6, 0.6) };
            *turn += phase * period / std::f64::consts::TAU;
            moved = moved.max(phase.abs());
        }
        if moved <= CONVERGED || moved.is_nan() {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(rate: f64, loss: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..600).map(|k| 0.01 * f64::from(k)).collect();
        let q = time.iter().map(|t| (-loss * t).exp() * (rate * t).cos()).collect();
        (time, q)
    }

    /// Without loss the turns are half periods; the start, where the rod is at rest, is none.
    #[test]
    fn turns_of_a_cosine_are_half_periods() {
        let rate = 8.3;
        let (time, q) = track(rate, 0.0);
        let mut turns: Vec<f64> = find(&q, 0.05).into_iter().map(|k| time[k]).collect();
        refine(&time, &q, &mut turns, 0.01);
        assert!(turns.len() > 12);
        for (k, turn) in turns.iter().take(12).enumerate() {
            let due = (k + 1) as f64 * std::f64::consts::PI / rate;
            assert!((turn - due).abs() < 1e-9, "turn {k}: {turn}, due {due}");
        }
    }

    /// A decaying swing turns by `atan(δ/ω)/ω` earlier. The local form has no decay: it sees more than half of that, and not all.
    #[test]
    fn loss_brings_turns_forward() {
        let (rate, loss) = (8.3, 0.4);
        let (time, q) = track(rate, loss);
        let mut turns: Vec<f64> = find(&q, 0.01).into_iter().map(|k| time[k]).collect();
        refine(&time, &q, &mut turns, 0.01);
        let earlier = std::f64::consts::PI / rate - turns[0];
        let due = (loss / rate).atan() / rate;
        assert!(earlier > 0.5 * due && earlier < due, "{earlier}, due {due}");
    }

    #[test]
    fn a_track_that_does_not_turn_has_no_turns() {
        let q: Vec<f64> = (0..50).map(f64::from).collect();
        assert!(find(&q, 1.0).is_empty() && find(&[], 1.0).is_empty());
        let mut none: [f64; 0] = [];
        refine(&[], &[], &mut none, 0.01);
    }
}
