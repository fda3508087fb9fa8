//! What should be known before an answer is used: what the experiment cannot determine, and what the fit had to assume.

use efam_core::work::written;
use efam_experiments::out_of_plane;
use models::effects::Kind;

use super::Found;
use super::section::LEAST_NOISE;
use super::verdict::{CutBy, CutShort, Diagnosis, Verdict};
use crate::calibrate::Problem;

/// Periods that a release should be seen for: damping is read off cycles.
const LEAST_PERIODS: f64 = 3.0;
/// Samples in a cycle below which turns are known badly: the quadratic through three of them is off by a per cent.
const LEAST_SAMPLES: f64 = 10.0;

/// All that concern a diagnosis, its problem, and what was found.
pub(super) fn warnings(diagnosis: &Diagnosis, problem: &Problem, found: &Found) -> Vec<String> {
    let mut words: Vec<String> = several(diagnosis).into_iter().collect();
    words.extend(cut_short(diagnosis));
    let shown = |place: &usize| found.places.contains(place);
    let all = problem.trials.iter().enumerate();
    words.extend(
        all.filter(|(place, _)| !shown(place))
            .map(|(_, trial)| format!("{}: shows no swing, and takes no part", trial.release.name)),
    );
    words.extend(of_experiment(problem));
    words.extend(of_recordings(found));
    words
}

/// What should be known of an answer of several names.
fn several(diagnosis: &Diagnosis) -> Option<String> {
    let is_named = matches!(diagnosis.verdict, Verdict::Named | Verdict::Incomplete | Verdict::Class);
    (is_named && diagnosis.effects.len() > 1).then(|| {
        "several effects together can stand in for one outside the catalogue: confirm them with another recording, with markers on the body".to_owned()
    })
}

/// What should be known of a search that was cut short.
fn cut_short(diagnosis: &Diagnosis) -> Option<String> {
    let CutShort { round, by } = diagnosis.cut_short.as_ref()?;
    let reason = match by {
        CutBy::Budget => format!("its budget of {} node steps", written(diagnosis.budget)),
        CutBy::Interruption => {
            "a time limit or an interruption, so another machine may give another answer".to_owned()
        }
    };
    let what = match round {
        Some(round) => {
            format!("the search was cut short in round {round} by {reason}: the answer is not final")
        }
        None => format!(
            "the answer was cut short by {reason}: no recording that separates the candidates was looked for"
        ),
    };
    Some(format!("{what}; give a larger --budget, or leave out candidates with --without"))
}

/// Effects that are part of every diagnosis, and no choice of an experiment.
const STANDING: [&str; 3] = ["gravity", "rayleigh_mass", "rayleigh_stiffness"];

/// Candidates that are none because the experiment's model has them.
fn had(problem: &Problem) -> Vec<&'static str> {
    let all = problem.trials.first().map(|trial| trial.model.catalogue.clone()).unwrap_or_default();
    let causes = all.iter().map(|effect| effect.about()).filter(|about| about.kind != Kind::Description);
    let could =
        causes.filter(|about| about.parameters.iter().any(|parameter| parameter.null_value.is_some()));
    could.map(|about| about.name).filter(|name| !STANDING.contains(name) && problem.has(name)).collect()
}

/// What an experiment cannot determine, whatever the answer.
fn of_experiment(problem: &Problem) -> Vec<String> {
    let fitted: Vec<_> = problem.trials.iter().filter(|trial| !trial.release.held_out).collect();
    let mut words = Vec::new();
    let had = had(problem);
    if !had.is_empty() {
        words.push(format!(
            "{}: already in the model, so no candidate; its values are fixed unless [calibrate] names its parameters",
            had.join(", ")
        ));
    }
    if fitted.len() == problem.trials.len() {
        words.push("no release is held out: the answer is not validated; record one more, or set held_out = true for one".to_owned());
    }
    if problem.fitted_pressures().len() < 2 {
        words.push(
            "one pressure only: effects that differ in their growth with pressure cannot be separated"
                .to_owned(),
        );
    }
    if fitted.len() < 2 {
        words.push(
            "one release only: changes between releases cannot be separated from constant effects".to_owned(),
        );
    }
    if fitted.iter().flat_map(|trial| &trial.release.tracks).any(|track| track.noise <= LEAST_NOISE) {
        words.push(format!(
            "a recording has less noise than a fit can resolve: {} mm is used; to allow for a larger error of the model, set noise in its [[recording]]",
            1e3 * LEAST_NOISE
        ));
    }
    words.extend(out_of_plane::warning(problem.trials().map(|trial| &trial.release)));
    if fitted.iter().all(|trial| trial.release.tracks.len() < 2) {
        words.push(
            "one marker only: effects that act at different places along the body are hard to separate"
                .to_owned(),
        );
    }
    words
}

/// What recordings say badly.
fn of_recordings(found: &Found) -> Vec<String> {
    let plans = &found.data.plans;
    let mut words = Vec::new();
    let seen =
        |plan: &crate::features::Plan| plan.frequency * (plan.time[plan.samples.len() - 1] - plan.time[0]);
    let longest = plans.iter().map(seen).fold(0.0, f64::max);
    if longest < LEAST_PERIODS {
        words.push(format!(
            "no release is longer than {longest:.1} periods: damping and slow changes are poorly determined; record until the swing has died away"
        ));
    }
    if plans.iter().any(|plan| plan.frequency * (plan.time[1] - plan.time[0]) > LEAST_SAMPLES.recip()) {
        words.push("fewer than ten samples in a cycle: turns are known badly".to_owned());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::verdict::Added;

    #[test]
    fn an_answer_of_several_names_is_warned_of() {
        let added = |name: &str| Added { effect: name.to_owned(), parameters: Vec::new() };
        let answer = |verdict, names: &[&str]| Diagnosis {
            verdict,
            effects: names.iter().map(|name| added(name)).collect(),
            ..Diagnosis::default()
        };
        let two = ["air_drag", "creep"];
        assert!(several(&answer(Verdict::Named, &two)).is_some_and(|text| text.contains("stand in for one")));
        assert_eq!(several(&answer(Verdict::Named, &two[..1])), None);
        assert_eq!(several(&answer(Verdict::Unknown, &two)), None);
    }

    #[test]
    fn a_search_that_was_cut_short_says_by_what() {
        let of = |round: Option<usize>, by: CutBy| {
            let diagnosis = Diagnosis {
                cut_short: Some(CutShort { round, by }),
                budget: 2_500_000,
                ..Diagnosis::default()
            };
            cut_short(&diagnosis).unwrap()
        };
        let one = of(Some(1), CutBy::Budget);
        assert!(
            one.contains("in round 1 by its budget of 2.50e6 node steps: the answer is not final"),
            "{one}"
        );
        let answer = of(None, CutBy::Interruption);
        assert!(answer.contains("another machine may give another answer") && !answer.contains("not final"));
        assert_eq!(cut_short(&Diagnosis::default()), None);
    }
}
