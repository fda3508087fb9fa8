//! Diagnosis: where simulation and recordings disagree, which effect is missing, and what is left when it
//! is added.
//!
//! A baseline is calibrated with the errors of mesh and step removed. The residual is asked for shapes before
//! any name (`localise.rs`), and every candidate of the catalogue is scored at the value where it is off,
//! orthogonally to all that the baseline may still adjust (`score.rs`). Those that promise most are fitted
//! roughly, the best of them in full, and the one that explains most is added, unless others do as well: then
//! the answer is a class, with the recording that would tell them apart (`planned.rs`). Releases that are
//! locked away judge it. The search goes on with the larger model until nothing scores; what became idle is
//! left out again (`idle.rs`). Where a candidate or a
//! shape stands out that no effect explains, the answer is that something unknown is missing.

mod candidate;
mod columns;
pub mod curve;
mod idle;
mod judge;
pub mod localise;
pub mod misfit;
pub mod plan;
mod planned;
mod refit;
mod round;
mod score;
mod section;
mod swing;
pub mod verdict;
mod words;

use crate::calibrate::joint::{Joint, Known};
use crate::calibrate::{CalibrateError, Problem};
pub use curve::Curve;
pub use section::{admit_tilt, problem};
pub use verdict::{Diagnosis, Verdict};

use curve::curves;
use idle::without_idle;
use judge::{Judgement, gaps, judge, judgement};
use planned::separation;
use round::{Best, Heard, round};
use verdict::{Added, Evidence};

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
    /// Each track of each release as it was measured, and as it is predicted before and after; first those
    /// that were fitted.
    pub curves: Vec<Curve>,
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
    let locked_before = judge(problem, &baseline.known(), baseline.cost(), tell)?;
    let (mut current, mut known) = (problem.clone(), baseline.known());
    let mut added: Vec<Box<Best>> = Vec::new();
    let mut after = None;
    for number in 1..=settings.most_effects + 1 {
        let followed = match added.is_empty() {
            true => None,
            false => Joint::follow(&current, &known, &|_| ())?,
        };
        let fit = followed.as_ref().unwrap_or(&baseline);
        let met = after.insert(judgement(fit));
        diagnosis.gap = gaps(&before, met, false);
        diagnosis.effects = added.iter().map(|best| Added::of(fit, &best.candidate)).collect();
        let found = round(fit, &current, locked_by(&added, &locked_before), number, settings, tell)?;
        diagnosis.thresholds.push(found.threshold);
        diagnosis.evidence.extend(found.evidence);
        let is_shaped = found.shapes.iter().any(|shape| shape.score > shape.threshold);
        diagnosis.shapes.extend(found.shapes);
        match found.heard {
            Heard::Effect(best) if number <= settings.most_effects => {
                drop(followed);
                (current, known) = (best.refit.problem.clone(), best.refit.known.clone());
                added.push(best);
            }
            Heard::Effect(best) => {
                diagnosis.warnings.push(format!(
                    "{} would come next, and is not in the repaired model: --most {} ends the search here",
                    best.candidate.name(),
                    settings.most_effects
                ));
                break;
            }
            Heard::Nothing if !is_shaped => break,
            Heard::Nothing | Heard::Stranger => {
                diagnosis.verdict = Verdict::Unknown;
                break;
            }
        }
    }
    let mut cost = added.last().map_or(baseline.cost(), |best| best.refit.cost);
    while let Some(lean) = without_idle(problem, &added, &known, cost)? {
        let idle = added.remove(lean.left_out);
        tell(&format!("{} became idle", idle.candidate.name()));
        let of_idle = |evidence: &&mut Evidence| evidence.effect == idle.candidate.name();
        for evidence in diagnosis.evidence.iter_mut().filter(of_idle) {
            evidence.rejected.get_or_insert_with(|| "it became idle beside the others".to_owned());
        }
        let judgement = judge(&lean.problem, &lean.known, lean.cost, tell)?;
        added.last_mut().expect("one is left").judgement = judgement;
        diagnosis.gap = gaps(&before, after.insert(lean.judgement), false);
        (diagnosis.effects, cost) = (lean.effects, lean.cost);
        (current, known) = (lean.problem, lean.known);
    }
    if let (Some(before), Some(after)) = (&locked_before, locked_by(&added, &locked_before)) {
        diagnosis.gap.extend(gaps(before, after, true));
    }
    let fitted = after.as_ref().map(|after| (&before, after, false));
    let locked = locked_before.as_ref().zip(locked_by(&added, &locked_before));
    let locked = locked.map(|(before, after)| (before, after, true));
    let curves = curves(&fitted.into_iter().chain(locked).collect::<Vec<_>>());
    diagnosis.misfits = misfit::misfits(&curves);
    let ambiguous = added.iter().find(|best| !best.members.is_empty());
    if let Some(best) = ambiguous.filter(|_| diagnosis.verdict != Verdict::Unknown) {
        diagnosis.members = best.members.iter().map(|(member, _)| member.clone()).collect();
        let (nearest, other) = &best.members[0];
        let pair = [best.candidate.clone(), other.clone()];
        let strength = best.refit.values.first().map_or(best.candidate.off, |value| value.value);
        tell("which recording would tell them apart");
        diagnosis.separating_experiment =
            separation(problem, &known, &pair, strength, best.widening, nearest.distance);
    }
    if diagnosis.verdict != Verdict::Unknown && !added.is_empty() {
        diagnosis.verdict = if diagnosis.members.is_empty() { Verdict::Named } else { Verdict::Class };
    }
    diagnosis.warnings.extend(words::warnings(problem));
    diagnosis.warnings.extend(words::strained(&known));
    set(&mut current, &known);
    diagnosis.summary = words::summary(&diagnosis);
    Ok(Outcome { diagnosis, repaired: current, curves })
}

/// How the model with all that was added meets what was locked away.
fn locked_by<'a>(added: &'a [Box<Best>], before: &'a Option<Judgement>) -> Option<&'a Judgement> {
    added.last().map_or(before.as_ref(), |best| best.judgement.as_ref())
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
