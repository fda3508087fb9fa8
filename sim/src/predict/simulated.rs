//! One run of a case, what it says, and what its mesh does to that.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use models::model::Model;

use super::quantity::{Told, numbers};
use crate::calibrate::problem::refine;
use crate::forward::{Initial, Run, forward, tip};
use crate::integrate::Effort;
use crate::results::rest::rest;
use crate::results::summary::{Cycle, EnergyBalance, MODES, summarise};
use crate::trajectory::Trajectory;

/// One run, and what it says.
pub(crate) struct Simulated {
    /// In the order of `QUANTITIES`; none where the run has none.
    pub numbers: Vec<Option<f64>>,
    /// Why numbers are missing, by the entry of a summary.
    pub missing: BTreeMap<String, String>,
    /// How well the energy adds up; none where the run did not follow it.
    pub energy: Option<EnergyBalance>,
    /// What the run cost.
    pub effort: Effort,
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
pub(crate) fn simulate(model: &Model, run: &Run) -> Result<Simulated, String> {
    let (mut root, mut lowest) = (0.0f64, (f64::INFINITY, Vec::new()));
    let trajectory: Trajectory = forward(model, run, &mut |sample| {
        root = root.max(sample.root_moment().abs());
        let (at, _) = tip(sample.system, &sample.state.q, &sample.state.v);
        if at[1] < lowest.0 {
            lowest = (at[1], [&sample.system.assembly.fields.position[..], &[at]].concat());
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
        lowest: between_samples(&trajectory),
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
        energy: summary.energy,
        effort: summary.effort,
    })
}

/// The lowest height of the tip, m, between samples by the cubic through two of them and their velocities: a tip that
/// whips turns round within a few hundredths of a second.
fn between_samples(trajectory: &Trajectory) -> Option<f64> {
    let at = |k: usize| (trajectory.tip[k][1], trajectory.tip_velocity[k][1]);
    let least = (0..trajectory.tip.len()).min_by(|a, b| at(*a).0.total_cmp(&at(*b).0))?;
    let neighbours = [least.checked_sub(1).map(|before| (before, least)), Some((least, least + 1))];
    let between = neighbours.into_iter().flatten().filter(|(_, after)| *after < trajectory.tip.len());
    let lows = between.map(|(before, after)| {
        cubic_least(trajectory.times[after] - trajectory.times[before], at(before), at(after))
    });
    Some(lows.fold(at(least).0, f64::min))
}

/// The least value of the cubic over a step with these values and slopes at its ends.
fn cubic_least(step: f64, (z, slope): (f64, f64), (next, next_slope): (f64, f64)) -> f64 {
    let (begin, end, rise) = (step * slope, step * next_slope, next - z);
    let (square, cube) = (3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise);
    // Where z' = begin + 2 square s + 3 cube s² turns from falling to rising.
    let root = (square * square - 3.0 * cube * begin).max(0.0).sqrt();
    let turn = if square + root == 0.0 { 0.0 } else { -begin / (square + root) };
    let s = turn.clamp(0.0, 1.0);
    (z + s * (begin + s * (square + s * cube))).min(z).min(next)
}

/// What the mesh does to what a run says: by Richardson from runs with edges of half and of a quarter of the length,
/// for an error of second order. From half alone a fifth of it was left of the lowest point of a tip that whips. The
/// numbers of a calibration whose mesh was removed belong to a rod without one.
pub(super) struct Mesh {
    numbers: Vec<f64>,
    cycles: Vec<[f64; 3]>,
    height: Vec<f64>,
}

impl Mesh {
    /// That of a run; none where it starts from a posture, which has nodes of its own, or where a finer run
    /// cannot be made.
    pub fn of(own: &Simulated, model: &Model, run: &Run) -> Option<Self> {
        if matches!(run.initial, Initial::Posture(_)) {
            return None;
        }
        let finer = |factor: usize| {
            let (mut model, mut run) = (model.clone(), run.clone());
            refine(&mut model, &mut run.initial, factor).ok()?;
            simulate(&model, &run).ok()
        };
        let (half, quarter) = rayon::join(|| finer(2), || finer(4));
        let (half, quarter) = (half?, quarter?);
        let off = |own: f64, half: f64, quarter: f64| quarter - own + (quarter - half) / 3.0;
        let number = |k: usize| match [own.numbers[k], half.numbers[k], quarter.numbers[k]] {
            [Some(own), Some(half), Some(quarter)] => off(own, half, quarter),
            _ => 0.0,
        };
        let count = own.cycles.len().min(half.cycles.len()).min(quarter.cycles.len());
        let cycle = |k: usize| {
            let of = |what: fn(&Cycle) -> f64| {
                off(what(&own.cycles[k]), what(&half.cycles[k]), what(&quarter.cycles[k]))
            };
            [
                of(|cycle| cycle.amplitude_m),
                of(|cycle| cycle.damping_ratio),
                of(|cycle| cycle.damped_frequency_hz),
            ]
        };
        Some(Self {
            numbers: (0..own.numbers.len()).map(number).collect(),
            cycles: (0..count).map(cycle).collect(),
            height: (0..own.height.len())
                .map(|k| off(own.height[k], half.height[k], quarter.height[k]))
                .collect(),
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

    /// A parabola is a cubic; a cosine is one up to a fourth power of the step.
    #[test]
    fn the_least_lies_between_samples() {
        let of = |z: fn(f64) -> (f64, f64), step: f64, count: usize| {
            let mut trajectory = Trajectory::default();
            for k in 0..count {
                let t = step * k as f64;
                let (height, rate) = z(t);
                trajectory.times.push(t);
                trajectory.tip.push([0.0, height]);
                trajectory.tip_velocity.push([0.0, rate]);
            }
            between_samples(&trajectory)
        };
        let parabola = |t: f64| ((t - 4.3).powi(2) - 1.0, 2.0 * (t - 4.3));
        assert!((of(parabola, 1.0, 10).unwrap() + 1.0).abs() < 1e-12);
        let cosine = |t: f64| (t.cos(), -t.sin());
        assert!((of(cosine, 0.3, 20).unwrap() + 1.0).abs() < 0.3f64.powi(4) / 384.0);
        let line = |t: f64| (t, 1.0);
        assert_eq!((of(line, 1.0, 2), of(line, 1.0, 0)), (Some(0.0), None));
    }
}
