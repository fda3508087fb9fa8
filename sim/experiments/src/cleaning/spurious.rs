//! Points that a camera saw where no marker was: single samples, found by what their neighbours say.
//!
//! A cubic through the two samples on either side predicts the one between. The distance from it is
//! a fourth difference, which hardly sees a release (a jump of acceleration `a` leaves at most
//! `0.11 a h²`) and not at all a smooth swing, but all of a ghost. What counts as far is local: noise
//! of the recording, the same distances nearby, and the second differences nearby; so the fast start
//! of a release is not taken for a ghost, and small beams are compared with their own swings.
//!
//! Bursts, whose points agree with one another, are found in `bursts.rs`.

use efam_core::quantile::quantile;

use super::{distance, noise};

/// Noise of the prediction error over noise of a sample: `√(1 + 34/36)`.
const OF_NOISE: f64 = 1.394;
/// Noise that may be, in standard deviations.
const MOST_NOISE: f64 = 8.0;
/// Share of the prediction errors nearby (their upper quartile) that may be.
const MOST_LOCAL: f64 = 4.0;
/// Share of the second differences nearby (nine tenths of them lie below) that may be: the jump of
/// acceleration at a release shows with 0.11 of it.
const MOST_BEND: f64 = 0.25;
/// Samples on either side that are nearby.
const NEARBY: usize = 10;
/// Samples apart within which a point spoils the prediction of another.
const SPOILT: usize = 2;
/// Longest gap in samples over which neighbours still predict.
const MOST_GAP: usize = 6;

/// Marks single samples that do not lie where their neighbours put them; `step` is the usual time
/// between samples, s.
pub fn find(time: &[f64], path: &[Option<[f64; 3]>], step: f64) -> Vec<bool> {
    let mut path = path.to_vec();
    let mut found = vec![false; path.len()];
    let sigma = noise::of_path(time, &path, step).unwrap_or(0.0);
    // Each round removes the largest outlier nearby.
    for _ in 0..12 {
        let errors = prediction_errors(time, &path, step);
        let bends = bends(time, &path, step);
        // Two that spoil the predictions of the same samples hide one another.
        let second = |i: usize| {
            let beside = i.saturating_sub(2 * SPOILT)..(i + 2 * SPOILT + 1).min(path.len());
            beside
                .filter(|&j| j != i && path[j].is_some())
                .find(|&j| are_both_far(time, &path, step, [i, j], sigma))
        };
        let of = |i: usize| {
            if stands_alone(time, &path, step, i, sigma) {
                vec![i]
            } else {
                second(i).map_or(Vec::new(), |j| vec![i, j])
            }
        };
        let far: Vec<usize> = (0..path.len())
            .filter(|&i| is_far(&errors, &bends, i, sigma) && is_top(&errors, i))
            .flat_map(of)
            .collect();
        if far.is_empty() {
            break;
        }
        for i in far {
            found[i] = true;
            path[i] = None;
        }
    }
    found
}

fn is_far(errors: &[Option<f64>], bends: &[Option<f64>], i: usize, sigma: f64) -> bool {
    let Some(error) = errors[i] else { return false };
    let low = i.saturating_sub(NEARBY);
    let high = (i + NEARBY + 1).min(errors.len());
    let nearby = |all: &[Option<f64>], share: f64| {
        let others = (low..high).filter(|k| k.abs_diff(i) > SPOILT).filter_map(|k| all[k]);
        quantile(others.collect(), share).unwrap_or(0.0)
    };
    let noise = MOST_NOISE * OF_NOISE * sigma;
    error > noise.max(MOST_LOCAL * nearby(errors, 0.75)) + MOST_BEND * nearby(bends, 0.9)
}

/// Of the samples from one to another and of those beside them, once some are gone, whether they are far; none where
/// that cannot be determined.
fn beside(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    step: f64,
    (from, to): (usize, usize),
    gone: &[usize],
    sigma: f64,
) -> Vec<(usize, Option<bool>)> {
    let low = from.saturating_sub(2 * NEARBY);
    let high = (to + 2 * NEARBY + 1).min(path.len());
    let mut left = path[low..high].to_vec();
    gone.iter().for_each(|i| left[i - low] = None);
    let errors = prediction_errors(&time[low..high], &left, step);
    let bends = bends(&time[low..high], &left, step);
    let all = (from - low).saturating_sub(SPOILT)..(to - low + SPOILT + 1).min(high - low);
    let told = |k: usize| (k + low, errors[k].map(|_| is_far(&errors, &bends, k, sigma)));
    all.filter(|k| left[*k].is_some()).map(told).collect()
}

