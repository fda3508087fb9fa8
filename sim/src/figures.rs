//! What the paper's Figures 4 to 9 show, from runs of our own.
//!
//! The paper publishes no trajectory and no position of a marker, so what it measured is stood in for: by a
//! release that is simulated at every pressure of its table, with the bending stiffness that its 32-node rod was
//! fitted with, the root and the mass that belong to that (see `SCENARIO`). The tip at rest of that run stands for
//! the measured tip; the paper's beam and its rods of 4 to 40 nodes are then fitted to it as the paper fits them.
//! So the rod of 32 nodes finds the table's own stiffness again, and no error: by construction.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Results, Figures 4 to 9 and Table 2.

use models::error::ModelError;
use models::model::Model;
use models::muscle::{Extrapolation, Muscle, MuscleError};
use models::statics::euler_bernoulli::EulerBernoulli;

use crate::analysis::AnalysisError;
use crate::analysis::bending_stiffness::StiffnessFit;
use crate::analysis::static_stiffness::{NODES, StaticFit, beam, compare};
use crate::results::rest::{Rest, rest};
use crate::results::summary::{MODES, Summary, Swing, summarise};
use crate::scenario::Case;
use crate::trajectory::Trajectory;

/// The muscle of the figures.
pub const MUSCLE: &str = "garbulinski-2022";
/// What is simulated for them: the paper's setup, as far as it is said.
pub const SCENARIO: &str = r#"# Purpose: what `efam figures` simulates.
# Expected: Table 2's stiffness is used as it was fitted: 32 nodes, a whole Voronoi length at the clamp, the resting
# mass per length at every pressure. The paper gives no Rayleigh constants: both are assumed.
name = "figures"

[muscle]
name = "garbulinski-2022"
pressure = "all rows"
stiffness = "pder_32"
mass = "per_length"

[rod]
nodes = 32
root = "paper"

[effects.rayleigh_mass]
alpha = "1 1/s"

[effects.rayleigh_stiffness]
beta = "2 ms"
"#;
/// Pieces into which the curve of the beam is divided.
const PIECES: usize = 32;
/// Places along two shapes at which they are compared.
const PLACES: usize = 50;

/// One pressure.
pub struct Pressure {
    /// Above ambient, Pa.
    pub pressure: f64,
    /// What was simulated.
    pub model: Model,
    /// The release.
    pub trajectory: Trajectory,
    /// Its rest.
    pub rest: Result<Rest, ModelError>,
    /// Its numbers.
    pub summary: Summary,
    /// Its spectrum and decay.
    pub swing: Swing,
    /// Table 2's EI: from the axial test, of the beam, of the rod of 32 nodes, N m².
    pub published: [f64; 3],
    /// EI and tip error of the beam and of the rods of [`NODES`], fitted to the tip at rest.
    pub fits: Vec<StaticFit>,
    /// Their shapes at rest with that EI.
    pub shapes: Vec<Shape>,
}

/// A shape at rest, from the clamp to the tip.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Nodes of the rod; none for the beam.
    pub nodes: Option<usize>,
    /// Points, m: along the active length, then the tip.
    pub points: Vec<[f64; 2]>,
    /// Farthest distance from the simulated rod at one share of the active length, m.
    pub off: f64,
}

impl Pressure {
    /// What the figures need of a simulated case.
    /// # Errors
    /// [`MuscleError`] of a pressure that Table 2 does not hold.
    pub fn new(case: &Case, trajectory: Trajectory) -> Result<Self, MuscleError> {
        let pressure = case.pressure.unwrap_or_default();
        let muscle = Muscle::built_in(MUSCLE)?;
        let mut published = [0.0; 3];
        for (value, source) in published.iter_mut().zip(["axial", "euler", "pder_32"]) {
            *value = muscle.at(pressure, source, Extrapolation::Refused)?.bending_stiffness;
        }
        let model = case.model.clone();
        let end = trajectory.times.last().copied().unwrap_or(0.0);
        let rest = rest(&model, end, MODES);
        let (mut summary, swing) = summarise(&model, &case.run, &trajectory, &rest);
        summary.name = case.name.clone();
        let (mut fits, mut shapes) = (Vec::new(), Vec::new());
        if let Ok(rest) = &rest {
            let meshes: Vec<Model> = NODES.iter().filter_map(|nodes| model.with_nodes(*nodes).ok()).collect();
            fits = compare(rest.tip, &meshes);
            shapes = fits.iter().filter_map(|fit| shape(&model, &meshes, fit, rest)).collect();
        }
        Ok(Self { pressure, model, trajectory, rest, summary, swing, published, fits, shapes })
    }

    /// The fit of the beam, or of a rod of so many nodes.
    pub fn fit(&self, nodes: Option<usize>) -> Option<&StiffnessFit> {
        self.fits.iter().find(|fit| fit.nodes == nodes).and_then(|fit| found(fit).ok())
    }

    /// The tip error of that fit, m.
    pub fn tip_error(&self, nodes: Option<usize>) -> Option<f64> {
        self.fit(nodes).map(|fit| fit.residual[0].hypot(fit.residual[1]))
    }
}

/// The paper's search; where it stalled, the other one, which minimises the same.
pub fn found(fit: &StaticFit) -> Result<&StiffnessFit, &AnalysisError> {
    fit.nelder_mead.as_ref().or(fit.gauss_newton.as_ref())
}

/// The shape of a fitted model beside the rod that was simulated.
fn shape(model: &Model, meshes: &[Model], fit: &StaticFit, simulated: &Rest) -> Option<Shape> {
    let bending_stiffness = found(fit).ok()?.bending_stiffness;
    let (active, tip) = match fit.nodes {
        None => {
            let beam = EulerBernoulli { bending_stiffness, ..beam(model) };
            let active: Vec<[f64; 2]> = beam.shape(PIECES).iter().map(|pose| pose.position).collect();
            (active, beam.tip().position)
        }
        Some(nodes) => {
            let mut mesh = meshes.iter().find(|mesh| mesh.edges + 1 == nodes)?.clone();
            mesh.set("rod.bending_stiffness", bending_stiffness).ok()?;
            let rest = rest(&mesh, 0.0, 1).ok()?;
            (rest.nodes, rest.tip)
        }
    };
    let off = (0..=PLACES)
        .map(|k| k as f64 / PLACES as f64)
        .map(|share| (along(&active, share), along(&simulated.nodes, share)))
        .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
        .fold(0.0, f64::max);
    let points = active.into_iter().chain([tip]).collect();
    Some(Shape { nodes: fit.nodes, points, off })
}

/// The point at a share of the length of a line through points.
fn along(points: &[[f64; 2]], share: f64) -> [f64; 2] {
    let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let whole: f64 = points.windows(2).map(length).sum();
    let mut left = share * whole;
    for pair in points.windows(2) {
        let own = length(pair);
        if left <= own && own > 0.0 {
            let part = left / own;
            return [0, 1].map(|k| pair[0][k] + part * (pair[1][k] - pair[0][k]));
        }
        left -= own;
    }
    points.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_along_a_bent_line_is_found_by_its_length() {
        let bent = [[0.0, 0.0], [3.0, 0.0], [3.0, -1.0]];
        assert_eq!(along(&bent, 0.0), [0.0, 0.0]);
        assert_eq!(along(&bent, 0.5), [2.0, 0.0]);
        assert_eq!(along(&bent, 0.875), [3.0, -0.5]);
        let end = along(&bent, 1.0);
        assert!((end[0] - 3.0).abs() < 1e-12 && (end[1] + 1.0).abs() < 1e-12, "{end:?}");
    }
}
