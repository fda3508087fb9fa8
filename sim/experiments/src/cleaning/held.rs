//! Whether a path moves at all, and whether the tip is held still at an instant that is given.

use std::ops::Range;

use efam_core::quantile::quantile;

use super::distance;
use super::motion::Motion;

/// Range of the tip along the axis on which it moves most, m, if that is noise: no wider than so many standard deviations, of
/// the noise or of the rounding that hides it.
pub(super) fn only_noise(path: &[Option<[f64; 3]>], sigma: f64) -> Option<f64> {
    let mut widest: f64 = 0.0;
    for k in 0..3 {
        let mut values: Vec<f64> = path.iter().flatten().map(|at| at[k]).collect();
        values.sort_by(f64::total_cmp);
        let steps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
        let digit = steps.fold(f64::INFINITY, f64::min);
        let [low, high] = [0.01, 0.99].map(|share| quantile(values.clone(), share));
        let width = high.zip(low).map_or(0.0, |(high, low)| high - low);
        if width > NOISE_WIDTH * sigma && width > MOST_DIGITS * digit {
            return None;
        }
        widest = widest.max(width);
    }
    Some(widest)
}

/// Standard deviations over which nearly all of noise lies.
const NOISE_WIDTH: f64 = 8.0;
/// Steps of the last digit within which motion and rounding cannot be separated.
const MOST_DIGITS: f64 = 3.0;
/// Share of the fastest speed with which a tip is not let go from rest. A hand that lowers a rod before it lets go stays below.
const MOVING: f64 = 0.2;
/// Shares of its range over which a swing from rest is a parabola, by as many samples as come and by four.
const PARABOLA: [f64; 2] = [0.25, 0.6];

/// Speed of the tip at an instant that is given, m/s, if it is not held there: that of the hold or, if the recording begins
/// with the instant, that with which its first samples begin.
pub(super) fn speed_at(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    motion: &Motion,
    sigma: f64,
    hold: &Range<usize>,
    fastest: f64,
) -> Option<f64> {
    let is_moving = |speed: &f64| *speed > MOVING * fastest;
    if hold.len() > 3 {
        let speeds: Vec<f64> = hold.clone().filter_map(|i| motion.speed(i)).collect();
        return quantile(speeds, 0.5).filter(is_moving);
    }
    let first = (hold.start..path.len()).find(|i| path[*i].is_some())?;
    let origin = path[first].expect("it is seen");
    let range = path.iter().flatten().map(|at| distance(*at, origin)).fold(0.0, f64::max);
    let seen: Vec<(f64, [f64; 3])> = (first..path.len())
        .filter_map(|i| Some((time[i] - time[first], path[i]?)))
        .enumerate()
        .take_while(|(k, (_, at))| *k < 4 || distance(*at, origin) < PARABOLA[0] * range)
        .map(|(_, own)| own)
        .collect();
    let is_short = seen.iter().all(|(_, at)| distance(*at, origin) < PARABOLA[1] * range);
    let rows = nalgebra::DMatrix::from_fn(seen.len(), 3, |i, k| seen[i].0.powi(k as i32));
    let inverse = (rows.transpose() * &rows).try_inverse().filter(|_| is_short && seen.len() > 3)?;
    let slopes = &inverse * rows.transpose();
    let speed = (0..3)
        .map(|k| seen.iter().enumerate().map(|(i, (_, at))| slopes[(1, i)] * at[k]).sum::<f64>().powi(2))
        .sum::<f64>()
        .sqrt();
    let error = sigma * inverse[(1, 1)].sqrt();
    Some(speed).filter(is_moving).filter(|speed| *speed > 3.0 * error)
}

#[cfg(test)]
mod tests {
    use super::super::cycles::{cut, cut_in_motion};
    use super::super::distance;
    use super::super::tests::{Noise, falling_swing};

    /// Noise alone, white or rounded, is no release, whether instants are given or not.
    #[test]
    fn noise_is_no_release() {
        let mut noise = Noise::new(11);
        let time: Vec<f64> = (0..600).map(|i| 0.01 * f64::from(i)).collect();
        let mut white: Vec<_> = time.iter().map(|_| Some([0.2, 0.0, 0.0])).collect();
        noise.disturb(&mut white, 3e-4);
        let rounded: Vec<_> =
            white.iter().map(|at| at.map(|at: [f64; 3]| at.map(|x| (x / 1e-3).round() * 1e-3))).collect();
        for (path, sigma) in [(&white, 3e-4), (&rounded, 1e-7)] {
            for given in [None, Some(&[0.0][..])] {
                let why = cut(&time, path, 0.01, sigma, given).unwrap_err();
                assert!(why.starts_with("nothing moves") || why.contains("which is no release"), "{why}");
            }
            assert!(cut_in_motion(&time, path, 0.01, sigma, None).unwrap_err().starts_with("nothing moves"));
        }
    }

    /// A recording that begins anywhere in a swing but near a turn does not begin with a release from rest, at 100 Hz or at 50.
    #[test]
    fn a_recording_that_begins_in_mid_swing_has_no_release_at_its_first_sample() {
        for step in [0.01, 0.02] {
            let mut noise = Noise::new(12);
            let (time, mut path) = falling_swing(0.0, 6.0, 0.2, 8.0, step);
            noise.disturb(&mut path, 1e-4);
            let from = |first: usize| {
                let time: Vec<f64> = time[first..].iter().map(|t| t - time[first]).collect();
                cut(&time, &path[first..], step, 1e-4, Some(&[0.0]))
            };
            assert_eq!(from(0).unwrap().len(), 1);
            // A period takes 0.785 s.
            for begin in [0.06, 0.12, 0.2, 0.28, 0.44, 0.54, 0.64, 0.94] {
                let why = from((begin / step) as usize).unwrap_err();
                assert!(why.contains("not let go from rest"), "{begin} s: {why}");
                let first = (begin / step) as usize;
                let time: Vec<f64> = time[first..].iter().map(|t| t - time[first]).collect();
                let cuts = cut_in_motion(&time, &path[first..], step, 1e-4, None).unwrap();
                assert_eq!((cuts.len(), cuts[0].hold.clone()), (1, 0..1), "{begin} s");
                assert!(distance(cuts[0].rest, [0.15, 0.0, -0.12]) < 5e-3, "{begin} s: {cuts:?}");
            }
            // Nor is there one in the midst of it.
            assert!(
                cut(&time, &path, step, 1e-4, Some(&[1.1])).unwrap_err().contains("not let go from rest")
            );
        }
    }
}
