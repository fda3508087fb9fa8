//! What a scenario gives, and that it can be given again.

use std::path::Path;

use efam_core::forward::Initial;
use models::effects::CATALOGUE;
use models::history::History;
use models::quantity::Unit;

use super::*;

const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";
const ROD: &str = "[rod]\nlength = \"300 mm\"\nmass = \"30 g\"\nbending_stiffness = \"0.05 N m^2\"\n\
                   axial_stiffness = \"1000 N\"\n";

fn one(text: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let scenario = Scenario::parse(Path::new("some/where.toml"), text, &overrides);
    let mut cases = scenario.and_then(|scenario| scenario.cases()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(cases.len(), 1);
    cases.remove(0)
}

fn error(text: &str, overrides: &[&str]) -> String {
    let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let scenario = Scenario::parse(Path::new("where.toml"), text, &overrides);
    match scenario.and_then(|scenario| scenario.cases()) {
        Ok(_) => panic!("nothing is refused"),
        Err(error) => error.to_string(),
    }
}

fn value(case: &Case, path: &str) -> f64 {
    case.model.value(path).unwrap()
}

#[test]
fn a_muscle_gives_rod_end_fitting_and_gravity() {
    let case = one(MUSCLE, &[]);
    assert_eq!(case.name, "where");
    assert_eq!(value(&case, "rod.length"), 7.99 * 0.0254);
    assert_eq!(value(&case, "rod.bending_stiffness"), 0.00709);
    assert_eq!(Some(value(&case, "rod.pressure")), case.pressure);
    assert_eq!(value(&case, "rod.mass"), 0.14227 * (6.69 * 0.0254));
    assert_eq!(value(&case, "effects.end_fitting.mass"), 54.92 * 1e-3);
    assert_eq!(case.model.tip_distance, 0.662 * 0.0254);
    assert_eq!(case.run.samples.len(), 2001);
    let own = one(MUSCLE, &["muscle.mass=per_length", "rod.tip=0 m", "rod.bending_stiffness=1 N m^2"]);
    assert_eq!(value(&own, "rod.mass"), 0.14227 * (7.99 * 0.0254));
    assert_eq!(value(&case, "effects.enclosed_air.inner_diameter"), 0.98 * 0.0254);
    assert!(own.model.effect("enclosed_air").is_none(), "the paper's way");
    assert_eq!(own.model.tip_distance, 0.0);
    assert_eq!(value(&own, "rod.bending_stiffness"), 1.0);
}

#[test]
fn all_rows_are_twenty_cases_in_order() {
    let scenario =
        Scenario::parse(Path::new("s.toml"), MUSCLE, &["muscle.pressure=all rows".to_owned()]).unwrap();
    let cases = scenario.cases().unwrap();
    assert!(scenario.is_all_rows());
    assert_eq!(cases.len(), 20);
    assert_eq!((cases[0].name.as_str(), cases[19].name.as_str()), ("s-005psi", "s-100psi"));
    assert!(cases.windows(2).all(|pair| pair[0].pressure < pair[1].pressure));
}

/// Catches a number that loses a bit in a round trip, a key that is left out, and an order that differs.
#[test]
fn a_resolved_case_gives_the_same_model_and_run() {
    let held = "[release]\nfrom = \"equilibrium\"\n[release.hold]\npressure = \"22 psi\"\n\
                [release.hold.effects.tip_load]\nforce_z = \"0.3 N\"\n";
    let points = "[release]\nnodes = [[\"0 m\", \"0 m\", \"0 m/s\", \"0 m/s\"], \
                  [\"0.1 m\", \"0.01 m\", \"0 m/s\", \"1 m/s\"], [\"0.2 m\", \"0.05 m\", \"0 m/s\", \"2 m/s\"]]\n";
    for (text, overrides) in [
        (MUSCLE.to_owned(), &["effects.air_drag.drag_coefficient=0.3", "release.angle=33 deg"][..]),
        (MUSCLE.to_owned(), &["muscle.pressure=[['0 s','17 psi'],['5.1 s','20.3 psi']]", "rod.scheme=paper"]),
        (format!("{MUSCLE}{held}"), &["effects.clamp_compliance.compliance=3 deg/(N m)"]),
        (format!("{MUSCLE}{points}"), &["run.rate=77.7 Hz", "integrator.fixed_step=0.3 ms"]),
        (format!("{ROD}{points}"), &["rod.length=0.21 m", "integrator.tolerance=1e-7"]),
        (ROD.to_owned(), &["rod.diameter=3.3 mm", "effects.viscoelastic.branch_stiffness=0.123"]),
        (format!("{ROD}{HUNG}"), &["effects.creep.creep_time=9 s", "release.history.held=0.7 s"]),
        (format!("{MUSCLE}{HUNG}"), &["effects.dahl.exponent=2", "effects.payload.offset=-3 mm"]),
    ] {
        let case = one(&text, overrides);
        let again = one(&case.resolved(), &[]);
        assert_eq!(again.name, case.name);
        assert_eq!(again.model.theta, case.model.theta, "{}", case.resolved());
        assert_eq!(again.model.tip_distance, case.model.tip_distance);
        assert_eq!((again.model.edges, again.model.scheme), (case.model.edges, case.model.scheme));
        let names = |case: &Case| case.model.parameters.iter().map(|p| p.path.clone()).collect::<Vec<_>>();
        assert_eq!(names(&again), names(&case));
        let (a, b) = (&again.run, &case.run);
        assert_eq!((a.duration, &a.samples, a.method), (b.duration, &b.samples, b.method));
        assert_eq!((a.tolerance, &a.steps, a.most_steps), (b.tolerance, &b.steps, b.most_steps));
        assert_eq!(a.history, b.history);
        match (&a.initial, &b.initial) {
            (Initial::Straight, Initial::Straight) => {}
            (Initial::Curve(a), Initial::Curve(b)) => assert_eq!(a, b),
            (Initial::Equilibrium { hold: a, own: i }, Initial::Equilibrium { hold: b, own: j }) => {
                assert_eq!((&a.theta, i), (&b.theta, j));
                assert_ne!(a.theta, again.model.theta);
            }
            (a, b) => panic!("{a:?} and {b:?}"),
        }
        assert_eq!(again.model.schedule.is_some(), case.model.schedule.is_some());
        if let (Some(a), Some(b)) = (&again.model.schedule, &case.model.schedule) {
            assert_eq!(a.breakpoints(), b.breakpoints());
            for time in [0.0, 0.123, 3.0, 5.1, 7.0] {
                assert_eq!(a.factors(time, time), b.factors(time, time));
                assert_eq!(a.pressure_change(time, time), b.pressure_change(time, time));
            }
        }
        assert_eq!(again.resolved(), case.resolved());
    }
}

const HUNG: &str = "[release]\nhistory = { hung = \"20 s\", raised = \"3 s\", held = \"5 s\" }\n";

#[test]
fn a_history_needs_its_three_times_and_something_that_remembers() {
    let creeps = ["effects.creep.creep_time=9 s".to_owned()];
    let case = one(&format!("{MUSCLE}{HUNG}"), &["effects.creep.creep_time=9 s"]);
    assert_eq!(case.run.history, Some(History { hung: 20.0, raised: 3.0, held: 5.0 }));
    assert_eq!(case.warnings, [""; 0]);
    let [warning] = &one(&format!("{MUSCLE}{HUNG}"), &[]).warnings[..] else { panic!("one warning") };
    assert!(warning.contains("release.history") && warning.contains("memory"), "{warning}");
    for (wrong, words) in [
        ("{ hung = \"20 s\", held = \"5 s\" }", "release.history.raised"),
        ("{ hung = \"20 s\", raised = \"0 s\", held = \"5 s\" }", "be positive"),
        ("{ hung = \"-1 s\", raised = \"2 s\", held = \"5 s\" }", "not be negative"),
        ("{ hung = \"20 s\", lifted = \"2 s\", held = \"5 s\" }", "release.history.lifted"),
        ("\"20 s\"", "release.history"),
    ] {
        let text = format!("{MUSCLE}[release]\nhistory = {wrong}\n");
        let error = Scenario::parse(Path::new("s.toml"), &text, &creeps).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// [`super::resolved`] writes numbers in these units: a scale other than one would cost bits.
#[test]
fn declared_units_are_si() {
    let declared = CATALOGUE.iter().flat_map(|effect| effect.about().parameters).map(|p| p.unit);
    for unit in declared.chain(units::ROD.map(|rod| rod.1)).chain(["rad", "rad/s", "m/s", "s", "Hz", "Pa"]) {
        assert_eq!(Unit::parse(unit).unwrap().scale, 1.0, "{unit}");
    }
}

#[test]
fn a_hold_may_use_a_load_that_the_release_does_not_have() {
    let held = "[release]\nfrom = \"equilibrium\"\n[release.hold.effects.tip_load]\nforce_z = \"0.3 N\"\n";
    let case = one(&format!("{MUSCLE}{held}"), &[]);
    assert_eq!(value(&case, "effects.tip_load.force_z"), 0.0);
    let Initial::Equilibrium { hold, own } = &case.run.initial else { panic!("{:?}", case.run.initial) };
    assert_eq!(own, &[hold.index("effects.tip_load.force_z").unwrap()]);
    assert_eq!(hold.theta[own[0]], 0.3);
}

#[test]
fn a_rod_that_springs_back_along_itself_warns() {
    let held = "[release]\nfrom = \"equilibrium\"\n[release.hold]\npressure = \"40 psi\"\n";
    let case = one(&format!("{MUSCLE}{held}"), &[]);
    let [warning] = &case.warnings[..] else { panic!("{:?}", case.warnings) };
    assert!(
        warning.starts_with("release.hold: the rod is 294.4 mm long while it is held and 202.9 mm"),
        "{warning}"
    );

    let points = std::env::temp_dir().join(format!("efam-posture-{}.csv", std::process::id()));
    let posture = |length: f64| {
        std::fs::write(&points, format!("x_m,z_m\n0,0\n{length},0\n")).unwrap();
        format!("{MUSCLE}[release]\nposture = {points:?}\n")
    };
    assert_eq!(one(&posture(1.005 * 7.99 * 0.0254), &[]).warnings, [] as [&str; 0]);
    let case = one(&posture(1.06 * 7.99 * 0.0254), &[]);
    let [warning] = &case.warnings[..] else { panic!("{:?}", case.warnings) };
    assert!(warning.contains("springs back along itself"), "{warning}");
    let message = error(&posture(2.0 * 7.99 * 0.0254), &[]);
    assert!(message.contains("give points of the whole active length"), "{message}");
    std::fs::remove_file(&points).unwrap();
}

#[test]
fn an_extrapolated_pressure_warns() {
    let case = one(MUSCLE, &["muscle.pressure=140 psi", "muscle.extrapolation=allowed"]);
    assert_eq!(
        case.warnings,
        [
            "muscle.pressure: 140 psi (965.266 kPa) lies outside the table, 5 to 100 psi (34.474 to 689.476 kPa): \
          extrapolated along straight lines"
        ]
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let with = |line: &str| format!("{MUSCLE}{line}\n");
    for (text, expected) in [
        (with("presure = 1"), "where.toml:4:1: muscle.presure: unknown key; did you mean `pressure`?"),
        (
            with("[effects.payload]\nmass = \"80 psi\""),
            "where.toml:5:8: effects.payload.mass: \"80 psi\" is a pressure, but a mass is due, such as \"80 g\" or \"80 kg\"",
        ),
        (
            with("[effects.payload]\nmass = 80"),
            "where.toml:5:8: effects.payload.mass: 80: needs a unit of mass, such as \"80 g\" or \"80 kg\"",
        ),
        (
            with("[effects.payload]\nmass = nan"),
            "where.toml:5:8: effects.payload.mass: nan: the number must be finite",
        ),
        (
            with("[effects.payload]\nmass = \"-80 g\""),
            "where.toml:5:8: effects.payload.mass = \"-80 g\": must lie in 0..=100 kg",
        ),
        (
            with("[effects.paylod]\nmass = \"80 g\""),
            "where.toml:4:10: effects.paylod: unknown key; did you mean `payload`?",
        ),
        (
            with("[rod]\nnodes = 3"),
            "where.toml:5:9: rod.nodes = 3: must lie in 4..=2000; 16 resolve the paper's muscle to 0.02 mm",
        ),
        (
            with("[rod]\nscheme = \"papr\""),
            "where.toml:5:10: rod.scheme = \"papr\": unknown; did you mean `paper`?; known here are consistent, paper",
        ),
        (
            with("[release]\nangle = \"400 deg\""),
            "where.toml:5:9: release.angle = \"400 deg\": must lie in -6.3..=6.3 rad (-361..=361 deg)",
        ),
        (with("[rod\n"), "where.toml:4:5: "),
        (
            ROD.replace("30 g", "0 g"),
            "where.toml:3:8: rod.mass = \"0 g\": must lie in 0.000000001..=10000 kg",
        ),
        (ROD.replace("mass", "#mass"), "where.toml:1:2: rod.mass: is missing; write mass = \"30 g\""),
        ("[run]\nrate = \"1 Hz\"".into(), "where.toml:1:1: rod.length: is missing; write length = "),
        (
            format!("{ROD}[effects.air_drag]\n"),
            "where.toml:6:1: effects.air_drag needs the diameter of the rod; give rod.diameter",
        ),
        (
            with("stiffness = \"pder\""),
            "where.toml:4:13: muscle.stiffness: garbulinski-2022 has no bending stiffness \"pder\"",
        ),
    ] {
        let message = error(&text, &[]);
        assert!(message.starts_with(expected), "expected {expected}\n   found {message}");
    }
    assert_eq!(
        error(MUSCLE, &["muscle.pressure=140 psi"]),
        "--set muscle.pressure=140 psi: muscle.pressure = 140 psi (965.266 kPa): outside the table of garbulinski-2022, \
         5 to 100 psi (34.474 to 689.476 kPa); choose a pressure inside, or set extrapolation = \"allowed\""
    );
    assert!(error(MUSCLE, &["effects.payload.mas=1 g"]).contains("did you mean `mass`?"));
    assert!(error(MUSCLE, &["effects"]).contains("write --set path=value"));
}

/// A key that is read and never used would leave model, run and goal as they are.
#[test]
fn every_number_of_a_scenario_changes_something() {
    let facts = |text: &str, set: &[&str]| {
        let Case { model, run, goal, rate, .. } = one(text, set);
        let own = (model.edges, model.tip_distance, model.scheme);
        format!("{:?} {own:?} {:?} {:?} {goal:?} {rate:?}", model.theta, run.initial, run)
    };
    let rod = format!("{ROD}diameter = \"10 mm\"\npressure = \"1 kPa\"\n[effects.creep]\n");
    let keys = [
        "rod.length=310 mm",
        "rod.mass=31 g",
        "rod.bending_stiffness=0.06 N m^2",
        "rod.axial_stiffness=900 N",
        "rod.diameter=11 mm",
        "rod.pressure=2 kPa",
        "rod.nodes=9",
        "rod.base_angle=3 deg",
        "rod.tip=4 mm",
        "release.angle=5 deg",
        "release.angular_velocity=0.1 rad/s",
        "release.history={ hung = \"9 s\", raised = \"1 s\", held = \"2 s\" }",
        "run.duration=7 s",
        "run.rate=50 Hz",
        "run.accuracy=2 mm",
        "integrator.tolerance=1e-5",
        "integrator.most_steps=77",
        "integrator.fixed_step=3 ms",
    ];
    let before = facts(&rod, &[]);
    for key in keys {
        assert_ne!(facts(&rod, &[key]), before, "{key}");
    }
    assert_ne!(facts(MUSCLE, &["muscle.pressure=16 psi"]), facts(MUSCLE, &[]));
}