/// Whether the samples beside one agree once it is gone. At the edge of a burst they do not, and nobody
/// can determine from a few samples which side is the marker.
fn stands_alone(time: &[f64], path: &[Option<[f64; 3]>], step: f64, i: usize, sigma: f64) -> bool {
    beside(time, path, step, (i, i), &[i], sigma).iter().all(|(_, is_far)| *is_far != Some(true))
}

/// Whether each of two is far from where its neighbours put it without the other, and all beside them agree without
/// both.
fn are_both_far(time: &[f64], path: &[Option<[f64; 3]>], step: f64, [i, j]: [usize; 2], sigma: f64) -> bool {
    let without = |gone: &[usize]| beside(time, path, step, (i.min(j), i.max(j)), gone, sigma);
    without(&[j]).contains(&(i, Some(true)))
        && without(&[i]).contains(&(j, Some(true)))
        && without(&[i, j]).iter().all(|(_, is_far)| *is_far == Some(false))
}

fn is_top(errors: &[Option<f64>], i: usize) -> bool {
    let low = i.saturating_sub(SPOILT);
    let high = (i + SPOILT + 1).min(errors.len());
    errors[low..high].iter().flatten().all(|other| *other <= errors[i].unwrap_or(0.0))
}

/// Distance of each sample from the cubic through two neighbours on either side, m.
fn prediction_errors(time: &[f64], path: &[Option<[f64; 3]>], step: f64) -> Vec<Option<f64>> {
    let seen: Vec<usize> = (0..path.len()).filter(|&i| path[i].is_some()).collect();
    let mut errors = vec![None; path.len()];
    for five in seen.windows(5) {
        let i = five[2];
        if time[five[4]] - time[five[0]] > (MOST_GAP + 4) as f64 * step {
            continue;
        }
        let others = [five[0], five[1], five[3], five[4]];
        let mut predicted = [0.0; 3];
        for &k in &others {
            let weight: f64 = (others.iter().filter(|&&other| other != k))
                .map(|&other| (time[i] - time[other]) / (time[k] - time[other]))
                .product();
            let at = path[k].unwrap_or_default();
            (0..3).for_each(|c| predicted[c] += weight * at[c]);
        }
        errors[i] = path[i].map(|at| distance(at, predicted));
    }
    errors
}

/// Second difference around each sample whose two neighbours are seen, m.
fn bends(time: &[f64], path: &[Option<[f64; 3]>], step: f64) -> Vec<Option<f64>> {
    let mut bends = vec![None; path.len()];
    for i in 1..path.len().saturating_sub(1) {
        if let (Some(a), Some(b), Some(c)) = (path[i - 1], path[i], path[i + 1])
            && time[i + 1] - time[i - 1] < 3.0 * step
        {
            bends[i] = Some(bend(a, b, c));
        }
    }
    bends
}

/// Length of the second difference of three points, m.
pub(super) fn bend(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - 2.0 * b[k] + c[k]).powi(2)).sum::<f64>().sqrt()
}

/// Distance of a point from the straight line between the samples that are left on either side, m.
pub(super) fn from_neighbours(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    i: usize,
    point: Option<[f64; 3]>,
) -> Option<f64> {
    let point = point?;
    let before = (0..i).rev().find(|&k| path[k].is_some())?;
    let after = (i + 1..path.len()).find(|&k| path[k].is_some())?;
    let (a, b) = (path[before]?, path[after]?);
    let share = (time[i] - time[before]) / (time[after] - time[before]);
    Some(distance(point, std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::tests::{Noise, falling_swing};

    #[test]
    fn a_ghost_is_found_and_the_release_is_left_alone() {
        let mut noise = Noise::new(3);
        for sigma in [0.0, 3e-6, 1e-4, 5e-4] {
            let (time, mut path) = falling_swing(1.23, 6.0, 0.2, 8.0, 0.01);
            noise.disturb(&mut path, sigma);
            assert!(!find(&time, &path, 0.01).contains(&true), "nothing is wrong at {sigma}");
            let ghosts = [
                (40, 0.2),
                (122, 0.03),
                (163, -0.05),
                (300, 0.01),
                (397, 0.08),
                (399, 0.17),
                (430, 0.12),
                (431, -0.07),
                (461, 0.1),
                (465, 0.1),
                (511, 0.15),
            ];
            for (i, off) in ghosts {
                path[i].as_mut().unwrap()[2] += off;
            }
            let found: Vec<usize> = find(&time, &path, 0.01)
                .iter()
                .enumerate()
                .filter(|(_, found)| **found)
                .map(|(i, _)| i)
                .collect();
            assert_eq!(found, ghosts.map(|(i, _)| i), "at {sigma}");
        }
    }
}
