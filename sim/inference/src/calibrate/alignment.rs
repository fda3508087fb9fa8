//! Two releases of one condition side by side: how they differ when what each has of its own is taken off.

use efam_core::quantile::usual_step;
use efam_experiments::release::Release;
use nalgebra::{Matrix5, Vector5};

use super::loss::spread;

/// How two releases of one condition differ.
pub(super) struct Difference {
    /// Mean square distance of their tips, m², aligned in time, frequency, size and place.
    pub square: f64,
    /// Frequency of the second over that of the first, less one.
    pub stretch: f64,
}

/// Two releases, aligned: first by the shift in time, up to the uncertainty of their instants, at which they are nearest,
/// then by Gauss and Newton in shift, frequency, size and place: every release has an instant, a stiffness, a start and a
/// camera of its own.
pub(super) fn difference(a: &Release, b: &Release) -> Option<Difference> {
    let (path, other) = (known(a), known(b));
    let times: Vec<f64> = other.iter().map(|(time, _)| *time).collect();
    let step = usual_step(&times)?;
    // Half the way from one end of the swing to the other: where its size is counted from.
    let middle = [0, 1].map(|axis| {
        let ends =
            |of: fn(f64, f64) -> f64| other.iter().map(|(_, at)| at[axis]).reduce(of).unwrap_or_default();
        0.5 * (ends(f64::min) + ends(f64::max))
    });
    // Where the second is when the first is at its samples, seen as the first; its swing, and how fast.
    let seen = |[shift, stretch, larger, x, z]: [f64; 5], time: f64| {
        let (at, rate) = between(&other, step, time / (1.0 + stretch) + shift)?;
        let swing = [0, 1].map(|axis| at[axis] - middle[axis]);
        let at = [0, 1].map(|axis| middle[axis] + [x, z][axis] + (1.0 + larger) * swing[axis]);
        Some((at, swing, rate.map(|rate| (1.0 + larger) * rate)))
    };
    let off = |alignment: [f64; 5]| -> Vec<Option<[f64; 2]>> {
        let of = |(time, own): &(f64, [f64; 2])| {
            let (theirs, ..) = seen(alignment, *time)?;
            Some([own[0] - theirs[0], own[1] - theirs[1]])
        };
        path.iter().map(of).collect()
    };
    let distance = |alignment: [f64; 5]| {
        let off = off(alignment);
        (off.iter().flatten().count() > path.len() / 2).then(|| mean_square(off.into_iter().flatten()))
    };
    // The step that would bring them nearer.
    let step_from = |alignment: [f64; 5]| {
        let (mut hessian, mut gradient) = (Matrix5::zeros(), Vector5::zeros());
        for (time, own) in &path {
            let Some((at, swing, rate)) = seen(alignment, *time) else { continue };
            for axis in 0..2 {
                let mut slopes = Vector5::new(rate[axis], -rate[axis] * time, swing[axis], 0.0, 0.0);
                slopes[3 + axis] = 1.0;
                hessian += slopes * slopes.transpose();
                gradient += slopes * (own[axis] - at[axis]);
            }
        }
        hessian.lu().solve(&gradient).unwrap_or_default()
    };
    let farthest = 3.0 * a.release_uncertainty.hypot(b.release_uncertainty);
    let shifts =
        (-SHIFTS..=SHIFTS).map(|k| [farthest * f64::from(k) / f64::from(SHIFTS), 0.0, 0.0, 0.0, 0.0]);
    let apart = |at: [f64; 5]| Some((at, distance(at)?));
    let (mut at, mut square) = shifts.filter_map(apart).min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    for _ in 0..MOST_STEPS {
        let step = step_from(at);
        let by = |share: f64| -> [f64; 5] {
            let [shift, others @ ..]: [f64; 5] = std::array::from_fn(|k| at[k] + share * step[k]);
            let [stretch, larger, x, z] = others;
            [shift.clamp(-farthest, farthest), stretch, larger, x, z]
        };
        // At the end of what an instant may be off the whole step may lead too far.
        let nearer = [1.0, 0.5, 0.25].map(by).into_iter().filter_map(apart).find(|(_, next)| *next < square);
        let Some(next) = nearer else { break };
        (at, square) = next;
    }
    // What jumps and comes back is another thing; in a difference no swing hides it.
    let off = off(at);
    let kept = off.iter().zip(ghosts(&off)).filter(|(_, is_ghost)| !is_ghost);
    Some(Difference { square: mean_square(kept.filter_map(|(off, _)| *off)), stretch: at[1] })
}

