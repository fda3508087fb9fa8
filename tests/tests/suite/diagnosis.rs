//! Goal: what is hidden in a drawn experiment is found, what is not there is not, and the repaired model
//! fits the held-out releases.
//! Setup: the twin, which shares no equation, mesh or integrator with the program; three pressures by two
//! angles, 6 s, noise of 0.3 mm, losses, ghosts, setup off within its tolerances.
//! Expected: the hidden effect first or in the class; gaps at the noise. `blind_bench` counts how often.

use efam_inference::calibrate::Prior;
use efam_inference::diagnose::{Diagnosis, DiagnosisOutcome, DiagnosisSettings, Verdict, diagnose};
use models::effects::CATALOGUE;
use tests::blind::{all_fitted, problem, setup};
use tests::twin::drawn::{Drawn, Plan, Priors};
use tests::twin::hidden::Hidden;

fn diagnosed(hidden: &[Hidden], seed: u64, settings: &DiagnosisSettings) -> DiagnosisOutcome {
    let drawn = Plan { duration: 6.0, ..Plan::of_two_angles(hidden) }.draw(seed);
    diagnose(&problem(&drawn), settings, &|_: &str| ()).expect("it can be diagnosed")
}

/// Settings with some effects of the catalogue alone.
fn only(asked: &[&str]) -> DiagnosisSettings {
    let names = CATALOGUE.iter().map(|effect| effect.about().name);
    let excluded = names.filter(|name| !asked.contains(name)).map(str::to_owned).collect();
    DiagnosisSettings { excluded, ..DiagnosisSettings::default() }
}

/// What is said without a catalogue: that something unknown is missing.
fn robbed(hidden: Hidden, seed: u64) -> Diagnosis {
    let excluded = CATALOGUE.iter().map(|effect| effect.about().name.to_owned()).collect();
    let found =
        diagnosed(&[hidden], seed, &DiagnosisSettings { excluded, ..DiagnosisSettings::default() }).diagnosis;
    assert_eq!(found.verdict, Verdict::Unknown, "{}", found.summary);
    found
}

fn worst_gap(diagnosis: &Diagnosis) -> f64 {
    diagnosis.gap.iter().map(|gap| gap.after).fold(0.0, f64::max)
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn where_nothing_is_hidden_nothing_is_named() {
    let found = diagnosed(&[], 901, &DiagnosisSettings::default()).diagnosis;
    assert_eq!(found.verdict, Verdict::NothingMissing, "{}", found.summary);
    assert!(found.effects.is_empty());
    assert!(worst_gap(&found) < 1.1, "{:?}", found.gap);
    assert_eq!(found.held_out.len(), 3);
}

#[test]
#[ignore = "a minute or more; the blind bench of CI has its kind"]
fn a_hidden_viscoelastic_branch_is_found_and_the_gap_closes() {
    let hidden = Hidden::named("viscoelastic", 1.0).expect("it is known");
    let DiagnosisOutcome { diagnosis: found, repaired, .. } =
        diagnosed(&[hidden], 902, &DiagnosisSettings::default());
    assert!(matches!(found.verdict, Verdict::Named | Verdict::Class), "{}", found.summary);
    let first = &found.effects[0];
    assert_eq!(first.effect, "viscoelastic", "{}", found.summary);
    assert!(worst_gap(&found) < 1.1, "{:?}", found.gap);
    let locked = found.gap.iter().filter(|gap| gap.held_out).map(|gap| gap.before);
    assert!(locked.fold(0.0, f64::max) > 1.5, "{:?}", found.gap);
    assert!(repaired.trials.iter().all(|trial| trial.model.effect("viscoelastic").is_some()));
}

/// A weight of which the experiment states the force alone: its mass is found, and no second weight.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn the_mass_of_a_weight_that_is_told_as_a_load_is_found() {
    const MASS: f64 = 0.02;
    let hidden = [Hidden::TipMass { mass: MASS }];
    let plan = Plan { pressures: vec![40.0; 2], angles: vec![0.0], duration: 3.0, ..Plan::usual(&hidden) };
    let mut problem = all_fitted(&plan.draw(912));
    for trial in problem.trials_mut() {
        let load = [("force_z", -9.81 * MASS)];
        trial.model = trial.model.with_effect("tip_load", &load).expect("an effect of the catalogue");
    }
    let settings = only(&["tip_mass", "added_mass", "air_drag"]);
    let found = diagnose(&problem, &settings, &|_: &str| ()).expect("it can be diagnosed").diagnosis;
    let first = &found.effects[0];
    assert_eq!(first.effect, "tip_mass", "{}", found.summary);
    let value = |name: &str| first.parameters.iter().find(|own| own.name == name).map(|own| own.value);
    assert_eq!(value("weight"), None, "{}", found.summary);
    assert!((value("mass").expect("it has one") / MASS - 1.0).abs() < 0.15, "{}", found.summary);
}

