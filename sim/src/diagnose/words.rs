//! The answer in words.

use std::fmt::Write;

use super::localise::Shape;
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

/// What an experiment cannot tell, whatever the answer.
pub(super) fn warnings(problem: &Problem) -> Vec<String> {
    let fitted: Vec<_> = problem.trials.iter().filter(|trial| !trial.release.held_out).collect();
    let mut words = Vec::new();
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
    if fitted.iter().all(|trial| trial.release.tracks.len() < 2) {
        words.push(
            "one marker alone: effects that differ by where along the body they act can hardly be told apart"
                .to_owned(),
        );
    }
    words
}
