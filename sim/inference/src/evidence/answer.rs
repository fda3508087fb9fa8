//! From odds to an answer: the rules of the verdict, and its words.

use super::Accepted;
use super::data::Data;
use super::likelihood::Fit;
use super::samples::{Sampled, numbers};
use super::unknown::Role;
use super::verdict::{Round, Seen, Value, Weighed};
use super::words::words;
use crate::diagnose::verdict::Verdict;
use crate::normal::NORMAL_95;

/// Share of the misfit that an answer may leave: odds do not know that the truth is absent, so the best must remove half. What
/// it saves in deviations from what is stated counts as well, by its likelihood.
const LEFT: f64 = 0.5;
/// Prior standard deviations from which on a part of the setup is reported.
const MOVED: f64 = 2.0;
/// Features that are reported.
const REPORTED: usize = 5;

/// The answer from what was accepted.
pub fn answer(
    data: &Data,
    baseline: &Sampled,
    accepted: &[Accepted],
    members: Vec<String>,
    rounds: Vec<Round>,
    warnings: Vec<String>,
) -> Weighed {
    let last = accepted.last();
    let sampled = last.map_or(baseline, |own| &own.sampled);
    let swing = data.first_swing();
    let values = values(sampled, |role| !matches!(role, Role::Setup(_)));
    let mut weighed = Weighed {
        named: accepted.iter().map(|own| own.name.clone()).collect(),
        members,
        rounds,
        moved: values_of_setup(sampled),
        values,
        before_mm: 1e3 * baseline.rms,
        after_mm: 1e3 * sampled.rms,
        noise_mm: 1e3 * sampled.noise,
        seen: last.map_or(Vec::new(), |own| seen(data, &baseline.fit, &own.sampled.fit)),
        runs: data.runs(),
        features: data.count(),
        unknowns: baseline.fit.at.z.len(),
        releases: data.plans.len(),
        warnings,
        ..Weighed::default()
    };
    let numbers = data.plans.iter().map(numbers).sum();
    weighed.verdict = verdict(baseline, sampled, accepted, &weighed, numbers, swing);
    weighed.summary = summary(&weighed);
    weighed
}

/// The rules.
fn verdict(
    before: &Sampled,
    after: &Sampled,
    accepted: &[Accepted],
    weighed: &Weighed,
    numbers: f64,
    swing: f64,
) -> Verdict {
    let is_little = |own: &Sampled| own.is_little(swing);
    if accepted.is_empty() {
        // What is far beyond noise and what repeats is there, whatever explains it.
        return if is_little(before) { Verdict::NothingMissing } else { Verdict::Unknown };
    }
    let saved = 0.5 * (before.fit.at.z.norm_squared() - after.fit.at.z.norm_squared()).max(0.0);
    let explained = numbers * (before.misfit() / after.misfit()).ln() + saved;
    if explained < -numbers * LEFT.ln() && !is_little(after) {
        return Verdict::Unknown;
    }
    let is_statement =
        accepted.last().is_some_and(|own| own.sampled.fit.hypothesis.freed == Some(statement(&own.name)));
    if is_statement && accepted.len() == 1 {
        return Verdict::Misstated;
    }
    if !weighed.members.is_empty() {
        return Verdict::Class;
    }
    if is_little(after) { Verdict::Named } else { Verdict::Incomplete }
}

/// The statement of that name; none such is an empty word.
fn statement(name: &str) -> &'static str {
    super::setup::FREED.iter().map(|(own, _)| *own).find(|own| *own == name).unwrap_or_default()
}

fn value(sampled: &Sampled, u: usize) -> Value {
    let fit = &sampled.fit;
    let unknown = &fit.hypothesis.unknowns[u];
    let own = unknown.own(&fit.hypothesis.trials);
    let (z, error) = (fit.at.z[u], sampled.covariance[(u, u)].max(0.0).sqrt());
    let at = |z: f64| unknown.value(own, if unknown.is_half { z.max(0.0) } else { z });
    let mut interval = [at(z - NORMAL_95 * error), at(z + NORMAL_95 * error)];
    interval.sort_by(f64::total_cmp);
    Value {
        name: unknown.label.clone(),
        unit: unknown.unit.to_owned(),
        value: at(z),
        interval_95: interval,
        deviations: z,
    }
}

fn values(sampled: &Sampled, is_of: impl Fn(&Role) -> bool) -> Vec<Value> {
    let unknowns = &sampled.fit.hypothesis.unknowns;
    (0..unknowns.len()).filter(|u| is_of(&unknowns[*u].role)).map(|u| value(sampled, u)).collect()
}

