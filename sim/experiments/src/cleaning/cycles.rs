//! Where in a long recording the tip is held, let go, and swings until it is raised again.
//!
//! A release is a stretch of quiet that ends in a motion which soon is fast, turns back at least three
//! times, and comes to rest elsewhere. A hand that raises the tip is slower, and does not swing. No
//! direction is needed for this, so that it comes before anything is known of gravity.

use std::ops::Range;

use efam_core::quantile::quantile;

use super::distance;
use super::held::{only_noise, speed_at};
use super::motion::Motion;

/// One release, in samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The quiet stretch before it.
    pub hold: Range<usize>,
    /// The swing, up to where the tip is raised again or the recording ends.
    pub swing: Range<usize>,
    /// Mean position of the hold, m, in the recording's frame.
    pub held: [f64; 3],
    /// Where the swing comes to rest, m: the mean of a window.
    pub rest: [f64; 3],
    /// The sample after that window.
    pub rest_end: usize,
}

impl Cut {
    /// Whether it turns as evenly as a swing does, and no farther from its rest than it was held: noise that wanders, a drift and a
    /// single bump do not.
    pub fn is_even(&self, time: &[f64], path: &[Option<[f64; 3]>]) -> bool {
        let turns = turns(path, self.swing.clone(), self.held, self.rest);
        let halves: Vec<f64> = turns.windows(2).map(|pair| time[pair[1]] - time[pair[0]]).collect();
        let usual = quantile(halves.clone(), 0.5).unwrap_or(f64::NAN);
        let even = halves.iter().filter(|half| (*half / usual - 1.0).abs() < UNEVEN).count();
        let far = self.swing.clone().filter_map(|i| Some(distance(path[i]?, self.rest))).fold(0.0, f64::max);
        turns.len() >= LEAST_TURNS
            && even as f64 >= EVEN * halves.len() as f64
            && far <= FARTHER * distance(self.held, self.rest)
    }

    /// The end of the hold, over which its place is averaged.
    pub fn late_hold(&self, time: &[f64]) -> Range<usize> {
        late(time, &self.hold)
    }
}

/// The end of a hold, over which its place is averaged.
pub(super) fn late(time: &[f64], hold: &Range<usize>) -> Range<usize> {
    let Some(last) = hold.end.checked_sub(1) else { return hold.clone() };
    hold.clone().find(|&i| time[last] - time[i] <= LATE_HOLD).unwrap_or(hold.start)..hold.end
}

/// End of the hold over which its place is averaged, s.
const LATE_HOLD: f64 = 0.3;
/// Speed below which the tip is quiet, in the fastest of the recording.
const QUIET: f64 = 0.04;
/// Speed above which it was let go, likewise.
pub(super) const FAST: f64 = 0.5;
/// Speed, m/s, below which nothing was let go, whatever the noise.
const SLOWEST: f64 = 1e-4;
/// Shortest hold, s, or in periods if that is less.
const SHORTEST_HOLD: f64 = 0.08;
const HELD_PERIODS: f64 = 0.5;
/// The same at least, in periods times the share of the fastest speed that is quiet: a turn of a swing is so for half as long.
const TURN_PERIODS: f64 = 2.0 / std::f64::consts::PI;
/// Time within which it must be fast, s, or in periods if that is more: a swing from rest needs a twelfth of one.
const SOON: f64 = 0.5;
const SOON_PERIODS: f64 = 0.2;
/// Noise in the speed that may be, in standard deviations.
const MOST_NOISE: f64 = 6.0;
/// Turns that make a swing.
pub(super) const LEAST_TURNS: usize = 3;
/// Part by which half a period of a swing may differ from the usual one: large swings take up to 1.4 times as long as small ones.
const UNEVEN: f64 = 0.4;
/// Share of half periods that are as even: of those of a random walk less than half are.
const EVEN: f64 = 2.0 / 3.0;
/// Distance from the rest, in that of the hold, that a swing does not leave: it loses energy, and the rest is a mean.
const FARTHER: f64 = 1.5;
/// Way back that counts as a turn, in the distance of the hold from the rest.
const LEAST_TURN: f64 = 0.04;
/// Samples to either side that say where the tip is at an instant, in spite of one that is spurious.
const AROUND: usize = 4;
/// Length of the window in which the rest is looked for, s, or in periods if that is more.
const REST_WINDOW: f64 = 0.5;
const REST_PERIODS: f64 = 0.25;

