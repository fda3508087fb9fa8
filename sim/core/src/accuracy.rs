//! How far a run is from the exact answer of its model, and the mesh and tolerance that bring it near enough.
//!
//! Both errors are estimated by a second run each. A coarser mesh, of two edges for three, changes the path of the
//! tip by `(1.5^p − 1)` times the error of the mesh, where `p` is the order of the scheme. Longer steps, twice as long
//! where they are given and of a tolerance sixteen times as large where they are not, change it by a multiple of the
//! error of the steps. The error of a run is the largest distance of its tip from the exact path.

mod errors;

use std::ops::ControlFlow;

use models::model::Model;

use crate::forward::{ForwardError, Run, Sample, forward, start_of_tip};
use crate::integrate::Method;
use crate::rest::rest;
use crate::trajectory::{Status, Trajectory};

pub use errors::{Errors, energy_warning, order, unclosed};
use errors::{apart, estimate};

/// The accuracy that a run must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Largest error of the tip's path, m; none for [`usual`].
    pub accuracy: Option<f64>,
    /// Whether the mesh may be chosen.
    pub chooses_mesh: bool,
    /// Whether the tolerance of the steps may be chosen.
    pub chooses_tolerance: bool,
}

/// Default accuracy, m: results are printed to a tenth of a millimetre.
const USUAL: f64 = 2e-5;
/// The same of small swings, as a share of them: frequencies and damping ratios are printed to three digits.
const USUAL_SHARE: f64 = 1e-3;
/// Share of its length by which the tip of a rod moves that swings: a fifth of a micrometre for the paper's muscle.
/// What is less is rounding, and has no frequency.
pub const AT_REST: f64 = 1e-6;
/// No accuracy is finer than that, over the length of the rod: a stiff edge rounds there.
const FINEST: f64 = 1e-8;

/// The default accuracy of a run, m: 0.02 mm, of small swings a thousandth. A rod that is at rest does not swing.
pub fn usual(model: &Model, swing: f64) -> f64 {
    let length = model.rod().length;
    if swing < AT_REST * length { USUAL } else { USUAL.min(USUAL_SHARE * swing).max(FINEST * length) }
}

/// Twice the way from the start to the rest, m, as far as there is a rest.
fn expected_swing(model: &Model, run: &Run) -> Result<f64, ForwardError> {
    let (start, length) = (start_of_tip(model, run)?, model.rod().length);
    let Ok(rest) = rest(model, 0.0, 0) else { return Ok(length) };
    let swing = 2.0 * (start[0] - rest.tip[0]).hypot(start[1] - rest.tip[1]);
    // A pressure or a load that changes later may move a rod that begins at rest by any of its length.
    let is_driven = model.is_timed() && swing < AT_REST * length;
    Ok(if is_driven { length } else { swing })
}

/// Share of the accuracy that mesh and step may have each, and at which each aims when it is chosen anew.
const SHARE: f64 = 0.5;
const AIM: f64 = 0.3;
const MOST_EDGES: usize = 1999;
/// Runs that are made to choose mesh and tolerance.
const MOST_ATTEMPTS: usize = 6;
/// Attempts in a row that are not twice as good as the one before do not converge: a rod without loss, or one that
/// folds. One alone may be the first that resolves the rod: what a coarser mesh says before that is too good.
const CONVERGES: f64 = 0.5;
const MOST_STALLED: usize = 2;
/// Steps times edges that no attempt may be expected to take: some seconds beyond what was requested.
const MOST_WORK: f64 = 3e6;
/// Edges and tolerance of a first attempt, from releases of the paper's muscle at all its pressures: there the error
/// of the mesh is at most `2.6 A / edges⁴`, that of the steps some ten times the tolerance times `A`, where `A` is the
/// swing or the length of the rod, whichever is less.
const USUAL_ERRORS: [f64; 2] = [2.6, 10.0];
/// The same for a run whose errors are estimated: few need a second attempt, which costs three runs.
const LARGE_ERRORS: [f64; 2] = [7.0, 40.0];
const FEWEST_EDGES: usize = 7;
const MOST_FIRST_EDGES: usize = 60;
const TOLERANCES: [f64; 2] = [1e-11, 1e-4];

/// A run whose errors are known.
pub struct Settled {
    /// The model on the mesh that was taken.
    pub model: Model,
    /// The run with the tolerance that was taken.
    pub run: Run,
    /// What came of it.
    pub trajectory: Trajectory,
    /// How wrong it may be; none where the run did not come to its end.
    pub errors: Option<Errors>,
}

