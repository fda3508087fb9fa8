//! Goal: what is hidden in a twin changes frequency and decay of small swings as closed forms say.
//! Setup: a rod of hardly any mass with a body at its end, without gravity, struck so that it swings by
//! some millimetres: `m ω² = 3 EI / L³`, curvature `κ = K (1 − s/L)`, `K = 3 A / L²`.
//! Expected: ratios of frequencies with and without an effect; loss of amplitude in a cycle from the
//! energy that a harmonic swing gives away. Swings are small, by a fiftieth of the length: what is
//! neglected is a share of some 1e-3 of each.

use std::f64::consts::{PI, TAU};

use tests::twin::beam::{Beam, Body};
use tests::twin::hidden::Hidden::{self, *};
use tests::twin::hidden::{AIR, Occasion, TURNS_OVER};
use tests::twin::motion::Motion;
use tests::twin::specimen::Specimen;

const LENGTH: f64 = 0.3;
const STIFFNESS: f64 = 0.01;
const MASS: f64 = 0.05;
/// Angular velocity of the straight rod at first, rad/s: swings of 5 mm.
const STRUCK: f64 = 0.075;
const DIAMETER: f64 = 0.025;

fn beam() -> Beam {
    Beam {
        elements: 6,
        length: LENGTH,
        mass: 1e-5,
        bending_stiffness: STIFFNESS,
        axial_stiffness: 500.0,
        axial_compliance: 0.0,
        bodies: vec![Body { mass: MASS, center: 0.0, inertia: 0.0 }],
        gravity: 0.0,
        incline: 0.0,
        alpha: 0.0,
        beta: 0.0,
    }
}

/// With so little stiffness damping, s, that the slow mode keeps its frequency to 1e-4, and a fast one
/// has died away after `FAST`, s.
const DAMPING: f64 = 5e-3;
const FAST: f64 = 3.0;
const DURATION: f64 = 7.0;

/// A swing: time and height of its turning points, s and m.
struct Swing {
    turns: Vec<[f64; 2]>,
}

impl Swing {
    fn of(beam: Beam, hidden: &[Hidden]) -> Self {
        let struck = [&[InitialVelocity { rate: STRUCK }], hidden].concat();
        let occasion = Occasion { pressure: 2e5, diameter: DIAMETER, drift: 0.5 };
        let specimen = Specimen::new(beam, &struck, &occasion);
        let motion = Motion::let_go(&specimen, 0.0, DURATION, 1e-7);
        let count = (DURATION / 2e-3) as usize;
        let height = |k: usize| specimen.beam.axis(&motion.at(k as f64 * 2e-3), 1.0)[0][1];
        let heights: Vec<f64> = (0..count).map(height).collect();
        // The parabola through the three samples at a turn.
        let turn = |k: usize| {
            let [a, b, c] = [heights[k - 1], heights[k], heights[k + 1]];
            let at = 0.5 * (a - c) / (a - 2.0 * b + c);
            [(k as f64 + at) * 2e-3, b - 0.25 * (a - c) * at]
        };
        let is_turn = |k: &usize| {
            let [a, b, c] = [heights[k - 1], heights[*k], heights[k + 1]];
            b.abs() > 0.3e-3 && (b - a) * (c - b) <= 0.0
        };
        Self { turns: (1..count - 1).filter(is_turn).map(turn).collect() }
    }

    /// Frequency of the slow mode with effects, rad/s.
    fn frequency(hidden: &[Hidden]) -> f64 {
        let swing = Self::of(Beam { beta: DAMPING, ..beam() }, hidden);
        let late: Vec<f64> = swing.turns.iter().map(|turn| turn[0]).filter(|time| *time > FAST).collect();
        PI * (late.len() - 1) as f64 / (late[late.len() - 1] - late[0])
    }