/// A rod whose EI is stated half too large, as exactly as if it had been measured, and nothing is missing: no effect takes
/// the blame.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_wrong_statement_is_said_before_an_effect() {
    let plan = Plan { pressures: vec![40.0], angles: vec![0.0], duration: 3.0, ..Plan::usual(&[]) };
    let drawn = plan.draw(913);
    let mut problem = all_fitted(&drawn);
    let truth = drawn.releases[0].bending_stiffness;
    let own = problem.parameters.iter_mut().find(|own| own.path == "rod.bending_stiffness");
    own.expect("it is fitted").prior = Some(Prior { mean: 1.5 * truth, deviation: 0.01 * truth });
    let found = diagnose(&problem, &only(&["tip_mass"]), &|_: &str| ()).expect("it can be diagnosed");
    let found = found.diagnosis;
    assert!(found.effects.is_empty(), "{}", found.summary);
    let first = found.contradictions.first().expect("EI is not as stated");
    assert_eq!(first.parameter, "EI", "{}", found.summary);
    assert!((first.value / truth - 1.0).abs() < 0.02, "{} of {truth}", first.value);
}

/// What is said of a setup with something off.
fn asked_of_setup(hidden: (&'static str, f64), seed: u64) -> setup::Answer {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(hidden.0);
    setup::ask(hidden, seed, &folder).expect("it is read and asked")
}

/// A clamp that is a few degrees off while the rod is held at the stated angle: the angle between both is wrong, and no effect of
/// the material takes the blame.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_clamp_that_stands_otherwise_than_stated_is_said() {
    let answer = asked_of_setup(("clamp_tilt", 40.0), 904).diagnosis;
    assert_eq!(answer.verdict, Verdict::Misstated, "{}", answer.summary);
    let word = answer.freed.as_deref().unwrap_or_default();
    assert!(answer.effects.is_empty() && ["clamp", "hold"].contains(&word), "{}", answer.summary);
}

/// Without the tilt the baseline misses far more than the camera's noise. Held-out releases are then weighed as those that were
/// fitted, or a model that is right would not be accepted.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_camera_that_leans_is_named() {
    let answer = asked_of_setup(setup::hidden(0, 884_001), 884_001);
    assert!(answer.is_right(), "{}", answer.diagnosis.summary);
}

/// A rod that a hand pushes upwards as it lets go: its instant lies where the hand lets go, and not where the rod begins to fall.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_hand_that_pushes_is_named() {
    let hidden = setup::hidden(2, 884_016);
    let answer = asked_of_setup(hidden, 884_016);
    assert!(answer.is_right() && hidden.1 > 0.0, "{}", answer.diagnosis.summary);
    let truth = Hidden::named(hidden.0, hidden.1).expect("it is known").strength();
    let values = &answer.diagnosis.effects[0].parameters;
    let off = values.iter().map(|own| (own.value / truth - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 0.2, "{}", answer.diagnosis.summary);
}

/// One round, and nothing is added: what the recordings support is shown, and is not called nothing.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn where_no_effect_may_be_added_what_speaks_is_not_called_nothing() {
    let hidden = Hidden::named("viscoelastic", 1.0).expect("it is known");
    let settings = DiagnosisSettings { most_effects: 0, ..only(&["viscoelastic", "air_drag"]) };
    let found = diagnosed(&[hidden], 902, &settings).diagnosis;
    assert_eq!((found.verdict, found.effects.len()), (Verdict::Unknown, 0), "{}", found.summary);
    assert_eq!(found.rounds.len(), 1);
    assert!(found.rounds[0].candidates.iter().any(|own| own.best() > found.rounds[0].bar));
}

/// Releases of a muscle with a viscoelastic branch with a different strength at each pressure, in what is typical.
fn with_branches(sizes: [f64; 3], plan: &Plan, seed: u64) -> Drawn {
    let drawn = |size: f64| {
        let hidden = Hidden::named("viscoelastic", size).expect("it is known");
        Plan { hidden: vec![hidden], ..plan.clone() }.draw(seed)
    };
    // What is drawn by chance does not depend on what is hidden.
    let mut all = drawn(sizes[0]);
    for k in [1, 2] {
        all.releases.splice(2 * k..2 * k + 2, drawn(sizes[k]).releases.drain(2 * k..2 * k + 2));
    }
    all
}