/// Mesh and tolerance with which to begin for an accuracy, m, as far as they may be chosen.
/// # Errors
/// As [`Run::on_mesh`].
pub fn first(model: &Model, run: &Run, goal: &Goal) -> Result<(Model, Run), ForwardError> {
    begin(model, run, goal, USUAL_ERRORS)
}

/// The same, where mesh and steps have these errors as in [`USUAL_ERRORS`].
fn begin(
    model: &Model,
    run: &Run,
    goal: &Goal,
    [of_mesh, of_steps]: [f64; 2],
) -> Result<(Model, Run), ForwardError> {
    let swing = expected_swing(model, run)?;
    let accuracy = goal.accuracy.unwrap_or_else(|| usual(model, swing));
    let swing = swing.clamp(FINEST * model.rod().length, model.rod().length);
    let mut run = run.clone();
    if goal.chooses_tolerance {
        run.tolerance = tolerance(AIM * accuracy / (of_steps * swing));
    }
    if !goal.chooses_mesh {
        return Ok((model.clone(), run));
    }
    let edges = (of_mesh * swing / (AIM * accuracy)).powf(0.25).ceil() as usize;
    Ok(run.on_mesh(model, edges.clamp(FEWEST_EDGES, MOST_FIRST_EDGES) + 1)?)
}

