//! One run from its start to its end: what is seen of each step, and what ends it. Who makes the steps is left open.

use std::ops::ControlFlow;

use models::model::Model;
use models::snapshot::Energy;
use models::system::System;

use crate::integrate::variational::Variational;
use crate::integrate::{Control, IntegrateError, Method, Reached, State, Steps};
use crate::observed::Observer;
use crate::run::Run;
use crate::trajectory::{Status, Trajectory};

use super::budget::Budget;
use super::patience::Patience;
use super::{ForwardError, Sample};

/// A run under way.
pub(super) struct Course<'a> {
    model: &'a Model,
    run: &'a Run,
    system: System,
    observer: Observer,
    budget: Option<Budget>,
    trajectory: Trajectory,
    at: State,
    /// Times at which a step has to end, s, ascending, and which is next.
    stops: Vec<f64>,
    stop: usize,
    sample: usize,
    duration: f64,
    patience: Patience,
    is_explicit: bool,
}

/// Whether a run goes on.
pub(super) enum Next {
    /// With a step that ends at this time, s, or before it.
    Step(f64),
    /// It is over.
    Over,
}

impl<'a> Course<'a> {
    /// A run before its first step, and where it starts.
    pub fn new(model: &'a Model, run: &'a Run, method: Method) -> Result<(Self, State), ForwardError> {
        let mut system = System::new(model);
        let state = run.initial.state_of(&mut system, run.history)?;
        let observer = Observer::new(model, run);
        let duration = run.duration.max(observer.end());
        let mut stops = model.kinks();
        stops.retain(|time| *time > 0.0 && *time < duration);
        // What is seen later changes no step before the end of the run.
        stops.extend([run.duration, duration]);
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let own = Self {
            model,
            run,
            system,
            observer,
            budget: run.energy.then(|| Budget::new(model)),
            trajectory: Trajectory::new(model, run),
            at: state.clone(),
            stops,
            stop: 0,
            sample: 0,
            duration,
            patience: Patience::new(run.most_steps),
            is_explicit: method.of(model) == Method::Verlet,
        };
        Ok((own, state))
    }

    /// How accurately its steps are made.
    pub fn control(&self) -> Control {
        Control {
            tolerance: self.run.tolerance,
            steps: self.run.steps.clone(),
            most_steps: self.run.most_steps,
            first_step: None,
        }
    }

    /// Sees what lies in the last step.
    pub fn look(
        &mut self,
        integrator: &mut dyn Reached,
        variational: Option<&Variational>,
        observe: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
    ) -> Next {
        let Self { run, system, observer, budget, trajectory, at, .. } = self;
        let (begin, end) = (integrator.step_start(), integrator.state().time);
        while let Some(instant) = observer.due(end) {
            integrator.interpolate(instant, at);
            observer.see(system, variational, at, [begin, end], trajectory);
        }
        while let Some(time) = trajectory.trace.due(end, run.duration) {
            integrator.interpolate_end(time, at);
            trajectory.trace.record(system, at);
        }
        while self.sample < run.samples.len() && run.samples[self.sample] <= end {
            let time = run.samples[self.sample];
            integrator.interpolate(time, at);
            let energy = match budget {
                Some(budget) => budget.at(system, at, begin, end),
                None => Energy::default(),
            };
            if run.keep_samples {
                trajectory.record(system, at, energy);
                if observer.is_differentiated() {
                    let slopes = observer.tip_by_parameters(variational, at, [begin, end]);
                    trajectory.tip_by_parameters.push(slopes);
                }
            }
            let mut seen = Sample { index: self.sample, system, state: at, energy };
            if observe(&mut seen).is_break() {
                trajectory.status = Status::CutShort { time };
                trajectory.cut();
                trajectory.effort = integrator.effort();
                return Next::Over;
            }
            self.sample += 1;
        }
        if end >= self.duration {
            return Next::Over;
        }
        if run.cancel.is_requested() {
            trajectory.status = Status::CutShort { time: end };
            trajectory.cut();
            return Next::Over;
        }
        while self.stops[self.stop] <= end {
            self.stop += 1;
        }
        Next::Step(self.stops[self.stop])
    }

    /// Takes note of a step.
    /// # Errors
    /// Why the run cannot go on.
    pub fn follow(
        &mut self,
        integrator: &mut dyn Reached,
        stepped: Result<(), IntegrateError>,
    ) -> Result<(), IntegrateError> {
        let effort = integrator.effort();
        self.trajectory.effort = effort;
        let time = integrator.state().time;
        if self.run.keep_steps {
            self.trajectory.steps.push(time);
        }
        let paced = stepped.and_then(|()| match self.run.steps {
            // Explicit steps are short, and cheap.
            Steps::Adaptive if !self.is_explicit => {
                self.patience.follow(self.model, effort, time, self.duration)
            }
            _ => Ok(()),
        });
        if let Err(error) = paced {
            let error = error.blamed(self.model, integrator);
            self.trajectory.status = Status::Failed { time, reason: error.to_string() };
            return Err(error);
        }
        let follows_losses = self.run.energy && !self.model.is_conservative();
        if let Some(budget) = self.budget.as_mut().filter(|_| follows_losses) {
            budget.follow(&mut self.system, integrator, &mut self.at);
        }
        Ok(())
    }

    /// What the run leaves; with what ended it, if it could not go on.
    pub fn done(mut self, error: Option<IntegrateError>) -> Result<Trajectory, ForwardError> {
        self.trajectory.fed = self.budget.as_ref().map(Budget::fed).unwrap_or_default();
        let Self { model, run, trajectory, .. } = self;
        run.work.add(&trajectory.effort, model.edges + 1, run.sensitivities.len());
        match error {
            None => Ok(trajectory),
            Some(error) => Err(ForwardError::Integrate { error, trajectory: Box::new(trajectory) }),
        }
    }
}
