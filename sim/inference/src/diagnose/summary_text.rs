//! The answer in words.

use models::digits::{short, significant};
use models::effects::by_name;

use super::verdict::{Added, Contradiction, Diagnosis, Gap, ParameterValue, Seen, Separation, Verdict};
use crate::listed::listed;

/// Features that are said in a sentence.
const SAID: usize = 2;
/// Values of an effect that a sentence gives, at most.
const GIVEN: usize = 3;

/// Lines for a person: the answer with the gap before and after, then the evidence. A line is there only if it has numbers.
pub(super) fn summary(diagnosis: &Diagnosis) -> String {
    let is_named = !diagnosis.effects.is_empty();
    let first = match diagnosis.verdict {
        Verdict::NothingMissing => "Nothing is missing that these recordings could show.".to_owned(),
        Verdict::Misstated => misstated(diagnosis),
        Verdict::Named | Verdict::Class | Verdict::Incomplete => named(diagnosis),
        Verdict::Unknown => unknown(diagnosis),
    };
    let lines = [
        Some(with_gap(&first, diagnosis)),
        (diagnosis.verdict == Verdict::NothingMissing).then(|| {
            "No effect of the catalogue explains more than noise and what does not repeat.".to_owned()
        }),
        (diagnosis.verdict != Verdict::NothingMissing).then(|| seen(&diagnosis.seen)).flatten(),
        removed(diagnosis),
        remains(diagnosis),
        (diagnosis.verdict != Verdict::Misstated).then(|| contradicted(diagnosis)).flatten(),
        is_named.then(|| next_best(diagnosis)).flatten(),
        diagnosis.separating_experiment.as_ref().map(to_tell_apart),
    ];
    let not_final = diagnosis.cut_short_in_round().filter(|_| diagnosis.verdict != Verdict::Unknown);
    let not_final = not_final.map(|round| format!("Not final: the search was cut short in round {round}. "));
    not_final.unwrap_or_default() + &lines.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

/// An answer with the gap before and after, on one line.
fn with_gap(answer: &str, diagnosis: &Diagnosis) -> String {
    let own = &diagnosis.total;
    let gap = if diagnosis.effects.is_empty() && diagnosis.freed.is_none() {
        format!("is {} mm", significant(own.after_mm, 2))
    } else {
        change(own.before_mm, own.after_mm)
    };
    format!("{answer} The gap between simulation and recordings {gap}.")
}

/// How a distance changes, mm.
fn change(before: f64, after: f64) -> String {
    let verb = if after > before { "rises" } else { "falls" };
    format!("{verb} from {} to {} mm", significant(before, 2), significant(after, 2))
}

/// An effect or statement as a person calls it: an effect as its page begins, `Air drag on the body: …`.
pub(super) fn called(name: &str) -> String {
    let page = by_name(name).map(|effect| effect.page());
    let title = page.as_deref().and_then(|page| page.split_once(':'));
    let Some((title, _)) = title else { return name.replace('_', " ") };
    let mut letters = title.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// What is missing, with its values, and what cannot be separated from it.
fn named(diagnosis: &Diagnosis) -> String {
    let names = listed(&diagnosis.effects.iter().map(with_sizes).collect::<Vec<_>>());
    let others: Vec<_> = diagnosis.members.iter().map(|member| called(&member.effect)).collect();
    let or = if others.is_empty() {
        String::new()
    } else {
        format!(", or what these recordings cannot separate from it ({})", others.join(", "))
    };
    let is = if diagnosis.effects.len() > 1 { "are" } else { "is" };
    let values: Vec<String> = diagnosis.effects.iter().filter_map(values).collect();
    let values = if values.is_empty() { String::new() } else { format!(": {}", values.join("; ")) };
    let more = match diagnosis.verdict {
        Verdict::Incomplete => {
            " More than noise remains: a similar effect may act instead, or another one as well."
        }
        _ => "",
    };
    let freed = diagnosis.freed.as_ref().map_or(String::new(), |word| {
        format!(" Beside that, what is stated of the {word} is wrong{}.", of_freed(diagnosis))
    });
    format!("{} {is} missing{or}{values}.{freed}{more}", capitalised(&names))
}

/// An effect as a person calls it, and whether its strength differs.
fn with_sizes(added: &Added) -> String {
    let first = added.parameters.first().map(|own| &own.name);
    let sizes = added.parameters.iter().filter(|own| Some(&own.name) == first && own.of.is_some());
    let of_each =
        if sizes.count() > 1 { " with a strength of its own at each pressure or release" } else { "" };
    format!("{}{of_each}", called(&added.effect))
}

/// A statement that is wrong, and what cannot be separated from it.
fn misstated(diagnosis: &Diagnosis) -> String {
    let word = diagnosis.freed.as_deref().unwrap_or("setup");
    let others: Vec<_> = diagnosis.members.iter().map(|member| called(&member.effect)).collect();
    let or = if others.is_empty() {
        String::new()
    } else {
        format!(" Or what these recordings cannot separate from it: {}.", others.join(", "))
    };
    format!(
        "What is stated of the {word} is wrong{}. With the fitted value nothing else is missing: measure it again.{or}",
        of_freed(diagnosis)
    )
}

/// The values of a statement that is wrong, after a colon.
fn of_freed(diagnosis: &Diagnosis) -> String {
    let values: Vec<String> = diagnosis.contradictions.iter().take(SAID).map(Contradiction::words).collect();
    if values.is_empty() { String::new() } else { format!(": {}", listed(&values)) }
}

/// That something is missing which has no name, or was not looked for.
fn unknown(diagnosis: &Diagnosis) -> String {
    let names: Vec<_> = diagnosis.effects.iter().map(|own| called(&own.effect)).collect();
    match (names.is_empty(), diagnosis.cut_short_in_round()) {
        (true, Some(round)) => format!("No final answer: the search was cut short in round {round}."),
        (true, None) => "Something is missing that no effect of the catalogue explains.".to_owned(),
        _ => format!(
            "Something is missing that no effect of the catalogue explains. {} comes nearest, does not explain half of the misfit, and need not be its cause.",
            capitalised(&listed(&names))
        ),
    }
}

/// The values of an effect; nothing where there are too many for a sentence.
fn values(added: &Added) -> Option<String> {
    let words = |value: &ParameterValue| {
        let of = value.of.as_ref().map_or(String::new(), |of| format!(" of {of}"));
        let number = format!("{} {}", short(value.value), value.unit);
        let interval = match value.interval_95 {
            Some([low, high]) => {
                format!(" (95 % interval {} to {})", short(low), short(high))
            }
            None => " (not fitted)".to_owned(),
        };
        format!("{}{of} {}{interval}", value.name.replace('_', " "), number.trim_end())
    };
    let few = (1..=GIVEN).contains(&added.parameters.len());
    few.then(|| listed(&added.parameters.iter().map(words).collect::<Vec<_>>()))
}

/// What is seen in the recordings, and what the model has instead.
fn seen(all: &[Seen]) -> Option<String> {
    let of = |own: &Seen| {
        let number = |value: f64| format!("{} {}", significant(value, 4), own.unit).trim_end().to_owned();
        let after = if own.before == own.after {
            String::new()
        } else {
            format!(", and {} with it", number(own.after))
        };
        format!(
            "{} of {} is {}; the model has {}{after}",
            own.what,
            own.release,
            number(own.recorded),
            number(own.before)
        )
    };
    let all: Vec<String> = all.iter().take(SAID).map(of).collect();
    (!all.is_empty()).then(|| format!("Seen: {}.", all.join("; ")))
}

fn percent(share: f64) -> String {
    if share >= 0.995 { "all".to_owned() } else { format!("{:.0} %", 100.0 * share) }
}

/// Share of the square of what noise does not explain that an answer removes.
fn share_removed(before: f64, after: f64, noise: f64) -> f64 {
    1.0 - (after.powi(2) - noise.powi(2)).max(0.0) / (before.powi(2) - noise.powi(2)).max(f64::MIN_POSITIVE)
}

fn removed(diagnosis: &Diagnosis) -> Option<String> {
    if diagnosis.effects.is_empty() && diagnosis.freed.is_none() {
        return None;
    }
    let own = &diagnosis.total;
    let share = share_removed(own.before_mm, own.after_mm, own.noise_mm);
    let held_out: Vec<&Gap> = diagnosis.gap.iter().filter(|gap| gap.held_out).collect();
    let mean = |of: fn(&Gap) -> f64| {
        let square: f64 = held_out.iter().map(|gap| of(gap).powi(2)).sum();
        (square / held_out.len().max(1) as f64).sqrt()
    };
    let on_held_out = if held_out.is_empty() {
        String::new()
    } else {
        let gap = change(mean(|gap| gap.before_mm), mean(|gap| gap.after_mm));
        format!(" On held-out releases the gap {gap}.")
    };
    (share > 0.0)
        .then(|| format!("The answer explains {} of the residual beyond noise.{on_held_out}", percent(share)))
}

/// What remains, beside how well the experiment repeats.
fn remains(diagnosis: &Diagnosis) -> Option<String> {
    let own = &diagnosis.total;
    (own.after_mm > 0.0).then(|| {
        let [left, noise, repeats] =
            [own.after_mm, own.noise_mm, own.repeats_mm].map(|value| significant(value, 2));
        format!("The remaining {left} mm compare with {noise} mm of noise, and {repeats} mm by which releases may differ.")
    })
}

/// What of the setup a fit moved far.
fn contradicted(diagnosis: &Diagnosis) -> Option<String> {
    let far: Vec<String> = diagnosis.contradictions.iter().map(Contradiction::words).take(SAID).collect();
    (!far.is_empty()).then(|| format!("Check the setup: {}.", listed(&far)))
}

impl Contradiction {
    /// In words.
    pub(super) fn words(&self) -> String {
        let stated = |value: f64| match self.unit.as_str() {
            "rad" => format!("{} deg", significant(value.to_degrees(), 3)),
            unit => format!("{} {unit}", significant(value, 3)).trim_end().to_owned(),
        };
        format!(
            "{} = {}, {:.1} standard deviations off",
            self.parameter,
            stated(self.value),
            self.deviations.abs()
        )
    }
}

/// What the next best effect of the last round would explain.
fn next_best(diagnosis: &Diagnosis) -> Option<String> {
    let named = diagnosis.effects.last()?;
    let is_of = |name: &str| name == named.effect;
    let round = diagnosis
        .rounds
        .iter()
        .find(|round| round.candidates.iter().any(|own| own.rejected.is_none() && is_of(&own.name)))?;
    let best = round.candidates.iter().find(|own| is_of(&own.name))?;
    let is_other = |name: &str| !is_of(name) && diagnosis.members.iter().all(|own| own.effect != name);
    let next = round.candidates.iter().find(|own| own.all.is_some() && is_other(&own.name))?;
    let behind = best.best() - next.best();
    Some(format!(
        "{}, the next best, is less likely by a factor of {}.",
        capitalised(&called(&next.name)),
        odds(behind)
    ))
}

/// A factor from its logarithm, in words that can be read.
fn odds(logarithm: f64) -> String {
    let decades = logarithm / std::f64::consts::LN_10;
    if decades < 3.0 { significant(logarithm.exp(), 2) } else { format!("1e{decades:.0}") }
}

fn to_tell_apart(separation: &Separation) -> String {
    format!(
        "To separate them, record {}: by simulation, this raises the distance of the nearest two from {:.1} to {:.1} standard deviations.",
        separation.what, separation.distance_now, separation.distance
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::verdict::{CutBy, CutShort, Member, Odds, Round, Total};

    fn answer(verdict: Verdict) -> Diagnosis {
        let value = ParameterValue {
            name: "drag_coefficient".to_owned(),
            unit: String::new(),
            of: None,
            value: 1.1,
            interval_95: Some([1.0, 1.2]),
        };
        let candidate = |name: &str, all: f64, why: Option<&str>| Odds {
            name: name.to_owned(),
            all: Some(all),
            rejected: why.map(str::to_owned),
            ..Odds::default()
        };
        let candidates = vec![candidate("air_drag", 30.0, None), candidate("creep", 10.0, Some("less"))];
        Diagnosis {
            verdict,
            effects: vec![Added { effect: "air_drag".to_owned(), parameters: vec![value] }],
            rounds: vec![Round { bar: 8.0, share: 0.01, candidates, others: Vec::new() }],
            total: Total { before_mm: 2.0, after_mm: 0.25, noise_mm: 0.2, repeats_mm: 1.0 },
            seen: vec![Seen {
                release: "first".to_owned(),
                what: "frequency in the first cycle".to_owned(),
                unit: "Hz".to_owned(),
                recorded: 1.1,
                before: 1.2,
                after: 1.1,
                deviations: [9.0, 0.1],
            }],
            ..Diagnosis::default()
        }
    }

    #[test]
    fn the_first_line_has_name_value_and_gap() {
        let said = summary(&answer(Verdict::Named));
        let first = said.lines().next().unwrap();
        assert!(
            first.starts_with(
                "Air drag on the body is missing: drag coefficient 1.10 (95 % interval 1.00 to 1.20)."
            ),
            "{first}"
        );
        assert!(
            first.ends_with("The gap between simulation and recordings falls from 2.0 to 0.25 mm."),
            "{first}"
        );
        assert!(said.contains("Seen: frequency in the first cycle of first is 1.100 Hz; the model has 1.200 Hz, and 1.100 Hz with it."), "{said}");
        assert!(said.contains("is less likely by a factor of 1e9"), "{said}");
    }

    #[test]
    fn a_class_and_an_answer_that_is_not_final_say_so() {
        let mut class = answer(Verdict::Class);
        class.members = vec![Member { effect: "tip_drag".to_owned(), behind: 1.0, distance: Some(1.5) }];
        assert!(summary(&class).contains("cannot separate from it (tip drag)"), "{}", summary(&class));
        class.cut_short = Some(CutShort { round: Some(2), by: CutBy::Budget });
        assert!(summary(&class).starts_with("Not final: the search was cut short in round 2."));
    }

    /// A setup that is off is said where nothing is missing.
    #[test]
    fn a_setup_that_is_off_is_said() {
        let mut nothing =
            Diagnosis { effects: Vec::new(), rounds: Vec::new(), ..answer(Verdict::NothingMissing) };
        assert!(!summary(&nothing).contains("setup"));
        nothing.contradictions = vec![Contradiction {
            parameter: "angle of the clamp".to_owned(),
            value: 0.1,
            unit: "rad".to_owned(),
            deviations: -3.2,
            ..Contradiction::default()
        }];
        let said = summary(&nothing);
        assert!(
            said.contains("Check the setup: angle of the clamp = 5.73 deg, 3.2 standard deviations off."),
            "{said}"
        );
    }
}
