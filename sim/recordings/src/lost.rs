//! Points that a program lost, where the format does not mark them.
//!
//! Programs that follow points in pictures repeat the last place, or the first, while they have none. A marker at rest
//! repeats its place too, but leaves it no faster than it moves later.
//!
//! Programs write 0, 0, 0 for a point that they lost, or another number for every coordinate, such as -9999. A marker that
//! moves through such a place is there by the way it moves; one that jumps to it from afar and back is not.

use std::ops::Range;

use efam_core::quantile::quantile;

use super::Marker;
use super::names::some;

/// Times a marker's usual largest step, from which on a jump to such a place is none that it moved.
const JUMP: f64 = 3.0;
/// Share of the steps that are usual.
const USUAL: f64 = 0.95;

/// Empties positions of one number for every coordinate beside which the marker is far away; says where.
pub(super) fn mask_codes(markers: &mut [Marker]) -> Option<String> {
    let (mut masked, mut names, mut numbers) = (0, Vec::new(), Vec::new());
    for marker in markers {
        let Some(code) = code(&marker.position) else { continue };
        let lost = jumps_to(code, &marker.position);
        if !lost.is_empty() {
            masked += lost.len();
            names.push(marker.name.clone());
            // In the file's own unit.
            let number = |x: f64| if x.abs() < 1e9 { (x + 0.0).to_string() } else { format!("{x:e}") };
            numbers.push(code.map(number).join(", "));
            lost.into_iter().for_each(|i| marker.position[i] = None);
        }
    }
    numbers.dedup();
    (masked > 0).then(|| {
        format!(
            "{masked} times a marker stood at exactly {}, far from where it was before and after; it counts as lost: {}",
            numbers.join(" or "),
            some(&names)
        )
    })
}

/// The place with one number for x and z, and for y unless the file has none, at which a marker is most often.
fn code(position: &[Option<[f64; 3]>]) -> Option<[f64; 3]> {
    let is_code = |[x, y, z]: &[f64; 3]| x == z && (y == x || *y == 0.0);
    let mut codes: Vec<[f64; 3]> = position.iter().flatten().copied().filter(is_code).collect();
    codes.sort_by(|a, b| a[2].total_cmp(&b[2]).then(a[1].total_cmp(&b[1])));
    codes.chunk_by(|a, b| a == b).max_by_key(|equal| equal.len()).map(|equal| equal[0])
}

/// Equal places in a row that may be a repetition.
const REPEATED: usize = 3;
/// Times the largest other step, by which no marker leaves a rest.
const LEAP: f64 = 2.0;

/// Empties places that are repeated, and from which the marker leaps farther than it moves anywhere else; says where.
pub(super) fn mask_repeated(markers: &mut [Marker]) -> Option<String> {
    let (mut masked, mut names) = (0, Vec::new());
    for marker in markers {
        for run in repeated(&marker.position) {
            masked += run.len();
            names.push(marker.name.clone());
            marker.position[run].fill(None);
        }
    }
    names.dedup();
    (masked > 0).then(|| {
        format!(
            "{masked} times a marker stood exactly where it was before, and then leapt farther than it moves anywhere else: \
             was it not followed there? it counts as lost: {}",
            some(&names)
        )
    })
}

