//! What a diagnosis leaves on disk.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html            the verdict with its evidence for people: one page with all pictures in it
//!   diagnosis.json         the same for programs
//!   gap.svg, features.svg, residual-01.svg …, swing.svg, candidates-1.svg …    the pictures
//!   repaired-1.toml …      a scenario for each release, with the effects in its model: `efam simulate`
//!   experiment.toml        the experiment as it was read
//!   summary.json           the verdict alone, and by which command
//! ```

mod page;

use std::fmt::Write;
use std::time::SystemTime;

use efam_core::work::written;
use efam_experiments::scenario::resolved::plain;
use efam_inference::calibrate::problem::is_of_pressure;
use efam_inference::diagnose::plan::Prospect;
use efam_inference::diagnose::verdict::{Gap, Odds, Round, Seen};
use efam_inference::diagnose::{Diagnosis, DiagnosisOutcome};
use efam_store::StoreError;
use efam_store::folder::Folder;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::calibrated::EXPERIMENT;
use crate::page::REPORT;
use crate::picture::diagnosed;
use crate::report::{significant, significant_or_dash};
use crate::{Request, write_mark};

/// The verdict.
pub const DIAGNOSIS: &str = "diagnosis.json";

/// Writes a diagnosis into an open folder; `request.resolved_scenario` is the experiment's text.
/// # Errors
/// [`StoreError::Write`].
pub fn write_diagnosis(
    folder: &Folder,
    request: &Request,
    outcome: &DiagnosisOutcome,
) -> Result<(), StoreError> {
    let diagnosis = &outcome.diagnosis;
    let text = serde_json::to_string_pretty(diagnosis).expect("a diagnosis has nothing that JSON has not");
    folder.write(DIAGNOSIS, text.as_bytes())?;
    folder.write(EXPERIMENT, request.resolved_scenario.as_bytes())?;
    let mut head = format!("{}\nWritten by efam diagnose from:", diagnosis.summary);
    for (file, hash) in &request.input_hashes {
        let _ = write!(head, "\n  {file}  sha256 {hash}");
    }
    for (k, trial) in outcome.repaired.trials.iter().enumerate() {
        let duration = trial.release.time.last().copied().unwrap_or(1.0);
        let mut text = plain(&head, &trial.release.name, &trial.model, &trial.run, duration);
        let known =
            outcome.errors.of(|parameter| is_of_pressure(parameter.pressure_pa, trial.release.pressure));
        text += &format!("\n{}", known.section());
        folder.write(&format!("repaired-{}.toml", k + 1), text.as_bytes())?;
    }
    let (pictures, written) = (diagnosed(diagnosis, &outcome.curves), SystemTime::now());
    for picture in &pictures {
        folder.write(&format!("{}.svg", picture.name), picture.svg().as_bytes())?;
    }
    folder.write(REPORT, page::page(request, outcome, &pictures, written).as_bytes())?;
    let own = json!({
        "verdict": diagnosis.verdict,
        "summary": diagnosis.summary,
        "effects": diagnosis.effects,
    });
    write_mark(folder, request, "diagnosis", written, own)
}

/// Candidates shown of each round.
const SHOWN: usize = 8;

