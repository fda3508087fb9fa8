//! All releases fitted together, for one who goes on from there: a diagnosis.

use nalgebra::DVector;

use super::error::CalibrateError;
use super::objective::{Objective, View};
use super::part::whole;
use super::prediction::Slopes;
use super::problem::Problem;
use super::refine::refine;
use super::search::{Found, search};
use super::unknowns::Unknowns;

/// A fit of all releases that are not locked away.
pub(crate) struct Joint<'a> {
    pub objective: Objective<'a>,
    pub found: Found,
}

impl<'a> Joint<'a> {
    /// Searches from the problem's start.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense, and where no start leads to a fit.
    pub fn search(problem: &'a Problem, tell: &(dyn Fn(&str) + Sync)) -> Result<Self, CalibrateError> {
        let objective = Objective::new(whole(problem, Unknowns::of(problem)?))?;
        let start = objective.start();
        let say = |stage: &super::Stage| match stage.swings {
            Some(swings) => {
                tell(&format!("{swings:.1} swings, residuals {:.2} times the noise", stage.spread))
            }
            None => tell(&format!("residuals {:.2} times the noise", stage.spread)),
        };
        let Some(mut found) = search(&objective, &start, &say) else { return Err(objective.refusal(&start)) };
        refine(&objective, &mut found, true, tell);
        Ok(Self { objective, found })
    }

    /// Goes on from another fit of the same releases: unknowns that both have begin where that one
    /// ended, others at their start. None where the model cannot be run there.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn follow(
        problem: &'a Problem,
        from: &Joint,
        tell: &dyn Fn(&str),
    ) -> Result<Option<Self>, CalibrateError> {
        let objective = Objective::new(whole(problem, Unknowns::of(problem)?))?;
        let mut x = objective.start();
        for (x, unknown) in x.iter_mut().zip(&objective.part.unknowns) {
            let same = |(_, other): &(&f64, &super::unknowns::Unknown)| {
                (&other.name, other.kind, other.group) == (&unknown.name, unknown.kind, unknown.group)
            };
            if let Some((there, _)) = from.found.x.iter().zip(&from.objective.part.unknowns).find(same) {
                *x = *there;
            }
        }
        Ok(Self::at(objective, x, tell))
    }

    fn at(objective: Objective<'a>, x: DVector<f64>, tell: &dyn Fn(&str)) -> Option<Self> {
        let mut view = View::of_all(&objective);
        let seen = objective.see(&x, &view, None)?;
        view.loss = seen.spreads().into_iter().map(super::loss::Huber::for_spread).collect();
        view.steps = Some(seen.steps);
        view.slopes = Slopes::Differences;
        let at = objective.evaluate(&x, &view, None)?;
        let mut found =
            Found { x, at, view, stages: Vec::new(), predicted: f64::INFINITY, converged: false, starts: 1 };
        refine(&objective, &mut found, true, tell);
        Some(Self { objective, found })
    }

    /// The value of an unknown, SI.
    pub fn value(&self, unknown: usize) -> f64 {
        self.objective.part.unknowns[unknown].scaled.value(self.found.x[unknown])
    }
}