    /// Amplitude of the cycle that begins at a turn, m, and what it loses.
    fn loss(&self, turn: usize) -> [f64; 2] {
        let [before, after] = [turn, turn + 2].map(|k| self.turns[k][1].abs());
        [0.5 * (before + after), before - after]
    }
}

fn close(name: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found}, expected {expected}");
}

#[test]
fn frequencies_shift_as_masses_and_springs_say() {
    let plain = Swing::frequency(&[]);
    let spring = 3.0 * STIFFNESS / LENGTH.powi(3);
    close("plain", plain, (spring / MASS).sqrt(), 1e-3);
    let compliance = 3.0;
    let clamp = 1.0 / (1.0 + compliance * LENGTH * LENGTH * spring);
    let pull = 0.2;
    let cases = [
        (TipMass { mass: 5e-3 }, MASS / (MASS + 5e-3)),
        (ClampCompliance { compliance }, clamp),
        (Hose { stiffness: pull, damping: 0.0, anchor: [LENGTH, 0.0] }, 1.0 + pull / spring),
        (Viscoelastic { branch_stiffness: 0.2, relaxation_time: 1e3 }, 1.2),
        (ReleaseDrift { change: 0.1 }, 1.05),
        // Yielding far beyond the swing, it is a spring in bending.
        (Dahl { moment: 0.1, yield_curvature: 100.0 }, 1.0 + 0.1 / 100.0 / STIFFNESS),
        (StiffnessTaper { taper: 0.2 }, 1.0 / taper_softens(0.2)),
    ];
    for (hidden, square) in cases {
        close(hidden.name(), Swing::frequency(&[hidden]) / plain, square.sqrt(), 1e-3);
    }
}

/// Deflection of a tapered cantilever over that of an even one: `3 ∫ (1 − x)² / (1 + e (x − ½)) dx`.
fn taper_softens(taper: f64) -> f64 {
    let count = 1000;
    let at = |k: usize| (k as f64 + 0.5) / f64::from(count);
    let density = |x: f64| 3.0 * (1.0 - x).powi(2) / (1.0 + taper * (x - 0.5));
    (0..count as usize).map(|k| density(at(k)) / f64::from(count)).sum()
}

/// A body beyond the end, with inertia: two degrees of freedom, flexibility of end and slope
/// `L³/3, L²/2, L`, over EI; the slower mode.
fn body_frequency(mass: f64, center: f64, inertia: f64) -> f64 {
    let l = LENGTH;
    let [ww, wt, tt] = [l.powi(3) / 3.0, l * l / 2.0, l].map(|x| x / STIFFNESS);
    let moment = inertia + mass * center * center;
    // Flexibility times mass, whose eigenvalues are 1/ω².
    let (first, second) = (ww * mass + wt * mass * center, wt * mass * center + tt * moment);
    let (up, down) = (ww * mass * center + wt * moment, wt * mass + tt * mass * center);
    let (trace, determinant) = (first + second, first * second - up * down);
    (0.5 * (trace + (trace * trace - 4.0 * determinant).sqrt())).powf(-0.5)
}

#[test]
fn the_body_at_the_end_swings_as_a_rigid_body_on_a_beam() {
    let ratio = |hidden: Hidden| {
        let [found, plain] = [vec![hidden], vec![]].map(|hidden| Swing::frequency(&hidden));
        found / plain
    };
    let plain = body_frequency(MASS, 0.0, 0.0);
    close("inertia", ratio(TipInertia { inertia: 3e-4 }), body_frequency(MASS, 0.0, 3e-4) / plain, 1e-3);
    close("offset", ratio(TipOffset { along: 0.02 }), body_frequency(MASS, 0.02, 0.0) / plain, 1e-3);
}

/// In the mode of the heavy body a mass per length counts with 33/140 of what it comes to; that the
/// mode changes is of second order, `(μ L / m)²`.
#[test]
fn added_mass_moves_with_the_rod() {
    let (added, length) = (0.02, LENGTH);
    let ratio = Swing::frequency(&[AddedMass { mass_per_length: added }]) / Swing::frequency(&[]);
    close("added mass", ratio, (MASS / (MASS + 33.0 / 140.0 * added * length)).sqrt(), 1e-3);
}

