//! Rest postures: `f(q, v = 0, z) = 0`, with the memory of every effect relaxed.
//!
//! Newton's method in nodal positions needs hundreds of tiny steps, because a rotation along
//! straight lines stretches the edges. Here a step turns and stretches the edges instead, with the
//! matrix that belongs to such steps (see `path.rs`), which is Newton's method in edge angles and
//! stretches at the cost of one banded factorisation. Where that matrix is not positive definite it
//! is shifted by a multiple of the mass matrix, so that every step goes down; a search along the
//! path keeps it from overshooting. A posture where the imbalance vanishes but the stiffness is not
//! positive definite, such as a rod balanced upright, is left along its softest direction.

use crate::coupled::Coupled;
use crate::error::ModelError;
use crate::fault::{At, find};
use crate::model::{BASE_ANGLE, Model};
use crate::plane::{dot, left};
use crate::system::System;

use super::path::{Path, add_curve, worse};

/// A posture in which the model stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Coordinates, shape `[2N+1]`.
    pub q: Vec<f64>,
    /// Relaxed memory of the effects.
    pub z: Vec<f64>,
    /// Time at which loads and laws that change in time were taken, s.
    pub time: f64,
    /// Newton iterations, over all load steps.
    pub iterations: usize,
    /// Steps in which the load was put on; 1 where it could be put on at once.
    pub load_steps: usize,
    /// Largest imbalance that is left, N: of the force on a node, or of the moment on the end body
    /// over the length of the rod. Below 1e-10 of the loads, or where rounding of positions keeps
    /// it: of the order of `(EA/ℓ + EI/ℓ³) 1e-16 L`, with 2000 nodes some 1e-6 N.
    pub imbalance: f64,
    /// Whether the tangent stiffness is positive definite: pushed, the rod comes back.
    pub stable: bool,
}

/// The rest posture of a model at time 0, from the coordinates `start`, or else from the straight
/// rod in the direction of the clamp.
///
/// The load is put on at once. Where that fails, or leads from the straight rod through postures
/// that are not stable, from which many lead on, it is put on in steps from the straight rod, each
/// as small as a stable way to the next needs: the rod then comes to the posture into which a hand
/// would lower it, and does not wind up. A `start` may lead through unstable postures. Weight and
/// other loads of kind [`Load`](crate::effects::Kind::Load) that go with mass or act at the tip are
/// put on; all else acts in full from the first step. An unstable posture is left where there is a
/// way down.
///
/// A slender rod under a small load at its end sinks by `F L³ / (3 EI)`:
///
/// ```
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
/// use models::statics::equilibrium;
/// use models::system::System;
///
/// let rod = Rod { length: 0.2, mass: 1e-6, bending_stiffness: 5e-3, axial_stiffness: 5e4, diameter: 0.01, pressure: 0.0 };
/// let spec = ModelSpec::of(rod).with(&[("payload.mass", 1e-4), ("gravity.acceleration", 9.81)]);
/// let model = Model::new(&spec)?;
/// let rest = equilibrium(&model, None)?;
/// let (tip, _) = System::new(&model).observed_tip(&rest.q, &vec![0.0; rest.q.len()]);
/// let due = 1e-4 * 9.81 * 0.2f64.powi(3) / (3.0 * 5e-3);
/// assert!(rest.stable && (tip[1] / -due - 1.0).abs() < 0.01);
/// # Ok::<(), models::error::ModelError>(())
/// ```
/// # Errors
/// [`ModelError::Equilibrium`] where not even small steps of the load lead there.
/// # Panics
/// If `start` has not `2N+1` entries.
pub fn equilibrium(model: &Model, start: Option<&[f64]>) -> Result<Equilibrium, ModelError> {
    equilibrium_at(model, 0.0, start)
}

/// The same at another time, s: where loads and laws that change in time have come to, such as a hand that lets go.
/// # Errors
/// As [`equilibrium`].
/// # Panics
/// If `start` has not `2N+1` entries.
pub fn equilibrium_at(model: &Model, time: f64, start: Option<&[f64]>) -> Result<Equilibrium, ModelError> {
    let mut search = Search::new(model, time);
    // Its length is that of the pressure at this time.
    search.system.assembly.context.set_time(model, time, None);
    let straight = search.system.assembly.straight(model.theta[BASE_ANGLE], 0.0).0;
    let mut q = start.map_or_else(|| straight.clone(), <[f64]>::to_vec);
    assert_eq!(q.len(), model.dof(), "coordinates of another model");
    search.may_slip = start.is_some();
    if search.settle(&mut q) {
        return Ok(search.found(q, 1));
    }
    let (mut share, mut step, mut load_steps) = (0.0, 0.25, 0);
    q = straight;
    while share < 1.0 {
        let next = f64::min(share + step, 1.0);
        search.system.assembly.load_share = next;
        search.may_slip = step <= SMALLEST_LOAD_STEP;
        let mut trial = q.clone();
        if search.settle(&mut trial) {
            (share, q) = (next, trial);
            load_steps += 1;
            step *= 2.0;
        } else if step > SMALLEST_LOAD_STEP {
            step *= 0.5;
        } else {
            let (at_rest, unused) = (vec![0.0; q.len()], vec![0.0; search.z.len()]);
            let at = At { time, q: &q, v: &at_rest, z: &unused };
            return Err(find(model, at).map_or_else(|| search.stalled(share), ModelError::Law));
        }
    }
    Ok(search.found(q, load_steps))
}

