//! A smallest stiffness damping β, which damps fast waves along the rod.
//!
//! With β of zero an integrator follows every wave. It takes many more steps, and the swing is the same.

use std::sync::Arc;

use models::quantity::format_si;
use models::statics::{equilibrium, modes};

use super::problem::{Problem, Trial};

/// The loss by the rate of bending.
pub(crate) const BETA: &str = "effects.rayleigh_stiffness.beta";

/// Least damping ratio of the second mode by stiffness damping: a steel cantilever in its clamp has as much.
const LEAST_DAMPING: f64 = 1e-3;

/// Smallest β that damps the waves of all releases, s: `ζ = β ω / 2`. None where a rod has no rest.
fn least(problem: &Problem) -> Option<f64> {
    let slowest = problem.trials().filter_map(second_mode).reduce(f64::min);
    slowest.map(|slowest| 2.0 * LEAST_DAMPING / slowest)
}

/// Angular frequency of the second mode about the rest, rad/s.
fn second_mode(trial: &Trial) -> Option<f64> {
    let rest = equilibrium(&trial.model, None).ok()?;
    Some(modes(&trial.model, &rest, 2).ok()?.get(1)?.angular_frequency)
}

/// Keeps β from leaving waves undamped: a β that is fitted by its bound, unless the experiment gives one, any other by its
/// value.
pub fn damp_waves(problem: &mut Problem) {
    let is_bounded = problem.parameters.iter().any(|own| own.path == BETA && own.bounds.is_some());
    let Some(least) = Some(&*problem).filter(|_| !is_bounded).and_then(least) else { return };
    if let Some(own) = problem.parameters.iter_mut().find(|own| own.path == BETA) {
        let known = problem
            .trials
            .first()
            .and_then(|trial| trial.model.parameters.iter().find(|known| known.path == BETA));
        own.bounds = known.map(|known| (least, known.range.1));
        return;
    }
    for trial in &mut problem.trials {
        if let Some(k) = trial.model.index(BETA).ok().filter(|k| trial.model.theta[*k] < least) {
            let (model, initial) = trial.with(&[(k, least)]);
            let trial = Arc::make_mut(trial);
            (trial.model, trial.run.initial) = (model, initial);
        }
    }
}

/// The warning of a problem in which β is held at the smallest value.
pub(super) fn warning(problem: &Problem) -> Option<String> {
    if problem.parameters.iter().any(|own| own.path == BETA) {
        return None;
    }
    let least = least(problem)?;
    let is_least = |trial: &Trial| trial.model.index(BETA).is_ok_and(|k| trial.model.theta[k] == least);
    problem.trials().any(is_least).then(|| {
        format!(
            "{BETA} is not fitted and is held at {}, which gives the second mode a damping ratio of {LEAST_DAMPING}: with zero, nothing damps fast waves; state or fit it if the rod loses more",
            format_si(least, "s")
        )
    })
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::Run;

    use super::*;
    use crate::calibrate::{FittedParameter, Nuisances, Scope};
    use crate::example::release;

    fn problem(beta: f64, fitted: &str) -> Problem {
        let mut model = muscle_at_15_psi();
        model.set(BETA, beta).expect("a muscle has it");
        let trial = Trial { release: release(Vec::new(), Vec::new()), model, run: Run::release(1.0, 10.0) };
        let parameters = vec![FittedParameter::new(fitted, Scope::Shared)];
        let mut problem = Problem { trials: vec![trial.into()], parameters, nuisances: Nuisances::default() };
        damp_waves(&mut problem);
        problem
    }

    /// Whatever is stated stays as it is stated, zero excepted.
    #[test]
    fn waves_are_damped_and_that_is_said() {
        let beta = |problem: &Problem| {
            let model = &problem.trials[0].model;
            model.value(BETA).expect("a muscle has it")
        };
        let held = problem(0.0, "effects.rayleigh_mass.alpha");
        let least = least(&held).expect("it has a rest");
        assert_eq!(beta(&held), least);
        assert!(warning(&held).is_some_and(|own| own.contains("is not fitted")));
        let stated = problem(0.01, "effects.rayleigh_mass.alpha");
        assert_eq!((beta(&stated), warning(&stated)), (0.01, None));
        let fitted = problem(0.01, BETA);
        assert_eq!(fitted.parameters[0].bounds.map(|bounds| bounds.0), Some(least));
    }
}
