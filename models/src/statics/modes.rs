//! Small free vibrations about a rest posture: `K φ = ω² M φ`.
//!
//! Inverse subspace iteration: a few shapes more than requested go through `K⁻¹ M` together and
//! are made orthonormal in `M`; of the small matrix that is left, the largest eigenvalues are
//! `1/ω²` of the slowest modes. Each pass costs a few back-substitutions, linear in the nodes.
//!
//! Memory answers at the mode's own frequency: part of it stiffens, part of it damps, so that a
//! model with memory is solved again at the frequency that it has found, until that stays.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::coupled::Coupled;
use crate::error::ModelError;
use crate::model::Model;
use crate::system::System;

use super::Equilibrium;

/// One small free vibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Undamped angular frequency, rad/s.
    pub angular_frequency: f64,
    /// Share of critical damping, `φᵀ D φ / (2 ω)`: what the shape sees of the damping, as if modes
    /// did not couple.
    pub damping_ratio: f64,
    /// Increments of the coordinates, shape `[2N+1]`, with `φᵀ M φ = 1`; the end body's centre of
    /// mass, or else its angle, moves in positive direction.
    pub shape: Vec<f64>,
    /// Share of its energy of deformation and weight that is stretch.
    pub stretch_share: f64,
}

/// Share of stretch in the energy of a mode from which on it is a vibration along the rod.
pub(super) const ALONG: f64 = 0.5;

/// The `count` slowest bending modes about a stable rest posture, ascending; all that there are, if the
/// model has fewer. Vibrations along the rod, whose energy is mostly stretch, are left out.
///
/// A slender rod without a load swings at `1.8751² √(EI / (m L³))` first:
///
/// ```
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
/// use models::statics::{equilibrium, modes};
///
/// let rod = Rod { length: 0.2, mass: 0.01, bending_stiffness: 5.0, axial_stiffness: 5e5, diameter: 0.01, pressure: 0.0 };
/// let model = Model::new(&ModelSpec::of(rod))?;
/// let slowest = modes(&model, &equilibrium(&model, None)?, 1)?;
/// let due = 1.8751f64.powi(2) * (5.0 / (0.01 * 0.2f64.powi(3))).sqrt();
/// assert!((slowest[0].angular_frequency / due - 1.0).abs() < 1e-3);
/// # Ok::<(), models::error::ModelError>(())
/// ```
/// # Errors
/// [`ModelError::Unstable`] about a posture that is not stable: a mode there grows instead of
/// swinging.
pub fn modes(model: &Model, at: &Equilibrium, count: usize) -> Result<Vec<Mode>, ModelError> {
    let mut along = 0;
    loop {
        let mut found = slowest(model, at, count + along)?;
        let is_last = found.len() < count + along;
        found.retain(|mode| mode.stretch_share < ALONG);
        if found.len() >= count || is_last {
            found.truncate(count);
            return Ok(found);
        }
        along += count - found.len();
    }
}

/// The `count` slowest modes, those along the rod included.
fn slowest(model: &Model, at: &Equilibrium, count: usize) -> Result<Vec<Mode>, ModelError> {
    let mut system = System::at_rest(model);
    let mut force = vec![0.0; model.dof()];
    let at_rest = vec![0.0; model.dof()];
    system.linearise(at.time, &at.q, &at_rest, &at.z, &mut force);
    system.condense(0.0);
    let mut shapes = Shapes::new(&system, &at.q, count);
    let relaxed = shapes.iterate(system.stiffness(), &system.mass)?;
    let mut modes = Vec::with_capacity(count);
    for (k, mut angular_frequency) in relaxed.into_iter().enumerate().take(count) {
        if model.memory() > 0 {
            angular_frequency = shapes.at_own_frequency(&mut system, k, angular_frequency)?;
        }
        let shape = shapes.columns[k].clone();
        let mut damped = vec![0.0; model.dof()];
        system.damping().multiply_add(shape.as_chunks::<1>().0, damped.as_chunks_mut().0);
        let damping_ratio = dot(&shape, &damped) / (2.0 * angular_frequency);
        modes.push(Mode { angular_frequency, damping_ratio, shape, stretch_share: 0.0 });
    }
    for mode in &mut modes {
        mode.stretch_share =
            system.stretch_energy(at.time, &at.q, &mode.shape) / mode.angular_frequency.powi(2);
    }
    Ok(modes)
}

/// Shapes beyond those requested: the iteration converges with `(ω_wanted / ω_beyond)²`.
const GUARDS: usize = 6;
const MOST_PASSES: usize = 200;