/// Share of the load below which a step may lead through unstable postures: a true snap, or a fork.
const SMALLEST_LOAD_STEP: f64 = 1.0 / 512.0;
/// Newton iterations of one load step.
const MOST_ITERATIONS: usize = 100;
/// Imbalance over load at which a posture counts as found.
const TOLERANCE: f64 = 1e-10;
/// Largest turn (rad) or stretch of a step that may count as rounding, if it no longer halves the
/// imbalance.
const ROUNDING: f64 = 1e-8;
/// How often an unstable posture is left.
const MOST_PUSHES: usize = 3;
/// Turn with which it is left, rad.
const PUSH: f64 = 0.05;

/// Room to look for the rest posture of one model.
struct Search {
    system: System,
    z: Vec<f64>,
    z_rate: Vec<f64>,
    /// Time at which laws are taken, s.
    time: f64,
    at_rest: Vec<f64>,
    force: Vec<f64>,
    step: Vec<f64>,
    factors: Coupled,
    /// Multiple of the mass matrix that the last factors needed, 1/s².
    shift: f64,
    path: Path,
    iterations: usize,
    imbalance: f64,
    stable: bool,
    /// Whether the way may lead through unstable postures.
    may_slip: bool,
}

impl Search {
    fn new(model: &Model, time: f64) -> Self {
        let (dof, memory) = (model.dof(), model.memory());
        Self {
            system: System::at_rest(model),
            z: vec![0.0; memory],
            z_rate: vec![0.0; memory],
            time,
            at_rest: vec![0.0; dof],
            force: vec![0.0; dof],
            step: vec![0.0; dof],
            factors: Coupled::zeros(dof),
            shift: 0.0,
            path: Path::new(model.edges),
            iterations: 0,
            imbalance: 0.0,
            stable: false,
            may_slip: true,
        }
    }

    fn found(self, q: Vec<f64>, load_steps: usize) -> Equilibrium {
        let Self { z, time, iterations, imbalance, stable, .. } = self;
        Equilibrium { q, z, time, iterations, load_steps, imbalance, stable }
    }

    fn stalled(&self, share: f64) -> ModelError {
        let worst =
            (0..self.force.len()).max_by(|&a, &b| self.force[a].abs().total_cmp(&self.force[b].abs()));
        ModelError::Equilibrium {
            load_percent: 100.0 * share,
            iterations: self.iterations,
            imbalance: self.imbalance,
            node: worst.map_or(0, |dof| (dof / 2 + 1).min(self.system.model.edges)),
        }
    }

    /// Goes down from `q` until the imbalance vanishes; whether it does, and without slipping where
    /// it may not.
    fn settle(&mut self, q: &mut Vec<f64>) -> bool {
        let mut pushes = 0;
        let (mut last_size, mut last_imbalance) = (f64::INFINITY, f64::INFINITY);
        self.shift = 0.0;
        for _ in 0..MOST_ITERATIONS {
            self.iterations += 1;
            let load = self.evaluate(q);
            let at_rounding = last_size < ROUNDING && self.imbalance > 0.5 * last_imbalance;
            if self.imbalance <= TOLERANCE * load || at_rounding {
                self.factors.clone_from(self.system.stiffness());
                self.stable = self.factors.factorize().is_ok() && self.factors.is_positive();
                if self.stable || pushes == MOST_PUSHES {
                    return true;
                }
                if !self.may_slip {
                    return false;
                }
                if !self.push(q) {
                    return true;
                }
                pushes += 1;
                (last_size, last_imbalance) = (f64::INFINITY, f64::INFINITY);
                continue;
            }
            if !self.imbalance.is_finite() {
                self.imbalance = last_imbalance;
                return false;
            }
            if !self.factorize() {
                return false;
            }
            if self.shift > 0.0 && !self.may_slip {
                return false;
            }
            self.step.copy_from_slice(&self.force);
            self.factors.solve(&mut self.step);
            let share = self.path.leave(&self.system, q, &self.step);
            if !self.path.size.is_finite() {
                return false;
            }
            (last_size, last_imbalance) = (self.path.size, self.imbalance);
            self.search(share);
            std::mem::swap(q, &mut self.path.q);
        }
        false
    }

