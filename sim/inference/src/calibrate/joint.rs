//! All releases fitted together, for one who goes on from there: a diagnosis.

use std::sync::Arc;

use nalgebra::DVector;

use super::error::CalibrateError;
use super::objective::Objective;
use super::part::whole;
use super::prediction::{Fidelity, Slopes};
use super::problem::{Problem, Trial};
use super::refine::{LAST, RESOLUTION_FITTED, refine};
use super::search::{EXPLAINED, Found, Meeting, common_cost, is_met, minimise_in, search};
use super::stage::STAGE_SHARE;
use super::starts::{counts, swing_times};
use super::unknowns::{Group, Unknown, UnknownKind, Unknowns};
use super::view::{Evaluation, View};

/// A value of a scaled unknown.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    pub unknown: Unknown,
    pub x: f64,
}

impl Estimate {
    /// Whether it is the same unknown, perhaps of a problem with other parameters, where its place is another one.
    pub fn is(&self, other: &Unknown) -> bool {
        self.unknown.name == other.name && self.unknown.group.is(other.group)
    }

    /// Whether it is the same parameter with one value for all.
    fn is_shared(&self, other: &Unknown) -> bool {
        self.unknown.name == other.name && self.unknown.group == Group::All
    }

    /// Whether it is a parameter of a trial's model.
    pub fn is_of(&self, place: usize, trial: &Trial) -> bool {
        let is_parameter = matches!(self.unknown.kind, UnknownKind::Parameter(_));
        is_parameter
            && match (self.unknown.group, trial.release.pressure) {
                (Group::All, _) => true,
                (own @ Group::Pressure(_), Some(pressure)) => own.is(Group::Pressure(pressure)),
                (Group::Pressure(_), None) => false,
                (Group::Release(own), _) => own == place,
            }
    }

    /// The value, SI.
    pub fn value(&self) -> f64 {
        self.unknown.scaled.value(self.x)
    }
}

/// A fit of all releases of a problem that are not held out.
#[derive(Clone)]
pub(crate) struct Joint {
    pub problem: Problem,
    pub objective: Arc<Objective>,
    pub found: Found,
    /// What may be left of the mesh's error, m, root mean square of each release; none where it was not
    /// removed anew.
    pub left_of_mesh: Option<Vec<f64>>,
}

/// What a fit of all releases of a problem lowers.
fn objective_of(problem: &Problem) -> Result<Objective, CalibrateError> {
    Objective::new(whole(problem, Unknowns::of(problem)?))
}

impl Joint {
    fn new(problem: &Problem, objective: Objective, found: Found) -> Self {
        Self { problem: problem.clone(), objective: objective.into(), found, left_of_mesh: None }
    }

    /// The same fit of a problem that differs in nothing that was fitted.
    /// # Errors
    /// [`CalibrateError`] where the problem is another one than was fitted.
    pub fn with_problem(self, problem: Problem) -> Result<Self, CalibrateError> {
        Ok(Self { objective: objective_of(&problem)?.into(), problem, ..self })
    }

    /// Searches from the problem's start.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense, and where no start leads to a fit.
    pub fn search(problem: &Problem, tell: &(dyn Fn(&str) + Sync)) -> Result<Self, CalibrateError> {
        let objective = objective_of(problem)?;
        let start = objective.start();
        let say = |stage: &super::Stage, _: &DVector<f64>| match stage.swings {
            Some(swings) => {
                tell(&format!("{swings:.1} swings, residuals {:.2} times the noise", stage.spread))
            }
            None => tell(&format!("residuals {:.2} times the noise", stage.spread)),
        };
        let Some(mut found) = search(&objective, &start, &say) else { return Err(objective.refusal(&start)) };
        let left_of_mesh =
            refine(&objective, &mut found, false, RESOLUTION_FITTED, tell).map(|mesh| mesh.left);
        Ok(Self { left_of_mesh, ..Self::new(problem, objective, found) })
    }