/// A muscle with large branches and an EI held as its statics say: they take the phase within the first swing, and no
/// score says anything. Only some of the catalogue are candidates.
fn with_stiffness_of_statics(asked: &[&str], seed: u64) -> Diagnosis {
    let usual = Plan::of_two_angles(&[]);
    let priors = Priors { bending_stiffness: 0.0, ..usual.priors };
    let plan = Plan { duration: 4.0, priors, ..usual };
    let mut problem = problem(&with_branches([1.0, 20.0, 20.0], &plan, seed));
    problem.parameters.retain(|parameter| parameter.path != "rod.bending_stiffness");
    let settings = DiagnosisSettings { most_effects: 1, ..only(asked) };
    diagnose(&problem, &settings, &|_: &str| ()).expect("it can be diagnosed").diagnosis
}

#[test]
#[ignore = "a minute or more; its kind has a shorter test beside it"]
fn what_is_missing_from_the_first_swing_on_is_found() {
    let asked = ["viscoelastic", "damping_over_pressure", "cubic_stiffness", "tip_mass"];
    let found = with_stiffness_of_statics(&asked, 907);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.summary);
    let own = found.effects[0].parameters.iter().filter(|own| own.name == "branch_stiffness");
    let sizes: Vec<f64> = own.map(|own| own.value).collect();
    let typical = Hidden::named("viscoelastic", 1.0).expect("it is known").strength();
    assert!((sizes[0] / typical - 1.0).abs() < 0.1, "{sizes:?}");
    assert!((sizes[1] / (20.0 * typical) - 1.0).abs() < 0.02, "{sizes:?}");
    assert!(worst_gap(&found) < 1.25, "{:?}", found.gap);
}

/// The same where no candidate could do it: what is named for want of a better is not called complete.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn what_misses_the_first_swings_with_every_effect_is_unknown() {
    let found = with_stiffness_of_statics(&["damping_over_pressure", "tip_mass"], 908);
    assert!(matches!(found.verdict, Verdict::Unknown | Verdict::Incomplete), "{}", found.summary);
}

/// No effect of one size does what this does; the size at the held-out pressure is its own, too, and one release more
/// is held out at a pressure that is not.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn an_effect_of_another_size_at_each_pressure_is_found() {
    let plan = Plan { duration: 4.0, ..Plan::of_two_angles(&[]) };
    let all = with_branches([0.5, 1.0, 2.0], &plan, 905);
    // Six of them score higher than the one that is hidden.
    let asked = [
        "clock",
        "hose",
        "set_curvature",
        "cubic_stiffness",
        "quadratic_stiffness",
        "pressure_volume",
        "viscoelastic",
    ];
    let settings = DiagnosisSettings { most_effects: 1, ..only(&asked) };
    let outcome = diagnose(&problem(&all), &settings, &|_: &str| ()).expect("it can be diagnosed");
    let DiagnosisOutcome { diagnosis: found, repaired, .. } = outcome;
    assert!(matches!(found.verdict, Verdict::Named | Verdict::Class), "{}", found.summary);
    assert!(
        found.summary.contains("Viscoelastic bending with a strength of its own at each pressure"),
        "{}",
        found.summary
    );
    let own = found.effects[0].parameters.iter().filter(|own| own.name == "branch_stiffness");
    let sizes: Vec<f64> = own.map(|own| own.value).collect();
    let typical = Hidden::named("viscoelastic", 1.0).expect("it is known").strength();
    assert_eq!(sizes.len(), 2, "{:?}", found.effects);
    assert!((sizes[0] / (0.5 * typical) - 1.0).abs() < 0.15, "{sizes:?}");
    assert!((sizes[1] / (2.0 * typical) - 1.0).abs() < 0.1, "{sizes:?}");
    // At the held-out pressure it has the size that was fitted there.
    let locked = &repaired.trials[2].model;
    let own = locked.value("effects.viscoelastic.branch_stiffness").expect("it is there");
    assert!((own / typical - 1.0).abs() < 0.1, "{own}");
    assert!(worst_gap(&found) < 1.25, "{:?}", found.gap);
}

/// With nothing to choose from, what is hidden is described, and not called nothing.
#[test]
#[ignore = "a minute or more; its kind has a shorter test beside it"]
fn what_the_catalogue_does_not_hold_is_unknown() {
    let found = robbed(Hidden::named("viscoelastic", 20.0).expect("it is known"), 903);
    assert!(found.summary.contains("that no effect of the catalogue explains"), "{}", found.summary);
    assert!(found.seen.iter().any(|own| own.deviations[1].abs() > 3.0), "{:?}", found.seen);
}

