//! A diagnosis while it works: what is being done, and the candidates as they stand.

use std::collections::BTreeMap;
use std::fmt::Write;

use ::rerun::external::re_sdk_types::components::MediaType;
use ::rerun::{RecordingStream, RecordingStreamResult, TextDocument, TextLog};
use efam_inference::diagnose::verdict::Evidence;
use efam_inference::diagnose::{Diagnosis, DiagnosisOutcome};

use super::compared::{draw, lay_out};
use super::entities::TIMELINE;
use super::tree::{self, ContainerKind, Tree, under};

/// Counts what was said.
pub(super) const STEP: &str = "step";
const LOG: &str = "search/log";
const RANKING: &str = "search/ranking";
const ANSWER: &str = "search/answer";

/// Candidates shown of a round.
const SHOWN: usize = 12;
/// Letters of the longest bar.
const LONGEST: f64 = 24.0;

/// The steps of a search, counted as they are shown.
pub(super) struct Steps {
    /// Whether a viewer follows.
    pub live: bool,
    count: i64,
}

impl Steps {
    /// Sends name and layout.
    pub fn begin(
        recording: &RecordingStream,
        (name, live): (&str, bool),
        number: u128,
        layout: impl FnOnce(&mut Tree) -> RecordingStreamResult<()>,
    ) -> RecordingStreamResult<Self> {
        recording.send_recording_name(name)?;
        tree::send(recording, number, STEP, live, layout)?;
        Ok(Self { live, count: 0 })
    }

    pub fn next(&mut self, recording: &RecordingStream) {
        self.count += 1;
        recording.set_time_sequence(STEP, self.count);
    }

    /// A step that says what is being done.
    pub fn doing(&mut self, recording: &RecordingStream, log: &str, what: &str) -> RecordingStreamResult<()> {
        self.next(recording);
        recording.log(log, &TextLog::new(what))
    }
}

/// What of a diagnosis was shown.
pub struct Search {
    steps: Steps,
    /// Of each round its threshold and its candidates, as they were told last.
    rounds: BTreeMap<usize, (f64, Vec<Evidence>)>,
}

impl Search {
    /// Sends name and layout.
    pub(super) fn begin(recording: &RecordingStream, name: &str, live: bool) -> RecordingStreamResult<Self> {
        let steps = Steps::begin(recording, (name, live), 1, |tree| {
            let pieces = [
                (tree.view("TextDocument", "Candidates", &[under(RANKING)], &[])?, 2.0),
                (tree.view("TextLog", "What is being done", &[under(LOG)], &[])?, 1.0),
            ];
            tree.container(ContainerKind::Horizontal, &pieces)?;
            Ok(())
        })?;
        Ok(Self { steps, rounds: BTreeMap::new() })
    }

    pub(super) fn doing(&mut self, recording: &RecordingStream, what: &str) -> RecordingStreamResult<()> {
        self.steps.doing(recording, LOG, what)
    }

    pub(super) fn ranked(
        &mut self,
        recording: &RecordingStream,
        threshold: f64,
        candidates: &[Evidence],
    ) -> RecordingStreamResult<()> {
        for candidate in candidates {
            let (_, known) = self.rounds.entry(candidate.round).or_insert_with(|| (threshold, Vec::new()));
            match known.iter_mut().find(|known| known.effect == candidate.effect) {
                Some(known) => *known = candidate.clone(),
                None => known.push(candidate.clone()),
            }
        }
        self.steps.next(recording);
        recording.log(RANKING, &markdown(&ranking(&self.rounds)))
    }

    pub(super) fn found(
        &mut self,
        recording: &RecordingStream,
        outcome: &DiagnosisOutcome,
    ) -> RecordingStreamResult<()> {
        // The last ranking is there at every time of a release, too.
        self.steps.next(recording);
        recording.set_duration_secs(TIMELINE, 0.0);
        recording.log(RANKING, &markdown(&ranking(&self.rounds)))?;
        recording.log(ANSWER, &markdown(&answer(&outcome.diagnosis)))?;
        recording.disable_timeline(STEP);
        let compared = draw(recording, outcome)?;
        tree::send(recording, 2, TIMELINE, self.steps.live, |tree| lay_out(tree, &compared, words))
    }
}

