//! Every kind of page in a browser: what it shows, and that it keeps to itself.
//!
//! Goal: a page that renders at 1200 and 400 pixels, light and dark, with no message on the console, no request
//! that leaves the machine, no text over other text, nothing wider than the window, and enough contrast.
//! Setup: small runs of each command; headless Chromium behind a proxy that is not there, so that nothing leaves,
//! with a log of requests. One frame makes a request, to show that it would be noted. The pages as they
//! are forbid all scripts but their own, so texts are measured in copies without that policy, in frames of the widths. Where no Chromium is there the test says so and passes;
//! `EFAM_BROWSER` names another.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use models::effects::CATALOGUE;
use serde_json::Value;

use crate::bench::{Bench, skipped};
use crate::calibrate::{EXPERIMENT, recording, scenario, simulated};

const WIDTHS: [u32; 2] = [1200, 400];
/// A grid, of which one pressure is refused.
const SWEEP: &str = "[sweep]\nscenario = \"release.toml\"\ndesign = \"grid\"\n\
    [[sweep.parameter]]\npath = \"muscle.pressure\"\nvalues = [\"15 psi\", \"40 psi\", \"400 psi\"]\n\
    [[sweep.parameter]]\npath = \"effects.payload.mass\"\nrange = [\"0 g\", \"80 g\"]\nsteps = 3\n";
/// Candidates of the diagnosis, so that it takes seconds.
const ASKED: [&str; 2] = ["air_drag", "viscoelastic"];
/// Least contrast of text, as the Web Content Accessibility Guidelines (2.2, 1.4.3) require it.
const LEAST_CONTRAST: f64 = 4.5;
/// Requested by one frame of the test itself; nobody has this name (RFC 2606).
const CANARY: &str = "http://canary.invalid/";
const POLICY_START: &str = "<meta http-equiv=\"Content-Security-Policy\"";

fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("EFAM_BROWSER") {
        return Some(PathBuf::from(named));
    }
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let path = std::env::var_os("PATH")?;
    let found = std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name)));
    let found = found.into_iter().find(|file| file.is_file());
    if found.is_none() {
        skipped("browser", "no Chromium is there to look at the pages with");
    }
    found
}

/// A page of each kind, by the folder that it lies in.
fn pages(bench: &Bench) -> Vec<&'static str> {
    bench.file("release.toml", &scenario());
    bench.file(
        "rows.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"all rows\"\n[rod]\nnodes = 12\n[run]\nduration = \"4 s\"\n\
         [effects.rayleigh_mass]\nalpha = \"1 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"4 ms\"\n",
    );
    bench.json(&["simulate", "release.toml", "--csv", "--json", "--out", "run"]);
    bench.file("15psi.csv", &recording(&simulated(&bench.text("run/trajectory.csv"))));
    bench.file("e.toml", EXPERIMENT);
    let short = ["simulate", "release.toml", "--json", "--set", "run.duration=\"0.1 s\"", "--out", "short"];
    bench.json(&short);
    bench.json(&["simulate", "rows.toml", "--json", "--out", "rows"]);
    bench.json(&["experiment", "check", "e.toml", "--json", "--out", "check"]);
    bench.json(&["analyse", "e.toml", "--json", "--out", "analysis"]);
    bench.json(&["calibrate", "e.toml", "--json", "--out", "calibration"]);
    let mut arguments = vec!["diagnose", "e.toml", "--json", "--out", "diagnosis"];
    let names = CATALOGUE.iter().map(|effect| effect.about().name);
    arguments.extend(names.filter(|name| !ASKED.contains(name)).flat_map(|name| ["--without", name]));
    bench.json(&arguments);
    let predict = [
        "predict",
        "--muscle",
        "calibration/muscle.toml",
        "--pressure",
        "15psi",
        "--duration",
        "4 s",
        "--json",
    ];
    bench.json(&[&predict[..], &["--draws", "8", "--out", "prediction"]].concat());
    let several = ["--pressure", "15psi,20psi", "--payload", "0g..80g:3", "--out", "grid"];
    bench.json(&[&predict[..3], &predict[5..], &several].concat());
    bench.file("sweep.toml", SWEEP);
    bench.json(&["sweep", "sweep.toml", "--json", "--csv", "--out", "sweep"]);
    bench.json(&["report", "run", "short", "calibration", "diagnosis", "--json", "--out", "report"]);
    bench.json(&["figures", "--json", "--set", "run.duration=\"5 s\"", "--out", "figures"]);
    let simulated = ["run", "short", "rows"];
    let measured = ["check", "analysis", "calibration", "diagnosis"];
    [&simulated[..], &measured, &["prediction", "grid", "sweep", "report", "figures"]].concat()
}

