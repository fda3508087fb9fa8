//! The residual before and after: over time, and over phase and amplitude of the swing.

use std::f64::consts::TAU;

use efam_inference::diagnose::Curve;
use efam_inference::diagnose::curve::{BEFORE_AND_AFTER, Predicted, Sample};

use crate::picture::panel::{Axis, Key, Panel, Row, Stroke, heading, px};
use crate::picture::{Area, BLUE, Drawn, GREY, MILLI, Picture, VERMILION, drawn};

/// Points that a line has at most.
const MOST_POINTS: usize = 2000;
/// Standard deviations of the noise that are shaded.
const SHADED: f64 = 2.0;

const PREDICTIONS: [(&str, Predicted); 2] = [("Before", BEFORE_AND_AFTER[0]), ("After", BEFORE_AND_AFTER[1])];

pub(super) fn before() -> Stroke {
    Stroke::new(VERMILION, 1.8)
}

pub(super) fn after() -> Stroke {
    Stroke::new(BLUE, 1.4)
}

/// The residual of the `number`-th release over time.
pub(super) fn over_time(number: usize, curve: &Curve) -> Picture {
    let part = if curve.held_out { ", held out" } else { "" };
    let title = format!("Residual over time: {}{part}", curve.release);
    let sizes = PREDICTIONS.map(|(_, of)| {
        let mut sizes: Vec<f64> = curve.seen().map(|s| MILLI * s.across(of(s)).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get((0.995 * sizes.len() as f64) as usize).copied().unwrap_or(0.0)
    });
    let most = (1.3 * sizes[0].max(sizes[1])).max(1.5 * SHADED * MILLI * curve.noise);
    let drawing = drawn((760, 560), |page| {
        heading(page, &title)?;
        let panels = page.below(px(30.0)).split_evenly((2, 1));
        for (((name, of), stroke), area) in PREDICTIONS.iter().zip([before(), after()]).zip(&panels) {
            one_over_time(area, name, curve, *of, &Stroke { width: 1.2, ..stroke }, most)?;
        }
        Ok(())
    });
    Picture {
        name: format!("residual-{number:02}"),
        caption: format!(
            "Measurement minus prediction of {} across the line from the clamp, in the direction of the swing. Shaded: two standard deviations of the noise.",
            curve.marker
        ),
        title,
        drawing,
    }
}

fn one_over_time(
    area: &Area,
    title: &str,
    curve: &Curve,
    of: Predicted,
    stroke: &Stroke,
    most: f64,
) -> Drawn {
    let times = || curve.seen().map(|sample| sample.time);
    let (Some(first), Some(last)) = (times().next(), times().last()) else {
        return Panel::without_data(area, title, "no samples");
    };
    let shade = Stroke { alpha: 0.35, ..Stroke::new(GREY, 8.0) };
    let keys = [Key::line(*stroke, "measured minus predicted"), Key::line(shade, "noise, two deviations")];
    let (x, y) = (Axis(first.min(0.0)..last, "time since release, s"), Axis(-most..most, "residual, mm"));
    let mut panel = Panel::new(area, title, &x, &y, &keys)?;
    let noise = SHADED * MILLI * curve.noise;
    panel.strip(first.min(0.0)..last, -noise..noise)?;
    let every = curve.samples.len().div_ceil(MOST_POINTS).max(1);
    let point = |s: &Sample| (s.time, (MILLI * s.across(of(s))).clamp(-most, most));
    for piece in curve.samples.split(Option::is_none) {
        panel.line(piece.iter().flatten().step_by(every).map(point), stroke)?;
    }
    Ok(())
}

/// Bands of the amplitude from the largest down, each this share of the one before, and parts of a swing.
const BANDS: usize = 7;
const STEP: f64 = 0.66;
const PHASES: usize = 16;
/// Fewest samples of a mean.
const LEAST_SAMPLES: usize = 3;
/// Radius of the largest mean, pixels.
const LARGEST: f64 = 14.0;

/// Mean residual in a part of the swing.
struct Cell {
    band: usize,
    /// Share of a swing.
    phase: f64,
    /// Mean over the noise of one sample.
    mean: f64,
    /// Its standard error by the noise.
    error: f64,
}

/// The residual of all releases over phase and amplitude of the swing; nothing where there is none.
pub(super) fn over_swing(curves: &[&Curve]) -> Option<Picture> {
    let cells = PREDICTIONS.map(|(_, of)| cells(curves, of));
    let all = || cells.iter().flatten();
    all().next()?;
    let most = all().map(|cell| cell.mean.abs()).fold(0.0, f64::max);
    let title = "Residual over the swing's phase and amplitude";
    let drawing = drawn((760, 860), |page| {
        heading(page, title)?;
        let panels = page.below(px(30.0)).split_evenly((2, 1));
        for (((name, _), cells), area) in PREDICTIONS.iter().zip(&cells).zip(&panels) {
            one_over_swing(area, name, cells, most)?;
        }
        Ok(())
    });
    Some(Picture {
        name: "swing".to_owned(),
        title: title.to_owned(),
        caption: format!(
            "Mean residual of the fitted releases in parts of the swing; phase 0 is the upper turn, 0.5 the lower. The largest mark is {most:.1} times the noise of a sample; means within two of their standard errors are left out. Filled: what was measured lies above what is predicted, hollow: below."
        ),
        drawing,
    })
}

fn cells(curves: &[&Curve], of: Predicted) -> Vec<Cell> {
    let mut sums = vec![[0.0; 2]; BANDS * PHASES];
    for curve in curves {
        for sample in curve.seen() {
            let band = sample.amplitude.max(f64::MIN_POSITIVE).ln() / STEP.ln();
            if band >= BANDS as f64 {
                continue;
            }
            let phase = (sample.phase / TAU).rem_euclid(1.0) * PHASES as f64;
            let cell = band.max(0.0) as usize * PHASES + (phase as usize).min(PHASES - 1);
            sums[cell][0] += sample.across(of(sample)) / curve.noise;
            sums[cell][1] += 1.0;
        }
    }
    let cell = |(k, [sum, count]): (usize, &[f64; 2])| Cell {
        band: k / PHASES,
        phase: ((k % PHASES) as f64 + 0.5) / PHASES as f64,
        mean: sum / count,
        error: count.sqrt().recip(),
    };
    let filled = sums.iter().enumerate().filter(|(_, [_, count])| *count >= LEAST_SAMPLES as f64);
    filled.map(cell).collect()
}

fn one_over_swing(area: &Area, title: &str, cells: &[Cell], most: f64) -> Drawn {
    let bound = |band: usize| 100.0 * STEP.powi(band as i32);
    let rows: Vec<Row> = (0..BANDS)
        .map(|band| Row {
            name: format!("{:.0} to {:.0} %", bound(band + 1), bound(band)),
            note: if band == 0 { "of the largest amplitude".to_owned() } else { String::new() },
        })
        .collect();
    let (above, below) = (Stroke::new(BLUE, 1.0), Stroke::new(VERMILION, 1.8));
    let keys = [Key::dot(above, "measured above predicted"), Key::ring(below, "below")];
    let x = Axis(0.0..1.0, "phase, share of a swing");
    let mut panel = Panel::rows(area, title, &x, &rows, 150.0, &keys)?;
    for cell in cells {
        let (at, size) = ((cell.phase, -(cell.band as f64)), LARGEST * (cell.mean.abs() / most).sqrt());
        if cell.mean.abs() < 2.0 * cell.error {
            panel.dots([at], &Stroke::new(GREY, 1.0), 0.8)?;
        } else if cell.mean > 0.0 {
            panel.dots([at], &above, size)?;
        } else {
            panel.rings([at], &below, size)?;
        }
    }
    Ok(())
}
