//! A model in the middle of its motion: one step after another, pressure and payload changed between them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use efam::failure::Failure;
use efam_core::integrate::State;
use efam_core::stepper::{ChangeError, Stepper};
use efam_experiments::scenario::Scenario;
use models::effects::by_name;
use models::line::RodPressure;
use models::model::Schedule;
use models::quantity::Quantity;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::failure::exception;
use crate::overrides::{overrides, quantity};
use crate::source::Source;

/// Time, coordinates, rates, and memory of the effects.
type Numbers = (f64, Vec<f64>, Vec<f64>, Vec<f64>);

/// A rod that is stepped.
#[pyclass(frozen, module = "efam._efam")]
pub struct Swing {
    inner: Mutex<Inner>,
}

struct Inner {
    stepper: Stepper,
    /// The present scenario, with all that was set.
    source: Source,
    /// The same as it was read, without what was set since by [`Inner::quickly`].
    scenario: Scenario,
    /// With a pressure line: commands, s and Pa, that the pressure in the rod has still to follow, from the last that it does.
    commands: Vec<(f64, f64)>,
}

/// What is set without reading a scenario again.
#[derive(Default)]
struct Changes {
    /// Values of the model by their paths.
    values: Vec<(String, f64)>,
    /// The pressure over time, behind a pressure line.
    schedule: Option<Arc<dyn Schedule>>,
    /// The commands of which it is made.
    commands: Vec<(f64, f64)>,
}

impl Inner {
    /// Values of a load at the tip and of the pressure, on which nothing else of a scenario depends: they are set without
    /// reading it again. None where there is more to set, or something is refused.
    fn quickly(&self, set: &[String]) -> Option<Changes> {
        let mut changes = Changes::default();
        for own in set {
            let (path, text) = own.split_once('=')?;
            let quantity = |unit: &str| Quantity::parse(text.trim_matches('"')).ok()?.to(unit).ok();
            if let Some(name) = path.strip_prefix(LOAD) {
                self.stepper.model().index(path).ok()?;
                let parameter =
                    by_name("tip_load")?.about().parameters.iter().find(|own| own.name == name)?;
                let is_admitted = |value: &f64| (parameter.range.0..=parameter.range.1).contains(value);
                changes.values.push((path.to_owned(), quantity(parameter.unit).filter(is_admitted)?));
            } else if path == "muscle.pressure" {
                let at = self.at_pressure(quantity("Pa")?)?;
                changes.values.extend(at.values);
                (changes.schedule, changes.commands) = (at.schedule, at.commands);
            } else {
                return None;
            }
        }
        Some(changes)
    }

    /// All values at a pressure, Pa, but those of the load at the tip; behind a pressure line the pressure is its command.
    fn at_pressure(&self, pressure: f64) -> Option<Changes> {
        let model = self.stepper.model();
        let Some(dead_time) = model.dead_time() else {
            let model = self.scenario.model_at(pressure)?;
            let all = model.parameters.iter().map(|parameter| parameter.path.clone()).zip(model.theta);
            let values = all.filter(|(path, _)| !path.starts_with(LOAD)).collect();
            return Some(Changes { values, ..Changes::default() });
        };
        let (now, release) = (self.stepper.state().time, model.rod().pressure);
        let mut commands = self.commands.clone();
        commands.push((now, pressure));
        // The line has still to follow what was sent within its dead time, and what was sent last before that.
        let passed = commands.iter().filter(|(sent, _)| *sent <= now - dead_time).count();
        commands.drain(..passed.saturating_sub(1));
        let resumes = (now, RodPressure::of(model).at(now));
        let schedule = self.scenario.steered(release, resumes, &commands)?;
        Some(Changes { schedule: Some(schedule), commands, ..Changes::default() })
    }

    /// Takes changes that came of what was `set`.
    fn apply(&mut self, changes: Changes, set: Vec<String>) -> PyResult<()> {
        let wrong = |error: ChangeError| exception(Failure::Usage(error.to_string()));
        if let Some(schedule) = changes.schedule {
            self.stepper.set_schedule(schedule).map_err(wrong)?;
            self.commands = changes.commands;
        }
        let values: Vec<_> = changes.values.iter().map(|(path, value)| (path.as_str(), *value)).collect();
        self.stepper.set_all(&values).map_err(wrong)?;
        self.source = self.source.with(set);
        Ok(())
    }
}

/// The load at the tip.
const LOAD: &str = "effects.tip_load.";

impl Swing {
    /// At the start of a scenario, on the mesh with which a run of its accuracy begins.
    pub fn of(source: Source) -> PyResult<Self> {
        let (case, scenario) = source.case()?;
        let case = case.begun();
        let wrong = |error: &dyn std::fmt::Display| exception(Failure::Diverged(error.to_string()));
        let state = case.run.initial.state(&case.model).map_err(|error| wrong(&error))?;
        let control = efam_core::integrate::Control {
            tolerance: case.run.tolerance,
            steps: case.run.steps.clone(),
            most_steps: case.run.most_steps,
            first_step: None,
        };
        let stepper = Stepper::with(&case.model, state, case.run.method, control);
        let stepper = stepper.map_err(|error| wrong(&error))?;
        // The line has settled when the rod is let go.
        let commands = vec![(0.0, case.model.rod().pressure)];
        Ok(Self { inner: Mutex::new(Inner { stepper, source, scenario, commands }) })
    }

    /// A panic leaves a rod that `set_state` makes whole again.
    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn diverged(error: impl std::fmt::Display) -> PyErr {
        exception(Failure::Diverged(error.to_string()))
    }
}

