//! What many answers are worth: a confusion matrix, and the rates that a diagnosis is held to.

use std::collections::BTreeMap;
use std::fmt::Write;

use efam_inference::diagnose::Verdict;

use super::answer::{Answer, TOLD_APART};

/// Distance below which two effects are one, standard deviations.
const ONE: f64 = 2.0;

/// The answers in a few lines: what was hidden and what was said, then the rates.
pub fn told(answers: &[Answer]) -> String {
    let mut text = String::from("hidden: what was said (how often)\n");
    let mut matrix: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for answer in answers {
        let names: Vec<&str> = answer.case.hidden.iter().map(|(name, _)| *name).collect();
        let mut hidden = if names.is_empty() { "nothing".to_owned() } else { names.join(" + ") };
        if answer.case.is_robbed {
            hidden += " (not in the catalogue)";
        }
        *matrix.entry(hidden).or_default().entry(answer.said()).or_insert(0) += 1;
    }
    for (hidden, said) in &matrix {
        let said: Vec<String> = said.iter().map(|(said, count)| format!("{said} ({count})")).collect();
        let _ = writeln!(text, "  {hidden}: {}", said.join("; "));
    }
    text.push('\n');
    let single = |a: &&Answer| a.case.is_known() && a.case.hidden.len() == 1 && a.is_visible;
    let at = |range: fn(f64) -> bool| {
        answers.iter().filter(single).filter(move |a| a.distance.is_some_and(range)).collect::<Vec<_>>()
    };
    let separable = at(|d| d >= TOLD_APART);
    let between = at(|d| (ONE..TOLD_APART).contains(&d));
    let one = at(|d| d < ONE);
    rate(&mut text, "separable (D of 5 or more): right name first", &separable, |a| a.is_right());
    rate(&mut text, "separable: truth in what is said", &separable, |a| a.holds_the_truth());
    rate(&mut text, "separable: a false name beside or instead", &separable, |a| a.has_a_false_name());
    let sizes = separable.iter().filter(|a| a.is_a_name()).map(|a| 1.0 + a.diagnosis.members.len() as f64);
    number(&mut text, "separable: median size of the class", median(sizes.collect()));
    rate(&mut text, "between (D of 2 to 5): truth in what is said", &between, |a| a.holds_the_truth());
    rate(&mut text, "one of several (D below 2): a class", &one, |a| a.is_a_class());
    rate(&mut text, "one of several: truth in what is said", &one, |a| a.holds_the_truth());
    let classes: Vec<&Answer> = answers.iter().filter(|a| a.is_a_class() && single(a)).collect();
    rate(&mut text, "classes: a recording that separates the nearest two", &classes, |a| {
        a.diagnosis.separating_experiment.as_ref().is_some_and(|found| found.distance >= TOLD_APART)
    });
    let empty: Vec<&Answer> = answers.iter().filter(|a| a.case.hidden.is_empty()).collect();
    rate(&mut text, "nothing hidden: a false name", &empty, |a| a.has_a_false_name());
    rate(&mut text, "nothing hidden: nothing said", &empty, |a| {
        a.diagnosis.verdict == Verdict::NothingMissing
    });
    let (strange, cousins): (Vec<&Answer>, Vec<&Answer>) = answers
        .iter()
        .filter(|a| !a.case.is_known() && a.is_visible)
        .partition(|a| a.distance.is_none_or(|distance| distance >= TOLD_APART));
    rate(&mut text, "not in the catalogue, a cousin is: a name or a class", &cousins, |a| a.is_a_name());
    rate(&mut text, "not in the catalogue: unknown or incomplete", &strange, |a| {
        matches!(a.diagnosis.verdict, Verdict::Unknown | Verdict::Incomplete)
    });
    rate(&mut text, "not in the catalogue: a single false name", &strange, |a| {
        a.diagnosis.verdict == Verdict::Named
    });
    let pairs: Vec<&Answer> = answers.iter().filter(|a| a.case.hidden.len() == 2).collect();
    rate(&mut text, "two hidden: both named", &pairs, |a| a.holds_the_truth());
    strengths(&mut text, &separable);
    gaps(&mut text, &separable);
    let seconds: Vec<f64> = answers.iter().map(|a| a.seconds).collect();
    number(&mut text, "seconds a set, longest", seconds.iter().copied().fold(0.0, f64::max));
    number(&mut text, "seconds a set, median", median(seconds));
    text
}

/// How well strengths are known where the name is right.
fn strengths(text: &mut String, answers: &[&Answer]) {
    let known: Vec<(f64, bool)> = answers
        .iter()
        .filter_map(|answer| answer.relative_strength())
        .map(|(found, [low, high])| ((found - 1.0).abs(), (low..=high).contains(&1.0)))
        .collect();
    rate(text, "right names: the interval holds the strength", &known.iter().collect::<Vec<_>>(), |k| k.1);
    number(text, "right names: error of the strength, median", median(known.iter().map(|k| k.0).collect()));
}

/// How far the repaired model is from what is true.
fn gaps(text: &mut String, answers: &[&Answer]) {
    let right: Vec<&Answer> = answers.iter().copied().filter(|a| a.is_right()).collect();
    for (k, of) in ["fitted", "held out"].into_iter().enumerate() {
        let all = right.iter().map(|a| a.noise_free[k]).collect();
        number(text, &format!("right names: noise-free gap over the noise, {of}, median"), median(all));
    }
}

fn rate<T>(text: &mut String, what: &str, of: &[&T], is: impl Fn(&T) -> bool) {
    if !of.is_empty() {
        let count = of.iter().filter(|one| is(one)).count();
        let share = 100.0 * count as f64 / of.len() as f64;
        let _ = writeln!(text, "  {what:60} {count:4} of {:4}  {share:5.1} %", of.len());
    }
}

fn number(text: &mut String, what: &str, value: f64) {
    if value.is_finite() {
        let _ = writeln!(text, "  {what:60} {value:.3}");
    }
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}
