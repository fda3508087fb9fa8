//! Where a run starts, and how that moves with the parameters.

use std::sync::Arc;

use models::effects::{LANES, Lanes};
use models::error::ModelError;
use models::history::History;
use models::model::Model;
use models::posture::Posture;
use models::statics::equilibrium;
use models::system::System;

use crate::integrate::State;
use crate::integrate::variational::{Slopes, Variational};

use super::history::memory_by_parameter;
use super::{ForwardError, Run, tip};

/// Where a run starts.
#[derive(Clone)]
pub enum Initial {
    /// Straight at the release angle, turning about the clamp at the release rate.
    Straight,
    /// At rest under other loads or another pressure.
    Equilibrium {
        /// The model that holds it: the same effects, other parameters.
        hold: Box<Model>,
        /// Parameters, as indices into `theta`, that the hold has of its own.
        own: Vec<usize>,
    },
    /// Along a curve from the clamp, which any mesh can follow.
    Curve(Arc<[CurvePoint]>),
    /// A posture of the model's own mesh, with velocities.
    Posture(Posture<f64>),
}

/// A point of a curve along which a rod starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// In W, m.
    pub position: [f64; 2],
    /// m/s.
    pub velocity: [f64; 2],
}

impl std::fmt::Debug for Initial {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Initial::Straight => "Straight",
            Initial::Equilibrium { .. } => "Equilibrium",
            Initial::Curve(_) => "Curve",
            Initial::Posture(_) => "Posture",
        })
    }
}

impl Initial {
    /// The same start on another mesh.
    /// # Errors
    /// [`ModelError::Nodes`].
    pub fn on_mesh(&self, nodes: usize) -> Result<Initial, ModelError> {
        Ok(match self {
            Initial::Straight => Initial::Straight,
            Initial::Equilibrium { hold, own } => {
                Initial::Equilibrium { hold: Box::new(hold.with_nodes(nodes)?), own: own.clone() }
            }
            Initial::Curve(curve) => Initial::Curve(curve.clone()),
            Initial::Posture(posture) => Initial::Posture(posture.resampled(nodes - 1)),
        })
    }
}

/// Where the observed tip starts, m.
/// # Errors
/// [`ForwardError::Model`] where the rod cannot be held as it should.
pub fn start_of_tip(model: &Model, run: &Run) -> Result<[f64; 2], ForwardError> {
    let mut system = System::new(model);
    let State { q, v, .. } = initial_state(&mut system, &run.initial, None)?;
    // The arm of the end body is that of the model, wherever it stands.
    Ok(tip(&system, &q, &v).0)
}

pub(super) fn initial_state(
    system: &mut System,
    initial: &Initial,
    history: Option<History>,
) -> Result<State, ModelError> {
    let model = system.model;
    let posture = match initial {
        Initial::Straight => system.assembly.straight_at_release(),
        Initial::Equilibrium { hold, .. } => {
            let rest = equilibrium(hold, None)?;
            let at_rest = vec![0.0; rest.q.len()];
            System::new(hold).assembly.posture(&rest.q, &at_rest)
        }
        Initial::Curve(points) => along(points, model.edges),
        Initial::Posture(posture) => posture.clone(),
    };
    let (q, v) = system.assembly.let_go(model, posture);
    let mut z = vec![0.0; model.memory()];
    match history {
        Some(history) if !z.is_empty() => z = system.remember(&history, &equilibrium(model, None)?.q, &q),
        _ => system.relax_memory(0.0, &q, &mut z),
    }
    Ok(State { time: 0.0, q, v, z })
}

/// The posture along a curve.
fn along(points: &[CurvePoint], edges: usize) -> Posture<f64> {
    let positions: Vec<_> = points.iter().map(|point| point.position).collect();
    let velocities: Vec<_> = points.iter().map(|point| point.velocity).collect();
    Posture::along(&positions, &velocities, edges)
}

/// Derivatives of the initial state by the watched parameters.
pub(super) fn initial_slopes<'m>(
    model: &'m Model,
    run: &Run,
    state: &State,
    order: &[usize],
) -> Result<Variational<'m>, ModelError> {
    let watched: Vec<_> = order.iter().map(|k| Some(*k)).collect();
    let mut system = System::new(model);
    system.watch(&watched);
    let groups = watched.len().div_ceil(LANES);
    let mut all = Vec::with_capacity(groups);
    for group in 0..groups {
        let posture = match &run.initial {
            Initial::Straight => system.straight_by_parameters(group),
            Initial::Equilibrium { hold, own } => {
                let shared: Vec<_> = watched.iter().map(|k| k.filter(|k| !own.contains(k))).collect();
                held_by_parameters(hold, &shared, group, state)
            }
            Initial::Curve(points) => along(points, model.edges).map(Into::into),
            Initial::Posture(posture) => posture.clone().map(Into::into),
        };
        let (q, v) = system.let_go_by_parameters(group, posture);
        let mut z = relaxed_memory_slopes(&mut system, group, state, &q);
        if run.history.is_some() && !z.is_empty() {
            for (lane, parameter) in order[group * LANES..].iter().take(LANES).enumerate() {
                let slopes = memory_by_parameter(model, run, *parameter)?;
                z.iter_mut().zip(slopes).for_each(|(z, slope)| z[lane] = slope);
            }
        }
        all.push(Slopes { q, v, z });
    }
    Ok(Variational::new(system, order, all))
}

/// The equilibrium of the hold with its derivatives, by the implicit function theorem.
fn held_by_parameters(hold: &Model, shared: &[Option<usize>], group: usize, state: &State) -> Posture<Lanes> {
    let mut system = System::new(hold);
    system.watch(shared);
    let rest = equilibrium(hold, None).expect("the run's initial state was found from it");
    let at_rest = vec![0.0; rest.q.len()];
    let mut force = vec![0.0; rest.q.len()];
    let mut by_theta = vec![[0.0; LANES]; rest.q.len()];
    let mut rate_by_theta = vec![[0.0; LANES]; state.z.len()];
    system.by_parameters(group, 0.0, &rest.q, &at_rest, &rest.z, &mut by_theta, &mut rate_by_theta);
    system.linearise(0.0, &rest.q, &at_rest, &rest.z, &mut force);
    system.condense(0.0);
    system.condense_residual(0.0, &rate_by_theta, &mut by_theta);
    let mut stiffness = system.stiffness().clone();
    if stiffness.factorize().is_ok() {
        stiffness.solve_many(&mut by_theta);
    }
    system.posture_by_parameters(group, &rest.q, &by_theta)
}

/// How the relaxed memory moves with the posture and the parameters.
fn relaxed_memory_slopes(
    system: &mut System,
    group: usize,
    state: &State,
    q: &[[f64; LANES]],
) -> Vec<[f64; LANES]> {
    let mut z = vec![[0.0; LANES]; state.z.len()];
    if z.is_empty() {
        return z;
    }
    let at_rest = vec![0.0; state.q.len()];
    let mut force = vec![0.0; state.q.len()];
    let mut by_theta = vec![[0.0; LANES]; state.q.len()];
    let still = vec![[0.0; LANES]; state.q.len()];
    system.by_parameters(group, 0.0, &state.q, &at_rest, &state.z, &mut by_theta, &mut z);
    system.linearise(0.0, &state.q, &at_rest, &state.z, &mut force);
    system.condense(0.0);
    system.recover_memory(0.0, q, &still, &mut z);
    z
}
