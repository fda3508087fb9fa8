//! Diagnosis: where simulation and recordings disagree, which effect is missing, and what remains when it is added.
//!
//! A baseline is calibrated with the errors of mesh and step removed, on a mesh fine enough for that
//! (`mesh_check.rs`). The residual is searched for patterns before any name (`localise.rs`). Every candidate of the
//! catalogue is scored at the value where it is off, orthogonally to all that the baseline may still adjust
//! (`score.rs`). Those with the largest predicted gain are fitted roughly, the best of them in full. The one that
//! explains most is added, unless others do as well: then the answer is a class, with the recordings that separate it
//! (`planned.rs`). Held-out releases validate the answer (`validation.rs`).
//!
//! The search goes on with the larger model until nothing scores. Effects that became unnecessary are removed
//! (`prune.rs`). An effect whose strength would have to differ between releases is not accepted (`constancy.rs`).
//! Where a candidate or a pattern remains that no effect explains, something unknown is missing, and a moment
//! describes it (`describe.rs`). Before that the search is repeated with effects of the rod's material that differ in
//! strength from pressure to pressure. Where the baseline misses even the first swings, scores say nothing, and
//! candidates are fitted to these (`first_swings.rs`).

mod before;
mod between;
pub(crate) mod candidate;
mod conclude;
mod constancy;
pub mod curve;
pub mod describe;
mod design_matrix;
mod extra;
mod first_swings;
pub mod localise;
pub mod mesh_check;
pub mod misfit;
pub mod plan;
mod planned;
mod prune;
mod refit;
mod round;
mod score;
pub(crate) mod section;
mod settings;
mod setup;
mod share;
mod shortlist;
mod stated;
mod stop;
mod summary_text;
mod swing;
mod threshold;
mod validation;
pub mod verdict;
mod warnings;

use efam_core::forward::Cancel;
use efam_core::work::Work;
use models::muscle;

use crate::calibrate::joint::Joint;
use crate::calibrate::repeats::Repeats;
use crate::calibrate::{CalibrateError, Problem};
pub use curve::Curve;
pub use section::{admit_tilt, known_effects, problem};
pub use settings::{DiagnosisSettings, USUAL_BUDGET};
pub use stated::without;
pub use verdict::{Diagnosis, Verdict};

use before::Before;
use candidate::has_several_pressures;
use curve::{Agreement, curves};
use round::{Round, RoundRequest, round};
use setup::Lift;
use share::Step;
use shortlist::{Best, RoundOutcome};
use stop::{counted, ending_by};
use validation::{HeldOut, agreement, gaps};
use verdict::{Added, Evidence, Gap};

/// Who hears how a diagnosis goes on, from any thread. A closure hears what is being done.
pub trait Listener: Sync {
    /// What is being done.
    fn doing(&self, what: &str);

    /// Candidates of one round as they stand, beside the score that they have to exceed: all of them when
    /// they are scored, one when it was fitted, all when the round is over.
    fn ranked(&self, _threshold: f64, _candidates: &[Evidence]) {}

    /// The baseline is fitted: from here on a search that is cut short has an answer.
    fn began(&self) {}

    /// A request to end the search at the next opportunity, with what was found by then.
    fn stop(&self) -> Cancel {
        Cancel::default()
    }
}

impl<F: Fn(&str) + Sync> Listener for F {
    fn doing(&self, what: &str) {
        self(what);
    }
}

/// What was found, with the model that has it.
#[derive(Clone)]
pub struct DiagnosisOutcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The problem with what was found before anything was added set in its models.
    pub baseline: Problem,
    /// The same with the effects in its models.
    pub repaired: Problem,
    /// How well its parameters are known.
    pub errors: muscle::Known,
    /// Each track of each release as it was measured, and as it is predicted before and after; first those
    /// that were fitted.
    pub curves: Vec<Curve>,
}

