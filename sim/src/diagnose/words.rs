//! The answer in words.

use super::verdict::{Diagnosis, Verdict};
use crate::calibrate::Problem;

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
            format!("{} is missing, or what does the same to these recordings: {}.", names(), others.join(", "))
        }
        Verdict::Unknown => "Something is missing that the catalogue does not hold.".to_owned(),
    }
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
