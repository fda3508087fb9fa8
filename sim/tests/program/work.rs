//! Work of each kind, small, for tests that disturb it.

use crate::bench::Bench;
use crate::calibrate::{recording, simulated};

/// A command that writes results, and what it leaves where `--out` says.
pub struct Work {
    /// What the user types, without `--out`.
    pub arguments: &'static [&'static str],
    /// Ending of the file that it writes; nothing where that is a folder.
    pub ending: &'static str,
    /// Whether its folder appears at once. That of a sweep is filled shard by shard.
    pub at_once: bool,
}

const fn folder(arguments: &'static [&'static str]) -> Work {
    Work { arguments, ending: "", at_once: true }
}

pub const WORK: [Work; 11] = [
    folder(&["simulate", "s.toml", "--csv"]),
    folder(&["calibrate", "e.toml"]),
    folder(&["diagnose", "e.toml"]),
    folder(&[
        "predict",
        "--muscle",
        "known.toml",
        "--pressure",
        "40 psi",
        "--duration",
        "2 s",
        "--draws",
        "20",
    ]),
    Work {
        arguments: &["sweep", "sweep.toml", "--points-per-shard", "2", "--csv"],
        ending: "",
        at_once: false,
    },
    Work { arguments: &["export", "run", "--to", "mat"], ending: ".mat", at_once: true },
    Work { arguments: &["export", "run", "--to", "mcap"], ending: ".mcap", at_once: true },
    folder(&["analyse", "e.toml"]),
    folder(&["report", "run", "run"]),
    folder(&["linearise", "s.toml", "--reduce", "4", "--sample", "10ms"]),
    Work { arguments: &["experiment", "init", "15psi.csv"], ending: ".toml", at_once: true },
];

const SWEEP: &str = "[sweep]\nscenario = \"s.toml\"\ndesign = \"latin_hypercube\"\npoints = 8\nseed = 3\n\
    [[sweep.parameter]]\npath = \"muscle.pressure\"\nrange = [\"10 psi\", \"90 psi\"]\n";
const SCENARIO: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
    [run]\nduration = \"1 s\"\naccuracy = \"1 mm\"\n[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n\
    [effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n";
const CALIBRATION: &str = "\n[calibration]\nreleases = 1\npressure_pa = [275790.3, 275790.3]\npayload_kg = [0.0, 0.0]\n\
    excursion_m = 0.2\n[[calibration.parameter]]\npath = \"rod.bending_stiffness\"\n\
    pressure_pa = 275790.3\nvalue = 0.00801\nstandard_error = 8.01e-5\ncorrelations = [1.0]\n";

/// A bench on which all of [`WORK`] can be done.
pub fn bench(name: &str) -> Bench {
    let bench = Bench::new(name);
    bench.file("s.toml", SCENARIO);
    bench.file("sweep.toml", SWEEP);
    let muscle = include_str!("../../../models/muscles/garbulinski-2022.toml");
    bench.file("known.toml", &format!("{muscle}{CALIBRATION}"));
    bench.file("truth.toml", &crate::calibrate::scenario());
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "run"]);
    bench.file("15psi.csv", &recording(&simulated(&bench.text("run/trajectory.csv"))));
    bench.file("e.toml", crate::calibrate::EXPERIMENT);
    bench
}
