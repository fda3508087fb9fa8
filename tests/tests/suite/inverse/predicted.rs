//! Goal: what a calibration predicts of a payload, and of a release that took no part, holds the truth in 95 % of
//! experiments.
//! Setup: the independent beam, its EI, losses and masses off by what a laboratory would not notice; six releases
//! without a payload are tracked and calibrated, the muscle file is written and read, and releases with 20, 100 and
//! 300 g are predicted at a calibrated pressure, their size unsaid; the beam itself is then let go with weights of one
//! drawn material.
//! Expected: rest, frequency, damping ratio and lowest point of the beam lie in their intervals in 90 to 99 % of 100
//! draws, and the intervals are such that a person would find them useful. The same of draws of a real laboratory, whose
//! releases differ by more than the noise: a release at a calibrated pressure and one between two pressures.

use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use efam_experiments::analysis::coordinate::Coordinate;
use efam_experiments::analysis::excursion::Excursion;
use efam_experiments::analysis::swing::{Known, swing_along};
use efam_inference::calibrate::{CalibrationSettings, Problem, calibrate};
use efam_inference::predict::grid::{Cell, grid};
use efam_inference::predict::request::CaseRequest;
use efam_report::calibrated::{Setup, muscle_file};
use models::muscle::Muscle;
use rayon::prelude::*;
use tests::PSI;
use tests::blind::{all_fitted, problem};
use tests::twin::AS_DRAWN;
use tests::twin::drawn::{DrawnRelease, Plan, Priors, Unrepeated};
use tests::twin::hidden::Hidden;
use tests::twin::random::Random;

const PRESSURE: f64 = 40.0;
const PAYLOADS: [f64; 3] = [0.02, 0.1, 0.3];
const NAMES: [&str; 4] = ["rest_z_m", "frequency_hz", "damping_ratio", "lowest_z_m"];
/// How long a predicted release lasts, s.
const SECONDS: f64 = 20.0;
/// Samples a second of the truth.
const RATE: f64 = 1000.0;

/// Densities between which 95 % of the weights of a laboratory lie, kg/m³: water, steel.
const DENSITIES: [f64; 2] = [1000.0, 7850.0];

/// Rotary inertia of a weight of a mass about its centre, kg m²: a ball. The weights of a seed are of one material.
fn rotary_inertia(seed: u64, mass: f64) -> f64 {
    let [low, high] = DENSITIES.map(f64::ln);
    let share = Random::new(!seed).normal() / (2.0 * 1.96);
    let density = (0.5 * (low + high) + share * (high - low)).exp();
    0.4 * mass * (0.75 * mass / (PI * density)).cbrt().powi(2)
}

/// What the beam of a seed does with a payload at 40 psi, let go from the horizontal.
fn truth(seed: u64, payload: f64) -> [Option<f64>; 4] {
    let inertia = rotary_inertia(seed, payload);
    let plan = Plan::of_two_angles(&[Hidden::TipMass { mass: payload }, Hidden::TipInertia { inertia }]);
    seen(plan, seed, &|own| own.release.pressure == Some(PRESSURE * PSI) && own.nominal.release_angle == 0.0)
}

/// What a release of a drawn experiment does, in the order of [`NAMES`], its setup being as it should; none where
/// its swing has no one frequency, as with the heaviest payload it may.
fn seen(plan: Plan, seed: u64, is_it: &dyn Fn(&DrawnRelease) -> bool) -> [Option<f64>; 4] {
    let priors = Priors { hold_angle: 0.0, instant: 0.0, tilt: 0.0, offset: 0.0, ..plan.priors };
    let unrepeated = Unrepeated { drift: 0.0, ..plan.unrepeated };
    // Longer than what is predicted, for the rest; finer, for a tip that whips.
    let drawn = Plan { duration: 1.5 * SECONDS, rate: RATE, priors, unrepeated, ..plan }.draw(seed);
    let own = drawn.releases.iter().rfind(|own| is_it(own));
    let path = &own.expect("a release of the plan").truth[0];
    let rest = [0, 1].map(|k| {
        let along: Vec<f64> = path.iter().map(|at| at[k]).collect();
        Excursion::about_end(3.0, &along, 1.0 / RATE).expect("thirty seconds").rest()
    });
    let seen: Vec<[f64; 2]> = path.iter().copied().step_by(10).take((100.0 * SECONDS) as usize).collect();
    let coordinate = Coordinate::largest_motion(seen.iter().copied(), rest);
    let coordinate = coordinate.towards([seen[0][0] - rest[0], seen[0][1] - rest[1]]);
    let (_, swing) = swing_along(&seen, 0.01, rest, coordinate, &Known::default()).expect("twenty seconds");
    let omega = swing.damped_frequency.ok();
    let ratio = swing.decay.ok().map(|decay| decay.damping_ratio);
    let lowest = path.iter().map(|at| at[1]).fold(f64::INFINITY, f64::min);
    [Some(rest[1]), omega.map(|omega| omega / std::f64::consts::TAU), ratio, Some(lowest)]
}

/// The muscle that a calibration finds, as a scenario's text.
fn calibrated(problem: &Problem) -> String {
    let outcome = calibrate(problem, &CalibrationSettings::default(), &|_: &str| ()).expect("a fit");
    let muscle = Muscle::built_in("garbulinski-2022").expect("built in");
    let setup = Setup { marker: outcome.calibration.marker(problem), ..Setup::default() };
    let file = muscle_file(&muscle, &outcome.calibration, setup, "pder_32", "twin")
        .expect("a muscle")
        .expect("columns");
    format!(
        "[muscle]\ntext = {}\n[run]\nduration = \"{SECONDS} s\"\n{AS_DRAWN}",
        toml::Value::from(file.text)
    )
}

