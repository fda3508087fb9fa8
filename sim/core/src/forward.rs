//! The one way to simulate: a model, where it starts, how to run it; a trajectory comes out.
//!
//! Simulation, calibration, diagnosis, prediction and sweeps all call [`forward`]. They differ in who
//! picks the parameters, the effects and the scenarios.

mod budget;
mod patience;
mod slopes;

use std::ops::ControlFlow;

use models::error::ModelError;
use models::model::Model;
use models::snapshot::{EffectForce, Energy, Snapshot};
use models::system::System;
use thiserror::Error;

use crate::integrate::variational::lane_order;
use crate::integrate::{self, Control, IntegrateError, Method, State, Steps};
use crate::observed::Observer;
use crate::trajectory::{Fed, Status, Trajectory};

use budget::Budget;
use patience::Patience;
use slopes::initial_slopes;

pub use crate::initial::{CurvePoint, Initial};
pub use crate::run::{Cancel, DEFAULT_METHOD, DEFAULT_TOLERANCE, FAST_TOLERANCE, Run, uniform};

/// A simulation that could not be done.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ForwardError {
    /// The model, or the equilibrium from which to start.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The method, which cannot do the model.
    #[error(transparent)]
    Method(IntegrateError),
    /// An end was requested before the run was over, where only a whole run is of use.
    #[error("it was cut short at {time} s")]
    CutShort {
        /// Time up to which it was integrated, s.
        time: f64,
    },
    /// The integration; the trajectory up to there is kept.
    #[error("{error}")]
    Integrate {
        /// What happened.
        error: IntegrateError,
        /// What was integrated before.
        trajectory: Box<Trajectory>,
    },
}

/// What an observer sees at each sample.
pub struct Sample<'a> {
    /// Place of the sample.
    pub index: usize,
    /// The equations, for whatever the observer wants to know.
    pub system: &'a mut System,
    /// The state.
    pub state: &'a State,
    /// Where the energy is; zero unless the run follows it.
    pub energy: Energy,
}

impl Sample<'_> {
    /// Bending moment at the root, N m; a small part of what a snapshot costs.
    pub fn root_moment(&mut self) -> f64 {
        let State { time, q, v, z } = self.state;
        self.system.root_moment(*time, q, v, z)
    }

    /// Everything that can be seen of the rod.
    pub fn snapshot(&mut self) -> Snapshot {
        let State { time, q, v, z } = self.state;
        let forces = self.system.effect_forces(*time, q, v, z);
        let (mut force, mut z_rate) = (vec![0.0; q.len()], vec![0.0; z.len()]);
        self.system.force(*time, q, v, z, &mut force, &mut z_rate);
        let n = self.system.model.edges;
        let fields = &self.system.assembly.fields;
        let tip = self.system.observed_tip(q, v);
        Snapshot {
            time: *time,
            nodes: fields.position.clone(),
            velocities: fields.velocity.clone(),
            body_angle: q[2 * n],
            body_angular_velocity: v[2 * n],
            body_center: [q[2 * n - 2], q[2 * n - 1]],
            tip: tip.0,
            tip_velocity: tip.1,
            bending_moment: (0..=n).map(|bend| fields.bending_moment(bend)).collect(),
            effect_forces: forces.into_iter().map(|(effect, force)| EffectForce { effect, force }).collect(),
            energy: self.energy,
        }
    }
}

/// Where the observed tip starts, m.
/// # Errors
/// [`ForwardError::Model`] where the rod cannot be held as it should.
pub fn start_of_tip(model: &Model, run: &Run) -> Result<[f64; 2], ForwardError> {
    let mut system = System::new(model);
    let State { q, v, .. } = run.initial.state_of(&mut system, None)?;
    // The arm of the end body is that of the model, wherever it stands.
    Ok(system.observed_tip(&q, &v).0)
}

