//! Noise of a marker, from third differences where it rests, so that no swing counts. What changes
//! slowly, such as creep or the heat of a camera, is no noise in this sense.

use efam_recordings::noise::variances;

/// Third differences that a median needs.
const LEAST: usize = 8;

/// Standard deviation of the noise of each coordinate, m: the root mean square over those of `axes`;
/// over the samples that `use_it` admits, or nothing if there are too few.
pub fn of_samples<const N: usize>(
    time: &[f64],
    path: &[Option<[f64; N]>],
    step: f64,
    use_it: impl Fn(usize) -> bool,
) -> Option<f64> {
    let in_a_row = |i: usize| time[i + 3] - time[i] < 3.5 * step;
    let variances = variances(path, LEAST, |i| in_a_row(i) && use_it(i) && use_it(i + 3))?;
    Some((variances.iter().sum::<f64>() / N as f64).sqrt())
}

/// Over a whole path, before it is known where the marker rests: too large where it mostly moves.
pub fn of_path(time: &[f64], path: &[Option<[f64; 3]>], step: f64) -> Option<f64> {
    of_samples(time, path, step, |_| true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::tests::Noise;

    #[test]
    fn white_noise_is_found_under_a_swing_and_ghosts() {
        let mut noise = Noise::new(7);
        let time: Vec<f64> = (0..2000).map(|i| 0.01 * i as f64).collect();
        let path: Vec<Option<[f64; 3]>> = (time.iter().enumerate())
            .map(|(i, t)| {
                let ghost = if i % 300 == 17 { 0.1 } else { 0.0 };
                let swing = 0.1 * (6.0 * t).sin();
                (i % 31 != 0).then(|| [0.2, swing + ghost, 0.0].map(|x| x + 2e-4 * noise.normal()))
            })
            .collect();
        let sigma = of_path(&time, &path, 0.01).unwrap();
        // 6000 correlated differences: the median is good to some 3 %; ghosts and swing add as much.
        assert!((sigma / 2e-4 - 1.0).abs() < 0.06, "{sigma}");
        assert_eq!(of_samples(&time, &path, 0.01, |i| i < 8), None);
    }
}