    /// Forces and tangent stiffness at `q`, with relaxed memory; returns the size of the loads, N.
    fn evaluate(&mut self, q: &[f64]) -> f64 {
        self.relaxed_force(q);
        let assembly = &self.system.assembly;
        let (c, f) = (&assembly.context, &assembly.fields);
        let mass = c.node_mass * (c.edges - 1) as f64 + c.body.mass;
        let length = c.rod.length;
        let load = mass * f.acceleration[0].hypot(f.acceleration[1])
            + f.tip[0].hypot(f.tip[1])
            + f.tip[2].abs() / length;
        let (moment, forces) = self.force.split_last().expect("a rod has coordinates");
        self.imbalance = forces.iter().fold((moment / length).abs(), |most, force| worse(most, force.abs()));
        let Self { system, time, at_rest, z, force, z_rate, .. } = self;
        system.linearise_into(*time, q, at_rest, z, force, z_rate);
        system.condense(0.0);
        load
    }

    /// Forces at `q`, with the memory as it is after a long rest there.
    fn relaxed_force(&mut self, q: &[f64]) {
        let Self { system, time, at_rest, z, force, z_rate, .. } = self;
        system.relax_memory(*time, q, z);
        system.force(*time, q, at_rest, z, force, z_rate);
    }

    /// Factors the matrix of paths with the smallest shift, of those tried, that makes it positive.
    fn factorize(&mut self) -> bool {
        let mut hessian = self.system.stiffness().clone();
        add_curve(&self.system, &self.force, &mut hessian.band);
        let smallest = self.smallest_shift();
        self.shift = if self.shift > 2.0 * smallest { 0.25 * self.shift } else { 0.0 };
        for _ in 0..60 {
            self.factors.clone_from(&hessian);
            self.factors.band.add_diagonal(self.shift, &self.system.mass);
            if self.factors.factorize().is_ok() && self.factors.is_positive() {
                return true;
            }
            self.shift = f64::max(4.0 * self.shift, smallest);
        }
        false
    }

    /// The square of an angular velocity below that of the slowest swing, 1/s².
    fn smallest_shift(&self) -> f64 {
        let c = &self.system.assembly.context;
        let (rod, mass) = (&c.rod, c.rod.mass + c.body.mass);
        1e-3 * (self.imbalance / rod.length + rod.bending_stiffness / rod.length.powi(3)) / mass + 1e-9
    }

    /// Goes along the path, at most to `share`, until the imbalance does not push back much: a
    /// search on the slope, which needs no energy and does not drown in its rounding. Beside the
    /// bounds of [`Path::leave`] it is seldom needed; either alone settles all but a few rods.
    fn search(&mut self, mut share: f64) {
        let slope_before: f64 = self.force.iter().zip(&self.step).map(|(f, step)| f * step).sum();
        for _ in 0..12 {
            self.path.follow(share);
            if self.path.size * share < 1e-6 {
                return;
            }
            let q = std::mem::take(&mut self.path.q);
            self.relaxed_force(&q);
            self.path.q = q;
            let slope: f64 = self.force.iter().zip(&self.path.rate).map(|(f, rate)| f * rate).sum();
            if slope >= -0.3 * slope_before {
                return;
            }
            let secant = slope_before / (slope_before - slope);
            share *= if secant.is_nan() { 0.25 } else { secant.clamp(0.1, 0.7) };
        }
    }

    /// Leaves an unstable posture along its softest direction; of the two ways, the one that takes
    /// the end body towards +x, or up. Whether there is a way.
    fn push(&mut self, q: &mut Vec<f64>) -> bool {
        if !self.factorize() {
            return false;
        }
        // Inverse iteration from a rigid turn about the clamp, in which every soft mode has a part.
        let n = self.system.model.edges;
        for (node, step) in q[..2 * n].chunks(2).zip(self.step.chunks_mut(2)) {
            step.copy_from_slice(&left([node[0], node[1]]));
        }
        self.step[2 * n] = 1.0;
        for _ in 0..20 {
            for (step, mass) in self.step.iter_mut().zip(&self.system.mass) {
                *step *= mass;
            }
            self.factors.solve(&mut self.step);
            let largest = self.step.iter().fold(0.0_f64, |most, step| worse(most, step.abs()));
            self.step.iter_mut().for_each(|step| *step /= largest);
        }
        self.path.leave(&self.system, q, &self.step);
        if !self.path.size.is_finite() || self.path.size == 0.0 {
            return false;
        }
        let end = [self.step[2 * n - 2], self.step[2 * n - 1]];
        let towards = dot(end, [1.0, 1e-3]);
        let share = f64::copysign(PUSH / self.path.size, towards);
        self.path.follow(share);
        std::mem::swap(q, &mut self.path.q);
        true
    }
}
