//! The answer in words.

use std::fmt::Write;

use models::effects::CATALOGUE;

use super::localise::Shape;
use super::section::{LEAST_NOISE, TILT};
use super::verdict::{Diagnosis, Verdict};
use crate::calibrate::Problem;
use crate::calibrate::joint::Known;
use crate::results::report::significant;

/// One paragraph for a person.
pub(super) fn summary(diagnosis: &Diagnosis) -> String {
    let names =
        || diagnosis.effects.iter().map(|added| added.effect.as_str()).collect::<Vec<_>>().join(" and ");
    match diagnosis.verdict {
        Verdict::NothingMissing => {
            "Nothing is missing that these recordings could show: no effect of the catalogue lowers the gap by more than noise does.".to_owned()
        }
        Verdict::Named => format!("{} is missing.", names()),
        Verdict::Class => {
            let others: Vec<_> = diagnosis.members.iter().map(|member| member.effect.as_str()).collect();
            let mut words =
                format!("{} is missing, or what does the same to these recordings: {}.", names(), others.join(", "));
            if let Some(separation) = &diagnosis.separating_experiment {
                let _ = write!(
                    words,
                    " To tell them apart, record {}: that takes the distance of the nearest two from {:.1} to {:.1} standard deviations.",
                    separation.what, separation.distance_now, separation.distance
                );
            }
            words
        }
        Verdict::Unknown => {
            let mut words = "Something is missing that the catalogue does not hold.".to_owned();
            if !diagnosis.effects.is_empty() {
                let _ = write!(words, " {} describes a part of it, and need not be its cause.", names());
            }
            if let Some(shape) = loudest(diagnosis) {
                let _ = write!(
                    words,
                    " What is left looks like this: {}, by {:.2} mm at the tip, mostly at {:.0} % of the largest amplitude.",
                    shape.what,
                    shape.size_mm,
                    100.0 * shape.at_amplitude
                );
            }
            words
        }
    }
}

/// The shape that stands out most in the last round, if one does.
fn loudest(diagnosis: &Diagnosis) -> Option<&Shape> {
    let last = diagnosis.shapes.iter().map(|shape| shape.round).max()?;
    let own = diagnosis.shapes.iter().filter(|shape| shape.round == last && shape.score > shape.threshold);
    own.max_by(|a, b| a.score.total_cmp(&b.score))
}

/// Standard deviations by which a nuisance may be off what was believed of it.
const BELIEVABLE: f64 = 4.0;

/// What a fit had to assume of the setup against what was believed.
pub(super) fn strained(known: &[Known]) -> Vec<String> {
    let of = |known: &Known| {
        let prior = known.unknown.prior?;
        let off = (known.value() - prior.mean) / prior.deviation;
        (off.abs() > BELIEVABLE).then(|| {
            format!(
                "{} = {} {} is {:.0} standard deviations off what was believed of it: check the setup",
                known.unknown.name,
                significant(known.value(), 3),
                known.unknown.unit,
                off.abs()
            )
        })
    };
    known.iter().filter_map(of).collect()
}

/// Effects that are part of every diagnosis, and no choice of an experiment.
const STANDING: [&str; 4] = ["gravity", "rayleigh_mass", "rayleigh_stiffness", TILT];

/// Candidates that are none because the experiment's model has them.
fn had(problem: &Problem) -> Vec<&'static str> {
    let names = CATALOGUE.iter().map(|effect| effect.about());
    let could = names.filter(|about| about.parameters.iter().any(|parameter| parameter.off.is_some()));
    let has = |name: &str| problem.trials.iter().any(|trial| trial.model.effect(name).is_some());
    could.map(|about| about.name).filter(|name| !STANDING.contains(name) && has(name)).collect()
}

/// A release that is seen for less than that, s, says little of how a swing dies away.
const SHORT: f64 = 2.0;

/// What an experiment cannot tell, whatever the answer.
pub(super) fn warnings(problem: &Problem) -> Vec<String> {
    let fitted: Vec<_> = problem.trials.iter().filter(|trial| !trial.release.held_out).collect();
    let mut words = Vec::new();
    let had = had(problem);
    if !had.is_empty() {
        words.push(format!(
            "{}: in the model already, so not looked for; it stays as it is unless [calibrate] names its parameters",
            had.join(", ")
        ));
    }
    if fitted.len() == problem.trials.len() {
        words.push("nothing is locked away: no release judges the answer that did not make it; record one more, or say held_out = true of one".to_owned());
    }
    if problem.fitted_pressures().len() < 2 {
        words.push(
            "one pressure alone: effects that differ by how they grow with the pressure cannot be told apart"
                .to_owned(),
        );
    }
    if fitted.len() < 2 {
        words.push("one release alone: what changes from release to release cannot be told from what is always there".to_owned());
    }
    if fitted.iter().flat_map(|trial| &trial.release.tracks).any(|track| track.noise <= LEAST_NOISE) {
        words.push(format!(
            "a recording has less noise than a fit can follow: {} mm is taken; where the model is believed to less, say so by noise in its [[recording]]",
            1e3 * LEAST_NOISE
        ));
    }
    let longest = fitted.iter().filter_map(|trial| trial.release.time.last()).fold(0.0, |a, b| b.max(a));
    if longest < SHORT {
        words.push(format!(
            "no release is seen for longer than {longest:.1} s: damping, and what changes slowly or only in small swings, can hardly be told; record until the swing has died away"
        ));
    }
    if fitted.iter().all(|trial| trial.release.tracks.len() < 2) {
        words.push(
            "one marker alone: effects that differ by where along the body they act can hardly be told apart"
                .to_owned(),
        );
    }
    words
}
