//! An experiment as a page: what was cut, masked and decided, and what its releases say.

use std::f64::consts::TAU;
use std::time::SystemTime;

use efam_experiments::analyse::Analysed;
use efam_experiments::cleaning::{CleanRelease, Cleaned, Decision};
use efam_experiments::experiment::Experiment;
use efam_experiments::out_of_plane;

use crate::Request;
use crate::page::{BeforeUse, Masked, Page, Table, extrapolated};
use crate::picture::Picture;
use crate::report::significant;
use models::digits::with_error;

/// The page of an experiment with its pictures; `written` is when.
pub(super) fn page(
    request: &Request,
    experiment: &Experiment,
    cleaned: &Cleaned,
    analysed: Option<&[Analysed]>,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let (title, word) = match analysed {
        Some(_) => (format!("Analysis of {}", experiment.name), "Analysed"),
        None => (format!("Check of {}", experiment.name), "Checked"),
    };
    let mut page = Page::new(&title, word, &lead(cleaned, analysed));
    let of = |name: &str| -> Vec<&Picture> {
        pictures.iter().filter(|picture| picture.name.starts_with(name)).collect()
    };
    if let Some(analysed) = analysed {
        page.section("Results of the releases");
        numbers(&mut page, analysed);
        page.figures(["frequency", "damping", "stiffness", "tip-error"].into_iter().flat_map(of));
        at_rest(&mut page, analysed);
        page.section("Each release");
        page.figures(of("release-"));
    }
    page.section("Cuts and masks");
    cuts(&mut page, cleaned);
    for picture in of("recording-") {
        page.figure(picture);
    }
    page.section("Decisions in cleaning");
    decisions(&mut page, cleaned);
    let used = cleaned.used().count();
    let own = vec![
        ("recordings".to_owned(), cleaned.recordings.len().to_string()),
        ("releases".to_owned(), format!("{}, {used} of them used", cleaned.releases.len())),
    ];
    page.before_use(&before_use(experiment, cleaned, analysed));
    page.facts_of(request, written, own);
    page.finish()
}

fn lead(cleaned: &Cleaned, analysed: Option<&[Analysed]>) -> String {
    let count = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let used = cleaned.used().count();
    let mut text = format!(
        "{} with {}, of which {used} can be used.",
        count(cleaned.recordings.len(), "recording"),
        count(cleaned.releases.len(), "release")
    );
    let Some(analysed) = analysed else { return text };
    let range = |name: &str, unit: &str, values: Vec<f64>| {
        let least = values.iter().copied().reduce(f64::min)?;
        let most = values.iter().copied().fold(least, f64::max);
        let [low, high] = [least, most].map(|value| significant(value, 3));
        Some(if low == high {
            format!(" {name} is {low}{unit}.")
        } else {
            format!(" {name} lies between {low} and {high}{unit}.")
        })
    };
    let decays = || analysed.iter().filter_map(|one| one.measured.as_ref().ok()?.decay.as_ref().ok());
    let natural = decays().map(|decay| decay.natural_frequency / TAU).collect();
    text += &range("The natural frequency", " Hz", natural).unwrap_or_default();
    let ratios = decays().map(|decay| decay.damping_ratio).collect();
    text += &range("The damping ratio", "", ratios).unwrap_or_default();
    let without = analysed.len() - decays().count();
    if without > 0 {
        text += &format!(" No damping ratio for {}.", count(without, "release"));
    }
    text
}

