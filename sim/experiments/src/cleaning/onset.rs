//! The instant of release: where the parabola of the first fall leaves the hold.
//!
//! ```text
//! s(t) = s0 + v0 t                                  while it is held (a hand may drift)
//! s(t) = s0 + v0 t + a (t − t0)² / 2 + v (t − t0)   after it is let go
//! ```
//!
//! `s` is the way along the first fall. `v` is zero, unless the path shows that the hand gave a push: without it
//! the instant of a rod that is pushed upwards would lie where it begins to fall. For each `t0` the rest is linear;
//! the best `t0` is searched between samples. The standard error is that of the fit, and, in quadrature, what `t0`
//! moves when half of the way is fitted: a release is no parabola for long.

use super::cycles::Cut;
use super::distance;

/// When the tip was let go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// On the recording's clock, s.
    pub instant: f64,
    /// Standard error, s.
    pub uncertainty: f64,
    /// Acceleration of the first fall, m/s²; nothing of an instant that is given.
    pub acceleration: Option<f64>,
    /// Velocity along the fall that a push of the hand gave it, m/s; nothing where none shows.
    pub push: Option<f64>,
}

/// Way that is fitted, in the distance of the hold from the rest.
const WAY: f64 = 0.12;
/// Time of the hold that is fitted, s.
const HOLD: f64 = 0.3;
/// Time before the end of the hold at which the instant may be, s, or the time of that way if it is more.
const BEFORE: f64 = 0.15;
/// Samples after the hold that are fitted at least, and that [`WAY`] has to have for a push to be accepted: a higher mode begins
/// as fast.
const LEAST_FALL: usize = 4;
/// Nothing is known better than this share of the longest time without a sample around it: of thirty releases
/// drawn by an independent model at 100 Hz the worst was 4 ms off, where both ways that are fitted said a tenth
/// of that; one whose first tenth of a second was lost was 10 ms off, whichever side of the gap it seemed on.
const LEAST_ERROR: f64 = 0.2;
/// Ratio of variances from which on a push is accepted: noise gives it once in seven hundred releases (F of 1 and 30 degrees of
/// freedom). Of sixty drawn releases without a push the largest was 9, of twelve with one the smallest 21.
const PUSH: f64 = 12.0;
/// What the best parabola leaves of a swing from rest, root mean square: this share of the square of the way that is fitted, over
/// the distance of the hold from the rest. It says nothing of a push.
const SHAPE: f64 = 8e-3;

/// Direction of the first fall from the hold towards the rest, a unit vector; a hand may have pushed it the other way before.
pub fn first_fall(path: &[Option<[f64; 3]>], cut: &Cut) -> Option<[f64; 3]> {
    let least = WAY * distance(cut.held, cut.rest);
    let to_rest: [f64; 3] = std::array::from_fn(|k| cut.rest[k] - cut.held[k]);
    let has_fallen = |at: &[f64; 3]| distance(*at, cut.held) > least && way(*at, cut.held, to_rest) > 0.0;
    let at = cut.swing.clone().filter_map(|i| path[i]).find(has_fallen)?;
    let length = distance(at, cut.held);
    Some(std::array::from_fn(|k| (at[k] - cut.held[k]) / length))
}

/// How far a place lies from the hold along a direction.
fn way(at: [f64; 3], held: [f64; 3], along: [f64; 3]) -> f64 {
    (0..3).map(|k| (at[k] - held[k]) * along[k]).sum()
}