/// Shapes under iteration, orthonormal in the mass matrix.
struct Shapes {
    columns: Vec<Vec<f64>>,
    wanted: usize,
}

impl Shapes {
    /// Starts from turns of the edges that wave along the rod, and stretches that do.
    fn new(system: &System, q: &[f64], wanted: usize) -> Self {
        let c = &system.assembly.context;
        let f = &system.assembly.fields;
        let n = c.edges;
        let column = |k: usize| {
            let mut column = vec![0.0; q.len()];
            let mut at = [0.0; 2];
            for j in 0..n {
                let phase = std::f64::consts::PI * (k as f64) * (j as f64 + 0.5) / n as f64;
                let (turn, stretch) = (phase.cos(), 0.1 * (phase + 1.0).sin());
                let [x, z] = f.tangent[j];
                at[0] += stretch * x - turn * z;
                at[1] += stretch * z + turn * x;
                column[2 * j..2 * j + 2].copy_from_slice(&at);
            }
            column[2 * n] = (1.0 + 0.3 * (k * k) as f64).cos() / c.rest_length;
            column
        };
        let count = (wanted + GUARDS).min(q.len());
        Self { columns: (0..count).map(column).collect(), wanted: wanted.min(count) }
    }

    /// Iterates until the wanted frequencies stay; returns all, rad/s, ascending.
    fn iterate(&mut self, stiffness: &Coupled, mass: &[f64]) -> Result<Vec<f64>, ModelError> {
        let mut factors = stiffness.clone();
        if factors.factorize().is_err() || !factors.is_positive() {
            return Err(ModelError::Unstable);
        }
        self.orthonormalise(mass);
        let size = self.columns.len();
        let mut squares: Vec<f64> = vec![f64::INFINITY; size];
        for _ in 0..MOST_PASSES {
            let solved: Vec<Vec<f64>> = self
                .columns
                .iter()
                .map(|column| {
                    let mut x: Vec<f64> = column.iter().zip(mass).map(|(x, m)| x * m).collect();
                    factors.solve(&mut x);
                    x
                })
                .collect();
            let small = DMatrix::from_fn(size, size, |a, b| {
                0.5 * (weighted(&self.columns[a], &solved[b], mass)
                    + weighted(&self.columns[b], &solved[a], mass))
            });
            let eigen = SymmetricEigen::new(small);
            let mut order: Vec<usize> = (0..size).collect();
            order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
            for (column, &k) in self.columns.iter_mut().zip(&order) {
                column.fill(0.0);
                for (solved, share) in solved.iter().zip(eigen.eigenvectors.column(k).iter()) {
                    column.iter_mut().zip(solved).for_each(|(x, s)| *x += share * s);
                }
            }
            self.orthonormalise(mass);
            let found: Vec<f64> = order.iter().map(|&k| 1.0 / eigen.eigenvalues[k]).collect();
            let moved = (0..self.wanted).map(|k| (found[k] / squares[k] - 1.0).abs()).fold(0.0, f64::max);
            squares = found;
            if moved < 1e-13 {
                break;
            }
        }
        for column in &mut self.columns {
            let end = column.len() - 3;
            let leading = column[end..].iter().copied().find(|x| x.abs() > 1e-9).unwrap_or(1.0);
            column.iter_mut().for_each(|x| *x *= leading.signum());
        }
        Ok(squares.iter().map(|square| square.sqrt()).collect())
    }

    /// Solves mode `k` again with the memory's answer at its own frequency, rad/s.
    fn at_own_frequency(&mut self, system: &mut System, k: usize, start: f64) -> Result<f64, ModelError> {
        let mut omega = start;
        for _ in 0..50 {
            system.condense_at_frequency(omega);
            let found = self.iterate(system.stiffness(), &system.mass)?[k];
            let moved = (found / omega - 1.0).abs();
            omega = found;
            if moved < 1e-10 {
                break;
            }
        }
        Ok(omega)
    }

    /// Gram and Schmidt, twice, which is enough.
    fn orthonormalise(&mut self, mass: &[f64]) {
        for k in 0..self.columns.len() {
            let (before, rest) = self.columns.split_at_mut(k);
            let column = &mut rest[0];
            for _ in 0..2 {
                for other in &*before {
                    let share = weighted(other, column, mass);
                    column.iter_mut().zip(other).for_each(|(x, o)| *x -= share * o);
                }
                let per_norm = weighted(column, column, mass).sqrt().recip();
                column.iter_mut().for_each(|x| *x *= per_norm);
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn weighted(a: &[f64], b: &[f64], weight: &[f64]) -> f64 {
    a.iter().zip(b).zip(weight).map(|((a, b), w)| a * b * w).sum()
}
