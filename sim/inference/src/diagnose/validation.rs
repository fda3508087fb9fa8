//! Validation of a model on held-out releases.
//!
//! How well it predicts them is what all releases cost together beyond those that were fitted,
//! `p(held out | fitted) = p(all) / p(fitted)`: a parameter that the fitted releases leave uncertain may still
//! give way. The gap that is shown is another one: everything that all releases share is held as it was found,
//! and only what belongs to a pressure or a release is fitted to them.

use std::sync::Arc;
use std::sync::OnceLock;

use super::curve::{Agreement, paths};
use super::verdict::Gap;
use crate::calibrate::ghosts::ghosts;
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::prediction::{FIT, Slopes};
use crate::calibrate::repeats::quantile_of_f;
use crate::calibrate::unknowns::{self, Group};
use crate::calibrate::{CalibrateError, Problem, Scope};

/// A model before held-out releases.
pub(super) struct HeldOut {
    pub agreement: Agreement,
    /// What belongs to the held-out releases alone, fitted to them.
    fitted: Joint,
    /// The model fitted to them and to what it was fitted to; none where that cannot be run.
    together: OnceLock<Option<Joint>>,
}

impl HeldOut {
    /// Shows a model held-out releases; none where there are none, or where the model cannot be run there.
    pub fn meet(problem: &Problem, known: &[Estimate]) -> Result<Option<Self>, CalibrateError> {
        Self::shown(problem, known, |held_out| Joint::search(held_out, &|_| ()))
    }

    /// What it meets of them without any fit.
    pub fn as_predicted(problem: &Problem, known: &[Estimate]) -> Result<Option<Self>, CalibrateError> {
        Self::shown(problem, known, |held_out| Joint::at(held_out, &[], Slopes::Variational, FIT))
    }

    /// What a fit makes of held-out releases, where what all share is held as it is known.
    fn shown(
        problem: &Problem,
        known: &[Estimate],
        fit: fn(&Problem) -> Result<Joint, CalibrateError>,
    ) -> Result<Option<Self>, CalibrateError> {
        if !problem.trials.iter().any(|trial| trial.release.held_out) {
            return Ok(None);
        }
        let mut held_out = problem.clone();
        set(&mut held_out, known);
        for trial in held_out.trials_mut() {
            trial.release.held_out = !trial.release.held_out;
        }
        // EI of a pressure that was held out as a whole is not known from elsewhere.
        held_out.parameters.retain(|parameter| parameter.scope != Scope::Shared);
        let fitted = CalibrateError::if_run(fit(&held_out))?;
        Ok(fitted.map(|fitted| Self { agreement: agreement(&fitted), fitted, together: OnceLock::new() }))
    }

    /// What belongs to them alone, as fitted to them.
    pub fn known(&self) -> Vec<Estimate> {
        self.fitted.known()
    }

    /// What they cost the model beyond what was fitted, whose fit is given; none where all together cannot be
    /// run.
    pub fn cost(&self, fit: &Joint) -> Result<Option<f64>, CalibrateError> {
        Ok(self.together(fit)?.map(|all| all.cost() - fit.cost()))
    }

    /// Mean squares over the noise of what was fitted, whose fit is given, and of what all together cost beyond it: the
    /// robust loss counts large residuals less. None where all together cannot be run.
    pub fn mean_squares(&self, fit: &Joint) -> Result<Option<[f64; 2]>, CalibrateError> {
        let Some(all) = self.together(fit)? else { return Ok(None) };
        let coordinates = |fit: &Joint| {
            let series = fit.found.at.carried.blocks.iter().flatten();
            series.map(|series| 2 * series.samples.len()).sum::<usize>() as f64
        };
        let [fitted, together] = [fit, all].map(|fit| [2.0 * fit.cost(), coordinates(fit)]);
        let beyond = (together[0] - fitted[0]) / (together[1] - fitted[1]).max(1.0);
        Ok(Some([fitted[0] / fitted[1].max(1.0), beyond]))
    }

    /// How the model meets all of them with what it was fitted to, fitted together; none where that cannot be run.
    pub fn met_together(&self, fit: &Joint) -> Result<Option<Agreement>, CalibrateError> {
        Ok(self.together(fit)?.map(agreement))
    }

    /// The model fitted to them and to what it was fitted to, whose fit is given; none where that cannot be run.
    pub fn together(&self, fit: &Joint) -> Result<Option<&Joint>, CalibrateError> {
        if self.together.get().is_none() {
            let mut all = fit.problem.clone();
            all.trials_mut().for_each(|trial| trial.release.held_out = false);
            let _ = self.together.set(Joint::together(&all, [fit, &self.fitted])?);
        }
        Ok(self.together.get().and_then(Option::as_ref))
    }
}

/// How a fit meets its own releases.
pub(super) fn agreement(fit: &Joint) -> Agreement {
    let of_release = |r: usize| {
        let block = &fit.found.at.carried.blocks[r];
        let loss = fit.found.view.loss[r];
        let (mut squares, mut heard) = (0.0, 0.0f64);
        let (mut distance, mut noise, mut count) = (0.0, 0.0, 0.0f64);
        let release = &fit.objective.part.members[r].release;
        let measured = &fit.objective.measured[r];
        for (t, series) in block.iter().enumerate() {
            let (own, camera_noise) = (measured.noise[t], measured.camera_noise[t]);
            let ghosts = ghosts(&release.tracks[t].position);
            for (k, residual) in series.samples.iter().zip(&series.residual) {
                let length = residual[0].hypot(residual[1]);
                if length <= loss.threshold {
                    squares += 0.5 * (length * own / camera_noise).powi(2);
                    heard += 1.0;
                }
                if !ghosts[measured.samples[*k]] {
                    distance += (own * length).powi(2);
                    noise += camera_noise;
                    count += 1.0;
                }
            }
        }
        let n = count.max(1.0);
        (
            release.name.clone(),
            1e3 * (distance / n).sqrt(),
            (squares / heard.max(1.0)).sqrt(),
            1e3 * noise / n,
        )
    };
    let gaps = (0..fit.found.view.loss.len()).map(of_release).collect();
    Agreement { gaps, paths: paths(fit) }
}