/// All releases of a path, or why there is none.
pub fn cut(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    step: f64,
    sigma: f64,
    given: Option<&[f64]>,
) -> Result<Vec<Cut>, String> {
    let (motion, period) = Motion::paced(time, path, step, sigma);
    let fastest = motion.fastest();
    let quiet = quiet(fastest, motion.noise);
    let shortest = SHORTEST_HOLD.min(HELD_PERIODS * period).max(TURN_PERIODS * quiet / fastest * period);
    let none_moves = || none_moves(path, sigma);
    let holds = match given {
        Some(instants) => {
            if let Some(why) = none_moves() {
                return Err(why);
            }
            let holds = given_holds(time, instants);
            for (at, hold) in instants.iter().zip(&holds) {
                if let Some(speed) = speed_at(time, path, &motion, sigma, hold, fastest) {
                    return Err(format!(
                        "at the instant {at} s the tip moves at {speed:.3} m/s, and at {fastest:.3} m/s at most: it is not \
                         let go from rest there; give an instant at which it is held still, or a recording that begins \
                         before it is let go, or start = \"in motion\""
                    ));
                }
            }
            holds
        }
        None if FAST * fastest < (2.0 * quiet).max(SLOWEST) => {
            let (fastest, noise) = (1e3 * fastest, 1e3 * motion.noise);
            return Err(format!(
                "the tip moves at {fastest:.1} mm/s at most, which is no release (noise explains {noise:.1} mm/s)"
            ));
        }
        None => match none_moves() {
            Some(why) => return Err(why),
            None => {
                holds(time, &motion, [quiet, FAST * fastest], [shortest, SOON.max(SOON_PERIODS * period)])
            }
        },
    };
    if holds.is_empty() {
        return Err(format!(
            "the tip, which moves at up to {:.0} mm/s, is nowhere still for {} s and fast soon after",
            1e3 * fastest,
            (1e3 * shortest).round() / 1e3
        ));
    }
    let count = holds.len();
    let mut after = swings(time, path, &motion, &holds, given.is_some());
    if after.contains(&After::NoSwing) {
        // What was no release, such as a fast raise, has cut the swing before it short.
        let is_left =
            |(hold, after): (&Range<usize>, &After)| (*after != After::NoSwing).then(|| hold.clone());
        let holds: Vec<_> = holds.iter().zip(&after).filter_map(is_left).collect();
        after = swings(time, path, &motion, &holds, given.is_some());
    }
    let is_swing = |after| match after {
        After::Swing(cut) => Some(cut),
        After::NoSwing | After::Unclear => None,
    };
    let cuts: Vec<Cut> = after.into_iter().filter_map(is_swing).collect();
    if cuts.is_empty() {
        Err(format!(
            "the tip starts {count} time{} from a stretch of quiet, and swings after none of them",
            if count == 1 { "" } else { "s" }
        ))
    } else {
        Ok(cuts)
    }
}

/// Speed below which the tip is quiet, m/s, of the fastest and of the noise in a speed.
pub(super) fn quiet(fastest: f64, noise: f64) -> f64 {
    (QUIET * fastest).max(MOST_NOISE * noise)
}

/// Why a path is no swing, if noise explains it.
pub(super) fn none_moves(path: &[Option<[f64; 3]>], sigma: f64) -> Option<String> {
    let width = 1e3 * only_noise(path, sigma)?;
    Some(format!("nothing moves: the tip stays within {width:.3} mm along each axis, which noise explains"))
}

