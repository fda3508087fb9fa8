//! Rods in motion, as a page's script plays them: postures over time, measured markers, the rest.

use std::ops::ControlFlow;

use efam_core::forward::{Run, forward};
use efam_core::quantile::usual_step;
use efam_core::trajectory::Trajectory;
use efam_inference::calibrate::unknowns::RELEASE_INSTANT;
use efam_inference::calibrate::{CalibrationOutcome, Problem, Trial};
use efam_inference::diagnose::DiagnosisOutcome;
use models::model::Model;
use models::system::System;
use serde_json::{Value, json};

use crate::picture::chart::{Stroke, column, column_in, look};
use crate::picture::{BLACK, BLUE, MILLI, VERMILION, base_angle};

/// Nodes of a rod that are kept at most, beside its tip.
const NODES: usize = 33;
/// The same of a rod of a family.
const NODES_OF_CASE: usize = 12;
/// Time over which a family moves, s, and by how much a place of it may be off, mm.
const MOST_TIME: f64 = 8.0;
const OFF_OF_CASE: f64 = 1.0;
/// Unit of the places, mm.
const UNIT: f64 = 0.1;
/// By how much a place may be off when it is interpolated between two frames, mm.
const OFF: f64 = 0.5;
/// Frames in a row that are left out at most.
const SKIPPED: usize = 24;

/// Instants of a release that are simulated for it, and releases of a page that are.
const INSTANTS: usize = 1500;
const RELEASES: usize = 6;
/// Label of the time of releases.
const SINCE_RELEASE: &str = "time since release, s";

/// A time, s, and the places of the nodes and of the tip then, m.
pub type Frame = (f64, Vec<[f64; 2]>);

/// What moves, and what is fixed beside it.
#[derive(Clone, Debug)]
pub struct Rods {
    /// What it shows.
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// Label of the axis of the charts with the same time.
    pub clock: &'static str,
    /// Direction of the clamp, rad.
    pub angle: f64,
    /// Nodes and tip at rest, m.
    pub rest: Option<Vec<[f64; 2]>>,
    /// Models.
    pub rods: Vec<Rod>,
    /// What was measured.
    pub markers: Vec<Marker>,
}

/// A model in motion.
#[derive(Clone, Debug)]
pub struct Rod {
    name: String,
    stroke: Stroke,
    frames: Vec<Frame>,
    /// Which case of the page's family it is.
    case: Option<usize>,
}

/// Where a marker was seen.
#[derive(Clone, Debug)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// Its look.
    pub stroke: Stroke,
    /// Times, s, and places, m.
    pub seen: Vec<(f64, [f64; 2])>,
    /// How far from a sample it still counts as seen, s.
    pub within: f64,
}

impl Rod {
    /// Thinned to what is needed to draw it; nothing without two frames.
    pub fn new(name: &str, stroke: Stroke, frames: Vec<Frame>) -> Option<Self> {
        Self::of_nodes((NODES, OFF), name, stroke, frames)
    }

    /// A case of a family, with fewer nodes: a page has many of them.
    fn of_case(case: usize, name: &str, frames: Vec<Frame>) -> Option<Self> {
        let rod = Self::of_nodes((NODES_OF_CASE, OFF_OF_CASE), name, Stroke::new(BLUE, 2.0), frames)?;
        Some(Self { case: Some(case), ..rod })
    }

    fn of_nodes((most, off): (usize, f64), name: &str, stroke: Stroke, frames: Vec<Frame>) -> Option<Self> {
        let nodes = frames.first()?.1.len();
        let every = (nodes - 1).div_ceil(most).max(1);
        let is_kept = |k: usize| k.is_multiple_of(every) || k + 2 >= nodes;
        let kept = |(time, nodes): Frame| {
            let own = nodes.into_iter().enumerate().filter(|(k, _)| is_kept(*k)).map(|(_, at)| at);
            (time, own.collect())
        };
        let frames = thinned(frames.into_iter().map(kept).collect(), off);
        (frames.len() > 1).then(|| Self { name: name.to_owned(), stroke, frames, case: None })
    }

    fn places(&self) -> impl Iterator<Item = &[f64; 2]> {
        self.frames.iter().flat_map(|(_, nodes)| nodes)
    }

    fn json(&self) -> Value {
        let times: Vec<f64> = self.frames.iter().map(|frame| frame.0).collect();
        let node = |k: usize| -> Value {
            let axis = |axis: usize| {
                let all: Vec<f64> = self.frames.iter().map(|frame| MILLI * frame.1[k][axis]).collect();
                column_in(&all, UNIT)
            };
            json!([axis(0), axis(1)])
        };
        let nodes: Vec<Value> = (0..self.frames[0].1.len()).map(node).collect();
        let (name, look, times) = (&self.name, look(&self.stroke), column(&times));
        json!({ "name": name, "look": look, "times": times, "nodes": nodes, "case": self.case })
    }
}

