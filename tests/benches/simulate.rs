//! Cost of a release, side by side: 20 s of the 15 psi row, unless said otherwise.

use divan::Bencher;
use efam_core::forward::{FAST_TOLERANCE, Run};
use efam_core::integrate::{Method, Steps};
use tests::{paper, simulate};

fn main() {
    divan::main();
}

fn release(method: Method, tolerance: f64) -> Run {
    Run { method, tolerance, ..Run::release(20.0, 100.0) }
}

/// 32 nodes, tip within 0.05 mm rms of the same mesh.
#[divan::bench(args = [(Method::Rodas4, FAST_TOLERANCE), (Method::TrBdf2, 1e-5), (Method::Esdirk34, 1e-5)])]
fn same_mesh(bencher: Bencher, (method, tolerance): (Method, f64)) {
    let model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0)]);
    bencher.bench_local(|| simulate(&model, &release(method, tolerance)));
}

/// The same with stiffness damping, as of a real muscle.
#[divan::bench(args = [(Method::Rodas4, FAST_TOLERANCE), (Method::TrBdf2, 1e-5)])]
fn stiffness_damped(bencher: Bencher, (method, tolerance): (Method, f64)) {
    let model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 0.01)]);
    bencher.bench_local(|| simulate(&model, &release(method, tolerance)));
}

/// Tip within 0.05 mm rms of the converged answer, mesh included.
#[divan::bench]
fn converged(bencher: Bencher) {
    let model = paper(15.0, 72, &[("rayleigh_mass.alpha", 1.0)]);
    bencher.bench_local(|| simulate(&model, &release(Method::Rodas4, 1.5e-5)));
}

/// Default settings, with the energy budget.
#[divan::bench]
fn default_settings(bencher: Bencher) {
    let model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0)]);
    bencher.bench_local(|| simulate(&model, &Run { energy: true, ..Run::release(20.0, 100.0) }));
}

/// Without any loss: Verlet.
#[divan::bench]
fn undamped(bencher: Bencher) {
    let model = paper(15.0, 32, &[]);
    bencher.bench_local(|| simulate(&model, &Run::release(20.0, 100.0)));
}

/// Fixed steps, so that only the cost of a node shows.
#[divan::bench(args = [32, 64, 128, 256, 512])]
fn nodes(bencher: Bencher, nodes: usize) {
    let model = paper(15.0, nodes, &[("rayleigh_mass.alpha", 1.0)]);
    let run = Run { steps: Steps::Fixed(1e-3), ..release(Method::Rodas4, FAST_TOLERANCE) };
    bencher.bench_local(|| simulate(&model, &Run { duration: 1.0, samples: vec![1.0], ..run.clone() }));
}

/// Sensitivities by so many parameters.
#[divan::bench(args = [0, 1, 5, 10])]
fn sensitivities(bencher: Bencher, parameters: usize) {
    let model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 0.001)]);
    let run = Run { sensitivities: (2..2 + parameters).collect(), ..release(Method::Rodas4, FAST_TOLERANCE) };
    bencher.bench_local(|| simulate(&model, &run));
}
