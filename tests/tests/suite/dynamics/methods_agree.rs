//! All integrators give one trajectory: ours, and diffsol's, which share
//! the equations but neither the formulas of its stages nor its error control.

use efam_core::forward::Run;
use efam_core::integrate::Method;
use tests::{paper, rms, simulate};

#[test]
fn at_the_tip_within_a_twentieth_of_a_millimetre() {
    let effects = [
        ("rayleigh_mass.alpha", 1.0),
        ("air_drag.drag_coefficient", 1.2),
        ("viscoelastic.branch_stiffness", 0.2),
        ("clamp_compliance.compliance", 1.0),
    ];
    for parameters in [&effects[..1], &effects[..]] {
        let model = paper(15.0, 32, parameters);
        let path =
            |method, tolerance| simulate(&model, &Run { method, tolerance, ..Run::release(5.0, 100.0) });
        let reference = path(Method::Esdirk34, 1e-8);
        for (method, tolerance) in [(Method::Rodas4, 3e-5), (Method::TrBdf2, 1e-5), (Method::Esdirk34, 1e-5)]
        {
            let distance = rms(&path(method, tolerance), &reference);
            assert!(distance < 0.05e-3, "{method:?}: {} mm", distance * 1e3);
        }
    }
}

/// Verlet shares nothing with the implicit methods. With damping off, two seconds stay predictable.
#[test]
fn without_loss_within_a_twentieth_of_a_millimetre() {
    let model = paper(40.0, 16, &[]);
    let path = |method, tolerance| simulate(&model, &Run { method, tolerance, ..Run::release(1.0, 100.0) });
    let distance = rms(&path(Method::Verlet, 0.0), &path(Method::Rodas4, 1e-8));
    assert!(distance < 0.05e-3, "{} mm", distance * 1e3);
}
