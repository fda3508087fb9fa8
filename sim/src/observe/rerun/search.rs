//! A diagnosis while it works: what is being done, and the present candidates.

use std::collections::BTreeMap;
use std::fmt::Write;

use ::rerun::external::re_sdk_types::components::MediaType;
use ::rerun::{RecordingStream, RecordingStreamResult, TextDocument, TextLog};
use efam_inference::diagnose::verdict::Round;
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
    /// The rounds up to now, by their numbers.
    rounds: BTreeMap<usize, Round>,
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
        number: usize,
        round: &Round,
    ) -> RecordingStreamResult<()> {
        self.rounds.insert(number, round.clone());
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

/// The rounds, the last first, with bars for the odds.
fn ranking(rounds: &BTreeMap<usize, Round>) -> String {
    let mut text = String::new();
    for (number, round) in rounds.iter().rev() {
        let _ = writeln!(text, "### Round {number}: an answer needs log odds of {:.1}\n", round.bar);
        text += "| candidate | by features | by samples | | |\n|---|---:|---:|---|---|\n";
        let most = round.candidates.first().map_or(1.0, |first| first.best().max(round.bar));
        for own in round.candidates.iter().take(SHOWN) {
            let bar = "•".repeat((LONGEST * own.best().max(0.0) / most).min(LONGEST).round() as usize);
            let all = own.all.map_or(String::new(), |all| format!("{all:.1}"));
            let _ =
                writeln!(text, "| {} | {:.1} | {all} | {bar} | {} |", own.name, own.features, own.reason());
        }
        text.push('\n');
    }
    text + "Logarithm of the odds over the model before, by features and by all samples.\n"
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
    use efam_inference::diagnose::verdict::Odds;

    use super::*;

    /// The last round comes first, the best candidate before the others, and no word breaks a table.
    #[test]
    fn a_ranking_is_a_table_with_the_best_on_top() {
        let candidate = |name: &str, features: f64, all: Option<f64>| Odds {
            name: name.to_owned(),
            features,
            all,
            rejected: all.is_none().then(|| "features favour others".to_owned()),
            ..Odds::default()
        };
        let round = |bar: f64, candidates| Round { bar, candidates, ..Round::default() };
        let first = vec![candidate("air_drag", 60.0, Some(64.0)), candidate("hose", 2.0, None)];
        let rounds =
            BTreeMap::from([(1, round(8.1, first)), (2, round(8.0, vec![candidate("dahl", 3.6, None)]))]);
        let text = ranking(&rounds);
        let at = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part} in {text}"));
        assert!(at("Round 2: an answer needs log odds of 8.0") < at("Round 1"));
        assert!(at("| dahl | 3.6 |") < at("| air_drag | 60.0 |") && at("| air_drag") < at("| hose"));
        assert!(text.contains("| 60.0 | 64.0 |") && text.contains("| 2.0 |  |"));
        assert_eq!(cell("a | b\nc"), "a \\| b c");
    }
}
