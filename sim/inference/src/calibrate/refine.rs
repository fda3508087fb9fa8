//! The end of a fit: slopes of the prediction itself, a loss that suits the residuals, and a rod
//! without mesh.
//!
//! The stages come near with the slopes of the variational equation, whose error is a per cent or two. Where
//! two unknowns are nearly collinear, that error would shift the final fit along their valley; so here slopes
//! are differences of runs on the same steps. They cost a run for each unknown, and are reused from point to
//! point as long as they predict the cost.

use efam_core::levenberg_marquardt::{Reused, Solution};
use efam_core::loss::Huber;
use nalgebra::DVector;

use super::numerics::{Correction, correction};
use super::objective::Objective;
use super::prediction::{Fidelity, Slopes};
use super::search::{Found, minimise_in};
use super::uncertainty::pseudo_inverse;
use super::view::{Evaluation, View};
use crate::normal::CLEAR;

/// Share of a standard error to which the fit of a calibration is found.
pub(super) const RESOLUTION: f64 = 0.02;
/// Rounds in which the loss and the weights follow what a fit misses.
pub(crate) const MOST_ROUNDS: usize = 4;
/// Change of the spread of what is missed that is worth another round.
pub(super) const CHANGED: f64 = 0.1;
/// The same as a share of the cost, where mesh and step were removed at another place.
const UNCORRECTED_SHARE: f64 = 1e-3;
/// Fidelity of the final fit. Alpha and beta are nearly collinear: only a fiftieth of a slope is independent
/// of the other. Steps of the usual size leave errors of four thousandths of the slopes, which turn that
/// remainder by half.
pub(crate) const LAST: Fidelity = Fidelity { tolerance: 2e-5, refinement: 1 };

/// Follows a fit to its end, one of [`LAST`] fidelity being near it, without the errors of the step, and of the mesh unless that is kept; says
/// what they did. `resolution` is the distance from the minimum at which it stops, standard errors.
pub(crate) fn refine(
    objective: &Objective,
    found: &mut Found,
    keep_mesh: bool,
    resolution: f64,
    tell: &dyn Fn(&str),
) -> Option<Correction> {
    let mut numerics = None;
    let mut view = View { slopes: Slopes::Differences, steps: None, ..found.view.clone() };
    // What mesh and step do is only known near the end: until then there is no use in the last digit.
    let first = (view.fidelity != LAST).then_some(UNCORRECTED_SHARE);
    for share in first.into_iter().chain([0.0, 0.0]) {
        if share == 0.0 && view.fidelity != LAST {
            (view.fidelity, view.steps) = (LAST, None);
        }
        tell("a finer mesh and step");
        let finer = correction(objective, &found.x, &view, keep_mesh)?;
        view.steps = Some(finer.own_steps.clone());
        view.corrections = Some(finer.corrections.clone());
        let better = settle(objective, found, &mut view, resolution, share)?;
        let errors = pseudo_inverse(&better.at.hessian).0.diagonal();
        let moved = (&better.x - &found.x).zip_map(&errors, |x, error| x / error.max(1e-300).sqrt());
        found.go_to(better, view.clone());
        numerics = Some(finer);
        if share == 0.0 && moved.amax() < CLEAR {
            break;
        }
    }
    numerics
}

/// Minimises with a loss whose threshold follows the spread of the residuals, on the steps that the
/// view has, or else on those of the start.
fn settle(
    objective: &Objective,
    from: &Found,
    view: &mut View,
    resolution: f64,
    share: f64,
) -> Option<Solution<Evaluation>> {
    if view.steps.is_none() {
        view.steps = Some(objective.see(&from.x, view, None)?.steps);
    }
    let is_alike = from.view.fidelity == view.fidelity;
    let start_home = from.home.as_ref().filter(|_| is_alike && from.view.slopes == view.slopes);
    let mut best: Option<Solution<Evaluation>> = None;
    for _ in 0..MOST_ROUNDS {
        let (x, carried, home) = match &best {
            Some(best) => (&best.x, &best.at.carried, best.home.as_ref()),
            None => (&from.x, &from.at.carried, start_home),
        };
        // Until mesh and step are known where they belong, the slopes of the stages will do.
        let is_reused = best.is_some() || is_alike || share > 0.0;
        let reused = is_reused.then_some(Reused { carried, home });
        let spreads = carried.spreads();
        view.loss = spreads.iter().map(|spread| Huber::for_spread(*spread)).collect();
        let solution = minimise_in(objective, x, reused, view, 0.5 * resolution * resolution, share)?;
        let now = solution.at.carried.spreads();
        let settled = |(before, now): (&f64, &f64)| (before.max(1.0) / now.max(1.0)).ln().abs() < CHANGED;
        let is_settled = spreads.iter().zip(&now).all(settled);
        best = Some(solution);
        if is_settled {
            break;
        }
    }
    best
}

/// By how many standard errors mesh and step would move each unknown if they were left in.
pub(crate) fn shift(objective: &Objective, found: &Found) -> DVector<f64> {
    let mut pull = DVector::zeros(found.x.len());
    let corrections = found.view.corrections.iter().flatten();
    for (r, (block, corrections)) in found.at.carried.blocks.iter().zip(corrections).enumerate() {
        let (locals, loss) = (&objective.part.locals[r], found.view.loss[r]);
        for (t, (series, correction)) in block.iter().zip(corrections).enumerate() {
            let per_noise = objective.measured[r].noise[t].recip();
            for ((k, residual), slopes) in series.samples.iter().zip(&series.residual).zip(&series.slopes) {
                let weight = loss.weight(residual[0].hypot(residual[1])) * per_noise;
                for (local, slope) in locals.iter().zip(slopes) {
                    let [x, z] = correction[*k];
                    pull[local.unknown] += weight * (slope[0] * x + slope[1] * z);
                }
            }
        }
    }
    let inverse = pseudo_inverse(&found.at.hessian).0;
    let errors = inverse.diagonal();
    (inverse * pull).zip_map(&errors, |moved, error| -moved / error.max(1e-300).sqrt())
}
