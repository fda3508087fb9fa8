//! Goal: what a recording of a known muscle gives is the muscle.
//! Setup: two releases of 10 s, 0.3 mm of noise, 3 % of samples masked, the instant known to 2 ms; data
//! of another mesh, element and integrator than the fit's. Starts off by 20 % in EI, by half in
//! alpha and beta.
//! Expected: EI within 0.5 %, alpha and beta within 5 % where the data determine them to
//! that, at every pressure of the table; and that the data determine both where the swing is long.

use tests::twin::direct::Direct;
use tests::twin::random::Random;
use tests::twin::study::{damped_muscle, fit, is_determined, landed, line, session, truth};

/// How many of alpha and beta the data determine; all that they determine is right.
fn recovers(psi: f64, cycles: usize, swing: f64) -> usize {
    let mut random = Random::new(psi as u64);
    let session = session(psi, swing, &mut random);
    let beam = damped_muscle(psi);
    let tip = beam.bodies[0].center;
    let direct = Direct::usual(0.3e-3, swing, tip);
    let releases = (0..cycles).map(|cycle| direct.release(&session, cycle, &mut random)).collect();
    let truth = truth(&beam);
    let found = fit(psi, releases, [0.8 * truth[0], 1.5 * truth[1], 1.5 * truth[2]]);
    let landed = landed(&found, truth);
    println!("| {psi:3} | {} | {} warnings", line(&landed), found.warnings.len());
    assert!(landed[0].off.abs() < 0.005, "{psi} psi: EI {}", line(&landed));
    for l in &landed[1..] {
        assert!(l.off.abs() < 0.05 || !is_determined(l), "{psi} psi: {}", line(&landed));
    }
    landed[1..].iter().filter(|l| is_determined(l)).count()
}

/// The swing is short there, and determines EI alone.
#[test]
fn the_muscle_at_15_psi() {
    recovers(15.0, 2, 6.0);
}

/// Their relative standard errors are 0.5 and 1.5 % here, of which three have to lie within 5 %.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn the_losses_at_40_psi_are_determined_and_right() {
    assert_eq!(recovers(40.0, 2, 10.0), 2);
}

/// Alpha is determined at three quarters of the pressures and beta at a quarter: those in the middle of the table.
#[test]
#[ignore = "minutes: all 20 pressures"]
fn the_muscle_at_every_pressure() {
    let determined: usize = (1..=20).map(|k| recovers(5.0 * f64::from(k), 2, 10.0)).sum();
    println!("{determined} of 40 losses are determined");
    assert!(determined >= 15, "{determined} of 40 losses are determined");
}