/// Finds what is missing.
/// # Errors
/// [`CalibrateError`] for a problem that makes no sense, and where the baseline cannot be fitted.
pub fn diagnose(
    problem: &Problem,
    settings: &DiagnosisSettings,
    listener: &dyn Listener,
) -> Result<DiagnosisOutcome, CalibrateError> {
    listener.doing("releases of one condition");
    let repeats = Repeats::of(problem, settings.repeatability);
    let heard =
        repeats.as_ref().filter(|repeats| repeats.is_known()).map(|repeats| repeats.heard_in(problem));
    let work = Work::limited(settings.budget);
    let mut problem = counted(&heard.unwrap_or_else(|| problem.clone()), &work);
    section::limit(&mut problem);
    let problem = &problem;
    let DiagnosisSettings { false_alarm, budget, .. } = *settings;
    let mut diagnosis = Diagnosis { false_alarm, budget, repeats, ..Diagnosis::default() };
    listener.doing("the first swings");
    let before = match first_swings::before(problem)? {
        Some(before) => before,
        None => Before::searched(problem, listener, &mut diagnosis)?,
    };
    diagnosis.misses_first_swings = before.first_swings.is_some();
    let searched;
    listener.began();
    let mut course = Course::new(&before, settings, listener, diagnosis);
    if let Some(alone) = course.misstated_alone()? {
        return concluded(alone, &work);
    }
    course.search()?;
    // Two missing effects may meet the first swings only together. Then the whole recordings are searched. Scores are unreliable where the
    // phase is lost, so that answer counts only if its residual is noise or does not repeat.
    if course.misses_first_swings_with_each()
        && course.may_search("a search of the whole recordings for several effects")
    {
        let mut diagnosis = Diagnosis { verdict: Verdict::default(), ..course.diagnosis.clone() };
        if let Some(before) = CalibrateError::if_run(Before::searched(problem, listener, &mut diagnosis))? {
            searched = before;
            let mut whole = Course::new(&searched, settings, listener, diagnosis);
            whole.search()?;
            if whole.diagnosis.verdict != Verdict::Unknown && whole.is_within_noise() {
                course = whole;
            } else {
                course.diagnosis.cut_short = whole.diagnosis.cut_short;
            }
        }
    }
    let is_unknown = course.diagnosis.verdict == Verdict::Unknown && settings.most_effects > 0;
    let second = "second search, with a strength for each pressure";
    if is_unknown && has_several_pressures(problem) && course.may_search(second) {
        listener.doing(second);
        course = course.widened()?;
    }
    course.keep_what_explains_most()?;
    concluded(course, &work)
}

/// The answer of a search, with the work that it took.
fn concluded(course: Course, work: &Work) -> Result<DiagnosisOutcome, CalibrateError> {
    let mut outcome = course.conclude()?;
    outcome.diagnosis.node_steps = work.node_steps();
    Ok(outcome)
}

/// Effects beside which still more is heard, and which then are not believed: with so many, similar effects to
/// what is missing describe a good part of it.
const TOO_MANY: usize = 3;

/// A diagnosis on its way.
struct Course<'a> {
    /// On a mesh that is fine enough, without anything added.
    problem: Problem,
    settings: &'a DiagnosisSettings,
    listener: &'a dyn Listener,
    before: &'a Before,
    /// The model with all that was added, fitted; its cost, and how it meets what it was fitted to.
    model: Joint,
    cost: f64,
    after: Agreement,
    added: Vec<Best>,
    /// The baseline with each belief lifted that stands at its limit.
    lifts: Vec<Lift>,
    /// How the model meets held-out releases with a belief lifted for good.
    lifted_held_out: Option<HeldOut>,
    /// The first round, where it was made to compare a wrong statement with effects.
    first_round: Option<Round>,
    /// The model after each of them.
    steps: Vec<Step>,
    /// Whether a candidate or a shape exceeds its threshold beside what was added.
    is_more_heard: bool,
    /// Whether effects of the rod's material have a strength for each pressure.
    is_widened: bool,
    diagnosis: Diagnosis,
}

impl<'a> Course<'a> {
    fn new(
        before: &'a Before,
        settings: &'a DiagnosisSettings,
        listener: &'a dyn Listener,
        diagnosis: Diagnosis,
    ) -> Self {
        Self {
            problem: before.model.problem.clone(),
            settings,
            listener,
            before,
            model: before.model.clone(),
            cost: before.cost,
            after: before.fitted.clone(),
            added: Vec::new(),
            lifts: Vec::new(),
            lifted_held_out: None,
            first_round: None,
            steps: Vec::new(),
            is_more_heard: false,
            is_widened: false,
            diagnosis,
        }
    }

