//! `efam diagnose` on a small experiment leaves a page that says what its files say.
//!
//! Goal: the way from a recording to `report.html`.
//! Setup: the release of the calibration's test, which lacks nothing, with a name that would be a tag; two
//! candidates, so that it takes seconds.

use models::effects::CATALOGUE;

use crate::bench::Bench;
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};

const ASKED: [&str; 2] = ["air_drag", "viscoelastic"];

#[test]
fn a_diagnosis_leaves_a_page_that_agrees_with_its_files() {
    let bench = Bench::new("diagnose");
    bench.file("truth.toml", &scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    bench.file("15psi.csv", &recording(&simulated(&bench.text("truth/trajectory.csv"))));
    bench.file("e.toml", &format!("name = \"a <b> & c\"\n{EXPERIMENT}"));
    let mut arguments = vec!["diagnose", "e.toml", "--json", "--out", "out"];
    let names = CATALOGUE.iter().map(|effect| effect.about().name);
    arguments.extend(names.filter(|name| !ASKED.contains(name)).flat_map(|name| ["--without", name]));
    let value = bench.json(&arguments);
    let diagnosis = &value["diagnosis"];
    assert_eq!(diagnosis["verdict"], "nothing_missing", "{diagnosis}");
    let page = bench.text("out/report.html");
    let holds = |text: &str| assert!(page.contains(text), "{text}");
    holds("<h1>Diagnosis of a &lt;b&gt; &amp; c</h1>");
    holds("Verdict: nothing missing");
    holds(diagnosis["summary"].as_str().expect("words"));
    let warnings = diagnosis["warnings"].as_array().expect("a list");
    assert!(!warnings.is_empty(), "one release has warnings");
    warnings.iter().for_each(|warning| holds(warning.as_str().expect("words")));
    holds("rod.bending_stiffness is fitted: one value for each pressure");
    holds("--without gravity");
    holds(&sim::results::sha256(bench.text("15psi.csv").as_bytes()));
    for picture in ["gap", "residual-01", "swing", "shapes", "candidates-1"] {
        let svg = bench.text(&format!("out/{picture}.svg"));
        // The page has it with a label for those who do not see it.
        holds(svg.trim().split_once(' ').expect("an element").1);
    }
    assert!(!page.contains("<script") && !page.contains("<b>"));
}
