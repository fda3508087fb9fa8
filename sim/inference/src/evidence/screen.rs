//! The screen: which candidates are worth a fit.
//!
//! An effect that is off leaves the rod as it is, so one run of each release has the slopes by many strengths. The linearised
//! model's evidence ranks the candidates; one run at its optimum shows how far that holds, and where a fit begins.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidates::Extension;
use super::data::Data;
use super::hypothesis::Hypothesis;
use super::likelihood::{Compared, evidence, expand, likelihood};
use super::search::Fit;
use super::unknown::{Act, Role, Unknown};

/// Longest step of the linearised model, prior standard deviations.
const LONGEST: f64 = 2.0;
/// Part of that step which is tried where the whole step leads astray: strong effects are not linear.
const PART: f64 = 0.3;
/// Strength from which a fit begins where the linearised model has none, prior standard deviations.
const LITTLE: f64 = 0.02;
/// Factor of the share within which the linearised model finds its own.
const REACH: f64 = 20.0;

/// A candidate and where its fit begins.
pub struct Screened {
    pub extension: Extension,
    pub start: DVector<f64>,
    pub share: f64,
    /// Logarithm of evidence over the baseline, by the linearised model and by a run at its optimum: the smaller one.
    pub promise: f64,
}

/// Screens extensions of a fit, the most promising first.
pub fn screen(data: &Data, base: &Fit, extensions: Vec<Extension>) -> Vec<Screened> {
    let slopes = slopes(data, base, &extensions);
    let (before, _) = likelihood(&base.compared, &data.weights, &base.z, base.share, REACH);
    let screened =
        |(extension, own): (Extension, Option<Compared>)| screened(data, base, before, extension, own?);
    let pairs: Vec<_> = extensions.into_iter().zip(slopes).collect();
    let mut all: Vec<Screened> =
        pairs.into_par_iter().map(screened).collect::<Vec<_>>().into_iter().flatten().collect();
    all.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    all
}

/// Differences and slopes of each extension at the optimum of the fit, where its strengths are zero.
fn slopes(data: &Data, base: &Fit, extensions: &[Extension]) -> Vec<Option<Compared>> {
    let mut found: Vec<Option<Compared>> = extensions.iter().map(|own| known(base, own)).collect();
    for together in side_by_side(extensions) {
        let alone = |e: &usize| vec![*e];
        let runs = match columns(data, base, extensions, &together) {
            Some(columns) => vec![(together, columns)],
            None if together.len() == 1 => Vec::new(),
            // One of them cannot be run; the others can.
            None => (together.iter().map(alone))
                .filter_map(|one| Some((one.clone(), columns(data, base, extensions, &one)?)))
                .collect(),
        };
        for (together, columns) in runs {
            let mut next = 0;
            for e in together {
                let count = extensions[e].strengths.len();
                if let Some(own) = &mut found[e] {
                    for (own, columns) in own.slopes.iter_mut().zip(&columns) {
                        for (k, place) in extensions[e].strengths.iter().enumerate() {
                            own.set_column(*place, &columns.column(next + k));
                        }
                    }
                }
                next += count;
            }
        }
    }
    found
}

/// The slopes that the fit has, in the places of an extension; the strengths have none yet.
fn known(base: &Fit, extension: &Extension) -> Option<Compared> {
    let (n, all) = (base.z.len(), extension.hypothesis.unknowns.len());
    let wider = |(u, own): (usize, &Unknown)| {
        let before = base.hypothesis.unknowns.get(u);
        if before.is_some_and(|before| before.scaled != own.scaled) { extension.wider } else { 1.0 }
    };
    let factors: Vec<f64> = extension.hypothesis.unknowns.iter().enumerate().map(wider).collect();
    let slopes = base.compared.slopes.iter().map(|own| {
        DMatrix::from_fn(own.nrows(), all, |f, u| if u < n { factors[u] * own[(f, u)] } else { 0.0 })
    });
    Some(Compared { differences: base.compared.differences.clone(), slopes: slopes.collect() })
}

/// Which extensions one model can have side by side: those of different effects.
fn side_by_side(extensions: &[Extension]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (e, own) in extensions.iter().enumerate().filter(|(_, own)| !own.strengths.is_empty()) {
        let is_apart =
            |group: &&mut Vec<usize>| group.iter().all(|other| extensions[*other].name != own.name);
        match all.iter_mut().find(is_apart) {
            Some(group) => group.push(e),
            None => all.push(vec![e]),
        }
    }
    all
}

