//! Samples that were not taken: they repeat the one before, or lie on the line between two others, as programs write them that
//! log faster than their source delivers.
//!
//! A new sample then comes every few rows, at a steady pace. What is rounded coarsely and moves slowly changes at
//! steps of its last digit and at no steady pace.

use efam_core::quantile::quantile;

use super::Marker;
use super::clock::{plain, rate_of};
use super::order::retain;

/// Changes that show a pace.
const LEAST: usize = 20;
/// Share of the changes that must keep the pace.
const STEADY: f64 = 0.9;
/// Largest changes over the smallest, by which they are more than steps of the last digit.
const MORE_THAN_DIGITS: f64 = 2.5;
/// Share of repetitions here and there that is worth saying.
const WORTH: f64 = 0.01;
/// Bend of a line whose three points are rounded, in steps of the last digit, at most.
const BEND_OF_DIGITS: f64 = 2.001;

/// Which samples to keep if the others repeat them, or lie between them, at a steady pace; and what the others do.
pub(super) fn find(markers: &[Marker], findings: &mut Vec<String>) -> Option<(Vec<bool>, &'static str)> {
    let samples = markers.first().map_or(0, |marker| marker.position.len());
    let sizes: Vec<f64> = (1..samples).map(|i| change(markers, i)).collect();
    let finite = || sizes.iter().copied().filter(|size| *size > 0.0 && size.is_finite());
    let least = finite().fold(f64::INFINITY, f64::min);
    if quantile(finite().collect(), STEADY)? < MORE_THAN_DIGITS * least {
        return None;
    }
    let changes: Vec<usize> = (1..samples).filter(|i| sizes[i - 1] > 0.0).collect();
    if let Some(keep) = paced(samples, &changes) {
        return Some((keep, "each sample is repeated"));
    }
    let moves = |i: usize| sizes.get(i).is_some_and(|size| *size > MORE_THAN_DIGITS * least);
    let single = (1..sizes.len()).filter(|&i| sizes[i] == 0.0 && moves(i - 1) && moves(i + 1)).count();
    if single as f64 > WORTH * samples as f64 {
        findings.push(format!(
            "{single} samples repeat the one before while all around them move: were frames dropped and filled in?"
        ));
    }
    let digit = BEND_OF_DIGITS * least_change(markers);
    let bends: Vec<usize> = (1..samples.saturating_sub(1)).filter(|&i| bend(markers, i) > digit).collect();
    Some((paced(samples, &bends)?, "each sample is followed by points on the line to the next"))
}

/// Which samples to keep if fresh ones come at a steady pace, and more than one sample apart.
fn paced(samples: usize, changes: &[usize]) -> Option<Vec<bool>> {
    let gaps: Vec<f64> = changes.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let usual = quantile(gaps.clone(), 0.5).filter(|usual| *usual >= 2.0 && changes.len() > LEAST)?;
    let single: Vec<f64> = gaps.iter().copied().filter(|gap| *gap < 1.5 * usual).collect();
    let pace = single.iter().sum::<f64>() / single.len() as f64;
    let is_steady = |gap: &&f64| {
        let whole = (**gap / pace).round().max(1.0) * pace;
        ((whole + 0.05).floor()..=(whole - 0.05).ceil()).contains(*gap)
    };
    if (gaps.iter().filter(is_steady).count() as f64) < STEADY * gaps.len() as f64 {
        return None;
    }
    let mut keep = vec![false; samples];
    let edges: Vec<usize> = [0].into_iter().chain(changes.iter().copied()).chain([samples]).collect();
    for pair in edges.windows(2) {
        // Equal samples in a row that are more than a repetition: a marker at rest.
        let length = (pair[1] - pair[0]) as f64;
        let count = (length / pace).round().max(1.0);
        (0..count as usize).for_each(|k| keep[pair[0] + (k as f64 * length / count).round() as usize] = true);
    }
    Some(keep)
}

/// Largest change of a coordinate from the sample before; infinite where a marker is lost or found.
fn change(markers: &[Marker], i: usize) -> f64 {
    let of_marker = |marker: &Marker| match (marker.position[i - 1], marker.position[i]) {
        (Some(a), Some(b)) => (0..3).map(|k| (b[k] - a[k]).abs()).fold(0.0, f64::max),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    };
    markers.iter().map(of_marker).fold(0.0, f64::max)
}