/// Estimates the instant of a release; nothing if too little of the fall is seen.
pub fn estimate(time: &[f64], path: &[Option<[f64; 3]>], cut: &Cut, step: f64) -> Option<Onset> {
    let fall = first_fall(path, cut)?;
    let way = |i: usize| path[i].map(|at| way(at, cut.held, fall));
    let whole = distance(cut.held, cut.rest);
    let begin = cut.hold.clone().find(|&i| time[cut.hold.end - 1] - time[i] <= HOLD)?;
    let enough = cut.swing.clone().filter(|&i| path[i].is_some()).nth(LEAST_FALL - 1)?;
    let until = |share: f64| {
        let past = cut.swing.clone().find(|&i| way(i).is_some_and(|way| way > share * whole))?;
        let samples = (begin..=past.max(enough)).filter_map(|i| Some((time[i], way(i)?))).collect();
        // A slow rod leaves the hold slowly.
        let before = BEFORE.max(time[past] - time[cut.hold.end]);
        Some(Begun { samples, window: [time[cut.hold.end] - before, time[past]], step })
    };
    let begun = until(WAY)?;
    let smooth = begun.search::<SMOOTH>()?;
    let shape = begun.samples.len() as f64 * (SHAPE * begun.way() * begun.way() / whole).powi(2);
    let shows = |fall: &Fall| smooth.cost > fall.cost + PUSH * fall.variance + shape;
    // Few samples do not distinguish a push from a higher mode: then the error holds both.
    let (pushed, perhaps) = match begun.search::<PUSHED>().filter(shows) {
        Some(fall) if begun.fallen(fall.instant.max(time[cut.hold.end - 1])) < LEAST_FALL => {
            (None, Some(fall))
        }
        pushed => (pushed, None),
    };
    let best = pushed.unwrap_or(smooth);
    let half = until(0.5 * WAY);
    let half = half
        .and_then(|half| if pushed.is_some() { half.search::<PUSHED>() } else { half.search::<SMOOTH>() });
    let moved = half.map_or(0.5 * step, |half| half.instant - best.instant);
    let other = perhaps.map_or(0.0, |fall| fall.instant - best.instant);
    let seen = || (begin..=enough).filter(|&i| path[i].is_some()).map(|i| time[i]);
    let around = |pair: &(f64, f64)| pair.1 > best.instant.min(time[cut.hold.end - 1]);
    let longest = seen().zip(seen().skip(1)).filter(around).map(|pair| pair.1 - pair.0).fold(step, f64::max);
    let uncertainty = best.error.hypot(moved).hypot(other).max(LEAST_ERROR * longest);
    let Fall { instant, acceleration, push, .. } = best;
    Some(Onset { instant, uncertainty, acceleration: Some(acceleration), push: pushed.map(|_| push) })
}

/// Unknowns of a path that leaves the hold at an instant: place, velocity and acceleration, and a push.
const SMOOTH: usize = 3;
const PUSHED: usize = 4;

/// A path that leaves the hold.
#[derive(Clone, Copy)]
struct Fall {
    instant: f64,
    /// Standard error of the instant by this fit alone.
    error: f64,
    acceleration: f64,
    push: f64,
    /// Sum of squares, and that over the degrees of freedom.
    cost: f64,
    variance: f64,
}

/// The end of the hold and the begin of the fall.
struct Begun {
    /// Times, s, and ways, m.
    samples: Vec<(f64, f64)>,
    /// Times between which the instant is searched, the later one being that of the last sample on the way that is fitted.
    window: [f64; 2],
    /// Time between two samples, s.
    step: f64,
}

impl Begun {
    /// The way until the last sample, m.
    fn way(&self) -> f64 {
        self.samples.last().map_or(0.0, |(_, way)| *way)
    }

    /// Samples on the way that is fitted, after an instant.
    fn fallen(&self, since: f64) -> usize {
        self.samples.iter().filter(|(t, _)| *t > since && *t <= self.window[1]).count()
    }

    /// The best path that leaves the hold, with so many unknowns.
    fn search<const UNKNOWNS: usize>(&self) -> Option<Fall> {
        let (seen, [from, to]) = (&self.samples, self.window);
        let free = seen.len().checked_sub(UNKNOWNS + 1).filter(|free| *free > 1)?;
        let fine = 0.05 * self.step;
        let count = ((to - from) / fine).ceil() as usize;
        let costs: Vec<(f64, f64, [f64; UNKNOWNS])> = (0..=count)
            .map(|k| from + fine * k as f64)
            .filter_map(|t0| fit(seen, t0).map(|(cost, solved)| (t0, cost, solved)))
            .filter(|(_, _, solved)| solved[2] > 0.0)
            .collect();
        let best = (0..costs.len()).min_by(|&a, &b| costs[a].1.total_cmp(&costs[b].1))?;
        let (t0, cost, solved) = costs[best];
        let variance = cost / free as f64;
        let found = |instant: f64, error: f64| {
            let push = solved.get(SMOOTH).copied().unwrap_or(0.0);
            Some(Fall { instant, error, acceleration: solved[2], push, cost, variance })
        };
        // The parabola through the costs on either side: its vertex, and how sharp it is.
        let (before, after) = (costs.get(best.wrapping_sub(1)), costs.get(best + 1));
        let (Some(before), Some(after)) = (before, after) else { return found(t0, self.step) };
        // Nothing is known worse than that it lies somewhere in the window, any place as likely as another.
        let anywhere = (to - from) / 12f64.sqrt();
        let bend = (before.1 - 2.0 * cost + after.1).max(0.0) / (fine * fine);
        let shift = if bend > 0.0 { 0.5 * (before.1 - after.1) / (bend * fine) } else { 0.0 };
        let error = if bend > 0.0 { (2.0 * variance / bend).sqrt().min(anywhere) } else { anywhere };
        found(t0 + shift.clamp(-fine, fine), error)
    }
}

