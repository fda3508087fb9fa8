//! A calibration as a page.

use std::time::SystemTime;

use efam_experiments::release::Track;
use efam_inference::calibrate::calibration::{Calibrated, Calibration, ReleaseFit, SearchReport};
use efam_inference::calibrate::{CalibrationOutcome, Problem};

use crate::page::{BeforeUse, Masked, Page, Table};
use crate::picture::{Picture, of_calibration};
use crate::report::{significant, significant_or_dash};
use crate::{Request, assumed};

/// The page of a calibration with its pictures; `written` is when.
pub(super) fn page(
    request: &Request,
    problem: &Problem,
    outcome: &CalibrationOutcome,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let calibration = &outcome.calibration;
    let title = format!("Calibration of {}", request.name);
    let mut page = Page::new(&title, &word(calibration), &lead(calibration));
    let of = |name: &str| -> Vec<&Picture> {
        pictures.iter().filter(|picture| picture.name.starts_with(name)).collect()
    };
    page.section("Parameters");
    parameters(&mut page, calibration);
    page.section("Residuals of each release");
    page.all_rods(&of_calibration(problem, outcome));
    page.figures(of("fit-"));
    fits(&mut page, calibration);
    misfits(&mut page, calibration);
    page.figures(of("shapes-"));
    if !of("parameter-").is_empty() {
        page.section("Parameters over pressure");
        page.figures(of("parameter-"));
    }
    page.section("Correlations");
    if calibration.correlations.iter().all(|group| group.names.len() < 2) {
        page.text("Each search found one parameter alone: there is nothing to be correlated with.")
    } else {
        page.figures(of("correlations-"))
    }
    correlations(&mut page, calibration);
    page.section("Stages of the search");
    stages(&mut page, calibration);
    let count = |held_out: bool| {
        calibration.releases.iter().filter(|release| release.held_out == held_out).count().to_string()
    };
    let evaluations: usize = calibration.searches.iter().map(|search| search.evaluations).sum();
    let own = vec![
        ("fitted releases".to_owned(), count(false)),
        ("held-out releases".to_owned(), count(true)),
        ("evaluations of all releases of a search".to_owned(), evaluations.to_string()),
    ];
    page.before_use(&before_use(problem, calibration));
    page.facts_of(request, written, own);
    page.finish()
}

fn word(calibration: &Calibration) -> String {
    let all = calibration.searches.iter().all(|search| search.converged);
    match (all, calibration.parameters.iter().any(|found| found.interval_95.is_none())) {
        (false, _) => "Calibrated, but a search did not converge".to_owned(),
        (true, true) => "Calibrated, but not all parameters are identifiable".to_owned(),
        (true, false) => "Calibrated".to_owned(),
    }
}

/// How well the releases are fitted, and the best and worst known parameter.
fn lead(calibration: &Calibration) -> String {
    let fitted = || calibration.releases.iter().filter(|release| !release.held_out);
    let rms = fitted().flat_map(|release| &release.tracks).map(|track| track.rms_mm);
    let (least, most) =
        rms.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), rms| (low.min(rms), high.max(rms)));
    let count = fitted().count();
    let releases = if count == 1 { "release" } else { "releases" };
    let mut text = format!(
        "{} numbers from {count} {releases}, which the fit meets to {} mm",
        calibration.parameters.len(),
        significant(least, 2)
    );
    if most > 1.05 * least {
        text += &format!(" at best and {} mm at worst", significant(most, 2));
    }
    text += ", root mean square.";
    let known = |found: &&Calibrated| found.relative_error().is_some();
    let error = |found: &&Calibrated| found.relative_error().unwrap_or(f64::INFINITY);
    let mut sorted: Vec<&Calibrated> = calibration.parameters.iter().filter(known).collect();
    sorted.sort_by(|a, b| error(a).total_cmp(&error(b)));
    if let Some(best) = sorted.first() {
        text += &format!(" Best known is {}, to {} %", best.label(), significant(100.0 * error(best), 2));
    }
    if let [_, .., worst] = &sorted[..] {
        text += &format!("; worst {}, to {} %", worst.label(), significant(100.0 * error(worst), 2));
    }
    if sorted.is_empty() { text } else { text + " (standard errors)." }
}

fn before_use(problem: &Problem, calibration: &Calibration) -> BeforeUse {
    let held_out = calibration.releases.iter().filter(|release| release.held_out);
    let finer = |release: &&ReleaseFit| release.numerical_error_mm > 0.0;
    let mesh = calibration.releases.iter().filter(finer).map(|release| {
        format!(
            "{}: to a rod without mesh and steps, from two meshes; that moved the prediction by {} mm, and may be off by {} mm",
            release.name,
            significant(release.numerical_error_mm, 2),
            significant(release.numerical_error_left_mm, 2)
        )
    });
    let tracks = problem.trials.iter().flat_map(|trial| {
        trial.release.tracks.iter().enumerate().map(move |(k, track)| (&trial.release, k, track))
    });
    let row = |(release, k, track): (&efam_experiments::release::Release, usize, &Track)| {
        let absent = track.position.iter().filter(|at| at.is_none()).count();
        let fit = calibration.releases.iter().find(|fit| fit.name == release.name)?;
        let held_back = fit.tracks.get(k)?.held_back;
        let counts = [track.position.len(), absent, held_back].map(|count| count.to_string());
        let names = [release.name.clone(), track.marker.clone()];
        (absent + held_back > 0).then(|| names.into_iter().chain(counts).collect())
    };
    BeforeUse {
        note: Some("Parameters belong to this model: a missing effect biases those that are fitted. efam diagnose tests whether one is missing.".to_owned()),
        warnings: calibration.warnings.clone(),
        held_out: Some(held_out.map(|release| release.name.clone()).collect()),
        extrapolated: Some(mesh.collect()),
        masked: Some(Masked {
            caption: "Samples left out: lost or masked; and outliers that count less",
            heads: &["release", "marker", "samples", "missing", "held back"],
            rows: tracks.filter_map(row).collect(),
        }),
        assumed: assumed::of_problem(problem),
    }
}