fn before_use(experiment: &Experiment, cleaned: &Cleaned, analysed: Option<&[Analysed]>) -> BeforeUse {
    let cases = (0..experiment.recordings.len()).filter_map(|k| experiment.case(k, None).ok()?);
    let mut warnings: Vec<String> = cases.flat_map(|case| case.warnings).collect();
    warnings.dedup();
    let (extrapolated, mut warnings) = extrapolated(&warnings);
    warnings.extend(cleaned.releases.iter().filter_map(|release| {
        let why = release.dropped.as_ref()?;
        Some(format!("{} is not used: {why}", release.release.name))
    }));
    warnings.extend(analysed.into_iter().flatten().flat_map(Analysed::warnings));
    let held_out = cleaned.releases.iter().filter(|release| release.release.held_out);
    warnings.extend(
        held_out
            .map(|release| format!("{} is held out: it is analysed, but not fitted", release.release.name)),
    );
    warnings.extend(cleaned.warnings());
    BeforeUse {
        note: analysed.map(|_| "Eq. 6 takes the damping ratio to be one for all amplitudes; where it is not, the picture of each release shows it.".to_owned()),
        warnings,
        held_out: None,
        extrapolated: Some(extrapolated),
        masked: Some(Masked {
            caption: "Samples of the tip that are left out: lost, or masked as spurious",
            heads: &["release", "samples", "lost or masked, %", "masked", "bridged for the spectrum"],
            rows: cleaned.releases.iter().filter_map(|release| lost(release, analysed)).collect(),
        }),
        assumed: assumed(experiment, cleaned, analysed),
    }
}

fn lost(of: &CleanRelease, analysed: Option<&[Analysed]>) -> Option<Vec<String>> {
    let mut own = analysed.into_iter().flatten().filter(|one| one.of.release.name == of.release.name);
    let bridged = own.find_map(|one| Some(one.measured.as_ref().ok()?.bridged.filled));
    let statistics = &of.statistics;
    (statistics.masked_share > 0.0).then(|| {
        vec![
            of.release.name.clone(),
            statistics.samples.to_string(),
            format!("{:.2}", 100.0 * statistics.masked_share),
            statistics.masked_samples.to_string(),
            bridged.map_or("-".to_owned(), |filled| filled.to_string()),
        ]
    })
}

fn assumed(experiment: &Experiment, cleaned: &Cleaned, analysed: Option<&[Analysed]>) -> Vec<String> {
    let mut words = vec![
        "The rod stays in the vertical plane through the clamp's axis; the distance of the tip from it is shown with each recording, and left out.".to_owned(),
        "The tip rests where the decay of its last three periods leads; where that cannot be fitted, at the mean of the end.".to_owned(),
    ];
    words.push(match (experiment.has_model(), analysed) {
        (true, Some(_)) => "Stiffness: the rod, its masses and the pressure are as the experiment file says, and the damping does not move the rest.".to_owned(),
        (true, None) => "The rod is as the experiment file says.".to_owned(),
        (false, _) => "The experiment states no rod, so no stiffness is claimed.".to_owned(),
    });
    words.push(format!(
        "{} more decisions were taken in cleaning; they are listed below, each with the key that decides otherwise.",
        cleaned.decisions.len()
    ));
    words
}

/// A value as people read it, or why there is none.
fn told<E: std::fmt::Display>(value: Result<f64, E>, digits: i32) -> String {
    value.map_or_else(|why| why.to_string(), |value| significant(value, digits))
}

fn numbers(page: &mut Page, analysed: &[Analysed]) {
    let row = |one: &Analysed| {
        let mut row = vec![
            one.of.release.name.clone(),
            one.of.release.pressure.map_or("-".to_owned(), |pressure| significant(1e-3 * pressure, 4)),
            one.static_drop().map_or("-".to_owned(), |drop| significant(1e3 * drop, 4)),
        ];
        match &one.measured {
            Err(error) => row.extend([error.to_string()].into_iter().chain(vec!["-".to_owned(); 4])),
            Ok(measured) => {
                let decay = measured.decay.as_ref();
                let ratio = decay.map(|decay| with_error(decay.damping_ratio, decay.ratio_error));
                row.extend([
                    told(measured.damped_frequency.as_ref().map(|omega| omega / TAU), 4),
                    measured.natural_frequency().map_or("-".to_owned(), |omega| significant(omega / TAU, 4)),
                    ratio.unwrap_or_else(|_| "-".to_owned()),
                    decay.map_or("-".to_owned(), |decay| significant(1e3 * decay.rms_residual, 2)),
                    measured.coordinate.name(),
                ]);
            }
        }
        row.push(match &one.in_motion {
            None => "-".to_owned(),
            Some(found) => told(found.as_ref().map(|found| found.bending_stiffness), 4),
        });
        row
    };
    page.table(&Table {
        caption: "Each release: eq. 6 and 7 along the coordinate; ± is one standard error",
        heads: &[
            "release",
            "pressure, kPa",
            "static drop, mm",
            "damped, Hz",
            "natural, Hz",
            "damping ratio",
            "eq. 6 misses by, mm",
            "coordinate",
            "EI from the frequency, N m²",
        ],
        rows: analysed.iter().map(row).collect(),
    });
}

