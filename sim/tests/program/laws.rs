//! A law as text in an experiment: it is fitted, is a candidate, and is kept with the results.
//!
//! Goal: `--law` makes an effect of a file one like any other. Setup: a release of the paper's muscle at 15 psi with a drag
//! that is text, simulated by the program; noise of 0.05 mm; fitted on the same mesh. Expected: its coefficient within five
//! standard errors and 5 %; the diagnosis of a model without it scores it; what is wrong with a file stands at its place.

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
    let rows = value["diagnosis"]["evidence"].as_array().expect("rows");
    assert!(rows.iter().any(|row| row["effect"] == "my_drag"), "{rows:?}");
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
