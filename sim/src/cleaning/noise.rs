//! Noise of a marker: what no motion explains from one sample to the next.
//!
//! Third differences of four samples in a row see no constant, no straight motion and no steady
//! acceleration; of white noise their variance is 20 times that of a sample. The median of their
//! sizes is taken where the marker rests, so that neither a swing nor a ghost counts. What changes
//! slowly, such as creep or the heat of a camera, is no noise in this sense.

/// Standard deviation of one coordinate over that of the median size of a normal number.
const OF_MEDIAN: f64 = 1.482_602;
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
    let mut differences: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for i in 0..path.len().saturating_sub(3) {
        let (Some(a), Some(b), Some(c), Some(d)) = (path[i], path[i + 1], path[i + 2], path[i + 3]) else {
            continue;
        };
        if time[i + 3] - time[i] < 3.5 * step && use_it(i) && use_it(i + 3) {
            for k in 0..N {
                differences[k].push((d[k] - 3.0 * c[k] + 3.0 * b[k] - a[k]).abs());
            }
        }
    }
    if differences[0].len() < LEAST {
        return None;
    }
    let square = differences.into_iter().filter_map(|all| super::spurious::quantile(all, 0.5));
    let square: f64 = square.map(|median| (OF_MEDIAN * median).powi(2) / 20.0).sum();
    Some((square / N as f64).sqrt())
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
