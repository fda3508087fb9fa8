//! TR-BDF2 and ESDIRK34 of the crate diffsol behind [`Integrator`]: slower than our own methods, and
//! independent of them.
//!
//! diffsol's solver borrows its problem, and an [`Integrator`] must own both. An `async` block may hold
//! a value and a borrow of it: [`Run`] polls one each time it wants something, and the block waits
//! for the next [`Request`] in between. Nothing else here is asynchronous.

mod equations;

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use ::diffsol::error::OdeSolverError;
use ::diffsol::{
    DiffsolError, FaerVec, InitialConditionSolverOptions, NonLinearOp, OdeSolverMethod, OdeSolverOptions,
    OdeSolverProblem, OdeSolverState, OdeSolverStopReason, RkState, Sdirk, Tableau, Vector,
};
use models::model::Model;

use self::equations::{BandSolver, Equations, parts};
use super::{Control, Effort, IntegrateError, Integrator, Reached, State, Steps, Stiff};

/// Speed to which errors of velocities are compared, in rod lengths a second. A rod of 0.2 m falls
/// at some 7: four times that spares steps which follow the velocity of small fast waves and leave
/// the path as it is. At tolerance 1e-5 the path of the muscle is then good to 0.04 mm.
const LENGTHS_PER_SECOND: f64 = 30.0;
/// Step sizes below this one are no steps, s.
const SMALLEST_STEP: f64 = 1e-13;
/// Tolerance at a fixed step: no error reaches it.
const ANY_ERROR: f64 = 1e6;
/// Share of the tolerance up to which a stage is solved. A tenth of this costs a third more, and
/// the error stays.
const STAGE_SHARE: f64 = 0.5;
/// Steps for which a tangent is kept. Ours is cheap, an iteration saved is worth more.
const TANGENT_STEPS: usize = 5;

/// A method of diffsol that survives this problem.
#[derive(Clone, Copy, Debug)]
pub enum Implicit {
    /// Second order.
    TrBdf2,
    /// Third order.
    Esdirk34,
}

/// Starts a method of diffsol at a state.
/// # Errors
/// [`IntegrateError::NotFinite`] if the forces at the start are not numbers.
pub fn start(
    method: Implicit,
    model: &Model,
    state: State,
    control: Control,
) -> Result<Box<dyn Integrator>, IntegrateError> {
    let tableau = match method {
        Implicit::TrBdf2 => Tableau::tr_bdf2(),
        Implicit::Esdirk34 => Tableau::esdirk34(),
    };
    let desk = Rc::new(Desk { answer: RefCell::new(state.clone()), ..Desk::default() });
    let drive = Box::pin(drive(tableau, model.clone(), state.clone(), control, desk.clone()));
    let mut run = Run { drive, desk, step_start: state.time, state, failure: None };
    run.poll()?;
    Ok(Box::new(run))
}

/// What a [`Run`] wants of its solver.
#[derive(Clone, Copy)]
enum Request {
    /// One step, up to a stop, s.
    Step(f64),
    State(f64),
}

/// Where requests and answers lie.
#[derive(Default)]
struct Desk {
    request: Cell<Option<Request>>,
    answer: RefCell<State>,
    effort: Cell<Effort>,
    next_step: Cell<f64>,
}

struct Run {
    drive: Pin<Box<dyn Future<Output = Result<Infallible, IntegrateError>>>>,
    desk: Rc<Desk>,
    step_start: f64,
    state: State,
    failure: Option<IntegrateError>,
}

impl Run {
    fn poll(&mut self) -> Result<(), IntegrateError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        match self.drive.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Pending => Ok(()),
            Poll::Ready(Err(failure)) => {
                self.failure = Some(failure.clone());
                Err(failure)
            }
        }
    }
}

impl Integrator for Run {
    fn advance(&mut self, stop: f64) -> Result<(), IntegrateError> {
        self.desk.request.set(Some(Request::Step(stop)));
        self.poll()?;
        let answer = self.desk.answer.borrow();
        if answer.time > self.state.time {
            self.step_start = self.state.time;
            copy(&answer, &mut self.state);
        }
        Ok(())
    }
}

impl Reached for Run {
    fn state(&self) -> &State {
        &self.state
    }

    fn step_start(&self) -> f64 {
        self.step_start
    }

    fn interpolate(&mut self, time: f64, state: &mut State) {
        self.desk.request.set(Some(Request::State(time)));
        // After a failure the solver is gone: only the last state remains.
        match self.poll() {
            Ok(()) => copy(&self.desk.answer.borrow(), state),
            Err(_) => copy(&self.state, state),
        }
    }

    fn next_step(&self) -> f64 {
        self.desk.next_step.get()
    }