    /// Begins a search in the first samples of each release.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn meeting(problem: &Problem, counts: &[usize]) -> Result<Meeting, CalibrateError> {
        Ok(Meeting::new(objective_of(problem)?, counts))
    }

    /// The best fit of such a search, with what mesh and step do. None where no start could be run.
    pub fn met(problem: &Problem, meeting: Meeting) -> Option<Self> {
        let (problem, objective) = (problem.clone(), meeting.objective);
        meeting.best.map(|found| Self { problem, objective, found, left_of_mesh: None })
    }

    /// How many samples of each release lie within so many small swings of the slowest one.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn first_swings(problem: &Problem, swings: f64) -> Result<Vec<usize>, CalibrateError> {
        let objective = objective_of(problem)?;
        let times = swing_times(&objective, &objective.start());
        let longest = times.iter().copied().fold(0.0, f64::max);
        Ok(counts(&objective, &vec![longest; times.len()], swings))
    }

    /// Goes on from what is known to `resolution`, the distance from the minimum in standard errors: unknowns that are among
    /// it begin there, others at their start. None where the model cannot be run there, or not on a finer mesh.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn follow(
        problem: &Problem,
        known: &[Estimate],
        resolution: f64,
    ) -> Result<Option<Self>, CalibrateError> {
        let fit = CalibrateError::if_run(Self::at(problem, known, Slopes::Differences, LAST))?;
        Ok(fit.and_then(|fit| fit.refined(resolution)))
    }

    /// Goes on to `resolution` from where it is. None where it cannot be run on a finer mesh.
    pub fn refined(mut self, resolution: f64) -> Option<Self> {
        let mesh = refine(&self.objective, &mut self.found, false, resolution, &|_| ())?;
        self.left_of_mesh = Some(mesh.left);
        Some(self)
    }

    /// Comes near the minimum from what is known, with what mesh and step do as another fit of the same
    /// releases has found it: for comparing many models of which few are worth more. On the steps of that
    /// fit, unless the model needs its own. None where the model cannot be run there.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn approach(
        problem: &Problem,
        known: &[Estimate],
        like: &View,
        has_own_steps: bool,
        share: f64,
    ) -> Result<Option<Self>, CalibrateError> {
        let objective = objective_of(problem)?;
        let x = placed(&objective, known);
        Ok(Self::like(problem, objective, &x, like, has_own_steps, share))
    }

    /// Searches from the problem's start, and then as [`Joint::approach`] does, to [`STAGE_SHARE`].
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn search_like(problem: &Problem, like: &View) -> Result<Option<Self>, CalibrateError> {
        let objective = objective_of(problem)?;
        let found = search(&objective, &objective.start(), &|_, _| ());
        Ok(found.and_then(|found| Self::like(problem, objective, &found.x, like, true, STAGE_SHARE)))
    }

    /// The minimum near a point with what mesh and step do as another fit has found it.
    fn like(
        problem: &Problem,
        objective: Objective,
        x: &DVector<f64>,
        like: &View,
        has_own_steps: bool,
        share: f64,
    ) -> Option<Self> {
        let mut view = View { slopes: Slopes::Variational, ..like.clone() };
        if has_own_steps {
            view.steps = Some(objective.see(x, &View { steps: None, ..like.clone() }, None)?.steps);
        }
        Self::near(problem, objective, x, view, share)
    }

    /// Comes near the minimum over all releases of a problem that two fits have between them, from what those
    /// know, and with what mesh and step do as they have found it. None where the model cannot be run there.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn together(problem: &Problem, parts: [&Joint; 2]) -> Result<Option<Self>, CalibrateError> {
        let objective = objective_of(problem)?;
        let seen = |t: &usize| {
            parts.iter().find_map(|part| {
                let r = part.objective.part.trials.iter().position(|own| own == t)?;
                Some((&part.found.view, r))
            })
        };
        let releases: Option<Vec<_>> = objective.part.trials.iter().map(seen).collect();
        let Some(view) = releases.and_then(|releases| View::gathered(&releases)) else { return Ok(None) };
        let view = View { slopes: Slopes::Variational, ..view };
        let x = placed(&objective, &parts.map(|part| part.known()).concat());
        Ok(Self::near(problem, objective, &x, view, 0.0))
    }

    /// The minimum near a point, under one view; the search ends where it gains no more than a `share` of the cost.
    fn near(
        problem: &Problem,
        objective: Objective,
        x: &DVector<f64>,
        view: View,
        share: f64,
    ) -> Option<Self> {
        let ended = minimise_in(&objective, x, None, &view, 1.0, share)?;
        let found = Found::of(ended, view, Vec::new());
        Some(Self::new(problem, objective, found))
    }

    /// What is known, as it is: unknowns that are among it are there, others at their start, and nothing
    /// is fitted.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense, and where the model cannot be run there.
    pub fn at(
        problem: &Problem,
        known: &[Estimate],
        slopes: Slopes,
        fidelity: Fidelity,
    ) -> Result<Self, CalibrateError> {
        let objective = objective_of(problem)?;
        let x = placed(&objective, known);
        let view = View { fidelity, ..View::of_all(objective.all()) };
        let Some(seen) = objective.see(&x, &view, None) else { return Err(objective.refusal(&x)) };
        let view = View { slopes, ..view.like(seen) };
        let Some(at) = objective.evaluate(&x, &view, None) else { return Err(objective.refusal(&x)) };
        let home = Some(x.clone());
        let (predicted, converged) = (f64::INFINITY, false);
        let found = Found { x, at, home, view, stages: Vec::new(), predicted, converged, starts: 1 };
        Ok(Self::new(problem, objective, found))
    }

    /// Residuals at what is known, with what they were measured by.
    /// # Errors
    /// As [`Joint::at`].
    pub fn seen(problem: &Problem, known: &[Estimate]) -> Result<(Objective, Evaluation), CalibrateError> {
        let objective = objective_of(problem)?;
        let x = placed(&objective, known);
        match objective.see(&x, &View::of_all(objective.all()), None) {
            Some(seen) => Ok((objective, seen)),
            None => Err(objective.refusal(&x)),
        }
    }

    /// Whether its residuals are noise, or small beside the motion, so that the search found the right minimum.
    pub fn is_met(&self) -> bool {
        is_met(&self.objective, &self.found)
    }

    /// Whether the noise explains its residuals.
    pub fn is_explained(&self) -> bool {
        self.found.at.carried.spreads().iter().all(|spread| *spread < EXPLAINED)
    }

    /// The name of a release, by its place in the problem.
    pub fn name_of(&self, trial: usize) -> Option<String> {
        let place = self.objective.part.trials.iter().position(|t| *t == trial)?;
        Some(self.objective.part.members[place].release.name.clone())
    }

    /// What it found.
    pub fn known(&self) -> Vec<Estimate> {
        let pairs = self.objective.part.unknowns.iter().zip(&self.found.x);
        pairs.map(|(unknown, x)| Estimate { unknown: unknown.clone(), x: *x }).collect()
    }

    /// The cost under the loss of the noise itself, which fits of the same releases share.
    pub fn cost(&self) -> f64 {
        common_cost(&self.objective, &self.found)
    }
}

/// The unknowns at what is known of them, others at their start.
fn placed(objective: &Objective, known: &[Estimate]) -> DVector<f64> {
    let mut x = objective.start();
    for (x, unknown) in x.iter_mut().zip(&objective.part.unknowns) {
        // What all shared is where one's own begins.
        let shared = || known.iter().find(|known| known.is_shared(unknown));
        if let Some(known) = known.iter().find(|known| known.is(unknown)).or_else(shared) {
            *x = known.x;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Held-out releases are fitted without the parameters that all share, so the others stand in other places there.
    #[test]
    fn an_unknown_of_another_problem_is_known_by_its_name_and_its_group() {
        let of = |place: usize, group: Group| {
            let kind = UnknownKind::Parameter(place);
            Unknown::nuisance(kind, "rod.bending_stiffness", "N m^2", group, 1.0, f64::INFINITY)
        };
        let known = Estimate { unknown: of(0, Group::Pressure(1e5)), x: 2.0 };
        assert!(known.is(&of(3, Group::Pressure(1e5))));
        assert!(!known.is(&of(0, Group::Pressure(2e5))) && !known.is(&of(0, Group::All)));
    }
}
