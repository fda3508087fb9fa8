//! What the settings of fits and sweeps are worth: the tip of the 15 psi row with mass damping alone
//! over 20 s, within 0.05 mm rms of the same mesh at a tight tolerance, and with 72 nodes within
//! 0.05 mm rms of the converged answer, which is Richardson's from 128 and 256 edges.

use efam_core::forward::{FAST_TOLERANCE, Run};
use models::model::Model;
use tests::{paper, rms, simulate};

fn muscle(nodes: usize) -> Model {
    paper(15.0, nodes, &[("rayleigh_mass.alpha", 1.0)])
}

fn with(tolerance: f64) -> Run {
    Run { tolerance, ..Run::release(20.0, 100.0) }
}

#[test]
fn fast_settings_keep_a_twentieth_of_a_millimetre_on_the_same_mesh() {
    let model = muscle(32);
    let distance = rms(&simulate(&model, &with(FAST_TOLERANCE)), &simulate(&model, &with(1e-7)));
    assert!(distance < 0.05e-3, "{} mm", distance * 1e3);
}

#[test]
fn with_72_nodes_they_keep_it_mesh_included() {
    let (fine, mut limit) = (simulate(&muscle(129), &with(1e-6)), simulate(&muscle(257), &with(1e-6)));
    for (finer, fine) in limit.tip.iter_mut().zip(&fine.tip) {
        *finer = [0, 1].map(|k| finer[k] + (finer[k] - fine[k]) / 3.0);
    }
    let distance = rms(&simulate(&muscle(72), &with(1.5e-5)), &limit);
    assert!(distance < 0.05e-3, "{} mm", distance * 1e3);
}
