//! A rod that is steered while it swings: one step after another, parameters and state changed between them.

use std::sync::Arc;

use models::effects::Rod;
use models::error::ModelError;
use models::model::{Model, Schedule};
use models::snapshot::{Energy, Snapshot};
use models::system::System;
use thiserror::Error;

use crate::forward::Sample;
use crate::integrate::{Control, Effort, IntegrateError, Integrator, Method, State, Steps, Stiff, start_own};

/// A model in the middle of its motion.
///
/// [`forward`](crate::forward::forward) runs a model from a start to an end that are known before. A `Stepper` is for
/// those who do not know what comes next: a controller that sets the pressure, a page with sliders, an agent that
/// learns. It owns its model, may go to another thread, and a [`step`](Self::step) allocates nothing.
///
/// ```
/// use efam_core::initial::Initial;
/// use efam_core::stepper::Stepper;
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
///
/// let rod = Rod {
///     length: 0.2,
///     mass: 0.03,
///     bending_stiffness: 5e-3,
///     axial_stiffness: 500.0,
///     diameter: 0.03,
///     pressure: 0.0,
/// };
/// let model = Model::new(&ModelSpec::of(rod).with(&[("rayleigh_mass.alpha", 1.0)]))?;
/// let mut stepper = Stepper::new(&model, Initial::Straight.state(&model)?)?;
/// for k in 1..=50 {
///     stepper.step_to(0.01 * f64::from(k))?;
/// }
/// let before = stepper.tip();
/// stepper.set("rod.bending_stiffness", 8e-3)?;
/// stepper.set("payload.mass", 0.01)?;
/// assert_eq!(stepper.state().time, 0.5);
/// assert!((stepper.tip().position[1] - before.position[1]).abs() < 1e-12, "what changes moves nothing by itself");
/// stepper.step(0.01)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Stepper {
    integrator: Box<dyn Integrator + Send>,
    /// The same equations, to be read between steps.
    system: System,
    /// Times at which a rate of the pressure jumps, s.
    kinks: Vec<f64>,
    method: Method,
    control: Control,
    /// What it cost before the integrator was last set up.
    before: Effort,
}

/// The observed tip at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Position in W, m.
    pub position: [f64; 2],
    /// Velocity, m/s.
    pub velocity: [f64; 2],
}

/// A change that cannot be: the stepper stays as it was.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ChangeError {
    /// A parameter that the model does not have, or a value that it may not have.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A method that cannot do the changed model.
    #[error(transparent)]
    Method(#[from] IntegrateError),
}

impl Stepper {
    /// Starts in a state, with the method that suits the model and the usual tolerance.
    /// # Errors
    /// As [`Stepper::with`].
    pub fn new(model: &Model, state: State) -> Result<Self, IntegrateError> {
        Self::with(model, state, Method::Auto, Control::default())
    }

    /// Starts in a state, with one of our own methods. [`Control::most_steps`] counts anew in each call of
    /// [`step`](Self::step).
    /// # Errors
    /// [`IntegrateError::Explicit`] for Verlet and a model that it cannot do; [`IntegrateError::WithoutDiffsol`] for
    /// methods that are not ours.
    /// # Panics
    /// If the state has not the model's shape.
    pub fn with(
        model: &Model,
        state: State,
        method: Method,
        control: Control,
    ) -> Result<Self, IntegrateError> {
        let integrator = integrator(model, state, method, &control)?;
        let (system, kinks) = (System::new(model), model.kinks());
        Ok(Self { integrator, system, kinks, method, control, before: Effort::default() })
    }

    /// Goes on for a duration, s; see [`step_to`](Self::step_to).
    /// # Errors
    /// As [`step_to`](Self::step_to).
    /// # Panics
    /// If the duration is negative or no number.
    pub fn step(&mut self, duration: f64) -> Result<&State, IntegrateError> {
        self.step_to(self.state().time + duration)
    }

    /// Goes on up to a time, s, and ends there: the integrator makes as many steps of its own as the tolerance
    /// needs.
    /// # Errors
    /// [`IntegrateError`]; the time says how far it came. [`set_state`](Self::set_state) begins anew.
    /// # Panics
    /// If the time is past or no number.
    pub fn step_to(&mut self, end: f64) -> Result<&State, IntegrateError> {
        let now = self.state().time;
        assert!(end >= now && end.is_finite(), "a step goes forwards in time, from {now} s, not to {end} s");
        let first = self.integrator.effort().steps;
        loop {
            let time = self.state().time;
            if time >= end {
                return Ok(self.integrator.state());
            }
            let steps = self.integrator.effort().steps - first;
            if steps >= self.control.most_steps {
                return Err(IntegrateError::TooManySteps { time, steps, stiff: Stiff::default() });
            }
            let stop = self.stop_after(time, end);
            if let Err(error) = self.integrator.advance(stop) {
                return Err(error.blamed(&self.system.model, &mut *self.integrator));
            }
        }
    }

    /// The next time at which a rate of the pressure jumps, or the end.
    fn stop_after(&self, time: f64, end: f64) -> f64 {
        let kinks = &self.kinks;
        kinks.get(kinks.partition_point(|kink| *kink <= time)).map_or(end, |kink| kink.min(end))
    }

    /// The present state.
    pub fn state(&self) -> &State {
        self.integrator.state()
    }

