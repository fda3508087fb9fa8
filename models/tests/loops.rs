//! Goal: what a cross-section loses in a cycle, law by law, over its size and over its rate.
//! Setup: curvature κ_0 + κ_a sin ωt; memories by Runge and Kutta's fourth-order method, steps ending at
//! the turns.
//! Expected: the closed loop of moment over curvature has the area that each test derives, J/m. Areas
//! are sums over 4000 points of a cycle, right to some 1e-6.

use std::f64::consts::PI;

use models::effects::braid_friction::BraidFriction;
use models::effects::clamp_friction::ClampFriction;
use models::effects::creep::Creep;
use models::effects::dahl::Dahl;
use models::effects::hysteresis::Hysteresis;
use models::effects::relaxation::Relaxation;
use models::effects::strain_rate_cubed::StrainRateCubed;
use models::effects::structural_damping::StructuralDamping;
use models::effects::{Bend, Law, Rod};

const ROD: Rod<f64> = Rod {
    length: 0.2,
    mass: 0.03,
    bending_stiffness: 0.008,
    axial_stiffness: 40.0,
    diameter: 0.027,
    pressure: 0.0,
};
const STEPS: usize = 4000;

/// The last of some cycles: its area, J/m, and the part of the moment in phase with the curvature
/// over it, N m².
struct Loop {
    area: f64,
    stiffness: f64,
}

/// Area of the last of some cycles about the straight rod.
fn area<L: Law>(law: &L, theta: &[f64], position: f64, amplitude: f64, omega: f64) -> f64 {
    cycle(law, theta, position, 0.0, amplitude, omega).area
}

/// Cycles about a curvature `rest`, at which the memories are relaxed before: all branches of the law.
fn cycle<L: Law>(law: &L, theta: &[f64], position: f64, rest: f64, amplitude: f64, omega: f64) -> Loop {
    let step = 2.0 * PI / (omega * STEPS as f64);
    let mut found = Loop { area: 0.0, stiffness: 0.0 };
    for branch in 0..L::ABOUT.memory.max(1) {
        let at = |phase: f64, memory: f64| {
            let angle = 2.0 * PI * phase / STEPS as f64;
            let kappa_rate = amplitude * omega * angle.cos();
            let kappa = rest + amplitude * angle.sin();
            (law.bend(&bend(kappa, kappa_rate, branch, memory, position), theta), kappa_rate)
        };
        // A branch relaxes to the curvature, friction to none.
        let relaxes = law.bend(&bend(rest, 0.0, branch, rest, position), theta).moment == 0.0;
        let mut memory = if relaxes { rest } else { 0.0 };
        for cycle in 0..6 {
            for k in 0..STEPS {
                let (law, kappa_rate) = at(k as f64, memory);
                if cycle == 5 {
                    let phase = (2.0 * PI * k as f64 / STEPS as f64).sin();
                    found.area += law.moment * kappa_rate * step;
                    found.stiffness += law.moment * phase * 2.0 / (amplitude * STEPS as f64);
                }
                let a = law.memory_rate;
                let b = at(k as f64 + 0.5, memory + 0.5 * step * a).0.memory_rate;
                let c = at(k as f64 + 0.5, memory + 0.5 * step * b).0.memory_rate;
                let d = at(k as f64 + 1.0, memory + step * c).0.memory_rate;
                memory += step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
            }
        }
    }
    found
}

fn bend(kappa: f64, kappa_rate: f64, branch: usize, memory: f64, position: f64) -> Bend<'static, f64> {
    Bend { kappa, kappa_rate, branch, memory, position, time: 0.0, mean_square_curvature: 0.0, rod: &ROD }
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
        assert_near(area(&BraidFriction, &[friction, creep_rate], 0.5, amplitude, omega), expected, 1e-4);
        let found = area(&ClampFriction, &[friction, 0.02, creep_rate], 0.1, amplitude, omega);
        assert_near(found, expected * (-1.0_f64).exp(), 1e-4);
    }
}