/// Right answers of the method of scores that the present one does not give. Each moves to the tests above when it does.
mod not_met {
    use super::*;

    /// A mass at the tip, seen in releases of one condition that differ in EI by more than their noise: what does not
    /// repeat is few numbers a release, however many samples show it.
    #[test]
    #[ignore = "not met: docs/src/validation/evidence.md, What is not right"]
    fn an_interval_holds_what_does_not_repeat() {
        const MASS: f64 = 0.015;
        let priors = Priors { bending_stiffness: 0.003, ..Priors::default() };
        let hidden = [Hidden::TipMass { mass: MASS }];
        let (pressures, angles) = (vec![40.0; 3], vec![0.0]);
        let plan = Plan { pressures, angles, duration: 4.0, priors, ..Plan::usual(&hidden) };
        let settings = only(&["tip_mass", "air_drag", "clamp_compliance"]);
        let found = diagnose(&all_fitted(&plan.draw(911)), &settings, &|_: &str| ())
            .expect("it can be diagnosed")
            .diagnosis;
        let first = &found.effects[0];
        assert_eq!(first.effect, "tip_mass", "{}", found.summary);
        let [low, high] = first.parameters[0].interval_95.expect("it was fitted");
        assert!((low..=high).contains(&MASS) && low >= 0.0 && high - low > 0.2 * MASS, "{}", found.summary);
    }

    /// A pressure that rises with bending explains nearly all of a cubic stiffness. The rest is within the error of a law, and more
    /// than noise: the answer is incomplete.
    #[test]
    #[ignore = "not met: docs/src/validation/evidence.md, What is not right"]
    fn a_similar_law_is_called_incomplete() {
        let hidden = Hidden::named("cubic_stiffness", 0.3).expect("it is known");
        let problem = problem(&Plan { duration: 4.0, ..Plan::of_two_angles(&[hidden]) }.draw(909));
        let found =
            diagnose(&problem, &only(&["pressure_volume"]), &|_: &str| ()).expect("it can be diagnosed");
        let found = found.diagnosis;
        assert_eq!(found.verdict, Verdict::Incomplete, "{}", found.summary);
        assert!(found.summary.contains("More than noise remains"), "{}", found.summary);
    }

    /// A clamp that is a few degrees off, in recordings that are read and cleaned as a laboratory's: nothing that a
    /// diagnosis fits by itself can do that, and the nearest effect was named instead.
    #[test]
    #[ignore = "not met: docs/src/validation/evidence.md, What is not right"]
    fn a_clamp_that_stands_otherwise_than_stated_is_named() {
        let hidden = ("clamp_tilt", 20.0);
        let answer = asked_of_setup(hidden, 904);
        assert!(answer.is_right(), "{}", answer.diagnosis.summary);
        let truth = Hidden::named(hidden.0, hidden.1).expect("it is known").strength();
        let off = answer.diagnosis.contradictions.iter().map(|own| (own.value / truth - 1.0).abs());
        assert!(off.fold(0.0, f64::max) < 0.2, "{}", answer.diagnosis.summary);
        // So does the clamp of every model that is given back, of held-out releases as well.
        let stated = [0.0, -25.0f64.to_radians()];
        for (k, trial) in answer.repaired.trials.iter().enumerate() {
            let clamp = trial.model.value("rod.base_angle").expect("a rod has one");
            assert!((clamp - stated[k % 2] - truth).abs() < 0.2 * truth.abs(), "{clamp} rad of release {k}");
        }
    }

    /// The same where no candidate could do it: nothing is named for want of a better.
    #[test]
    #[ignore = "not met: docs/src/validation/evidence.md, What is not right"]
    fn what_misses_the_first_swings_with_every_effect_is_unknown() {
        let found = with_stiffness_of_statics(&["damping_over_pressure", "tip_mass"], 908);
        assert_eq!((found.verdict, found.effects.len()), (Verdict::Unknown, 0), "{}", found.summary);
    }

    /// With nothing to choose from, what is hidden is described, and not called nothing.
    #[test]
    #[ignore = "not met: docs/src/validation/evidence.md, What is not right"]
    fn what_the_catalogue_does_not_hold_is_unknown() {
        robbed(Hidden::named("viscoelastic", 1.0).expect("it is known"), 903);
    }
}
