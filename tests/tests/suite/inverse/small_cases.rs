//! Goal: a calibration finds what made the data, and knows how well.
//! Setup: the paper's muscle on 160 nodes, integrated at a tolerance of 1e-7, sampled a hundred
//! times a second, with seeded noise and lost samples; fitted on 32 nodes. (With 48 nodes the
//! truth would have a mesh of its own, worth 0.2 % of EI.) Twins of whole experiments are beside this; here
//! each claim has its own small case.
//! Expected: estimates within their stated errors; words where the data cannot determine it.

use efam_core::forward::{Run, uniform};
use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use efam_inference::calibrate::{
    CalibrationOutcome, CalibrationSettings, FittedParameter, Nuisances, Problem, Scope, Trial, calibrate,
};
use models::model::Model;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use tests::{PSI, paper, simulate};

const EI: &str = "rod.bending_stiffness";
const ALPHA: &str = "effects.rayleigh_mass.alpha";
const BETA: &str = "effects.rayleigh_stiffness.beta";

/// The paper's muscle with losses.
fn muscle(psi: f64, nodes: usize, alpha: f64, beta: f64) -> Model {
    paper(psi, nodes, &[("rayleigh_mass.alpha", alpha), ("rayleigh_stiffness.beta", beta)])
}

/// What a made-up recording has that no model says.
#[derive(Clone, Copy)]
struct Recording {
    seed: u64,
    duration: f64,
    noise: f64,
    /// Time zero of the recording before the true release, s.
    late: f64,
    /// Hold angle, rad.
    angle: f64,
    /// Share of samples that are ghosts.
    ghosts: f64,
}

const USUAL: Recording =
    Recording { seed: 1, duration: 6.0, noise: 3e-4, late: 0.0, angle: 0.0, ghosts: 0.0 };