    /// Goes on from another state, time included.
    /// # Panics
    /// If the state has not the model's shape.
    pub fn set_state(&mut self, state: State) {
        let model = self.system.model.clone();
        self.restart(&model, state).expect("the method has done this model before");
    }

    /// The model as it is now.
    pub fn model(&self) -> &Model {
        &self.system.model
    }

    /// Sets a parameter, SI, by its path such as `payload.mass` or `rod.length`; see [`set_all`](Self::set_all).
    /// # Errors
    /// [`ChangeError`].
    pub fn set(&mut self, path: &str, value: f64) -> Result<(), ChangeError> {
        self.set_all(&[(path, value)])
    }

    /// Sets parameters, SI, all or none, by their paths; those of effects with or without `effects.` before it. The rod
    /// keeps its place and velocity, and its memory; energy is not kept.
    ///
    /// A value jumps. Many small jumps come to a value that changes, but for damping: it resists a rest length that
    /// changes at a rate, see [`models::pressure`], and does not see one that jumps. What is set to the value that it
    /// has costs nothing.
    /// # Errors
    /// [`ChangeError`].
    pub fn set_all(&mut self, values: &[(&str, f64)]) -> Result<(), ChangeError> {
        let mut model = self.system.model.clone();
        for (path, value) in values {
            let is_known = model.index(path).is_ok();
            let of_effect = format!("effects.{path}");
            model.set(if is_known { path } else { &of_effect }, *value)?;
        }
        if model.theta == self.system.model.theta {
            return Ok(());
        }
        let State { time, q, v, z } = self.integrator.state();
        let posture = self.system.assembly.posture(q, v);
        let (q, v) = System::new(&model).assembly.coordinates(&posture);
        let state = State { time: *time, q, v, z: z.clone() };
        Ok(self.restart(&model, state)?)
    }

    /// Makes it another rod, such as the muscle at another pressure; see [`set_all`](Self::set_all). An axial stiffness that
    /// is not known stays as it is.
    /// # Errors
    /// [`ChangeError`].
    pub fn set_rod(&mut self, rod: &Rod<f64>) -> Result<(), ChangeError> {
        let diameter = if rod.diameter.is_nan() { 0.0 } else { rod.diameter };
        let own = self.system.model.rod().axial_stiffness;
        let axial_stiffness = if rod.axial_stiffness.is_nan() { own } else { rod.axial_stiffness };
        self.set_all(&[
            ("rod.length", rod.length),
            ("rod.mass", rod.mass),
            ("rod.bending_stiffness", rod.bending_stiffness),
            ("rod.axial_stiffness", axial_stiffness),
            ("rod.diameter", diameter),
            ("rod.pressure", rod.pressure),
        ])
    }

    /// Gives the rod a pressure over time, such as the commands of a regulator before a
    /// [pressure line](models::pressure::PressureSchedule::steered). It keeps its place and velocity.
    /// # Errors
    /// [`ChangeError`].
    pub fn set_schedule(&mut self, schedule: Arc<dyn Schedule>) -> Result<(), ChangeError> {
        let mut model = self.system.model.clone();
        model.schedule = Some(schedule);
        let state = self.integrator.state().clone();
        Ok(self.restart(&model, state)?)
    }

    fn restart(&mut self, model: &Model, state: State) -> Result<(), IntegrateError> {
        let mut control = self.control.clone();
        if control.steps == Steps::Adaptive {
            control.first_step = Some(self.integrator.next_step());
        }
        let before = self.effort();
        self.integrator = integrator(model, state, self.method, &control)?;
        (self.system, self.kinks) = (System::new(model), model.kinks());
        self.before = before;
        Ok(())
    }

    /// The observed tip.
    pub fn tip(&self) -> Tip {
        let State { q, v, .. } = self.integrator.state();
        let (position, velocity) = self.system.observed_tip(q, v);
        Tip { position, velocity }
    }

    /// Node positions in W, m, shape `[N+1]`.
    pub fn nodes(&mut self) -> &[[f64; 2]] {
        let State { time, q, v, .. } = self.integrator.state();
        self.system.assembly.place(&self.system.model, *time, q, v);
        &self.system.assembly.fields.position
    }

    /// Kinetic, elastic and potential energy; what is dissipated and supplied is not followed.
    pub fn energy(&mut self) -> Energy {
        let State { time, q, v, z } = self.integrator.state();
        let (kinetic, elastic, potential) = self.system.energy(*time, q, v, z);
        Energy { kinetic, elastic, potential, ..Energy::default() }
    }

    /// Everything that can be seen of the rod.
    pub fn snapshot(&mut self) -> Snapshot {
        let energy = self.energy();
        let state = self.integrator.state();
        Sample { index: 0, system: &mut self.system, state, energy }.snapshot()
    }

    /// What it has cost so far.
    pub fn effort(&self) -> Effort {
        self.before + self.integrator.effort()
    }
}

fn integrator(
    model: &Model,
    state: State,
    method: Method,
    control: &Control,
) -> Result<Box<dyn Integrator + Send>, IntegrateError> {
    let State { q, v, z, .. } = &state;
    let (found, due) = ([q.len(), v.len(), z.len()], [model.dof(), model.dof(), model.memory()]);
    assert_eq!(found, due, "coordinates, velocities and memory have the model's shape");
    start_own(method, model, state, Control { most_steps: usize::MAX, ..control.clone() })
}
