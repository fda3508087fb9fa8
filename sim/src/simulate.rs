//! A case of a scenario, simulated as `efam simulate` does it, and what must be known of the run before it is used.

use std::ops::ControlFlow;

use efam_core::accuracy::{Errors, Settled, energy_warning, first, settle};
use efam_core::forward::{Cancel, ForwardError, Job, Run, Sample, forward, forward_many};
use efam_core::rest::rest;
use efam_core::trajectory::Trajectory;
use efam_core::{left_out, limits};
use efam_experiments::scenario::Case;
use efam_experiments::summary::MODES;

use crate::failure::Failure;

/// Simulates a case until its end, until it is cancelled, or to where it fails; what was integrated is kept.
///
/// With `estimates`, the run is repeated on a coarser mesh and with longer steps. These runs give its errors, and choose mesh
/// and tolerance.
/// # Errors
/// [`Failure`] where nothing could be integrated.
pub fn simulate(
    case: &Case,
    estimates: bool,
    cancel: Cancel,
    see: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Settled, Failure> {
    let run = Run { cancel, ..case.run.clone() };
    let stopped = |error| Failure::of_simulation(&case.name, error);
    if estimates {
        return settle(&case.model, &run, &case.goal, see).map_err(stopped);
    }
    let (model, run) = first(&case.model, &run, &case.goal).map_err(stopped)?;
    let trajectory = kept(case, forward(&model, &run, see))?;
    Ok(Settled { model, run, trajectory, errors: None })
}

/// Simulates many cases on one thread as [`simulate`] does without estimates; `done` sees the place of each. Models that
/// are alike but for their parameters run side by side, see [`forward_many`].
pub fn simulate_many(cases: &[Case], cancel: &Cancel, done: &mut dyn FnMut(usize, Result<Settled, Failure>)) {
    let mut begun = Vec::with_capacity(cases.len());
    for (place, case) in cases.iter().enumerate() {
        let run = Run { cancel: cancel.clone(), ..case.run.clone() };
        match first(&case.model, &run, &case.goal) {
            Ok((model, run)) => begun.push((place, model, run)),
            Err(error) => done(place, Err(Failure::of_simulation(&case.name, error))),
        }
    }
    let jobs: Vec<Job> = begun.iter().map(|(_, model, run)| Job { model, run }).collect();
    forward_many(&jobs, &mut |_, _| ControlFlow::Continue(()), &mut |job, trajectory| {
        let (place, model, run) = &begun[job];
        let settled =
            |trajectory| Settled { model: model.clone(), run: run.clone(), trajectory, errors: None };
        done(*place, kept(&cases[*place], trajectory).map(settled));
    });
}

/// What was integrated, if anything was.
/// # Errors
/// [`Failure`] where nothing was.
pub fn kept(case: &Case, run: Result<Trajectory, ForwardError>) -> Result<Trajectory, Failure> {
    match run {
        Ok(trajectory) => Ok(trajectory),
        Err(ForwardError::Integrate { trajectory, .. }) => Ok(*trajectory),
        Err(error) => Err(Failure::of_simulation(&case.name, error)),
    }
}

/// The warnings that only a finished run can give: its errors, and where its model does not hold. Those of its case
/// come before them.
pub fn warnings(case: &Case, done: &Settled) -> Vec<String> {
    let case = case.run_as(&done.model, &done.run);
    let errors = done.errors.iter().flat_map(|errors| errors.warnings(&case.run, &case.model, &case.goal));
    let is_told = |errors: &Errors| errors.energy_m.is_some_and(|energy| energy > errors.requested_m);
    let energy =
        energy_warning(&case.model, &done.trajectory).filter(|_| !done.errors.as_ref().is_some_and(is_told));
    let end = done.trajectory.times.last().copied().unwrap_or(0.0);
    let rest = rest(&case.model, end, MODES).ok();
    let limits = limits::warnings(&case.model, &done.trajectory, rest.as_ref(), case.measured_moment());
    errors
        .chain(energy)
        .chain(limits)
        .chain(left_out::warnings(&case.model, case.muscle().is_some(), 1))
        .collect()
}
