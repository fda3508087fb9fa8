//! What people type before they know the program, and what it says then.
//!
//! Goal: a frequent slip is answered with what was meant, and with the next move; what can be taken is taken.
//! Expected: the texts below; they are golden.

use serde_json::Value;

use crate::bench::Bench;

const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";
const SHORT: &str = "[run]\nduration = \"0.1 s\"\naccuracy = \"1 mm\"\n[rod]\nnodes = 8\n";
const EXPERIMENT: &str = "[muscle]\nname = \"garbulinski-2022\"\n[[recording]]\nfile = \"x.csv\"\ntip = \"Tip\"\n\
    pressure = \"15 psi\"\nup = \"+z\"\nalong = \"+x\"\nangle = \"0 deg\"\noffset = \"none\"\n";
const SWEEP: &str = "[sweep]\nscenario = \"s.toml\"\ndesign = \"grid\"\n[[sweep.parameter]]\n\
    path = \"muscle.pressure\"\nvalues = [\"10 psi\", \"20 psi\"]\n";

/// A hold and a fall in millimetres, 220 mm long.
fn millimetres() -> String {
    let mut text = String::from("t_s,Tip_x_m,Tip_y_m,Tip_z_m\n");
    for k in 0..300 {
        let t = 0.01 * f64::from(k);
        let after = (t - 1.0).max(0.0);
        let angle = -1.4 * (1.0 - (9.0 * after).cos() * (-after).exp());
        text += &format!("{t:.2},{:.4},0,{:.4}\n", 220.0 * angle.cos(), 220.0 * angle.sin());
    }
    text
}

/// A scenario, an experiment, a sweep, and a recording in millimetres.
fn bench(name: &str) -> Bench {
    let bench = Bench::new(name);
    bench.file("s.toml", &format!("{MUSCLE}{SHORT}"));
    bench.file("e.toml", EXPERIMENT);
    bench.file("sweep.toml", SWEEP);
    bench.file("x.csv", &millimetres());
    bench
}

/// The message of a command that must fail with a code, and leave nothing behind.
fn refused(bench: &Bench, code: i32, line: &str) -> String {
    let before = bench.left();
    let arguments: Vec<&str> = line.split(' ').collect();
    let (was, stdout, stderr) = bench.run(&arguments);
    assert_eq!((was, stdout.as_str()), (code, ""), "{line}: {stderr}");
    assert_eq!(bench.left(), before, "{line} leaves something behind");
    stderr
}

#[test]
fn millimetres_as_metres_are_doubted_wherever_a_length_is_read() {
    let bench = bench("typed-millimetres");
    let doubt = "1000 times too far: is the unit mm?";
    // The next move is in the message, and works.
    for command in ["experiment check", "analyse", "calibrate", "diagnose"] {
        let line = &format!("{command} e.toml --out out");
        let stderr = refused(&bench, 3, line);
        assert!(stderr.starts_with("error: x.csv: release 1: held straight, the tip stands 2"), "{stderr}");
        let next = format!("{doubt} Say recording[1].unit = \"mm\", or the unit that the numbers are in\n");
        assert!(stderr.ends_with(&next), "{line}: {stderr}");
    }
    let set = ["--set", "recording[1].unit=\"mm\""];
    bench.json(&[&["experiment", "check", "e.toml", "--json", "--out", "checked"], &set[..]].concat());
    // No angle, and so not held straight: the same.
    bench.file("bent.toml", &EXPERIMENT.replace("angle = \"0 deg\"\noffset = \"none\"\n", ""));
    let stderr = refused(&bench, 3, "experiment check bent.toml --out out");
    assert!(stderr.contains(doubt), "{stderr}");
    let inspected = bench.json(&["inspect", "x.csv", "--json"]);
    let findings = inspected["recordings"][0]["findings"].to_string();
    assert!(findings.contains(&format!("m along an axis: {doubt}")), "{findings}");
    let inspected = bench.json(&["inspect", "x.csv", "--unit", "mm", "--json"]);
    assert!(!inspected.to_string().contains(doubt), "{inspected}");
    let rod = "[rod]\nlength = \"80 m\"\nmass = \"24 g\"\nbending_stiffness = \"0.007 N m^2\"\n\
        axial_stiffness = \"100 N\"\nnodes = 8\n";
    bench.file("rod.toml", rod);
    let (_, _, stderr) = bench.run(&["statics", "rod.toml"]);
    assert!(stderr.contains(&format!("warning: the rod is 80 m long: {doubt}\n")), "{stderr}");
}