fn normal(random: &mut impl RngCore) -> f64 {
    let (u, v) = (1.0 - uniform_number(random), uniform_number(random));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn uniform_number(random: &mut impl RngCore) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn record(truth: &Model, psi: f64, of: Recording, points: &[Point]) -> Release {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(of.seed);
    let mut model = truth.clone();
    model.set("release.angle", of.angle).unwrap();
    let time = uniform(of.duration, 100.0);
    let run = Run {
        samples: time.iter().map(|t| (t - of.late).max(0.0)).collect(),
        tolerance: 1e-7,
        points: points.to_vec(),
        ..Run::release(of.duration, 100.0)
    };
    let path = simulate(&model, &run);
    let tracks = points.iter().enumerate().map(|(p, at)| Track {
        marker: format!("marker {p}"),
        at: *at,
        noise: of.noise,
        discrepancy: 0.0,
        position: (path.points.iter())
            .map(|seen| {
                let is_lost = uniform_number(&mut random) < 0.03;
                let is_ghost = uniform_number(&mut random) < of.ghosts;
                let far = if is_ghost { 0.2 } else { 0.0 };
                let seen = seen[p].map(|x| x + of.noise * normal(&mut random) + far);
                (!is_lost).then_some(seen)
            })
            .collect(),
    });
    Release {
        name: format!("made-up.csv#{}", of.seed),
        tracks: tracks.collect(),
        time,
        release_uncertainty: 0.003,
        pressure: Some(psi * PSI),
        payload: 0.0,
        held_out: false,
        out_of_plane: OutOfPlane::default(),
    }
}

fn trial(model: &Model, release: Release) -> Trial {
    Trial { release, model: model.clone(), run: Run::release(1.0, 100.0) }
}

fn three() -> Vec<FittedParameter> {
    [EI, ALPHA, BETA].map(|path| FittedParameter::new(path, Scope::Shared)).to_vec()
}

fn solve(problem: &Problem) -> CalibrationOutcome {
    calibrate(problem, &CalibrationSettings::default(), &|_: &str| ()).unwrap()
}

/// Distance of an estimate from the truth in standard errors.
fn off(outcome: &CalibrationOutcome, path: &str, truth: f64) -> f64 {
    let found = outcome.calibration.of(path)[0];
    (found.value - truth) / found.standard_error.unwrap()
}

/// Off by a factor of three in both losses and 30 % in EI, another mesh and integrator, lost samples,
/// a release instant of 4 ms and a hold angle of 0.4 degrees that nobody has said.
#[test]
fn a_poor_start_finds_the_truth() {
    let (alpha, beta) = (0.6, 0.004);
    let truth = muscle(15.0, 160, alpha, beta);
    let release = record(&truth, 15.0, Recording { late: 0.004, angle: 0.007, ..USUAL }, &[Point::Tip]);
    let mut model = muscle(15.0, 32, 3.0 * alpha, beta / 3.0);
    let ei = truth.rod().bending_stiffness;
    model.set(EI, 0.7 * ei).unwrap();
    let problem = Problem {
        trials: vec![trial(&model, release).into()],
        parameters: three(),
        nuisances: Nuisances::default(),
    };
    let outcome = solve(&problem);
    // Each estimate errs by a normal number of standard errors; one in 16 000 by four.
    for (path, truth) in [(EI, ei), (ALPHA, alpha), (BETA, beta)] {
        let off = off(&outcome, path, truth);
        assert!(off.abs() < 4.0, "{path}: {off} standard errors");
    }
    let found = outcome.calibration.of(EI)[0];
    assert!((found.value / ei - 1.0).abs() < 0.005, "{found:?}");
    let instant = &outcome.calibration.nuisances[0];
    assert!((instant.value - 0.004).abs() < 4.0 * instant.standard_error.unwrap(), "{instant:?}");
}

/// Draws of a cheap case: one second of one release, two parameters. The intervals must hold the truth as
/// often as they say: of 160 of them 95 % with a standard error of 1.7 %, so 90 to 99 % leaves three.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let alpha = 1.5;
    let truth = muscle(15.0, 100, alpha, 0.002);
    let clean = record(&truth, 15.0, Recording { duration: 1.2, noise: 0.0, ..USUAL }, &[Point::Tip]);
    let model = muscle(15.0, 20, 1.2 * alpha, 0.002);
    let ei = truth.rod().bending_stiffness;
    let mut held = [0, 0];
    const DRAWS: u64 = 80;
    for seed in 0..DRAWS {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1000 + seed);
        let mut release = clean.clone();
        let track = &mut release.tracks[0];
        track.noise = 3e-4;
        for seen in track.position.iter_mut().flatten() {
            *seen = seen.map(|x| x + 3e-4 * normal(&mut random));
        }
        let problem = Problem {
            trials: vec![trial(&model, release).into()],
            parameters: [EI, ALPHA].map(|path| FittedParameter::new(path, Scope::Shared)).to_vec(),
            nuisances: Nuisances {
                release_instant: false,
                hold_angle: None,
                offset: None,
                ..Nuisances::default()
            },
        };
        let outcome = solve(&problem);
        for (held, (path, truth)) in held.iter_mut().zip([(EI, ei), (ALPHA, alpha)]) {
            let [low, high] = outcome.calibration.of(path)[0].interval_95.unwrap();
            *held += usize::from(low <= truth && truth <= high);
        }
    }
    let share = (held[0] + held[1]) as f64 / (2 * DRAWS) as f64;
    assert!((0.90..=0.99).contains(&share), "{share}: {held:?}");
}

/// One sample in a hundred lies 280 mm off, and nobody has masked it: the estimates stay within their
/// intervals, while the share that least squares would follow is some hundred standard errors.
#[test]
fn ghosts_that_cleaning_has_missed_do_no_harm() {
    let (alpha, beta) = (1.0, 0.003);
    let truth = muscle(30.0, 160, alpha, beta);
    let release = record(&truth, 30.0, Recording { ghosts: 0.01, duration: 4.0, ..USUAL }, &[Point::Tip]);
    let model = muscle(30.0, 32, 0.7, 0.004);
    let problem = Problem {
        trials: vec![trial(&model, release).into()],
        parameters: three(),
        nuisances: Nuisances {
            release_instant: false,
            hold_angle: None,
            offset: None,
            ..Nuisances::default()
        },
    };
    let outcome = solve(&problem);
    for (path, truth) in [(EI, truth.rod().bending_stiffness), (ALPHA, alpha), (BETA, beta)] {
        let off = off(&outcome, path, truth);
        assert!(off.abs() < 4.0, "{path}: {off} standard errors");
    }
    assert!(outcome.calibration.releases[0].tracks[0].held_back >= 3);
}

