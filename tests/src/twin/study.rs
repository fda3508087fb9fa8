//! What twin studies share: true damping, a problem for the calibration, and how far off it lands.

use std::path::Path;
use std::sync::Arc;

use efam_core::forward::Run;
use efam_experiments::experiment::Experiment;
use efam_experiments::release::Release;
use efam_inference::calibrate::{
    Calibration, CalibrationSettings, FittedParameter, Nuisances, Problem, Scope, Trial, calibrate,
};

use super::beam::Beam;
use super::muscle;
use super::random::Random;
use super::session::{Session, six_cycles};
use crate::{PSI, paper};

/// The parameters that are studied: EI, alpha, beta.
pub const PATHS: [&str; 3] =
    ["rod.bending_stiffness", "effects.rayleigh_mass.alpha", "effects.rayleigh_stiffness.beta"];
/// Nodes of the model that is fitted: what a user has who changes nothing.
const NODES: usize = 32;
/// Elements and step of the twin, for paths within 0.002 to 0.01 mm of the continuum.
const ELEMENTS: usize = 12;
const STEP: f64 = 5e-3;

/// A twin whose damping grows with pressure as the paper's does: fast up to 30 psi, then slowly. The
/// sizes are plausible, not measured.
pub fn damped_muscle(psi: f64) -> Beam {
    let rise = 1.0 - (-(psi - 5.0) / 25.0).exp();
    muscle(psi, ELEMENTS, 0.4 + 0.4 * rise, 0.005 + 0.015 * rise)
}

/// Six cycles of it, let go within half a degree of the horizontal or so.
pub fn session(psi: f64, swing: f64, random: &mut Random) -> Session {
    let cycles = six_cycles(random, swing, 0.8f64.to_radians());
    Session::play(&damped_muscle(psi), &cycles, STEP)
}

/// What a laboratory writes of a recording in which markers of the tip are called `tip…` and those of the base `base…`.
/// # Panics
/// If that is no experiment.
pub fn experiment<'a>(psi: f64, markers: impl Iterator<Item = &'a str> + Clone) -> Experiment {
    let named = |beginning: &str| {
        let names = markers.clone().filter(|name| name.starts_with(beginning));
        names.map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
    };
    let text = format!(
        "[muscle]\nname = \"garbulinski-2022\"\n[[recording]]\nfile = \"twin.csv\"\n\
         pressure = \"{psi} psi\"\ntip = [{}]\nbase = [{}]\n",
        named("tip"),
        named("base")
    );
    Experiment::parse(Path::new("twin.toml"), &text, &[]).expect("an experiment")
}

/// EI, alpha and beta of a twin.
pub fn truth(beam: &Beam) -> [f64; 3] {
    [beam.bending_stiffness, beam.alpha, beam.beta]
}

/// Calibrates EI, alpha and beta, shared by all releases, from `start`.
/// # Panics
/// If the calibration refuses the problem.
pub fn fit(psi: f64, releases: Vec<Release>, start: [f64; 3]) -> Calibration {
    let model = paper(psi, NODES, &[]);
    let trial = |release: Release| Trial {
        release: Release { pressure: Some(psi * PSI), ..release },
        model: model.clone(),
        run: Run::release(1.0, 100.0),
    };
    let parameter = |(path, start): (&str, f64)| FittedParameter {
        start: Some(start),
        ..FittedParameter::new(path, Scope::Shared)
    };
    let problem = Problem {
        trials: releases.into_iter().map(trial).map(Arc::new).collect(),
        parameters: PATHS.into_iter().zip(start).map(parameter).collect(),
        nuisances: Nuisances::default(),
    };
    calibrate(&problem, &CalibrationSettings::default(), &|_: &str| ())
        .expect("a problem that makes sense")
        .calibration
}

/// An estimate beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landed {
    /// Estimate over truth, minus one.
    pub off: f64,
    /// Standard error over truth, infinite where there is none.
    pub error: f64,
    /// Whether the 95 % interval holds the truth.
    pub covered: bool,
}

/// How far off each of [`PATHS`] landed.
pub fn landed(found: &Calibration, truth: [f64; 3]) -> [Landed; 3] {
    [0, 1, 2].map(|k| {
        let found = found.of(PATHS[k])[0];
        let covered = found.interval_95.is_some_and(|[low, high]| low <= truth[k] && truth[k] <= high);
        Landed {
            off: found.value / truth[k] - 1.0,
            error: found.standard_error.map_or(f64::INFINITY, |error| error / truth[k]),
            covered,
        }
    })
}

/// Whether the data determine a parameter to 5 %: three standard errors lie within. With two, one
/// sound fit in twenty at the edge would fail; the recording at 15 psi in `inverse/chain.rs` is such a
/// case, with beta 5.4 ± 2.5 % off.
pub fn is_determined(landed: &Landed) -> bool {
    3.0 * landed.error < 0.05
}

/// One line of a table: each off ± error, in per cent.
pub fn line(landed: &[Landed; 3]) -> String {
    landed.map(|l| format!("{:+7.3} ± {:.3} %", 100.0 * l.off, 100.0 * l.error)).join("  ")
}
