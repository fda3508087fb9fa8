//! Derivatives of a start that have no closed form: of the memory that a history leaves, and of the velocity in a hand
//! that moves.

use models::error::ModelError;
use models::model::Model;
use models::system::System;

use super::{Initial, Run, initial_state};
use crate::integrate::State;

/// Share of a parameter, or of its scale, by which it is moved for a difference of histories: rests are
/// found to some 1e-10, and the difference is of second order.
const MOVED: f64 = 1e-4;

/// Derivative of the state at the start by a parameter: the rest in which the rod hung, the posture of release and the
/// laws all move with it. By central differences, once a run.
pub(super) fn state_by_parameter(model: &Model, run: &Run, parameter: usize) -> Result<State, ModelError> {
    let step = MOVED * model.theta[parameter].abs().max(model.parameters[parameter].scale);
    let side = |step: f64| {
        let (mut model, mut initial) = (model.clone(), run.initial.clone());
        model.theta[parameter] += step;
        if let Initial::Equilibrium { hold, own } = &mut initial
            && !own.contains(&parameter)
        {
            hold.theta[parameter] += step;
        }
        initial_state(&mut System::new(&model), &initial, run.history)
    };
    let (plus, minus) = (side(step)?, side(-step)?);
    let slope = |plus: Vec<f64>, minus: Vec<f64>| {
        plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
    };
    Ok(State { time: 0.0, q: slope(plus.q, minus.q), v: slope(plus.v, minus.v), z: slope(plus.z, minus.z) })
}
