//! Goal: the trajectory converges with the second power of the edge length at the consistent root,
//! and with the first at the paper's.
//! Setup: the 15 psi row with mass and stiffness damping, tip path of the first second.
//! Expected: slope of log error over log edge length at least 1.9 over four refinements from 32
//! edges on (coarser meshes are not yet asymptotic); the
//! reference is Richardson's from the two finest meshes, so that its own error is of fourth order.

use models::model::{Model, ModelSpec, Scheme};
use sim::forward::Run;
use tests::{order, paper_spec, simulate};

fn path(scheme: Scheme, edges: usize) -> Vec<[f64; 2]> {
    let damping = [("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 0.01)];
    let spec = ModelSpec { scheme, ..paper_spec(15.0, edges + 1, &damping) };
    let model = Model::new(&spec).expect("valid");
    simulate(&model, &Run { tolerance: 1e-8, ..Run::release(1.0, 50.0) }).tip
}

fn order_of(scheme: Scheme, power: f64) -> f64 {
    let (fine, finer) = (path(scheme, 256), path(scheme, 512));
    let scale = 1.0 / (2.0_f64.powf(power) - 1.0);
    let limit: Vec<[f64; 2]> =
        fine.iter().zip(&finer).map(|(a, b)| [0, 1].map(|k| b[k] + scale * (b[k] - a[k]))).collect();
    let meshes = [32, 45, 64, 91, 128];
    let error = |edges: &usize| {
        let path = path(scheme, *edges);
        let square: f64 =
            path.iter().zip(&limit).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum();
        (square / limit.len() as f64).sqrt()
    };
    let errors: Vec<f64> = meshes.iter().map(error).collect();
    let sizes: Vec<f64> = meshes.iter().map(|n| 1.0 / *n as f64).collect();
    order(&sizes, &errors)
}

#[test]
fn second_at_the_consistent_root() {
    let found = order_of(Scheme::Consistent, 2.0);
    assert!((1.9..2.2).contains(&found), "{found}");
}

#[test]
fn first_at_the_papers_root() {
    let found = order_of(Scheme::Paper, 1.0);
    assert!((0.85..1.2).contains(&found), "{found}");
}