#[test]
fn a_file_of_another_kind_is_named_with_the_command_that_takes_it() {
    let bench = bench("typed-kinds");
    bench.file("laws.toml", "[laws.mine]\nplace = \"flow\"\nforce = \"-v_n\"\n");
    let recording =
        "`efam experiment init x.csv` writes an experiment from it, `efam inspect x.csv` summarises it";
    let simulates = "`efam simulate s.toml` takes it";
    let diagnoses = "`efam diagnose e.toml` takes it, as calibrate and analyse do; `efam predict` takes the rod.toml or muscle.toml \
                     that `efam calibrate e.toml` writes";
    let sweeps = "`efam sweep sweep.toml` takes it";
    for (line, code, is, then) in [
        ("diagnose x.csv", 2, "x.csv: is a recording, and an experiment is due", recording),
        ("calibrate x.csv", 2, "x.csv: is a recording, and an experiment is due", recording),
        ("simulate x.csv", 2, "x.csv: is a recording, and a scenario is due", recording),
        ("simulate e.toml", 2, "e.toml: is an experiment, and a scenario is due", diagnoses),
        ("modes e.toml", 2, "e.toml: is an experiment, and a scenario is due", diagnoses),
        ("predict e.toml", 2, "e.toml: is an experiment, and a scenario is due", diagnoses),
        ("simulate sweep.toml", 2, "sweep.toml: is a sweep, and a scenario is due", sweeps),
        ("diagnose s.toml", 2, "s.toml: is a scenario, and an experiment is due", simulates),
        ("diagnose --plan e.toml", 2, "e.toml: is an experiment, and a scenario is due", diagnoses),
        ("sweep s.toml", 2, "s.toml: is a scenario, and a sweep is due", simulates),
        ("sweep e.toml", 2, "e.toml: is an experiment, and a sweep is due", diagnoses),
        ("inspect s.toml", 3, "s.toml: is a scenario, and a recording is due", simulates),
        ("experiment init s.toml", 3, "s.toml: is a scenario, and a recording is due", simulates),
        (
            "simulate laws.toml",
            2,
            "laws.toml: is a file of laws, and a scenario is due",
            "`efam effects --check laws.toml` takes it",
        ),
    ] {
        assert_eq!(refused(&bench, code, line), format!("error: {is}; {then}\n"), "{line}");
    }
    // A scenario that is wrong is no other kind of file.
    bench.file("wrong.toml", &format!("{MUSCLE}[runn]\n"));
    let stderr = refused(&bench, 2, "simulate wrong.toml");
    assert!(stderr.contains("runn: unknown key; did you mean `run`?"), "{stderr}");
}

#[test]
fn a_key_without_its_first_tables_is_known_by_its_end() {
    let bench = bench("typed-keys");
    for (set, meant) in [
        ("payload.mass=80g", "payload: unknown key; did you mean `effects.payload.mass`?"),
        ("duration=2s", "duration: unknown key; did you mean `run.duration`?"),
        ("rayleigh_mass.alpha=1Hz", "did you mean `effects.rayleigh_mass.alpha`?"),
    ] {
        let stderr = refused(&bench, 2, &format!("simulate s.toml --set {set}"));
        assert!(stderr.contains(meant), "{stderr}");
    }
    bench.file("own.toml", &format!("{MUSCLE}[payload]\nmass = \"80 g\"\n"));
    let stderr = refused(&bench, 2, "simulate own.toml");
    assert!(
        stderr.starts_with("error: own.toml:4:2: payload: unknown key; did you mean `effects.payload.mass`?")
    );
}

