//! What an experiment file says, and what is said of a wrong one.

use std::path::Path;

use super::*;

const RECORDING: &str = "[[recording]]\nfile = \"15psi.csv\"\ntip = \"Tip\"\n";
const ROD: &str = "[rod]\nlength = \"100 mm\"\nmass = \"96.3 g\"\nbending_stiffness = \"0.02 N m^2\"\n\
                   axial_stiffness = \"200 N\"\n";

fn load(text: &str, overrides: &[&str]) -> Result<Experiment, ExperimentError> {
    let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Experiment::parse(Path::new("some/where.toml"), text, &overrides)
}

fn error(text: &str, overrides: &[&str]) -> String {
    match load(text, overrides) {
        Ok(_) => panic!("nothing is refused"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn every_key_is_read() {
    let text = "name = \"beam\"\n[[recording]]\nfile = \"a/15psi.csv\"\npressure = \"15 psi\"\n\
        payload = { mass = \"80 g\", center_of_mass = \"1 in\", offset = \"-4 mm\" }\ntip = [\"T1\", \"T2\"]\n\
        body = [{ marker = \"M\", at = \"50 mm\" }, { marker = \"N\", at = 0.7 }]\nbase = \"Base\"\n\
        unit = \"mm\"\nrate = \"100 Hz\"\nup = \"+x\"\nalong = [0, 0, 2]\nclamp = [\"1 mm\", \"0 m\", \"0 m\"]\n\
        base_angle = \"5 deg\"\nangle = \"10 deg\"\noffset = [\"0 mm\", \"22 mm\"]\ninstants = [\"0.71 s\", \"3 s\"]\ninstant_error = \"2 ms\"\nkeep = [1]\n\
        held_out = [2]\nnoise = \"0.1 mm\"\nspurious = \"keep\"\nmask = [[\"1 s\", \"2 s\"]]\nnote = \"warm\"\n\
        [[recording.release]]\nnumber = 2\nangle = \"20 deg\"\n[calibrate]\nparameters = [\"x\"]\n";
    let experiment = load(text, &[]).unwrap();
    assert_eq!((experiment.name.as_str(), experiment.has_model()), ("beam", false));
    let entry = &experiment.recordings[0];
    assert_eq!(entry.file, Path::new("some/a/15psi.csv"));
    assert_eq!((entry.name.as_str(), entry.key.as_str()), ("15psi.csv", "recording[1]"));
    assert_eq!(
        entry.payload,
        Payload { mass: 0.08, center_of_mass: 0.0254, offset: -0.004, rotary_inertia: 0.0, is_given: true }
    );
    assert_eq!(entry.body[0].at, At::Length(0.05));
    assert_eq!(entry.body[1].at, At::Share(0.7));
    assert_eq!((entry.tip.len(), entry.base.as_slice()), (2, &["Base".to_owned()][..]));
    assert_eq!(entry.up, Some(Direction::Axis(0, 1.0)));
    assert_eq!(entry.along, Some(Direction::Vector([0.0, 0.0, 1.0])));
    assert_eq!(entry.offset, Some(Offset::Given([0.0, 0.022])));
    assert_eq!((entry.instant_of(2), entry.instant_of(3)), (Some(3.0), None));
    assert_eq!(entry.instant_error, Some(0.002));
    assert_eq!(entry.base_angle, Some(5f64.to_radians()));
    assert_eq!(entry.angle_of(1), Some(10f64.to_radians()));
    assert_eq!(entry.angle_of(2), Some(20f64.to_radians()));
    assert!(entry.is_held_out(2) && !entry.is_held_out(1) && !entry.find_spurious);
    assert!(experiment.section("calibrate").unwrap().is_given());
    assert!(experiment.case(0, None).unwrap().is_none());
}

#[test]
fn a_rod_without_an_angle_is_held_bent() {
    let starts = |more: &str| {
        let experiment = load(&format!("{RECORDING}{more}"), &[]).unwrap();
        [1, 2].map(|number| experiment.recordings[0].start_of(number))
    };
    assert_eq!(starts(""), [Start::Held, Start::Held]);
    assert_eq!(starts("angle = \"0 deg\"\n"), [Start::Straight, Start::Straight]);
    assert_eq!(starts("start = \"straight\"\n"), [Start::Straight, Start::Straight]);
    let second = "[[recording.release]]\nnumber = 2\nangle = \"5 deg\"\n";
    assert_eq!(starts(second), [Start::Held, Start::Straight]);
    for start in ["held", "in motion"] {
        for more in ["angle = \"0 deg\"\n", second] {
            let said = error(&format!("{RECORDING}start = \"{start}\"\n{more}"), &[]);
            assert!(said.contains("recording[1].start") && said.contains("has no angle"), "{said}");
        }
    }
    assert_eq!(starts("start = \"in motion\"\n"), [Start::InMotion; 2]);
    let said = error(&format!("{RECORDING}start = \"in motion\"\ninstants = [\"1 s\", \"2 s\"]\n"), &[]);
    assert!(said.contains("have one instant at most"), "{said}");
}

#[test]
fn a_model_is_that_of_a_scenario_with_the_recordings_own_pressure_and_payload() {
    let text = format!(
        "[muscle]\nname = \"garbulinski-2022\"\n{}pressure = \"15 psi\"\n{}pressure = \"40 psi\"\npayload = \"80 g\"\n",
        RECORDING, RECORDING
    );
    let experiment = load(&text, &["recording[1].pressure=20 psi"]).unwrap();
    let at = |k: usize, path: &str| {
        let model = experiment.case(k, Some(0.2)).unwrap().unwrap().model;
        model.value(path).unwrap()
    };
    let scenario = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"20 psi\"\n";
    let scenario = crate::scenario::Scenario::parse(Path::new("s.toml"), scenario, &[]).unwrap();
    assert_eq!(
        experiment.case(0, Some(0.0)).unwrap().unwrap().model.theta,
        scenario.cases().unwrap()[0].model.theta
    );
    assert_eq!((at(0, "effects.payload.mass"), at(1, "effects.payload.mass")), (0.0, 0.08));
    assert_eq!(at(1, "release.angle"), 0.2);
    let rod = load(&format!("{ROD}{RECORDING}"), &[]).unwrap();
    assert_eq!(rod.case(0, None).unwrap().unwrap().model.rod().length, 0.1);
    let two = format!("{ROD}base_angle = \"3 deg\"\n{RECORDING}{RECORDING}base_angle = \"-20 deg\"\n");
    let turned = load(&two, &[]).unwrap();
    let clamp = |k: usize| {
        let model = turned.case(k, None).unwrap().unwrap().model;
        model.value("rod.base_angle").unwrap()
    };
    assert_eq!([clamp(0), clamp(1)], [3f64, -20.0].map(f64::to_radians));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let with = |line: &str| format!("{RECORDING}{line}\n");
    for (text, expected) in [
        (
            with("presure = 1"),
            "some/where.toml:4:1: recording[1].presure: unknown key; did you mean `pressure`?",
        ),
        (
            with("pressure = \"3 mm\""),
            "some/where.toml:4:12: recording[1].pressure: \"3 mm\" is a length, but a pressure is due",
        ),
        (
            with("clamp = [\"1 mm\", \"2 mm\"]"),
            "some/where.toml:4:9: recording[1].clamp = [\"1 mm\", \"2 mm\"]: must have three numbers",
        ),
        (with("up = \"+w\""), "some/where.toml:4:6: recording[1].up = \"+w\": unknown"),
        (
            with("instant_error = \"1 ms\""),
            "some/where.toml:4:17: recording[1].instant_error = \"1 ms\": belongs to instants that are given",
        ),
        (with("keep = [0]"), "some/where.toml:4:8: recording[1].keep = [0]: must count releases from 1"),
        (with("held_out = 1"), "some/where.toml:4:12: recording[1].held_out = 1: true or false is due"),
        (
            with("mask = [[\"2 s\", \"1 s\"]]"),
            "some/where.toml:4:8: recording[1].mask = [[\"2 s\", \"1 s\"]]: must have in each row",
        ),
        (
            with("body = [{ marker = \"M\", at = \"5 kg\" }]"),
            "some/where.toml:4:30: recording[1].body[1].at: \"5 kg\" is a mass, but a length is due",
        ),
        (
            with("body = [{ marker = \"M\", at = 1.5 }]"),
            "some/where.toml:4:30: recording[1].body[1].at = 1.5: must be a length, or lie in 0..=1",
        ),
        (
            with("[effects.payload]\nmass = \"1 g\""),
            "rod: is missing; write [rod] or [muscle], for [effects]",
        ),
        ("[[recording]]\ntip = \"T\"\n".to_owned(), "recording[1].file: is missing; write file ="),
        ("[[recording]]\nfile = \"a.csv\"\n".to_owned(), "recording[1].tip: is missing; write tip ="),
        (String::new(), "some/where.toml: recording: is missing; write [[recording]]"),
        (
            "recording = 3\n".to_owned(),
            "some/where.toml:1:13: recording = 3: a list of tables is due; write [[recording]]",
        ),
        (
            format!("[muscle]\nname = \"garbulinski-2022\"\n{RECORDING}"),
            "recording[1].pressure: is missing; write pressure = \"15 psi\", which the muscle needs",
        ),
        (
            format!("[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n{RECORDING}"),
            "some/where.toml:3:12: muscle.pressure = \"15 psi\": each [[recording]] has its own pressure; move it there",
        ),
    ] {
        let message = error(&text, &[]);
        assert!(message.contains(expected), "expected {expected}\n   found {message}");
    }
    let message = error(RECORDING, &["recording[2].pressure=15 psi"]);
    assert!(message.ends_with("there is no recording[2]; members count from one"), "{message}");
    let message = match load(RECORDING, &[]).unwrap().read(0) {
        Ok(_) => panic!("there is no such file"),
        Err(error) => error.to_string(),
    };
    assert!(
        message.starts_with("some/where.toml:2:8: recording[1].file: some/15psi.csv: cannot be read"),
        "{message}"
    );
    let range = load(&format!("{}{RECORDING}", ROD.replace("96.3 g", "0 g")), &[]).unwrap().case(0, None);
    let message = range.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.starts_with("some/where.toml:3:8: rod.mass = \"0 g\": must lie in"), "{message}");
}
