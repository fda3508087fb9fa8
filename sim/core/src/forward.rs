//! The one way to simulate: a model, where it starts, how to run it; a trajectory comes out.
//!
//! Simulation, calibration, diagnosis, prediction and sweeps all call [`forward`]. They differ in who
//! picks the parameters, the effects and the scenarios.

mod budget;
mod course;
mod many;
mod patience;
mod slopes;

use std::ops::ControlFlow;

use models::error::ModelError;
use models::model::Model;
use models::snapshot::{EffectForce, Energy, Snapshot};
use models::system::System;
use thiserror::Error;

use crate::integrate::variational::lane_order;
use crate::integrate::{self, IntegrateError, Method, State};
use crate::trajectory::Trajectory;

use course::{Course, Next};
use slopes::initial_slopes;

pub use many::{Job, forward_many};

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
    // The arm of the end body is that of the model, at every posture.
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
    let mut found = None;
    forward_many(&[Job { model, run }], &mut |_, sample| observe(sample), &mut |_, done| found = Some(done));
    found.expect("the run of each job is done")
}

/// One run by itself.
fn alone(
    model: &Model,
    run: &Run,
    observe: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Trajectory, ForwardError> {
    let order = lane_order(model, &run.sensitivities);
    // A trajectory that is to be differentiated is integrated in steps that a stage can span.
    let method = match run.method {
        Method::Auto if !order.is_empty() => Method::Rodas4,
        method => method,
    };
    let (mut course, state) = Course::new(model, run, method)?;
    let mut variational =
        if order.is_empty() { None } else { Some(initial_slopes(model, run, &state, &order)?) };
    let mut integrator =
        integrate::start(method, model, state, course.control()).map_err(ForwardError::Method)?;
    loop {
        let stop = match course.look(&mut *integrator, variational.as_ref(), observe) {
            Next::Step(stop) => stop,
            Next::Over => return course.done(None),
        };
        let stepped = integrator.advance(stop).and_then(|()| match &mut variational {
            Some(variational) => variational.follow(&mut *integrator),
            None => Ok(()),
        });
        if let Err(error) = course.follow(&mut *integrator, stepped) {
            return course.done(Some(error));
        }
    }
}
