//! A candidate fitted in full: its parameters beside all others, mesh and step removed anew.

use super::candidate::Candidate;
use super::verdict::Value;
use crate::calibrate::joint::{Joint, Known};
use crate::calibrate::profile::NORMAL_95;
use crate::calibrate::uncertainty::uncertainty;
use crate::calibrate::unknowns::Group;
use crate::calibrate::{CalibrateError, Problem};

/// A model with one more effect, fitted.
#[derive(Clone)]
pub(super) struct Refit {
    /// The problem with the effect in it.
    pub problem: Problem,
    /// Where the fit ended.
    pub known: Vec<Known>,
    /// Cost under the loss of the noise.
    pub cost: f64,
    /// Parameters of the effect.
    pub values: Vec<Value>,
    /// Whether the strength stands on a bound of what is believed, the value at which it is off included.
    pub is_at_bound: bool,
}

/// Fits a candidate, beginning with the strength that its score asks for. None where it cannot be run.
pub(super) fn refit(
    problem: &Problem,
    candidate: &Candidate,
    estimate: f64,
    from: &[Known],
) -> Result<Option<Refit>, CalibrateError> {
    let Ok(problem) = candidate.added_to(problem, estimate) else { return Ok(None) };
    let Some(fit) = Joint::follow(&problem, from, &|_| ())? else { return Ok(None) };
    let (values, is_at_bound) = values(&fit, candidate);
    let (known, cost) = (fit.known(), fit.cost());
    drop(fit);
    Ok(Some(Refit { known, cost, values, is_at_bound, problem }))
}

/// Values of an effect's parameters with their intervals, and whether the strength is at a bound.
fn values(fit: &Joint, candidate: &Candidate) -> (Vec<Value>, bool) {
    let of = uncertainty(&fit.objective, &fit.found);
    let prefix = format!("effects.{}.", candidate.name());
    let (mut values, mut is_at_bound) = (Vec::new(), false);
    for (k, known) in fit.known().iter().enumerate() {
        let Some(name) = known.unknown.name.strip_prefix(&prefix) else { continue };
        let (low, high) = known.unknown.bounds;
        let near = 1e-6 * (high - low).abs().min(1e300);
        is_at_bound |= name == candidate.strength.name && (known.x - low < near || high - known.x < near);
        let deviation = of.covariance[(k, k)].max(0.0).sqrt();
        let at = |side: f64| known.unknown.scaled.value(known.x + side * NORMAL_95 * deviation);
        values.push(Value {
            name: name.to_owned(),
            unit: known.unknown.unit.to_owned(),
            of: match known.unknown.group {
                Group::All => None,
                Group::Pressure(pressure) => Some(format!("{pressure} Pa")),
                Group::Release(t) => fit.name_of(t),
            },
            value: known.value(),
            interval_95: of.is_determined[k].then(|| [at(-1.0), at(1.0)]),
        });
    }
    for (parameter, value) in candidate.tried.iter().filter(|(parameter, _)| parameter.plausible.is_none()) {
        let (name, unit) = (parameter.name.to_owned(), parameter.unit.to_owned());
        values.push(Value { name, unit, of: None, value: *value, interval_95: None });
    }
    (values, is_at_bound)
}
