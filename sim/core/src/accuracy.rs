//! How far a run is from the exact answer of its model, and the mesh and tolerance that bring it near enough.
//!
//! Both errors are estimated by a second run each. A coarser mesh, of two edges for three, changes the path of the
//! tip by `(1.5^p − 1)` times the error of the mesh, where `p` is the order of the scheme. Longer steps, twice as long
//! where they are given and of a tolerance sixteen times as large where they are not, change it by a multiple of the
//! error of the steps. The error of a run is the largest distance of its tip from the exact path.

use models::model::{Model, Scheme};
use serde::{Deserialize, Serialize};

use std::ops::ControlFlow;

use crate::forward::{ForwardError, Run, Sample, forward, start_of_tip};
use crate::integrate::{Method, Steps};
use crate::rest::rest;
use crate::trajectory::{Status, Trajectory};

/// What is asked of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Largest error of the tip's path, m; none for [`usual`].
    pub accuracy: Option<f64>,
    /// Whether the mesh may be chosen.
    pub chooses_mesh: bool,
    /// Whether the tolerance of the steps may be chosen.
    pub chooses_tolerance: bool,
}

/// Accuracy unless another is asked for, m: results are printed to a tenth of a millimetre.
const USUAL: f64 = 2e-5;
/// The same of small swings, as a share of them: frequencies and damping ratios are printed to three digits.
const USUAL_SHARE: f64 = 1e-3;
/// Share of its length by which the tip of a rod moves that swings: a fifth of a micrometre for the paper's muscle.
/// What is less is rounding, and has no frequency.
pub const AT_REST: f64 = 1e-6;
/// No accuracy is finer than that, over the length of the rod: a stiff edge rounds there.
const FINEST: f64 = 1e-8;

/// The accuracy that a run has unless another is asked for, m: 0.02 mm, of small swings a thousandth. A rod that is
/// at rest does not swing.
pub fn usual(model: &Model, swing: f64) -> f64 {
    let length = model.rod().length;
    if swing < AT_REST * length { USUAL } else { USUAL.min(USUAL_SHARE * swing).max(FINEST * length) }
}

/// Twice the way from the start to the rest, m, as far as there is a rest.
fn expected_swing(model: &Model, run: &Run) -> Result<f64, ForwardError> {
    let start = start_of_tip(model, run)?;
    let Ok(rest) = rest(model, 0.0, 0) else { return Ok(model.rod().length) };
    Ok(2.0 * (start[0] - rest.tip[0]).hypot(start[1] - rest.tip[1]))
}

/// How wrong a run may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Errors {
    /// Accuracy that was requested, or the usual one.
    pub requested_m: f64,
    /// Largest distance of the tip from where a rod without mesh would have it.
    pub mesh_m: f64,
    /// When that is, after release.
    pub mesh_time_s: f64,
    /// Nodes of the coarser run that tells.
    pub coarse_nodes: usize,
    /// Largest distance of the tip from where infinitely short steps would have it.
    pub step_m: f64,
    /// When that is, after release.
    pub step_time_s: f64,
    /// Distance by which the energy fails to close, over the energy released, times the swing.
    pub energy_m: Option<f64>,
    /// When and why the run with longer steps could not go on; what it did before is compared.
    pub fails: Option<String>,
    /// Runs that were made to choose mesh and tolerance.
    pub attempts: usize,
}

impl Errors {
    /// Both errors together, m.
    pub fn tip_m(&self) -> f64 {
        self.mesh_m + self.step_m
    }

    /// Whether the path of the tip is as accurate as was asked.
    pub fn is_reached(&self) -> bool {
        self.tip_m() <= self.requested_m && self.fails.is_none()
    }

