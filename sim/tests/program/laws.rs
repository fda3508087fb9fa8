//! A law as text in an experiment: it is fitted, is a candidate, and is kept with the results.
//!
//! Goal: `--law` makes an effect of a file one like any other. Setup: a release of the paper's muscle at 15 psi with a drag
//! that is text, simulated by the program; noise of 0.05 mm; fitted on the same mesh. Expected: its coefficient within five
//! standard errors and 5 %; the diagnosis of a model without it scores it; a message gives the place of what is wrong with a file.

use crate::bench::Bench;
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};

const LAW: &str = "[laws.my_drag]\nplace = \"flow\"\nforce = \"-c * v_n * abs(v_n) * diameter\"\n\
    parameters.c = { unit = \"kg/m^3\", default = 0.6, range = [0, 50], plausible = [0, 20] }\n";
const C: f64 = 6.0;

fn bench() -> Bench {
    let bench = Bench::new("laws");
    bench.file("truth.toml", &format!("{}[effects.my_drag]\nc = \"{C} kg/m^3\"\n{LAW}", scenario()));
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    bench.file("15psi.csv", &recording(&simulated(&bench.text("truth/trajectory.csv"))));
    bench.file("law.toml", LAW);
    bench
}

#[test]
fn a_law_of_a_file_is_fitted_scored_and_kept() {
    let bench = bench();
    let fitted = EXPERIMENT.replace("[[recording]]", "[effects.my_drag]\nc = \"2 kg/m^3\"\n[[recording]]");
    let parameters = [
        ("rod.bending_stiffness", "per_pressure"),
        ("effects.rayleigh_mass.alpha", "shared"),
        ("effects.rayleigh_stiffness.beta", "shared"),
        ("effects.my_drag.c", "shared"),
    ]
    .map(|(path, scope)| format!("[[calibrate.parameter]]\npath = \"{path}\"\nscope = \"{scope}\"\n"));
    bench.file("fitted.toml", &format!("{fitted}{}", parameters.concat()));
    let value = bench.json(&["calibrate", "fitted.toml", "--law", "law.toml", "--json", "--out", "fitted"]);
    let rows = value["calibration"]["parameters"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["name"] == "effects.my_drag.c").expect("it is fitted");
    let [found, error] = ["value", "standard_error"].map(|key| row[key].as_f64().expect("a number"));
    assert!((found - C).abs() < (5.0 * error).min(0.05 * C), "{found} ± {error}");
    let kept = bench.text("fitted/experiment.toml");
    assert!(kept.contains("[laws.my_drag]") && kept.contains("-c * v_n"), "{kept}");

    bench.file("lacking.toml", EXPERIMENT);
    let arguments =
        ["diagnose", "lacking.toml", "--law", "law.toml", "--most", "1", "--json", "--out", "found"];
    let value = bench.json(&arguments);
    let round = &value["diagnosis"]["rounds"][0];
    let fitted = round["candidates"].as_array().expect("rows").iter().map(|own| &own["name"]);
    let mut all = fitted.chain(round["others"].as_array().expect("names"));
    assert!(all.any(|name| name == "my_drag"), "{round:?}");
}

#[test]
fn what_is_wrong_with_a_file_of_laws_is_said_at_its_place() {
    let bench = Bench::new("laws-wrong");
    bench.file("15psi.csv", "t_s,Tip_x_m,Tip_y_m,Tip_z_m\n");
    bench.file("e.toml", EXPERIMENT);
    bench.file("law.toml", &LAW.replace("abs(v_n)", "abs(v_m)"));
    bench.file("twice.toml", LAW);
    for (arguments, message) in [
        (&["calibrate", "e.toml", "--law", "law.toml"][..], "law.toml:3:25"),
        (&["diagnose", "e.toml", "--law", "none.toml"][..], "none.toml: cannot be read"),
        (&["diagnose", "e.toml", "--law", "twice.toml", "--law", "twice.toml"][..], "laws.my_drag"),
        (&["effects", "--check", "e.toml"][..], "unknown key; known here is laws"),
        (&["effects", "--rust", "law.toml"][..], "law.toml:3:25"),
    ] {
        let (code, _, said) = bench.run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {said}");
        assert!(said.contains(message), "{arguments:?}: {said}");
    }
    let feeds = LAW.replace("\"-c", "\"c");
    bench.file("feeds.toml", &feeds);
    let (code, printed, _) = bench.run(&["effects", "--check", "feeds.toml"]);
    assert_eq!(code, 1, "{printed}");
    assert!(printed.contains("FAILS  never feeds energy: laws.my_drag: it feeds"), "{printed}");
}

/// What `--check` prints of a test.
fn line<'a>(printed: &'a str, test: &str) -> &'a str {
    printed.lines().find(|line| line.contains(test)).unwrap_or_else(|| panic!("{test}: {printed}"))
}