/// All masses and all stiffnesses in one ratio give one and the same motion: the data cannot separate EI from the
/// masses, and the calibration says so, with the experiment that would.
#[test]
fn stiffness_against_mass_is_said_to_be_hard_to_tell() {
    let truth = muscle(15.0, 60, 0.8, 0.004);
    let release = record(&truth, 15.0, Recording { duration: 3.0, ..USUAL }, &[Point::Tip]);
    let model = muscle(15.0, 24, 0.8, 0.004);
    let parameters = [EI, "rod.mass", "rod.axial_stiffness", "effects.end_fitting.mass", ALPHA];
    let problem = Problem {
        trials: vec![trial(&model, release).into()],
        parameters: parameters.map(|path| FittedParameter::new(path, Scope::Shared)).to_vec(),
        nuisances: Nuisances {
            release_instant: true,
            hold_angle: None,
            offset: None,
            ..Nuisances::default()
        },
    };
    let settings = CalibrationSettings { remove_mesh: false, ..CalibrationSettings::default() };
    let found = calibrate(&problem, &settings, &|_: &str| ()).unwrap().calibration;
    let said = found.warnings.join("\n");
    let is_vague = found.of(EI)[0].relative_error().is_none_or(|error| error > 1.0);
    assert!(is_vague, "{found:?}");
    assert!(said.contains("payload of known mass") && said.contains("rod.bending_stiffness"), "{said}");
}

/// The same problem on one thread and on two, to the last bit.
#[test]
fn the_number_of_threads_changes_no_bit() {
    let truth = muscle(15.0, 40, 1.0, 0.004);
    let release = |seed| {
        record(&truth, 15.0, Recording { seed, duration: 1.5, ..USUAL }, &[Point::Tip, Point::Along(0.6)])
    };
    let model = muscle(15.0, 16, 1.5, 0.003);
    let problem = Problem {
        trials: (1..4).map(|seed| trial(&model, release(seed)).into()).collect(),
        parameters: three(),
        nuisances: Nuisances::default(),
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&problem))
    };
    assert!(on(1) == on(2));
}

/// Profile and curvature agree where the cost is nearly a parabola: to a fifth of the width.
#[test]
fn the_profile_agrees_with_the_curvature_of_a_parabola() {
    let truth = muscle(15.0, 40, 1.0, 0.0);
    let release = record(&truth, 15.0, Recording { duration: 1.5, ..USUAL }, &[Point::Tip]);
    let model = muscle(15.0, 16, 1.2, 0.0);
    let problem = Problem {
        trials: vec![trial(&model, release).into()],
        parameters: [EI, ALPHA].map(|path| FittedParameter::new(path, Scope::Shared)).to_vec(),
        nuisances: Nuisances {
            release_instant: true,
            hold_angle: None,
            offset: None,
            ..Nuisances::default()
        },
    };
    let settings = CalibrationSettings { profile: true, ..CalibrationSettings::default() };
    let found = calibrate(&problem, &settings, &|_: &str| ()).unwrap().calibration;
    for one in &found.parameters {
        let (curved, profiled) = (one.interval_95.unwrap(), one.profile_95.unwrap());
        let width = curved[1] - curved[0];
        for (a, b) in curved.iter().zip(profiled) {
            assert!((a - b).abs() < 0.2 * width, "{}: {curved:?} {profiled:?}", one.name);
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused_in_words() {
    let model = muscle(15.0, 16, 1.0, 0.001);
    let release = record(&model, 15.0, Recording { duration: 0.5, ..USUAL }, &[Point::Tip]);
    let one = trial(&model, release);
    let refused = |trials: Vec<Trial>, parameters: Vec<FittedParameter>| {
        let trials = trials.into_iter().map(Into::into).collect();
        let problem = Problem { trials, parameters, nuisances: Nuisances::default() };
        calibrate(&problem, &CalibrationSettings::default(), &|_: &str| ()).unwrap_err().to_string()
    };
    let only = |path: &str| vec![FittedParameter::new(path, Scope::PerPressure)];
    assert!(refused(Vec::new(), three()).contains("no release to calibrate with"));
    assert!(refused(vec![one.clone()], Vec::new()).contains("no parameter to calibrate"));
    assert!(refused(vec![one.clone()], only("rod.bending")).contains("rod.bending_stiffness"));
    let mut other = one.clone();
    other.release.pressure = None;
    assert!(refused(vec![other], only(EI)).contains("has no pressure"));
    let mut other = one.clone();
    other.release.tracks[0].position.fill(None);
    assert!(refused(vec![other], three()).contains("0 samples"));
    let mut other = one.clone();
    other.release.tracks[0].at = Point::Along(1.5);
    assert!(refused(vec![other], three()).contains("1.5 of the active length"));
    let start = FittedParameter { start: Some(-1.0), ..FittedParameter::new(EI, Scope::Shared) };
    assert!(refused(vec![one.clone()], vec![start]).contains("must lie within the bounds"));
    assert!(refused(vec![one], [three(), three()].concat()).contains("twice"));
}
