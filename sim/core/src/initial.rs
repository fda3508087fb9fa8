//! Where a run starts.

use std::sync::Arc;

use models::effects::{LANES, tip_hold};
use models::error::ModelError;
use models::history::History;
use models::model::Model;
use models::posture::Posture;
use models::statics::{Equilibrium, equilibrium};
use models::system::System;

use crate::integrate::State;

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

impl Initial {
    /// Whether a hand holds the rod, and may move.
    pub fn is_in_a_hand(&self) -> bool {
        matches!(self, Initial::Equilibrium { hold, .. } if hold.effect(tip_hold::NAME).is_some())
    }

    /// Whether a hand moves the rod, or would with another value of a parameter: its rate.
    pub(crate) fn is_in_a_moving_hand(&self, parameter: usize) -> bool {
        let Initial::Equilibrium { hold, .. } = self else { return false };
        let [_, _, x, z, _, moment] = tip_hold::PULL;
        let mut rates = [x, z, moment].into_iter().filter_map(|path| hold.index(path).ok());
        rates.any(|rate| rate == parameter || hold.theta[rate] != 0.0)
    }

    /// The state in which a model starts; its memory is relaxed there.
    /// # Errors
    /// [`ModelError::Equilibrium`] where the rod cannot be held as it should.
    pub fn state(&self, model: &Model) -> Result<State, ModelError> {
        self.state_of(&mut System::new(model), None)
    }

    /// The same for equations that are set up, behind a history.
    pub(crate) fn state_of(
        &self,
        system: &mut System,
        history: Option<History>,
    ) -> Result<State, ModelError> {
        let posture = match self {
            Initial::Straight => system.assembly.straight_at_release(),
            Initial::Equilibrium { hold, .. } => {
                let rest = equilibrium(hold, None)?;
                let velocity = velocity_in_the_hand(hold, &rest)?;
                System::new(hold).assembly.posture(&rest.q, &velocity)
            }
            Initial::Curve(points) => along(points, system.model.edges),
            Initial::Posture(posture) => posture.clone(),
        };
        let (q, v) = system.assembly.let_go(&system.model, posture);
        let mut z = vec![0.0; system.model.memory()];
        match history {
            Some(history) if !z.is_empty() => {
                let hanging = equilibrium(&system.model, None)?;
                z = system.remember(&history, &hanging.q, &q);
            }
            _ => system.relax_memory(0.0, &q, &mut z),
        }
        Ok(State { time: 0.0, q, v, z })
    }
}

/// The posture along a curve.
pub(crate) fn along(points: &[CurvePoint], edges: usize) -> Posture<f64> {
    let positions: Vec<_> = points.iter().map(|point| point.position).collect();
    let velocities: Vec<_> = points.iter().map(|point| point.velocity).collect();
    Posture::along(&positions, &velocities, edges)
}

/// Velocity with which an equilibrium moves while the load of the hand changes, shape `[2N+1]`.
fn velocity_in_the_hand(hold: &Model, rest: &Equilibrium) -> Result<Vec<f64>, ModelError> {
    let mut velocity = vec![0.0; rest.q.len()];
    if hold.effect(tip_hold::NAME).is_none() {
        return Ok(velocity);
    }
    let [x, z, rate_x, rate_z, moment, rate_moment] = tip_hold::PULL;
    let loads = [hold.index(x)?, hold.index(z)?, hold.index(moment)?];
    let rates = [hold.index(rate_x)?, hold.index(rate_z)?, hold.index(rate_moment)?];
    if rates.iter().all(|k| hold.theta[*k] == 0.0) {
        return Ok(velocity);
    }
    let mut system = System::new(hold);
    system.watch(&loads.map(Some));
    for (velocity, by_load) in velocity.iter_mut().zip(rest_by_parameters(&mut system, rest, 0)) {
        *velocity = rates.iter().zip(by_load).map(|(k, slope)| hold.theta[*k] * slope).sum();
    }
    Ok(velocity)
}

/// Derivatives of a rest by the watched parameters, by the implicit function theorem.
pub(crate) fn rest_by_parameters(system: &mut System, rest: &Equilibrium, group: usize) -> Vec<[f64; LANES]> {
    let at_rest = vec![0.0; rest.q.len()];
    let mut force = vec![0.0; rest.q.len()];
    let mut by_theta = vec![[0.0; LANES]; rest.q.len()];
    let mut rate_by_theta = vec![[0.0; LANES]; rest.z.len()];
    system.by_parameters(group, 0.0, &rest.q, &at_rest, &rest.z, &mut by_theta, &mut rate_by_theta);
    system.linearise(0.0, &rest.q, &at_rest, &rest.z, &mut force);
    system.condense(0.0);
    system.condense_residual(0.0, &rate_by_theta, &mut by_theta);
    let mut stiffness = system.stiffness().clone();
    if stiffness.factorize().is_ok() {
        stiffness.solve_many(&mut by_theta);
    }
    by_theta
}
