//! What the suites share: the paper's muscle, and ways to run it.

pub mod accuracy;
pub mod blind;
pub mod drawn_scenarios;
pub mod hostile;
pub mod recordings;
mod skipped;
pub mod twin;

use std::ops::ControlFlow;

use efam_core::forward::{Run, forward};
use efam_core::trajectory::Trajectory;
use models::effects::Rod;
use models::model::{Model, ModelSpec, Scheme};
use models::muscle::{Extrapolation, Muscle};

pub use skipped::skipped;

/// One pound-force per square inch, Pa.
pub const PSI: f64 = 6_894.757_293_168_361;

/// The paper's muscle at a pressure, its fitting a point mass and without air, released from the horizontal, with
/// parameters of effects set:
/// `("rayleigh_mass.alpha", 1.0)`.
pub fn paper(psi: f64, nodes: usize, parameters: &[(&str, f64)]) -> Model {
    Model::new(&paper_spec(psi, nodes, parameters)).expect("the paper's muscle is a model")
}

/// What [`paper`] is built from.
pub fn paper_spec(psi: f64, nodes: usize, parameters: &[(&str, f64)]) -> ModelSpec {
    let muscle = Muscle::built_in("garbulinski-2022").expect("it is built in");
    let at = muscle.at(psi * PSI, "pder_32", Extrapolation::Refused).expect("in the table");
    let fitting = muscle.end_fitting;
    let mut effects = vec![(
        "end_fitting".to_owned(),
        vec![("mass".to_owned(), fitting.mass), ("center_of_mass".to_owned(), fitting.center_of_mass)],
    )];
    effects.extend(parameters.iter().map(|(path, value)| {
        let (effect, key) = path.split_once('.').expect("effect.parameter");
        (effect.to_owned(), vec![(key.to_owned(), *value)])
    }));
    ModelSpec {
        nodes,
        rod: Rod {
            length: at.length,
            mass: muscle.rest.mass_per_length * muscle.rest.length,
            bending_stiffness: at.bending_stiffness,
            axial_stiffness: at.axial_stiffness,
            diameter: at.outer_diameter,
            pressure: at.pressure,
        },
        base_angle: 0.0,
        release_angle: 0.0,
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: fitting.center_of_mass,
        effects,
        catalogue: Default::default(),
        schedule: None,
    }
}

/// Runs a model that must come to its end.
pub fn simulate(model: &Model, run: &Run) -> Trajectory {
    forward(model, run, &mut |_| ControlFlow::Continue(())).expect("the run comes to its end")
}

/// Root mean square distance of two tip paths, m.
pub fn rms(a: &Trajectory, b: &Trajectory) -> f64 {
    assert_eq!(a.tip.len(), b.tip.len(), "sampled alike");
    let sum: f64 = a.tip.iter().zip(&b.tip).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum();
    (sum / a.tip.len() as f64).sqrt()
}

/// Slope of the straight line through `log(error)` over `log(size)`: the order of convergence.
pub fn order(sizes: &[f64], errors: &[f64]) -> f64 {
    let points: Vec<_> = sizes.iter().zip(errors).map(|(h, e)| (h.ln(), e.ln())).collect();
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let covariance: f64 = points.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum();
    covariance / points.iter().map(|p| (p.0 - mean.0).powi(2)).sum::<f64>()
}