#[test]
fn what_a_law_may_do_is_not_held_against_it() {
    let bench = Bench::new("laws-check");
    let shaker = "[laws.motor]\nplace = \"tip\"\nkind = \"load\"\nforce_x = \"f * sin(2*pi*frequency*time)\"\n\
        parameters.f = { unit = \"N\", default = 0.02, range = [-1, 1] }\n\
        parameters.frequency = { unit = \"Hz\", default = 1, range = [0, 50] }\n";
    let wind = "[laws.wind]\nplace = \"flow\"\nkind = \"load\"\n\
        force = \"0.5 * rho * diameter * (u*sin(2*pi*f*time) - v_n) * abs(u*sin(2*pi*f*time) - v_n)\"\n\
        parameters.u = { unit = \"m/s\", default = 1, range = [0, 30] }\n\
        parameters.f = { unit = \"Hz\", default = 0.5, range = [0, 30] }\n\
        parameters.rho = { unit = \"kg/m^3\", default = 1.2, range = [0, 30] }\n";
    let late = "[laws.step]\nplace = \"tip\"\nforce_x = \"f * max(0, sign(time - t0))\"\n\
        parameters.f = { unit = \"N\", default = 0.02, range = [-1, 1] }\n\
        parameters.t0 = { unit = \"s\", default = 40, range = [0, 50] }\n";
    let brake = "[laws.brake]\nplace = \"tip\"\nforce_x = \"-b * v_x * max(0, -z - z0)\"\n\
        force_z = \"-b * v_z * max(0, -z - z0)\"\n\
        parameters.b = { unit = \"N s/m^2\", default = 0.5, range = [0, 100] }\n\
        parameters.z0 = { unit = \"m\", default = 0.1, range = [0, 1] }\n";
    for (law, test, due) in [
        (shaker, "never feeds energy", "not tested: a load acts from outside"),
        (wind, "never feeds energy", "not tested: a load acts from outside"),
        (late, "off is exactly off, and on is on", "holds"),
        (late, "at off the sensitivity is not zero", "holds"),
        (brake, "the same in every direction", "not tested: it is not the same when the clamp is turned"),
        (brake, "never feeds energy", "holds"),
        (LAW, "the same in every direction", "holds"),
        (LAW, "the force at rest is the gradient", "not tested: the flow acts from outside"),
    ] {
        bench.file("law.toml", law);
        let (code, printed, said) = bench.run(&["effects", "--check", "law.toml"]);
        assert_eq!(code, 0, "{printed}{said}");
        assert!(line(&printed, test).contains(due), "{printed}");
        let checked = bench.json(&["effects", "--check", "law.toml", "--json"]);
        let tests = checked["laws"][0]["tests"].as_array().expect("tests");
        let own = tests.iter().find(|own| own["test"].as_str().is_some_and(|name| name.starts_with(test)));
        assert_eq!(own.expect("it is printed")["not_tested"].is_null(), due == "holds", "{checked}");
    }
    // What feeds energy from a time on that is a parameter.
    let fed = LAW.replace("\"-c *", "\"max(0, sign(time - begin)) * c *");
    bench.file(
        "fed.toml",
        &format!("{fed}parameters.begin = {{ unit = \"s\", default = 30, range = [0, 50] }}\n"),
    );
    let (code, printed, _) = bench.run(&["effects", "--check", "fed.toml"]);
    assert_eq!(code, 1, "{printed}");
    assert!(line(&printed, "never feeds energy").contains("W to the rod at 30.3 s"), "{printed}");
}

#[test]
fn a_law_of_a_file_is_simulated_as_one_of_the_scenario() {
    let bench = Bench::new("laws-simulate");
    let scenario = format!("{}[effects.my_drag]\nc = \"{C} kg/m^3\"\n", scenario());
    bench.file("inside.toml", &format!("{scenario}{LAW}"));
    bench.file("beside.toml", &scenario);
    bench.file("law.toml", LAW);
    for command in [&["simulate", "--no-files"][..], &["statics"], &["modes"]] {
        let of = |file: &str, more: &[&str]| {
            let (name, rest) = command.split_first().expect("a command");
            let value = bench.json(&[&[*name, file, "--json"], rest, more].concat());
            match value.get("runs") {
                Some(runs) => ["rest", "damped_frequency_hz", "damping_ratio", "effort", "errors"]
                    .map(|key| runs[0][key].to_string())
                    .join(" "),
                None => value.to_string().replace("beside", "inside"),
            }
        };
        let [inside, beside] = [of("inside.toml", &[]), of("beside.toml", &["--law", "law.toml"])];
        assert_eq!(inside, beside, "{command:?}");
    }
    let (code, _, said) = bench.run(&["simulate", "inside.toml", "--law", "law.toml", "--no-files"]);
    assert!(code == 2 && said.contains("another file has one of this name"), "{said}");
    bench.json(&["simulate", "beside.toml", "--law", "law.toml", "--json", "--out", "kept"]);
    let kept = bench.text("kept/scenario.resolved.toml");
    assert!(kept.contains("[laws.my_drag]") && kept.contains("-c * v_n"), "{kept}");
    let hashes = bench.text("kept/summary.json");
    assert!(hashes.contains("\"law.toml\""), "{hashes}");
}

#[test]
fn a_law_with_very_many_parameters_is_refused_at_once() {
    let bench = Bench::new("laws-many");
    let many: String = (0..100_000)
        .map(|k| format!("parameters.c{k} = {{ unit = \"kg/m^3\", default = 0.6, range = [0, 10] }}\n"))
        .collect();
    bench.file(
        "law.toml",
        &format!("[laws.my]\nplace = \"flow\"\nforce = \"-c0 * v_n * abs(v_n) * diameter\"\n{many}"),
    );
    let (code, _, said) = bench.run(&["effects", "--check", "law.toml"]);
    assert!(code == 2 && said.contains("100000 parameters; a law has at most 8"), "{said}");
}
