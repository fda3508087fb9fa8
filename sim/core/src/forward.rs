//! The one way to simulate: a model, where it starts, how to run it; a trajectory comes out.
//!
//! Simulation, calibration, diagnosis, prediction and sweeps all call [`forward`]. They differ in who
//! picks the parameters, the effects and the scenarios.

mod budget;
mod history;
mod start;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use models::error::ModelError;
use models::history::History;
use models::model::Model;
use models::snapshot::{EffectForce, Energy, Snapshot};
use models::system::System;
use thiserror::Error;

use crate::integrate::variational::lane_order;
use crate::integrate::{self, Control, IntegrateError, Method, State};
use crate::observed::Observer;
use crate::point::Point;
use crate::trajectory::{Status, Trajectory};

use budget::Budget;
pub use start::{CurvePoint, Initial, start_of_tip};
use start::{initial_slopes, initial_state};

/// How to run a model.
#[derive(Clone, Debug)]
pub struct Run {
    /// Where it starts.
    pub initial: Initial,
    /// What the memory of the effects has seen before; none: it is relaxed where the rod starts.
    pub history: Option<History>,
    /// End of the run, s after release; later where the clock of what observes asks for it.
    pub duration: f64,
    /// Times at which the trajectory is sampled, s, ascending: of states since release, of the points
    /// by the clock of what observes.
    pub samples: Vec<f64>,
    /// Integrator.
    pub method: Method,
    /// Error admitted in a step, see [`Control::tolerance`].
    pub tolerance: f64,
    /// Steps of this size, s, without error control.
    pub fixed_step: Option<f64>,
    /// Steps after which to give up.
    pub most_steps: usize,
    /// Whether the trajectory keeps its samples; if not, only who observes sees them, and memory stays flat.
    pub keep_samples: bool,
    /// Whether to keep where the steps ended, so that another run can be made on them.
    pub keep_steps: bool,
    /// Whether to follow dissipated and supplied energy.
    pub energy: bool,
    /// Parameters, as indices into `theta`, by which to differentiate the path of the tip, and those
    /// of the points as they are observed.
    pub sensitivities: Vec<usize>,
    /// Further points whose paths are recorded.
    pub points: Vec<Point>,
    /// Times at which a step has to end, s, ascending. With a fixed step longer than what lies
    /// between them they are the steps, so that a run can be repeated on those of another.
    pub stops: Vec<f64>,
    /// Time between points of the [trace](Trajectory::trace) of the tip, s, which is taken beside the samples;
    /// none for no trace.
    pub trace_step: Option<f64>,
    /// Ends the run before its next step.
    pub cancel: Cancel,
}

/// A request to end a run, shared with whoever makes it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Option<Arc<AtomicBool>>);