    fn effort(&self) -> Effort {
        self.desk.effort.get()
    }
}

fn copy(from: &State, to: &mut State) {
    to.time = from.time;
    to.q.clone_from(&from.q);
    to.v.clone_from(&from.v);
    to.z.clone_from(&from.z);
}

/// Answers requests until an error ends it.
async fn drive(
    tableau: Tableau<f64>,
    model: Model,
    start: State,
    control: Control,
    desk: Rc<Desk>,
) -> Result<Infallible, IntegrateError> {
    let problem = problem(&model, &start, &control);
    let mut pilot = Pilot::new(&problem, tableau, control)?;
    let mut y = FaerVec::zeros(problem.atol.len(), Default::default());
    loop {
        let wanted = poll_fn(|_| desk.request.take().map_or(Poll::Pending, Poll::Ready)).await;
        match wanted {
            Request::Step(stop) => {
                pilot.step(stop)?;
                pilot.write(pilot.time, pilot.solver.state().y, &mut desk.answer.borrow_mut());
                desk.effort.set(pilot.effort());
                desk.next_step.set(pilot.solver.state().h);
            }
            Request::State(time) => {
                pilot.interpolate(time, &mut y);
                pilot.write(time, &y, &mut desk.answer.borrow_mut());
            }
        }
    }
}

fn problem(model: &Model, start: &State, control: &Control) -> OdeSolverProblem<Equations> {
    let equations = Equations::new(model, start);
    let tolerance = if control.steps == Steps::Adaptive { control.tolerance } else { ANY_ERROR };
    let length = model.rod().length;
    let speed = LENGTHS_PER_SECOND * length;
    let dof = model.dof();
    let mut atol = vec![tolerance * length; dof];
    atol.extend(vec![tolerance * speed; dof]);
    atol[dof - 1] = tolerance;
    atol[2 * dof - 1] = tolerance * LENGTHS_PER_SECOND;
    atol.extend(vec![tolerance / length; model.memory()]);
    OdeSolverProblem {
        eqn: equations,
        rtol: tolerance,
        atol: FaerVec::from_vec(atol, Default::default()),
        t0: start.time,
        h0: control.first_step.unwrap_or(1.0),
        integrate_out: false,
        sens_rtol: None,
        sens_atol: None,
        out_rtol: None,
        out_atol: None,
        param_rtol: None,
        param_atol: None,
        ic_options: InitialConditionSolverOptions::default(),
        ode_options: OdeSolverOptions {
            // Counted over the whole run, not in a row: the default of 50 ends every long run.
            max_nonlinear_solver_failures: 1_000_000,
            min_timestep: SMALLEST_STEP,
            nonlinear_solver_tolerance: STAGE_SHARE * control.tolerance / tolerance,
            update_jacobian_after_steps: TANGENT_STEPS,
            update_rhs_jacobian_after_steps: TANGENT_STEPS,
            ..OdeSolverOptions::default()
        },
    }
}

type Solver<'p> = Sdirk<'p, Equations, BandSolver>;

/// diffsol's solver between two stops.
struct Pilot<'p> {
    problem: &'p OdeSolverProblem<Equations>,
    solver: Solver<'p>,
    control: Control,
    time: f64,
    /// The last step that no stop cut short, s.
    stride: f64,
    at_stop: bool,
}

impl<'p> Pilot<'p> {
    fn new(
        problem: &'p OdeSolverProblem<Equations>,
        tableau: Tableau<f64>,
        control: Control,
    ) -> Result<Self, IntegrateError> {
        let time = problem.t0;
        let stuck = |_| IntegrateError::Stalled { time, step: 0.0 };
        let state = RkState::new(problem, tableau.order()).map_err(stuck)?;
        finite(problem, time, state.as_ref().dy)?;
        let solver = Sdirk::new(problem, state, tableau, BandSolver::new(&problem.eqn)).map_err(stuck)?;
        Ok(Self { problem, solver, control, time, stride: 0.0, at_stop: false })
    }

