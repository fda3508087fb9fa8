//! How the beam moves from a posture at rest: an implicit Runge-Kutta method of its own.
//!
//! Five stages of one diagonal, order four, L-stable, of fixed step; each stage is solved for its
//! coordinates by Newton's method with the tangent of the step's beginning. It shares nothing with
//! the integrators of `sim`. Source: Hairer and Wanner (1996), Solving Ordinary Differential
//! Equations II, table 6.5 of section IV.6.

use super::band::{Band, Factors};
use super::beam::{Beam, Slopes};

const GAMMA: f64 = 0.25;
const BELOW: [[f64; 4]; 5] = [
    [0.0; 4],
    [0.5, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];

/// A change of the coordinates below which a stage is solved, m; gradients have no unit.
const SOLVED: f64 = 1e-10;
const MOST_ITERATIONS: usize = 50;

/// A motion from rest, kept at every step.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Size of the steps, s.
    pub step: f64,
    /// Coordinates and velocities after each step, the start first.
    pub states: Vec<[Vec<f64>; 2]>,
}

/// Coordinates, velocities and accelerations of a stage.
type Stage = [Vec<f64>; 3];

impl Motion {
    /// Lets `beam` go from the coordinates `start`.
    /// # Panics
    /// If a stage cannot be solved: take a smaller step.
    pub fn from_rest(beam: &Beam, start: Vec<f64>, duration: f64, step: f64) -> Self {
        let mass = beam.mass_matrix();
        let still = vec![0.0; beam.dof()];
        let mut states = vec![[start, still.clone()]];
        let slope = 1.0 / (GAMMA * step);
        let slopes = Slopes { velocity: slope, acceleration: slope * slope };
        let mut acceleration = still;
        for k in 0..(duration / step).round() as usize {
            let [q, v] = &states[k];
            let factors = beam.tangent(&mass, q, v, &acceleration, slopes).factorize();
            let mut stages: Vec<Stage> = Vec::with_capacity(5);
            for row in &BELOW {
                let known = |start: &[f64], rate: usize| -> Vec<f64> {
                    let so_far =
                        |i: usize| -> f64 { stages.iter().zip(row).map(|(s, a)| a * s[rate][i]).sum() };
                    start.iter().enumerate().map(|(i, x)| x + step * so_far(i)).collect()
                };
                let known = [known(q, 1), known(v, 2)];
                let guess = stages.last().map_or(&acceleration, |stage| &stage[2]);
                let stage = solve(beam, &mass, &factors, slope, known, guess);
                stages.push(stage.unwrap_or_else(|| panic!("a step of {step} s is too long")));
            }
            // The last stage is the end of the step.
            let [q, v, a] = stages.swap_remove(4);
            acceleration = a;
            states.push([q, v]);
        }
        Self { step, states }
    }

    /// Time of the last step, s.
    pub fn duration(&self) -> f64 {
        self.step * (self.states.len() - 1) as f64
    }

    /// Coordinates at a time from 0 to the last step: the cubic through two steps and their
    /// velocities.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let place = (time / self.step).clamp(0.0, (self.states.len() - 1) as f64);
        let k = (place as usize).min(self.states.len() - 2);
        let (s, h) = (place - k as f64, self.step);
        let ([q0, v0], [q1, v1]) = (&self.states[k], &self.states[k + 1]);
        let (rise, out, into) = (s * s * (3.0 - 2.0 * s), h * s * (1.0 - s).powi(2), h * s * s * (s - 1.0));
        (0..q0.len()).map(|i| q0[i] + rise * (q1[i] - q0[i]) + out * v0[i] + into * v1[i]).collect()
    }

    /// Path of the point `share`, see [`Beam::axis`], at these times.
    pub fn path(&self, beam: &Beam, share: f64, times: &[f64]) -> Vec<[f64; 2]> {
        times.iter().map(|t| beam.axis(&self.at(*t), share)[0]).collect()
    }
}

/// The stage whose coordinates and velocities are `known` but for its own acceleration's share.
fn solve(
    beam: &Beam,
    mass: &Band,
    factors: &Factors,
    slope: f64,
    known: [Vec<f64>; 2],
    guess: &[f64],
) -> Option<Stage> {
    let [q_known, v_known] = &known;
    let rate = |x: &[f64], known: &[f64]| -> Vec<f64> {
        x.iter().zip(known).map(|(x, k)| slope * (x - k)).collect()
    };
    let begin = |i: usize| q_known[i] + (v_known[i] + guess[i] / slope) / slope;
    let mut q: Vec<f64> = (0..guess.len()).map(begin).collect();
    let mut is_solved = false;
    for _ in 0..MOST_ITERATIONS {
        let v = rate(&q, q_known);
        let a = rate(&v, v_known);
        if is_solved {
            return Some([q, v, a]);
        }
        let mut change = beam.imbalance(mass, &q, &v, &a);
        factors.solve(&mut change);
        q.iter_mut().zip(&change).for_each(|(q, change)| *q -= change);
        is_solved = change.iter().all(|change| change.abs() < SOLVED);
    }
    None
}
