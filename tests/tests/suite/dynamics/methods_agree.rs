//! The explicit and the implicit integrator give one trajectory; with diffsol's methods ours is compared in the core's tests.

use efam_core::forward::Run;
use efam_core::integrate::Method;
use tests::{paper, rms, simulate};

/// Verlet shares nothing with the implicit methods. With damping off, two seconds stay predictable.
#[test]
fn without_loss_within_a_twentieth_of_a_millimetre() {
    let model = paper(40.0, 16, &[]);
    let path = |method, tolerance| simulate(&model, &Run { method, tolerance, ..Run::release(1.0, 100.0) });
    let distance = rms(&path(Method::Verlet, 0.0), &path(Method::Rodas4, 1e-8));
    assert!(distance < 0.05e-3, "{} mm", distance * 1e3);
}
