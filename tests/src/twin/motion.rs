//! How a beam moves after it is let go: an implicit Runge-Kutta method of its own.
//!
//! Five stages of one diagonal, order four, L-stable; each stage is solved for its coordinates by
//! Newton's method. Steps are fixed, or follow from the embedded method of order three. It shares
//! nothing with the integrators of `sim`. Source: Hairer and Wanner (1996), Solving Ordinary
//! Differential Equations II, table 6.5 of section IV.6.

use super::band::Factors;
use super::beam::{Beam, Slopes};
use super::specimen::{Specimen, Stage};

const GAMMA: f64 = 0.25;
const BELOW: [[f64; 4]; 5] = [
    [0.0; 4],
    [0.5, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];
/// Weights of the stages less those of the embedded method.
const ERROR: [f64; 5] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 0.25];

/// A change of velocities below which a stage is solved, m/s; gradients have 1/s. Velocities, because
/// coordinates alone would let the noise of short steps grow as one over their length, and drive the
/// fast modes that made them short.
const SOLVED: f64 = 5e-7;
/// And what rounding leaves of coordinates, m.
const ROUNDING: f64 = 1e-14;
const MOST_ITERATIONS: usize = 40;
/// A change that is not below this share of the last one requires a tangent at the present stage.
const SLOW: f64 = 0.5;
/// And one that is not below this share of it is gone half way.
const TO_AND_FRO: f64 = 0.9;
/// Steps that adapt are no longer than this, s: between steps lies a cubic.
const LONGEST: f64 = 8e-3;
const SHORTEST: f64 = 1e-8;

/// A motion, kept at every step.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Time of each step after the release, s, the start first.
    pub times: Vec<f64>,
    /// Coordinates and velocities then.
    pub states: Vec<[Vec<f64>; 2]>,
}

/// Coordinates, velocities, accelerations, memories.
#[derive(Clone, Debug)]
struct State {
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    z: Vec<f64>,
}

/// A stage, with the rates of its memories.
type Solved = (State, Vec<f64>);

impl Motion {
    /// Lets `beam` go from the coordinates `start`, with steps of `step`, s.
    /// # Panics
    /// If a stage cannot be solved: take a smaller step.
    pub fn from_rest(beam: &Beam, start: Vec<f64>, duration: f64, step: f64) -> Self {
        let specimen = Specimen::plain(beam);
        let still = vec![0.0; beam.dof()];
        let mut state = State { time: 0.0, q: start, v: still.clone(), a: still, z: Vec::new() };
        let mut motion = Self { times: vec![0.0], states: vec![[state.q.clone(), state.v.clone()]] };
        for _ in 0..(duration / step).round() as usize {
            let stages = advance(&specimen, &state, step);
            let mut stages = stages.unwrap_or_else(|| panic!("a step of {step} s is too long"));
            // The last stage is the end of the step.
            state = stages.swap_remove(4).0;
            motion.keep(&state);
        }
        motion
    }

    /// Lets a specimen go, straight at an angle from the clamp's, rad. A step's error of the embedded
    /// method is kept below `tolerance`, m.
    /// # Panics
    /// If steps become too short for the clock.
    pub fn let_go(specimen: &Specimen, angle: f64, duration: f64, tolerance: f64) -> Self {
        let [q, v, z] = specimen.let_go(angle);
        let a = vec![0.0; q.len()];
        let mut state = State { time: 0.0, q, v, a, z };
        let mut motion = Self { times: vec![0.0], states: vec![[state.q.clone(), state.v.clone()]] };
        let weights = weights(specimen);
        let mut step: f64 = 1e-4;
        while state.time < duration {
            assert!(step > SHORTEST, "no step at {} s is short enough", state.time);
            let Some(mut stages) = advance(specimen, &state, step) else {
                step *= 0.3;
                continue;
            };
            let error = error(&stages, &weights) * step / tolerance;
            if error <= 1.0 {
                state = stages.swap_remove(4).0;
                motion.keep(&state);
            }
            step = (step * (0.8 * error.powf(-0.25)).clamp(0.2, 2.0)).min(LONGEST);
        }
        motion
    }

    fn keep(&mut self, state: &State) {
        self.times.push(state.time);
        self.states.push([state.q.clone(), state.v.clone()]);
    }

    /// Time of the last step, s.
    pub fn duration(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Coordinates at a time from 0 to the last step: the cubic through two steps and their
    /// velocities.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let k = self.times.partition_point(|t| *t <= time).clamp(1, self.times.len() - 1) - 1;
        let h = self.times[k + 1] - self.times[k];
        let s = ((time - self.times[k]) / h).clamp(0.0, 1.0);
        let ([q0, v0], [q1, v1]) = (&self.states[k], &self.states[k + 1]);
        let (rise, out, into) = (s * s * (3.0 - 2.0 * s), h * s * (1.0 - s).powi(2), h * s * s * (s - 1.0));
        (0..q0.len()).map(|i| q0[i] + rise * (q1[i] - q0[i]) + out * v0[i] + into * v1[i]).collect()
    }