/// Simulates a model; `observe` sees every sample while the run goes on, and may break it off.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use efam_core::forward::{Run, forward};
/// use efam_core::trajectory::Status;
/// # use models::effects::Rod;
/// # use models::model::{Model, ModelSpec};
/// # let rod = Rod { length: 0.2, mass: 0.03, bending_stiffness: 5e-3, axial_stiffness: 500.0, diameter: 0.03,
/// #     pressure: 0.0 };
/// # let model = Model::new(&ModelSpec { nodes: 12, ..ModelSpec::of(rod) }.with(&[("rayleigh_mass.alpha", 1.0)]))?;
///
/// // Up to where the tip first passes below a tenth of a metre.
/// let path = forward(&model, &Run::release(5.0, 200.0), &mut |sample| {
///     let [_, height] = sample.snapshot().tip;
///     if height < -0.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// })?;
/// assert!(matches!(path.status, Status::CutShort { time } if time < 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`ForwardError`]; a run that stops half-way carries what was integrated.
pub fn forward(
    model: &Model,
    run: &Run,
    observe: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Trajectory, ForwardError> {
    let done = integrated(model, run, observe);
    let effort = match &done {
        Ok(trajectory) => Some(trajectory.effort),
        Err(ForwardError::Integrate { trajectory, .. }) => Some(trajectory.effort),
        Err(_) => None,
    };
    effort.iter().for_each(|effort| run.work.add(effort, model.edges + 1, run.sensitivities.len()));
    done
}

/// The run, not yet counted.
fn integrated(
    model: &Model,
    run: &Run,
    observe: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Trajectory, ForwardError> {
    let mut system = System::new(model);
    let state = run.initial.state_of(&mut system, run.history)?;
    let order = lane_order(model, &run.sensitivities);
    let mut variational =
        if order.is_empty() { None } else { Some(initial_slopes(model, run, &state, &order)?) };
    let mut observer = Observer::new(model, run);
    let duration = run.duration.max(observer.end());
    let mut budget = run.energy.then(|| Budget::new(model));
    let follows_losses = run.energy && !model.is_conservative();
    let mut trajectory = Trajectory::new(model, run);
    let mut at = state.clone();
    let breakpoints = model.schedule.as_ref().map_or(&[][..], |schedule| schedule.breakpoints());
    let mut stops: Vec<f64> = breakpoints.iter().copied().filter(|t| *t > 0.0 && *t < duration).collect();
    // What is seen later changes no step before the end of the run.
    stops.extend([run.duration, duration]);
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    let control = Control {
        tolerance: run.tolerance,
        steps: run.steps.clone(),
        most_steps: run.most_steps,
        first_step: None,
    };
    // A trajectory that is to be differentiated is integrated in steps that a stage can span.
    let method = match run.method {
        Method::Auto if variational.is_some() => Method::Rodas4,
        method => method,
    };
    let mut integrator = integrate::start(method, model, state, control).map_err(ForwardError::Method)?;
    let (mut sample, mut stop) = (0, 0);
    let mut patience = Patience::new(run.most_steps);
    loop {
        let (begin, end) = (integrator.step_start(), integrator.state().time);
        while let Some(instant) = observer.due(end) {
            integrator.interpolate(instant, &mut at);
            observer.see(&system, variational.as_ref(), &at, [begin, end], &mut trajectory);
        }
        while let Some(time) = trajectory.trace.due(end, run.duration) {
            integrator.interpolate(time, &mut at);
            trajectory.trace.record(&system, &at);
        }
        while sample < run.samples.len() && run.samples[sample] <= end {
            let time = run.samples[sample];
            integrator.interpolate(time, &mut at);
            let energy = match &budget {
                Some(budget) => budget.at(&mut system, &at, begin, end),
                None => Energy::default(),
            };
            if run.keep_samples {
                trajectory.record(&system, &at, energy);
                if observer.is_differentiated() {
                    let slopes = observer.tip_by_parameters(variational.as_ref(), &at, [begin, end]);
                    trajectory.tip_by_parameters.push(slopes);
                }
            }
            let mut seen = Sample { index: sample, system: &mut system, state: &at, energy };
            if observe(&mut seen).is_break() {
                trajectory.status = Status::CutShort { time };
                trajectory.cut();
                trajectory.effort = integrator.effort();
                trajectory.fed = fed(&budget);
                return Ok(trajectory);
            }
            sample += 1;
        }
        if end >= duration {
            break;
        }
        if run.cancel.is_requested() {
            trajectory.status = Status::CutShort { time: end };
            trajectory.cut();
            trajectory.fed = fed(&budget);
            return Ok(trajectory);
        }
        while stops[stop] <= end {
            stop += 1;
        }
        let stepped = integrator.advance(stops[stop]).and_then(|()| match &mut variational {
            Some(variational) => variational.follow(&mut *integrator),
            None => Ok(()),
        });
        trajectory.effort = integrator.effort();
        if run.keep_steps {
            trajectory.steps.push(integrator.state().time);
        }
        let paced = stepped.and_then(|()| match run.steps {
            // Explicit steps are short, and cheap.
            Steps::Adaptive if method.of(model) != Method::Verlet => {
                patience.follow(model, trajectory.effort, integrator.state().time, duration)
            }
            _ => Ok(()),
        });
        if let Err(error) = paced {
            let error = error.blamed(model, &mut *integrator);
            trajectory.fed = fed(&budget);
            trajectory.status = Status::Failed { time: integrator.state().time, reason: error.to_string() };
            return Err(ForwardError::Integrate { error, trajectory: Box::new(trajectory) });
        }
        if let Some(budget) = budget.as_mut().filter(|_| follows_losses) {
            budget.follow(&mut system, &mut *integrator, &mut at);
        }
    }
    trajectory.fed = fed(&budget);
    Ok(trajectory)
}

fn fed(budget: &Option<Budget>) -> Vec<Fed> {
    budget.as_ref().map(Budget::fed).unwrap_or_default()
}