impl Cancel {
    /// Ends runs once the flag is set.
    pub fn by(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    /// Whether the flag is set.
    pub fn is_asked(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// The integrator that a run takes unless told otherwise.
pub const DEFAULT_METHOD: Method = Method::Auto;
/// Default of [`Run::tolerance`]: on the paper's muscle the budget of energy closes to some 1e-6.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// Tolerance of fits and sweeps: the tip of the paper's muscle stays within 0.05 mm rms.
pub const FAST_TOLERANCE: f64 = 3e-5;

impl Run {
    /// A release with default settings, sampled `rate` times a second.
    pub fn release(duration: f64, rate: f64) -> Self {
        Self {
            initial: Initial::Straight,
            history: None,
            duration,
            samples: uniform(duration, rate),
            method: DEFAULT_METHOD,
            tolerance: DEFAULT_TOLERANCE,
            fixed_step: None,
            most_steps: 10_000_000,
            keep_samples: true,
            keep_steps: false,
            energy: false,
            sensitivities: Vec::new(),
            points: Vec::new(),
            stops: Vec::new(),
            trace_step: Some(1.0 / rate),
            cancel: Cancel::default(),
        }
    }

    /// The same model and run on another mesh.
    /// # Errors
    /// [`ModelError::Nodes`].
    pub fn on_mesh(&self, model: &Model, nodes: usize) -> Result<(Model, Run), ModelError> {
        Ok((model.with_nodes(nodes)?, Run { initial: self.initial.on_mesh(nodes)?, ..self.clone() }))
    }
}

/// Times from zero to `duration`, `rate` a second, both ends included where they fall on a sample.
pub fn uniform(duration: f64, rate: f64) -> Vec<f64> {
    let count = (duration * rate * (1.0 + 1e-12)).floor() as usize;
    (0..=count).map(|k| k as f64 / rate).collect()
}

/// A simulation that could not be done.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ForwardError {
    /// The model, or the equilibrium from which to start.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The method, which cannot do the model.
    #[error(transparent)]
    Method(IntegrateError),
    /// The integration; the trajectory up to there is kept.
    #[error("{error}")]
    Integrate {
        /// What happened.
        error: IntegrateError,
        /// What was integrated before.
        trajectory: Box<Trajectory>,
    },
}

/// Bending moment at the root of a system in a state, N m; positive where the rod is bent towards +z.
pub fn root_moment(system: &mut System, State { time, q, v, z }: &State) -> f64 {
    let (mut force, mut z_rate) = (vec![0.0; q.len()], vec![0.0; z.len()]);
    system.force(*time, q, v, z, &mut force, &mut z_rate);
    system.assembly.fields.bending_moment(0)
}

/// What an observer sees at each sample.
pub struct Sample<'a, 'm> {
    /// Place of the sample.
    pub index: usize,
    /// The equations, for whatever the observer wants to know.
    pub system: &'a mut System<'m>,
    /// The state.
    pub state: &'a State,
    /// Where the energy is; zero unless the run follows it.
    pub energy: Energy,
}

impl Sample<'_, '_> {
    /// Bending moment at the root, N m; a small part of what a snapshot costs.
    pub fn root_moment(&mut self) -> f64 {
        root_moment(self.system, self.state)
    }

    /// Everything that can be seen of the rod.
    pub fn snapshot(&mut self) -> Snapshot {
        let State { time, q, v, z } = self.state;
        let forces = self.system.effect_forces(*time, q, v, z);
        let (mut force, mut z_rate) = (vec![0.0; q.len()], vec![0.0; z.len()]);
        self.system.force(*time, q, v, z, &mut force, &mut z_rate);
        let n = self.system.model.edges;
        let fields = &self.system.assembly.fields;
        let tip = tip(self.system, q, v);
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

/// Position and velocity of the observed tip.
pub fn tip(system: &System, q: &[f64], v: &[f64]) -> ([f64; 2], [f64; 2]) {
    let last = q.len() - 1;
    let (sin, cos) = q[last].sin_cos();
    let arm = system.assembly.context.body.arm([cos, sin]);
    let distance = system.model.tip_distance;
    let [x, z] = [distance * cos - arm[0], distance * sin - arm[1]];
    ([q[last - 2] + x, q[last - 1] + z], [v[last - 2] - z * v[last], v[last - 1] + x * v[last]])
}

/// Simulates a model; `observe` sees every sample while the run goes on, and may break it off.
/// # Errors
/// [`ForwardError`]; a run that stops half-way carries what was integrated.
pub fn forward(
    model: &Model,
    run: &Run,
    observe: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Trajectory, ForwardError> {
    let mut system = System::new(model);
    let state = initial_state(&mut system, &run.initial, run.history)?;
    let order = lane_order(model, &run.sensitivities);
    let mut variational = match order.is_empty() {
        true => None,
        false => Some(initial_slopes(model, run, &state, &order)?),
    };
    let mut observer = Observer::new(model, run);
    let duration = run.duration.max(observer.end());
    let mut budget = run.energy.then(|| Budget::new(model));
    let follows_losses = run.energy && !model.is_conservative();
    let mut trajectory = Trajectory::new(model, run);
    let mut at = state.clone();
    let breakpoints = model.schedule.as_ref().map_or(&[][..], |schedule| schedule.breakpoints());
    let stops = breakpoints.iter().chain(&run.stops).copied();
    let mut stops: Vec<f64> = stops.filter(|t| *t > 0.0 && *t < duration).collect();
    // What is seen later changes no step before the end of the run.
    stops.extend([run.duration, duration]);
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    let control =
        Control { tolerance: run.tolerance, fixed_step: run.fixed_step, stops, most_steps: run.most_steps };
    // A trajectory that is to be differentiated is integrated in steps that a stage can span.
    let method = match run.method {
        Method::Auto if variational.is_some() => Method::Rodas4,
        method => method,
    };
    let mut stepper = integrate::start(method, model, state, control).map_err(ForwardError::Method)?;
    let mut sample = 0;
    loop {
        let (begin, end) = (stepper.step_start(), stepper.state().time);
        while let Some(instant) = observer.due(end) {
            stepper.interpolate(instant, &mut at);
            observer.see(&system, variational.as_ref(), &at, [begin, end], &mut trajectory);
        }
        while let Some(time) = trajectory.trace.due(end, run.duration) {
            stepper.interpolate(time, &mut at);
            trajectory.trace.record(&system, &at);
        }
        while sample < run.samples.len() && run.samples[sample] <= end {
            let time = run.samples[sample];
            stepper.interpolate(time, &mut at);
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
                trajectory.effort = stepper.effort();
                return Ok(trajectory);
            }
            sample += 1;
        }
        if end >= duration {
            break;
        }
        if run.cancel.is_asked() {
            trajectory.status = Status::CutShort { time: end };
            trajectory.cut();
            return Ok(trajectory);
        }
        let stepped = stepper.advance().and_then(|()| match &mut variational {
            Some(variational) => variational.follow(&mut *stepper),
            None => Ok(()),
        });
        trajectory.effort = stepper.effort();
        if run.keep_steps {
            trajectory.steps.push(stepper.state().time);
        }
        if let Err(error) = stepped {
            trajectory.status = Status::Failed { time: stepper.state().time, reason: error.to_string() };
            return Err(ForwardError::Integrate { error, trajectory: Box::new(trajectory) });
        }
        if let Some(budget) = budget.as_mut().filter(|_| follows_losses) {
            budget.follow(&mut system, &mut *stepper, &mut at);
        }
    }
    Ok(trajectory)
}
