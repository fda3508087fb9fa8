//! Goal: the trajectory converges with at least the third power of the edge length by the consistent scheme, and with
//! the first by the paper's.
//! Setup: the 15 psi row with mass and stiffness damping, tip path of the first second.
//! Expected: slope of log error over log edge length at least 3 from 8 to 32 edges, where the error falls from some
//! 0.1 mm to below 1 µm; about 1 by the paper's scheme, from 32 to 128 edges. The
//! reference is Richardson's from two finer meshes.

use efam_core::forward::Run;
use models::model::{Model, ModelSpec, Scheme};
use tests::{order, paper_spec, simulate};

fn path(scheme: Scheme, edges: usize) -> Vec<[f64; 2]> {
    let damping = [("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 0.01)];
    let spec = ModelSpec { scheme, ..paper_spec(15.0, edges + 1, &damping) };
    let model = Model::new(&spec).expect("valid");
    simulate(&model, &Run { tolerance: 1e-10, ..Run::release(1.0, 50.0) }).tip
}

fn order_of(scheme: Scheme, power: f64, meshes: [usize; 5]) -> f64 {
    let (fine, finer) = (path(scheme, 2 * meshes[4]), path(scheme, 4 * meshes[4]));
    let scale = 1.0 / (2.0_f64.powf(power) - 1.0);
    let limit: Vec<[f64; 2]> =
        fine.iter().zip(&finer).map(|(a, b)| [0, 1].map(|k| b[k] + scale * (b[k] - a[k]))).collect();
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
fn third_at_least_by_the_consistent_scheme() {
    let found = order_of(Scheme::Consistent, 3.0, [8, 11, 16, 22, 32]);
    assert!((3.0..5.0).contains(&found), "{found}");
}

#[test]
fn first_by_the_papers_scheme() {
    let found = order_of(Scheme::Paper, 1.0, [32, 45, 64, 91, 128]);
    assert!((0.85..1.2).contains(&found), "{found}");
}
