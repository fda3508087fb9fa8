//! What should be known before an answer is used: what the experiment cannot tell, and what the fit had to assume.

use efam_experiments::out_of_plane;
use models::effects::Kind;

use super::mesh_check;
use super::refit::prefix;
use super::section::{LEAST_NOISE, TILT};
use super::stop;
use super::verdict::{Contradiction, Diagnosis, Verdict};
use crate::calibrate::Problem;
use crate::calibrate::joint::Estimate;
use crate::calibrate::repeats::DRIFT;
use crate::calibrate::unknowns::{FARTHEST, UnknownKind};
use models::digits::significant;

/// All that concern a diagnosis as it stands, its problem, and where its fit ended.
pub(super) fn warnings(diagnosis: &Diagnosis, problem: &Problem, known: &[Estimate]) -> Vec<String> {
    let mut words: Vec<String> = several(diagnosis).into_iter().collect();
    words.extend(stop::warning(diagnosis));
    words.extend(mesh_check::warning(&diagnosis.numerics));
    words.extend(of_experiment(problem));
    words.extend(diagnosis.contradictions.iter().map(|own| format!("{}: check the setup", own.told())));
    words.extend(diagnosis.effects.iter().flat_map(|added| bounded(known, &added.effect)));
    words
}

/// Standard deviations by which a value is off what was `believed`; none where it is not so far off as the setup may be, but
/// for rounding. How far dampings of releases differ is measured, so a large one contradicts no statement.
pub(super) fn deviations_off(found: &Estimate, believed: &Estimate) -> Option<f64> {
    if believed.unknown.kind == UnknownKind::MassDamping {
        return None;
    }
    let prior = believed.unknown.prior?;
    Some(((found.value() - prior.mean) / prior.deviation).abs()).filter(|off| *off > FARTHEST * (1.0 - 1e-6))
}

/// Whether the fit needs a setup as far off as it may be.
pub(super) fn is_strained(known: &[Estimate]) -> bool {
    known.iter().any(|known| deviations_off(known, known).is_some())
}

/// What a fit had to assume of the setup against what was believed: each value, and the unknown that has the belief.
pub(super) fn contradictions<'a>(
    known: impl Iterator<Item = (&'a Estimate, &'a Estimate)>,
) -> Vec<Contradiction> {
    let of = |(found, believed): (&Estimate, &Estimate)| {
        let deviations = deviations_off(found, believed)?;
        let (parameter, unit) = (found.unknown.name.clone(), found.unknown.unit.to_owned());
        Some(Contradiction { parameter, value: found.value(), unit, deviations })
    };
    let mut all: Vec<_> = known.filter_map(of).collect();
    all.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    all
}

impl Contradiction {
    /// In words.
    pub(super) fn told(&self) -> String {
        let Self { parameter, value, unit, deviations } = self;
        let value = match unit.as_str() {
            "rad" => stated(value.to_degrees(), "deg"),
            unit => stated(*value, unit),
        };
        format!("{parameter} = {value} is {deviations:.0} standard deviations from its prior")
    }
}

/// A value with its unit.
fn stated(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 3)).trim_end().to_owned()
}

/// What of an effect stands at an end of what is believed, so that its interval is no more than a bound.
fn bounded(known: &[Estimate], effect: &str) -> Vec<String> {
    let prefix = prefix(effect);
    let of = |known: &Estimate| {
        let is_own = known.unknown.name.starts_with(&prefix);
        (is_own && known.value() != 0.0 && known.unknown.is_at_bound(known.x)).then(|| {
            format!(
                "{} = {} hit its bound; the fit would go further: check whether this value suits the rod, or stands in for another effect",
                known.unknown.label(),
                stated(known.value(), known.unknown.unit)
            )
        })
    };
    known.iter().filter_map(of).collect()
}

/// What should be known of an answer of several names.
fn several(diagnosis: &Diagnosis) -> Option<String> {
    let is_named = matches!(diagnosis.verdict, Verdict::Named | Verdict::Incomplete | Verdict::Class);
    (is_named && diagnosis.effects.len() > 1).then(|| {
        "several effects together can stand in for one outside the catalogue: confirm them with another recording, with markers on the body".to_owned()
    })
}

/// Effects that are part of every diagnosis, and no choice of an experiment.
const STANDING: [&str; 5] = ["gravity", "rayleigh_mass", "rayleigh_stiffness", TILT, DRIFT];

/// Candidates that are none because the experiment's model has them.
fn had(problem: &Problem) -> Vec<&'static str> {
    let all = problem.trials.first().map(|trial| trial.model.catalogue.clone()).unwrap_or_default();
    let causes = all.iter().map(|effect| effect.about()).filter(|about| about.kind != Kind::Description);
    let could =
        causes.filter(|about| about.parameters.iter().any(|parameter| parameter.null_value.is_some()));
    could.map(|about| about.name).filter(|name| !STANDING.contains(name) && problem.has(name)).collect()
}

/// A release that is seen for less than that, s, says little of how a swing dies away.
const SHORT: f64 = 2.0;

/// What an experiment cannot tell, whatever the answer.
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
    let longest = fitted.iter().filter_map(|trial| trial.release.time.last()).fold(0.0, |a, b| b.max(a));
    if longest < SHORT {
        words.push(format!(
            "no release is longer than {longest:.1} s: damping and slow changes are poorly determined; record until the swing has died away"
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::unknowns::{Group, Scaled, Unknown, UnknownKind};
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
    fn a_damping_that_does_not_repeat_contradicts_no_statement() {
        let of = |kind: UnknownKind| {
            let unknown = Unknown::nuisance(kind, "any", "", Group::Release(0), 1.0, f64::INFINITY);
            let known = Estimate { unknown, x: 5.0 };
            deviations_off(&known, &known)
        };
        assert_eq!((of(UnknownKind::HoldAngle), of(UnknownKind::MassDamping)), (Some(5.0), None));
    }

    /// A part that is zero is absent, and at no bound.
    #[test]
    fn what_stands_at_an_end_of_its_range_is_warned_of() {
        let known = |name: &str, value: f64| Estimate {
            unknown: Unknown {
                kind: UnknownKind::Parameter(0),
                name: format!("effects.{name}"),
                unit: "m",
                group: Group::All,
                scaled: Scaled::By(1e-3),
                bounds: (0.0, 5.0),
                prior: None,
                start: 0.0,
            },
            x: 1e3 * value,
        };
        let all = [
            known("marker_offset.along", 5e-3),
            known("marker_offset.across", 3e-3),
            known("marker_offset.third", 0.0),
            known("hose.stiffness", 5e-3),
        ];
        let words = bounded(&all, "marker_offset");
        assert_eq!(words.len(), 1, "{words:?}");
        assert!(words[0].starts_with("effects.marker_offset.along = 0.00500 m hit its bound"), "{words:?}");
    }
}