    /// Adds effect after effect while something speaks, prunes, and says whether that is an answer.
    fn search(&mut self) -> Result<(), CalibrateError> {
        if let Some(first_swings) = &self.before.first_swings
            && !self.add_by_first_swings(first_swings)?
        {
            self.diagnosis.verdict = Verdict::Unknown;
            return Ok(());
        }
        let mut kept_out = self.add_pruned()?;
        // A pruned effect makes room for another. Only once: two effects might replace each other for ever.
        if kept_out.is_some() && self.added.len() < self.settings.most_effects {
            kept_out = self.add_pruned()?;
        }
        if let Some(effect) = kept_out {
            self.end_at_limit(effect);
        }
        let misstated = self.misstated()?;
        let is_cut_short = self.diagnosis.cut_short_in_round().is_some();
        let is_within = !self.added.is_empty() && self.is_within_repeats()?;
        let is_misstated = misstated.as_ref().is_some_and(|own| own.leads);
        self.diagnosis.verdict = match (is_misstated, self.diagnosis.verdict) {
            // What is stated is wrong, and then nothing may be missing.
            (true, _) => Verdict::Unknown,
            _ if is_within => Verdict::Named,
            // What was not asked may be what is missing.
            _ if is_cut_short => Verdict::Unknown,
            // What is far beyond the noise and what repeats is there, whatever speaks of it.
            (_, Verdict::NothingMissing) if self.added.is_empty() && !self.is_within_noise() => {
                Verdict::Unknown
            }
            (_, verdict) if verdict == Verdict::Unknown || self.added.is_empty() => verdict,
            _ => {
                // A law that is not quite right leaves more than noise.
                match (self.is_believed()?, self.is_more_heard || self.is_missed()) {
                    (true, false) => Verdict::Named,
                    (true, true) => Verdict::Incomplete,
                    (false, _) => Verdict::Unknown,
                }
            }
        };
        // Neither the effect nor the statement leads.
        if misstated.is_some() && self.diagnosis.verdict == Verdict::Named {
            self.diagnosis.verdict = Verdict::Class;
        }
        self.diagnosis.contradictions = misstated.map_or(Vec::new(), |own| own.values);
        Ok(())
    }

    /// Whether no effect alone brings the model to meet the first swings.
    fn misses_first_swings_with_each(&self) -> bool {
        let is_lost = self.before.first_swings.is_some() && self.added.is_empty();
        is_lost && self.settings.most_effects > 0 && self.diagnosis.cut_short_in_round().is_none()
    }

