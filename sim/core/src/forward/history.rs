//! Derivatives of the memory that a history leaves.

use models::error::ModelError;
use models::model::Model;
use models::system::System;

use super::{Initial, Run, initial_state};

/// Share of a parameter, or of its scale, by which it is moved for a difference of histories: rests are
/// found to some 1e-10, and the difference is of second order.
const MOVED: f64 = 1e-4;

/// Derivative of the memory at the start by a parameter, with a history: the rest in which the rod hung, the
/// posture of release and the laws all move with it. By central differences, once a run.
pub(super) fn memory_by_parameter(
    model: &Model,
    run: &Run,
    parameter: usize,
) -> Result<Vec<f64>, ModelError> {
    let step = MOVED * model.theta[parameter].abs().max(model.parameters[parameter].scale);
    let side = |step: f64| {
        let (mut model, mut initial) = (model.clone(), run.initial.clone());
        model.theta[parameter] += step;
        if let Initial::Equilibrium { hold, own } = &mut initial
            && !own.contains(&parameter)
        {
            hold.theta[parameter] += step;
        }
        initial_state(&mut System::new(&model), &initial, run.history).map(|state| state.z)
    };
    let (plus, minus) = (side(step)?, side(-step)?);
    Ok(plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect())
}
