//! What drives a run from outside: its pressure over time, and the forces of loads that depend on time.

use efam_core::trajectory::Trajectory;
use models::effects::Kind;
use models::line::RodPressure;
use models::model::Model;
use models::system::System;

/// What drives a run.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// Times at which the pressure changes, and to what, Pa.
    pub pressure_changes: Vec<Change>,
    /// The loads that depend on time.
    pub forces: Vec<Force>,
}

/// A change of a pressure, Pa, or of a force, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// When it begins, s.
    pub time: f64,
    /// When it ends, s.
    pub until: f64,
    /// Before.
    pub from: f64,
    /// After; of a periodic force its amplitude.
    pub to: f64,
    /// Frequency of a periodic force, Hz.
    pub frequency: Option<f64>,
}

/// The force of a load on the rod at its start, over time.
#[derive(Clone, Debug)]
pub struct Force {
    /// Name of its effect.
    pub effect: String,
    /// s.
    pub times: Vec<f64>,
    /// Resultant on all nodes in W, N.
    pub values: Vec<[f64; 2]>,
    /// When it changes.
    pub changes: Vec<Change>,
}

/// Times at which a force is evaluated at most.
const MOST_TIMES: usize = 20_000;
/// Share of the range of a force below which it does not change from one time to the next.
const STILL: f64 = 1e-6;
/// Crossings of its mean from which on a force may be periodic, and by which share their distances may differ.
const LEAST_CROSSINGS: usize = 4;
const UNEVEN: f64 = 0.02;

impl Drive {
    /// That of a run.
    pub fn of(model: &Model, trajectory: &Trajectory) -> Self {
        let trace = &trajectory.trace;
        let end = trace.time(trace.tip.len().saturating_sub(1));
        Self { pressure_changes: pressure_changes(model, end), forces: forces(model, trajectory) }
    }

    /// Whether nothing changes but the rod itself.
    pub fn is_still(&self) -> bool {
        self.pressure_changes.is_empty() && self.forces.is_empty()
    }
}

/// Indices of the effects of a model that are loads which depend on time.
pub fn timed_loads(model: &Model) -> Vec<usize> {
    let is_timed_load = |k: &usize| {
        let about = model.effects[*k].effect.about();
        about.timed && about.kind == Kind::Load
    };
    (0..model.effects.len()).filter(is_timed_load).collect()
}

fn pressure_changes(model: &Model, end: f64) -> Vec<Change> {
    let inner = model.kinks().into_iter().filter(|time| *time > 0.0 && *time < end);
    let times: Vec<f64> = [0.0].into_iter().chain(inner).chain([end]).collect();
    let pressure = RodPressure::of(model);
    let mut changes: Vec<Change> = Vec::new();
    for pair in times.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|time| pressure.at(time));
        if (to - from).abs() <= STILL * from.abs().max(1.0) {
            continue;
        }
        match changes.last_mut() {
            Some(last) if last.until == pair[0] => (last.until, last.to) = (pair[1], to),
            _ => changes.push(Change { time: pair[0], until: pair[1], from, to, frequency: None }),
        }
    }
    changes
}

fn forces(model: &Model, trajectory: &Trajectory) -> Vec<Force> {
    let loads = timed_loads(model);
    if loads.is_empty() || trajectory.times.is_empty() {
        return Vec::new();
    }
    let trace = &trajectory.trace;
    let stride = trace.tip.len().div_ceil(MOST_TIMES).max(1);
    let times: Vec<f64> = (0..trace.tip.len()).step_by(stride).map(|point| trace.time(point)).collect();
    let start = trajectory.state(0);
    let still = vec![0.0; start.v.len()];
    let mut system = System::new(model);
    let of = |k: &usize| {
        let mut at = |time: &f64| {
            let nodes = system.forces_of(*k, *time, &start.q, &still, &start.z).unwrap_or_default();
            nodes.iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]])
        };
        let values: Vec<[f64; 2]> = times.iter().map(&mut at).collect();
        let effect = model.effects[*k].effect.about().name.to_owned();
        let force = Force { effect, times: times.clone(), values, changes: Vec::new() };
        let mut changes = changes(&force.times, &force.main());
        let component = force.component();
        changes.iter_mut().for_each(|change| locate(change, &times, &mut |time| at(&time)[component]));
        Force { changes, ..force }
    };
    loads.iter().map(of).filter(|force| !force.changes.is_empty()).collect()
}

impl Force {
    /// Which component has the larger range: 0 along x, 1 along z.
    pub fn component(&self) -> usize {
        let component = |k: usize| self.values.iter().map(move |value| value[k]);
        usize::from(range(component(1)) > range(component(0)))
    }

