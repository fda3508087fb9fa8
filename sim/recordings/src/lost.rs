//! Zeros that stand for lost points, where the format does not say so.
//!
//! Programs write 0, 0, 0 for a point that they lost. A marker that moves through the origin is there by the way it
//! moves; one that jumps to it from afar and back is not.

use efam_core::quantile::quantile;

use super::Marker;
use super::names::some;

/// Times a marker's usual largest step, from which on a jump to the origin is none that it moved.
const JUMP: f64 = 3.0;
/// Share of the steps that are usual.
const USUAL: f64 = 0.95;

/// Empties positions of exactly 0, 0, 0 beside which the marker is far away; says where.
pub(super) fn mask_zeros(markers: &mut [Marker]) -> Option<String> {
    let (mut masked, mut names) = (0, Vec::new());
    for marker in markers {
        let zeros = zeros(&marker.position);
        if !zeros.is_empty() {
            masked += zeros.len();
            names.push(marker.name.clone());
            zeros.into_iter().for_each(|i| marker.position[i] = None);
        }
    }
    (masked > 0).then(|| {
        format!(
            "{masked} times a marker stood at exactly 0, 0, 0, far from where it was before and after; it counts as \
             lost: {}",
            some(&names)
        )
    })
}

fn zeros(position: &[Option<[f64; 3]>]) -> Vec<usize> {
    let size = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let steps = position.windows(2).filter_map(|pair| {
        let (a, b) = (pair[0]?, pair[1]?);
        let moved: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
        (a != [0.0; 3] && b != [0.0; 3]).then_some(size(moved))
    });
    let Some(usual) = quantile(steps.collect(), USUAL) else { return Vec::new() };
    let seen = || position.iter().enumerate().filter_map(|(i, at)| Some((i, (*at)?)));
    // Places off the origin, and whether they are far from it: there are some, since there are steps.
    let places: Vec<(usize, bool)> =
        seen().filter(|(_, at)| *at != [0.0; 3]).map(|(i, at)| (i, size(at) > JUMP * usual)).collect();
    let is_lost = |i: &usize| {
        let next = places.partition_point(|(place, _)| place < i);
        places[next.saturating_sub(1)..(next + 1).min(places.len())].iter().all(|(_, is_far)| *is_far)
    };
    seen().filter(|(_, at)| *at == [0.0; 3]).map(|(i, _)| i).filter(is_lost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_to_the_origin_is_a_loss_and_a_way_through_it_is_none() {
        let far: Vec<_> = (0..40).map(|k| Some([0.4 + 1e-3 * f64::from(k % 5), 0.0, 0.01])).collect();
        let mut lost = far.clone();
        [0, 1, 17, 18, 39].into_iter().for_each(|i| lost[i] = Some([0.0; 3]));
        assert_eq!(zeros(&lost), [0, 1, 17, 18, 39]);
        // A swing about the origin, in whole millimetres, which rests there.
        let swing =
            |k: i32| (20.0 * (0.3 * f64::from(k)).cos() * (-0.05 * f64::from(k)).exp()).round() * 1e-3;
        let through: Vec<_> = (0..200).map(|k| Some([0.0, 0.0, swing(k)])).collect();
        assert!(through.iter().filter(|at| **at == Some([0.0; 3])).count() > 50);
        assert_eq!(zeros(&through), [0; 0]);
        assert_eq!(zeros(&vec![Some([0.0; 3]); 9]), [0; 0]);
    }
}