/// The swing of a path that begins in mid-swing, from its first sample on, or from an instant. Its hold is that sample alone,
/// and its held place the farthest from the rest.
pub fn cut_in_motion(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    step: f64,
    sigma: f64,
    from: Option<f64>,
) -> Result<Vec<Cut>, String> {
    if let Some(why) = none_moves(path, sigma) {
        return Err(why);
    }
    let motion = Motion::paced(time, path, step, sigma).0;
    let begin = from.map_or(0, |from| time.partition_point(|t| *t < from));
    let none = || "the tip is not seen from the instant on at which the swing is to begin".to_owned();
    let first = (begin..path.len()).find(|i| path[*i].is_some()).ok_or_else(none)?;
    let hold = first..first + 1;
    let swing = hold.end..path.len();
    let place = path[first].ok_or_else(none)?;
    let (rest, window) = rest(time, path, &motion, swing.clone(), place, true).ok_or_else(none)?;
    let held = path[first..].iter().flatten().copied();
    let held = held.max_by(|a, b| distance(*a, rest).total_cmp(&distance(*b, rest))).ok_or_else(none)?;
    let turns = turns(path, swing.clone(), held, rest).len();
    if turns < LEAST_TURNS {
        return Err(format!(
            "the tip turns back {turns} times, and a swing does so {LEAST_TURNS} times at least"
        ));
    }
    Ok(vec![Cut { hold, swing, held, rest, rest_end: window.end }])
}

/// What follows a hold.
#[derive(PartialEq)]
enum After {
    Swing(Cut),
    NoSwing,
    /// It comes to no rest before the next hold.
    Unclear,
}

/// What follows some holds; those that are `given` are followed by a swing.
fn swings(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    motion: &Motion,
    holds: &[Range<usize>],
    given: bool,
) -> Vec<After> {
    let ends: Vec<usize> = holds.iter().skip(1).map(|hold| hold.start).chain([path.len()]).collect();
    let after = |(k, hold): (usize, &Range<usize>)| {
        let whole = hold.end..ends[k];
        let is_last = k + 1 == holds.len();
        let Some(held) = mean(path, late(time, hold)) else { return After::Unclear };
        let Some((rest, window)) = rest(time, path, motion, whole.clone(), held, is_last) else {
            return After::Unclear;
        };
        let end = if is_last { whole.end } else { raised(path, whole.clone(), rest, held, &window) };
        let (swing, rest_end) = (whole.start..end, window.end);
        if given || turns(path, swing.clone(), held, rest).len() >= LEAST_TURNS {
            After::Swing(Cut { hold: hold.clone(), swing, held, rest, rest_end })
        } else {
            After::NoSwing
        }
    };
    holds.iter().enumerate().map(after).collect()
}

/// Stretches of quiet after which the tip soon is fast. They begin and end with a sample that is seen: what
/// the tip does while it is lost, nobody knows.
fn holds(
    time: &[f64],
    motion: &Motion,
    [quiet, fast]: [f64; 2],
    [shortest, soon]: [f64; 2],
) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    // A hold, and the first sample after it that is seen.
    let mut last: Option<(Range<usize>, usize)> = None;
    let mut open: Option<Range<usize>> = None;
    for i in 0..time.len() {
        let Some(speed) = motion.speed(i) else { continue };
        if speed < quiet {
            open.get_or_insert(i..i).end = i + 1;
        } else if let Some(hold) = open.take()
            && time[hold.end - 1] - time[hold.start] >= shortest
        {
            last = Some((hold, i));
        }
        if speed >= fast
            && let Some((hold, after)) = last.take()
            && time[i] - time[after] <= soon
        {
            found.push(hold);
        }
    }
    found
}

/// The half second before each instant, or what there is of it; the first sample where the recording begins there.
fn given_holds(time: &[f64], instants: &[f64]) -> Vec<Range<usize>> {
    let sample = |at: f64| time.partition_point(|t| *t < at);
    instants
        .iter()
        .map(|at| sample(at - 0.5).min(sample(*at).saturating_sub(1))..sample(*at).max(1))
        .collect()
}

