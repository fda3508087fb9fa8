//! Energies that do not close, laws that are wrong, and models that come to no end.
//!
//! Goal: each of them ends with what is to blame, or warns.
//! Setup: scenarios that were once simulated without a word, or for ever.
//! Expected: the message names the law or the effect, where it was, and the next move.

use crate::bench::Bench;

const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";
const DAMPING: &str = "[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n";

/// A drag as text, with `force` as its formula.
fn drag(force: &str) -> String {
    format!(
        "{MUSCLE}[run]\nduration = \"1 s\"\n{DAMPING}[effects.my]\n[laws.my]\nplace = \"flow\"\nforce = \"{force}\"\n\
         parameters.c = {{ unit = \"kg/m^3\", default = 0.6, range = [0, 10] }}\n"
    )
}

/// Exit code and what was said, its lines joined.
fn said(bench: &Bench, text: &str, more: &[&str]) -> (i32, String) {
    bench.file("s.toml", text);
    let (code, _, stderr) = bench.run(&[&["simulate", "s.toml", "--no-files"], more].concat());
    (code, stderr.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn a_law_that_feeds_energy_is_named() {
    let bench = Bench::new("energies-fed");
    let (code, wrong) = said(&bench, &drag("c * v_n * abs(v_n) * diameter"), &[]);
    assert!(code == 0 && wrong.contains("laws.my feeds energy to the rod"), "{wrong}");
    let (code, right) = said(&bench, &drag("-c * v_n * abs(v_n) * diameter"), &[]);
    assert!(code == 0 && !right.contains("feeds energy"), "{right}");
    // What acts from outside may.
    let load = drag("c * v_n * abs(v_n) * diameter").replace("[laws.my]", "[laws.my]\nkind = \"load\"");
    let (code, load) = said(&bench, &load, &[]);
    assert!(code == 0 && !load.contains("laws.my feeds"), "{load}");
}

#[test]
fn a_law_that_gives_no_number_is_named_with_what_it_saw() {
    let bench = Bench::new("energies-nan");
    let at_once = drag("-c * v_n * abs(v_n) * diameter * log(-1)");
    let (code, message) = said(&bench, &at_once, &[]);
    assert_eq!(code, 4, "{message}");
    for part in
        ["laws.my.force is not a finite number at edge 1 of", "t = 0.0000 s", "v_n = 0 m/s", "c = 0.6 kg/m^3"]
    {
        assert!(message.contains(part), "{part}: {message}");
    }
    // In the middle of the motion.
    let later = drag("-c * v_n * abs(v_n) * diameter * sqrt(1 - time / end)");
    let later = format!("{later}parameters.end = {{ unit = \"s\", default = 0.05, range = [0.01, 1] }}\n");
    let (code, message) = said(&bench, &later, &[]);
    assert_eq!(code, 4, "{message}");
    for part in ["laws.my.force", "at edge", "t = 0.0500 s", "time = 50", "end = 50 ms"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    // Where the rest is looked for.
    bench.file("s.toml", &at_once);
    let (code, _, rest) = bench.run(&["statics", "s.toml"]);
    let rest = rest.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        code == 4 && rest.contains("no equilibrium found: laws.my.force is not a finite number"),
        "{rest}"
    );
}

/// A moment of unknown cause that grows with the curvature beyond all bounds: a legal model, whose steps shrink for ever.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn steps_that_become_too_short_end_the_run_with_the_effect() {
    let bench = Bench::new("energies-stiff");
    let text = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"5 psi\"\n[release]\nangular_velocity = \"-6.68 rad/s\"\n\
        [run]\nduration = \"1 s\"\nrate = \"100 Hz\"\naccuracy = \"0.16308 mm\"\n\
        [effects.rayleigh_mass]\nalpha = \"3 1/s\"\n[effects.rayleigh_stiffness]\nbeta = \"0.001 s\"\n\
        [effects.latent_moment]\nconstant = \"0.0251161 1/m\"\nsquare = \"-0.0025453 m\"\ncube = \"-0.00265686 m^2\"\n\
        square_rate = \"-0.000133311 m^2 s\"\n[effects.strain_rate_cubed]\ncoefficient = \"2.58155e-07 m^2 s^3\"\n";
    let (code, message) = said(&bench, text, &[]);
    assert_eq!(code, 4, "{message}");
    for part in ["the steps become too short", "where the force of effects.", "raise integrator.most_steps"] {
        assert!(message.contains(part), "{part}: {message}");
    }
}

/// About a rest, elastic and potential energy change by a hundred times the energy of the motion, and cancel: the budget
/// counts against the latter.
#[test]
fn the_energy_of_a_small_motion_closes_or_a_warning_says_by_how_much_not() {
    let bench = Bench::new("energies-small");
    let small = format!(
        "{MUSCLE}[release]\nfrom = \"equilibrium\"\n[release.hold.effects.payload]\nmass = \"1 g\"\n\
         [run]\nduration = \"5 s\"\naccuracy = \"50 mm\"\n{DAMPING}"
    );
    let (code, coarse) = said(&bench, &small, &["--set", "integrator.tolerance=1e-3"]);
    assert!(code == 0 && coarse.contains("the energy fails to close by"), "{coarse}");
    let (code, chosen) = said(&bench, &small, &[]);
    assert!(code == 0 && !chosen.contains("the energy fails to close by"), "{chosen}");
}

#[test]
fn a_step_that_leads_nowhere_is_refused_at_once() {
    let bench = Bench::new("energies-step");
    let text = format!("{MUSCLE}{DAMPING}[integrator]\nfixed_step = \"1e-12 s\"\n");
    let (code, message) = said(&bench, &text, &[]);
    assert_eq!(code, 2, "{message}");
    for part in ["integrator.fixed_step", "takes 2.0e13 steps for 20 s", "give 2 µs or more"] {
        assert!(message.contains(part), "{part}: {message}");
    }
}

/// A rate at which there is one sample is printed as a number that can be read.
#[test]
fn a_very_small_rate_is_printed_short() {
    let bench = Bench::new("energies-rate");
    let text = format!("{MUSCLE}[run]\nduration = \"1 s\"\nrate = \"1e-300 Hz\"\n{DAMPING}");
    let (code, message) = said(&bench, &text, &[]);
    assert!(code == 0 && message.contains("samples at 1.00e-300 Hz"), "{message}");
    assert!(!message.contains("0000000000"), "{message}");
}
