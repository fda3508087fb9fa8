//! A diagnosis as a page.

use efam_core::work::written;
use efam_inference::diagnose::verdict::{Added, Contradiction, Odds, ParameterValue};
use efam_inference::diagnose::{Curve, Diagnosis, DiagnosisOutcome, Verdict};
use models::effects::Catalogue;

use super::{odds_cells, seen_cells};
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
    let [gap, features, over_time, looks, candidates]: [Vec<&Picture>; 5] =
        [of(&["gap"]), of(&["features"]), of(&["residual"]), of(&["swing"]), of(&["candidates"])];
    page.section("What is seen");
    for picture in features {
        page.figure(picture);
    }
    seen(&mut page, diagnosis);
    page.section("Gap between simulation and recordings");
    page.figures(gap);
    gaps(&mut page, diagnosis);
    if !over_time.is_empty() {
        page.section("Residuals over time");
        page.all_rods(&of_diagnosis(outcome));
        page.figures(over_time);
    }
    if !looks.is_empty() {
        page.section("Residuals over the swing");
        page.figures(looks);
    }
    page.section("Candidates");
    for picture in candidates {
        page.figure(picture);
    }
    odds(&mut page, diagnosis);
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
            caption: "Samples left out: of the hold, lost or masked",
            heads: &["release", "marker", "samples", "missing"],
            rows: outcome.curves.iter().filter_map(lost).collect(),
        }),
        assumed: assumed::of_problem(&outcome.repaired),
    }
}

/// How much of a track is not there.
fn lost(curve: &Curve) -> Option<Vec<String>> {
    let (all, seen) = (curve.samples.len(), curve.seen().count());
    let cells = [curve.release.clone(), curve.marker.clone(), all.to_string(), (all - seen).to_string()];
    (seen < all).then(|| cells.to_vec())
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
    if !diagnosis.contradictions.is_empty() {
        let row = |own: &Contradiction| {
            let [low, high] = own.interval_95.map(short);
            let off = format!("{:.1}", own.deviations.abs());
            vec![own.parameter.clone(), short(own.value), low, high, own.unit.clone(), off]
        };
        page.heading("Not as stated");
        page.table(&Table {
            caption: "Values of the rod and the setup that the fit moved by more than two standard deviations of what is stated",
            heads: &["value", "fitted", "from", "to", "unit", "deviations"],
            rows: diagnosis.contradictions.iter().map(row).collect(),
        });
    }
    if !diagnosis.members.is_empty() {
        page.heading("Equally good effects");
        let row = |member: &efam_inference::diagnose::verdict::Member| {
            vec![
                member.effect.clone(),
                format!("{:.1}", member.behind),
                member.distance.map_or(String::new(), |distance| format!("{distance:.1}")),
                meaning(&member.effect).unwrap_or_default(),
            ]
        };
        page.table(&Table {
            caption: "Effects that these recordings cannot separate from it. Distance in standard deviations: below 2 inseparable, from 5 separable",
            heads: &["effect", "log odds behind", "distance", "meaning"],
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

fn seen(page: &mut Page, diagnosis: &Diagnosis) {
    page.table(&Table {
        caption: "Features that the answer changes most, as recorded and as the model has them before and after",
        heads: &["feature", "release", "recorded", "before", "after", "unit"],
        rows: diagnosis.seen.iter().map(|own| seen_cells(own).to_vec()).collect(),
    });
}

fn odds(page: &mut Page, diagnosis: &Diagnosis) {
    let row = |(number, own): (usize, &Odds)| {
        let [name, rest @ ..] = odds_cells(own, "");
        [name, number.to_string()].into_iter().chain(rest).collect()
    };
    let rounds = diagnosis.rounds.iter().enumerate();
    let fitted = rounds.flat_map(|(k, round)| round.candidates.iter().map(move |own| (k + 1, own)));
    page.folded(
        "All candidates in numbers",
        &Table {
            caption: "Candidates that were fitted: logarithm of their odds over the model before",
            heads: &["candidate", "round", "by features", "by all samples", "left, mm", "why not"],
            rows: fitted.map(row).collect(),
        },
    );
    for (k, round) in diagnosis.rounds.iter().enumerate().filter(|(_, round)| !round.others.is_empty()) {
        page.text(&format!(
            "Not fitted in round {}, because less was promised of them: {}.",
            k + 1,
            round.others.join(", ")
        ));
    }
}

/// What only a diagnosis has among its facts.
fn facts(diagnosis: &Diagnosis) -> Vec<(String, String)> {
    let bars: Vec<String> = diagnosis
        .rounds
        .iter()
        .enumerate()
        .map(|(k, own)| format!("round {}: {:.1}", k + 1, own.bar))
        .collect();
    vec![
        ("most probable nothing that an answer leaves".to_owned(), significant(diagnosis.false_alarm, 2)),
        ("log odds that an answer needs".to_owned(), bars.join(", ")),
        ("nodes".to_owned(), diagnosis.nodes.to_string()),
        ("features and unknowns".to_owned(), format!("{} and {}", diagnosis.features, diagnosis.unknowns)),
        ("simulated releases".to_owned(), diagnosis.runs.to_string()),
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
    use efam_inference::diagnose::verdict::{Gap, Member, Round, Seen, Separation};

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
            (k % 40 != 7).then_some(Sample { time, measured, before, after, amplitude, phase })
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
        let candidate = |name: &str, rejected: Option<&str>| Odds {
            name: name.to_owned(),
            features: 40.0,
            all: rejected.is_none().then_some(133.0),
            share: 0.01,
            rms_mm: rejected.is_none().then_some(0.3),
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
        let seen = Seen {
            release: name.to_owned(),
            what: "frequency in the first cycle".to_owned(),
            unit: "Hz".to_owned(),
            recorded: 1.2,
            before: 1.3,
            after: 1.21,
            deviations: [30.0, 0.5],
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
        let member = Member { effect: "tip_drag".to_owned(), behind: 2.0, distance: Some(1.5) };
        let separation =
            Separation { what: "a longer recording".to_owned(), distance: 6.0, distance_now: 1.5 };
        let added = Added { effect: "air_drag".to_owned(), parameters: vec![value] };
        let diagnosis = Diagnosis {
            verdict,
            summary: format!("A summary of <{name}>."),
            effects: has_effect.then_some(added).into_iter().collect(),
            members: is_class.then_some(member).into_iter().collect(),
            separating_experiment: is_class.then_some(separation),
            rounds: vec![Round {
                bar: 8.1,
                share: 0.02,
                candidates: vec![
                    candidate("air_drag", None),
                    candidate("creep", Some("air_drag explains more")),
                ],
                others: vec!["dahl".to_owned()],
            }],
            seen: vec![seen],
            gap: vec![gap(name, false), gap("held", true)],
            false_alarm: 0.01,
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
                 <td class=\"number\">10</td>",
                "rod.bending_stiffness is fitted: one value for each pressure",
                "air_drag explains more",
                "rms residual over noise",
                "residual, mm",
                "time since release, s",
                "phase, share of a swing",
                "model minus recording, standard deviations",
                "square root of the log odds",
                "less was promised of them: dahl",
                "efam diagnose 15 psi.toml",
                "SHA-256 of 15 psi.csv",
                "0123abcd",
                "19700101T000000Z",
                "round 1: 8.1",
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
