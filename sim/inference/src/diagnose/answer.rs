//! From odds to an answer: the rules of the verdict, and its numbers.

use super::data::Data;
use super::likelihood::Fit;
use super::samples::{Sampled, numbers};
use super::setup::FREED;
use super::unknown::{Role, Unknown};
use super::verdict::{Added, Contradiction, Diagnosis, Gap, Member, ParameterValue, Seen, Total, Verdict};
use super::words::words;
use super::{Accepted, DiagnosisSettings, Found};
use crate::normal::NORMAL_95;

/// Share of the mean square of the misfit that an answer may leave: odds do not know that the truth is absent, so it must explain
/// more than it leaves. What it saves in deviations from what is stated counts as well, by its likelihood.
const LEFT: f64 = 0.5;
/// Prior standard deviations from which on a part of the setup is reported. Of what all releases share there are some eight numbers:
/// in one set of three one of them is so far off by chance, which costs a look. Of what each release has of its own there are fifty.
const MOVED: f64 = 2.0;
const OWN_MOVED: f64 = 3.0;
/// Features that are reported.
const REPORTED: usize = 8;

/// The answer from what was found, without its words.
pub(super) fn answer(found: &Found, settings: &DiagnosisSettings, gap: Vec<Gap>) -> Diagnosis {
    let Found { data, baseline, accepted, members, rounds, .. } = found;
    let last = accepted.last().map_or(baseline, |own| &own.sampled);
    let name = |(place, own): &(usize, Accepted)| Member {
        effect: own.name.clone(),
        behind: accepted[*place].odds - own.odds,
        distance: None,
    };
    let hypothesis = &last.fit.hypothesis;
    Diagnosis {
        verdict: verdict(found),
        effects: effects(last, data.plans.len(), accepted.iter().map(|own| own.name.as_str())),
        freed: hypothesis.freed.map(str::to_owned),
        members: members.iter().map(name).collect(),
        rounds: rounds.clone(),
        seen: seen(data, &baseline.fit, &last.fit),
        contradictions: contradictions(last),
        held_out: gap.iter().filter(|gap| gap.held_out).map(|gap| gap.release.clone()).collect(),
        gap,
        total: Total {
            before_mm: 1e3 * baseline.rms,
            after_mm: 1e3 * last.rms,
            noise_mm: 1e3 * last.noise,
            repeats_mm: 1e3 * last.repeated_within(data),
        },
        false_alarm: settings.false_alarm,
        nodes: hypothesis.trials[0].model.edges + 1,
        features: data.count(),
        unknowns: baseline.fit.at.z.len(),
        runs: data.runs(),
        ..Diagnosis::default()
    }
}

/// Whether held-out releases, which take part in no fit of what releases share, are fitted worse with an answer than without.
pub(super) fn is_contradicted(gap: &[Gap]) -> bool {
    let held_out = |of: fn(&Gap) -> f64| -> f64 {
        gap.iter().filter(|gap| gap.held_out).map(|gap| of(gap).powi(2)).sum()
    };
    held_out(|gap| gap.after) > held_out(|gap| gap.before)
}

/// The rules.
fn verdict(found: &Found) -> Verdict {
    let Found { data, baseline, accepted, members, .. } = found;
    let Some(last) = accepted.last() else {
        // What was not compared may be what is missing. What is far beyond noise and what repeats is there, whatever explains it.
        let is_cut_short = found.cut_short.is_some();
        let is_nothing = baseline.may_be_noise(baseline.repeats(data)) && !is_cut_short && !found.has_more;
        return if is_nothing { Verdict::NothingMissing } else { Verdict::Unknown };
    };
    let after = &last.sampled;
    let saved = 0.5 * (baseline.fit.at.z.norm_squared() - after.fit.at.z.norm_squared()).max(0.0);
    let numbers: f64 = data.plans.iter().map(numbers).sum();
    let explained = numbers * (baseline.misfit() / after.misfit()).ln() + saved;
    let is_half = explained >= -0.5 * numbers * LEFT.ln() || after.may_be_noise(data.stated_repeats());
    if !is_half {
        return Verdict::Unknown;
    }
    match (&accepted[..], members.is_empty(), after.may_be_noise(data.known_repeats())) {
        ([only], ..) if only.strengths.is_empty() => Verdict::Misstated,
        (_, _, false) => Verdict::Incomplete,
        (_, false, _) => Verdict::Class,
        _ => Verdict::Named,
    }
}

/// Value and interval of an unknown.
fn value(sampled: &Sampled, u: usize) -> (f64, [f64; 2]) {
    let fit = &sampled.fit;
    let unknown = &fit.hypothesis.unknowns[u];
    let own = unknown.own(&fit.hypothesis.trials);
    let (z, error) = (fit.at.z[u], sampled.covariance[(u, u)].max(0.0).sqrt());
    let at = |z: f64| unknown.value(own, if unknown.is_half { z.max(0.0) } else { z });
    let mut interval = [at(z - NORMAL_95 * error), at(z + NORMAL_95 * error)];
    interval.sort_by(f64::total_cmp);
    (at(z), interval)
}