/// Where the swing comes to rest: the mean of the quietest window in it, of the last swing at its end; and that window.
pub(super) fn rest(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    motion: &Motion,
    swing: Range<usize>,
    held: [f64; 3],
    is_last: bool,
) -> Option<([f64; 3], Range<usize>)> {
    let (begin, end) = (*time.get(swing.start)?, *time.get(swing.end.checked_sub(1)?)?);
    let window = REST_WINDOW.max(REST_PERIODS * motion.period(path)).min(0.3 * (end - begin));
    if is_last {
        let from = swing.clone().find(|&i| time[i] >= end - 1.5 * window)?;
        return Some((mean(path, from..swing.end)?, from..swing.end));
    }
    // Not next to the hold that follows, which is quiet as well: that end is given up to the raise.
    let held_next = middle(path, swing.end.saturating_sub(AROUND)..(swing.end + AROUND).min(path.len()))?;
    let farthest = swing.clone().filter_map(|i| Some(distance(path[i]?, held))).fold(0.0, f64::max);
    let mut best: Option<(f64, Range<usize>)> = None;
    let mut to = swing.start;
    for from in swing.clone().step_by(5) {
        while to < swing.end && time[to] - time[from] < window {
            to += 1;
        }
        if to == swing.end {
            break;
        }
        let Some(middle) = mean(path, from..to) else { continue };
        if distance(middle, held_next) < 0.3 * farthest {
            continue;
        }
        let speeds: Vec<f64> = (from..to).filter_map(|i| motion.speed(i)).collect();
        let speed = speeds.iter().sum::<f64>() / speeds.len().max(1) as f64;
        if !speeds.is_empty() && best.as_ref().is_none_or(|(least, _)| speed < *least) {
            best = Some((speed, from..to));
        }
    }
    let (_, window) = best?;
    Some((mean(path, window.clone())?, window))
}

/// Sample from which on the tip is raised: after the last one as near the rest as half of those in its window are. No
/// model of the swing reproduces a hand's motion after that.
fn raised(
    path: &[Option<[f64; 3]>],
    swing: Range<usize>,
    rest: [f64; 3],
    held: [f64; 3],
    window: &Range<usize>,
) -> usize {
    let away = |i: usize| path[i].map(|at| distance(at, rest));
    let usual = quantile(window.clone().filter_map(away).collect(), 0.5);
    // A tip that still swings widely passes its rest on the way up.
    let near = usual.unwrap_or(0.0).min(0.06 * distance(held, rest));
    let last = swing.clone().rev().find(|&i| away(i).is_some_and(|away| away <= near));
    last.map_or(swing.end, |last| last + 1).max(window.end.min(swing.end))
}

/// Samples at which the tip turns back along the line from its rest to its hold.
pub(super) fn turns(
    path: &[Option<[f64; 3]>],
    swing: Range<usize>,
    held: [f64; 3],
    rest: [f64; 3],
) -> Vec<usize> {
    let whole = distance(held, rest);
    let along = |at: [f64; 3]| (0..3).map(|k| (at[k] - rest[k]) * (held[k] - rest[k])).sum::<f64>() / whole;
    let least = LEAST_TURN * whole;
    let (mut extreme, mut last, mut falls, mut turns) = (f64::INFINITY, swing.start, true, Vec::new());
    for (i, value) in swing.filter_map(|i| Some((i, along(path[i]?)))) {
        let is_farther = if falls { value < extreme } else { value > extreme };
        if is_farther {
            (extreme, last) = (value, i);
        } else if (value - extreme).abs() > least {
            turns.push(last);
            (extreme, last, falls) = (value, i, !falls);
        }
    }
    turns
}

/// Median of each coordinate of the samples that are seen.
fn middle(path: &[Option<[f64; 3]>], range: Range<usize>) -> Option<[f64; 3]> {
    let seen: Vec<_> = path.get(range)?.iter().flatten().collect();
    let of = |k: usize| quantile(seen.iter().map(|point| point[k]).collect(), 0.5);
    Some([of(0)?, of(1)?, of(2)?])
}

