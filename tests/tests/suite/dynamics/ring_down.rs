//! Goal: a small swing rings down with ζ = α/(2ω) + βω/2.
//! Setup: the 40 psi row, 32 nodes, started from a posture of rest with the first mode added, at an
//! amplitude of a thousandth of the length, so that geometry stays linear to 1e-6.
//! Expected: frequency and damping ratio from successive zero crossings and peaks within 1 %.
//! Source: Clough and Penzien (2003), section 12-3.

use efam_core::forward::{Initial, Run};
use models::model::Model;
use models::posture::Posture;
use models::statics::{Mode, equilibrium, modes};
use models::system::System;
use tests::{paper, simulate};

fn first_mode(model: &Model) -> (Mode, Posture<f64>) {
    let rest = equilibrium(model, None).expect("it hangs");
    let mode = modes(model, &rest, 1).expect("stable").remove(0);
    let amplitude = 1e-3 * model.rod().length / mode.shape.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let q: Vec<f64> = rest.q.iter().zip(&mode.shape).map(|(q, x)| q + amplitude * x).collect();
    let at_rest = vec![0.0; q.len()];
    let posture = System::new(model).assembly.posture(&q, &at_rest);
    (mode, posture)
}

#[test]
fn at_the_rate_of_mass_and_stiffness_damping() {
    let (alpha, beta) = (0.4, 0.004);
    let model = paper(40.0, 32, &[("rayleigh_mass.alpha", alpha), ("rayleigh_stiffness.beta", beta)]);
    let (mode, posture) = first_mode(&model);
    let omega = mode.angular_frequency;
    // Geometric stiffness is not damped, so β acts on the material share of ω² only: the projection
    // knows it; for a rod that hangs nearly straight the two differ little.
    let expected = mode.damping_ratio;
    let run = Run { initial: Initial::Posture(posture), tolerance: 1e-9, ..Run::release(10.0, 1000.0) };
    let path = simulate(&model, &run);
    let rest = equilibrium(&model, None).expect("it hangs");
    let system = System::new(&model);
    let z_rest = system.observed_tip(&rest.q, &vec![0.0; rest.q.len()]).0[1];
    let z: Vec<f64> = path.tip_z().iter().map(|z| z - z_rest).collect();
    let peaks: Vec<(f64, f64)> = (1..z.len() - 1)
        .filter(|&k| z[k] > 0.0 && z[k] > z[k - 1] && z[k] >= z[k + 1])
        .map(|k| {
            let bend = z[k - 1] - 2.0 * z[k] + z[k + 1];
            let shift = 0.5 * (z[k - 1] - z[k + 1]) / bend;
            (path.times[k] + shift * 1e-3, z[k] - 0.25 * (z[k - 1] - z[k + 1]) * shift)
        })
        .collect();
    let (first, last) = (peaks[0], peaks[peaks.len() - 1]);
    let cycles = (peaks.len() - 1) as f64;
    let decrement = (first.1 / last.1).ln() / cycles / std::f64::consts::TAU;
    let ratio = decrement / (1.0 + decrement * decrement).sqrt();
    assert!((ratio / expected - 1.0).abs() < 0.01, "damping ratio {ratio} against {expected}");
    let damped = std::f64::consts::TAU * cycles / (last.0 - first.0);
    let natural = damped / (1.0 - ratio * ratio).sqrt();
    assert!((natural / omega - 1.0).abs() < 0.01, "{natural} against {omega} rad/s");
}

/// Without weight all stiffness is material, and Rayleigh's formula holds exactly.
#[test]
fn without_weight_modes_have_rayleighs_damping_ratio() {
    let (alpha, beta) = (0.4, 0.004);
    let model = paper(
        40.0,
        32,
        &[("rayleigh_mass.alpha", alpha), ("rayleigh_stiffness.beta", beta), ("gravity.acceleration", 0.0)],
    );
    let rest = equilibrium(&model, None).expect("straight");
    for mode in modes(&model, &rest, 3).expect("stable") {
        let omega = mode.angular_frequency;
        let expected = alpha / (2.0 * omega) + beta * omega / 2.0;
        assert!(
            (mode.damping_ratio / expected - 1.0).abs() < 1e-6,
            "{} against {expected}",
            mode.damping_ratio
        );
    }
}