#[pymethods]
impl Swing {
    /// Goes on for a time, such as 0.01 or "10 ms".
    fn step(&self, py: Python<'_>, dt: &Bound<'_, PyAny>) -> PyResult<()> {
        let dt = quantity("dt", dt, "s")?;
        if !(dt >= 0.0 && dt.is_finite()) {
            return Err(exception(Failure::Usage(format!("dt = {dt} s: must not be negative"))));
        }
        py.detach(|| self.inner().stepper.step(dt).map(|_| ())).map_err(Self::diverged)
    }

    /// Changes pressure, payload or any parameter; the rod keeps its place and velocity.
    #[pyo3(signature = (**options))]
    fn set(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        // Another thread may step it, and wait for the global lock.
        let source = py.detach(|| self.inner().source.clone());
        let more = overrides(options, &source.laws())?;
        py.detach(|| {
            let mut inner = self.inner();
            let wrong = |error: &dyn std::fmt::Display| exception(Failure::Usage(error.to_string()));
            if let Some(changes) = inner.quickly(&more) {
                return inner.apply(changes, more);
            }
            let source = inner.source.with(more);
            let (case, scenario) = source.case()?;
            let own = case.model;
            let is_timed = inner.stepper.model().schedule.is_some() || own.schedule.is_some();
            if is_timed || own.theta.len() != inner.stepper.model().theta.len() {
                let message = "while it swings no effect can be added and no pressure over time be given; \
                               have the effect in the model, and set the pressure step by step";
                return Err(exception(Failure::Usage(message.to_owned())));
            }
            let values: Vec<(&str, f64)> = own
                .parameters
                .iter()
                .map(|parameter| parameter.path.as_str())
                .zip(own.theta.clone())
                .collect();
            inner.stepper.set_all(&values).map_err(|error| wrong(&error))?;
            (inner.source, inner.scenario) = (source, scenario);
            Ok(())
        })
    }

    /// Time since the release, s.
    #[getter]
    fn time(&self) -> f64 {
        self.inner().stepper.state().time
    }

    /// Time, coordinates, rates, and memory of the effects; may be set.
    #[getter]
    fn get_state(&self) -> Numbers {
        let State { time, q, v, z } = self.inner().stepper.state().clone();
        (time, q, v, z)
    }

    #[setter]
    fn set_state(&self, state: Numbers) -> PyResult<()> {
        let mut inner = self.inner();
        let (time, q, v, z) = state;
        let now = inner.stepper.state();
        let is_shaped = [q.len(), v.len(), z.len()] == [now.q.len(), now.v.len(), now.z.len()];
        let is_finite = time.is_finite() && q.iter().chain(&v).chain(&z).all(|value| value.is_finite());
        if !is_shaped || !is_finite {
            let message = format!(
                "state: {} coordinates, {} rates and {} memories, all finite, are due",
                now.q.len(),
                now.v.len(),
                now.z.len()
            );
            return Err(exception(Failure::Usage(message)));
        }
        inner.stepper.set_state(State { time, q, v, z });
        Ok(())
    }

    /// Position of the observed tip, m, and its velocity, m/s.
    #[getter]
    fn tip<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let tip = self.inner().stepper.tip();
        (PyArray1::from_slice(py, &tip.position), PyArray1::from_slice(py, &tip.velocity))
    }

    /// Positions of the nodes, m, shape `[N+1, 2]`.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = self.inner().stepper.nodes().as_flattened().to_vec();
        let count = numbers.len() / 2;
        PyArray1::from_vec(py, numbers).reshape([count, 2])
    }

    /// Kinetic, elastic and potential energy, J.
    #[getter]
    fn energy(&self) -> (f64, f64, f64) {
        let energy = self.inner().stepper.energy();
        (energy.kinetic, energy.elastic, energy.potential)
    }

    fn __getitem__(&self, path: &str) -> PyResult<f64> {
        let inner = self.inner();
        let model = inner.stepper.model();
        let index = model.index(path);
        index
            .map(|k| model.theta[k])
            .map_err(|error| pyo3::exceptions::PyKeyError::new_err(error.to_string()))
    }
}

/// Sets the pressure of each swing, Pa, and steps it by `dt`, s, on all cores: tips as x, z and their velocities in m and m/s,
/// shape `[swings, 4]`, not a number where a swing cannot go on.
#[pyfunction]
pub fn step_many<'py>(
    py: Python<'py>,
    swings: Vec<Py<Swing>>,
    pressures: Vec<f64>,
    dt: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if swings.len() != pressures.len() || !(dt >= 0.0 && dt.is_finite()) {
        let message = format!("{} swings, {} pressures, dt = {dt} s", swings.len(), pressures.len());
        return Err(exception(Failure::Usage(format!("{message}: one pressure each, and no negative time"))));
    }
    let step = |(swing, pressure): (&Py<Swing>, f64)| -> PyResult<[f64; 4]> {
        let inner = &mut *swing.get().inner();
        let refused = || {
            let message =
                format!("pressure {pressure} Pa: the muscle has no constant pressure, or not this one");
            exception(Failure::Usage(message))
        };
        let changes = inner.at_pressure(pressure).ok_or_else(refused)?;
        inner.apply(changes, vec![format!("muscle.pressure=\"{pressure} Pa\"")])?;
        if inner.stepper.step(dt).is_err() {
            return Ok([f64::NAN; 4]);
        }
        let tip = inner.stepper.tip();
        Ok([tip.position[0], tip.position[1], tip.velocity[0], tip.velocity[1]])
    };
    let all: Vec<[f64; 4]> =
        py.detach(|| swings.par_iter().zip(pressures).map(step).collect::<PyResult<_>>())?;
    PyArray1::from_slice(py, all.as_flattened()).reshape([all.len(), 4])
}
