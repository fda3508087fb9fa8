//! Pictures of a diagnosis: gaps and features before and after, residuals, and the odds of the candidates. One colour and mark is before, a ring in vermilion, another after, a dot in blue.

use efam_inference::diagnose::verdict::{Gap, Odds, Round, Seen};
use efam_inference::diagnose::{Curve, Diagnosis};

use crate::picture::diagnosed_residual::{after, before, over_swing, over_time};
use crate::picture::panel::{Axis, Key, Panel, Row, Stroke};
use crate::picture::{BLACK, GREY, Picture, drawn};
use crate::report::significant;

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
    if !diagnosis.seen.is_empty() {
        pictures.push(features(&diagnosis.seen));
    }
    let leading: Vec<&Curve> = curves.iter().filter(|curve| curve.is_leading).collect();
    pictures.extend(leading.iter().enumerate().map(|(k, curve)| over_time(k + 1, curve)));
    let fitted: Vec<&Curve> = leading.into_iter().filter(|curve| !curve.held_out).collect();
    pictures.extend(over_swing(&fitted));
    for (k, round) in diagnosis.rounds.iter().enumerate() {
        if !round.candidates.is_empty() {
            pictures.push(ranking(k + 1, round));
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
        caption: "Rms residual of each release over its noise; 1 is noise alone. Below the line: held-out releases.".to_owned(),
        drawing,
    }
}

/// Differences beyond this are drawn at it, standard deviations: a frequency may be off by hundreds of its error.
const FARTHEST: f64 = 20.0;

/// Features as the model has them before and after, against what was recorded.
fn features(seen: &[Seen]) -> Picture {
    let rows: Vec<Row> = seen
        .iter()
        .map(|own| Row {
            name: format!("{}, {}", own.what, own.release),
            note: format!(
                "{} recorded, {} before, {} after",
                significant(own.recorded, 4),
                significant(own.before, 4),
                format!("{} {}", significant(own.after, 4), own.unit).trim_end()
            ),
        })
        .collect();
    let near = |deviations: f64| deviations.clamp(-FARTHEST, FARTHEST);
    let most = seen.iter().flat_map(|own| own.deviations).map(|own| near(own).abs()).fold(3.0, f64::max);
    let zero = Stroke::dashed(BLACK, 1.4, 6.0, 4.0);
    let keys = [Key::ring(before(), "before"), Key::dot(after(), "after"), Key::line(zero, "as recorded")];
    let title = "Features of the recordings";
    let drawing = drawn((WIDTH + 240, height(rows.len())), |page| {
        let x = Axis(-1.06 * most..1.06 * most, "model minus recording, standard deviations");
        let mut panel = Panel::rows(page, title, &x, &rows, NAMES + 240.0, &keys)?;
        let end = 0.5 - rows.len() as f64;
        panel.strip(-2.0..2.0, end..0.5)?;
        panel.line([(0.0, end), (0.0, 0.5)].into_iter(), &zero)?;
        for (k, own) in seen.iter().enumerate() {
            let [was, is] = own.deviations.map(|own| (near(own), -(k as f64)));
            panel.line([was, is].into_iter(), &Stroke::new(GREY, 1.2))?;
            panel.rings([was], &before(), 6.0)?;
            panel.dots([is], &after(), 5.0)?;
        }
        Ok(())
    });
    Picture {
        name: "features".to_owned(),
        title: title.to_owned(),
        caption: format!(
            "What an expert compares: features of the recordings that the answer changes most. Shaded: two standard deviations of what is left. Beyond {FARTHEST:.0} a mark is at the edge."
        ),
        drawing,
    }
}

/// Candidates of a round by their odds.
fn ranking(number: usize, round: &Round) -> Picture {
    let all: Vec<&Odds> = round.candidates.iter().take(SHOWN).collect();
    let rows: Vec<Row> =
        all.iter().map(|own| Row { name: own.name.clone(), note: own.reason().to_owned() }).collect();
    // Odds are of tens and of thousands: their square root shows both.
    let root = |odds: f64| odds.signum() * odds.abs().sqrt();
    let odds = || all.iter().flat_map(|own| [Some(own.features), own.all]).flatten().map(root);
    let most = odds().fold(root(round.bar), f64::max);
    let least = odds().fold(0.0, f64::min).max(-0.5 * most);
    let line = Stroke::dashed(BLACK, 1.4, 6.0, 4.0);
    let keys = [
        Key::ring(before(), "by features"),
        Key::dot(after(), "by all samples"),
        Key::line(line, format!("what an answer needs, {:.1}", round.bar)),
    ];
    let title = format!("Candidates of round {number}");
    let drawing = drawn((WIDTH + 240, height(rows.len())), |page| {
        let x = Axis(1.06 * least..1.06 * most, "square root of the log odds over the model before");
        let mut panel = Panel::rows(page, &title, &x, &rows, NAMES + 240.0, &keys)?;
        let bar = root(round.bar);
        panel.line([(bar, 0.5 - rows.len() as f64), (bar, 0.5)].into_iter(), &line)?;
        for (k, own) in all.iter().enumerate() {
            let at = |odds: f64| (root(odds).max(least), -(k as f64));
            panel.rings([at(own.features)], &before(), 5.0)?;
            if let Some(all) = own.all {
                panel.line([at(own.features), at(all)].into_iter(), &Stroke::new(GREY, 1.2))?;
                panel.dots([at(all)], &after(), 5.0)?;
            }
        }
        Ok(())
    });
    Picture {
        name: format!("candidates-{number}"),
        title,
        caption: "Logarithm of the odds of each candidate over the model before, of which the square root is drawn: by features, and where they were fitted by all samples, which decide. Below each name: why it is not the answer.".to_owned(),
        drawing,
    }
}