/// Parts of the setup that are far off what is stated, the farthest first; losses are not stated.
fn values_of_setup(sampled: &Sampled) -> Vec<Value> {
    let is_stated = |role: &Role| matches!(role, Role::Setup(word) if !["parameter", "hand"].contains(word));
    let mut all = values(sampled, is_stated);
    let freed = sampled.fit.hypothesis.freed;
    all.retain(|own| {
        own.deviations.abs() > MOVED || freed.is_some_and(|_| own.deviations.abs() > 0.5 * MOVED)
    });
    all.sort_by(|a, b| b.deviations.abs().total_cmp(&a.deviations.abs()));
    all.truncate(REPORTED);
    all
}

/// Features that an answer mends, the largest gain first.
fn seen(data: &Data, before: &Fit, after: &Fit) -> Vec<Seen> {
    let share = after.share;
    let mut all = Vec::new();
    for (r, plan) in data.plans.iter().enumerate() {
        let trial = &after.hypothesis.trials[r];
        for (f, what) in plan.features.iter().enumerate() {
            let (was, is) =
                (before.at.seen.features.differences[r][f], after.at.seen.features.differences[r][f]);
            if !(was.is_finite() && is.is_finite()) {
                continue;
            }
            let gain = 0.5 * (was * was - is * is) / (share * share);
            let in_words = |value: f64| words(plan, trial, *what, value);
            let (name, recorded) = in_words(plan.values[f]);
            let there = |difference: f64| in_words(plan.values[f] + plan.scales[f] * difference).1;
            let release = trial.release.name.clone();
            all.push(Seen { release, what: name, recorded, before: there(was), after: there(is), gain });
        }
    }
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all.truncate(REPORTED);
    all
}

/// The answer in one or two sentences.
fn summary(own: &Weighed) -> String {
    let what = own.named.join(" and ");
    let saw = own
        .seen
        .iter()
        .take(2)
        .map(|seen| format!("{} is {:.3} and not {:.3}", seen.what, seen.recorded, seen.before));
    let saw = saw.collect::<Vec<_>>().join("; ");
    let left = format!("{:.3} mm of {:.3} mm are left", own.after_mm, own.before_mm);
    match own.verdict {
        _ if own.rounds.iter().any(|round| round.candidates.is_empty()) && own.named.is_empty() => {
            format!("No answer: no candidate was fitted. {:.3} mm are left.", own.after_mm)
        }
        Verdict::NothingMissing => format!(
            "Nothing is missing that these recordings show: {:.3} mm are left.{}",
            own.after_mm,
            moved(&own.moved)
        ),
        Verdict::Unknown if own.named.is_empty() => {
            format!(
                "Something is missing that no effect of the catalogue explains: {:.3} mm are left.",
                own.after_mm
            )
        }
        Verdict::Unknown => {
            format!("Unknown: {what} fits best, but does not explain half of the misfit; {left}.")
        }
        Verdict::Class => {
            format!(
                "{what} is missing, or {}: these recordings cannot tell. Seen: {saw}. {left}.",
                own.members.join(", ")
            )
        }
        Verdict::Misstated => format!("A stated value is wrong: {what}. Seen: {saw}. {left}."),
        Verdict::Named => format!("{what} is missing. Seen: {saw}. {left}."),
        Verdict::Incomplete => format!("{what} is missing, and something else. Seen: {saw}. {left}."),
    }
}

/// What of the setup is far off what is stated, as a sentence with a blank before; nothing where there is none.
fn moved(all: &[Value]) -> String {
    let of = |own: &Value| {
        let unit = if own.unit.is_empty() { String::new() } else { format!(" {}", own.unit) };
        format!("{} is {:.3e}{unit}, {:.1} deviations off", own.name, own.value, own.deviations.abs())
    };
    let all: Vec<String> = all.iter().take(2).map(of).collect();
    if all.is_empty() {
        return String::new();
    }
    format!(" But the setup is not quite as stated: {}.", all.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setup_that_is_off_is_said_where_nothing_is_missing() {
        let off = Value {
            name: "set curvature".to_owned(),
            unit: "1/m".to_owned(),
            value: 0.5,
            interval_95: [0.4, 0.6],
            deviations: 3.2,
        };
        let mut weighed = Weighed { verdict: Verdict::NothingMissing, ..Weighed::default() };
        assert!(!summary(&weighed).contains("setup"));
        weighed.moved = vec![off];
        let said = summary(&weighed);
        assert!(said.ends_with("set curvature is 5.000e-1 1/m, 3.2 deviations off."), "{said}");
    }
}
