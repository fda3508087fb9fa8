//! Diagnosis: where simulation and recordings disagree, which effect is missing, and what is left when it
//! is added.
//!
//! A baseline is calibrated with the errors of mesh and step removed. Every candidate of the catalogue is
//! scored at the value where it is off, orthogonally to all that the baseline may still adjust
//! (`score.rs`). Those that promise most are fitted in full, and the one that explains most is added, unless
//! others do as well: then the answer is a class. Releases that are locked away judge it. The search goes on
//! with the larger model until nothing scores.

mod candidate;
mod columns;
mod judge;
mod refit;
mod round;
mod score;
mod section;
pub mod verdict;
mod words;

use crate::calibrate::joint::{Joint, Known};
use crate::calibrate::{CalibrateError, Problem};
pub use section::problem;
pub use verdict::{Diagnosis, Verdict};

use judge::{gaps, judge, judgement};
use round::{Best, round};
use verdict::Added;

/// How a diagnosis is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Probability that a round names something where nothing is missing.
    pub false_alarm: f64,
    /// Effects added at most.
    pub most_effects: usize,
    /// Candidates that are left out.
    pub excluded: Vec<String>,
}

impl Default for Settings {
    /// One in a hundred, three effects.
    fn default() -> Self {
        Self { false_alarm: 0.01, most_effects: 3, excluded: Vec::new() }
    }
}

/// What was found, with the model that has it.
#[derive(Clone)]
pub struct Outcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The problem with the effects in its models and all that was found set.
    pub repaired: Problem,
}

/// Finds what is missing; `tell` hears what is being done, from any thread.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where the baseline cannot be fitted.
pub fn diagnose(
    problem: &Problem,
    settings: &Settings,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Outcome, CalibrateError> {
    let mut diagnosis = Diagnosis { false_alarm: settings.false_alarm, ..Diagnosis::default() };
    let locked = problem.trials.iter().filter(|trial| trial.release.held_out);
    diagnosis.held_out = locked.map(|trial| trial.release.name.clone()).collect();
    let baseline = Joint::search(problem, &|what| tell(&format!("baseline: {what}")))?;
    let before = judgement(&baseline);
    let (mut current, mut known) = (problem.clone(), baseline.known());
    let mut added: Vec<Best> = Vec::new();
    let mut after = judgement(&baseline);
    for number in 1..=settings.most_effects + 1 {
        let larger = current.clone();
        let followed = match number {
            1 => None,
            _ => Joint::follow(&larger, &known, &|_| ())?,
        };
        let fit = followed.as_ref().unwrap_or(&baseline);
        after = judgement(fit);
        let found = round(fit, &current, number, settings, tell)?;
        diagnosis.thresholds.push(found.threshold);
        diagnosis.evidence.extend(found.evidence);
        let Some(best) = found.best else { break };
        if number > settings.most_effects {
            diagnosis.verdict = Verdict::Unknown;
            break;
        }
        if !carries_over(&best) {
            diagnosis.verdict = Verdict::Unknown;
            break;
        }
        (current, known) = (best.refit.problem.clone(), best.refit.known.clone());
        added.push(best);
    }
    diagnosis.gap = gaps(&before, &after, false);
    if let (Some(before), Some(after)) =
        (judge(problem, &baseline.known(), tell)?, judge(&current, &known, tell)?)
    {
        diagnosis.gap.extend(gaps(&before, &after, true));
    }
    conclude(&mut diagnosis, &added);
    diagnosis.warnings = words::warnings(problem);
    set(&mut current, &known);
    diagnosis.summary = words::summary(&diagnosis);
    Ok(Outcome { diagnosis, repaired: current })
}

/// Puts what was found into the models.
fn set(problem: &mut Problem, known: &[Known]) {
    for (t, trial) in problem.trials.iter_mut().enumerate() {
        for known in known {
            if let (true, Ok(k)) = (known.is_of(t, trial), trial.model.index(&known.unknown.name)) {
                let (model, initial) = trial.with(&[(k, known.value())]);
                (trial.model, trial.run.initial) = (model, initial);
            }
        }
    }
}

/// χ² by which an effect may worsen what was locked away before it is disbelieved.
const WORSE: f64 = 9.0;

/// Whether what was locked away agrees.
fn carries_over(best: &Best) -> bool {
    best.held_out.is_none_or(|decrease| decrease > -WORSE)
}

/// From the rounds to the answer.
fn conclude(diagnosis: &mut Diagnosis, added: &[Best]) {
    diagnosis.effects = added
        .iter()
        .map(|best| Added { effect: best.candidate.name().to_owned(), parameters: best.refit.values.clone() })
        .collect();
    if let Some(ambiguous) = added.iter().find(|best| !best.members.is_empty()) {
        diagnosis.members = ambiguous.members.clone();
    }
    if diagnosis.verdict != Verdict::Unknown && !added.is_empty() {
        diagnosis.verdict = if diagnosis.members.is_empty() { Verdict::Named } else { Verdict::Class };
    }
}
