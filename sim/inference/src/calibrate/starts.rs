//! Where a search begins: points spread around the start, each compared by the first swing.
//!
//! A wrong stiffness or loss shows as a wrong frequency or decay, and within the first swing no
//! phase is lost by a whole turn yet, so the least cost there is a safe beginning.

use efam_core::loss::Huber;
use models::statics::{equilibrium, modes};
use nalgebra::DVector;
use rayon::prelude::*;

use super::objective::Objective;
use super::prediction::Member;
use super::unknowns::UnknownKind;
use super::view::View;

/// Swings by which starts are compared: one, and a little so that its upper peak is seen.
pub(super) const FIRST_SWINGS: f64 = 1.25;
/// Points beside the start.
const POINTS: usize = 40;
/// Factors around the start: what describes the rod itself is known better than losses.
const ROD_SPREAD: f64 = 1.7;
const EFFECT_SPREAD: f64 = 4.0;
/// Time of a swing where the model has no rest to swing about, as a share of the recording.
const UNKNOWN_SWING: f64 = 0.1;

/// Time of one small swing of each release about its rest, s.
pub(super) fn swing_times(objective: &Objective, x: &DVector<f64>) -> Vec<f64> {
    let releases = 0..objective.part.members.len();
    let of = |r: usize| {
        let member = objective.member(r);
        let Member { trial, measured, .. } = member;
        let (theta, _) = member.values(x);
        let (mut model, _) = trial.with(&theta);
        model.schedule = None;
        let slowest = equilibrium(&model, None).and_then(|rest| modes(&model, &rest, 1)).ok();
        let frequency = slowest.and_then(|modes| modes.first().map(|mode| mode.angular_frequency));
        let last = measured.samples.last().map_or(0.0, |k| trial.release.time[*k]);
        match frequency {
            Some(frequency) if frequency > 0.0 => std::f64::consts::TAU / frequency,
            _ => UNKNOWN_SWING * last,
        }
    };
    releases.into_par_iter().map(of).collect()
}

/// How many samples of each release lie within so many swings; five at least.
pub(super) fn counts(objective: &Objective, times: &[f64], swings: f64) -> Vec<usize> {
    let of = |(r, time): (usize, &f64)| {
        let (trial, measured) = (&objective.part.members[r], &objective.measured[r]);
        let within = measured.samples.partition_point(|k| trial.release.time[*k] <= swings * time);
        within.max(5).min(measured.samples.len())
    };
    times.iter().enumerate().map(of).collect()
}

/// The start and points around it, the best by the first swing before the others.
pub(super) fn ranked(objective: &Objective, start: &DVector<f64>) -> Vec<DVector<f64>> {
    let points = spread(objective, start);
    let times = swing_times(objective, start);
    let mut counts = counts(objective, &times, FIRST_SWINGS);
    leave_out_repeats(objective, &mut counts);
    let loss = vec![Huber { threshold: f64::INFINITY }; times.len()];
    let view = View { counts, loss, ..View::of_all(objective.all()) };
    let cost = |x: &DVector<f64>| {
        let seen = objective.see(x, &view, None)?;
        // A ghost in the first swing must not choose: the spread of each release does.
        let (spreads, priors) = (seen.spreads(), objective.cost(&Default::default(), x, &view));
        let lengths = view.counts.iter().zip(spreads);
        Some(priors + lengths.map(|(count, spread)| *count as f64 * spread * spread).sum::<f64>())
    };
    let costs: Vec<f64> =
        points.par_iter().map(|x| cost(x).filter(|cost| cost.is_finite()).unwrap_or(f64::INFINITY)).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]).then(a.cmp(b)));
    order.into_iter().map(|k| points[k].clone()).collect()
}

/// Takes no samples of releases whose pressure others have shown.
fn leave_out_repeats(objective: &Objective, counts: &mut [usize]) {
    let pressure = |r: usize| objective.part.members[r].release.pressure;
    for r in 0..counts.len() {
        if (0..r).any(|other| pressure(other) == pressure(r)) {
            counts[r] = 0;
        }
    }
}

/// The start, then points of Halton's sequence around it; all unknowns of one parameter go together. What was
/// weighed or measured stays where it is: a rod half as heavy again and as stiff swings as well.
/// Source: Halton (1960), Numerische Mathematik 2, 84-90.
fn spread(objective: &Objective, start: &DVector<f64>) -> Vec<DVector<f64>> {
    let unknowns = &objective.part.unknowns;
    let mut spread_out: Vec<usize> = Vec::new();
    for unknown in unknowns {
        if let UnknownKind::Parameter(k) = unknown.kind
            && unknown.prior.is_none()
            && unknown.start > 0.0
            && unknown.scaled.value(unknown.bounds.0) >= 0.0
            && !spread_out.contains(&k)
        {
            spread_out.push(k);
        }
    }
    const BASES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
    spread_out.truncate(BASES.len());
    let count = if spread_out.is_empty() { 0 } else { POINTS };
    let mut points = vec![start.clone()];
    for point in 1..=count {
        let mut x = start.clone();
        for (u, unknown) in unknowns.iter().enumerate() {
            let UnknownKind::Parameter(k) = unknown.kind else { continue };
            let Some(place) = spread_out.iter().position(|other| *other == k) else { continue };
            let factor = if unknown.name.starts_with("rod.") { ROD_SPREAD } else { EFFECT_SPREAD };
            let share = 2.0 * van_der_corput(point, BASES[place]) - 1.0;
            let value = unknown.scaled.value(x[u]) * factor.powf(share);
            x[u] = unknown.scaled.variable(value).clamp(unknown.bounds.0, unknown.bounds.1);
        }
        points.push(x);
    }
    points
}

/// The digits of a number in a base, mirrored behind the point.
fn van_der_corput(mut number: usize, base: usize) -> f64 {
    let (mut value, mut unit) = (0.0, 1.0 / base as f64);
    while number > 0 {
        value += unit * (number % base) as f64;
        number /= base;
        unit /= base as f64;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_fills_the_unit_interval() {
        assert_eq!([1, 2, 3, 4, 5].map(|k| van_der_corput(k, 2)), [0.5, 0.25, 0.75, 0.125, 0.625]);
        assert_eq!([1, 2, 3].map(|k| (9.0 * van_der_corput(k, 3)).round()), [3.0, 6.0, 1.0]);
    }
}