/// Sum of squares and unknowns of the best path that leaves the hold at an instant.
fn fit<const UNKNOWNS: usize>(seen: &[(f64, f64)], t0: f64) -> Option<(f64, [f64; UNKNOWNS])> {
    use nalgebra::{SMatrix, SVector};
    let row = |t: f64| {
        let since = (t - t0).max(0.0);
        SVector::<f64, UNKNOWNS>::from_fn(|k, _| [1.0, t - t0, 0.5 * since * since, since][k])
    };
    let (mut normal, mut right) = (SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros(), SVector::zeros());
    for (t, s) in seen {
        let row = row(*t);
        normal += row * row.transpose();
        right += row * *s;
    }
    let solved = normal.cholesky()?.solve(&right);
    let cost = seen.iter().map(|(t, s)| (s - row(*t).dot(&solved)).powi(2)).sum();
    Some((cost, solved.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::cycles::cut;
    use crate::cleaning::tests::{Noise, falling_swing};

    /// Free fall from a level hold, at any place between two samples, under noise.
    #[test]
    fn the_instant_is_found_between_samples_within_its_error() {
        let mut noise = Noise::new(2);
        let (mut outside, mut count) = (0, 0);
        for k in 0..20 {
            let instant = 1.2 + 0.0005 * k as f64;
            let (time, mut path) = falling_swing(instant, 6.0, 0.2, 8.0, 0.01);
            noise.disturb(&mut path, 2e-4);
            let cuts = cut(&time, &path, 0.01, 2e-4, None).unwrap();
            let onset = estimate(&time, &path, &cuts[0], 0.01).unwrap();
            let error = onset.instant - instant;
            assert!(error.abs() < 0.004, "{onset:?} for {instant}");
            assert_eq!(onset.push, None, "for {instant}");
            outside += usize::from(error.abs() > 2.0 * onset.uncertainty);
            count += 1;
        }
        // One in twenty by chance; the error of the model is only estimated.
        assert!(outside * 5 <= count, "{outside} of {count}");
    }

    /// A hand that pushes upwards or down: without the push, the instant of the first would be where it begins to fall, a
    /// twentieth of a second late.
    #[test]
    fn the_instant_of_a_push_is_where_the_hand_lets_go() {
        let mut noise = Noise::new(3);
        for push in [-0.3, 0.4] {
            let instant = 1.2034;
            let (time, mut path) = falling_swing(instant, 6.0, 0.2, 8.0, 0.01);
            for (t, point) in time.iter().zip(&mut path) {
                let since = (t - instant).max(0.0);
                point.as_mut().unwrap()[2] -= push / 8.0 * (8.0 * since).sin() * (-0.4 * since).exp();
            }
            noise.disturb(&mut path, 2e-4);
            let cuts = cut(&time, &path, 0.01, 2e-4, None).unwrap();
            let onset = estimate(&time, &path, &cuts[0], 0.01).unwrap();
            assert!((onset.instant - instant).abs() < 0.004, "{onset:?} of {push}");
            assert!(onset.push.is_some_and(|found| (found - push).abs() < 0.08), "{onset:?} of {push}");
        }
    }

    /// A parabola is no swing, which shows where there is no noise.
    #[test]
    fn a_release_without_noise_has_no_push() {
        for omega in [6.0, 8.0, 28.0] {
            let (time, path) = falling_swing(1.2034, 6.0, 0.2, omega, 0.01);
            let cuts = cut(&time, &path, 0.01, 1e-6, None).unwrap();
            let onset = estimate(&time, &path, &cuts[0], 0.01).unwrap();
            assert_eq!(onset.push, None, "{onset:?}");
        }
    }
}