/// The verdict and its evidence as a person reads them.
pub fn diagnosis_table(diagnosis: &Diagnosis) -> String {
    let mut out = format!("{}\n", diagnosis.summary);
    for added in &diagnosis.effects {
        for value in &added.parameters {
            let of = value.of.as_ref().map_or(String::new(), |of| format!(" of {of}"));
            let interval = value.interval_95.map_or(" (held)".to_owned(), |[low, high]| {
                format!(" ({} to {})", significant(low, 3), significant(high, 3))
            });
            let _ = writeln!(
                out,
                "  {}.{}{of} = {}{interval} {}",
                added.effect,
                value.name,
                significant(value.value, 4),
                value.unit
            );
        }
    }
    for (k, round) in diagnosis.rounds.iter().enumerate() {
        let _ = write!(out, "\n{}", round_table(k + 1, round));
    }
    if !diagnosis.seen.is_empty() {
        let _ = write!(out, "\n{}", seen_table(&diagnosis.seen));
    }
    let numbers = ["before", "after"].map(|head| (head, Side::Number));
    let heads = [&[("rms residual / noise", Side::Words)], &numbers[..], &[("", Side::Name)]].concat();
    let mut gaps = Aligned::new(&heads);
    for Gap { release, held_out, before, after, .. } in &diagnosis.gap {
        let part = if *held_out { "(held out)" } else { "" };
        gaps.row([release, &format!("{before:.3}"), &format!("{after:.3}"), part]);
    }
    let [done, budget] = [diagnosis.node_steps, diagnosis.budget].map(written);
    let runs = diagnosis.runs;
    let _ = write!(out, "\n{gaps}\nwork: {runs} runs, {done} node steps, of a budget of {budget}\n");
    for warning in &diagnosis.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// The candidates of a round with their odds.
fn round_table(number: usize, round: &Round) -> String {
    let mut out = format!(
        "round {number}: {:.2} % of the swing is missed; an answer needs log odds of {:.1}\n",
        100.0 * round.share,
        round.bar
    );
    let numbers = ["by features", "by samples", "left, mm"].map(|head| (head, Side::Number));
    let heads = [&[("candidate", Side::Words)], &numbers[..], &[("", Side::Name)]].concat();
    let mut candidates = Aligned::new(&heads).indented(2);
    for own in round.candidates.iter().take(SHOWN) {
        candidates.row(odds_cells(own, "-"));
    }
    let _ = write!(out, "{candidates}");
    out
}

/// A candidate with its odds: name, by features, by samples, what is left, mm, and why it is not the answer; `none` where it was not
/// fitted.
fn odds_cells(own: &Odds, none: &str) -> [String; 5] {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or(none.to_owned(), |value| format!("{value:.digits$}"))
    };
    [
        own.name.clone(),
        number(Some(own.features), 1),
        number(own.all, 1),
        number(own.rms_mm, 3),
        own.reason().to_owned(),
    ]
}

/// A feature with its release, as recorded, and as the model has it before and after, with its unit.
fn seen_cells(own: &Seen) -> [String; 6] {
    let [recorded, before, after] = [own.recorded, own.before, own.after].map(|value| significant(value, 4));
    [own.what.clone(), own.release.clone(), recorded, before, after, own.unit.clone()]
}

/// What the recordings show, and what the model has before and after.
fn seen_table(seen: &[Seen]) -> String {
    let numbers = ["recorded", "before", "after"].map(|head| (head, Side::Number));
    let heads = [&[("seen", Side::Words), ("of", Side::Words)], &numbers[..], &[("", Side::Name)]].concat();
    let mut table = Aligned::new(&heads);
    for own in seen {
        table.row(seen_cells(own));
    }
    table.to_string()
}

/// What a planned experiment could show, as a person reads it.
pub fn plan_table(prospects: &[Prospect], releases: usize) -> String {
    let plural = if releases == 1 { "" } else { "s" };
    let heads = [
        ("effect", Side::Words),
        ("parameter", Side::Words),
        ("detectable", Side::Number),
        ("separable", Side::Number),
        ("most similar", Side::Words),
        ("plausible", Side::Number),
        ("", Side::Name),
    ];
    let mut table = Aligned::new(&heads).indented(2);
    for prospect in prospects {
        let number = |value: f64| if value.is_finite() { significant(value, 2) } else { "never".to_owned() };
        table.row([
            prospect.effect.clone(),
            prospect.parameter.clone(),
            number(prospect.detectable_from),
            number(prospect.separable_from),
            prospect.nearest.clone().unwrap_or("-".to_owned()),
            significant_or_dash(prospect.largest_plausible, 2),
            prospect.unit.clone(),
        ]);
    }
    let mut out = format!("{releases} release{plural} could show\n{table}");
    out += "detectable, separable: smallest value at 5 standard deviations, for small effects; plausible: largest expected value\n";
    out
}
