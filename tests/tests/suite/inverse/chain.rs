//! Goal: the whole chain, from what cameras saw to parameters: recording, cleaning, fit.
//! Setup: a recording of six cycles with noise, losses in bursts, ghosts of up to 200 mm, a base that
//! wanders, motion out of the plane, a turned and shifted frame; release instants unknown.
//! Expected: six releases, their instants within five standard errors; EI within 0.5 %, alpha and
//! beta within 5 % where identifiable.

use efam_experiments::cleaning::{Cleaned, clean_all};
use tests::twin::random::Random;
use tests::twin::sensor::Cameras;
use tests::twin::session::Session;
use tests::twin::study::{damped_muscle, experiment, fit, is_determined, landed, line, session, truth};

fn cleaned(psi: f64, swing: f64, noise: f64, seed: u64) -> (Session, Cleaned) {
    let mut random = Random::new(seed + psi as u64);
    let session = session(psi, swing, &mut random);
    let beam = &session.beam;
    let cameras = Cameras::usual(noise, beam.length, beam.bodies[0].center, &[]);
    let recording = cameras.record(&session, &mut random);
    let markers = cameras.markers.iter().map(|(name, _)| &name[..]);
    let cleaned = clean_all(&experiment(psi, markers), vec![recording]).expect("six releases");
    (session, cleaned)
}

/// A raise as fast as a release, a sample beside a hold that lies elsewhere, and points lost at a turn, before
/// a fall, through the beginning of one, through all of one.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn no_release_is_lost() {
    for (psi, noise) in [(15.0, 0.5e-3), (25.0, 0.5e-3), (5.0, 0.1e-3), (85.0, 0.5e-3)] {
        let (session, cleaned) = cleaned(psi, 15.0, noise, 40);
        check_instants(psi, &session, &cleaned);
    }
}

fn check_instants(psi: f64, session: &Session, cleaned: &Cleaned) {
    assert_eq!(cleaned.releases.len(), 6, "{psi} psi: {:?}", cleaned.decisions);
    for (found, instant) in cleaned.releases.iter().zip(&session.releases) {
        let (off, error) = (found.instant - instant, found.release.release_uncertainty);
        println!("{psi} psi: instant {:+.2} ms ± {:.2} ms", 1e3 * off, 1e3 * error);
        assert!(off.abs() < 5.0 * error, "{psi} psi: {off} s off, ± {error} s");
    }
}

/// How many of alpha and beta the data determine; all that they determine is right.
fn recovers(psi: f64, swing: f64, noise: f64, seed: u64) -> usize {
    let (session, cleaned) = cleaned(psi, swing, noise, seed);
    check_instants(psi, &session, &cleaned);
    let releases = cleaned.used().map(|release| release.release.clone()).collect();
    let truth = truth(&damped_muscle(psi));
    let found = fit(psi, releases, [0.8 * truth[0], 1.5 * truth[1], 1.5 * truth[2]]);
    let landed = landed(&found, truth);
    println!("| {psi:3} | {noise} | {} | {} warnings", line(&landed), found.warnings.len());
    assert!(landed[0].off.abs() < 0.005, "{psi} psi: EI {}", line(&landed));
    for l in &landed[1..] {
        assert!(l.off.abs() < 0.05 || !is_determined(l), "{psi} psi: {}", line(&landed));
    }
    landed[1..].iter().filter(|l| is_determined(l)).count()
}

/// At 15 psi neither loss is determined by so short a recording, at 40 psi both are.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_recording_at_15_and_one_at_40_psi() {
    recovers(15.0, 8.0, 0.3e-3, 40);
    assert_eq!(recovers(40.0, 8.0, 0.3e-3, 40), 2);
}

/// From 25 to 45 psi six releases determine both losses, whatever the noise. Beyond, with 0.1 mm of noise, what is left of
/// the wandering base counts as missed by the model: without it they would be ten times as well known.
#[test]
#[ignore = "minutes: twenty pressures twice"]
fn recordings_at_all_pressures_and_noises() {
    let noises = [0.1e-3, 0.5e-3, 0.3e-3].into_iter().cycle();
    for seed in [40, 1040] {
        let of = |(k, noise): (i32, f64)| recovers(5.0 * f64::from(k), 15.0, noise, seed);
        let determined: Vec<usize> = (1..=20).zip(noises.clone()).map(of).collect();
        println!("{} of 40 losses are determined", determined.iter().sum::<usize>());
        assert!(determined[4..9].iter().all(|count| *count == 2), "{determined:?}");
        assert!(determined.iter().sum::<usize>() >= 20, "{determined:?}");
    }
}
