//! Integrators of the equations of motion behind one seam: [`Integrator`].

#[cfg(feature = "diffsol")]
mod diffsol;
mod rosenbrock;
pub(crate) mod side_by_side;
mod span;
mod stages;
mod stride;
pub mod tableau;
pub mod variational;
mod verlet;

use models::fault::{At, Fault, fastest, find};
use models::model::Model;
use thiserror::Error;

#[cfg(feature = "diffsol")]
use diffsol::Implicit;
use rosenbrock::Rosenbrock;
use verlet::Verlet;

/// Coordinates, velocities and memory at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Time since release, s.
    pub time: f64,
    /// Generalised coordinates, shape `[2N+1]`.
    pub q: Vec<f64>,
    /// Their rates.
    pub v: Vec<f64>,
    /// Memory of the effects.
    pub z: Vec<f64>,
}

/// How long the steps are.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Steps {
    /// As long as the error admits.
    #[default]
    Adaptive,
    /// Of this size, s, without error control: for convergence studies.
    Fixed(f64),
    /// Those of another run, by the times at which they end, s, ascending. A step that the model cannot resolve
    /// is halved until it can; steps as long as the error admits then lead to its end.
    Given(Vec<f64>),
    /// The same, none of them halved: for a difference of two runs, in which a step that only one of them halves would be
    /// a jump.
    Repeated(Vec<f64>),
}

impl Steps {
    /// Their size, s, if all have the same.
    pub fn fixed(&self) -> Option<f64> {
        match self {
            Steps::Fixed(step) => Some(*step),
            Steps::Adaptive | Steps::Given(_) | Steps::Repeated(_) => None,
        }
    }

    /// The same without ends from a time on, s.
    pub fn ending_before(mut self, time: f64) -> Self {
        if let Steps::Given(ends) | Steps::Repeated(ends) = &mut self {
            ends.retain(|end| *end < time);
        }
        self
    }

    /// Where a step that begins at a time has to end at the latest, s: at the stop, or at the end of a given step
    /// before it.
    fn stop_after(&self, time: f64, stop: f64) -> f64 {
        let (Steps::Given(ends) | Steps::Repeated(ends)) = self else { return stop };
        ends.get(ends.partition_point(|end| *end <= time)).map_or(stop, |end| end.min(stop))
    }
}

/// How accurately.
#[derive(Clone, Debug)]
pub struct Control {
    /// Error admitted in a step, relative to the rod's length and to the speed of its fall: it chooses the size of
    /// adaptive steps, says which of the given ones are halved, and how well an implicit method solves any.
    pub tolerance: f64,
    /// How long the steps are.
    pub steps: Steps,
    /// Steps after which to give up.
    pub most_steps: usize,
    /// Size to begin with where steps are adaptive, s; none for the method's own.
    pub first_step: Option<f64>,
}

/// Default of [`Control::tolerance`]: on the paper's muscle the budget of energy closes to some 1e-6.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// Default of [`Control::most_steps`].
pub const DEFAULT_MOST_STEPS: usize = 10_000_000;

impl Default for Control {
    fn default() -> Self {
        Self {
            tolerance: DEFAULT_TOLERANCE,
            steps: Steps::Adaptive,
            most_steps: DEFAULT_MOST_STEPS,
            first_step: None,
        }
    }
}

/// Effort of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Effort {
    /// Accepted steps.
    pub steps: usize,
    /// Steps tried and repeated with a smaller size.
    pub rejected: usize,
    /// Evaluations of the forces.
    pub evaluations: usize,
    /// Evaluations of the tangents.
    pub linearisations: usize,
    /// Factorizations of the step's matrix.
    pub factorizations: usize,
    /// Newton iterations, where the method has any.
    pub newton_iterations: usize,
}

impl std::ops::Add for Effort {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            rejected: self.rejected + other.rejected,
            evaluations: self.evaluations + other.evaluations,
            linearisations: self.linearisations + other.linearisations,
            factorizations: self.factorizations + other.factorizations,
            newton_iterations: self.newton_iterations + other.newton_iterations,
        }
    }
}

