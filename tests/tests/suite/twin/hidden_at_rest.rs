//! Goal: what is hidden in a twin bends it at rest as closed forms say.
//! Setup: a weightless rod, so heavily damped that it follows what acts on it; a set curvature is what
//! bends it, or a small force at its end.
//! Expected: uniform curvature from the moment's balance; small deflections of a cantilever.

use tests::twin::beam::{Beam, Body};
use tests::twin::hidden::Hidden::{self, *};
use tests::twin::hidden::Occasion;
use tests::twin::motion::Motion;
use tests::twin::specimen::Specimen;

const LENGTH: f64 = 0.3;
const STIFFNESS: f64 = 0.01;
const EA: f64 = 500.0;
/// Set curvature, 1/m.
const SET: f64 = 2.0;

fn beam() -> Beam {
    Beam {
        elements: 12,
        length: LENGTH,
        mass: 1e-3,
        bending_stiffness: STIFFNESS,
        axial_stiffness: EA,
        axial_compliance: 0.0,
        bodies: vec![Body { mass: 0.01, center: 0.0, inertia: 0.0 }],
        gravity: 0.0,
        incline: 0.0,
        alpha: 10.0,
        beta: 0.05,
    }
}

/// Position of the end and angle there, rad, after so many seconds.
fn end(hidden: &[Hidden], duration: f64) -> [f64; 3] {
    let occasion = Occasion { pressure: 2e5, diameter: 0.025, drift: 0.5 };
    let specimen = Specimen::new(beam(), hidden, &occasion);
    let motion = Motion::let_go(&specimen, 0.0, duration, 1e-7);
    let [[x, z], p] = specimen.beam.axis(&motion.at(duration), 1.0);
    [x, z, p[1].atan2(p[0])]
}

fn set(more: Hidden) -> [Hidden; 2] {
    [SetCurvature { curvature: SET, by_pressure: 0.0 }, more]
}

/// After 5 s the slowest mode, at `√(3 EI / m L³) = 10 rad/s` with a damping of more than half, has
/// died away to 1e-10; elements of fourth order leave `(κ L / 12)⁴ = 6e-6`.
fn close(name: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found}, expected {expected}");
}

#[test]
fn a_set_curvature_is_an_arc_of_a_circle() {
    let by_pressure = SetCurvature { curvature: 1.5, by_pressure: 0.5 / 2e5 };
    for hidden in [SetCurvature { curvature: SET, by_pressure: 0.0 }, by_pressure] {
        let [x, z, angle] = end(&[hidden], 5.0);
        close("x", x, (SET * LENGTH).sin() / SET, 1e-5);
        close("z", z, (1.0 - (SET * LENGTH).cos()) / SET, 1e-5);
        close("angle", angle, SET * LENGTH, 1e-5);
    }
}

