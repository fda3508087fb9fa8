//! Amplitude and phase of a swing, read off the path of a point.

/// Amplitude, rad, and phase, rad, of each point of a path in W, from its angle about the clamp: the angle
/// off the rest is the amplitude times the cosine of the phase, and the phase grows with time.
pub(super) fn swing(time: &[f64], path: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let angle: Vec<f64> = path.iter().map(|[x, z]| z.atan2(*x)).collect();
    let n = angle.len();
    // The rest, about which the last tenth still swings.
    let late = &angle[n - n.div_ceil(10)..];
    let rest = late.iter().sum::<f64>() / late.len() as f64;
    let rate = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
        (angle[b] - angle[a]) / (time[b] - time[a]).max(f64::MIN_POSITIVE)
    };
    let (mut squares, mut rates) = (0.0, 0.0);
    for k in 0..n {
        squares += (angle[k] - rest).powi(2);
        rates += rate(k).powi(2);
    }
    let frequency = (rates / squares.max(f64::MIN_POSITIVE)).sqrt().max(f64::MIN_POSITIVE);
    let of_sample = |k: usize| {
        let (across, along) = (angle[k] - rest, -rate(k) / frequency);
        [across.hypot(along), along.atan2(across)]
    };
    (0..n).map(of_sample).collect()
}

/// Makes the amplitudes shares of the largest of all.
pub(super) fn share_of_largest(all: &mut [Vec<[f64; 2]>]) {
    let amplitudes = all.iter().flatten().map(|[amplitude, _]| *amplitude);
    let largest = amplitudes.fold(f64::MIN_POSITIVE, f64::max);
    all.iter_mut().flatten().for_each(|[amplitude, _]| *amplitude /= largest);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn a_decaying_swing_has_its_own_amplitude_and_phase() {
        let time: Vec<f64> = (0..2000).map(|k| 0.005 * f64::from(k)).collect();
        let angle = |t: f64| -0.4 + 0.3 * (-0.5 * t).exp() * (7.0 * t).cos();
        let path: Vec<[f64; 2]> = time.iter().map(|t| [angle(*t).cos(), angle(*t).sin()]).collect();
        let found = swing(&time, &path);
        for (t, [amplitude, phase]) in time.iter().zip(&found).skip(1).take(800) {
            // The rate of the decay, a fourteenth of the frequency, is taken for a part of the swing.
            assert!((amplitude / (0.3 * (-0.5 * t).exp()) - 1.0).abs() < 0.09, "{t}: {amplitude}");
            let off = (phase - 7.0 * t + PI).rem_euclid(2.0 * PI) - PI;
            assert!(off.abs() < 0.09, "{t}: {off}");
        }
    }
}
