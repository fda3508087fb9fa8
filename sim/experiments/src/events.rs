//! What happens in a run: it is let go, the pressure changes, a force begins, ends or goes on.
//!
//! The events come from what drives the run, see [`Drive`]. Each has its window, up to the next, and its numbers: those of
//! a step response in x and in z, and the swing along the first mode. Under steady forcing there are gain and phase instead.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use efam_core::accuracy::AT_REST;
use efam_core::rest::{Rest, rest};
use efam_core::trajectory::Trajectory;
use models::model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::coordinate::Coordinate;
use crate::analysis::forced::{Response, response};
use crate::analysis::step::{Step, step};
use crate::drive::{Change, Drive};

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// The rod was let go, away from its rest or with a velocity.
    Release,
    /// The pressure changed within a tenth of a period of the first mode.
    PressureStep,
    /// It changed more slowly.
    PressureRamp,
    /// A force changed within a tenth of a period of the first mode.
    ForceStep,
    /// It changed more slowly.
    ForceRamp,
    /// A periodic force acts.
    SteadyForcing,
}

/// An event of a run and what followed, up to the next. Times of its numbers count from the event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// The effect whose force it is; none of a release or a pressure.
    pub effect: Option<String>,
    /// When it began, s after the start of the run.
    pub time_s: f64,
    /// When its change was over.
    pub until_s: f64,
    /// The next event, or the end of the run.
    pub window_end_s: f64,
    /// Before: Pa of a pressure, N of a force.
    pub from: Option<f64>,
    /// After; of a steady forcing the amplitude, N.
    pub to: Option<f64>,
    /// Response of the tip along x.
    pub x: Option<Step>,
    /// Response of the tip along z.
    pub z: Option<Step>,
    /// Frequency of a steady forcing.
    pub forcing_hz: Option<f64>,
    /// Gain and phase of the tip along x under steady forcing.
    pub forced_x: Option<Response>,
    /// The same along z.
    pub forced_z: Option<Response>,
    /// Why entries are null, by their names.
    pub missing: BTreeMap<String, String>,
}

impl Event {
    /// In words, with its time.
    pub fn name(&self) -> String {
        let number = |value: Option<f64>, factor: f64| {
            models::digits::significant_or_dash(value.map(|value| factor * value), 3)
        };
        let of = self.effect.as_deref().unwrap_or_default();
        let at = models::digits::fixed(self.time_s, 2);
        let ends = |factor| (number(self.from, factor), number(self.to, factor));
        match self.kind {
            EventKind::Release => format!("release at {at} s"),
            EventKind::PressureStep | EventKind::PressureRamp => {
                let (from, to) = ends(1e-3);
                let what = if self.kind == EventKind::PressureStep { "step" } else { "ramp" };
                format!("pressure {what} from {from} to {to} kPa at {at} s")
            }
            EventKind::ForceStep | EventKind::ForceRamp => {
                let (from, to) = ends(1.0);
                let what = if self.kind == EventKind::ForceStep { "step" } else { "ramp" };
                format!("{of}: force {what} from {from} to {to} N at {at} s")
            }
            EventKind::SteadyForcing => {
                let hertz = number(self.forcing_hz, 1.0);
                format!("{of}: force of {} N at {hertz} Hz from {at} s on", number(self.to, 1.0))
            }
        }
    }
}

/// Share of a period of the first mode below which a change is a step.
const AT_ONCE: f64 = 0.1;

/// The events of a run, by time, without their numbers.
pub fn events(
    model: &Model,
    trajectory: &Trajectory,
    drive: &Drive,
    at_release: Option<&Rest>,
) -> Vec<Event> {
    let end = end_of(trajectory);
    let first_mode = at_release.and_then(|rest| rest.modes.as_ref().ok()?.first().copied());
    let period = first_mode.map_or(0.0, |(hertz, _)| hertz.recip());
    let mut all: Vec<Event> = Vec::new();
    let event = |kind, effect: Option<&str>, change: &Change| Event {
        kind,
        effect: effect.map(str::to_owned),
        time_s: change.time,
        until_s: change.until,
        window_end_s: end,
        from: Some(change.from),
        to: Some(change.to),
        x: None,
        z: None,
        forcing_hz: change.frequency,
        forced_x: None,
        forced_z: None,
        missing: BTreeMap::new(),
    };
    let is_step = |change: &Change| change.until - change.time <= AT_ONCE * period;
    for change in &drive.pressure_changes {
        let kind = if is_step(change) { EventKind::PressureStep } else { EventKind::PressureRamp };
        all.push(event(kind, None, change));
    }
    for force in &drive.forces {
        for change in &force.changes {
            let kind = match change.frequency {
                Some(_) => EventKind::SteadyForcing,
                None if is_step(change) => EventKind::ForceStep,
                None => EventKind::ForceRamp,
            };
            all.push(event(kind, Some(&force.effect), change));
        }
    }
    if is_released(model, trajectory, at_release) {
        // What changes from the release on is part of it.
        let is_at_once = |event: &Event| event.time_s == 0.0 && event.kind != EventKind::SteadyForcing;
        all.retain(|event| !is_at_once(event));
        let none = Change { time: 0.0, until: 0.0, from: 0.0, to: 0.0, frequency: None };
        all.push(Event { from: None, to: None, ..event(EventKind::Release, None, &none) });
    }
    all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then((a.kind as u8).cmp(&(b.kind as u8))));
    for k in 0..all.len() {
        let next = all[k + 1..].iter().map(|next| next.time_s).find(|next| *next > all[k].time_s);
        all[k].window_end_s = next.unwrap_or(end).min(end);
    }
    all.retain(|event| event.kind == EventKind::Release || event.time_s < end);
    all
}