/// κ of `κ + more(κ) = κ₀`, by bisection.
fn balance(more: impl Fn(f64) -> f64) -> f64 {
    let [mut low, mut high] = [0.0, 2.0 * SET];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if middle + more(middle) < SET { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn nonlinear_stiffness_shares_the_set_moment() {
    type Law = fn(f64) -> f64;
    let cases: [(Hidden, Law); 4] = [
        (CubicStiffness { coefficient: 0.03 }, |k| 0.03 * k * k * k),
        (CubicStiffness { coefficient: -0.03 }, |k| -0.03 * k * k * k),
        (QuadraticStiffness { coefficient: 0.1 }, |k| 0.1 * k * k),
        (PressureVolume { coefficient: 0.03 }, |k| 0.03 * k * k * k),
    ];
    for (hidden, law) in cases {
        let [.., angle] = end(&set(hidden), 5.0);
        close(hidden.name(), angle, balance(law) * LENGTH, 1e-5);
    }
}

/// `κ = κ₀ / (1 + e (s/L − ½))`, integrated.
#[test]
fn a_taper_bends_the_softer_end_more() {
    let taper: f64 = 0.4;
    let [.., angle] = end(&set(StiffnessTaper { taper }), 5.0);
    let expected = SET * LENGTH / taper * ((1.0 + 0.5 * taper) / (1.0 - 0.5 * taper)).ln();
    close("taper", angle, expected, 1e-5);
    // A taper the other way gives the same angle, but bends further out: less deflection.
    let [_, stiff_end, _] = end(&set(StiffnessTaper { taper }), 5.0);
    let [_, stiff_root, _] = end(&set(StiffnessTaper { taper: -taper }), 5.0);
    assert!(stiff_root < 0.95 * stiff_end, "{stiff_root} m, {stiff_end} m");
}

/// The dashpots of the damping lag by their time, β + α m L³ / 3 EI = 0.15 s, times the rate of the
/// change, here less than 0.02 1/s.
#[test]
fn stiffness_that_changes_slowly_is_followed() {
    let [.., angle] = end(&set(StiffnessDrift { rate: 0.02 }), 8.0);
    close("drift", angle, SET * LENGTH / (1.0 - 0.02 * 8.0), 5e-3);
    let quarter = 0.25 * std::f64::consts::TAU / 0.2;
    let [.., angle] = end(&set(Ripple { share: 0.1, frequency: 0.2 }), quarter);
    close("ripple", angle, SET * LENGTH / 1.1, 1e-3);
}

/// A Maxwell branch that has relaxed carries nothing; at a thousandth of its time it is a spring.
#[test]
fn a_maxwell_branch_is_stiff_at_first_and_gone_at_last() {
    let branch = |relaxation_time| Viscoelastic { branch_stiffness: 0.25, relaxation_time };
    let [.., angle] = end(&set(branch(0.2)), 8.0);
    close("relaxed", angle, SET * LENGTH, 1e-5);
    let [.., angle] = end(&set(branch(5e3)), 5.0);
    close("stiff", angle, SET * LENGTH / 1.25, 1e-3);
    let creep = Creep { branch_stiffness: 0.25, relaxation_time: 5.0 };
    // The branch creeps while it is loaded: `κ − z` decays with τ (1 + g), from `κ₀ / (1 + g)`.
    let [.., angle] = end(&set(creep), 5.0);
    let strain = SET / 1.25 * (-5.0f64 / (5.0 * 1.25)).exp();
    close("creep", angle, (SET - 0.25 * strain) * LENGTH, 2e-2);
}

/// A small force at the end: `F L³ / 3 EI`, and `C F L²` more where the clamp gives way.
#[test]
fn a_force_at_the_end_deflects_as_a_cantilever_and_its_clamp() {
    let force = 2e-3;
    let hand = HandRelease { force, time: 1e9 };
    let rod = LENGTH.powi(3) / (3.0 * STIFFNESS);
    close("hand", end(&[hand], 5.0)[1], force * rod, 1e-3);
    let compliance = 3.0;
    let clamp = end(&[hand, ClampCompliance { compliance }], 5.0)[1];
    close("clamp", clamp, force * (rod + compliance * LENGTH.powi(2)), 1e-3);
    let (stiffness, lift) = (0.2, 0.01);
    let hose = Hose { stiffness, damping: 0.0, anchor: [LENGTH, lift] };
    close("hose", end(&[hose], 5.0)[1], stiffness * lift * rod / (1.0 + stiffness * rod), 2e-3);
    // A wall at 0.02 rad above the rod, on the side to which a downward force pushes it.
    let down = HandRelease { force: -force, time: 1e9 };
    let wall = Wall { stiffness, angle: -5e-3 };
    let free = force * rod;
    let depth = (free - 5e-3 * LENGTH) / (1.0 + stiffness * rod);
    close("wall", -end(&[down, wall], 5.0)[1], 5e-3 * LENGTH + depth, 2e-3);
}

/// `F / EA`, and `c F` more.
#[test]
fn a_compliance_in_series_stretches_more() {
    let pull = Hose { stiffness: 1.0, damping: 0.0, anchor: [2.0, 0.0] };
    let compliance = 4e-3;
    let stretch = |hidden: &[Hidden]| end(hidden, 3.0)[0] / LENGTH - 1.0;
    let [plain, soft] = [stretch(&[pull]), stretch(&[pull, AxialCompliance { compliance }])];
    let force = |stretch: f64| 2.0 - LENGTH * (1.0 + stretch);
    close("plain", plain, force(plain) / EA, 1e-6);
    close("soft", soft, force(soft) * (1.0 / EA + compliance), 1e-6);
}

/// A memory of friction holds back the rod that comes to rest: it stops short by what the friction
/// holds, `M_f / EI`, less what the last overshoot turned back.
#[test]
fn friction_that_remembers_leaves_it_short() {
    for moment in [1e-3, 2e-3] {
        let [.., angle] = end(&set(Dahl { moment, yield_curvature: 0.05 }), 5.0);
        let (short, most) = (SET - angle / LENGTH, moment / STIFFNESS);
        assert!((0.5 * most..1.001 * most).contains(&short), "{short} 1/m of {most}");
    }
}
