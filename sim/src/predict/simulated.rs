//! One run of a case, what it says, and what its mesh does to that.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use models::model::Model;

use super::quantity::{Told, numbers};
use crate::calibrate::problem::refine;
use crate::forward::{Initial, Run, forward};
use crate::results::rest::rest;
use crate::results::summary::{Cycle, MODES, summarise};
use crate::trajectory::Trajectory;

/// One run, and what it says.
pub(super) struct Simulated {
    /// In the order of `QUANTITIES`; none where the run has none.
    pub numbers: Vec<Option<f64>>,
    /// Why numbers are missing, by the entry of a summary.
    pub missing: BTreeMap<String, String>,
    /// Upper peak by upper peak.
    pub cycles: Vec<Cycle>,
    /// Height of the tip at each sample, m.
    pub height: Vec<f64>,
    /// Time of each, s.
    pub time: Vec<f64>,
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
    /// The rod at rest and at the lowest point of the tip, m.
    pub postures: Vec<(&'static str, Vec<[f64; 2]>)>,
}

/// Runs a model to its end.
/// # Errors
/// Why it cannot, in words.
pub(super) fn simulate(model: &Model, run: &Run) -> Result<Simulated, String> {
    let (mut root, mut lowest) = (0.0f64, (f64::INFINITY, Vec::new()));
    let trajectory: Trajectory = forward(model, run, &mut |sample| {
        let snapshot = sample.snapshot();
        root = root.max(snapshot.bending_moment.first().copied().unwrap_or(0.0).abs());
        if snapshot.tip[1] < lowest.0 {
            lowest = (snapshot.tip[1], [snapshot.nodes, vec![snapshot.tip]].concat());
        }
        ControlFlow::Continue(())
    })
    .map_err(|error| error.to_string())?;
    let at_rest = rest(model, run.duration, MODES);
    let (summary, _) = summarise(model, run, &trajectory, &at_rest);
    let at_rest = at_rest.map_err(|error| error.to_string())?;
    let [x, z] = at_rest.tip;
    let height = trajectory.tip_z();
    let told = Told {
        root_moment: root,
        root_moment_at_rest: at_rest.root_moment,
        lowest: between_samples(&height),
        summary: &summary,
    };
    Ok(Simulated {
        numbers: numbers(&told),
        excursion: trajectory.tip.iter().map(|tip| (tip[0] - x).hypot(tip[1] - z)).fold(0.0, f64::max),
        postures: vec![
            ("at rest", [at_rest.nodes.clone(), vec![at_rest.tip]].concat()),
            ("at its lowest", lowest.1),
        ],
        height,
        time: trajectory.times,
        cycles: summary.cycles.unwrap_or_default(),
        missing: summary.missing,
    })
}

/// The least of values at even steps, between them by the parabola through the least three.
fn between_samples(values: &[f64]) -> Option<f64> {
    let least = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    if least == 0 || least + 1 == values.len() {
        return Some(values[least]);
    }
    let [before, at, after] = [values[least - 1], values[least], values[least + 1]];
    let (slope, bend) = (0.5 * (after - before), after - 2.0 * at + before);
    Some(if bend > 0.0 { at - 0.5 * slope * slope / bend } else { at })
}

/// What the mesh does to what a run says: by Richardson from a run with edges of half the length, for an error of
/// second order. The numbers of a calibration whose mesh was removed belong to a rod without one.
pub(super) struct Mesh {
    numbers: Vec<f64>,
    cycles: Vec<[f64; 3]>,
    height: Vec<f64>,
}

/// An error of which halving the edges leaves a quarter, over the difference of the two.
const RICHARDSON: f64 = 4.0 / 3.0;

impl Mesh {
    /// That of a run; none where it starts from a posture, which has nodes of its own, or where the finer run
    /// cannot be made.
    pub fn of(own: &Simulated, model: &Model, run: &Run) -> Option<Self> {
        if matches!(run.initial, Initial::Posture(_)) {
            return None;
        }
        let (mut model, mut run) = (model.clone(), run.clone());
        refine(&mut model, &mut run.initial, 2).ok()?;
        let finer = simulate(&model, &run).ok()?;
        let off = |own: f64, finer: f64| RICHARDSON * (finer - own);
        let number = |(own, finer): (&Option<f64>, &Option<f64>)| match (own, finer) {
            (Some(own), Some(finer)) => off(*own, *finer),
            _ => 0.0,
        };
        let cycle = |(own, finer): (&Cycle, &Cycle)| {
            [
                off(own.amplitude_m, finer.amplitude_m),
                off(own.damping_ratio, finer.damping_ratio),
                off(own.damped_frequency_hz, finer.damped_frequency_hz),
            ]
        };
        Some(Self {
            numbers: own.numbers.iter().zip(&finer.numbers).map(number).collect(),
            cycles: own.cycles.iter().zip(&finer.cycles).map(cycle).collect(),
            height: own.height.iter().zip(&finer.height).map(|(own, finer)| off(*own, *finer)).collect(),
        })
    }

    /// Takes it off what a run on the same mesh says.
    pub fn removed(&self, simulated: &mut Simulated) {
        for (number, off) in simulated.numbers.iter_mut().zip(&self.numbers) {
            number.iter_mut().for_each(|number| *number += off);
        }
        for (cycle, [amplitude, ratio, frequency]) in simulated.cycles.iter_mut().zip(&self.cycles) {
            cycle.amplitude_m += amplitude;
            cycle.damping_ratio += ratio;
            cycle.damped_frequency_hz += frequency;
        }
        for (height, off) in simulated.height.iter_mut().zip(&self.height) {
            *height += off;
        }
    }
}

/// A parameter of a model, zero where it has none.
pub(super) fn value(model: &Model, path: &str) -> f64 {
    model.index(path).map_or(0.0, |k| model.theta[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_lies_between_samples() {
        let values: Vec<f64> = (0..10).map(|k| (f64::from(k) - 4.3).powi(2) - 1.0).collect();
        assert!((between_samples(&values).unwrap() + 1.0).abs() < 1e-12);
        assert_eq!(between_samples(&[1.0, 2.0]), Some(1.0));
        assert_eq!(between_samples(&[]), None);
    }
}