    fn step(&mut self, stop: f64) -> Result<(), IntegrateError> {
        let stop = self.control.steps.stop_after(self.time, stop);
        // diffsol takes times this close for one.
        if stop <= self.time + 1e-12 * (1.0 + self.time.abs()) {
            if stop > self.time {
                (self.time, self.at_stop) = (stop, true);
            }
            return Ok(());
        }
        let before = self.solver.get_statistics().clone();
        if before.number_of_steps >= self.control.most_steps {
            return Err(IntegrateError::TooManySteps {
                time: self.time,
                steps: before.number_of_steps,
                stiff: Stiff::default(),
            });
        }
        self.problem.eqn.begin_step(self.time);
        if self.at_stop {
            self.leave_stop();
        }
        let mut target = stop;
        if self.control.steps != Steps::Adaptive {
            if let Some(step) =
                self.control.steps.fixed().filter(|step| self.time + step * (1.0 + 1e-6) < stop)
            {
                target = self.time + step;
            }
            *self.solver.state_mut().h = target - self.time;
        }
        let tried = self.solver.state().h;
        let reason = self.solver.set_stop_time(target).and_then(|()| self.solver.step());
        let reason =
            reason.map_err(|error| self.explain(&error, tried, before.number_of_nonlinear_solver_fails))?;
        let state = self.solver.state();
        finite(self.problem, state.t, state.y)?;
        let step = state.t - self.time;
        if matches!(reason, OdeSolverStopReason::TstopReached) {
            self.time = target;
            self.at_stop = target == stop;
        } else if self.control.steps != Steps::Adaptive {
            return Err(IntegrateError::Stalled { time: self.time, step: tried });
        } else {
            self.time = state.t;
            self.stride = step;
        }
        Ok(())
    }

    /// Goes on after a stop with the step that it cut short, and with the rate behind it: the last step's
    /// is that before a kink of the schedule.
    fn leave_stop(&mut self) {
        let time = self.time;
        let state = self.solver.state_mut();
        *state.t = time;
        *state.h = state.h.max(self.stride);
        NonLinearOp::call_inplace(&self.problem.eqn, state.y, time, state.dy);
        self.at_stop = false;
    }

    fn interpolate(&self, time: f64, y: &mut FaerVec<f64>) {
        let state = self.solver.state();
        if self.solver.interpolate_inplace(time.min(state.t), y).is_err() {
            y.copy_from(state.y);
        }
    }

    fn write(&self, time: f64, y: &FaerVec<f64>, state: &mut State) {
        let [q, v, z] = parts(y, self.problem.eqn.dof());
        state.time = time;
        for (to, from) in [(&mut state.q, q), (&mut state.v, v), (&mut state.z, z)] {
            to.clear();
            to.extend_from_slice(from);
        }
    }

    fn effort(&self) -> Effort {
        let statistics = self.solver.get_statistics();
        let equations = &self.problem.eqn;
        let tangents = equations.tangents.borrow();
        Effort {
            steps: statistics.number_of_steps,
            rejected: statistics.number_of_error_test_failures + statistics.number_of_nonlinear_solver_fails,
            evaluations: equations.evaluations.get(),
            linearisations: tangents.linearisations,
            factorizations: tangents.factorizations,
            newton_iterations: statistics.number_of_nonlinear_solver_iterations,
        }
    }

    /// The reason for which a step failed, in our words.
    fn explain(&self, error: &DiffsolError, tried: f64, stalled_before: usize) -> IntegrateError {
        let state = self.solver.state();
        let (time, mut rate) = (state.t, state.y.clone());
        NonLinearOp::call_inplace(&self.problem.eqn, state.y, time, &mut rate);
        if let Err(error) = finite(self.problem, time, &rate) {
            return error;
        }
        let stalls = self.solver.get_statistics().number_of_nonlinear_solver_fails - stalled_before;
        match error {
            DiffsolError::OdeSolverError(
                OdeSolverError::StepSizeTooSmall { .. } | OdeSolverError::TooManyErrorTestFailures { .. },
            ) if stalls == 0 => {
                let [_, acceleration, _] = parts(&rate, self.problem.eqn.dof());
                let fastest = (0..acceleration.len() - 1)
                    .max_by(|&i, &j| acceleration[i].abs().total_cmp(&acceleration[j].abs()));
                IntegrateError::StepTooSmall {
                    time,
                    step: SMALLEST_STEP,
                    node: node(fastest.unwrap_or(0)),
                    stiff: Stiff::default(),
                }
            }
            _ => IntegrateError::Stalled { time, step: tried },
        }
    }
}

/// Node of a coordinate.
fn node(coordinate: usize) -> usize {
    coordinate / 2 + 1
}

fn finite(problem: &OdeSolverProblem<Equations>, time: f64, y: &FaerVec<f64>) -> Result<(), IntegrateError> {
    let dof = problem.eqn.dof();
    let [q, v, z] = parts(y, dof);
    let strange = |x: &[f64]| x.iter().position(|x| !x.is_finite());
    // Memory has one value for each node of the rod and the root.
    let edges = dof / 2;
    let node =
        strange(q).or(strange(v)).map(|k| node(k).min(edges)).or_else(|| strange(z).map(|k| k % (edges + 1)));
    node.map_or(Ok(()), |node| Err(IntegrateError::NotFinite { time, node }))
}
