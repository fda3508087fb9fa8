//! The answer in words.

use std::collections::HashSet;
use std::fmt::Write;

use models::effects::by_name;

use super::misfit::BANDS;
use super::round::NO_MORE;
use super::verdict::{
    Added, Contradiction, Description, Diagnosis, Evidence, Gap, Misfit, ParameterValue, Separation, Shape,
    Verdict, Wrong,
};
use crate::calibrate::repeats::Source;
use crate::calibrate::warnings::SETUP;
use crate::listed::listed;
use models::digits::{short, significant};

/// Lines for a person: the answer with the gap before and after, then the evidence, then the caveats. A line is there only
/// if it has numbers.
pub(super) fn summary(diagnosis: &Diagnosis) -> String {
    let misfit = || {
        if diagnosis.misses_first_swings {
            Some(format!(
                "The simulation misses even the first swings by more than a fifth of the motion: {SETUP}."
            ))
        } else {
            wrong(&diagnosis.misfits)
        }
    };
    let lines: Vec<Option<String>> = match diagnosis.verdict {
        Verdict::NothingMissing => vec![
            Some(with_gap("Nothing is missing that these recordings could show.", diagnosis)),
            Some("No effect of the catalogue lowers the gap by more than noise and repeatability explain.".to_owned()),
            remains(diagnosis),
            apart(diagnosis),
        ],
        Verdict::Misstated => vec![
            contradicted(diagnosis).map(|value| with_gap(&format!("A stated value is wrong: {value}."), diagnosis)),
            Some("With the fitted value, nothing else is missing that these recordings could show. Measure it again, or state it otherwise.".to_owned()),
            removed(diagnosis),
            remains(diagnosis),
        ],
        Verdict::Named | Verdict::Class => vec![
            Some(with_gap(&named(diagnosis), diagnosis)),
            removed(diagnosis),
            remains(diagnosis),
            // A class of one effect has it in its first line.
            contradicted(diagnosis)
                .filter(|_| !is_effect_or_statement(diagnosis))
                .map(|value| format!("A stated value may be wrong: {value}. Check it first.")),
            misfit(),
            next_best(diagnosis),
            diagnosis.separating_experiment.as_ref().map(to_tell_apart),
        ],
        Verdict::Incomplete => vec![
            Some(with_gap(&named(diagnosis), diagnosis)),
            removed(diagnosis),
            remains(diagnosis),
            contradicted(diagnosis)
                .map(|value| format!("A stated value may be wrong instead: {value}. Check it first.")),
            loudest(diagnosis).map(look),
            misfit(),
            diagnosis.separating_experiment.as_ref().map(to_tell_apart),
        ],
        Verdict::Unknown => vec![
            Some(with_gap(&missing(diagnosis), diagnosis)),
            misfit(),
            partly(diagnosis),
            diagnosis.description.as_ref().and_then(described),
            loudest(diagnosis).map(look),
            apart(diagnosis),
        ],
    };
    let not_final = diagnosis.cut_short_in_round().filter(|_| diagnosis.verdict != Verdict::Unknown);
    let not_final = not_final.map(|round| format!("Not final: the search was cut short in round {round}. "));
    not_final.unwrap_or_default() + &lines.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

/// An answer with the gap before and after, on one line.
fn with_gap(answer: &str, diagnosis: &Diagnosis) -> String {
    let Some(shares) = &diagnosis.shares else { return answer.to_owned() };
    let has_changed = !diagnosis.effects.is_empty() || diagnosis.verdict == Verdict::Misstated;
    let gap = if has_changed {
        change(shares.before_mm, shares.left_mm)
    } else {
        format!("is {} mm", significant(shares.left_mm, 2))
    };
    format!("{answer} The gap between simulation and recordings {gap}.")
}

/// How a distance changes, mm.
fn change(before: f64, after: f64) -> String {
    let verb = if after > before { "rises" } else { "falls" };
    format!("{verb} from {} to {} mm", significant(before, 2), significant(after, 2))
}

/// Whether the answer is one effect, or a stated value that is wrong in its place.
fn is_effect_or_statement(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::Class && diagnosis.members.is_empty()
}

/// What of the setup a fit moved to its limit or beyond: the worst two, each parameter once.
fn contradicted(diagnosis: &Diagnosis) -> Option<String> {
    let mut seen = HashSet::new();
    let of_each = diagnosis.contradictions.iter().filter(|own| seen.insert(&own.parameter));
    let worst: Vec<String> = of_each.map(Contradiction::told).take(2).collect();
    (!worst.is_empty()).then(|| listed(&worst))
}

/// That something is missing which has no name, or was not looked for.
fn missing(diagnosis: &Diagnosis) -> String {
    let is_unasked = |own: &Evidence| own.rejected.as_deref() == Some(NO_MORE);
    if diagnosis.effects.is_empty() && diagnosis.evidence.iter().any(is_unasked) {
        return "Something is missing; no effect was fitted, because none may be added.".to_owned();
    }
    if let Some(round) = diagnosis.cut_short_in_round() {
        let so_far = if diagnosis.effects.is_empty() {
            ", before it had found an effect."
        } else {
            ". Its best answer so far follows."
        };
        return format!("No final answer: the search was cut short in round {round}{so_far}");
    }
    let or = contradicted(diagnosis)
        .map_or(String::new(), |told| format!(", or a stated value is wrong: {told}. Check it first"));
    format!("Something is missing that no effect of the catalogue explains{or}.")
}

/// A parameter's name as a person says it.
fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// An effect as a person calls it: as its page begins, `Air drag on the body: …`.
fn called(effect: &str) -> String {
    let page = by_name(effect).map(|effect| effect.page());
    let title = page.as_deref().and_then(|page| page.split_once(':'));
    let Some((title, _)) = title else { return plain(effect) };
    let mut letters = title.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn names(diagnosis: &Diagnosis) -> String {
    let is_of_each = |added: &Added| {
        diagnosis
            .evidence
            .iter()
            .any(|own| own.effect == added.effect && own.of_each_pressure && own.rejected.is_none())
    };
    let name = |added: &Added| {
        if is_of_each(added) {
            format!("{} with a different strength at each pressure", called(&added.effect))
        } else {
            called(&added.effect)
        }
    };
    capitalised(&listed(&diagnosis.effects.iter().map(name).collect::<Vec<_>>()))
}

/// Share of the size of the largest misfit from which on another is worth words.
const ALSO: f64 = 0.3;

/// What the simulation does wrong: the largest misfit, and another beside it.
fn wrong(misfits: &[Misfit]) -> Option<String> {
    let first = misfits.first()?;
    let where_and_when = |misfit: &Misfit| {
        let [low, high] = misfit.amplitudes.map(|share| 100.0 * share);
        let (size, range) = match (low, high) {
            (_, 100.0..) => ("large", format!("above {low:.0} %")),
            (low, _) if low <= 100.0 * BANDS[BANDS.len() - 1][0] => ("small", format!("below {high:.0} %")),
            _ => ("middle", format!("{low:.0} to {high:.0} %")),
        };
        format!("at {size} swings ({range} of the largest amplitude)")
    };
    let mut words = format!("The simulation {} {}", does(first.what), where_and_when(first));
    let (own, there) = (first.pressures_pa.len(), first.pressures_there_pa.len());
    if own > 1 && own == there {
        words += ", at all pressures";
    } else if own > 0 && own < there {
        let kilo = |pressure: &f64| format!("{:.0}", 1e-3 * pressure);
        let own: Vec<_> = first.pressures_pa.iter().map(kilo).collect();
        let _ = write!(words, ", most clearly at {} kPa", listed(&own));
    }
    let [cycles, before] = first.cycles;
    if before < 1.0 {
        let _ = write!(words, ", in the first {cycles:.0} cycles");
    } else {
        let _ = write!(words, ", from cycle {:.0} to {:.0}", before + 1.0, before + cycles);
    }
    let another = misfits[1..].iter().find(|other| other.size_mm > ALSO * first.size_mm);
    if let Some(other) = another {
        let _ = if other.amplitudes == first.amplitudes {
            write!(words, "; there it also {}", does(other.what))
        } else {
            write!(words, "; it {} {}", does(other.what), where_and_when(other))
        };
    }
    Some(words + ".")
}

fn does(what: Wrong) -> &'static str {
    match what {
        Wrong::LosesEnergyTooSlowly => "loses energy too slowly",
        Wrong::LosesEnergyTooFast => "loses energy too fast",
        Wrong::SwingsTooSlowly => "swings too slowly",
        Wrong::SwingsTooFast => "swings too fast",
    }
}

/// Values of an effect that are told in a sentence, at most.
const TOLD: usize = 3;

/// What is missing, with its values, and what cannot be told from it.
fn named(diagnosis: &Diagnosis) -> String {
    let others: Vec<_> = diagnosis.members.iter().map(|member| called(&member.effect)).collect();
    let or = if !others.is_empty() {
        format!(", or an effect that these recordings cannot separate from it ({})", others.join(", "))
    } else {
        String::new()
    };
    let statement = contradicted(diagnosis)
        .filter(|_| is_effect_or_statement(diagnosis))
        .map_or(String::new(), |value| format!(" Or a stated value is wrong: {value}; check it first."));
    let is = if diagnosis.effects.len() > 1 { "are" } else { "is" };
    let values: Vec<String> = diagnosis.effects.iter().filter_map(values).collect();
    let values = if values.is_empty() { String::new() } else { format!(": {}", values.join("; ")) };
    format!("{} {is} missing{or}{values}.{statement}", names(diagnosis))
}

/// The values of an effect; nothing where there are too many for a sentence.
fn values(added: &Added) -> Option<String> {
    let told = |value: &ParameterValue| {
        let of = value.of.as_ref().map_or(String::new(), |of| format!(" of {of}"));
        let number = format!("{} {}", short(value.value), value.unit);
        let interval = match value.interval_95 {
            Some([low, high]) => {
                format!(" (95 % interval {} to {})", short(low), short(high))
            }
            None => " (not fitted)".to_owned(),
        };
        format!("{}{of} {}{interval}", plain(&value.name), number.trim_end())
    };
    let few = (1..=TOLD).contains(&added.parameters.len());
    few.then(|| listed(&added.parameters.iter().map(told).collect::<Vec<_>>()))
}

fn percent(share: f64) -> String {
    if share >= 0.995 { "all".to_owned() } else { format!("{:.0} %", 100.0 * share) }
}

fn removed(diagnosis: &Diagnosis) -> Option<String> {
    let shares = diagnosis.shares.as_ref()?;
    let share = shares.removed.filter(|share| *share > 0.0)?;
    let it = if diagnosis.effects.len() > 1 { "They explain" } else { "It explains" };
    let held_out: Vec<&Gap> = diagnosis.gap.iter().filter(|gap| gap.held_out).collect();
    let held_out = shares.removed_held_out.map_or(String::new(), |share| {
        let share = if share > 0.0 { percent(share) } else { "nothing".to_owned() };
        let gap = change(mean(&held_out, |gap| gap.before_mm), mean(&held_out, |gap| gap.after_mm));
        format!(", and {share} on held-out releases, where the gap {gap}")
    });
    Some(format!("{it} {} of the residual beyond noise{held_out}.", percent(share)))
}

/// What remains, beside how well the experiment repeats.
fn remains(diagnosis: &Diagnosis) -> Option<String> {
    let shares = diagnosis.shares.as_ref()?;
    let than = diagnosis.repeats.as_ref().map(|repeats| {
        let size = significant(repeats.distance_mm, 2);
        let releases = diagnosis.gap.iter().filter(|gap| !gap.held_out).count();
        let is_within = shares.left_mm <= repeats.largest_mm(releases);
        let than = if is_within { "no more than" } else { "more than" };
        match repeats.source {
            Source::Stated => format!("{than} the stated repeatability of {size} mm"),
            Source::Measured => {
                let most = significant(repeats.largest_mm(releases), 2);
                format!(
                    "{than} the measured repeatability of {size} mm ({most} mm at 95 %{})",
                    repeats.between()
                )
            }
            Source::Assumed => format!(
                "{than} the repeatability of {size} mm assumed for a single release, 1 % of its motion (state calibrate.repeatability, or repeat the release)"
            ),
        }
    });
    let left = significant(shares.left_mm, 2);
    let than = than.map(|than| format!("The remaining {left} mm are {than}."));
    let more = (diagnosis.verdict == Verdict::Incomplete).then(|| {
        "More than noise remains, here or in held-out releases: a similar effect may act instead, or another one as well."
            .to_owned()
    });
    let both: Vec<String> = [than, more].into_iter().flatten().collect();
    (!both.is_empty()).then(|| both.join(" "))
}

/// What the next best effect would explain in the place of the one that was added.
fn next_best(diagnosis: &Diagnosis) -> Option<String> {
    let [only] = &diagnosis.effects[..] else { return None };
    let is_found = |own: &&Evidence| own.effect == only.effect && own.rejected.is_none();
    let found = diagnosis.evidence.iter().find(is_found)?;
    let (round, own) = (found.round, found.realised_decrease?);
    let first = || diagnosis.evidence.iter().filter(|evidence| evidence.round == round);
    let is_other = |evidence: &&Evidence| {
        evidence.effect != only.effect
            && diagnosis.members.iter().all(|member| member.effect != evidence.effect)
    };
    let kept = first().filter(is_other).filter_map(|other| Some((other, other.realised_decrease?)));
    let (next, kept) = kept.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let share = diagnosis.shares.as_ref()?.removed?.min(1.0) * kept / own;
    (share >= 0.005).then(|| {
        format!("{}, the next best, would explain {}.", capitalised(&called(&next.effect)), percent(share))
    })
}

/// Root mean square of a distance over releases.
fn mean(gaps: &[&Gap], of: fn(&Gap) -> f64) -> f64 {
    (gaps.iter().map(|gap| of(gap).powi(2)).sum::<f64>() / gaps.len() as f64).sqrt()
}

/// Gap between simulation and recordings in the end.
fn apart(diagnosis: &Diagnosis) -> Option<String> {
    let all: Vec<&Gap> = diagnosis.gap.iter().collect();
    (!all.is_empty()).then(|| {
        format!("The residual is {:.2} times the noise; 1 is noise alone.", mean(&all, |gap| gap.after))
    })
}

fn to_tell_apart(separation: &Separation) -> String {
    format!(
        "To separate them, record {}: by simulation, this raises the distance of the nearest two from {:.1} to {:.1} standard deviations.",
        separation.what, separation.distance_now, separation.distance
    )
}

/// What was added on the way to an unknown.
fn partly(diagnosis: &Diagnosis) -> Option<String> {
    if diagnosis.effects.is_empty() {
        return None;
    }
    let removed = diagnosis.shares.as_ref().and_then(|shares| shares.removed);
    let share = removed.filter(|share| *share > 0.0);
    let share = share.map_or("a part".to_owned(), percent);
    let describes = if diagnosis.effects.len() > 1 { "describe" } else { "describes" };
    Some(format!("{} {describes} {share} of it, and need not be its cause.", names(diagnosis)))
}

/// The moment that it would take.
fn described(description: &Description) -> Option<String> {
    let about = by_name(&description.moment.effect)?.about();
    let term = |value: &ParameterValue| {
        let parameter = about.parameters.iter().find(|parameter| parameter.name == value.name)?;
        let number = format!("{} {}", short(value.value), value.unit);
        Some(format!("{} ({})", parameter.meaning, number.trim_end()))
    };
    let terms: Vec<String> = description.moment.parameters.iter().filter_map(term).collect();
    (!terms.is_empty()).then(|| {
        format!(
            "A description, not a cause: a moment at every bend, over EI {}, would explain {} of the residual.",
            listed(&terms),
            percent(description.share)
        )
    })
}

fn look(shape: &Shape) -> String {
    format!(
        "Largest residual pattern: {}, {:.2} mm at the tip, mostly at {:.0} % of the largest amplitude.",
        shape.what,
        shape.size_mm,
        100.0 * shape.at_amplitude
    )
}

/// The shape that stands out most in the last round, if one does.
fn loudest(diagnosis: &Diagnosis) -> Option<&Shape> {
    let last = diagnosis.shapes.iter().map(|shape| shape.round).max()?;
    let own = diagnosis.shapes.iter().filter(|shape| shape.round == last && shape.score > shape.threshold);
    own.max_by(|a, b| a.score.total_cmp(&b.score))
}

#[cfg(test)]
mod tests;