fn parameters(page: &mut Page, calibration: &Calibration) {
    let row = |found: &Calibrated| {
        let interval = |k: usize| significant_or_dash(found.interval_95.map(|ends| ends[k]), 5);
        let bound = if found.at_bound { "at its bound" } else { "" };
        vec![
            found.label(),
            significant(found.value, 5),
            significant_or_dash(found.standard_error, 2),
            interval(0),
            interval(1),
            found.unit.clone(),
            significant_or_dash(found.relative_error().map(|error| 100.0 * error), 2),
            significant_or_dash(found.error_inflation, 2),
            bound.to_owned(),
        ]
    };
    let heads = [
        "parameter",
        "value",
        "standard error",
        "95 %, from",
        "to",
        "unit",
        "error, %",
        "inflation",
        "remark",
    ];
    page.table(&Table {
        caption: "Estimates. Inflation: factor on the standard error for correlated residuals",
        heads: &heads,
        rows: calibration.parameters.iter().map(row).collect(),
    });
    page.folded(
        "Nuisance parameters, per recording",
        &Table {
            caption: "Instants, angles and offsets that were fitted with it",
            heads: &heads,
            rows: calibration.nuisances.iter().map(row).collect(),
        },
    );
}

/// Differences of fits and recordings in the quantities that `efam predict` gives.
fn misfits(page: &mut Page, calibration: &Calibration) {
    let percent = |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:+.2}", 100.0 * share));
    let row = |release: &ReleaseFit| {
        let of = &release.misfit;
        vec![
            release.name.clone(),
            significant(1e3 * release.excursion_m, 3),
            significant(of.distance_mm, 2),
            significant(of.rest_mm, 2),
            significant_or_dash(release.measured.frequency_hz, 4),
            percent(of.frequency),
            significant_or_dash(release.measured.damping_ratio, 3),
            percent(of.damping_ratio),
        ]
    };
    page.table(&Table {
        caption: "Difference of fit and recording, without noise. Predictions add it to their intervals",
        heads: &[
            "release",
            "excursion, mm",
            "rms distance, mm",
            "distance at the end, mm",
            "measured frequency, Hz",
            "frequency difference, %",
            "measured damping ratio",
            "its difference, %",
        ],
        rows: calibration.releases.iter().map(row).collect(),
    });
    if let Some(repeats) = &calibration.repeats {
        page.text(&crate::calibrated::repeats_in_words(repeats));
    }
}

fn fits(page: &mut Page, calibration: &Calibration) {
    let mut rows = Vec::new();
    for release in &calibration.releases {
        for track in &release.tracks {
            rows.push(vec![
                release.name.clone(),
                track.marker.clone(),
                if release.held_out { "held out" } else { "fitted" }.to_owned(),
                format!("{:.2}", release.duration_s),
                track.samples.to_string(),
                significant(track.rms_mm, 3),
                significant(track.stated_noise_mm, 3),
                significant(track.reduced_chi_squared, 3),
                format!("{:.2}", track.autocorrelation),
            ]);
        }
    }
    page.table(&Table {
        caption: "Residuals of the fit. χ² of 1 is noise alone; an autocorrelation near 1 shows a remaining misfit",
        heads: &[
            "release",
            "marker",
            "part",
            "up to, s",
            "samples",
            "rms, mm",
            "noise, mm",
            "reduced χ²",
            "autocorrelation",
        ],
        rows,
    });
}

fn correlations(page: &mut Page, calibration: &Calibration) {
    let mut rows = Vec::new();
    for group in &calibration.correlations {
        for (k, name) in group.names.iter().enumerate() {
            for (l, other) in group.names.iter().enumerate().skip(k + 1) {
                rows.push((group.matrix[k][l], vec![name.clone(), other.clone()]));
            }
        }
    }
    rows.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let row = |(value, mut names): (f64, Vec<String>)| {
        names.push(format!("{value:.4}"));
        names
    };
    page.folded(
        "All correlations in numbers",
        &Table {
            caption: "The strongest first",
            heads: &["of", "and", "correlation"],
            rows: rows.into_iter().map(row).collect(),
        },
    );
}

fn stages(page: &mut Page, calibration: &Calibration) {
    let row = |search: &SearchReport, stage: &efam_inference::calibrate::Stage| {
        vec![
            search.releases.join(", "),
            stage.start.to_string(),
            stage.swings.map_or("all".to_owned(), |swings| significant(swings, 3)),
            stage.evaluations.to_string(),
            significant(stage.spread, 3),
            if stage.converged { "yes" } else { "no" }.to_owned(),
        ]
    };
    let rows = calibration.searches.iter();
    page.table(&Table {
        caption: "Stretches that were fitted one after another. Spread: of the residuals, in units of the noise",
        heads: &["releases", "start", "swings", "evaluations", "spread", "came to rest"],
        rows: rows.flat_map(|search| search.stages.iter().map(|stage| row(search, stage))).collect(),
    });
}