/// Slopes of features by the strengths of several extensions, by release, each from where it is off.
fn columns(
    data: &Data,
    base: &Fit,
    extensions: &[Extension],
    together: &[usize],
) -> Option<Vec<DMatrix<f64>>> {
    let n = base.z.len();
    let mut joint = Hypothesis::clone(&base.hypothesis);
    let places: Vec<usize> = together.iter().flat_map(|e| extensions[*e].strengths.iter().copied()).collect();
    for e in together {
        let own = &extensions[*e].hypothesis;
        for (trial, with) in joint.trials.iter_mut().zip(&own.trials) {
            let added = with.model.effect(&extensions[*e].name)?;
            let values: Vec<(&str, f64)> = (added.effect.about().parameters.iter())
                .zip(added.theta.clone())
                .map(|(parameter, k)| (parameter.name, with.model.theta[k]))
                .collect();
            *trial = trial.with_effect(&extensions[*e].name, &values).ok()?;
        }
        for place in &extensions[*e].strengths {
            let mut unknown = own.unknowns[*place].clone();
            for (r, act) in &mut unknown.acts {
                let Act::Theta(k) = act else { return None };
                let path = &own.trials[*r].model.parameters[*k.first()?].path;
                *k = vec![joint.trials[*r].model.index(path).ok()?];
            }
            joint.unknowns.push(unknown);
        }
    }
    let z = DVector::from_fn(joint.unknowns.len(), |u, _| if u < n { base.z[u] } else { 0.0 });
    let compared = data.compare(&joint, &z, &|u| u >= n)?;
    let of_release = |slopes: &DMatrix<f64>| slopes.columns(n, places.len()).into_owned();
    Some(compared.slopes.iter().map(of_release).collect())
}

/// The linearised model of one extension, and a run at its optimum. `before` is the logarithm of the likelihood of the fit
/// that it extends.
fn screened(
    data: &Data,
    base: &Fit,
    before: f64,
    extension: Extension,
    slopes: Compared,
) -> Option<Screened> {
    let unknowns = &extension.hypothesis.unknowns;
    let n = base.z.len();
    let at = |u: usize| {
        if u >= n {
            return if unknowns[u].role == Role::Strength { 0.0 } else { unknowns[u].start };
        }
        let is_wider = base.hypothesis.unknowns[u].scaled != unknowns[u].scaled;
        if is_wider { base.z[u] / extension.wider } else { base.z[u] }
    };
    let z = DVector::from_fn(unknowns.len(), |u, _| at(u));
    let (linear, share) = evidence(&slopes, &data.weights, unknowns, &z, base.share, REACH);
    let expanded = expand(&slopes, &data.weights, &z, share);
    let step =
        expanded.hessian.cholesky()?.solve(&expanded.gradient).map(|step| step.clamp(-LONGEST, LONGEST));
    // The volume of the unknowns is that of the linearised model.
    let promised = linear - base.evidence;
    let mut best: Option<(f64, f64, DVector<f64>)> = None;
    for part in [1.0, PART] {
        let start = begun(unknowns, &z, &(part * &step));
        let Some(there) = data.compare(&extension.hypothesis, &start, &|_| false) else { continue };
        let (value, share) = likelihood(&there, &data.weights, &start, share, REACH);
        if best.as_ref().is_none_or(|best| value - before > best.0) {
            best = Some((value - before, share, start));
        }
        // The linearised model holds: no shorter step is needed.
        if value - before > 0.5 * promised {
            break;
        }
    }
    let (tried, share, start) = best?;
    let promise = promised.min(tried) + extension.odds;
    Some(Screened { extension, start, share, promise })
}

/// Where a step of the linearised model leads: within the bounds, and a little of each strength at least.
fn begun(unknowns: &[Unknown], z: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
    let mut start = z - step;
    for (start, unknown) in start.iter_mut().zip(unknowns) {
        if unknown.is_half {
            *start = start.max(0.0);
        }
        if unknown.role == Role::Strength && start.abs() < LITTLE {
            *start = LITTLE.copysign(*start);
        }
    }
    start
}

/// A start for a fit that ended below the one that it extends: all as there, and a little of the strengths.
pub fn beside(base: &Fit, extension: &Extension) -> DVector<f64> {
    let unknowns = &extension.hypothesis.unknowns;
    DVector::from_fn(unknowns.len(), |u, _| match base.hypothesis.unknowns.get(u) {
        Some(before) if before.scaled != unknowns[u].scaled => base.z[u] / extension.wider,
        Some(_) => base.z[u],
        None if unknowns[u].role == Role::Strength => LITTLE,
        None => unknowns[u].start,
    })
}

/// The hypothesis of an extension, shared.
pub fn hypothesis(extension: &Extension) -> Arc<Hypothesis> {
    Arc::new(extension.hypothesis.clone())
}