/// What a model that is right may miss of releases that it was not fitted to, root mean square over the noise: an
/// error of a law.
const MISSED: f64 = 0.6;

/// Whether held-out releases are missed by more than a model that is right would, by the mean squares over the noise of
/// what was fitted and of them: one effect in the place of another fits what it is fitted to.
pub(super) fn is_astray([fitted, held_out]: [f64; 2]) -> bool {
    held_out > fitted.max(1.0) + MISSED.powi(2)
}

/// Whether the residuals of held-out releases are larger than those of fitted ones, by mean squares of each release: a similar
/// law follows what it is fitted to. Student's t with the spread of the fitted ones, at 97.5 %.
pub(super) fn is_missed(fitted: &[f64], held_out: &[f64]) -> bool {
    if fitted.len() < 2 || held_out.is_empty() {
        return false;
    }
    let [n, m] = [fitted, held_out].map(|own| own.len() as f64);
    let [mean, other] = [fitted, held_out].map(|own| own.iter().sum::<f64>() / own.len() as f64);
    let variance = fitted.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let of_difference = variance * (n.recip() + m.recip());
    other > mean && (other - mean).powi(2) > quantile_of_f(1.0, n - 1.0) * of_difference
}

/// Gaps before and after, of the same releases.
pub(super) fn gaps(before: &Agreement, after: &Agreement, held_out: bool) -> Vec<Gap> {
    let pairs = before.gaps.iter().zip(&after.gaps);
    pairs
        .map(|((release, before_mm, before, noise_mm), (_, after_mm, after, _))| Gap {
            release: release.clone(),
            held_out,
            before_mm: *before_mm,
            after_mm: *after_mm,
            before: *before,
            after: *after,
            noise_mm: *noise_mm,
        })
        .collect()
}

/// Puts what was found into the models.
pub(super) fn set(problem: &mut Problem, known: &[Estimate]) {
    for (t, trial) in problem.trials_mut().enumerate() {
        for known in known {
            if let (true, Ok(k)) = (known.is_of(t, trial), trial.model.index(&known.unknown.name)) {
                let (model, initial) = trial.with(&[(k, known.value())]);
                (trial.model, trial.run.initial) = (model, initial);
            }
        }
    }
}

/// Gives models what was found of their releases, for one who simulates them; a fit has it beside its models.
pub(super) fn pose(problem: &mut Problem, known: &[Estimate]) {
    for known in known {
        let Group::Release(t) = known.unknown.group else { continue };
        if known.unknown.is_nuisance() {
            let trial = Arc::make_mut(&mut problem.trials[t]);
            unknowns::pose(trial, &known.unknown.name, known.value());
        }
    }
}

#[cfg(test)]
mod tests {
    use efam_core::forward::Initial;

    use super::*;
    use crate::calibrate::hold::tests::pulled;
    use crate::calibrate::unknowns::{Unknown, UnknownKind};
    use crate::calibrate::{FittedParameter, Nuisances};

    /// The load of the hand that was found, also in what holds the rod.
    #[test]
    fn a_rod_starts_where_the_hand_was_found_to_hold_it() {
        let parameters = vec![FittedParameter::new("rod.bending_stiffness", Scope::Shared)];
        let mut problem =
            Problem { trials: vec![pulled(0.0).into()], parameters, nuisances: Nuisances::default() };
        let path = "effects.tip_hold.force_x";
        let unknown = Unknown::nuisance(UnknownKind::Pull, path, "N", Group::Release(0), 1.0, f64::INFINITY);
        pose(&mut problem, &[Estimate { unknown, x: 7.0 }]);
        let trial = &problem.trials[0];
        let Initial::Equilibrium { hold, .. } = &trial.run.initial else { panic!("it is held") };
        let force = |model: &models::model::Model| model.theta[model.index(path).unwrap()];
        assert_eq!((force(&trial.model), force(hold)), (7.0, 7.0));
    }

    /// Coloured noise that is larger than stated is in what was fitted as well; an effect in the place of another
    /// is not.
    #[test]
    fn what_was_held_out_is_missed_only_beyond_what_noise_leaves() {
        assert!(!is_astray([1.0, 1.1]) && !is_astray([1.44, 1.56]));
        assert!(is_astray([1.0, 1.96]) && is_astray([0.25, 1.96]));
    }

    /// Student's t at 4 degrees of freedom is 2.776 at 97.5 % (any table): here 2.7 and 2.9 standard errors. One fitted release
    /// has no spread.
    #[test]
    fn residuals_of_held_out_releases_are_larger_from_a_quantile_on() {
        let fitted = [0.9, 0.95, 1.0, 1.05, 1.1];
        let error = (0.00625f64 * (0.2 + 0.25)).sqrt();
        let held_out = |errors: f64| [1.0 + errors * error; 4];
        assert!(!is_missed(&fitted, &held_out(2.7)) && is_missed(&fitted, &held_out(2.9)));
        assert!(!is_missed(&fitted, &held_out(-2.9)) && !is_missed(&fitted[..1], &[2.0]));
    }
}