/// Fluid on a spring within the fitting: two masses, two springs; a spring that is far stiffer than
/// the rod carries it along, so that nothing changes.
#[test]
fn what_sloshes_is_a_mass_on_a_spring() {
    let plain = Swing::frequency(&[]);
    let stiff = Swing::frequency(&[Sloshing { mass: 0.01, frequency: 300.0, damping: 0.1 }]);
    close("stiff", stiff, plain, 1e-3);
    let (mass, own) = (0.005, 8.0);
    let shown = Swing::frequency(&[Sloshing { mass, frequency: own, damping: 0.15 }]);
    // `k − (m − s) ω² = s ω² H`, H the real part of what a base's motion gives the sloshing mass:
    // (1 + iy) / (1 − x² + iy), x = ω/Ω, y = 2 ζ x. The lower root.
    let spring = 3.0 * STIFFNESS / LENGTH.powi(3);
    let imbalance = |w: f64| {
        let (x, y) = (w / own, 2.0 * 0.15 * w / own);
        let gain = (1.0 - x * x + y * y) / ((1.0 - x * x).powi(2) + y * y);
        spring - (MASS - mass) * w * w - mass * w * w * gain
    };
    let [mut low, mut high] = [0.0, 0.8 * own];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if imbalance(middle) > 0.0 { &mut low } else { &mut high }) = middle;
    }
    let closed = low / (spring / MASS).sqrt();
    assert!(closed < 0.985);
    close("sloshing", shown / plain, closed, 1e-3);
}

/// Losses of a cycle, `ΔA = ΔE / (k A)`, `k = 3 EI / L³`. Of a moment m(s): `∮∫ m dκ ds`.
#[test]
fn cycles_lose_what_friction_and_drag_take() {
    let (l, spring) = (LENGTH, 3.0 * STIFFNESS / LENGTH.powi(3));
    let omega = (spring / MASS).sqrt();
    type Loss<'a> = Box<dyn Fn(f64) -> f64 + 'a>;
    // The mean of the mode (3x² − x³)/2 squared is 33/140.
    let cases: Vec<(Hidden, Loss, f64)> = vec![
        (
            Hysteresis { loss_factor: 0.01 },
            Box::new(|a| bends_away(a, omega, &|k, r| 0.01 * STIFFNESS * k.abs() * (r / TURNS_OVER).tanh())),
            1e-2,
        ),
        (
            BraidFriction { moment: 2e-5 },
            Box::new(|a| bends_away(a, omega, &|_, r| 2e-5 * (r / TURNS_OVER).tanh())),
            1e-2,
        ),
        (Dahl { moment: 2e-5, yield_curvature: 5e-3 }, Box::new(|a| dahl_takes(a, 2e-5, 5e-3)), 1e-2),
        (
            Hose { stiffness: 0.0, damping: 5e-3, anchor: [0.0; 2] },
            Box::new(|a| PI * 5e-3 * omega * a / spring),
            1e-2,
        ),
        (
            LinearDrag { coefficient: 0.1 },
            Box::new(|a| PI * 0.1 * omega * a * l * 33.0 / 140.0 / spring),
            1e-2,
        ),
        (
            TipDrag { drag_area: 1.0 },
            Box::new(|a| 0.5 * AIR * 8.0 / 3.0 * omega * omega * a * a / spring),
            1e-2,
        ),
        (
            AirDrag { drag_coefficient: 50.0 },
            Box::new(|a| {
                0.5 * AIR * 50.0 * DIAMETER * 8.0 / 3.0 * omega * omega * a * a * l * mode_cubed() / spring
            }),
            1e-2,
        ),
        (
            Viscoelastic { branch_stiffness: 0.05, relaxation_time: 0.2 },
            Box::new(|a| PI * 0.05 * omega * 0.2 / (1.0 + (omega * 0.2).powi(2)) * a),
            3e-2,
        ),
    ];
    for (hidden, loss, tolerance) in cases {
        let swing = Swing::of(beam(), &[hidden]);
        for turn in 1..3 {
            let [amplitude, lost] = swing.loss(turn);
            close(hidden.name(), lost, loss(amplitude), tolerance);
        }
    }
}