/// Answer and candidates, each on a tab.
fn words(tree: &mut Tree) -> RecordingStreamResult<String> {
    let tabs = [
        (tree.view("TextDocument", "Answer", &[under(ANSWER)], &[])?, 1.0),
        (tree.view("TextDocument", "Candidates", &[under(RANKING)], &[])?, 1.0),
    ];
    tree.container(ContainerKind::Tabs, &tabs)
}

pub(super) fn markdown(text: &str) -> TextDocument {
    TextDocument::new(text).with_media_type(MediaType::markdown())
}

/// The rounds, the last first, with bars for the scores.
fn ranking(rounds: &BTreeMap<usize, (f64, Vec<Evidence>)>) -> String {
    let mut text = String::new();
    for (round, (threshold, candidates)) in rounds.iter().rev() {
        let _ = writeln!(text, "### Round {round}: threshold of the score {threshold:.2}\n");
        text += "| candidate | score | | predicted | fitted | |\n|---|---:|---|---:|---:|---|\n";
        let mut sorted: Vec<&Evidence> = candidates.iter().collect();
        sorted.sort_by(|a, b| b.score.total_cmp(&a.score));
        let most = sorted.first().map_or(1.0, |first| first.score.max(*threshold));
        for own in sorted.iter().take(SHOWN) {
            let bar = "•".repeat((LONGEST * own.score / most).round() as usize);
            let keeps = own.realised_decrease.map_or(String::new(), |keeps| format!("{keeps:.0}"));
            let why = own.rejected.as_deref().unwrap_or("");
            let _ = writeln!(
                text,
                "| {} | {:.2} | {bar} | {:.0} | {keeps} | {why} |",
                own.label(),
                own.score,
                own.predicted_decrease
            );
        }
        text.push('\n');
    }
    text + "Predicted and fitted: decrease of χ² by the score and by the fit.\n"
}

/// The answer in words, the gaps, the warnings.
fn answer(diagnosis: &Diagnosis) -> String {
    let mut text = format!(
        "{}\n\n| release | rms residual over noise, before | after |\n|---|---:|---:|\n",
        diagnosis.summary.replace('\n', "\n\n")
    );
    for gap in &diagnosis.gap {
        let part = if gap.held_out { ", held out" } else { "" };
        let _ = writeln!(text, "| {}{part} | {:.2} | {:.2} |", cell(&gap.release), gap.before, gap.after);
    }
    for warning in &diagnosis.warnings {
        let _ = write!(text, "\n- {}", cell(warning));
    }
    text
}

/// Words of others as a cell of a table.
pub(super) fn cell(words: &str) -> String {
    words.replace('|', "\\|").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last round stands first, the best candidate before the others, and no word breaks a table.
    #[test]
    fn a_ranking_is_a_table_with_the_best_on_top() {
        let candidate = |round, effect: &str, score| Evidence {
            round,
            effect: effect.to_owned(),
            of_each_pressure: false,
            of_first_swings: false,
            tried: Vec::new(),
            score,
            predicted_decrease: score * score,
            realised_decrease: (round == 2).then_some(7.0),
            strength: 1.0,
            held_out_decrease: None,
            rejected: None,
        };
        let first = (3.5, vec![candidate(1, "hose", 2.0), candidate(1, "air_drag", 8.0)]);
        let rounds = BTreeMap::from([(1, first), (2, (3.4, vec![candidate(2, "dahl", 3.6)]))]);
        let text = ranking(&rounds);
        let at = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part} in {text}"));
        assert!(at("Round 2: threshold of the score 3.40") < at("Round 1"));
        assert!(at("| dahl | 3.60 |") < at("| air_drag | 8.00 |") && at("| air_drag") < at("| hose"));
        assert!(text.contains("| 13 | 7 |") && text.contains("| 64 |  |"));
        assert_eq!(cell("a | b\nc"), "a \\| b c");
    }
}