fn end_of(trajectory: &Trajectory) -> f64 {
    let trace = &trajectory.trace;
    trace.time(trace.tip.len().saturating_sub(1))
}

/// Whether the tip starts off the rest at the release, or with a velocity.
fn is_released(model: &Model, trajectory: &Trajectory, at_release: Option<&Rest>) -> bool {
    let (Some(rest), Some(tip)) = (at_release, trajectory.trace.tip.first()) else { return true };
    let least = AT_REST * model.rod().length;
    let [vx, vz] = trajectory.trace.velocity.first().copied().unwrap_or_default();
    let first_mode = rest.modes.as_ref().ok().and_then(|modes| modes.first());
    let of_velocity = first_mode.map_or(0.0, |(hertz, _)| vx.hypot(vz) / (TAU * hertz));
    (tip[0] - rest.tip[0]).hypot(tip[1] - rest.tip[1]) + of_velocity > least
}

/// Points of the trace within the window of an event, from the end of its change or from its beginning on, and the time of
/// the first, s.
pub fn window(trajectory: &Trajectory, from: f64, to: f64) -> (f64, &[[f64; 2]]) {
    let trace = &trajectory.trace;
    if trace.step <= 0.0 {
        return (from, &[]);
    }
    let count = trace.tip.len();
    // The first point at or after the event, and the last before the next one.
    let first = (from / trace.step - 1e-9).ceil().max(0.0);
    let begin = first * trace.step;
    let first = (first as usize).min(count);
    let last = ((to / trace.step + 1e-9).floor() as usize + 1).clamp(first, count);
    (begin, &trace.tip[first..last])
}

/// The rest at the end of an event's window.
pub fn rest_after(model: &Model, event: &Event, modes: usize) -> Result<Rest, String> {
    // A load that jumps at the next event has its value of before.
    let before = event.window_end_s - 1e-9 * event.window_end_s.max(1.0);
    rest(model, before, modes).map_err(|error| error.to_string())
}

/// The numbers of each event.
pub fn measure(model: &Model, trajectory: &Trajectory, drive: &Drive, all: &mut [Event]) {
    let forcing = all.iter().find(|event| event.kind == EventKind::SteadyForcing).map(|event| event.time_s);
    let length = model.rod().length;
    for event in all {
        if event.kind == EventKind::SteadyForcing {
            forced(trajectory, drive, event);
            continue;
        }
        let (begin, path) = window(trajectory, event.time_s, event.window_end_s);
        let steady = if forcing.is_some_and(|from| from < event.window_end_s) {
            Err("a periodic force acts, so there is no steady state".to_owned())
        } else {
            rest_after(model, event, 0)
        };
        let along = |k: usize| -> Result<Step, String> {
            let steady = steady.as_ref().map_err(Clone::clone)?.tip[k];
            let values: Vec<f64> = path.iter().map(|at| at[k]).collect();
            Ok(step(&values, trajectory.trace.step, steady, AT_REST * length)?.later(begin - event.time_s))
        };
        let (x, z) = (along(0), along(1));
        for (name, own) in [("x", &x), ("z", &z)] {
            if let Err(why) = own {
                event.missing.insert(name.to_owned(), why.clone());
            }
        }
        (event.x, event.z) = (x.ok(), z.ok());
    }
}

fn forced(trajectory: &Trajectory, drive: &Drive, event: &mut Event) {
    let force = drive.forces.iter().find(|force| Some(&force.effect) == event.effect.as_ref());
    let (Some(force), Some(hertz)) = (force, event.forcing_hz) else { return };
    let (begin, path) = window(trajectory, event.time_s, event.window_end_s);
    for (k, name) in [(0, "forced_x"), (1, "forced_z")] {
        let values: Vec<f64> = path.iter().map(|at| at[k]).collect();
        match response((&values, begin, trajectory.trace.step), (&force.times, &force.main()), hertz) {
            Ok(found) if k == 0 => event.forced_x = Some(found),
            Ok(found) => event.forced_z = Some(found),
            Err(why) => {
                event.missing.insert(name.to_owned(), why);
            }
        }
    }
}

/// The event whose swing the run's own numbers are: the release, or else the first that is no steady forcing.
pub fn main_event(all: &[Event]) -> Option<&Event> {
    let is = |kind: EventKind| move |event: &&Event| event.kind == kind;
    all.iter()
        .find(is(EventKind::Release))
        .or_else(|| all.iter().find(|e| e.kind != EventKind::SteadyForcing))
}

/// The coordinate along which a run is analysed about a rest, positive on the side of the first point of its path.
pub fn coordinate(path: &[[f64; 2]], rest: &Rest) -> Coordinate {
    let largest_motion = || Coordinate::largest_motion(path.iter().copied(), rest.tip);
    let start = path.first().map_or([0.0; 2], |at| [at[0] - rest.tip[0], at[1] - rest.tip[1]]);
    rest.first_direction.map_or_else(largest_motion, Coordinate::first_mode).towards(start)
}
