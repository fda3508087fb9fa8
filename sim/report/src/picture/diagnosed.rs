//! Pictures of a diagnosis: gaps before and after, what the residual looks like, who was asked and what
//! they said. One colour and mark is before, a ring in vermilion, another after, a dot in blue.

use efam_inference::diagnose::verdict::{Evidence, Gap, Shape};
use efam_inference::diagnose::{Curve, Diagnosis};

use crate::picture::diagnosed_residual::{after, before, over_swing, over_time};
use crate::picture::panel::{Axis, Key, Panel, Row, Stroke, heading, px};
use crate::picture::{Area, BLACK, BLUE, Drawn, GREY, Picture, drawn};

/// Candidates drawn of a round, at most.
const SHOWN: usize = 12;
/// Height of a row, and of all that is above and below the rows, pixels.
const ROW: f64 = 40.0;
const AROUND: f64 = 150.0;
/// Width of a picture and of its rows' names, pixels.
const WIDTH: u32 = 760;
const NAMES: f64 = 230.0;

/// All pictures of a diagnosis, in the order in which one would look at them.
pub fn diagnosed(diagnosis: &Diagnosis, curves: &[Curve]) -> Vec<Picture> {
    let mut pictures = Vec::new();
    if !diagnosis.gap.is_empty() {
        pictures.push(gap(&diagnosis.gap));
    }
    let leading: Vec<&Curve> = curves.iter().filter(|curve| curve.is_leading).collect();
    pictures.extend(leading.iter().enumerate().map(|(k, curve)| over_time(k + 1, curve)));
    let fitted: Vec<&Curve> = leading.into_iter().filter(|curve| !curve.held_out).collect();
    pictures.extend(over_swing(&fitted));
    if !diagnosis.shapes.is_empty() {
        pictures.push(shapes(&diagnosis.shapes));
    }
    for (k, threshold) in diagnosis.thresholds.iter().enumerate() {
        let own: Vec<&Evidence> =
            diagnosis.evidence.iter().filter(|evidence| evidence.round == k + 1).take(SHOWN).collect();
        if !own.is_empty() {
            pictures.push(ranking(k + 1, &own, *threshold));
        }
    }
    pictures
}

fn height(rows: usize) -> u32 {
    (AROUND + ROW * rows as f64) as u32
}

fn gap(gaps: &[Gap]) -> Picture {
    let rows: Vec<Row> = gaps
        .iter()
        .map(|gap| Row {
            name: gap.release.clone(),
            note: format!(
                "{}{:.2} to {:.2} mm",
                if gap.held_out { "held out, " } else { "" },
                gap.before_mm,
                gap.after_mm
            ),
        })
        .collect();
    let most = gaps.iter().map(|gap| gap.before.max(gap.after)).fold(1.0, f64::max);
    let join = Stroke::new(GREY, 1.2);
    let noise = Stroke::dashed(BLACK, 1.4, 6.0, 4.0);
    let keys = [Key::ring(before(), "before"), Key::dot(after(), "after"), Key::line(noise, "noise alone")];
    let drawing = drawn((WIDTH, height(rows.len())), |page| {
        let x = Axis(0.0..1.06 * most, "rms residual over noise");
        let mut panel = Panel::rows(page, "Gap between simulation and recordings", &x, &rows, NAMES, &keys)?;
        let end = 0.5 - rows.len() as f64;
        panel.strip(0.0..1.0, end..0.5)?;
        panel.line([(1.0, end), (1.0, 0.5)].into_iter(), &noise)?;
        if let Some(first) = gaps.iter().position(|gap| gap.held_out).filter(|first| *first > 0) {
            let y = 0.5 - first as f64;
            panel.line([(0.0, y), (1.06 * most, y)].into_iter(), &Stroke::new(BLACK, 1.0))?;
        }
        for (k, gap) in gaps.iter().enumerate() {
            let at = |value: f64| (value, -(k as f64));
            panel.line([at(gap.before), at(gap.after)].into_iter(), &join)?;
            panel.rings([at(gap.before)], &before(), 6.0)?;
            panel.dots([at(gap.after)], &after(), 5.0)?;
        }
        Ok(())
    });
    Picture {
        name: "gap".to_owned(),
        title: "Gap between simulation and recordings".to_owned(),
        caption: "Rms residual of each release over its noise; 1 is noise alone. Below the line: held-out releases. Outliers that are held back do not count.".to_owned(),
        drawing,
    }
}

