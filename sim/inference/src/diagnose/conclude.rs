//! What a diagnosis comes to: its words, its warnings, and the models with what was found.

use rayon::prelude::*;

use super::between::between_releases;
use super::candidate::Candidate;
use super::describe::describe;
use super::refit::errors;
use super::stop::ending_by;
use super::validation::{HeldOut, pose, set};
use super::verdict::{Added, Shares, Verdict};
use super::warnings::{contradictions, warnings};
use super::{Course, DiagnosisOutcome, first_swings, misfit, summary_text};
use crate::calibrate::CalibrateError;
use crate::calibrate::discrepancy::heard;
use crate::calibrate::joint::Joint;
use crate::calibrate::refine::{MOST_ROUNDS, RESOLUTION_FITTED};

impl Course<'_> {
    /// Says what it all comes to.
    pub(super) fn conclude(mut self) -> Result<DiagnosisOutcome, CalibrateError> {
        self.weigh()?;
        let between = self.between_releases()?;
        let (known, errors) = (self.model.known(), errors(&self.model, &between));
        let (gap, curves) = self.gaps();
        match self.diagnosis.verdict {
            // A phase that is lost has no moment that describes it.
            Verdict::Unknown if self.before.first_swings.is_some() && self.added.is_empty() => {}
            Verdict::Unknown => {
                if self.may_add_to_answer("a moment that describes the residual") {
                    let (ending, level) = (self.ending()?, self.settings.false_alarm);
                    let tell = |what: &str| self.listener.doing(what);
                    self.diagnosis.description = describe(&ending, level, &tell)?;
                }
            }
            _ => {
                if !self.added.is_empty() && self.may_add_to_answer("intervals from the profile likelihood") {
                    self.listener.doing("intervals");
                    self.profile(&between)?;
                }
                self.tell_apart(&known);
            }
        }
        self.diagnosis.gap = gap;
        self.diagnosis.shares = Some(Shares::of(&self.diagnosis.gap));
        let held_out = self.problem.trials.iter().filter(|trial| trial.release.held_out);
        self.diagnosis.held_out = held_out.map(|trial| trial.release.name.clone()).collect();
        if self.before.first_swings.is_some() {
            self.diagnosis.warnings.push(first_swings::WARNING.to_owned());
        }
        if !self.diagnosis.misses_first_swings {
            self.diagnosis.misfits = misfit::misfits(&curves);
        }
        if self.diagnosis.contradictions.is_empty() {
            self.diagnosis.contradictions = contradictions(known.iter().map(|own| (own, own)));
        }
        let warnings = warnings(&self.diagnosis, &self.problem, &known);
        self.diagnosis.warnings.extend(warnings);
        self.diagnosis.summary = summary_text::summary(&self.diagnosis);
        // What was fitted comes last: a pressure may have releases of both kinds.
        let of_held_out = |held_out: Option<&HeldOut>| held_out.map_or(Vec::new(), HeldOut::known);
        let (before, after) = (of_held_out(self.before.held_out.as_ref()), of_held_out(self.held_out()));
        let (mut baseline, mut repaired) = (self.problem, self.model.problem);
        for known in [&before, &self.before.known] {
            set(&mut baseline, known);
            pose(&mut baseline, known);
        }
        for known in [&after, &known] {
            set(&mut repaired, known);
            pose(&mut repaired, known);
        }
        Ok(DiagnosisOutcome { diagnosis: self.diagnosis, baseline, repaired, errors, curves })
    }

    /// Fits an answer that misses more than noise and what does not repeat anew, with its samples weighed by what it
    /// misses: a fit to that as to noise would move the strengths.
    fn weigh(&mut self) -> Result<(), CalibrateError> {
        let is_weighed = !self.added.is_empty() && !self.is_within_noise();
        if !is_weighed || !self.may_add_to_answer("a fit with samples weighed by their residuals") {
            return Ok(());
        }
        let stop = self.listener.stop();
        for _ in 0..MOST_ROUNDS {
            let Some(problem) = heard(&self.model) else { break };
            let stopped = ending_by(&problem, &stop);
            let Some(fit) = Joint::follow(&stopped, &self.model.known(), RESOLUTION_FITTED)? else { break };
            self.model = fit.with_problem(problem)?;
        }
        let known = self.model.known();
        if let Some(last) = self.added.last_mut() {
            last.held_out = HeldOut::meet(&self.model.problem, &known)?;
        }
        self.tell();
        Ok(())
    }

    /// The standard error of each unknown from differences between releases, held-out ones included.
    fn between_releases(&mut self) -> Result<Vec<f64>, CalibrateError> {
        let has_intervals = !self.added.is_empty() && self.diagnosis.verdict != Verdict::Unknown;
        if !has_intervals || !self.may_add_to_answer("differences between releases, in the intervals") {
            return Ok(vec![0.0; self.model.found.x.len()]);
        }
        let all = self.held_out().map(|held_out| held_out.together(&self.model)).transpose()?.flatten();
        let candidates = self.added.iter().map(|best| &best.candidate);
        Ok(between_releases(&self.model, all.unwrap_or(&self.model), candidates))
    }

    /// Bounds of what is badly known, from the profile of the likelihood.
    fn profile(&mut self, between: &[f64]) -> Result<(), CalibrateError> {
        let fit = self.ending()?;
        let candidates: Vec<_> = self.added.iter().map(|best| &best.candidate).collect();
        let profiled = |candidate: &&Candidate| Added::profiled(&fit, candidate, between);
        self.diagnosis.effects = candidates.par_iter().map(profiled).collect();
        Ok(())
    }
}