/// A rod over a release of that duration, s, as far as it can be run; its times later by `late`, s.
fn frames(model: &Model, run: &Run, duration: f64, late: f64) -> Vec<Frame> {
    let samples = (0..INSTANTS).map(|k| duration * k as f64 / (INSTANTS - 1) as f64).collect();
    let mut frames = Vec::with_capacity(INSTANTS);
    let _ = forward(model, &Run { samples, duration, ..run.clone() }, &mut |sample| {
        let snapshot = sample.snapshot();
        frames.push((snapshot.time + late, [snapshot.nodes, vec![snapshot.tip]].concat()));
        ControlFlow::Continue(())
    });
    frames
}

fn duration(trial: &Trial) -> f64 {
    trial.release.time.last().copied().unwrap_or(0.0)
}

fn seen(name: &str, seen: Vec<(f64, [f64; 2])>) -> Marker {
    let times: Vec<f64> = seen.iter().map(|seen| seen.0).collect();
    let within = usual_step(&times).unwrap_or(0.0).max(1e-3);
    Marker { name: format!("{name}, measured"), stroke: Stroke::new(BLACK, 1.8), seen, within }
}

fn of_release(trial: &Trial, caption: &str, rods: Vec<Rod>, markers: Vec<Marker>) -> Option<Rods> {
    (!rods.is_empty()).then(|| Rods {
        title: format!("The rod in motion: {}", trial.release.name),
        caption: caption.to_owned(),
        clock: SINCE_RELEASE,
        angle: base_angle(&trial.model),
        rest: None,
        rods,
        markers,
    })
}

/// The fitted rod of each of the first releases, and its markers.
pub fn of_calibration(problem: &Problem, outcome: &CalibrationOutcome) -> Vec<Rods> {
    let held = outcome.calibration.as_held(problem);
    let one = |trial: &Trial| {
        let name = &trial.release.name;
        let late = outcome.calibration.nuisance(name, RELEASE_INSTANT);
        let rod = Rod::new(
            "fitted",
            Stroke::new(BLUE, 2.0),
            frames(&trial.model, &trial.run, duration(trial), late),
        );
        let curves = outcome.curves.iter().filter(|curve| curve.release == *name);
        let markers = curves.map(|curve| {
            seen(&curve.marker, curve.time.iter().copied().zip(curve.measured.iter().copied()).collect())
        });
        let caption = "The fitted rod over the markers as they were seen; the charts show the same instant.";
        of_release(trial, caption, rod.into_iter().collect(), markers.collect())
    };
    held.trials().take(RELEASES).filter_map(one).collect()
}

/// The rod before an effect is added and after, of each of the first releases, and its markers.
pub fn of_diagnosis(outcome: &DiagnosisOutcome) -> Vec<Rods> {
    let one = |(before, after): (&Trial, &Trial)| {
        let looks = [Stroke::dashed(VERMILION, 1.8, 8.0, 5.0), Stroke::new(BLUE, 2.0)];
        let rod = |((name, trial), look): ((&str, &Trial), Stroke)| {
            Rod::new(name, look, frames(&trial.model, &trial.run, duration(trial), 0.0))
        };
        let rods = [("before", before), ("after", after)].into_iter().zip(looks).filter_map(rod).collect();
        let curves = outcome.curves.iter().filter(|curve| curve.release == after.release.name);
        let markers = curves.map(|curve| {
            seen(&curve.marker, curve.seen().map(|sample| (sample.time, sample.measured)).collect())
        });
        let caption = "The model before and after over the markers as they were seen; the residuals below show the same instant.";
        of_release(after, caption, rods, markers.collect())
    };
    outcome.baseline.trials().zip(outcome.repaired.trials()).take(RELEASES).filter_map(one).collect()
}

/// The frames of a run until then, s.
pub(super) fn frames_until(model: &Model, trajectory: &Trajectory, end: f64) -> Vec<Frame> {
    let mut system = System::new(model);
    let count = trajectory.times.iter().take_while(|time| **time <= end).count();
    let frame = |sample: usize| {
        let state = trajectory.state(sample);
        let mut nodes = system.assembly.posture(&state.q, &state.v).nodes;
        nodes.push(trajectory.tip[sample]);
        (trajectory.times[sample], nodes)
    };
    (0..count).map(frame).collect()
}

/// A run as a case of a family; nothing of a run without samples.
pub fn rod_of_run(case: usize, name: &str, model: &Model, trajectory: &Trajectory) -> Option<Rod> {
    Rod::of_case(case, name, frames_until(model, trajectory, MOST_TIME))
}

/// The same of a case that is simulated for it.
pub fn rod_of_case(case: usize, name: &str, model: &Model, run: &Run) -> Option<Rod> {
    Rod::of_case(case, name, frames(model, run, run.duration.min(MOST_TIME), 0.0))
}