fn repeated(position: &[Option<[f64; 3]>]) -> Vec<Range<usize>> {
    let step = |i: usize| {
        let (a, b) = (position[i]?, position.get(i + 1).copied().flatten()?);
        Some((0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt())
    };
    let mut runs: Vec<(Range<usize>, f64)> = Vec::new();
    let (mut start, mut farthest) = (0, 0.0f64);
    for i in 0..position.len() {
        match step(i) {
            Some(0.0) => {}
            Some(leap) if i + 1 - start >= REPEATED && step(i + 1).is_some() => {
                runs.push((start..i + 1, leap));
                start = i + 1;
            }
            other => {
                farthest = farthest.max(other.unwrap_or(0.0));
                start = i + 1;
            }
        }
    }
    // Of several runs each is compared with what is no leap.
    let is_leap = |own: &(Range<usize>, f64)| own.1 > LEAP * farthest && farthest > 0.0;
    runs.into_iter().filter(is_leap).map(|(run, _)| run).collect()
}

/// Samples at a place beside which the marker is far from it.
fn jumps_to(code: [f64; 3], position: &[Option<[f64; 3]>]) -> Vec<usize> {
    let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
    let steps = position.windows(2).filter_map(|pair| {
        let (a, b) = (pair[0]?, pair[1]?);
        (a != code && b != code).then_some(apart(a, b))
    });
    let Some(usual) = quantile(steps.collect(), USUAL) else { return Vec::new() };
    let seen = || position.iter().enumerate().filter_map(|(i, at)| Some((i, (*at)?)));
    // Other places, and whether they are far from it: there are some, since there are steps.
    let places: Vec<(usize, bool)> =
        seen().filter(|(_, at)| *at != code).map(|(i, at)| (i, apart(at, code) > JUMP * usual)).collect();
    let is_lost = |i: &usize| {
        let next = places.partition_point(|(place, _)| place < i);
        places[next.saturating_sub(1)..(next + 1).min(places.len())].iter().all(|(_, is_far)| *is_far)
    };
    seen().filter(|(_, at)| *at == code).map(|(i, _)| i).filter(is_lost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marker_that_is_not_followed_is_told_from_one_at_rest() {
        let at = |x: f64| Some([x, 0.0, 0.0]);
        let swing = |t: f64| at(0.15 * (7.0 * t).cos() * (-0.2 * t).exp());
        let from = |still: f64, begin: f64| -> Vec<_> {
            (0..200).map(|k| f64::from(k) / 30.0).map(|t| swing((t - still).max(0.0) + begin)).collect()
        };
        // Held for half a second and let go; in mid-swing by then; likewise in the midst.
        assert_eq!(repeated(&from(0.5, 0.0)), []);
        let mut late = from(0.0, 0.0);
        let first = late[0];
        late[..16].fill(first);
        assert_eq!(repeated(&late), vec![0..16; 1]);
        let mut lost = from(0.0, 0.0);
        let last = lost[60];
        lost[60..67].fill(last);
        assert_eq!(repeated(&lost), vec![60..67; 1]);
        // A ghost beside a rest, steps of the last digit, and a rest to the end.
        let mut ghost = from(0.5, 0.0);
        ghost[9] = at(3.0);
        assert_eq!(repeated(&ghost), []);
        let coarse = (0..400).map(|k| at((100.0 * (0.01 * f64::from(k)).cos()).round())).collect::<Vec<_>>();
        assert_eq!(repeated(&coarse), []);
        assert_eq!(repeated(&[at(0.0), at(1.0), at(1.0), at(1.0), at(1.0)]), []);
    }

    #[test]
    fn a_jump_to_one_number_is_a_loss_and_a_way_through_it_is_none() {
        let lost_of = |position: &[Option<[f64; 3]>]| {
            code(position).map_or(Vec::new(), |code| jumps_to(code, position))
        };
        let far: Vec<_> = (0..40).map(|k| Some([0.4 + 1e-3 * f64::from(k % 5), 0.0, 0.01])).collect();
        // Without a y in the file, y is 0.
        for code in [[0.0; 3], [-9.999; 3], [99.0, 0.0, 99.0]] {
            let mut lost = far.clone();
            [0, 1, 17, 18, 39].into_iter().for_each(|i| lost[i] = Some(code));
            assert_eq!(lost_of(&lost), [0, 1, 17, 18, 39], "{code:?}");
        }
        // A swing about the origin, in whole millimetres, which rests there, and one along x = z.
        let swing =
            |k: i32| (20.0 * (0.3 * f64::from(k)).cos() * (-0.05 * f64::from(k)).exp()).round() * 1e-3;
        let through: Vec<_> = (0..200).map(|k| Some([0.0, 0.0, swing(k)])).collect();
        assert!(through.iter().filter(|at| **at == Some([0.0; 3])).count() > 50);
        assert_eq!(lost_of(&through), [0; 0]);
        let along: Vec<_> = (0..200).map(|k| Some([1.0 + swing(k), 0.0, 1.0 + swing(k)])).collect();
        assert_eq!(lost_of(&along), [0; 0]);
        assert_eq!(lost_of(&vec![Some([0.0; 3]); 9]), [0; 0]);
    }
}