/// An integrator in the middle of a run.
pub trait Integrator: Reached {
    /// Makes one step, which ends at the stop, s, or before it; at the stop it does nothing. The solution may have a
    /// kink there.
    /// # Errors
    /// [`IntegrateError`] with the time at which it gave up.
    fn advance(&mut self, stop: f64) -> Result<(), IntegrateError>;
}

/// How far a run has come: its last step.
pub trait Reached {
    /// The state at the end of the last step.
    fn state(&self) -> &State;
    /// Where the last step began, s.
    fn step_start(&self) -> f64;
    /// The state at a time within the last step, written into one of the same size, such as a clone of
    /// [`Reached::state`].
    fn interpolate(&mut self, time: f64, state: &mut State);
    /// Of that state the coordinates and velocities of the end body, if no more is to be had for less.
    fn interpolate_end(&mut self, time: f64, state: &mut State) {
        self.interpolate(time, state);
    }
    /// Size that the next step would have, s.
    fn next_step(&self) -> f64;
    /// What the run has cost so far.
    fn effort(&self) -> Effort;
}

/// A method of integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// [`Method::Verlet`] for a model that loses no energy, [`Method::Rodas4`] for all others.
    Auto,
    /// Explicit, symplectic, second order: ours, for models that lose no energy.
    Verlet,
    /// Linearly implicit, fourth order, six stages, L-stable: ours.
    Rodas4,
    /// Implicit, second order: diffsol's.
    TrBdf2,
    /// Implicit, third order: diffsol's.
    Esdirk34,
}

/// A run that could not go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum IntegrateError {
    /// The step shrank to nothing.
    #[error(
        "the step shrank to {step:.1e} s at t = {time:.4} s near node {node}{stiff}; try a stiffer rod, more damping, or a looser tolerance"
    )]
    StepTooSmall {
        /// Time, s.
        time: f64,
        /// Step, s.
        step: f64,
        /// Node with the largest error.
        node: usize,
        /// What makes the steps short.
        stiff: Stiff,
    },
    /// A fixed step that the method cannot take: the explicit one is not stable in it, or its error is as large as the rod.
    #[error(
        "a step of {step:.1e} s is too long at t = {time:.4} s near node {node}; try a fixed_step of half of it, or none"
    )]
    StepTooLong {
        /// Time, s.
        time: f64,
        /// Step, s.
        step: f64,
        /// Node where the force changed most, or with the largest error.
        node: usize,
    },
    /// A state that is not a number.
    #[error("the state is not a number at t = {time:.4} s near node {node}; try a smaller step or tolerance")]
    NotFinite {
        /// Time, s.
        time: f64,
        /// Node where it was found first.
        node: usize,
    },
    /// Newton's method did not converge.
    #[error(
        "Newton stalled at t = {time:.4} s with a step of {step:.1e} s; try method = \"rodas4\", or a looser tolerance"
    )]
    Stalled {
        /// Time, s.
        time: f64,
        /// Step, s.
        step: f64,
    },
    /// Verlet for a model with forces that depend on velocity, memory or time.
    #[error(
        "integrator.method = \"verlet\" is for models without damping, memory or a changing pressure; take \"auto\""
    )]
    Explicit,
    /// A method of diffsol in a program that was built without it.
    #[error(
        "integrator.method: tr_bdf2 and esdirk34 need the feature diffsol, which this program was built without; take \"auto\", or build with --features diffsol"
    )]
    WithoutDiffsol,
    /// More steps than admitted.
    #[error(
        "{steps} steps brought the run only to t = {time:.4} s{stiff}; raise integrator.most_steps, loosen the tolerance, or give the rod some damping"
    )]
    TooManySteps {
        /// Time, s.
        time: f64,
        /// Steps made.
        steps: usize,
        /// What makes the steps short.
        stiff: Stiff,
    },
    /// Steps that become so short that the run comes to no end.
    #[error(
        "the steps become too short: {steps} of them brought the run from t = {:.4} s only to t = {time:.4} s{stiff}, while its slowest swing takes {period:.2} s; try to weaken what is stiff there, more damping or a looser tolerance, or raise integrator.most_steps to a hundred times as many", time - spanned
    )]
    TooSlow {
        /// Time, s.
        time: f64,
        /// Attempts at steps, of which the last ones are meant.
        steps: usize,
        /// Time that these spanned, s.
        spanned: f64,
        /// Period of the slowest mode, s.
        period: f64,
        /// What makes the steps short.
        stiff: Stiff,
    },
    /// A law that gives no number.
    #[error("{0}")]
    Law(Fault),
}

