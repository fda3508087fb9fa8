//! Goal: a 95 % interval holds the truth in 95 % of experiments.
//! Setup: one true motion for each of six release angles, many draws of noise, masks, offsets and release
//! instants; each draw is one release of 8 s, fitted from the truth.
//! Expected: 90 to 99 % of 200 draws; of 200 draws with 95 %, 99.9 % cover 90 to 99 %. The same of losses that
//! whole experiments find, under noise with a memory.

use efam_inference::calibrate::{CalibrationSettings, calibrate};
use rayon::prelude::*;
use tests::blind::all_fitted;
use tests::twin::direct::Direct;
use tests::twin::drawn::Plan;
use tests::twin::random::Random;
use tests::twin::study::{PATHS, damped_muscle, fit, landed, session, truth};

/// Shares of draws whose intervals cover, and root mean squares of the errors in standard errors.
fn coverage(psi: f64, draws: u64, swing: f64) -> [[f64; 2]; 3] {
    let session = session(psi, swing, &mut Random::new(3));
    let beam = damped_muscle(psi);
    let direct = Direct::usual(0.3e-3, swing, beam.bodies[0].center);
    let one = |draw: u64| {
        let mut random = Random::new(1000 + draw);
        let release = direct.release(&session, draw as usize % 6, &mut random);
        landed(&fit(psi, vec![release], truth(&beam)), truth(&beam))
    };
    let all: Vec<_> = (0..draws).into_par_iter().map(one).collect();
    [0, 1, 2].map(|k| {
        let covered = all.iter().filter(|l| l[k].covered).count() as f64 / draws as f64;
        let square: f64 = all.iter().map(|l| (l[k].off / l[k].error).powi(2)).sum();
        let off = all.iter().map(|l| l[k].off).sum::<f64>() / draws as f64;
        let error = all.iter().map(|l| l[k].error).sum::<f64>() / draws as f64;
        let spread = (square / draws as f64).sqrt();
        println!(
            "{psi} psi, {}: covered {:.1} %, errors {spread:.2} of their standard, bias {:+.3} %, error {:.3} %",
            PATHS[k],
            100.0 * covered,
            100.0 * off,
            100.0 * error
        );
        [covered, spread]
    })
}

/// Of twenty draws at 95 % fewer than sixteen cover in one of four hundred trials.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn of_twenty_draws_sixteen_or_more_cover() {
    for [covered, _] in coverage(15.0, 20, 4.0) {
        assert!(covered >= 0.8, "{covered}");
    }
}

#[test]
#[ignore = "minutes: 200 draws at three pressures"]
fn of_two_hundred_draws_90_to_99_percent_cover() {
    for psi in [15.0, 40.0, 100.0] {
        let found = coverage(psi, 200, 8.0);
        assert!(found.iter().all(|[covered, _]| (0.9..=0.99).contains(covered)), "{psi} psi: {found:?}");
    }
}

/// How far α and β of drawn experiments of six releases are off, in standard errors; the figures are printed.
/// A third of the noise's variance remembers three samples; 3 % of the samples are lost, eight at a time.
fn of_experiments(seeds: std::ops::Range<u64>) -> [Vec<f64>; 2] {
    let plan = Plan::of_two_angles(&[]);
    let one = |seed: u64| {
        let drawn = plan.draw(seed);
        let outcome =
            calibrate(&all_fitted(&drawn), &CalibrationSettings::default(), &|_: &str| ()).expect("a fit");
        [(PATHS[1], drawn.alpha), (PATHS[2], drawn.beta)].map(|(path, truth)| {
            let own = outcome.calibration.parameters.iter().find(|own| own.name == path).expect("fitted");
            (own.value - truth) / own.standard_error.expect("determined")
        })
    };
    let all: Vec<[f64; 2]> = seeds.into_par_iter().map(one).collect();
    [0, 1].map(|k| {
        let off: Vec<f64> = all.iter().map(|off| off[k]).collect();
        let mean = |of: &dyn Fn(f64) -> f64| off.iter().map(|off| of(*off)).sum::<f64>() / off.len() as f64;
        let (bias, spread) = (mean(&|off| off), mean(&|off| off * off).sqrt());
        println!("{}: errors {spread:.2} of their standard, {bias:+.2} in the mean", PATHS[k + 1]);
        off
    })
}

#[test]
#[ignore = "minutes: 100 experiments of six releases"]
fn of_one_hundred_experiments_90_to_99_percent_cover() {
    for off in of_experiments(84_001..84_101) {
        let covered = off.iter().filter(|off| off.abs() <= 1.96).count();
        assert!((90..=99).contains(&covered), "{covered}");
    }
}