/// Smallest change of any coordinate from one sample to the next: a step of the last digit, or less.
fn least_change(markers: &[Marker]) -> f64 {
    let steps = markers.iter().flat_map(|marker| marker.position.windows(2));
    let pairs = steps.filter_map(|pair| Some((pair[0]?, pair[1]?)));
    let pairs = pairs.flat_map(|(a, b)| (0..3).map(move |k| (a[k], b[k])));
    // The last bits of a number are no step.
    let is_step = |(a, b): &(f64, f64)| (b - a).abs() > 1e-12 * a.abs();
    pairs.filter(is_step).map(|(a, b)| (b - a).abs()).fold(f64::INFINITY, f64::min)
}

/// Largest distance of a coordinate from the line through the samples on both sides, twice; infinite beside a loss.
fn bend(markers: &[Marker], i: usize) -> f64 {
    let of_marker = |marker: &Marker| match marker.position[i - 1..i + 2] {
        [Some(a), Some(b), Some(c)] => (0..3).map(|k| (a[k] - 2.0 * b[k] + c[k]).abs()).fold(0.0, f64::max),
        [None, None, None] => 0.0,
        _ => f64::INFINITY,
    };
    markers.iter().map(of_marker).fold(0.0, f64::max)
}

/// Leaves out the other samples, and says so.
pub(super) fn leave_out(keep: &[bool], what: &str, time: &mut Vec<f64>, markers: &mut [Marker]) -> String {
    let logged = rate_of(time);
    retain(keep, time);
    markers.iter_mut().for_each(|marker| marker.retain(keep));
    format!(
        "{what}, {} times on the whole: what is logged at {} Hz was taken at {} Hz; the others are left out",
        plain(keep.len() as f64 / time.len() as f64),
        plain(logged),
        plain(rate_of(time))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marker(z: impl Fn(usize) -> f64) -> Vec<Marker> {
        let position = (0..1200).map(|i| Some([0.4, 0.0, z(i)])).collect();
        vec![Marker { name: "tip".to_owned(), position, orientation: None }]
    }

    #[test]
    fn repeated_samples_are_told_from_rest_and_from_coarse_digits() {
        let swing = |t: f64| 0.1 * (-0.3 * t).exp() * (10.0 * t).cos();
        let found = |markers: &[Marker]| {
            let mut findings = Vec::new();
            let keep = find(markers, &mut findings);
            keep.map(|(keep, _)| keep.iter().filter(|keep| **keep).count())
        };
        // Each six times; at 120 Hz in 1000 Hz; twice.
        assert_eq!(found(&marker(|i| swing((i / 6) as f64 * 0.02))), Some(200));
        assert_eq!(found(&marker(|i| swing((i as f64 * 0.12).floor() * 0.02))), Some(144));
        assert_eq!(found(&marker(|i| swing((i / 2) as f64 * 0.01))), Some(600));
        // Every sample new; held for half of the time; in whole millimetres, whatever the pace.
        assert_eq!(found(&marker(|i| swing(i as f64 * 0.003))), None);
        assert_eq!(found(&marker(|i| swing(i.saturating_sub(600) as f64 * 0.01))), None);
        for pace in [0.001, 0.003, 0.01] {
            assert_eq!(found(&marker(|i| (1e3 * swing(i as f64 * pace)).round() / 1e3)), None, "{pace}");
        }
        assert_eq!(found(&marker(|i| (i as f64 / 7.0).floor() * 1e-3)), None);
        // On lines between samples of 50 Hz, whole numbers and in steps of a micrometre.
        let noise = |k: usize| 1e-4 * ((k * k * 7 % 19) as f64 / 18.0 - 0.5);
        let taken = |k: usize| swing(k as f64 * 0.02) + noise(k);
        let between = |i: usize| taken(i / 10) + (i % 10) as f64 / 10.0 * (taken(i / 10 + 1) - taken(i / 10));
        assert_eq!(found(&marker(between)), Some(120));
        assert_eq!(found(&marker(|i| (1e6 * between(i)).round() / 1e6)), Some(120));
        // A triangle that is seen as it is.
        assert_eq!(found(&marker(|i| 1e-3 * (i % 400).min(400 - i % 400) as f64)), None);
    }
}
