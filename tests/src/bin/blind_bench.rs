//! Blind bench of the diagnosis: experiments drawn by the twin, with one effect hidden in each or none,
//! are diagnosed, and what is said is counted.
//!
//! `cargo run --release -p tests --bin blind_bench -- [FIRST SEED] [SETS OF EACH] [SIZE] [KIND…]`; a size of
//! 1 is what one would expect of a muscle, kinds are names of effects, or `nothing`. With
//! `BLIND_BENCH_TELLS=1` it says what it is doing.

use std::collections::BTreeMap;
use std::time::Instant;

use models::effects::by_name;
use sim::diagnose::{Diagnosis, Settings, Verdict, diagnose};
use tests::blind::problem;
use tests::twin::drawn::Plan;
use tests::twin::hidden::{self, Hidden};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| words.get(k).and_then(|word| word.parse::<f64>().ok());
    let (first, sets) = (number(0).unwrap_or(1.0) as u64, number(1).unwrap_or(1.0) as u64);
    let kinds = hidden::all(number(2).unwrap_or(1.0));
    let is_asked = |name: &str| words.len() < 4 || words[3..].iter().any(|word| word == name);
    let nothing = std::iter::once(("nothing", None));
    let begin = Instant::now();
    let mut tally = BTreeMap::new();
    let is_told = std::env::var_os("BLIND_BENCH_TELLS").is_some();
    let tell = |what: &str| {
        if is_told {
            eprintln!("{:8.1} s  {what}", begin.elapsed().as_secs_f64());
        }
    };
    for (name, hidden) in nothing.chain(kinds.map(|(name, hidden)| (name, Some(hidden)))) {
        if !is_asked(name) {
            continue;
        }
        for seed in first..first + sets {
            let hidden: Vec<Hidden> = hidden.iter().cloned().collect();
            let problem = problem(&Plan::usual(&hidden).draw(seed));
            let begin = Instant::now();
            let how = match diagnose(&problem, &Settings::default(), &tell) {
                Ok(outcome) => {
                    report(name, seed, &outcome.diagnosis, begin.elapsed().as_secs_f64());
                    right(name, &outcome.diagnosis)
                }
                Err(error) => {
                    println!("{name:18} {seed:4}  {error}");
                    "failed"
                }
            };
            *tally.entry(how).or_insert(0) += 1;
        }
    }
    println!("{tally:?} in {:.0} s", begin.elapsed().as_secs_f64());
}

/// What the answer is worth.
fn right(name: &str, diagnosis: &Diagnosis) -> &'static str {
    let is_first = diagnosis.effects.first().is_some_and(|added| added.effect == name);
    let is_member = diagnosis.members.iter().any(|member| member.effect == name);
    let is_in_catalogue = by_name(name).is_some();
    match diagnosis.verdict {
        Verdict::NothingMissing if name == "nothing" => "nothing, and rightly",
        Verdict::NothingMissing => "missed",
        Verdict::Unknown if name != "nothing" && !is_in_catalogue => "unknown, and rightly",
        Verdict::Unknown => "unknown, wrongly",
        Verdict::Named if is_first && diagnosis.effects.len() == 1 => "named",
        Verdict::Named | Verdict::Class if is_first => "first of several",
        Verdict::Class if is_member => "in the class",
        _ => "wrong name",
    }
}

fn report(name: &str, seed: u64, diagnosis: &Diagnosis, seconds: f64) {
    let said: Vec<&str> = match diagnosis.verdict {
        Verdict::NothingMissing => vec!["nothing"],
        Verdict::Unknown => vec!["unknown"],
        _ => diagnosis.effects.iter().map(|added| added.effect.as_str()).collect(),
    };
    let members: Vec<&str> = diagnosis.members.iter().map(|member| member.effect.as_str()).collect();
    let mean = |of: fn(&sim::diagnose::verdict::Gap) -> f64, held_out: bool| {
        let all: Vec<f64> = diagnosis.gap.iter().filter(|gap| gap.held_out == held_out).map(of).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    println!(
        "{name:18} {seed:4}  {:40} class {:40} gap {:.3} to {:.3}, locked {:.3} to {:.3}  {seconds:.1} s",
        said.join(" + "),
        members.join(", "),
        mean(|gap| gap.before, false),
        mean(|gap| gap.after, false),
        mean(|gap| gap.before, true),
        mean(|gap| gap.after, true),
    );
    if let Some(separation) = &diagnosis.separating_experiment {
        println!("      {}: {:.1} to {:.1}", separation.what, separation.distance_now, separation.distance);
    }
    for shape in diagnosis.shapes.iter().filter(|shape| shape.score > shape.threshold) {
        println!(
            "      round {}: {}: {:.2} of {:.2}, {:.3} mm at {:.2} of the amplitude",
            shape.round, shape.what, shape.score, shape.threshold, shape.size_mm, shape.at_amplitude
        );
    }
    let mut evidence: Vec<_> = diagnosis.evidence.iter().filter(|evidence| evidence.round == 1).collect();
    evidence.sort_by(|a, b| b.score.total_cmp(&a.score));
    for evidence in evidence.iter().take(6) {
        println!(
            "      {:20} score {:7.2} of {:.2}  promises {:8.1}  keeps {:8.1}  strength {:.3e}  {}",
            evidence.effect,
            evidence.score,
            diagnosis.thresholds[0],
            evidence.predicted_decrease,
            evidence.realised_decrease.unwrap_or(f64::NAN),
            evidence.strength,
            evidence.rejected.as_deref().unwrap_or("chosen"),
        );
    }
}