fn at_rest(page: &mut Page, analysed: &[Analysed]) {
    let mut rows = Vec::new();
    for one in analysed {
        for fit in &one.at_rest {
            let ei = |of: &Result<efam_experiments::analysis::bending_stiffness::StiffnessFit, _>| {
                told(of.as_ref().map(|fit| fit.bending_stiffness), 5)
            };
            let best = fit.gauss_newton.as_ref().or(fit.nelder_mead.as_ref());
            let off = best.map(|fit| 1e3 * fit.residual[0].hypot(fit.residual[1]));
            rows.push(vec![
                one.of.release.name.clone(),
                fit.nodes.map_or("Euler-Bernoulli".to_owned(), |nodes| format!("PDER, {nodes} nodes")),
                ei(&fit.nelder_mead),
                ei(&fit.gauss_newton),
                one.rest
                    .and_then(|rest| fit.relative_error(rest.error))
                    .map_or("-".to_owned(), |error| significant(100.0 * error, 2)),
                off.map_or("-".to_owned(), |off| significant(off, 3)),
                fit.unmodified.map_or("-".to_owned(), |[_, z]| significant(1e3 * z, 4)),
            ]);
        }
    }
    page.folded(
        "Stiffness from the tip at rest, in numbers",
        &Table {
            caption: "EI in N m² with which each model's tip comes nearest to the measured one, by two searches",
            heads: &["release", "model", "Nelder-Mead", "Gauss-Newton", "standard error, %", "tip error, mm", "z without the walk, mm"],
            rows,
        },
    );
}

fn cuts(page: &mut Page, cleaned: &Cleaned) {
    let row = |of: &CleanRelease| {
        let statistics = &of.statistics;
        let kept = match (&of.dropped, of.release.held_out, of.representative) {
            (Some(why), _, _) => format!("dropped: {why}"),
            (None, true, _) => "held out".to_owned(),
            (None, false, true) => "kept, representative".to_owned(),
            (None, false, false) => "kept".to_owned(),
        };
        vec![
            of.release.name.clone(),
            format!("{:.4}", of.instant),
            format!("{:.4}", of.release.release_uncertainty),
            format!("{:.1}", statistics.hold_angle.to_degrees()),
            significant(1e3 * statistics.out_of_plane, 3),
            format!("{:.1}", 100.0 * statistics.out_of_plane_share),
            significant(1e3 * statistics.noise, 2),
            kept,
        ]
    };
    let over = out_of_plane::over_pressures(cleaned.used().map(|used| &used.release));
    let over = over.map_or(String::new(), |over| format!("; from the plane: {}", over.words()));
    let caption = format!("Each release as it was cut{over}");
    page.table(&Table {
        caption: &caption,
        heads: &[
            "release",
            "instant, s",
            "its error, s",
            "hold, deg",
            "from the plane, mm",
            "of the length, %",
            "noise, mm",
            "use",
        ],
        rows: cleaned.releases.iter().map(row).collect(),
    });
}

fn decisions(page: &mut Page, cleaned: &Cleaned) {
    let row = |of: &Decision| vec![of.about.clone(), of.what.clone(), of.key.to_owned()];
    page.folded(
        &format!("All {} decisions", cleaned.decisions.len()),
        &Table {
            caption: "Decisions in cleaning, each with the key of the experiment file that overrides it",
            heads: &["about", "what", "key"],
            rows: cleaned.decisions.iter().map(row).collect(),
        },
    );
}