/// The effect whose force changes most where steps become short, if it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stiff(pub Option<&'static str>);

impl std::fmt::Display for Stiff {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        self.0.map_or(Ok(()), |effect| write!(f, ", where the force of effects.{effect} changes fastest"))
    }
}

/// Times after a state at which its motion is looked at for a law that gives no number there, s: as short as the steps
/// that lead there.
const AHEAD: [f64; 6] = [0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8];

impl IntegrateError {
    /// The same error with what is to blame for it: a law that gives no number, or the effect that changes fastest.
    pub fn blamed(mut self, model: &Model, integrator: &mut dyn Reached) -> Self {
        if matches!(self, Self::Explicit | Self::WithoutDiffsol) {
            return self;
        }
        let after = integrator.state().clone();
        let mut ahead = after.clone();
        let tried = integrator.next_step().clamp(0.0, 1e-2);
        for h in AHEAD.into_iter().chain([0.1, 0.3, 1.0].map(|share| share * tried)) {
            for (ahead, (q, v)) in ahead.q.iter_mut().zip(after.q.iter().zip(&after.v)) {
                *ahead = q + h * v;
            }
            let fault = find(model, at(&State { time: after.time + h, ..ahead.clone() }));
            // In a step that is too long, laws of the catalogue see what no rod does.
            if let Some(fault) =
                fault.filter(|fault| fault.is_written || !matches!(self, Self::StepTooLong { .. }))
            {
                return Self::Law(fault);
            }
        }
        if let Self::StepTooSmall { stiff, .. }
        | Self::TooManySteps { stiff, .. }
        | Self::TooSlow { stiff, .. } = &mut self
            && integrator.step_start() < after.time
        {
            let mut before = after.clone();
            integrator.interpolate(integrator.step_start(), &mut before);
            stiff.0 = fastest(model, at(&before), at(&after));
        }
        self
    }
}

fn at(State { time, q, v, z }: &State) -> At<'_> {
    At { time: *time, q, v, z }
}

impl Method {
    /// The method that a run of the model takes.
    pub fn of(self, model: &Model) -> Self {
        match self {
            Method::Auto if model.is_conservative() => Method::Verlet,
            Method::Auto => Method::Rodas4,
            other => other,
        }
    }
}

/// Starts an integrator at a state.
/// # Errors
/// [`IntegrateError::Explicit`] for Verlet and a model that it cannot do, [`IntegrateError::WithoutDiffsol`].
pub fn start(
    method: Method,
    model: &Model,
    state: State,
    control: Control,
) -> Result<Box<dyn Integrator>, IntegrateError> {
    match method.of(model) {
        #[cfg(feature = "diffsol")]
        Method::TrBdf2 => diffsol::start(Implicit::TrBdf2, model, state, control),
        #[cfg(feature = "diffsol")]
        Method::Esdirk34 => diffsol::start(Implicit::Esdirk34, model, state, control),
        own => Ok(start_own(own, model, state, control)?),
    }
}

/// Starts one of our own integrators, which may go to another thread.
/// # Errors
/// As [`start`]; those of diffsol are none of ours.
pub fn start_own(
    method: Method,
    model: &Model,
    state: State,
    control: Control,
) -> Result<Box<dyn Integrator + Send>, IntegrateError> {
    match method.of(model) {
        Method::Verlet if !model.is_conservative() => Err(IntegrateError::Explicit),
        Method::Verlet => Ok(Box::new(Verlet::new(model, state, control))),
        Method::TrBdf2 | Method::Esdirk34 => Err(IntegrateError::WithoutDiffsol),
        Method::Auto | Method::Rodas4 => {
            Ok(Box::new(Rosenbrock::new(&tableau::RODAS4, model, state, control)))
        }
    }
}
