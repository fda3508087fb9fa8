//! A diagnosis as a page.

use efam_core::work::written;
use efam_inference::diagnose::verdict::{Added, ParameterValue};
use efam_inference::diagnose::{Curve, Diagnosis, DiagnosisOutcome, Verdict};
use models::effects::Catalogue;

use crate::page::{BeforeUse, Masked, Page, Table};
use crate::picture::{Picture, of_diagnosis};
use crate::report::{short, significant};
use crate::{Request, assumed};

/// The page of a diagnosis with its pictures; `written` is when.
pub(super) fn page(
    request: &Request,
    outcome: &DiagnosisOutcome,
    pictures: &[Picture],
    written: std::time::SystemTime,
) -> String {
    let diagnosis = &outcome.diagnosis;
    let title = format!("Diagnosis of {}", request.name);
    let (answer, evidence_lines) = diagnosis.summary.split_once('\n').unwrap_or((&diagnosis.summary, ""));
    let lead = format!("{}. {}", verdict(diagnosis.verdict), evidence_lines.replace('\n', " "));
    let mut page = Page::new(&title, answer, lead.trim_end());
    let catalogue = outcome.repaired.trials.first().map(|trial| trial.model.catalogue.clone());
    effects(&mut page, diagnosis, &catalogue.unwrap_or_default());
    let of = |names: &[&str]| {
        pictures.iter().filter(|picture| names.iter().any(|name| picture.name.starts_with(name))).collect()
    };
    let [gap, over_time, looks, candidates]: [Vec<&Picture>; 4] =
        [of(&["gap"]), of(&["residual"]), of(&["swing", "shapes"]), of(&["candidates"])];
    page.section("Gap between simulation and recordings");
    page.figures(gap);
    gaps(&mut page, diagnosis);
    if !over_time.is_empty() {
        page.section("Residuals over time");
        page.all_rods(&of_diagnosis(outcome));
        page.figures(over_time);
    }
    page.section("Residual patterns");
    page.figures(looks);
    page.section("Candidate effects");
    for picture in candidates {
        page.figure(picture);
    }
    evidence(&mut page, diagnosis);
    page.before_use(&reservations(outcome));
    page.facts_of(request, written, facts(diagnosis));
    page.finish()
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "Verdict: named",
        Verdict::Incomplete => "Verdict: named, incomplete",
        Verdict::Class => "Verdict: ambiguous",
        Verdict::Misstated => "Verdict: a stated value is wrong",
        Verdict::NothingMissing => "Verdict: nothing missing",
        Verdict::Unknown => "Verdict: unknown",
    }
}

/// What should be known before the answer is used.
fn reservations(outcome: &DiagnosisOutcome) -> BeforeUse {
    BeforeUse {
        note: Some("The rate of right answers is known from about two hundred simulated experiments only (docs/src/validation/blind-bench.md). Confirm a name before you publish it.".to_owned()),
        warnings: outcome.diagnosis.warnings.clone(),
        held_out: Some(outcome.diagnosis.held_out.clone()),
        extrapolated: None,
        masked: Some(Masked {
            caption: "Samples left out: of the hold, lost or masked; and outliers held back",
            heads: &["release", "marker", "samples", "missing", "held back"],
            rows: outcome.curves.iter().filter_map(lost).collect(),
        }),
        assumed: assumed::of_problem(&outcome.repaired),
    }
}

/// How much of a track is not there, or hardly counts.
fn lost(curve: &Curve) -> Option<Vec<String>> {
    let (all, seen, heard) = (curve.samples.len(), curve.seen().count(), curve.heard().count());
    let counts = [all, all - seen, seen - heard].map(|count| count.to_string());
    let names = [curve.release.clone(), curve.marker.clone()];
    (heard < all).then(|| names.into_iter().chain(counts).collect())
}

