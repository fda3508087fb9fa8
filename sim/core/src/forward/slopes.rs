//! How the state in which a run starts moves with the parameters.

use models::effects::{LANES, Lanes};
use models::error::ModelError;
use models::model::Model;
use models::posture::Posture;
use models::statics::equilibrium;
use models::system::System;

use crate::initial::{Initial, along, rest_by_parameters};
use crate::integrate::State;
use crate::integrate::variational::{Slopes, Variational};
use crate::run::Run;

/// Derivatives of the initial state by the watched parameters.
pub(super) fn initial_slopes(
    model: &Model,
    run: &Run,
    state: &State,
    order: &[usize],
) -> Result<Variational, ModelError> {
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
                held_by_parameters(hold, &state.q, &shared, group)
            }
            Initial::Curve(points) => along(points, model.edges).map(Into::into),
            Initial::Posture(posture) => posture.clone().map(Into::into),
        };
        let (q, mut v) = system.let_go_by_parameters(group, posture);
        let mut z = relaxed_memory_slopes(&mut system, group, state, &q);
        let is_remembered = run.history.is_some() && !z.is_empty();
        for (lane, parameter) in order[group * LANES..].iter().take(LANES).enumerate() {
            // A hand that does not move leaves the rod at rest, whatever its force.
            let is_moved = run.initial.is_in_a_moving_hand(*parameter);
            if !is_remembered && !is_moved {
                continue;
            }
            let slopes = state_by_parameter(model, run, *parameter)?;
            if is_moved {
                v.iter_mut().zip(slopes.v).for_each(|(v, slope)| v[lane] = slope);
            }
            if is_remembered {
                z.iter_mut().zip(slopes.z).for_each(|(z, slope)| z[lane] = slope);
            }
        }
        all.push(Slopes { q, v, z });
    }
    Ok(Variational::new(system, all))
}

/// The equilibrium of the hold with its derivatives, from the state in which the rod was let go there.
fn held_by_parameters(hold: &Model, near: &[f64], shared: &[Option<usize>], group: usize) -> Posture<Lanes> {
    let mut system = System::new(hold);
    system.watch(shared);
    let rest = equilibrium(hold, Some(near)).expect("the run's initial state was found from it");
    let by_theta = rest_by_parameters(&mut system, &rest, group);
    system.posture_by_parameters(group, &rest.q, &by_theta)
}

/// How the relaxed memory that is felt moves with the posture and the parameters.
fn relaxed_memory_slopes(
    system: &mut System,
    group: usize,
    state: &State,
    q: &[[f64; LANES]],
) -> Vec<[f64; LANES]> {
    let mut z = vec![[0.0; LANES]; system.model.felt_memory()];
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

/// Share of a parameter, or of its scale, by which it is moved for a difference of histories: rests are
/// found to some 1e-10, and the difference is of second order.
const MOVED: f64 = 1e-4;

/// Derivative of the state at the start by a parameter, for what has no closed form: the memory that a history leaves, for
/// the rest in which the rod hung, the posture of release and the laws all move with it; and the velocity in a hand that
/// moves. By central differences, once a run.
fn state_by_parameter(model: &Model, run: &Run, parameter: usize) -> Result<State, ModelError> {
    let step = MOVED * model.theta[parameter].abs().max(model.parameters[parameter].scale);
    let side = |step: f64| {
        let (mut model, mut initial) = (model.clone(), run.initial.clone());
        model.theta[parameter] += step;
        if let Initial::Equilibrium { hold, own } = &mut initial
            && !own.contains(&parameter)
        {
            hold.theta[parameter] += step;
        }
        initial.state_of(&mut System::new(&model), run.history)
    };
    let (plus, minus) = (side(step)?, side(-step)?);
    let slope = |plus: Vec<f64>, minus: Vec<f64>| {
        plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
    };
    Ok(State { time: 0.0, q: slope(plus.q, minus.q), v: slope(plus.v, minus.v), z: slope(plus.z, minus.z) })
}
