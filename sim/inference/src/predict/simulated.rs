//! One run of a case, what it says, and what its mesh does to that.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use efam_core::accuracy::order;
use efam_core::forward::{ForwardError, Job, Run, Sample, forward, forward_many};
use efam_core::integrate::Effort;
use efam_core::rest::rest;
use efam_core::trajectory::Trajectory;
use efam_experiments::summary::{Cycle, EnergyBalance, MODES, summarise};
use models::model::Model;

use super::quantity::{PredictedKind, QUANTITIES, Quantity, Told, numbers};
use crate::calibrate::problem::refine;

/// One run, and what it says.
pub struct Simulated {
    /// In the order of `QUANTITIES`; none where the run has none.
    pub numbers: Vec<Option<f64>>,
    /// Why numbers are missing, by the entry of a summary.
    pub missing: BTreeMap<String, String>,
    /// How well the energy adds up; none where the run did not follow it.
    pub energy: Option<EnergyBalance>,
    /// Effort of the run.
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

impl Simulated {
    /// All numbers, each with its interval.
    pub fn quantities(&self, interval: impl Fn(usize, f64) -> Option<[f64; 2]>) -> Vec<Quantity> {
        let quantity = |(k, kind): (usize, &PredictedKind)| {
            let value = self.numbers[k];
            Quantity {
                name: kind.name.to_owned(),
                meaning: kind.meaning.to_owned(),
                unit: kind.unit.to_owned(),
                value,
                interval_95: value.and_then(|value| interval(k, value)),
                missing: self.missing.get(kind.entry).filter(|_| value.is_none()).cloned(),
            }
        };
        QUANTITIES.iter().enumerate().map(quantity).collect()
    }
}

/// What a run shows during the motion.
struct Shown {
    /// Largest bending moment at the root, N m.
    root: f64,
    /// Height of the tip where it is lowest, m, and the nodes with the tip there.
    lowest: (f64, Vec<[f64; 2]>),
}

impl Shown {
    fn nothing() -> Self {
        Self { root: 0.0, lowest: (f64::INFINITY, Vec::new()) }
    }

    fn see(&mut self, sample: &mut Sample) {
        self.root = self.root.max(sample.root_moment().abs());
        let (at, _) = sample.system.observed_tip(&sample.state.q, &sample.state.v);
        if at[1] < self.lowest.0 {
            self.lowest = (at[1], [&sample.system.assembly.fields.position[..], &[at]].concat());
        }
    }
}

/// Runs a model to its end.
/// # Errors
/// Why it cannot, in words.
pub fn simulate(model: &Model, run: &Run) -> Result<Simulated, String> {
    let mut shown = Shown::nothing();
    let trajectory = forward(model, run, &mut |sample| {
        shown.see(sample);
        ControlFlow::Continue(())
    });
    told(model, run, trajectory, shown)
}

/// Runs models to their ends on one thread, those that are alike [side by side](forward_many).
pub(super) fn simulate_many(models: &[Model], run: &Run) -> Vec<Result<Simulated, String>> {
    let jobs: Vec<Job> = models.iter().map(|model| Job { model, run }).collect();
    let mut shown: Vec<_> = models.iter().map(|_| Shown::nothing()).collect();
    let mut all: Vec<_> = models.iter().map(|_| None).collect();
    let mut ended = Vec::with_capacity(models.len());
    let see = &mut |place: usize, sample: &mut Sample| {
        shown[place].see(sample);
        ControlFlow::Continue(())
    };
    forward_many(&jobs, see, &mut |place, trajectory| ended.push((place, trajectory)));
    for (place, trajectory) in ended {
        let shown = std::mem::replace(&mut shown[place], Shown::nothing());
        all[place] = Some(told(&models[place], run, trajectory, shown));
    }
    all.into_iter().map(|one| one.expect("the run of each job is done")).collect()
}

/// What a run says.
fn told(
    model: &Model,
    run: &Run,
    trajectory: Result<Trajectory, ForwardError>,
    Shown { root, lowest }: Shown,
) -> Result<Simulated, String> {
    let trajectory = trajectory.map_err(|error| error.to_string())?;
    let at_rest = rest(model, run.duration, MODES);
    let (summary, _) = summarise(model, run, &trajectory, &at_rest);
    let at_rest = at_rest.map_err(|error| error.to_string())?;
    let [x, z] = at_rest.tip;
    let height = trajectory.tip_z();
    let told = Told {
        root_moment: root,
        root_moment_at_rest: at_rest.root_moment,
        lowest: trajectory.trace.lowest().map(|low| low.tip[1]),
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

/// What the mesh does to what a run says: by Richardson from runs with edges of half and of a quarter of the length,
/// for an error of the scheme's order. The
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
        let finer = |factor: usize| {
            let (mut model, mut run) = (model.clone(), run.clone());
            refine(&mut model, &mut run.initial, factor).ok()?;
            simulate(&model, &run).ok()
        };
        let (half, quarter) = rayon::join(|| finer(2), || finer(4));
        let (half, quarter) = (half?, quarter?);
        let rest_of_mesh = 2f64.powf(order(model)) - 1.0;
        let off = |own: f64, half: f64, quarter: f64| quarter - own + (quarter - half) / rest_of_mesh;
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