fn mean_square(all: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (sum, count) = all.fold((0.0, 0.0), |(sum, count), [x, z]| (sum + x * x + z * z, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Place and velocity between samples, by the cubic through the nearest four; none in a gap or at an end.
fn between(path: &[(f64, [f64; 2])], step: f64, time: f64) -> Option<([f64; 2], [f64; 2])> {
    let after = path.partition_point(|(own, _)| *own <= time);
    let four = path.get(after.checked_sub(2)?..after + 2)?;
    // Three steps, and not four.
    if four[3].0 - four[0].0 > 3.5 * step {
        return None;
    }
    let (mut at, mut rate) = ([0.0; 2], [0.0; 2]);
    for (i, (own, place)) in four.iter().enumerate() {
        // Lagrange's weight and its slope, a factor after the other.
        let (mut weight, mut slope) = (1.0, 0.0);
        for (_, (other, _)) in four.iter().enumerate().filter(|(j, _)| *j != i) {
            slope = (slope * (time - other) + weight) / (own - other);
            weight *= (time - other) / (own - other);
        }
        for axis in 0..2 {
            at[axis] += weight * place[axis];
            rate[axis] += slope * place[axis];
        }
    }
    Some((at, rate))
}

/// Steps of the alignment at most.
const MOST_STEPS: usize = 10;
/// Shifts in time that are tried to each side.
const SHIFTS: i32 = 60;

/// How many times as far from the middle of its two neighbours as samples usually are another thing is that was taken
/// for the marker: one of a hundred million samples is by chance.
const GHOST: f64 = 6.0;

/// Samples of the tip that are there, with their times, but for ghosts.
pub(super) fn known(release: &Release) -> Vec<(f64, [f64; 2])> {
    let path = &release.tracks[release.leading_track()].position;
    let (time, ghosts) = (&release.time, ghosts(path));
    (0..path.len()).filter(|k| !ghosts[*k]).filter_map(|k| Some((time[k], path[k]?))).collect()
}

/// Which samples jump and come back at once: another thing that was taken for the marker, whatever a model says.
pub(crate) fn ghosts(path: &[Option<[f64; 2]>]) -> Vec<bool> {
    let all: Vec<(usize, [f64; 2])> =
        path.iter().enumerate().filter_map(|(k, at)| Some((k, (*at)?))).collect();
    let jump = |three: &[(usize, [f64; 2])]| {
        let off = |axis: usize| three[1].1[axis] - 0.5 * (three[0].1[axis] + three[2].1[axis]);
        off(0).hypot(off(1))
    };
    let jumps: Vec<f64> = all.windows(3).map(jump).collect();
    let usual = spread(jumps.clone());
    let at = |k: usize| jumps.get(k.wrapping_sub(1)).copied().unwrap_or(0.0);
    let mut ghosts = vec![false; path.len()];
    for (k, (place, _)) in all.iter().enumerate() {
        // The neighbours of a ghost jump half as far as it, those of a turn as far.
        ghosts[*place] = at(k) > GHOST * usual && at(k) > 1.5 * at(k + 1).max(at(k.wrapping_sub(1)));
    }
    ghosts
}

#[cfg(test)]
pub mod tests {
    use efam_experiments::release::{Point, Track};

    use super::*;

    /// A swing that decays to a rest, seen from `from` on, `more` at its rest, and `share` larger in its swing.
    pub fn release(from: f64, more: f64, share: f64) -> Release {
        let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        let swing = |time: f64| 0.02 * (1.0 + share) * (-time).exp() * (9.0 * time).cos();
        let position = time.iter().map(|time| Some([0.1, more + swing(time + from)])).collect();
        let tracks =
            vec![Track { marker: "tip".to_owned(), at: Point::Tip, position, noise: 1e-5, discrepancy: 0.0 }];
        let name = "made-up".to_owned();
        Release {
            name,
            time,
            release_uncertainty: 0.01,
            tracks,
            pressure: None,
            payload: 0.0,
            held_out: false,
        }
    }

    #[test]
    fn releases_are_compared_aligned_in_time_size_and_place() {
        let reference = release(0.0, 0.0, 0.0);
        let of = |other: &Release| 1e3 * difference(&reference, other).unwrap().square.sqrt();
        let mut with_ghosts = release(0.0, 0.0, 0.0);
        for k in [50, 51, 200] {
            with_ghosts.tracks[0].position[k] = Some([0.2, 0.1]);
        }
        with_ghosts.tracks[0].position[51] = None;
        assert!(of(&with_ghosts) < 1e-3, "{}", of(&with_ghosts));
        let elsewhere = release(0.012, 1e-3, 0.05);
        assert!(of(&elsewhere) < 0.02, "{}", of(&elsewhere));
    }

    /// What decays a tenth faster is another swing, however it is aligned. To first order it is off by `0.1 t e^−t` of the
    /// swing, of which its size takes away what is proportional to `e^−t`. What is left, `0.1 (t − ½) e^−t`, has a square
    /// whose integral is `0.01 / 8`, over four seconds, half of it for the swing.
    #[test]
    fn a_damping_that_differs_is_a_distance() {
        let (reference, mut other) = (release(0.0, 0.0, 0.0), release(0.0, 0.0, 0.0));
        for (time, at) in other.time.iter().zip(&mut other.tracks[0].position) {
            *at = Some([0.1, 0.02 * (-1.1 * time).exp() * (9.0 * time).cos()]);
        }
        let found = difference(&reference, &other).unwrap().square.sqrt();
        let due = 0.02 * (0.01f64 / 64.0).sqrt();
        assert!((found / due - 1.0).abs() < 0.15, "{found} for {due}");
    }

    /// The second swings slower by a hundredth: seen at the same samples, it is the first with its time stretched.
    #[test]
    fn a_frequency_that_differs_is_no_distance() {
        let (reference, mut slower) = (release(0.0, 0.0, 0.0), release(0.0, 0.0, 0.0));
        let swing = |time: f64| 0.02 * (-time).exp() * (9.0 * time).cos();
        for (time, at) in slower.time.iter().zip(&mut slower.tracks[0].position) {
            *at = Some([0.1, swing(time * 0.99)]);
        }
        let found = difference(&reference, &slower).unwrap();
        assert!((found.stretch + 0.01).abs() < 2e-4, "{}", found.stretch);
        assert!(found.square.sqrt() < 2e-5, "{}", found.square.sqrt());
    }
}