    /// Path of the point `share`, see [`Beam::axis`], at these times.
    pub fn path(&self, beam: &Beam, share: f64, times: &[f64]) -> Vec<[f64; 2]> {
        times.iter().map(|t| beam.axis(&self.at(*t), share)[0]).collect()
    }
}

/// Displacement, m, that a unit of each coordinate and memory represents.
fn weights(specimen: &Specimen) -> [Vec<f64>; 2] {
    let length = specimen.beam.element_length();
    let coordinates = [1.0, 1.0, length, length].into_iter().cycle().take(specimen.beam.dof());
    [coordinates.collect(), specimen.weight_of_memory()]
}

/// Largest error of a step per its length, m/s.
fn error(stages: &[Solved], [of_q, of_z]: &[Vec<f64>; 2]) -> f64 {
    let largest = |weights: &[f64], rate: &dyn Fn(&Solved, usize) -> f64| {
        let error = |i: usize| -> f64 { stages.iter().zip(ERROR).map(|(stage, d)| d * rate(stage, i)).sum() };
        weights.iter().enumerate().map(|(i, weight)| (weight * error(i)).abs()).fold(0.0, f64::max)
    };
    largest(of_q, &|(stage, _), i| stage.v[i]).max(largest(of_z, &|(_, rates), i| rates[i]))
}

/// The stages of a step, if they can be solved.
fn advance(specimen: &Specimen, start: &State, step: f64) -> Option<Vec<Solved>> {
    let reach = GAMMA * step;
    let first = Stage { time: start.time + reach, reach, memory: &start.z };
    let mut factors = renewed(specimen, &first, start);
    let mut stages: Vec<Solved> = Vec::with_capacity(5);
    for row in &BELOW {
        let known = |x: &[f64], rate: &dyn Fn(&Solved, usize) -> f64| -> Vec<f64> {
            let so_far =
                |i: usize| -> f64 { stages.iter().zip(row).map(|(stage, a)| a * rate(stage, i)).sum() };
            x.iter().enumerate().map(|(i, x)| x + step * so_far(i)).collect()
        };
        let q = known(&start.q, &|(stage, _), i| stage.v[i]);
        let v = known(&start.v, &|(stage, _), i| stage.a[i]);
        let z = known(&start.z, &|(_, rates), i| rates[i]);
        let time = start.time + step * (GAMMA + row.iter().sum::<f64>());
        let stage = Stage { time, reach, memory: &z };
        let guess = stages.last().map_or(&start.a, |(stage, _)| &stage.a);
        stages.push(solve(specimen, &stage, &mut factors, [q, v], guess)?);
    }
    Some(stages)
}

fn renewed(specimen: &Specimen, stage: &Stage, at: &State) -> Factors {
    let slope = stage.reach.recip();
    let slopes = Slopes { velocity: slope, acceleration: slope * slope };
    specimen.tangent(stage, &at.q, &at.v, &at.a, slopes).factorize()
}

/// The stage whose coordinates and velocities are `known` but for its own rates' share.
fn solve(
    specimen: &Specimen,
    stage: &Stage,
    factors: &mut Factors,
    known: [Vec<f64>; 2],
    guess: &[f64],
) -> Option<Solved> {
    let [q_known, v_known] = &known;
    let (reach, slope) = (stage.reach, stage.reach.recip());
    let rate = |x: &[f64], known: &[f64]| -> Vec<f64> {
        x.iter().zip(known).map(|(x, k)| slope * (x - k)).collect()
    };
    let begin = |i: usize| q_known[i] + (v_known[i] + guess[i] * reach) * reach;
    let mut q: Vec<f64> = (0..guess.len()).map(begin).collect();
    let solved = (SOLVED * reach).max(ROUNDING);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        let v = rate(&q, q_known);
        let a = rate(&v, v_known);
        if last < solved {
            let z = specimen.memory(stage, &q, &v);
            let rates = rate(&z, stage.memory);
            return Some((State { time: stage.time, q, v, a, z }, rates));
        }
        let mut change = specimen.imbalance(stage, &q, &v, &a);
        factors.solve(&mut change);
        // Checked for each: the largest of some numbers does not show one that is none.
        if !change.iter().all(|change| change.is_finite()) {
            return None;
        }
        let largest = change.iter().map(|change| change.abs()).fold(0.0, f64::max);
        // Newton's method may go to and fro between friction one way and the other, and never reach
        // the steep slope between: half of the way does.
        let share = if largest > TO_AND_FRO * last { 0.5 } else { 1.0 };
        q.iter_mut().zip(&change).for_each(|(q, change)| *q -= share * change);
        if largest > solved && largest > SLOW * last {
            let v = rate(&q, q_known);
            let a = rate(&v, v_known);
            *factors =
                renewed(specimen, stage, &State { time: stage.time, q: q.clone(), v, a, z: Vec::new() });
        }
        last = largest;
    }
    None
}