/// Runs a model, estimates its errors, and chooses mesh and tolerance anew until they are as small as requested.
/// `see` sees the samples of each attempt; what it breaks off, or what cannot go on, is returned as it is.
///
/// ```
/// use std::ops::ControlFlow;
///
/// use efam_core::accuracy::{Goal, settle};
/// use efam_core::forward::Run;
/// # use models::effects::Rod;
/// # use models::model::{Model, ModelSpec};
/// # let rod = Rod { length: 0.2, mass: 0.03, bending_stiffness: 5e-3, axial_stiffness: 500.0, diameter: 0.03,
/// #     pressure: 0.0 };
/// # let model = Model::new(&ModelSpec { nodes: 8, ..ModelSpec::of(rod) }.with(&[("rayleigh_mass.alpha", 1.0),
/// #     ("rayleigh_stiffness.beta", 2e-3)]))?;
///
/// let goal = Goal { accuracy: Some(1e-4), chooses_mesh: true, chooses_tolerance: true };
/// let settled = settle(&model, &Run::release(0.5, 100.0), &goal, &mut |_| ControlFlow::Continue(()))?;
/// let errors = settled.errors.ok_or("it came to its end")?;
/// println!("{} nodes are within {:.3} mm", settled.model.edges + 1, 1e3 * errors.tip_m());
/// # assert!(errors.is_reached(), "{errors:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`ForwardError::Model`], [`ForwardError::Method`].
pub fn settle(
    model: &Model,
    run: &Run,
    goal: &Goal,
    see: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Settled, ForwardError> {
    let mut best = search(model, run, goal, see)?;
    // What is finer is not always nearer: where the search does not reach its goal, one for ten times less may. The path of
    // a rod without any loss is chaotic, whatever the mesh.
    let is_implicit = run.method.of(model) != Method::Verlet;
    let may_choose = is_implicit && (goal.chooses_mesh || goal.chooses_tolerance);
    let mut wanted = best.errors.as_ref().map_or(f64::INFINITY, |errors| 10.0 * errors.requested_m);
    while let Some(errors) = (best.errors.as_ref())
        .filter(|errors| may_choose && !errors.is_reached() && wanted <= 10.0 * errors.tip_m())
    {
        let (requested_m, attempts) = (errors.requested_m, errors.attempts);
        let other = search(model, run, &Goal { accuracy: Some(wanted), ..*goal }, see)?;
        // Cut short, or failed where the first did not.
        let Some(found) = &other.errors else {
            return Ok(if matches!(other.trajectory.status, Status::CutShort { .. }) { other } else { best });
        };
        let attempts = attempts + found.attempts;
        let apart_m = apart(&best, &other);
        let is_better = found.tip_m() < errors.tip_m();
        let is_reached = found.is_reached();
        best = if is_better { other } else { best };
        if let Some(errors) = &mut best.errors {
            let apart_m = errors.apart_m.into_iter().chain(apart_m).reduce(f64::max);
            *errors = Errors { requested_m, attempts, apart_m, ..errors.clone() };
        }
        if is_reached {
            break;
        }
        wanted *= 10.0;
    }
    Ok(best)
}

/// One search: attempts with ever finer meshes and tolerances, of which the best is returned.
fn search(
    model: &Model,
    run: &Run,
    goal: &Goal,
    see: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Result<Settled, ForwardError> {
    // The steps of Verlet's method become shorter with the edges, and a mesh too fine costs more than an attempt.
    let errors = if run.method.of(model) == Method::Verlet { USUAL_ERRORS } else { LARGE_ERRORS };
    let (mut model, mut run) = begin(model, run, goal, errors)?;
    let (mut last, mut stalled) = (f64::INFINITY, 0);
    // The best attempt, by how wrong it is, and the one before the last, if that is another.
    let mut best: Option<(f64, Settled)> = None;
    let mut attempts = 0;
    loop {
        attempts += 1;
        let trajectory = match forward(&model, &run, see) {
            Err(ForwardError::Integrate { trajectory, .. }) => *trajectory,
            run => run?,
        };
        let errors = estimate(&model, &run, &trajectory, goal, attempts)?;
        let mut attempt = Settled { model: model.clone(), run: run.clone(), trajectory, errors };
        let Some(errors) = &attempt.errors else {
            // A finer attempt that fails says nothing against the one before; one that was cut short ends the search.
            let is_cut = matches!(attempt.trajectory.status, Status::CutShort { .. });
            return Ok(best.filter(|_| !is_cut).map_or(attempt, |(_, best)| best));
        };
        let wrong = errors.wrong(&attempt);
        // What longer steps change says nothing of the mesh, whose coarser run takes steps of its own.
        let is_known = errors.mesh_m > errors.step_m || wrong[1] <= SHARE;
        let may = [goal.chooses_mesh, goal.chooses_tolerance && run.method.of(&model) != Method::Verlet];
        let worst = wrong[0].max(wrong[1]);
        let apart_m = best.as_ref().and_then(|(_, best)| apart(best, &attempt));
        // An attempt that an earlier one contradicts is good only once another agrees with it.
        let aims = if worst <= SHARE && apart_m.is_some() { [2.0 * AIM; 2] } else { wrong };
        let mends = [may[0] && is_known && aims[0] > SHARE, may[1] && aims[1] > SHARE];
        stalled = if worst > CONVERGES * last { stalled + 1 } else { 0 };
        // A third more than in proportion, for tolerances of coarse runs promise too much.
        let less = if mends[1] { (AIM / aims[1]).powf(1.3).max(1e-4) } else { 1.0 };
        let edges = if mends[0] { finer(&model, aims[0] / AIM).min(MOST_EDGES) } else { model.edges };
        let work = attempt.trajectory.effort.steps as f64 * less.powf(-0.25) * edges as f64;
        let ends = !(mends[0] || mends[1])
            || stalled == MOST_STALLED
            || attempts == MOST_ATTEMPTS
            || work > MOST_WORK;
        if let Some(errors) = &mut attempt.errors {
            errors.apart_m = apart_m;
        }
        let is_better = best.as_ref().is_none_or(|(before, _)| worst <= *before);
        match &mut best {
            Some((_, best)) if !is_better => {
                let errors = best.errors.as_mut().expect("the best attempt came to its end");
                *errors = Errors { apart_m: errors.apart_m.or(apart_m), attempts, ..errors.clone() };
            }
            _ => best = Some((worst, attempt)),
        }
        if let Some((_, best)) = best.take_if(|_| ends) {
            return Ok(best);
        }
        last = worst;
        if mends[1] {
            run.tolerance = tolerance(run.tolerance * less);
        }
        if mends[0] {
            (model, run) = run.on_mesh(&model, edges + 1)?;
        }
    }
}

/// A tolerance within the range of tolerances, with two digits, as people write it.
fn tolerance(wanted: f64) -> f64 {
    let wanted = wanted.clamp(TOLERANCES[0], TOLERANCES[1]);
    format!("{wanted:.1e}").parse().unwrap_or(wanted)
}

/// Edges of a mesh that lowers an error of the mesh by a factor.
fn finer(model: &Model, factor: f64) -> usize {
    (model.edges as f64 * factor.powf(1.0 / order(model)).clamp(1.1, 4.0)).ceil() as usize
}
