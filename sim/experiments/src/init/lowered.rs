//! Whether a hand lowers the rod before it lets go.
//!
//! A rod that is let go at rest first turns after half a swing, and the next turn is half a swing later. A hand that lowers
//! the rod leaves the hold earlier than it lets go, so the first turn comes later than that. Half a swing before it the
//! rod was on its own.

use crate::cleaning::CleanRelease;

/// Time to the first turn over that between turns from which on a hand has lowered the rod. The first half swing is the
/// largest, and may be slower: a pendulum let go at a right angle needs 1.18 times as long for it as for small ones, a
/// silicone trunk that hangs and was pulled aside 1.4 times.
const LATE: f64 = 1.5;

/// Longest gap before the second turn, in half swings: a turn that is not seen lies in no shorter one.
const GAP: f64 = 0.3;

/// When the rod was let go, s on the recording's clock, if that is later than it left the hold.
pub(super) fn let_go(of: &CleanRelease) -> Option<f64> {
    let (path, rest) = (&of.release.tracks[of.release.leading_track()].position, of.statistics.rest);
    let off = of.release.time.iter().zip(path).filter_map(|(time, at)| {
        let [x, z] = (*at)?;
        (0.0..of.swings_until).contains(time).then_some((*time, [x - rest[0], z - rest[1]]))
    });
    let off: Vec<_> = off.collect();
    let [first, second] = turns(&along(&off))?;
    let half_swing = second - first;
    // The first turn may be in a gap.
    let begun = off.iter().map(|(time, _)| *time).take_while(|time| *time < second);
    let longest = begun.fold((0.0, 0.0f64), |(last, longest), time| (time, longest.max(time - last))).1;
    if longest > GAP * half_swing {
        return None;
    }
    (first > LATE * half_swing).then_some(of.instant + first - half_swing)
}

/// Distance from the rest along the direction in which the tip moves most: along one axis alone a strip that bends far
/// turns twice in a swing.
fn along(off: &[(f64, [f64; 2])]) -> Vec<(f64, f64)> {
    let product = |i: usize, j: usize| off.iter().map(|(_, at)| at[i] * at[j]).sum::<f64>();
    let (sin, cos) = (0.5 * (2.0 * product(0, 1)).atan2(product(0, 0) - product(1, 1))).sin_cos();
    off.iter().map(|(time, [x, z])| (*time, x * cos + z * sin)).collect()
}

/// The first two turns after the tip has gone through its rest: where it is farthest between two passages.
fn turns(swing: &[(f64, f64)]) -> Option<[f64; 2]> {
    let mut sides = swing.chunk_by(|a, b| a.1.is_sign_positive() == b.1.is_sign_positive());
    sides.next()?;
    let farthest = |side: &[(f64, f64)]| {
        side.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(time, _)| *time)
    };
    let turns = [farthest(sides.next()?)?, farthest(sides.next()?)?];
    // The third passage ends the second of them.
    sides.next().map(|_| turns)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Let go at `late` after it left the hold, from which a hand lowers it evenly by a tenth of the way; 1.5 Hz.
    fn swing(late: f64) -> Vec<(f64, [f64; 2])> {
        let at = |time: f64| {
            if time < late {
                1.0 - 0.1 * time / late
            } else {
                0.9 * (-0.5 * (time - late)).exp() * (9.4 * (time - late)).cos()
            }
        };
        (0..400).map(|k| 0.02 * f64::from(k)).map(|time| (time, [0.3 * at(time), at(time)])).collect()
    }

    #[test]
    fn half_a_swing_before_the_first_turn_the_rod_was_let_go() {
        let found = |late: f64| {
            let [first, second] = turns(&along(&swing(late))).unwrap();
            (first / (second - first), 2.0 * first - second)
        };
        let (ratio, _) = found(0.0);
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
        let (ratio, at) = found(0.25);
        assert!(ratio > LATE && (at - 0.25).abs() < 0.03, "{ratio}, {at}");
    }
}
