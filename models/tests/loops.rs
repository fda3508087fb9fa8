//! Goal: what a cross-section loses in a cycle, law by law, over its size and over its rate.
//! Setup: curvature κ_a sin ωt; memory by Runge and Kutta's fourth-order method, steps ending at the turns.
//! Expected: the closed loop of moment over curvature has the area that each test derives, J/m. Areas
//! are sums over 4000 points of a cycle, right to some 1e-6.

use std::f64::consts::PI;

use models::effects::braid_friction::BraidFriction;
use models::effects::clamp_friction::ClampFriction;
use models::effects::creep::Creep;
use models::effects::dahl::Dahl;
use models::effects::hysteresis::Hysteresis;
use models::effects::strain_rate_cubed::StrainRateCubed;
use models::effects::{Bend, Law, Moment, Rod};

const ROD: Rod<f64> = Rod {
    length: 0.2,
    mass: 0.03,
    bending_stiffness: 0.008,
    axial_stiffness: 40.0,
    diameter: 0.027,
    pressure: 0.0,
};
const STEPS: usize = 4000;

/// Area of the last of some cycles.
fn area<L: Law>(theta: &[f64], position: f64, amplitude: f64, omega: f64) -> f64 {
    let step = 2.0 * PI / (omega * STEPS as f64);
    let at = |phase: f64, memory: f64| -> (Moment<f64>, f64) {
        let angle = 2.0 * PI * phase / STEPS as f64;
        let kappa_rate = amplitude * omega * angle.cos();
        let bend = Bend {
            kappa: amplitude * angle.sin(),
            kappa_rate,
            memory,
            position,
            time: 0.0,
            mean_square_curvature: 0.0,
            rod: &ROD,
        };
        (L::bend(&bend, theta), kappa_rate)
    };
    let mut memory = 0.0;
    let mut area = 0.0;
    for _cycle in 0..6 {
        area = 0.0;
        for k in 0..STEPS {
            let (law, kappa_rate) = at(k as f64, memory);
            area += law.moment * kappa_rate * step;
            let a = law.memory_rate;
            let b = at(k as f64 + 0.5, memory + 0.5 * step * a).0.memory_rate;
            let c = at(k as f64 + 0.5, memory + 0.5 * step * b).0.memory_rate;
            let d = at(k as f64 + 1.0, memory + step * c).0.memory_rate;
            memory += step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
    }
    area
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} against {expected}");
}

/// Curvature over which friction turns round, 1/m.
const BRISTLE: f64 = 0.01;

/// From turn to turn `1 − z` falls as `exp(−κ/κ_b)`, so at each turn `2 κ_b` of the way count for
/// nothing: `4 M_f (κ_a − κ_b)`, at any rate well above that of creeping.
#[test]
fn coulomb_friction_loses_four_amplitudes_at_any_rate() {
    let (friction, creep_rate, amplitude) = (7e-4, 1e-4, 3.0);
    for omega in [0.2, 2.0, 200.0] {
        let expected = 4.0 * friction * (amplitude - BRISTLE);
        assert_near(area::<BraidFriction>(&[friction, creep_rate], 0.5, amplitude, omega), expected, 1e-4);
        let found = area::<ClampFriction>(&[friction, 0.02, creep_rate], 0.1, amplitude, omega);
        assert_near(found, expected * (-1.0_f64).exp(), 1e-4);
    }
}

/// Below the rate of creeping friction is viscous: `M = M_f κ̇/κ̇₀` loses `π M_f κ_a² ω/κ̇₀`.
#[test]
fn what_sticks_creeps() {
    let (friction, creep_rate, amplitude, omega) = (7e-4, 10.0, 0.3, 1.0);
    let found = area::<BraidFriction>(&[friction, creep_rate], 0.5, amplitude, omega);
    let expected = PI * friction * amplitude * amplitude * omega / creep_rate;
    // The step bends by 3/8 of the squared ratio of the rates, 0.03.
    assert_near(found, expected, 1e-3);
}

/// `∮ η EI |κ| |dκ| = 2 η EI κ_a²`, of the energy ½ EI κ_a² that is 4 η; less the turns, at each of
/// which `2 κ_b` of the way count for nothing.
#[test]
fn hysteresis_loses_the_same_share_at_any_rate_and_size() {
    let eta = 0.04;
    for omega in [2.0, 200.0] {
        for amplitude in [0.1, 0.3, 3.0] {
            let found = area::<Hysteresis>(&[eta, 1e-4], 0.5, amplitude, omega);
            let stored = 0.5 * ROD.bending_stiffness * amplitude * amplitude;
            let ratio: f64 = BRISTLE / amplitude;
            // Of second order: the turn's friction moment falls along 2 κ_b, and √(κ² + κ_b²) is more
            // than |κ|.
            let second = ratio * ratio * (2.5 + (2.0 / ratio).ln());
            let tolerance = 2.0 * ratio.powi(3) + 1e-4;
            assert_near(found / stored, 4.0 * eta * (1.0 - 2.0 * ratio + second), tolerance);
        }
    }
}