    /// What to know before the run is used.
    pub fn warnings(&self, run: &Run, model: &Model, goal: &Goal) -> Vec<String> {
        let mut warnings = Vec::new();
        let asked = millimetres(self.requested_m);
        let misses = self.tip_m() > self.requested_m;
        if misses && self.mesh_m > SHARE * self.requested_m {
            let next = match self.mesh_nodes(model) {
                Some(nodes) if goal.chooses_mesh => format!("rod.nodes = {nodes} may do, and takes longer"),
                Some(nodes) if model.scheme == Scheme::Paper => {
                    format!("give rod.nodes = {nodes}, or leave rod.scheme out")
                }
                Some(nodes) => format!("give rod.nodes = {nodes}, or leave it out"),
                None => "ask for less by run.accuracy".to_owned(),
            };
            warnings.push(format!(
                "the mesh of {} nodes puts the tip wrong by some {} mm at {:.2} s, {asked} mm was asked; {next}",
                model.edges + 1,
                millimetres(self.mesh_m),
                self.mesh_time_s
            ));
        }
        let next = match (run.steps.fixed(), run.method.of(model)) {
            (Some(step), _) => format!("give integrator.fixed_step = \"{} ms\"", significant(500.0 * step)),
            (None, Method::Verlet) => {
                "without any loss every digit counts: give it some damping, or believe the first swings only"
                    .to_owned()
            }
            (None, _) => format!("give integrator.tolerance = {:.0e}", 0.1 * run.tolerance),
        };
        if let Some(why) = &self.fails {
            warnings.push(format!("with longer steps the run fails: {why}; {next}"));
        } else if misses && self.step_m > SHARE * self.requested_m {
            warnings.push(format!(
                "the steps put the tip wrong by some {} mm at {:.2} s, {asked} mm was asked; {next}",
                millimetres(self.step_m),
                self.step_time_s
            ));
        }
        if let Some(energy) = self.energy_m.filter(|energy| *energy > self.requested_m) {
            warnings.push(format!(
                "the energy fails to close by what {} mm of the swing are worth, {asked} mm was asked; {next}",
                millimetres(energy)
            ));
        }
        warnings
    }