fn effects(page: &mut Page, diagnosis: &Diagnosis, catalogue: &Catalogue) {
    page.section("Missing effects");
    if diagnosis.effects.is_empty() {
        page.text("No effect was added to the model.");
    }
    let row = |effect: &str, value: &ParameterValue| {
        let bound = |k: usize| value.interval_95.map_or("not fitted".to_owned(), |of| short(of[k]));
        let of = value.of.as_deref().unwrap_or("all releases").to_owned();
        vec![
            format!("{effect}.{}", value.name),
            of,
            short(value.value),
            bound(0),
            bound(1),
            value.unit.clone(),
        ]
    };
    let of_added =
        |added: &Added| added.parameters.iter().map(|own| row(&added.effect, own)).collect::<Vec<_>>();
    let rows = diagnosis.effects.iter().flat_map(of_added).collect();
    let meaning = |effect: &str| Some(format!("{effect}: {}", catalogue.by_name(effect)?.about().meaning));
    page.list(&diagnosis.effects.iter().filter_map(|added| meaning(&added.effect)).collect::<Vec<_>>());
    let heads = ["parameter", "of", "value", "from", "to", "unit"];
    page.table(&Table { caption: "Values with their 95 % intervals", heads: &heads, rows });
    if let Some(description) = &diagnosis.description {
        page.heading("A description, not a cause");
        page.table(&Table {
            caption: "Moment at every bend, over EI, that would explain the residual; it is not in the repaired model",
            heads: &heads,
            rows: of_added(&description.moment),
        });
    }
    if !diagnosis.members.is_empty() {
        page.heading("Equally good effects");
        let row = |member: &efam_inference::diagnose::verdict::Member| {
            vec![
                member.effect.clone(),
                format!("{:.1}", member.behind),
                format!("{:.1}", member.distance),
                meaning(&member.effect).unwrap_or_default(),
            ]
        };
        page.table(&Table {
            caption: "Effects that these recordings cannot separate from it. Distance in standard deviations: below 2 inseparable, from 5 separable",
            heads: &["effect", "worse by, χ²", "distance", "meaning"],
            rows: diagnosis.members.iter().map(row).collect(),
        });
    }
    if let Some(separation) = &diagnosis.separating_experiment {
        page.heading("Recommended recording");
        page.text(&format!(
            "Record {}. By simulation, this raises the distance of the nearest two from {:.1} to {:.1} standard deviations.",
            separation.what, separation.distance_now, separation.distance
        ));
    }
}

fn gaps(page: &mut Page, diagnosis: &Diagnosis) {
    let row = |gap: &efam_inference::diagnose::verdict::Gap| {
        let millimetres = |value: f64| format!("{value:.3}");
        let part = if gap.held_out { "held out" } else { "fitted" };
        vec![
            gap.release.clone(),
            part.to_owned(),
            format!("{:.2}", gap.before),
            format!("{:.2}", gap.after),
            millimetres(gap.before_mm),
            millimetres(gap.after_mm),
            millimetres(gap.noise_mm),
        ]
    };
    page.table(&Table {
        caption: "Gap of each release, over the noise and in mm",
        heads: &["release", "part", "before", "after", "before, mm", "after, mm", "noise, mm"],
        rows: diagnosis.gap.iter().map(row).collect(),
    });
}

fn evidence(page: &mut Page, diagnosis: &Diagnosis) {
    let row = |own: &efam_inference::diagnose::verdict::Evidence| {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.1}"));
        vec![
            own.label(),
            own.round.to_string(),
            format!("{:.2}", own.score),
            number(Some(own.predicted_decrease)),
            number(own.realised_decrease),
            number(own.held_out_decrease),
            own.rejected.clone().unwrap_or_else(|| "in the answer".to_owned()),
        ]
    };
    page.folded(
        "All candidates in numbers",
        &Table {
            caption: "All candidates of all rounds; decreases are of χ²",
            heads: &[
                "effect",
                "round",
                "score",
                "predicted decrease",
                "fitted decrease",
                "held-out decrease",
                "reason for rejection",
            ],
            rows: diagnosis.evidence.iter().map(row).collect(),
        },
    );
}