/// Below the rate of creeping friction is viscous: `M = M_f κ̇/κ̇₀` loses `π M_f κ_a² ω/κ̇₀`.
#[test]
fn what_sticks_creeps() {
    let (friction, creep_rate, amplitude, omega) = (7e-4, 10.0, 0.3, 1.0);
    let found = area(&BraidFriction, &[friction, creep_rate], 0.5, amplitude, omega);
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
            let found = area(&Hysteresis, &[eta, 1e-4], 0.5, amplitude, omega);
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
    fn lost<L: Law>(law: &L, theta: &[f64], kappa: f64, kappa_rate: f64, memory: f64) -> f64 {
        let at = |kappa: f64, memory: f64| bend(kappa, kappa_rate, 0, memory, 0.1);
        let found = law.bend(&at(kappa, memory), theta);
        // Energies are of second order in z and smooth in κ: central differences are right to 1e-8.
        let step = 1e-6;
        let energy = |sign: f64| {
            let time = sign * step / (kappa_rate.abs() + 1.0);
            law.bend_energy(&at(kappa + kappa_rate * time, memory + found.memory_rate * time), theta)
        };
        let stored = (energy(1.0) - energy(-1.0)) / (2.0 * step) * (kappa_rate.abs() + 1.0);
        found.moment * kappa_rate - stored
    }
    for kappa in [-3.0, -0.02, -0.003, 0.0, 0.001, 0.005, 0.05, 8.0] {
        for kappa_rate in [-80.0, -1.0, -1e-3, 0.0, 1e-4, 0.3, 40.0] {
            for memory in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                let friction = [
                    lost(&BraidFriction, &[1e-3, 0.02], kappa, kappa_rate, memory),
                    lost(&ClampFriction, &[1e-3, 0.02, 0.02], kappa, kappa_rate, memory),
                    lost(&Dahl, &[1e-3, 0.5, 0.02, 1.0, 1.0], kappa, kappa_rate, memory),
                    lost(&Dahl, &[1e-3, 0.5, 0.02, 2.5, 0.5], kappa, kappa_rate, memory),
                    lost(&Dahl, &[1e-3, 0.5, 0.02, 1.3, 4.0], kappa, kappa_rate, memory),
                    lost(&Hysteresis, &[0.05, 0.02], kappa, kappa_rate, memory),
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
                area(&Dahl, &[friction, yielding, 1e-7, 1.0, 1.0], 0.5, amplitude, omega),
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
        assert_near(area(&StrainRateCubed, &[coefficient], 0.5, amplitude, omega), expected, 1e-9);
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
        assert_near(area(&Creep, &[share, time], 0.5, 2.0, ratio / time), expected, tolerance);
    }
}

/// A cycle loses `π G'' κ_a²`, and `G''/G'` is the loss factor: the same within the 3 % of its page over two
/// and a half decades of frequency, for weak and strong losses, about a straight and a bent rest and at
/// every amplitude. Relaxed at rest, it adds no stiffness.
#[test]
fn structural_damping_has_one_loss_factor_at_every_frequency_amplitude_and_rest() {
    for loss in [0.01, 0.1, 0.2, 0.3] {
        for decade in 0..=10 {
            let frequency = 3.0 * 10.0_f64.powf(2.5 * (f64::from(decade) / 10.0 - 0.5));
            for (rest, amplitude) in [(0.0, 2.0), (0.0, 0.01), (5.0, 0.05)] {
                let theta = [loss, 3.0];
                let found = cycle(&StructuralDamping, &theta, 0.5, rest, amplitude, 2.0 * PI * frequency);
                let storage = ROD.bending_stiffness + found.stiffness;
                let factor = found.area / (PI * amplitude * amplitude * storage);
                assert_near(factor, loss, 0.03);
            }
        }
        // Slower than the longest time, 1.1 s: ω²τ² = 0.075 of that branch's 1.6 to 2 η is in phase.
        let slow = cycle(&StructuralDamping, &[loss, 3.0], 0.5, 5.0, 0.1, 0.25);
        assert!(slow.stiffness < 0.16 * loss * ROD.bending_stiffness, "{}", slow.stiffness);
    }
}

/// About a bent rest the friction moment of `hysteresis` hardly changes over a small cycle: it loses
/// `4 η EI κ_0 (κ_a − κ_b)`, as Coulomb's friction does, which is no fixed share of `½ EI κ_a²`.
#[test]
fn hysteresis_is_coulomb_friction_about_a_bent_rest() {
    let (eta, rest) = (0.04, 5.0);
    for amplitude in [0.1, 0.5, 1.0] {
        let found = cycle(&Hysteresis, &[eta, 1e-4], 0.5, rest, amplitude, 10.0).area;
        let expected = 4.0 * eta * ROD.bending_stiffness * rest * (amplitude - BRISTLE);
        // The friction moment at the two turns differs by 2 κ_a/κ_0: its mean stays, to second order.
        assert_near(found, expected, 2e-4 + BRISTLE / rest);
    }
}

/// At a curvature that stays the moment falls as the box spectrum says,
/// `g EI ∫ exp(−t/τ) d ln τ / ln(τ_l/τ_s)` from τ_s to τ_l, within the 1 % of its page.
#[test]
fn relaxation_is_even_over_the_logarithm_of_time() {
    let (share, shortest, longest): (f64, f64, f64) = (0.4, 0.05, 20.0);
    let (kappa, step) = (2.0, 0.002);
    let due = |time: f64| {
        let count = 2000;
        let decay = |k: i32| {
            let log = (f64::from(k) + 0.5) / f64::from(count);
            (-time / (shortest * (longest / shortest).powf(log))).exp()
        };
        (0..count).map(decay).sum::<f64>() / f64::from(count)
    };
    let theta = [share, shortest, longest];
    let mut memory = [0.0; 4];
    for k in 0..40_000 {
        let mut found = 0.0;
        for (branch, memory) in memory.iter_mut().enumerate() {
            let law = Relaxation.bend(&bend(kappa, 0.0, branch, *memory, 0.5), &theta);
            found += law.moment / (share * ROD.bending_stiffness * kappa);
            let half = *memory + 0.5 * step * law.memory_rate;
            *memory += step * Relaxation.bend(&bend(kappa, 0.0, branch, half, 0.5), &theta).memory_rate;
        }
        if k % 50 == 0 {
            let due = due(step * f64::from(k));
            assert!((found - due).abs() < 0.01, "{} s: {found}, due {due}", step * f64::from(k));
        }
    }
}

/// Bouc and Wen's loops in closed form. With `n = 2`, `σ = 1` a half loop from `−z_m` to `z_m` takes the way
/// `κ_y (atan z_m + artanh z_m) = 2 κ_a`, and the area is `−M_f κ_y ln(1 − z_m⁴)`. With `n = 1` and
/// `c = 2σ − 1` it takes `κ_y (ln(1 + c z_m)/c − ln(1 − z_m)) = 2 κ_a`, and the area is
/// `2 M_f κ_y (−z_m − ln(1 − z_m) − z_m/c + ln(1 + c z_m)/c²)`.
#[test]
fn bouc_and_wens_loops_have_the_areas_of_their_solutions() {
    let (friction, yielding) = (7e-4, 0.5);
    // Where the way is that of `due`, by halving.
    let solve = |way: &dyn Fn(f64) -> f64, due: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if way(middle) < due { low = middle } else { high = middle }
        }
        low
    };
    for amplitude in [0.4, 1.0, 2.0] {
        let due = 2.0 * amplitude / yielding;
        let z = solve(&|z: f64| z.atan() + z.atanh(), due);
        let expected = -friction * yielding * (1.0 - z.powi(4)).ln();
        let found = area(&Dahl, &[friction, yielding, 1e-7, 2.0, 1.0], 0.5, amplitude, 20.0);
        assert_near(found, expected, 1e-3);
        for shape in [0.7, 2.0, 5.0] {
            let c = 2.0 * shape - 1.0;
            let z = solve(&|z: f64| (c * z).ln_1p() / c - (1.0 - z).ln(), due);
            let expected =
                2.0 * friction * yielding * (-z - (1.0 - z).ln() - z / c + (c * z).ln_1p() / (c * c));
            let found = area(&Dahl, &[friction, yielding, 1e-7, 1.0, shape], 0.5, amplitude, 20.0);
            // In the smallest loop the start is forgotten slowly.
            assert_near(found, expected, if amplitude < yielding { 0.02 } else { 1e-3 });
        }
    }
}