/// Mean of the samples that are seen.
pub(super) fn mean(path: &[Option<[f64; 3]>], range: Range<usize>) -> Option<[f64; 3]> {
    let seen: Vec<_> = path.get(range)?.iter().flatten().collect();
    (!seen.is_empty())
        .then(|| std::array::from_fn(|k| seen.iter().map(|point| point[k]).sum::<f64>() / seen.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::onset::estimate;
    use crate::cleaning::tests::{Noise, along, falling_swing, raised_and_released};

    #[test]
    fn six_cycles_are_cut_apart_where_they_begin() {
        let mut noise = Noise::new(11);
        let (time, mut path, instants) = raised_and_released(6);
        noise.disturb(&mut path, 3e-4);
        // At 1.3 Hz and at 64 Hz.
        for pace in [1.0, 0.02] {
            let time: Vec<f64> = time.iter().map(|t| pace * t).collect();
            let step = 0.01 * pace;
            let cuts = cut(&time, &path, step, 3e-4, None).unwrap_or_else(|why| panic!("{pace}: {why}"));
            assert_eq!(cuts.len(), 6, "{pace}");
            for (cut, (instant, raise)) in cuts.iter().zip(&instants) {
                let end = time[cut.hold.end] / pace;
                // The window of the velocity is three samples to either side, or a tenth of a period.
                let window = if pace < 1.0 { 0.12 } else { 0.05 };
                assert!((end - instant).abs() < window, "{pace}: {end} for {instant}");
                let last = time[cut.swing.end - 1] / pace;
                assert!(last > raise - 0.6 && last < raise + 2.0 * window, "{pace}: {last} for {raise}");
                assert!(distance(cut.held, [0.2, 0.0, 0.0]) < 1e-3, "{pace}: {cut:?}");
                assert!(distance(cut.rest, [0.15, 0.0, -0.12]) < 3e-3, "{pace}: {cut:?}");
                let onset = estimate(&time, &path, cut, step).unwrap();
                let error = (onset.instant / pace - instant).abs();
                // A sample is 0.01 s.
                assert!(
                    error < 0.008 && error < 4.0 * onset.uncertainty / pace,
                    "{pace}: {onset:?} for {instant}"
                );
            }
        }
    }

    /// From the rest to the hold in a quarter of a second: as fast as a release, and none.
    #[test]
    fn a_fast_raise_hides_no_release() {
        let (time, mut path, instants) = raised_and_released(4);
        let raise = instants[2].0 - 0.8 - 1.4;
        for (point, t) in path.iter_mut().zip(&time).filter(|(_, t)| (raise..raise + 1.4).contains(*t)) {
            let share = ((t - raise - 1.1) / 0.25).clamp(0.0, 1.0);
            *point = Some(along(0.5 + 0.5 * (std::f64::consts::PI * share).cos(), 0.2));
        }
        let cuts = cut(&time, &path, 0.01, 1e-5, None).unwrap();
        assert_eq!(cuts.len(), 4);
    }

    #[test]
    fn what_is_no_release_is_none() {
        let still = vec![Some([0.1, 0.0, 0.0]); 500];
        let time: Vec<f64> = (0..500).map(|i| 0.01 * i as f64).collect();
        let why = cut(&time, &still, 0.01, 1e-5, None).unwrap_err();
        assert!(why.starts_with("the tip moves at 0.0 mm/s at most"), "{why}");
        // Inflated and let off again: it goes and comes, and does not swing.
        let step = |t: f64| 1.0 / (1.0 + (-20.0 * t).exp());
        let inflated: Vec<_> =
            time.iter().map(|t| Some([0.1, 0.0, 0.05 * (step(t - 1.5) - step(t - 3.5))])).collect();
        let why = cut(&time, &inflated, 0.01, 1e-5, None).unwrap_err();
        assert!(why.contains("swings after none of them"), "{why}");
        let (time, path) = falling_swing(1.23, 6.0, 0.2, 8.0, 0.01);
        assert_eq!(cut(&time, &path, 0.01, 1e-5, None).unwrap().len(), 1);
    }
}