/// What is not stored is lost, at any curvature, rate and memory: also where hysteresis passes through
/// straight, and its friction moment with it.
#[test]
fn friction_never_feeds_energy() {
    fn lost<L: Law>(theta: &[f64], kappa: f64, kappa_rate: f64, memory: f64) -> f64 {
        let at = |kappa: f64, memory: f64| Bend {
            kappa,
            kappa_rate,
            memory,
            position: 0.1,
            time: 0.0,
            mean_square_curvature: 0.0,
            rod: &ROD,
        };
        let law = L::bend(&at(kappa, memory), theta);
        // Energies are of second order in z and smooth in κ: central differences are right to 1e-8.
        let step = 1e-6;
        let energy = |sign: f64| {
            let time = sign * step / (kappa_rate.abs() + 1.0);
            L::bend_energy(&at(kappa + kappa_rate * time, memory + law.memory_rate * time), theta)
        };
        let stored = (energy(1.0) - energy(-1.0)) / (2.0 * step) * (kappa_rate.abs() + 1.0);
        law.moment * kappa_rate - stored
    }
    for kappa in [-3.0, -0.02, -0.003, 0.0, 0.001, 0.005, 0.05, 8.0] {
        for kappa_rate in [-80.0, -1.0, -1e-3, 0.0, 1e-4, 0.3, 40.0] {
            for memory in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                let friction = [
                    lost::<BraidFriction>(&[1e-3, 0.02], kappa, kappa_rate, memory),
                    lost::<ClampFriction>(&[1e-3, 0.02, 0.02], kappa, kappa_rate, memory),
                    lost::<Dahl>(&[1e-3, 0.5, 0.02], kappa, kappa_rate, memory),
                    lost::<Hysteresis>(&[0.05, 0.02], kappa, kappa_rate, memory),
                ];
                for (law, lost) in friction.iter().enumerate() {
                    assert!(
                        *lost > -1e-9 * (1.0 + kappa_rate.abs()),
                        "{law}: {lost} at {kappa}, {kappa_rate}, {memory}"
                    );
                }
            }
        }
    }
}

/// From turn to turn `1 − z` falls as `exp(−κ/κ_y)`, so the closed loop turns at `z = tanh(κ_a/κ_y)`
/// and has the area `4 M_f (κ_a − κ_y tanh(κ_a/κ_y))`. For small swings it goes with the third power:
/// their friction is elastic.
#[test]
fn dahl_friction_loses_less_than_coulomb_s_in_small_swings() {
    let (friction, yielding) = (7e-4, 0.5);
    for omega in [0.01, 200.0] {
        for amplitude in [0.05, 0.5, 5.0] {
            let expected = 4.0 * friction * (amplitude - yielding * f64::tanh(amplitude / yielding));
            // In the smallest loop the start is forgotten slowly: 1 − κ_a/κ_y a half cycle at most.
            let tolerance = if amplitude < yielding { 0.05 } else { 1e-5 };
            assert_near(
                area::<Dahl>(&[friction, yielding, 1e-7], 0.5, amplitude, omega),
                expected,
                tolerance,
            );
        }
    }
}

/// `∮ EI c₃ κ̇³ dκ = ¾ π EI c₃ ω³ κ_a⁴`.
#[test]
fn the_cube_of_the_rate_loses_with_the_fourth_power_of_the_swing() {
    let coefficient = 1e-7;
    for (amplitude, omega) in [(1.0_f64, 8.0_f64), (3.0, 8.0), (3.0, 50.0)] {
        let expected = 0.75 * PI * ROD.bending_stiffness * coefficient * omega.powi(3) * amplitude.powi(4);
        assert_near(area::<StrainRateCubed>(&[coefficient], 0.5, amplitude, omega), expected, 1e-9);
    }
}

/// Zener's loss, `π g EI κ_a² ωτ / (1 + ω²τ²)`: largest at ωτ = 1, and hardly any in a swing.
#[test]
fn creep_loses_most_at_its_own_time() {
    let (share, time) = (0.1, 30.0);
    for ratio in [0.2, 1.0, 5.0] {
        let expected = PI * share * ROD.bending_stiffness * 4.0 * ratio / (1.0 + ratio * ratio);
        // Six cycles forget the start as exp(−12π/ωτ).
        let tolerance = 1e-6 + (-12.0 * PI / ratio).exp() * 10.0;
        assert_near(area::<Creep>(&[share, time], 0.5, 2.0, ratio / time), expected, tolerance);
    }
}
