//! `efam diagnose` on a small experiment leaves a page that says what its files say.
//!
//! Goal: the way from a recording to `report.html`.
//! Setup: the release of the calibration's test, in a file whose name holds a tag; two candidates, so that it
//! takes seconds. What is found does not matter: the release comes from 16 nodes, and a diagnosis removes
//! the mesh.

use models::effects::CATALOGUE;

use crate::bench::{Bench, without_scripts};
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};

const RECORDING: &str = "15<b>psi.csv";
const ASKED: [&str; 2] = ["air_drag", "viscoelastic"];

#[test]
fn a_diagnosis_leaves_a_page_that_agrees_with_its_files() {
    let bench = Bench::new("diagnose");
    bench.file("truth.toml", &scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    bench.file(RECORDING, &recording(&simulated(&bench.text("truth/trajectory.csv"))));
    bench.file("e.toml", &EXPERIMENT.replace("15psi.csv", RECORDING));
    let mut arguments = vec!["diagnose", "e.toml", "--json", "--out", "out"];
    let names = CATALOGUE.iter().map(|effect| effect.about().name);
    arguments.extend(names.filter(|name| !ASKED.contains(name)).flat_map(|name| ["--without", name]));
    let value = bench.json(&arguments);
    let diagnosis = &value["diagnosis"];
    let page = bench.text("out/report.html");
    let holds = |text: &str| assert!(page.contains(text), "{text}");
    holds("<h1>Diagnosis of e</h1>");
    holds("15&lt;b&gt;psi.csv");
    let words = |key: &str| diagnosis[key].as_str().expect("words").replace('\'', "&#39;");
    holds(&format!("Verdict: {}", words("verdict").replace('_', " ")));
    words("summary").lines().for_each(holds);
    let warnings = diagnosis["warnings"].as_array().expect("a list");
    assert!(!warnings.is_empty(), "one release has warnings");
    warnings.iter().for_each(|warning| holds(warning.as_str().expect("words")));
    holds("rod.bending_stiffness is fitted: one value for each pressure");
    holds("--without gravity");
    holds(&efam_store::sha::sha256(bench.text(RECORDING).as_bytes()));
    for picture in ["gap", "features", "residual-01", "swing", "candidates-1"] {
        let svg = bench.picture(&format!("out/{picture}.svg"));
        // The page has it with a label for those who do not see it.
        holds(&svg);
    }
    // The repaired model is a scenario for what comes next, and says how well it is known.
    let asked = [
        "predict",
        "out/repaired-1.toml",
        "--payload",
        "20g",
        "--draws",
        "8",
        "--json",
        "--out",
        "predicted",
    ];
    let predicted = bench.json(&asked);
    assert_eq!(predicted["prediction"]["draws"], 8, "{predicted}");
    assert!(!without_scripts(&page).contains("<script") && !page.contains("<b>"));
}