/// Effects with their parameters: those that were fitted, and those that have another value than zero.
fn effects<'a>(sampled: &Sampled, fitted: usize, names: impl Iterator<Item = &'a str>) -> Vec<Added> {
    let hypothesis = &sampled.fit.hypothesis;
    let (trials, unknowns) = (&hypothesis.trials, &hypothesis.unknowns);
    let model = &trials[0].model;
    let effect = |name: &str| {
        let prefix = format!("effects.{name}.");
        let mut parameters = Vec::new();
        for (k, own) in model.parameters.iter().enumerate() {
            let Some(key) = own.path.strip_prefix(&prefix) else { continue };
            let is_of = |u: &usize| unknowns[*u].path(trials) == Some(&own.path);
            let own_unknowns: Vec<usize> = (0..unknowns.len()).filter(is_of).collect();
            for u in own_unknowns.iter().filter(|u| unknowns[**u].is_of_any(fitted)) {
                let (value, interval) = value(sampled, *u);
                parameters.push(ParameterValue {
                    name: key.to_owned(),
                    unit: own.unit.to_owned(),
                    of: unknowns[*u].of(trials),
                    value,
                    interval_95: Some(interval),
                });
            }
            if own_unknowns.is_empty() && model.theta[k] != 0.0 {
                let (name, unit) = (key.to_owned(), own.unit.to_owned());
                parameters.push(ParameterValue {
                    name,
                    unit,
                    of: None,
                    value: model.theta[k],
                    interval_95: None,
                });
            }
        }
        (!parameters.is_empty()).then(|| Added { effect: name.to_owned(), parameters })
    };
    names.filter_map(effect).collect()
}

/// What of the rod and the setup is far off what is stated, the farthest first; losses are not stated.
fn contradictions(sampled: &Sampled) -> Vec<Contradiction> {
    let hypothesis = &sampled.fit.hypothesis;
    let wider = |word: &str| {
        let own = hypothesis.freed.filter(|freed| *freed == word)?;
        FREED.iter().find(|(freed, _)| *freed == own).map(|(_, factor)| *factor)
    };
    let of = |(u, unknown): (usize, &Unknown)| {
        let Role::Setup(word) = unknown.role else { return None };
        let deviations = sampled.fit.at.z[u] * wider(word).unwrap_or(1.0);
        let (value, interval_95) = value(sampled, u);
        let moved = if unknown.is_own { OWN_MOVED } else { MOVED };
        let is_off = deviations.abs() > moved && !["parameter", "hand"].contains(&word);
        is_off.then(|| Contradiction {
            parameter: unknown.label.clone(),
            value,
            interval_95,
            unit: unknown.unit.to_owned(),
            deviations,
        })
    };
    let mut all: Vec<Contradiction> = hypothesis.unknowns.iter().enumerate().filter_map(of).collect();
    all.sort_by(|a, b| b.deviations.abs().total_cmp(&a.deviations.abs()));
    all
}

/// Features that an answer mends, the largest gain first; of an answer that is none those that are off most.
fn seen(data: &Data, before: &Fit, after: &Fit) -> Vec<Seen> {
    let mut all = Vec::new();
    for (r, plan) in data.plans.iter().enumerate() {
        let trial = &after.hypothesis.trials[r];
        for (f, what) in plan.features.iter().enumerate() {
            let [was, is] = [before, after].map(|fit| fit.at.seen.features.differences[r][f]);
            if !(was.is_finite() && is.is_finite()) {
                continue;
            }
            let in_words = |value: f64| words(plan, trial, *what, value);
            let (name, unit, recorded) = in_words(plan.values[f]);
            let there = |difference: f64| in_words(plan.values[f] + plan.scales[f] * difference).2;
            // What is left is the noise of the feature, and what the answer does not explain.
            let deviation = data.weights[r].deviation(f, after.share);
            all.push(Seen {
                release: trial.release.name.clone(),
                what: name,
                unit: unit.to_owned(),
                recorded,
                before: there(was),
                after: there(is),
                deviations: [was, is].map(|own| own / deviation),
            });
        }
    }
    let gain = |own: &Seen| own.deviations[0].powi(2) - own.deviations[1].powi(2);
    let off = |own: &Seen| own.deviations[1].abs();
    let is_same = std::ptr::eq(before, after);
    all.sort_by(|a, b| if is_same { off(b).total_cmp(&off(a)) } else { gain(b).total_cmp(&gain(a)) });
    all.truncate(REPORTED);
    all
}