/// What a scenario predicts at a pressure, psi, with each payload.
fn foretold(text: String, psi: f64, payloads: &[f64]) -> Vec<Cell> {
    let asked = CaseRequest::scenario(Path::new("twin.toml"), text);
    let (case, known) = asked.case(Some(psi * PSI), Some(0.0)).expect("a case");
    let mut asked = asked;
    asked.release.payload_center = Some(case.model.tip_distance);
    let make = |pressure, payload| Ok(asked.case(pressure, Some(payload))?.0);
    let grid = grid("twin", (&[psi * PSI], payloads), &make, known.as_ref(), &|| ());
    grid.expect("a grid").cells
}

/// What a calibration of a seed's releases without a payload predicts.
fn predicted(seed: u64) -> Vec<Cell> {
    let problem = all_fitted(&Plan::of_two_angles(&[]).draw(seed));
    foretold(calibrated(&problem), PRESSURE, &PAYLOADS)
}

/// How far the truth is off a number, in half widths of its interval, and that half width over the number.
type Off = (f64, f64);

/// How far the truth is off each number of a cell.
fn off(cell: &Cell, truth: [Option<f64>; 4]) -> [Option<Off>; 4] {
    [0, 1, 2, 3].map(|k| {
        let quantity = cell.quantity(NAMES[k])?;
        let ([low, high], middle) = (quantity.interval_95?, quantity.value?);
        Some(((truth[k]? - middle) / (0.5 * (high - low)), 0.5 * (high - low) / middle.abs()))
    })
}

/// Of draws, each with its request: the share whose intervals hold the truth, by number; the figures are printed.
fn shares<const N: usize>(all: &[[[Option<Off>; 4]; N]], what: [&str; N]) -> [f64; 4] {
    let mut shares = [0.0; 4];
    for (k, name) in NAMES.iter().enumerate() {
        for (p, what) in what.iter().enumerate() {
            let own: Vec<Off> = all.iter().filter_map(|cells| cells[p][k]).collect();
            let mean = |of: &dyn Fn(&Off) -> f64| own.iter().map(of).sum::<f64>() / own.len() as f64;
            println!(
                "{name:16} {what}: of {} held {:>5.1} %, off by {:+.2} half widths in the mean, {:.2} rms; half width {:.3} %",
                own.len(),
                100.0 * mean(&|own| f64::from(own.0.abs() <= 1.0)),
                mean(&|own| own.0),
                mean(&|own| own.0 * own.0).sqrt(),
                100.0 * mean(&|own| own.1)
            );
            shares[k] += mean(&|own| f64::from(own.0.abs() <= 1.0)) / N as f64;
        }
    }
    shares
}

/// Of payloads.
fn coverage(seeds: Range<u64>) -> [f64; 4] {
    let one = |seed: u64| {
        let cells = predicted(seed);
        [0, 1, 2].map(|k| off(&cells[k], truth(seed, PAYLOADS[k])))
    };
    let all: Vec<_> = seeds.into_par_iter().map(one).collect();
    shares(&all, PAYLOADS.map(|payload| format!("{:>4.0} g", 1e3 * payload)).each_ref().map(String::as_str))
}

/// Of releases of a laboratory that took no part: at 70 psi, which was calibrated, and at 40 psi, between two pressures
/// that were; both from 25 degrees below the horizontal.
fn coverage_of_a_laboratory(seeds: Range<u64>) -> [f64; 4] {
    const PRESSURES: [f64; 2] = [70.0, 40.0];
    let down = (-25.0f64).to_radians();
    let one = |seed: u64| {
        let plan = Plan::usual(&[]).of_a_laboratory();
        let text = calibrated(&problem(&plan.draw(seed)));
        PRESSURES.map(|psi| {
            let text =
                format!("{text}[rod]\nbase_angle = \"{down} rad\"\n[release]\nangle = \"{down} rad\"\n");
            let own = |own: &DrawnRelease| {
                own.release.pressure == Some(psi * PSI) && own.nominal.release_angle == down
            };
            off(&foretold(text, psi, &[0.0])[0], seen(plan.clone(), seed, &own))
        })
    };
    let all: Vec<_> = seeds.into_par_iter().map(one).collect();
    shares(&all, ["at 70 psi", "at 40 psi"])
}

/// Of six numbers at 95 % fewer than four are held in one of five hundred trials.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn of_two_draws_most_intervals_hold_the_truth() {
    let shares = coverage(80_001..80_003);
    assert!(shares.iter().all(|share| *share >= 0.6), "{shares:?}");
}

#[test]
#[ignore = "a quarter of an hour: 100 draws of three payloads"]
fn of_one_hundred_draws_90_to_99_percent_hold_the_truth() {
    let shares = coverage(83_001..83_101);
    assert!(shares.iter().all(|share| (0.9..=0.99).contains(share)), "{shares:?}");
}

#[test]
#[ignore = "minutes: 60 draws"]
fn of_a_laboratory_90_to_99_percent_hold_the_truth() {
    let shares = coverage_of_a_laboratory(84_001..84_061);
    let all = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!((0.9..=0.99).contains(&all), "{shares:?}");
}
