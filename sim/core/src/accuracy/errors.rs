//! The errors of one run, from a coarser mesh and longer steps, and what to warn of.

use std::ops::ControlFlow;

use models::model::{Model, Scheme};
use serde::{Deserialize, Serialize};

use super::{AIM, AT_REST, Goal, MOST_EDGES, SHARE, Settled, finer, usual};
use crate::forward::{ForwardError, Run, forward};
use crate::integrate::{Method, Steps};
use crate::trajectory::{Status, Trajectory};

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
    /// Nodes of the coarser run, which gives the error.
    pub coarse_nodes: usize,
    /// Largest distance of the tip from where infinitely short steps would have it.
    pub step_m: f64,
    /// When that is, after release.
    pub step_time_s: f64,
    /// Distance by which the energy fails to close, over the energy released, times the swing.
    pub energy_m: Option<f64>,
    /// When and why the run with longer steps could not go on; what it did before is compared.
    pub fails: Option<String>,
    /// Largest distance of the tip from another attempt with another mesh or tolerance, where the estimated errors do not
    /// explain it: they cannot be trusted.
    pub apart_m: Option<f64>,
    /// Runs that were made to choose mesh and tolerance.
    pub attempts: usize,
}

impl Errors {
    /// Both errors together, m; where they cannot be trusted at least as much as attempts differ by.
    pub fn tip_m(&self) -> f64 {
        (self.mesh_m + self.step_m).max(self.apart_m.unwrap_or(0.0))
    }

    /// Errors of mesh and steps over what was requested; the energy belongs to the steps.
    pub(super) fn wrong(&self, attempt: &Settled) -> [f64; 2] {
        let energy = self.energy_m.unwrap_or(0.0).max(self.step_m) / self.requested_m;
        let closure = unclosed(&attempt.model, &attempt.trajectory).unwrap_or(0.0) / UNCLOSED;
        [self.mesh_m / self.requested_m, energy.max(SHARE * closure)]
    }

    /// Whether the path of the tip is as accurate as requested.
    pub fn is_reached(&self) -> bool {
        self.tip_m() <= self.requested_m && self.fails.is_none()
    }

    /// What to know before the run is used.
    pub fn warnings(&self, run: &Run, model: &Model, goal: &Goal) -> Vec<String> {
        let mut warnings = Vec::new();
        let asked = millimetres(self.requested_m);
        let misses = self.mesh_m + self.step_m > self.requested_m;
        if let Some(apart) = self.apart_m.filter(|apart| *apart > self.requested_m) {
            warnings.push(format!(
                "the estimated errors cannot be trusted: another mesh or tolerance moves the tip by {} mm, {asked} mm was \
                 requested; a rod with little damping may have no smooth path: give it some, or believe the first \
                 swings only",
                millimetres(apart)
            ));
        }
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
                "the mesh of {} nodes puts the tip wrong by some {} mm at {:.2} s, {asked} mm was requested; {next}",
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
                "the steps put the tip wrong by some {} mm at {:.2} s, {asked} mm was requested; {next}",
                millimetres(self.step_m),
                self.step_time_s
            ));
        }
        if let Some(energy) = self.energy_m.filter(|energy| *energy > self.requested_m) {
            warnings.push(format!(
                "the energy fails to close by what {} mm of the swing are worth, {asked} mm was requested; {next}",
                millimetres(energy)
            ));
        }
        warnings
    }

    /// Nodes that would reach the requested accuracy.
    fn mesh_nodes(&self, model: &Model) -> Option<usize> {
        let edges = finer(model, self.mesh_m / (AIM * self.requested_m));
        (edges < MOST_EDGES).then_some(edges + 1)
    }
}

/// Times their estimated errors that two attempts may be apart: an estimate holds to a factor of 1.5 in 98 of 100 drawn
/// runs.
const EXPLAINED: f64 = 2.0;
/// Share of the energy of a motion by which its budget may fail to close: more changes the second digit of a damping
/// ratio.
const UNCLOSED: f64 = 0.01;
/// How far two runs of one model are apart, m, if that is more than their errors explain.
pub(super) fn apart(a: &Settled, b: &Settled) -> Option<f64> {
    let estimated: f64 =
        [a, b].iter().flat_map(|run| &run.errors).map(|errors| errors.mesh_m + errors.step_m).sum();
    let distance = a.trajectory.trace.farthest(&b.trajectory.trace).0;
    (distance > EXPLAINED * estimated).then_some(distance)
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
pub(super) fn estimate(
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
        // Longer steps and fewer edges are no more steps, unless they come to no end.
        most_steps: run.most_steps.min(MOST_MORE * trajectory.effort.steps.max(FEWEST_STEPS)),
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
        apart_m: None,
        attempts,
    }))
}

/// Times the steps of a run that its estimates may take, and of how many at least.
const MOST_MORE: usize = 4;
const FEWEST_STEPS: usize = 1000;

/// Share of the energy of a motion by which its budget fails to close; none for a rod at rest.
pub fn unclosed(model: &Model, trajectory: &Trajectory) -> Option<f64> {
    let moves = trajectory.trace.extent() >= AT_REST * model.rod().length;
    trajectory.unclosed().filter(|_| moves)
}

/// What to know of the energy of a run, whose accuracy may be coarse against a small motion.
pub fn energy_warning(model: &Model, trajectory: &Trajectory) -> Option<String> {
    let share = unclosed(model, trajectory).filter(|share| *share > UNCLOSED)?;
    Some(format!(
        "the energy fails to close by {} % of that of the motion, and damping and amplitudes are as wrong: ask for \
         a smaller run.accuracy, or a smaller integrator.tolerance or fixed_step",
        models::digits::rounded(100.0 * share, 2)
    ))
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
/// ESDIRK34. With a tolerance sixteen times as large, steps of a method whose error estimate is of third
/// order are twice as long, and the same is expected; stiff modes lose some of the order.
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
