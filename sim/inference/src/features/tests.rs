//! Features of made-up swings.

use efam_experiments::release::{Point, Track};

use super::*;
use crate::example;

/// A decaying swing about a rest, with a second coordinate that follows it.
pub fn swing(frequency: f64, loss: f64, noise: impl Fn(usize) -> [f64; 2]) -> Release {
    let time: Vec<f64> = (0..800).map(|k| 0.01 * k as f64).collect();
    let position = time.iter().enumerate().map(|(k, t)| {
        let q = 0.1 * (-loss * t).exp() * (std::f64::consts::TAU * frequency * t).cos();
        let [x, z] = noise(k);
        Some([0.1 + 0.2 * q - 0.5 * q * q + x, -0.05 + q + z])
    });
    let track = Track {
        marker: "tip".to_owned(),
        at: Point::Tip,
        position: position.collect(),
        noise: 1e-4,
        discrepancy: 0.0,
    };
    example::release(time, vec![track])
}

#[test]
fn a_decaying_swing_shows_its_frequency_and_loss() {
    let plan = Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap();
    for (what, value) in plan.features.iter().zip(&plan.values) {
        match what {
            What::Frequency { .. } => assert!((value - 1.4f64.ln()).abs() < 1e-3, "{what:?} {value}"),
            What::Damping { .. } => {
                let due = 0.3 / (std::f64::consts::TAU * 1.4);
                assert!((value - due).abs() < 1e-3, "{what:?} {value} {due}");
            }
            _ => {}
        }
    }
    assert!(plan.features.contains(&What::Damping { window: 2 }), "{:?}", plan.features);
}

/// Features change smoothly with the frequency of a simulated track: second differences over small steps are as the step's
/// square, with no jump where a sample enters a window.
#[test]
fn features_are_smooth_in_the_frequency() {
    let plan = Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap();
    let of = |frequency: f64| {
        let position = |_: usize, k: usize| {
            let t = plan.time[k];
            let q = 0.1 * (-0.3 * t).exp() * (std::f64::consts::TAU * frequency * t).cos();
            [0.1 + 0.2 * q - 0.5 * q * q, -0.05 + q]
        };
        plan.simulated(&plan.coordinates(&position, plan.time.len())).values
    };
    // The window of half the step has a quarter of the second difference; a jump would have all of it.
    let steps: Vec<Vec<f64>> = (0..60).map(|k| of(1.3 + 0.002 * f64::from(k))).collect();
    for f in 0..plan.features.len() {
        let bend = |k: usize| steps[k - 1][f] - 2.0 * steps[k][f] + steps[k + 1][f];
        let change = (steps[59][f] - steps[0][f]).abs().max(1e-3 * plan.scales[f]);
        let worst = (1..59).map(|k| bend(k).abs()).fold(0.0, f64::max);
        assert!(worst < 0.02 * change, "{:?}: {worst} of {change}", plan.features[f]);
    }
}

/// The derivative along a movement is that of a difference of two tracks.
#[test]
fn a_derivative_along_a_movement_is_a_difference() {
    let plan = Plan::of(&swing(1.4, 0.3, |_| [0.0; 2]), false).unwrap();
    let of = |frequency: f64| {
        let position = |_: usize, k: usize| {
            let t = plan.time[k];
            let q = 0.1 * (-0.3 * t).exp() * (std::f64::consts::TAU * frequency * t).cos();
            [0.1 + 0.2 * q, -0.05 + q]
        };
        plan.coordinates(&position, plan.time.len())
    };
    let (here, there) = (of(1.4), of(1.4 + 1e-6));
    let movement: Vec<Vec<f64>> = here
        .iter()
        .zip(&there)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| (b - a) / 1e-6).collect())
        .collect();
    let at = plan.simulated(&here);
    let slopes = plan.along(&here, &at, &movement);
    let (low, high) = (plan.simulated(&of(1.399)), plan.simulated(&of(1.401)));
    for (f, slope) in slopes.iter().enumerate() {
        let due = (high.values[f] - low.values[f]) / 0.002;
        let size = due.abs().max(0.1 * plan.scales[f]);
        assert!((slope - due).abs() < 0.01 * size, "{:?}: {slope}, due {due}", plan.features[f]);
    }
}

/// Odd data: too short, without a swing, with gaps, not a number. No panic, and no features where there is no swing.
#[test]
fn odd_releases_have_no_features() {
    let mut release = swing(1.4, 0.3, |_| [0.0; 2]);
    release.tracks[0].position[5] = Some([f64::NAN, 0.0]);
    release.tracks[0].position[100] = None;
    assert!(Plan::of(&release, false).is_some());
    release.tracks[0].position.iter_mut().for_each(|at| *at = Some([0.1, 0.2]));
    assert!(Plan::of(&release, false).is_none());
    release.tracks[0].position.iter_mut().for_each(|at| *at = None);
    assert!(Plan::of(&release, true).is_none());
    assert!(Plan::of(&example::release(Vec::new(), Vec::new()), false).is_none());
}

/// Turns that a refinement has brought out of order bound no window: no loss, and no panic.
#[test]
fn turns_out_of_order_have_no_loss() {
    let plan = Plan::of(&swing(1.4, 0.1, |_| [0.0; 2]), false).unwrap();
    let loss = |turns: &[f64]| plan.loss(&plan.time, &plan.recorded[0], turns, 0, 2);
    assert_eq!(loss(&[1.0, 0.8, 0.5]), 0.0);
    assert_eq!(loss(&[1.0, f64::NAN, f64::NAN]), 0.0);
    assert!(loss(&[0.35, 0.7, 1.05]) > 0.0);
}