    /// That component, N.
    pub fn main(&self) -> Vec<f64> {
        let k = self.component();
        self.values.iter().map(|value| value[k]).collect()
    }
}

/// Finds the instant of a jump between two times by bisection.
fn locate(change: &mut Change, times: &[f64], force: &mut dyn FnMut(f64) -> f64) {
    if change.time != change.until || change.frequency.is_some() {
        return;
    }
    let after = times.partition_point(|time| *time < change.time);
    let Some(before) = after.checked_sub(1) else { return };
    let (mut low, mut high) = (times[before], change.time);
    // To the last bit but a few.
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        let value = force(middle);
        if (value - change.from).abs() < (value - change.to).abs() { low = middle } else { high = middle }
    }
    (change.time, change.until) = (high, high);
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    (high - low).max(0.0)
}

/// When a force changes: a periodic one once, from its beginning on.
fn changes(times: &[f64], values: &[f64]) -> Vec<Change> {
    let least = STILL * range(values.iter().copied());
    let (Some(end), true) = (times.last(), least > 0.0) else { return Vec::new() };
    let moves = |k: usize| (values[k + 1] - values[k]).abs() > least;
    let Some(first) = (0..values.len() - 1).find(|k| moves(*k)) else { return Vec::new() };
    if let Some((frequency, amplitude)) = periodic(&times[first..], &values[first..]) {
        let (time, from) = (times[first], values[first]);
        return vec![Change { time, until: *end, from, to: amplitude, frequency: Some(frequency) }];
    }
    let mut changes: Vec<Change> = Vec::new();
    let mut k = first;
    while k < values.len() - 1 {
        let length = (k..values.len() - 1).take_while(|k| moves(*k)).count();
        if length > 0 {
            let (from, to) = (values[k], values[k + length]);
            // Of a jump between two times, the later one: at it the force is what it is from then on.
            let time = if length == 1 && k > 0 { times[k + 1] } else { times[k] };
            changes.push(Change { time, until: times[k + length], from, to, frequency: None });
        }
        k += length.max(1);
    }
    changes
}

/// Frequency, Hz, and amplitude of a force that is periodic in the later half of its times.
fn periodic(times: &[f64], values: &[f64]) -> Option<(f64, f64)> {
    let half = values.len() / 2;
    let (times, values) = (&times[half..], &values[half..]);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let crossings: Vec<f64> = (1..values.len())
        .filter(|&k| values[k - 1] < mean && values[k] >= mean)
        .map(|k| {
            times[k - 1] + (times[k] - times[k - 1]) * (mean - values[k - 1]) / (values[k] - values[k - 1])
        })
        .collect();
    if crossings.len() < LEAST_CROSSINGS {
        return None;
    }
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    let is_even = crossings.windows(2).all(|pair| ((pair[1] - pair[0]) / period - 1.0).abs() < UNEVEN);
    is_even.then(|| (period.recip(), 0.5 * range(values.iter().copied())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times() -> Vec<f64> {
        (0..=1000).map(|k| 0.01 * f64::from(k)).collect()
    }

    fn of(force: impl Fn(f64) -> f64) -> Vec<Change> {
        changes(&times(), &times().into_iter().map(force).collect::<Vec<_>>())
    }

    #[test]
    fn steps_ramps_and_oscillations_are_told_apart() {
        assert_eq!(of(|_| 3.0), []);
        let [step] = of(|t| if t < 1.0 { 0.0 } else { 2.0 })[..] else { panic!("one") };
        assert_eq!((step.time, step.until, step.from, step.to), (1.0, 1.0, 0.0, 2.0));
        let [on, off] = of(|t| if (1.0..2.5).contains(&t) { 1.0 } else { 0.0 })[..] else { panic!("two") };
        assert!((on.time, on.to, off.time, off.to) == (1.0, 1.0, 2.5, 0.0), "{on:?} {off:?}");
        let [ramp] = of(|t| (t - 2.0).clamp(0.0, 3.0))[..] else { panic!("one") };
        assert!((ramp.time, ramp.until) == (2.0, 5.0) && (ramp.to - 3.0).abs() < 1e-12, "{ramp:?}");
        let late = |t: f64| if t < 3.0 { 0.0 } else { 0.2 * (8.0 * (t - 3.0)).sin() };
        let [sine] = of(late)[..] else { panic!("one") };
        assert!((sine.frequency.unwrap() * std::f64::consts::TAU / 8.0 - 1.0).abs() < 1e-3, "{sine:?}");
        assert!((sine.time - 3.0).abs() < 0.011 && (sine.to / 0.2 - 1.0).abs() < 1e-2, "{sine:?}");
    }
}
