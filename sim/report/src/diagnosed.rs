//! What a diagnosis leaves on disk.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html            the verdict with its evidence for people: one page with all pictures in it
//!   diagnosis.json         the same for programs
//!   gap.svg, residual-01.svg …, swing.svg, shapes.svg, candidates-1.svg …    the pictures
//!   repaired-1.toml …      a scenario for each release, with the effects in its model: `efam simulate`
//!   experiment.toml        the experiment as it was read
//!   summary.json           the verdict alone, and by which command
//! ```

mod page;

use std::fmt::Write;
use std::time::SystemTime;

use efam_experiments::scenario::resolved::plain;
use efam_inference::calibrate::problem::is_of_pressure;
use efam_inference::diagnose::plan::Prospect;
use efam_inference::diagnose::verdict::{Evidence, Gap};
use efam_inference::diagnose::{Diagnosis, Outcome};
use efam_store::StoreError;
use efam_store::folder::Folder;
use serde_json::json;

use crate::calibrated::EXPERIMENT;
use crate::page::REPORT;
use crate::picture::diagnosed;
use crate::report::significant;
use crate::{Request, write_mark};

/// The verdict.
pub const DIAGNOSIS: &str = "diagnosis.json";

/// Writes a diagnosis into an open folder; `request.resolved_scenario` is the experiment's text.
/// # Errors
/// [`StoreError::Write`].
pub fn write_diagnosis(folder: &Folder, request: &Request, outcome: &Outcome) -> Result<(), StoreError> {
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
        let mut text = plain(&head, &trial.release.name, &trial.model, duration);
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
    for (round, threshold) in diagnosis.thresholds.iter().enumerate() {
        let mut shapes = diagnosis.shapes.iter().filter(|shape| shape.round == round + 1).peekable();
        if shapes.peek().is_some() {
            let _ = writeln!(out, "\nround {}: residual patterns", round + 1);
        }
        for shape in shapes {
            let stands_out = if shape.score > shape.threshold { "  above the threshold" } else { "" };
            let _ = writeln!(
                out,
                "  {:44}{:>8.2} of {:.2}{:>9.3} mm at {:>3.0} % of the amplitude{stands_out}",
                shape.what,
                shape.score,
                shape.threshold,
                shape.size_mm,
                100.0 * shape.at_amplitude
            );
        }
        let _ = writeln!(
            out,
            "\nround {}: threshold of the score {threshold:.2}; predicted and fitted: decrease of χ²",
            round + 1
        );
        let _ = writeln!(
            out,
            "  {:34}{:>8}{:>10}{:>10} {:>12}",
            "candidate", "score", "predicted", "fitted", "strength"
        );
        let own: Vec<&Evidence> =
            diagnosis.evidence.iter().filter(|evidence| evidence.round == round + 1).collect();
        for evidence in own.iter().take(SHOWN) {
            let keeps = evidence.realised_decrease.map_or("-".to_owned(), |keeps| format!("{keeps:.1}"));
            let _ = writeln!(
                out,
                "  {:34}{:>8.2}{:>10.1}{keeps:>10} {:>12}  {}",
                evidence.asked(),
                evidence.score,
                evidence.predicted_decrease,
                significant(evidence.strength, 3),
                evidence.rejected.as_deref().unwrap_or("")
            );
        }
    }
    out += "\nrms residual / noise      before     after\n";
    for Gap { release, held_out, before, after, .. } in &diagnosis.gap {
        let part = if *held_out { "  (held out)" } else { "" };
        let _ = writeln!(out, "  {release:22}{before:>8.3}{after:>10.3}{part}");
    }
    for warning in &diagnosis.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// What a planned experiment could show, as a person reads it.
pub fn plan_table(prospects: &[Prospect], releases: usize) -> String {
    let mut out = format!(
        "{releases} release{} could show\n  {:24}{:24}{:>12}{:>14}  {:24}{:>10}\n",
        if releases == 1 { "" } else { "s" },
        "effect",
        "parameter",
        "detectable",
        "separable",
        "most similar",
        "plausible"
    );
    for prospect in prospects {
        let number = |value: f64| if value.is_finite() { significant(value, 2) } else { "never".to_owned() };
        let _ = writeln!(
            out,
            "  {:24}{:24}{:>12}{:>14}  {:24}{:>10} {}",
            prospect.effect,
            prospect.parameter,
            number(prospect.detectable_from),
            number(prospect.separable_from),
            prospect.nearest.as_deref().unwrap_or("-"),
            prospect.largest_plausible.map_or("-".to_owned(), |most| significant(most, 2)),
            prospect.unit,
        );
    }
    out += "detectable, separable: smallest value at 5 standard deviations, for small effects; plausible: largest expected value\n";
    out
}