/// Copies without the policy that measure themselves, and a page that frames all of them and all as they are.
fn framed(bench: &Bench, pages: &[&str]) -> String {
    let mut frames = String::new();
    for page in pages {
        let text = bench.text(&format!("{page}/report.html"));
        let (head, policy) = text.split_once(POLICY_START).expect("a page has a policy");
        let rest = policy.split_once('>').expect("a tag ends").1;
        let script = format!("<script>{}</script></body>", include_str!("browser.js"));
        let copy = format!("{head}{}", rest.replace("</body>", &script));
        bench.file(&format!("{page}/measured.html"), &copy);
        for width in WIDTHS {
            frames += &format!(
                "<iframe src=\"{page}/measured.html#{page}-{width}\" width=\"{width}\" height=\"900\"></iframe>\n"
            );
        }
        frames += &format!("<iframe src=\"{page}/report.html\" width=\"800\" height=\"900\"></iframe>\n");
    }
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><pre id=\"found\"></pre><script>addEventListener('message', \
         said => document.getElementById('found').append(JSON.stringify(said.data) + '\\n'))</script>\n{frames}<iframe srcdoc=\"<img src='{CANARY}'>\"></iframe>"
    )
}

/// By what the browser's log of the network identifies a request's owner: a hash of the owner's name.
/// Source: Chromium, tools/traffic_annotation, `ComputeHashValue`.
fn asker(name: &str) -> u32 {
    name.bytes().fold(0, |hash, letter| (hash * 31 + u32::from(letter)) % 138_003_713)
}

/// Addresses that pages have requested, not the browser on its own account.
fn asked(log: &str) -> BTreeSet<String> {
    let askers = ["blink_resource_loader", "navigation_url_loader"].map(asker);
    let event = |line: &str| {
        let event: Value = serde_json::from_str(line.trim().trim_end_matches(',')).ok()?;
        let params = &event["params"];
        let by_page = askers.iter().any(|asker| params["traffic_annotation"] == *asker);
        let address = params["url"].as_str().filter(|address| address.starts_with("http"))?;
        by_page.then(|| address.to_owned())
    };
    log.lines().filter_map(event).collect()
}

/// What each copy says of itself, one JSON object a line; and the console's content.
fn looked(browser: &Path, bench: &Bench, scheme: u8) -> (Vec<Value>, Vec<String>, BTreeSet<String>) {
    let profile = bench.0.join(format!("profile-{scheme}"));
    let log = bench.0.join(format!("network-{scheme}.json"));
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=60000", "--dump-dom"])
        .arg("--window-size=1300,1000")
        .arg("--proxy-server=http://127.0.0.1:9")
        .arg(format!("--log-net-log={}", log.display()))
        .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", bench.0.join("all.html").display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&output.stdout);
    let found = dom.split_once("<pre id=\"found\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let found = found.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&output.stderr))).0;
    let plain = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let values = plain.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let stderr = String::from_utf8_lossy(&output.stderr);
    let console = stderr.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
    let log = fs::read_to_string(log).expect("the browser keeps its log");
    (values, console, asked(&log))
}

/// As a person uses them, with their policy: see `interactive.mjs`.
fn used(browser: &Path, bench: &Bench) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/interactive.mjs");
    match Command::new("node").arg(script).arg(browser).arg(&bench.0).output() {
        Err(_) => skipped("node", "Node is not there, which drives Chromium: nobody used the pages"),
        Ok(output) => {
            let said =
                [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
            assert!(output.status.success(), "{}\n{}", said[0], said[1]);
        }
    }
}

#[test]
#[ignore = "long, and needs Chromium; .ci/run runs it"]
fn every_page_can_be_read_and_keeps_to_itself() {
    let Some(browser) = browser() else { return };
    let bench = Bench::new("browser");
    let pages = pages(&bench);
    bench.file("all.html", &framed(&bench, &pages));
    let mut papers = Vec::new();
    // Blink's numbers: dark 0, light 1.
    for scheme in [1, 0] {
        let (found, console, asked) = looked(&browser, &bench, scheme);
        assert!(console.is_empty(), "{console:#?}");
        assert_eq!(found.len(), WIDTHS.len() * pages.len(), "each copy has measured itself: {found:?}");
        for page in &found {
            let name = page["name"].as_str().expect("a name");
            let nothing = |key: &str| {
                let list = page[key].as_array().unwrap_or_else(|| panic!("{key} of {page}"));
                assert!(list.is_empty(), "{name}, {key}: {list:#?}");
            };
            ["overlaps", "cut", "resources", "dead_links", "unreachable"].into_iter().for_each(nothing);
            assert!(page["texts"].as_u64() > Some(50), "{name} has text: {page}");
            assert!(page["too_wide"] == 0, "{name} is wider than its window by {} pixels", page["too_wide"]);
            let contrast = page["contrast"].as_f64().expect("a number");
            assert!(contrast >= LEAST_CONTRAST, "{name}: contrast {contrast} of {}", page["faintest"]);
        }
        assert_eq!(asked, BTreeSet::from([CANARY.to_owned()]), "requests that would leave the machine");
        papers.push(found[0]["paper"].clone());
    }
    assert_ne!(papers[0], papers[1], "light and dark differ");
    used(&browser, &bench);
    let _ = fs::remove_dir_all(&bench.0);
}
