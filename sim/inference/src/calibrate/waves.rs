//! Fast waves along the rod are damped, whatever is fitted.
//!
//! A loss by the rate of bending alone damps them. Where it is zero, an integrator follows every wave, in a hundred times
//! the steps, and the swing is the same.

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

fn is_fitted(problem: &Problem) -> bool {
    problem.parameters.iter().any(|own| own.path == BETA)
}

/// Keeps β from leaving waves undamped: a β that is fitted by its bound, unless the experiment gives one, any other by its
/// value.
pub fn damp_waves(problem: &mut Problem) {
    let Some(least) = least(problem) else { return };
    if is_fitted(problem) {
        let trial = problem.trials.first();
        let most = trial.and_then(|trial| trial.model.parameters.iter().find(|known| known.path == BETA));
        let Some(most) = most.map(|known| known.range.1) else { return };
        for own in problem.parameters.iter_mut().filter(|own| own.path == BETA && own.bounds.is_none()) {
            own.bounds = Some((least, most));
        }
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

/// Says that a β which is not fitted is as small as damps the waves.
pub(super) fn warning(problem: &Problem) -> Option<String> {
    let least = least(problem).filter(|_| !is_fitted(problem))?;
    let is_least = |trial: &Trial| trial.model.index(BETA).is_ok_and(|k| trial.model.theta[k] == least);
    problem.trials().any(is_least).then(|| {
        format!(
            "{BETA} is not fitted and is held at {}, a damping ratio of {LEAST_DAMPING} in the second mode: without it nothing damps fast waves; state or fit it if the rod loses more",
            format_si(least, "s")
        )
    })
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::Run;
    use efam_experiments::release::Release;

    use super::*;
    use crate::calibrate::{FittedParameter, Nuisances, Scope};

    fn problem(beta: f64, fitted: &str) -> Problem {
        let release = Release {
            name: "made-up".to_owned(),
            time: Vec::new(),
            release_uncertainty: 0.01,
            tracks: Vec::new(),
            pressure: None,
            payload: 0.0,
            held_out: false,
        };
        let mut model = muscle_at_15_psi();
        model.set(BETA, beta).expect("a muscle has it");
        let trial = Trial { release, model, run: Run::release(1.0, 10.0) };
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
            model.theta[model.index(BETA).expect("a muscle has it")]
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
