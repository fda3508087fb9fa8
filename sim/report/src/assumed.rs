//! What is taken to be so and was not measured, in plain words.

use efam_experiments::summary::Summary;
use efam_inference::calibrate::{FittedParameter, Problem, Scope, Trial};
use models::effects::{CATALOGUE, Kind};

use crate::report::short;
use crate::report::significant;

/// What a simulation takes for granted.
pub fn of_run(summary: &Summary) -> Vec<String> {
    let settings = &summary.settings;
    let mut words = vec![
        "The rod moves in one plane, and its clamp does not give way unless an effect below says so.".to_owned(),
        match settings.scheme.as_str() {
            "paper" => "Scheme: the paper's, with curvature 2 tan(φ/2) and a whole Voronoi length at the clamp. An EI fitted with it belongs to it and to this number of nodes.",
            _ => "Scheme: consistent; it converges to the continuous rod with the fourth power of the edge length. An EI fitted with the paper's scheme belongs to that.",
        }
        .to_owned(),
    ];
    let acts = |name: &str| settings.effects.iter().any(|effect| effect == name);
    let given = |path: &str| {
        let own = summary.parameters.get(path)?;
        Some(format!("{path} = {} {}", short(own.value), own.unit).trim_end().to_owned())
    };
    let losses: Vec<String> = ["effects.rayleigh_mass.alpha", "effects.rayleigh_stiffness.beta"]
        .into_iter()
        .filter(|path| summary.parameters.get(*path).is_some_and(|own| own.value != 0.0))
        .filter_map(given)
        .collect();
    if !losses.is_empty() {
        words.push(format!("Damping is as the scenario or the muscle file has it: {}.", losses.join(", ")));
    }
    let absent: Vec<&str> = (CATALOGUE.iter().map(|effect| effect.about()))
        .filter(|about| !acts(about.name) && about.kind != Kind::Description)
        .map(|about| about.name)
        .collect();
    words.push(format!("Effects that act: {}.", settings.effects.join(", ")));
    if !absent.is_empty() {
        words.push(format!("Effects of the catalogue that are taken to be absent: {}.", absent.join(", ")));
    }
    words
}

/// What a fit holds fixed, and what it fits beside the requested parameters.
pub fn of_problem(problem: &Problem) -> Vec<String> {
    let unit = |path: &str| {
        let model = &problem.trials.first()?.model;
        Some(model.parameters[model.index(path).ok()?].unit)
    };
    let fitted = |parameter: &FittedParameter| {
        let scope = match parameter.scope {
            Scope::Shared => "one value for all releases",
            Scope::PerPressure => "one value for each pressure",
            Scope::PerRelease => "one value for each release",
        };
        let believed = parameter.prior.map_or(String::new(), |prior| {
            let (mean, deviation) = (significant(prior.mean, 4), significant(prior.deviation, 2));
            let unit = unit(&parameter.path).unwrap_or_default();
            format!(", believed to be {mean} ± {deviation} {unit}").trim_end().to_owned()
        });
        format!("{} is fitted: {scope}{believed}", parameter.path)
    };
    let mut words: Vec<String> = problem.parameters.iter().map(fitted).collect();
    let nuisances = &problem.nuisances;
    if nuisances.release_instant {
        words.push("the instant of each release is fitted within its error".to_owned());
    }
    if problem.trials().any(Trial::is_held) {
        words.push(
            "where no angle is given, a hand holds the rod bent: its force and moment, and how fast they change, are fitted"
                .to_owned(),
        );
    }
    let is_straight = problem.trials().any(Trial::is_straight);
    if let Some(angle) = nuisances.hold_angle.filter(|_| is_straight) {
        words.push(format!(
            "the angle at which each release is held is fitted, to {} degrees",
            significant(angle.to_degrees(), 2)
        ));
    }
    if let Some(angle) = nuisances.clamp_angle {
        words.push(format!(
            "the angle of the clamp is fitted, to {} degrees",
            significant(angle.to_degrees(), 2)
        ));
    }
    if let Some(offset) = nuisances.offset {
        words.push(format!("the place of each marker is fitted, to {} mm", significant(1e3 * offset, 2)));
    }
    if nuisances.farthest.is_finite() {
        words.push(format!("none of these is more than {} standard deviations off", nuisances.farthest));
    }
    words.push("everything else is as experiment.toml says".to_owned());
    words
}