fn shapes(shapes: &[Shape]) -> Picture {
    let last = shapes.iter().map(|shape| shape.round).max().unwrap_or(1);
    let mut words: Vec<&str> = Vec::new();
    for shape in shapes {
        if !words.contains(&shape.what.as_str()) {
            words.push(&shape.what);
        }
    }
    let rows: Vec<Row> =
        words.iter().map(|what| Row { name: (*what).to_owned(), note: String::new() }).collect();
    let share = |shape: &Shape| shape.score / shape.threshold.max(f64::MIN_POSITIVE);
    let most = shapes.iter().map(share).fold(1.0, f64::max);
    let line = Stroke::dashed(BLACK, 1.4, 6.0, 4.0);
    let of_last = if last > 1 { "with the added effects" } else { "baseline" };
    let mut keys = vec![Key::dot(after(), of_last), Key::line(line, "threshold")];
    if last > 1 {
        keys.insert(0, Key::ring(before(), "before"));
    }
    let drawing = drawn((WIDTH + 120, height(rows.len())), |page| {
        let x = Axis(0.0..1.06 * most, "score over its threshold");
        let title = "Residual patterns";
        let mut panel = Panel::rows(page, title, &x, &rows, NAMES + 120.0, &keys)?;
        panel.line([(1.0, 0.5 - rows.len() as f64), (1.0, 0.5)].into_iter(), &line)?;
        let of_round = |round: usize| {
            let own = shapes.iter().filter(move |shape| shape.round == round);
            let row = |what: &str| words.iter().position(|word| *word == what).unwrap_or(0);
            own.map(|shape| (share(shape), -(row(&shape.what) as f64))).collect::<Vec<_>>()
        };
        if last > 1 {
            panel.rings(of_round(1), &before(), 6.0)?;
        }
        panel.dots(of_round(last), &after(), 5.0)
    });
    Picture {
        name: "shapes".to_owned(),
        title: "Residual patterns".to_owned(),
        caption: "Residual patterns by harmonic and amplitude, scored as effects are. Right of the line: above the threshold. They do not depend on the catalogue.".to_owned(),
        drawing,
    }
}

fn ranking(round: usize, evidence: &[&Evidence], threshold: f64) -> Picture {
    let rows: Vec<Row> = evidence
        .iter()
        .map(|own| Row {
            name: own.effect.clone(),
            note: own.rejected.clone().unwrap_or_else(|| "in the answer".to_owned()),
        })
        .collect();
    let (chosen, other) = (Stroke::new(BLUE, 1.4), Stroke::new(GREY, 1.6));
    let line = Stroke::dashed(BLACK, 1.4, 6.0, 4.0);
    let title = format!("Candidates of round {round}");
    let drawing = drawn((1160, height(rows.len()) + 30), |page| {
        heading(page, &title)?;
        let (left, right) = page.below(px(30.0)).split_horizontally(px(750.0));
        scores(&left, &rows, evidence, threshold, [&chosen, &other, &line])?;
        decreases(&right, &rows, evidence)
    });
    let left = if evidence.iter().any(|own| own.of_first_swings) {
        "root of the decrease of χ² by each effect when fitted to the first swings alone, and the threshold"
    } else {
        "score of each effect, and the threshold at the false-alarm level"
    };
    Picture {
        name: format!("candidates-{round}"),
        title,
        caption: format!(
            "Left: {left}. Right: predicted and fitted decrease of χ². Below each name: the reason for rejection."
        ),
        drawing,
    }
}

fn scores(
    area: &Area,
    rows: &[Row],
    evidence: &[&Evidence],
    threshold: f64,
    [chosen, other, line]: [&Stroke; 3],
) -> Drawn {
    let most = evidence.iter().map(|own| own.score).fold(threshold, f64::max);
    let keys = [
        Key::dot(*chosen, "in the answer"),
        Key::ring(*other, "rejected"),
        Key::line(*line, format!("threshold, {threshold:.2}")),
    ];
    let x = Axis(0.0..1.06 * most, "score, standard deviations");
    let mut panel = Panel::rows(area, "Score", &x, rows, 400.0, &keys)?;
    panel.line([(threshold, 0.5 - rows.len() as f64), (threshold, 0.5)].into_iter(), line)?;
    let points = |is_chosen: bool| {
        let own = evidence.iter().enumerate().filter(move |(_, own)| own.rejected.is_none() == is_chosen);
        own.map(|(k, own)| (own.score, -(k as f64))).collect::<Vec<_>>()
    };
    panel.rings(points(false), other, 5.0)?;
    panel.dots(points(true), chosen, 5.0)
}

fn decreases(area: &Area, rows: &[Row], evidence: &[&Evidence]) -> Drawn {
    let log = |value: f64| value.max(1.0).log10();
    let all = evidence.iter().flat_map(|own| [Some(own.predicted_decrease), own.realised_decrease]);
    let most = all.flatten().map(log).fold(1.0, f64::max);
    let keys = [Key::ring(before(), "predicted"), Key::dot(after(), "fitted")];
    let x = Axis(0.0..1.06 * most, "log10 of the decrease of χ²");
    let mut panel = Panel::rows(area, "Decrease of χ²", &x, rows, 0.0, &keys)?;
    for (k, own) in evidence.iter().enumerate() {
        let at = |value: f64| (log(value), -(k as f64));
        if let Some(kept) = own.realised_decrease {
            panel.line([at(own.predicted_decrease), at(kept)].into_iter(), &Stroke::new(GREY, 1.2))?;
            panel.dots([at(kept)], &after(), 4.5)?;
        }
        panel.rings([at(own.predicted_decrease)], &before(), 6.0)?;
    }
    Ok(())
}