    /// Adds effects, then prunes; returns the effect that [`Course::add_all`] returns.
    fn add_pruned(&mut self) -> Result<Option<&'static str>, CalibrateError> {
        let kept_out = self.add_all()?;
        let is_complete = self.diagnosis.cut_short_in_round().is_none();
        if is_complete
            && self.added.len() > 1
            && self.may_search("a test which of the effects are unnecessary")
        {
            self.prune()?;
        }
        Ok(kept_out)
    }

    /// Adds effects while one scores above the threshold; returns the next one where the limit keeps it out.
    fn add_all(&mut self) -> Result<Option<&'static str>, CalibrateError> {
        for place in self.added.len()..=self.settings.most_effects {
            if !self.added.is_empty() && self.is_within_repeats()? {
                return Ok(None);
            }
            let (number, is_widened) = (self.diagnosis.thresholds.len() + 1, self.is_widened);
            let request = RoundRequest { number, is_last: place == self.settings.most_effects, is_widened };
            let found = match self.first_round.take().filter(|_| number == 1) {
                Some(found) => found,
                None if self.is_stopped() => {
                    self.cut_short_before(number);
                    return Ok(None);
                }
                None => match self.round(request)? {
                    Some(found) => found,
                    None => {
                        self.cut_short_before(number);
                        return Ok(None);
                    }
                },
            };
            self.cut_short_in(number, &found.evidence);
            self.diagnosis.thresholds.push(found.threshold);
            self.diagnosis.evidence.extend(found.evidence);
            self.diagnosis.shapes.extend(found.shapes);
            self.is_more_heard = found.is_heard;
            self.diagnosis.warnings.extend(found.negligible.map(|effect| {
                format!("{effect} scores as well, at less than a tenth of the size of what was found: it cannot be separated from an error of that law")
            }));
            match found.outcome {
                RoundOutcome::Effect(best) => self.add(best)?,
                RoundOutcome::LimitReached(effect) => return Ok(Some(effect)),
                RoundOutcome::Nothing if !found.is_shaped => return Ok(None),
                RoundOutcome::Nothing | RoundOutcome::Unexplained => {
                    self.diagnosis.verdict = Verdict::Unknown;
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }

    /// Warns that the limit kept an effect out.
    fn end_at_limit(&mut self, effect: &str) {
        let most = self.settings.most_effects;
        self.diagnosis.warnings.push(format!(
            "the repaired model lacks {effect} or another effect, because --most {most} ended the search"
        ));
        if most >= TOO_MANY || self.added.is_empty() {
            self.diagnosis.verdict = Verdict::Unknown;
        }
    }

    /// Looks for one more effect; none where the search was interrupted before a candidate could be fitted.
    fn round(&self, request: RoundRequest) -> Result<Option<Round>, CalibrateError> {
        let (held_out, settings) = (self.held_out(), self.settings);
        match round(&self.ending()?, held_out, &self.added, request, settings, self.listener) {
            Err(CalibrateError::NoFit { .. } | CalibrateError::Forward { .. }) if self.is_interrupted() => {
                Ok(None)
            }
            found => found.map(Some),
        }
    }

    fn add(&mut self, best: Box<Best>) -> Result<(), CalibrateError> {
        let mut best = self.lasting(best)?;
        self.model = best.refit.fitted.clone();
        self.cost = best.refit.cost;
        // It may be there already, with one strength for all pressures.
        let name = best.candidate.name();
        if let Some(place) = self.added.iter().position(|added| added.candidate.name() == name) {
            best.widen(self.added.remove(place));
        }
        self.added.push(*best);
        self.tell();
        self.remember();
        Ok(())
    }

    /// A model that was found in a search which may be asked to end: its own runs do not end, and it meets held-out
    /// releases.
    fn lasting(&self, mut best: Box<Best>) -> Result<Box<Best>, CalibrateError> {
        let lasting = ending_by(&best.refit.fitted.problem, &Cancel::default());
        best.refit.fitted = best.refit.fitted.with_problem(lasting)?;
        if best.held_out.is_none() && self.is_interrupted() {
            best.held_out = HeldOut::meet(&best.refit.fitted.problem, &best.refit.known)?;
        }
        Ok(best)
    }

    /// Says which values the effects have in the model as it is, and how it meets what it was fitted to.
    fn tell(&mut self) {
        let of = |best: &Best| Added::of(&self.model, &best.candidate);
        self.diagnosis.effects = self.added.iter().map(of).collect();
        self.after = agreement(&self.model);
    }

    /// The same search with strengths that differ from pressure to pressure, if that has an answer; or else
    /// this, with the evidence of both.
    fn widened(mut self) -> Result<Self, CalibrateError> {
        let own = &self.diagnosis;
        let diagnosis = Diagnosis {
            false_alarm: own.false_alarm,
            budget: own.budget,
            numerics: own.numerics.clone(),
            evidence: own.evidence.clone(),
            thresholds: own.thresholds.clone(),
            shapes: own.shapes.clone(),
            repeats: own.repeats.clone(),
            misses_first_swings: own.misses_first_swings,
            ..Diagnosis::default()
        };
        let mut wider = Self::new(self.before, self.settings, self.listener, diagnosis);
        wider.is_widened = true;
        wider.lifts.clone_from(&self.lifts);
        wider.search()?;
        if wider.added.is_empty() || wider.diagnosis.verdict == Verdict::Unknown {
            for evidence in wider.diagnosis.evidence.iter_mut().skip(self.diagnosis.evidence.len()) {
                evidence
                    .rejected
                    .get_or_insert_with(|| "with it something else would still be missing".to_owned());
            }
            self.diagnosis.evidence = wider.diagnosis.evidence;
            self.diagnosis.thresholds = wider.diagnosis.thresholds;
            self.diagnosis.cut_short = wider.diagnosis.cut_short;
            return Ok(self);
        }
        Ok(wider)
    }

    /// Gaps before and after of what was fitted and held-out releases, and the curves behind them.
    fn gaps(&self) -> (Vec<Gap>, Vec<Curve>) {
        let mut pairs = vec![(&self.before.fitted, &self.after, false)];
        let held_out = self.before.held_out.as_ref().zip(self.held_out());
        pairs.extend(held_out.map(|(before, after)| (&before.agreement, &after.agreement, true)));
        let gap = pairs.iter().flat_map(|(before, after, held_out)| gaps(before, after, *held_out));
        (gap.collect(), curves(&pairs))
    }

    /// How the model with all that was added or lifted meets held-out releases.
    fn held_out(&self) -> Option<&HeldOut> {
        let before = || self.lifted_held_out.as_ref().or(self.before.held_out.as_ref());
        self.added.last().map_or_else(before, |best| best.held_out.as_ref())
    }
}