/// Loss of amplitude in a harmonic cycle by a moment of curvature and its rate, m.
fn bends_away(amplitude: f64, omega: f64, moment: &dyn Fn(f64, f64) -> f64) -> f64 {
    let count = 200;
    let mut work = 0.0;
    for (i, j) in (0..count * count).map(|m| (m / count, m % count)) {
        let [x, phase] = [i, j].map(|k| (k as f64 + 0.5) / count as f64);
        let kappa = 3.0 * amplitude / (LENGTH * LENGTH) * (1.0 - x);
        let (sin, cos) = (TAU * phase).sin_cos();
        let rate = omega * kappa * cos;
        work += moment(kappa * sin, rate) * rate * TAU / omega * LENGTH / (count * count) as f64;
    }
    work / (3.0 * STIFFNESS / LENGTH.powi(3)) / amplitude
}

/// The same for Dahl's friction, whose loop between ±K has the area `4 M_f (K − κ_y tanh(K/κ_y))`.
fn dahl_takes(amplitude: f64, moment: f64, yields: f64) -> f64 {
    let count = 1000;
    let area = |x: f64| {
        let kappa = 3.0 * amplitude / (LENGTH * LENGTH) * (1.0 - x);
        4.0 * moment * (kappa - yields * (kappa / yields).tanh())
    };
    let work: f64 = (0..count).map(|k| area((k as f64 + 0.5) / count as f64) * LENGTH / count as f64).sum();
    work / (3.0 * STIFFNESS / LENGTH.powi(3)) / amplitude
}

/// `∫ ((3x² − x³)/2)³ dx`.
fn mode_cubed() -> f64 {
    let count = 1000;
    let mode = |x: f64| (0.5 * (3.0 * x * x - x * x * x)).powi(3);
    (0..count).map(|k| mode((k as f64 + 0.5) / count as f64) / count as f64).sum()
}

/// A hand that lets go within a fraction of a swing adds its impulse, `F τ / (1 + i ω τ)`, to that of the
/// stroke, `m ω₀ L`; what both make of the first swing is their sum's size.
#[test]
fn a_hand_that_lets_go_slowly_is_an_impulse() {
    let (force, time) = (0.05, 0.02);
    let omega = (3.0 * STIFFNESS / LENGTH.powi(3) / MASS).sqrt();
    let first = |hidden: &[Hidden]| Swing::of(beam(), hidden).turns[0][1];
    let (stroke, lag) = (MASS * STRUCK * LENGTH, omega * time);
    let [real, imaginary] = [1.0, -lag].map(|x| force * time * x / (1.0 + lag * lag));
    let expected = (stroke + real).hypot(imaginary) / stroke;
    close("hand", first(&[HandRelease { force, time }]) / first(&[]), expected, 2e-3);
}

/// Damping that follows pressure: half as much more where the pressure is the reference.
#[test]
fn damping_grows_with_pressure() {
    let damped = Beam { alpha: 0.2, ..beam() };
    let loss = |hidden: &[Hidden]| {
        let [amplitude, lost] = Swing::of(damped.clone(), hidden).loss(1);
        lost / amplitude
    };
    let plain = loss(&[]);
    let omega = (3.0 * STIFFNESS / LENGTH.powi(3) / MASS).sqrt();
    close("plain", plain, 2.0 * (0.05 * TAU / omega).tanh(), 1e-2);
    close("more", loss(&[DampingOverPressure { alpha: 0.1, beta: 0.0, reference: 2e5 }]) / plain, 1.5, 1e-2);
}