/// All rods of a family, of which one may be chosen; nothing without rods. The clamp is that of `model`.
pub fn of_family(model: &Model, rods: Vec<Rod>) -> Option<Rods> {
    (!rods.is_empty()).then(|| Rods {
        title: "The rods in motion".to_owned(),
        caption: "All cases at one time; the sliders choose among them, and charts over time show the same instant."
            .to_owned(),
        clock: SINCE_RELEASE,
        angle: base_angle(model),
        rest: None,
        rods,
        markers: Vec::new(),
    })
}

/// Frames between which all places can be interpolated.
fn thinned(frames: Vec<Frame>, most: f64) -> Vec<Frame> {
    let is_between = |from: usize, to: usize| {
        let (first, last) = (&frames[from], &frames[to]);
        frames[from + 1..to].iter().all(|(time, nodes)| {
            let share = (time - first.0) / (last.0 - first.0);
            nodes.iter().zip(&first.1).zip(&last.1).all(|((at, a), b)| {
                let off = |k: usize| at[k] - a[k] - share * (b[k] - a[k]);
                MILLI * off(0).hypot(off(1)) <= most
            })
        })
    };
    let mut kept = vec![0];
    while let Some(&from) = kept.last().filter(|from| **from + 1 < frames.len()) {
        let far = (from + SKIPPED).min(frames.len() - 1);
        let next = (from + 2..=far).take_while(|to| is_between(from, *to)).last();
        kept.push(next.unwrap_or(from + 1));
    }
    kept.into_iter().filter_map(|k| frames.get(k).cloned()).collect()
}

impl Rods {
    /// As the script reads it.
    pub fn json(&self) -> Value {
        let of_markers = self.markers.iter().flat_map(|marker| marker.seen.iter().map(|seen| &seen.1));
        let all = || {
            let rods = self.rods.iter().flat_map(Rod::places);
            rods.chain(of_markers.clone()).chain(self.rest.iter().flatten()).chain([&[0.0, 0.0]])
        };
        // Room for the clamp, and for what is drawn about a place.
        let range = |axis: usize| {
            let ends = |(low, high): (f64, f64), at: &[f64; 2]| (low.min(at[axis]), high.max(at[axis]));
            let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            [MILLI * low - 22.0, MILLI * high + 22.0].map(f64::round)
        };
        let marker = |own: &Marker| {
            let times: Vec<f64> = own.seen.iter().map(|seen| seen.0).collect();
            let axis = |k: usize| {
                let places: Vec<f64> = own.seen.iter().map(|seen| MILLI * seen.1[k]).collect();
                column_in(&places, UNIT)
            };
            json!({
                "name": own.name, "look": look(&own.stroke), "shape": "ring", "within": own.within,
                "times": column(&times), "x": axis(0), "z": axis(1)
            })
        };
        let rest = self.rest.as_ref().map(|rest| {
            let place = |at: &[f64; 2]| at.map(|at| (10.0 * MILLI * at).round() / 10.0);
            rest.iter().map(place).collect::<Vec<_>>()
        });
        json!({
            "title": self.title, "clock": self.clock, "angle": self.angle,
            "x": range(0), "z": range(1), "rest": rest,
            "rods": self.rods.iter().map(Rod::json).collect::<Vec<_>>(),
            "markers": self.markers.iter().filter(|own| !own.seen.is_empty()).map(marker).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame that a line between its neighbours gives is left out, and no other.
    #[test]
    fn frames_that_can_be_interpolated_are_left_out() {
        let frame = |time: f64, z: f64| (time, vec![[0.0, 0.0], [0.1, z]]);
        let straight: Vec<Frame> = (0..11).map(|k| frame(f64::from(k), 0.01 * f64::from(k))).collect();
        assert_eq!(thinned(straight, OFF).len(), 2);
        let kinked: Vec<Frame> =
            (0..11).map(|k| frame(f64::from(k), 0.01 * f64::from((k - 5i32).abs()))).collect();
        let times: Vec<f64> = thinned(kinked, OFF).iter().map(|frame| frame.0).collect();
        assert_eq!(times, [0.0, 5.0, 10.0]);
    }

    #[test]
    fn a_rod_keeps_its_root_its_end_and_its_tip() {
        let nodes: Vec<[f64; 2]> = (0..=80).map(|k| [f64::from(k), 0.0]).collect();
        let frames = vec![(0.0, nodes.clone()), (1.0, nodes)];
        let rod = Rod::new("a", Stroke::new(crate::picture::BLUE, 1.0), frames).unwrap();
        let kept: Vec<f64> = rod.frames[0].1.iter().map(|at| at[0]).collect();
        assert!(kept.len() <= NODES + 2 && kept[0] == 0.0 && kept.ends_with(&[79.0, 80.0]), "{kept:?}");
    }
}