/// What only a diagnosis has among its facts.
fn facts(diagnosis: &Diagnosis) -> Vec<(String, String)> {
    let thresholds: Vec<String> =
        diagnosis.thresholds.iter().enumerate().map(|(k, t)| format!("round {}: {t:.2}", k + 1)).collect();
    vec![
        ("false-alarm level of a round".to_owned(), significant(diagnosis.false_alarm, 2)),
        ("threshold of the score".to_owned(), thresholds.join(", ")),
        ("nodes".to_owned(), diagnosis.numerics.nodes.to_string()),
        ("mesh error over the noise".to_owned(), format!("{:.2}", diagnosis.numerics.left)),
        (
            "node steps, of the budget".to_owned(),
            format!("{} of {}", written(diagnosis.node_steps), written(diagnosis.budget)),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use efam_inference::calibrate::{FittedParameter, Nuisances, Problem, Scope};
    use efam_inference::diagnose::curve::Sample;
    use efam_inference::diagnose::verdict::{Added, Evidence, Gap, Member, Separation, Shape};

    use super::*;
    use crate::page::stripped;
    use crate::picture::diagnosed;

    /// A marker that swings 10 mm about a point 300 mm from the clamp, and is predicted 1 mm off before.
    fn curve(release: &str, held_out: bool) -> Curve {
        let sample = |k: usize| {
            let time = 0.01 * k as f64;
            let phase = 9.0 * time;
            let after = [0.3, 0.01 * phase.cos()];
            let measured = [0.3, after[1] + 2e-4 * (40.0 * time).sin()];
            let before = [0.3, after[1] - 1e-3 * phase.cos()];
            let amplitude = (-0.3 * time).exp();
            let is_held_back = k == 50;
            (k % 40 != 7).then_some(Sample { time, measured, before, after, amplitude, phase, is_held_back })
        };
        Curve {
            release: release.to_owned(),
            held_out,
            pressure: Some(1e5),
            marker: "Tip <1>".to_owned(),
            is_leading: true,
            noise: 2e-4,
            samples: (0..400).map(sample).collect(),
        }
    }

    fn outcome(verdict: Verdict, name: &str) -> DiagnosisOutcome {
        let evidence = |effect: &str, rejected: Option<&str>| Evidence {
            round: 1,
            effect: effect.to_owned(),
            of_each_pressure: false,
            of_first_swings: false,
            tried: Vec::new(),
            score: 12.0,
            predicted_decrease: 140.0,
            realised_decrease: rejected.is_none().then_some(133.0),
            strength: 1.1,
            held_out_decrease: None,
            rejected: rejected.map(str::to_owned),
        };
        let gap = |release: &str, held_out: bool| Gap {
            release: release.to_owned(),
            held_out,
            before_mm: 0.9,
            after_mm: 0.3,
            before: 3.0,
            after: 1.0,
            noise_mm: 0.3,
        };
        let shape = |round: usize| Shape {
            round,
            what: "the mean drifts with the amplitude".to_owned(),
            score: 7.0,
            threshold: 5.0,
            at_amplitude: 1.0,
            size_mm: 0.4,
        };
        let value = ParameterValue {
            name: "drag_coefficient".to_owned(),
            unit: String::new(),
            of: None,
            value: 1.1,
            interval_95: Some([1.0, 1.2]),
        };
        let has_effect = matches!(verdict, Verdict::Named | Verdict::Incomplete | Verdict::Class);
        let is_class = verdict == Verdict::Class;
        let member = Member { effect: "tip_drag".to_owned(), behind: 2.0, distance: 1.5 };
        let separation =
            Separation { what: "a longer recording".to_owned(), distance: 6.0, distance_now: 1.5 };
        let added = Added { effect: "air_drag".to_owned(), parameters: vec![value] };
        let diagnosis = Diagnosis {
            verdict,
            summary: format!("A summary of <{name}>."),
            effects: has_effect.then_some(added).into_iter().collect(),
            members: is_class.then_some(member).into_iter().collect(),
            separating_experiment: is_class.then_some(separation),
            evidence: vec![
                evidence("air_drag", None),
                evidence("creep", Some("it would need the wrong sign")),
            ],
            gap: vec![gap(name, false), gap("held", true)],
            false_alarm: 0.01,
            thresholds: vec![4.2],
            shapes: vec![shape(1), shape(2)],
            held_out: vec!["held".to_owned()],
            warnings: vec!["one pressure alone".to_owned()],
            ..Diagnosis::default()
        };
        let repaired = Problem {
            trials: Vec::new(),
            parameters: vec![FittedParameter::new("rod.bending_stiffness", Scope::PerPressure)],
            nuisances: Nuisances {
                release_instant: true,
                hold_angle: Some(0.01),
                offset: Some(1e-3),
                ..Nuisances::default()
            },
        };
        DiagnosisOutcome {
            diagnosis,
            baseline: repaired.clone(),
            repaired,
            errors: Default::default(),
            curves: vec![curve(name, false), curve("held", true)],
        }
    }

    fn page_of(verdict: Verdict, name: &str) -> String {
        let outcome = outcome(verdict, name);
        let mut request = Request {
            name: name.to_owned(),
            argv: vec!["efam".to_owned(), "diagnose".to_owned(), format!("{name}.toml")],
            ..Request::default()
        };
        request.input_hashes.insert(format!("{name}.csv"), "0123abcd".to_owned());
        let pictures = diagnosed(&outcome.diagnosis, &outcome.curves);
        page(&request, &outcome, &pictures, SystemTime::UNIX_EPOCH)
    }

    #[test]
    fn each_verdict_has_a_page_that_says_it_and_what_it_rests_on() {
        for (kind, word, says) in [
            (Verdict::Named, "Verdict: named", "<td class=\"number\">1.20</td>"),
            (Verdict::Class, "Verdict: ambiguous", "Record a longer recording"),
            (Verdict::NothingMissing, "Verdict: nothing missing", "No effect was added"),
            (Verdict::Unknown, "Verdict: unknown", "No effect was added"),
        ] {
            let html = page_of(kind, "15 psi");
            if let Ok(folder) = std::env::var("EFAM_LOOK") {
                std::fs::write(format!("{folder}/report-{kind:?}.html"), &html).unwrap();
            }
            for text in [
                word,
                "A summary of &lt;15 psi&gt;.",
                says,
                "one pressure alone",
                "<li>held</li>",
                "<th scope=\"row\">15 psi</th><td>Tip &lt;1&gt;</td><td class=\"number\">400</td>\
                 <td class=\"number\">10</td><td class=\"number\">1</td>",
                "rod.bending_stiffness is fitted: one value for each pressure",
                "it would need the wrong sign",
                "rms residual over noise",
                "residual, mm",
                "time since release, s",
                "phase, share of a swing",
                "score over its threshold",
                "score, standard deviations",
                "log10 of the decrease",
                "efam diagnose 15 psi.toml",
                "SHA-256 of 15 psi.csv",
                "0123abcd",
                "19700101T000000Z",
                "round 1: 4.20",
            ] {
                assert!(html.contains(text), "{kind:?}: {text}");
            }
            let rest = stripped(&html);
            assert!(!rest.contains("NaN") && !rest.contains("<script"), "{kind:?}");
        }
    }

    #[test]
    fn a_name_cannot_write_into_the_page() {
        let html = page_of(Verdict::Named, "<script>alert(1)</script>");
        assert!(!stripped(&html).contains("<script"));
        assert!(html.contains("Diagnosis of &lt;script&gt;alert(1)&lt;/script&gt;"));
    }

    /// A page loads nothing: no address in it leads anywhere but into itself.
    #[test]
    fn a_page_needs_no_network() {
        let html = stripped(&page_of(Verdict::Named, "15 psi"));
        let addresses = html.match_indices("http").map(|(at, _)| &html[at..(at + 40).min(html.len())]);
        let foreign: Vec<_> = addresses
            .filter(|text| !text.starts_with("http-equiv") && !text.starts_with("http://www.w3.org/2000/svg"))
            .collect();
        assert!(foreign.is_empty(), "{foreign:?}");
        assert!(!html.contains("src=") && !html.contains("url("));
    }
}
