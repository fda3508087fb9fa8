//! A drawn experiment as files that pose the problem of [`super::problem`]: what `efam diagnose` makes of them.
//!
//! The file is written from the problem itself, number by number. What the cleaning masks is left out, and noise and instants are given, as
//! they are to a diagnosis in memory; half a second of the hold is seen besides, which a recording must
//! have.

use std::fmt::Write;

use efam_experiments::release::{Point, Release};
use efam_inference::calibrate::{FittedParameter, Problem, Scale, Scope};

use super::truth::Truth;
use crate::twin::AS_DRAWN;
use crate::twin::drawn::{Drawn, Plan};
use crate::twin::lab::millimetres;

/// How long the held rod is seen, s: short of the half second before the release that a diagnosis looks at.
const HOLD: f64 = 0.45;

/// The same plan with the hold that a recording must have.
pub fn with_hold(plan: Plan) -> Plan {
    Plan { hold: HOLD, ..plan }
}

/// The recordings of an experiment, each with its name.
pub fn recordings(problem: &Problem) -> Vec<(String, String)> {
    // To a thousandth of a hundredth of the noise.
    let text = |release: &Release| millimetres(release, 9, 6);
    problem.trials.iter().enumerate().map(|(k, trial)| (file_name(k), text(&trial.release))).collect()
}

/// The experiment file of a problem that was drawn. Nothing in it says what is hidden.
/// # Panics
/// If the models are not those of [`super::problem`].
pub fn experiment(name: &str, problem: &Problem, drawn: &Drawn) -> String {
    let model = &problem.trials[0].model;
    let value = |path: &str| model.value(path).expect("it is there");
    let mut text = format!(
        "# Drawn by blind_bench. What is hidden stands in truth.csv, which no diagnosis reads.\n\
         name = \"{name}\"\n\n[muscle]\nname = \"garbulinski-2022\"\n\n[rod]\nnodes = {}\n\n{AS_DRAWN}",
        model.edges + 1
    );
    for (effect, parameter, unit) in [("rayleigh_mass", "alpha", "1/s"), ("rayleigh_stiffness", "beta", "s")]
    {
        let value = value(&format!("effects.{effect}.{parameter}"));
        let _ = write!(text, "\n[effects.{effect}]\n{parameter} = \"{value:?} {unit}\"\n");
    }
    for (k, (trial, of)) in problem.trials.iter().zip(&drawn.releases).enumerate() {
        let Release { time, pressure, tracks, release_uncertainty, held_out, .. } = &trial.release;
        let (pressure, instant) = (pressure.unwrap_or_default(), -time[0]);
        let (base, angle) = (of.nominal.base_angle, of.nominal.release_angle);
        let body = tracks.iter().filter_map(|track| match track.at {
            Point::Tip => None,
            Point::Along(share) => Some(format!("{{ marker = \"{}\", at = {share:?} }}", track.marker)),
        });
        let body = body.collect::<Vec<_>>().join(", ");
        let _ = write!(
            text,
            "\n[[recording]]\nfile = \"{}\"\npressure = \"{pressure:?} Pa\"\ntip = \"tip\"\nbody = [{body}]\n\
             up = \"+z\"\nalong = \"+x\"\nbase_angle = \"{base:?} rad\"\nangle = \"{angle:?} rad\"\n\
             offset = \"none\"\ninstants = [\"{instant:.9} s\"]\ninstant_error = \"{release_uncertainty:?} s\"\n\
             noise = \"{:?} m\"\nspurious = \"keep\"\nheld_out = {held_out}\n",
            file_name(k),
            tracks[0].noise
        );
    }
    let deviation = |own: Option<f64>| own.unwrap_or(0.0);
    let nuisances = &problem.nuisances;
    let _ = write!(
        text,
        "\n[calibrate]\nrelease_instant = {}\nhold_angle = \"{:?} rad\"\noffset = \"{:?} m\"\n",
        nuisances.release_instant,
        deviation(nuisances.hold_angle),
        deviation(nuisances.offset)
    );
    problem.parameters.iter().for_each(|own| parameter(&mut text, own, problem));
    text
}

/// The file of a sweep over experiments with what is hidden in each: only effects that are removed from the
/// catalogue are named in it.
pub fn sweep(name: &str, all: &[(String, Truth)]) -> String {
    let mut text = format!("name = \"{name}\"\n\n[sweep]\nexperiments = [\"*/experiment.toml\"]\n");
    for (file, truth) in all.iter().filter(|(_, truth)| truth.case.is_robbed) {
        let without = truth.case.excluded();
        let _ = write!(text, "\n[[sweep.experiment]]\nfile = \"{file}\"\nwithout = {without:?}\n");
    }
    text
}

fn parameter(text: &mut String, own: &FittedParameter, problem: &Problem) {
    let mut known = problem.trials[0].model.parameters.iter();
    let unit = known.find(|known| known.path == own.path).map_or("", |known| known.unit);
    let scope = match own.scope {
        Scope::Shared => "shared",
        Scope::PerPressure => "per_pressure",
        Scope::PerRelease => "per_release",
    };
    let _ = write!(text, "\n[[calibrate.parameter]]\npath = \"{}\"\nscope = \"{scope}\"\n", own.path);
    let start = own.start.map(|start| ("start", start));
    let prior = own.prior.map(|prior| [("prior", prior.mean), ("deviation", prior.deviation)]);
    for (key, value) in start.into_iter().chain(prior.into_iter().flatten()) {
        let _ = writeln!(text, "{key} = \"{value:?} {unit}\"");
    }
    if let Some(scale) = own.scale {
        let word = if scale == Scale::Linear { "linear" } else { "logarithmic" };
        let _ = writeln!(text, "scale = \"{word}\"");
    }
}

fn file_name(trial: usize) -> String {
    format!("{}.csv", trial + 1)
}
