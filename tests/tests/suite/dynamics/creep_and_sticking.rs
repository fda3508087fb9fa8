//! Goal: slow motion under a constant moment: creep from a relaxed start, and what friction holds.
//! Setup: the 15 psi row without weight, bent by a moment at its end.
//! Expected: as each test derives, to within the time that the rod itself takes to follow.

use efam_core::forward::{Initial, Run};
use models::model::Model;
use tests::{paper, simulate};

const MOMENT: f64 = 1e-4;

/// `κ = M/EI [1 − g/(1+g) exp(−t/(τ(1+g)))]`: all of the stiffness at first, the static one at last.
#[test]
fn creep_starts_relaxed_and_ends_at_the_static_stiffness() {
    let (share, time, alpha) = (0.1, 5.0, 40.0);
    let model = paper(
        15.0,
        24,
        &[
            ("gravity.acceleration", 0.0),
            ("end_fitting.mass", 1e-3),
            ("end_fitting.center_of_mass", 0.0),
            ("rayleigh_mass.alpha", alpha),
            ("tip_load.moment", MOMENT),
            ("creep.creep_stiffness", share),
            ("creep.creep_time", time),
        ],
    );
    let path = simulate(&model, &Run { tolerance: 1e-7, ..Run::release(30.0, 1.0) });
    let rod = model.rod();
    let kappa = MOMENT / rod.bending_stiffness;
    let slow = time * (1.0 + share);
    // Mass damping lags by α/ω², where ω² is at least 3 EI / (m L³) with all of the mass at the end.
    let lag = alpha * (rod.mass + 1e-3) * rod.length.powi(3) / (3.0 * rod.bending_stiffness);
    for (t, state) in path.times.iter().zip(0..).skip(2) {
        let angle = *path.state(state).q.last().expect("the angle");
        let missing = share / (1.0 + share) * (-t / slow).exp();
        let expected = kappa * rod.length * (1.0 - missing);
        let tolerance = kappa * rod.length * (missing * lag / slow + 1e-3);
        assert!((angle - expected).abs() < tolerance, "{t} s: {angle} against {expected} rad");
    }
}

fn bent(moment: f64, friction: f64, creep_rate: f64) -> Model {
    paper(
        15.0,
        24,
        &[
            ("gravity.acceleration", 0.0),
            ("rayleigh_stiffness.beta", 0.2),
            ("tip_load.moment", moment),
            ("braid_friction.friction_moment", friction),
            ("braid_friction.creep_rate", creep_rate),
        ],
    )
}

/// What is bent by less than friction holds does not come back, but for what creeps: with no other
/// moment `EI κ = −M_f z`, so that `κ̇ = −r ż` with `r = M_f/EI`, and `ż = (κ̇ − z √(κ̇² + κ̇₀²))/κ_b`
/// gives `ż = −z κ̇₀ / √((r + κ_b)² − r² z²)`.
#[test]
fn friction_holds_an_offset() {
    let (friction, creep_rate, bristle) = (1e-3, 5e-3, 0.01);
    let from = |friction: f64| {
        let hold = bent(0.5e-3, friction, creep_rate);
        let run = Run { tolerance: 1e-8, ..Run::release(9.0, 10.0) };
        let initial = Initial::Equilibrium { hold: Box::new(hold), own: vec![] };
        let model = bent(0.0, friction, creep_rate);
        (model.rod(), simulate(&model, &Run { initial, ..run }))
    };
    let (rod, path) = from(friction);
    let r = friction / rod.bending_stiffness;
    // After five seconds the swing within what sticks is over.
    let (settled, last) = (path.state(50), path.state(90));
    assert!(path.tip[90][1] > 0.2 * path.tip[0][1], "{:?} of {:?}", path.tip[90], path.tip[0]);
    for (bend, (before, after)) in settled.z.iter().zip(&last.z).enumerate() {
        let (mut z, step) = (*before, 1e-3);
        for _ in 0..4000 {
            let rate = |z: f64| -z * creep_rate / ((r + bristle).powi(2) - (r * z).powi(2)).sqrt();
            z += step * rate(z + 0.5 * step * rate(z));
        }
        // Stiffness damping takes β κ̇, β over the time of creeping: 0.2 s of some 30 s, of the 13 % that are lost.
        assert!((after - z).abs() < 2e-3 * z.abs() + 1e-4, "bend {bend}: {after} against {z}");
    }
    let (_, free) = from(0.0);
    assert!(free.tip.iter().any(|tip| tip[1] < 0.0), "without friction it swings through");
}