#[test]
fn a_word_of_several_effects_offers_them_all() {
    let bench = bench("typed-effects");
    let stderr = refused(&bench, 2, "effects drag");
    let due = "error: no effect `drag`; did you mean `air_drag`, `tip_drag` or `linear_drag`?; there are ";
    assert!(stderr.starts_with(due), "{stderr}");
}

#[test]
fn zero_needs_no_unit() {
    let bench = bench("typed-zero");
    bench.file("s.toml", &format!("{MUSCLE}{SHORT}[effects.rayleigh_mass]\nalpha = 0\n"));
    let alpha = |arguments: &[&str]| {
        let all = [&["simulate", "s.toml", "--json", "--overwrite", "--out", "out"], arguments].concat();
        bench.json(&all)["runs"][0]["parameters"]["effects.rayleigh_mass.alpha"].clone()
    };
    assert_eq!(alpha(&[]), alpha(&["--set", "effects.rayleigh_mass.alpha=\"0 1/s\""]));
    assert_eq!(alpha(&["--angle", "0", "--payload", "0"]), alpha(&[]));
    let stderr = refused(&bench, 2, "simulate s.toml --set effects.rayleigh_mass.alpha=1");
    assert!(stderr.contains("1: needs a unit of frequency or rate"), "{stderr}");
}

#[test]
fn predict_without_a_rod_says_how_to_name_one() {
    let bench = bench("typed-predict");
    for line in ["predict", "predict --payload 80g"] {
        let stderr = refused(&bench, 2, line);
        assert!(stderr.contains("--muscle muscle.toml --pressure 40psi"), "{stderr}");
        assert!(stderr.contains("garbulinski-2022"), "{stderr}");
    }
}

#[test]
fn shorthands_are_the_keys_and_are_not_given_twice() {
    let bench = bench("typed-shorthands");
    let run = |arguments: &[&str]| {
        let json = ["--json", "--overwrite", "--out", "out"];
        let mut runs = bench.json(&[&["simulate", "s.toml"], arguments, &json].concat());
        let run = runs["runs"][0].take();
        [&run["simulated_s"], &run["rest"], &run["peaks"]].map(Value::clone)
    };
    let short = run(&["--payload", "80g", "--duration", "0.2s", "--angle", "20deg"]);
    let sets = ["effects.payload.mass=80g", "run.duration=0.2s", "release.angle=20deg"];
    assert_eq!(short, run(&sets.iter().flat_map(|set| ["--set", *set]).collect::<Vec<_>>()));
    assert_eq!(short[0], 0.2);
    let tip = |line: &[&str]| bench.json(line)["statics"][0]["tip_z_m"].clone();
    assert_eq!(
        tip(&["statics", "s.toml", "--payload", "80g", "--json"]),
        tip(&["statics", "s.toml", "--set", "effects.payload.mass=80g", "--json"])
    );
    for (line, due) in [
        (
            "simulate s.toml --payload 80g --set effects.payload.mass=50g",
            "--payload 80g and --set effects.payload.mass=50g both give effects.payload.mass",
        ),
        (
            "simulate s.toml --duration 5s --set run.duration=4s",
            "--duration 5s and --set run.duration=4s both give run.duration",
        ),
        (
            "simulate s.toml --angle 20deg --set release.angle=1deg",
            "--angle 20deg and --set release.angle=1deg both give release.angle",
        ),
        (
            "simulate s.toml --pressure 20psi --set muscle.pressure=10psi",
            "--pressure 20psi and --set muscle.pressure=10psi both give muscle.pressure",
        ),
        (
            "modes s.toml --payload 80g --set effects.payload.mass=50g",
            "--payload 80g and --set effects.payload.mass=50g both give effects.payload.mass",
        ),
        (
            "predict --muscle garbulinski-2022 --pressure 15psi --payload 8g --set effects.payload.mass=5g",
            "--payload 8g and --set effects.payload.mass=5g both give effects.payload.mass",
        ),
    ] {
        assert_eq!(refused(&bench, 2, line), format!("error: {due}; keep one of them\n"), "{line}");
    }
}