    /// Nodes that would reach what was asked.
    fn mesh_nodes(&self, model: &Model) -> Option<usize> {
        let edges = finer(model, self.mesh_m / (AIM * self.requested_m));
        (edges < MOST_EDGES).then_some(edges + 1)
    }
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
/// Steps times edges that no attempt may be expected to take: some seconds that nobody asked for.
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

/// Runs a model, estimates its errors, and chooses mesh and tolerance anew until they are as small as asked.
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
    // The steps of Verlet's method become shorter with the edges, and a mesh too fine costs more than an attempt.
    let errors = if run.method.of(model) == Method::Verlet { USUAL_ERRORS } else { LARGE_ERRORS };
    let (mut model, mut run) = begin(model, run, goal, errors)?;
    let (mut last, mut stalled) = (f64::INFINITY, 0);
    let mut attempts = 0;
    loop {
        attempts += 1;
        let trajectory = match forward(&model, &run, see) {
            Err(ForwardError::Integrate { trajectory, .. }) => *trajectory,
            run => run?,
        };
        let errors = estimate(&model, &run, &trajectory, goal, attempts)?;
        let Some(errors) = errors else { return Ok(Settled { model, run, trajectory, errors }) };
        let wrong = [errors.mesh_m, errors.step_m.max(errors.energy_m.unwrap_or(0.0))]
            .map(|error| error / errors.requested_m);
        // What longer steps change says nothing of the mesh, whose coarser run takes steps of its own.
        let is_known = errors.mesh_m > errors.step_m || wrong[1] <= SHARE;
        let may = [goal.chooses_mesh, goal.chooses_tolerance && run.method.of(&model) != Method::Verlet];
        let mends = [may[0] && is_known && wrong[0] > SHARE, may[1] && wrong[1] > SHARE];
        let worst = wrong[0].max(wrong[1]);
        stalled = if worst > CONVERGES * last { stalled + 1 } else { 0 };
        // A third more than in proportion, for tolerances of coarse runs promise too much.
        let less = if mends[1] { (AIM / wrong[1]).powf(1.3).max(1e-4) } else { 1.0 };
        let edges = if mends[0] { finer(&model, wrong[0] / AIM).min(MOST_EDGES) } else { model.edges };
        let work = trajectory.effort.steps as f64 * less.powf(-0.25) * edges as f64;
        if !(mends[0] || mends[1]) || stalled == MOST_STALLED || attempts == MOST_ATTEMPTS || work > MOST_WORK
        {
            return Ok(Settled { model, run, trajectory, errors: Some(errors) });
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

/// Order of the error in the edge length that estimates count on: three for the consistent scheme, which reaches
/// four on meshes that resolve the rod and three beyond, where its ends show.
pub fn order(model: &Model) -> f64 {
    match model.scheme {
        Scheme::Consistent => 3.0,
        Scheme::Paper => 1.0,
    }
}

/// What a coarser mesh and longer steps say of a run; none where it did not come to its end, or these were cancelled.
fn estimate(
    model: &Model,
    run: &Run,
    trajectory: &Trajectory,
    goal: &Goal,
    attempts: usize,
) -> Result<Option<Errors>, ForwardError> {
    if trajectory.status != Status::Complete {
        return Ok(None);
    }
    let quiet = Run {
        energy: false,
        keep_samples: false,
        keep_steps: false,
        sensitivities: Vec::new(),
        ..run.clone()
    };
    let coarse_nodes = (model.edges * 2 / 3).max(3) + 1;
    let (coarse, longer) = both(
        || -> Result<_, ForwardError> {
            let (model, run) = quiet.on_mesh(model, coarse_nodes)?;
            traced(&model, &run)
        },
        || traced(model, &with_longer_steps(model, &quiet, trajectory)),
    );
    let ((coarse, coarse_fails), (longer, fails)) = (coarse?, longer?);
    if [&coarse, &longer].iter().any(|run| matches!(run.status, Status::CutShort { .. })) {
        return Ok(None);
    }
    let swing = trajectory.trace.extent();
    let (mesh, mesh_time_s) = trajectory.trace.farthest(&coarse.trace);
    let (step, step_time_s) = trajectory.trace.farthest(&longer.trace);
    let ratio = model.edges as f64 / (coarse_nodes - 1) as f64;
    // A mesh that cannot even be run, or that is no coarser, says nothing good.
    let per_mesh =
        if coarse_fails.is_some() || ratio <= 1.0 { 1.0 } else { 1.0 / (ratio.powf(order(model)) - 1.0) };
    let closure = trajectory.closure();
    Ok(Some(Errors {
        requested_m: goal.accuracy.unwrap_or_else(|| usual(model, swing)),
        mesh_m: mesh * per_mesh,
        mesh_time_s,
        coarse_nodes,
        step_m: step / longer_steps(model, run).1,
        step_time_s,
        energy_m: closure.map(|closure| closure * swing),
        fails,
        attempts,
    }))
}

/// What two functions say, beside one another where threads are to be had.
fn both<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(feature = "parallel")]
    return rayon::join(a, b);
    #[cfg(not(feature = "parallel"))]
    (a(), b())
}

/// A run for the sake of its trace, and why it could not go on.
fn traced(model: &Model, run: &Run) -> Result<(Trajectory, Option<String>), ForwardError> {
    match forward(model, run, &mut |_| ControlFlow::Continue(())) {
        Ok(trajectory) => Ok((trajectory, None)),
        Err(ForwardError::Integrate { trajectory, error }) => Ok((*trajectory, Some(error.to_string()))),
        Err(error) => Err(error),
    }
}

/// By how much longer steps admit more error, and how many times the error of the run they change it by.
///
/// Twice as long steps of order `p` change it by `2^p − 1` errors: 15 for RODAS4, 3 for Verlet and TR-BDF2, 7 for
/// ESDIRK34. Of a tolerance sixteen times as large, with which the steps of a method that judges itself by a
/// result of third order are twice as long, the same is expected; stiff modes lose some of the order.
fn longer_steps(model: &Model, run: &Run) -> (f64, f64) {
    match (&run.steps, run.method.of(model)) {
        (_, Method::Verlet) => (16.0, 3.0),
        (_, Method::TrBdf2) => (8.0, 3.0),
        (_, Method::Esdirk34) => (16.0, 7.0),
        (Steps::Fixed(_) | Steps::Given(_) | Steps::Repeated(_), _) => (16.0, 15.0),
        (Steps::Adaptive, _) => (16.0, STIFF),
    }
}

/// The share of 15 errors that is left of RODAS4's order.
const STIFF: f64 = 6.0;

fn with_longer_steps(model: &Model, run: &Run, trajectory: &Trajectory) -> Run {
    let mean = || run.duration / trajectory.effort.steps.max(1) as f64;
    let (steps, tolerance) = match (&run.steps, run.method.of(model)) {
        (Steps::Fixed(step), _) => (Steps::Fixed(2.0 * step), run.tolerance),
        (Steps::Given(ends) | Steps::Repeated(ends), _) => {
            (Steps::Given(ends.iter().skip(1).step_by(2).copied().collect()), run.tolerance)
        }
        (Steps::Adaptive, Method::Verlet) => (Steps::Fixed(2.0 * mean()), run.tolerance),
        (Steps::Adaptive, _) => (Steps::Adaptive, longer_steps(model, run).0 * run.tolerance),
    };
    Run { steps, tolerance, ..run.clone() }
}

fn millimetres(metres: f64) -> String {
    significant(1e3 * metres)
}

/// Two digits that count.
fn significant(value: f64) -> String {
    models::digits::rounded(value, 2)
}
