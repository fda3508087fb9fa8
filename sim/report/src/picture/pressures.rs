//! Frequency and damping over pressure, beside what the paper says of its own.
//!
//! Of its measurements the paper's text gives trends alone: they are written into the picture as
//! words at their pressures. No point of them is drawn, for none is published as a number.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Results, on Figure 9.

use crate::picture::chart::Cases;
use crate::picture::panel::{Axis, Key, Panel, Stroke, heading, padded, px};
use crate::picture::{Area, BLACK, BLUE, Drawing, Drawn, Summary, VERMILION, drawn};

/// One pressure's run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureRow {
    /// Pressure above ambient, Pa.
    pub pressure: f64,
    /// By the paper's method from the swing, Hz.
    pub natural_frequency: Option<f64>,
    /// Of the slowest small vibration about the rest, Hz.
    pub mode_frequency: Option<f64>,
    /// By the paper's method from the swing.
    pub damping_ratio: Option<f64>,
}

impl PressureRow {
    /// What a summary says at a pressure, Pa.
    pub fn new(pressure: f64, summary: &Summary) -> Self {
        let mode = summary.modes.as_ref().and_then(|modes| modes.first());
        let [_, natural_frequency, damping_ratio] = summary.as_paper();
        Self {
            pressure,
            natural_frequency,
            mode_frequency: mode.map(|mode| mode.natural_frequency_hz),
            damping_ratio,
        }
    }
}

/// A pound-force per square inch, Pa.
pub const PASCAL_PER_PSI: f64 = 6_894.757_293_168;

/// Two panels over pressure, psi: natural frequency and damping ratio; as SVG. `origin` is where the rows come from:
/// simulated or recorded.
pub fn pressures(name: &str, origin: &str, rows: &[PressureRow]) -> Drawing {
    drawn((1200, 520), |page| {
        heading(page, &format!("{name}: {origin}, beside the trends that the paper's text gives"))?;
        let panels = page.below(px(34.0)).split_evenly((1, 2));
        frequency(rows, &panels[0])?;
        damping(rows, &panels[1])
    })
}

type Points = Vec<(f64, f64)>;

fn points(rows: &[PressureRow], of: impl Fn(&PressureRow) -> Option<f64>) -> Points {
    rows.iter().filter_map(|row| Some((row.pressure / PASCAL_PER_PSI, of(row)?))).collect()
}

/// The rows that have it are the cases of its dots.
fn cases(rows: &[PressureRow], of: impl Fn(&PressureRow) -> Option<f64>) -> Option<Cases> {
    let has = rows.iter().enumerate().filter(|(_, row)| of(row).is_some());
    Some(Cases::Each(has.map(|(k, _)| k).collect()))
}

fn frequency(rows: &[PressureRow], area: &Area) -> Drawn {
    let swing = points(rows, |row| row.natural_frequency);
    let mode = points(rows, |row| row.mode_frequency);
    let (line, small) = (Stroke::new(BLUE, 1.8), Stroke::dashed(VERMILION, 1.8, 7.0, 4.0));
    let spread = spread(&swing).map_or(String::new(), |spread| format!(", spread {:.0} %", 100.0 * spread));
    let keys = [
        Key::line(line, format!("release{spread} (paper: 20 %)")),
        Key::line(small, "first mode about the rest"),
    ];
    let title = "Natural frequency";
    let Some((mut panel, y)) = axes(area, title, "natural frequency, Hz", [&swing, &mode], &keys)? else {
        return Ok(());
    };
    let [upper, lower] = words(y);
    let below = |words: f64| words - 0.035 * (y.1 - y.0);
    panel.strip(30.0..40.0, y.0..below(lower))?;
    panel.line([(10.0, y.0), (10.0, below(upper))].into_iter(), &Stroke::dashed(BLACK, 1.2, 3.0, 3.0))?;
    panel.text((10.0, upper), "paper: highest at 10 psi,")?;
    panel.text((30.0, lower), "lowest at 30 to 40 psi, then a linear rise")?;
    panel.line(swing.iter().copied(), &line)?;
    panel.line(mode.iter().copied(), &small)?;
    panel.of_cases(cases(rows, |row| row.natural_frequency)).dots(swing, &line, 3.5)?;
    panel.of_cases(cases(rows, |row| row.mode_frequency)).rings(mode, &Stroke::new(VERMILION, 1.4), 5.0)
}

fn damping(rows: &[PressureRow], area: &Area) -> Drawn {
    let swing = points(rows, |row| row.damping_ratio);
    let line = Stroke::new(BLUE, 1.8);
    let ratio = match (swing.first(), swing.last()) {
        (Some(first), Some(last)) if swing.len() > 1 => {
            format!(": {:.1} times from {:.0} to {:.0} psi", last.1 / first.1, first.0, last.0)
        }
        _ => String::new(),
    };
    let keys = [Key::line(line, format!("release{ratio} (paper: about 4.5 times)"))];
    let title = "Damping ratio";
    let Some((mut panel, y)) =
        axes(area, title, "damping ratio, dimensionless", [&swing, &Vec::new()], &keys)?
    else {
        return Ok(());
    };
    let [upper, lower] = words(y);
    panel.line(
        [(30.0, y.0), (30.0, lower - 0.035 * (y.1 - y.0))].into_iter(),
        &Stroke::dashed(BLACK, 1.2, 3.0, 3.0),
    )?;
    panel.text((5.0, upper), "paper: rises about 4.5 times from 5 to 100 psi,")?;
    panel.text((30.0, lower), "two thirds of its maximum by 30 psi")?;
    panel.line(swing.iter().copied(), &line)?;
    panel.of_cases(cases(rows, |row| row.damping_ratio)).dots(swing, &line, 3.5)
}

/// Axes with room for two lines of words above the data, and their range of y.
fn axes<'a>(
    area: &Area<'a>,
    title: &str,
    label: &str,
    data: [&Points; 2],
    keys: &[Key],
) -> Drawn<Option<(Panel<'a>, (f64, f64))>> {
    let values = || data.into_iter().flatten().map(|point| point.1);
    if values().next().is_none() {
        return Panel::without_data(area, title, "no run has it").map(|()| None);
    }
    let range = padded(values(), 0.08);
    let y = (range.start.min(0.9 * range.end).max(0.0), range.end + 0.3 * (range.end - range.start));
    let x = 0.0..data.into_iter().flatten().map(|point| point.0).fold(105.0, f64::max);
    let panel = Panel::new(area, title, &Axis(x, "pressure, psi"), &Axis(y.0..y.1, label), keys)?;
    Ok(Some((panel, y)))
}

/// Heights of two lines of words at the top.
fn words((low, high): (f64, f64)) -> [f64; 2] {
    [0.06, 0.14].map(|share| high - share * (high - low))
}

/// How far the largest is above the smallest, as the paper counts it.
fn spread(points: &Points) -> Option<f64> {
    let range = padded(points.iter().map(|point| point.1), 0.0);
    (points.len() > 1).then(|| range.end / range.start - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(psi: f64, frequency: f64) -> PressureRow {
        PressureRow {
            pressure: psi * PASCAL_PER_PSI,
            natural_frequency: Some(frequency),
            mode_frequency: Some(1.02 * frequency),
            damping_ratio: Some(0.06 / frequency),
        }
    }

    #[test]
    fn the_picture_states_our_spread_and_the_papers_words() {
        let rows: Vec<_> =
            (1..=20).map(|k| row(5.0 * f64::from(k), 1.1 + 0.6 * (-0.25 * f64::from(k - 1)).exp())).collect();
        let Drawing { svg, .. } = pressures("all rows", "simulated", &rows);
        if let Ok(folder) = std::env::var("EFAM_LOOK") {
            std::fs::write(format!("{folder}/pressures.svg"), &svg).unwrap();
        }
        // 1.7 to 1.105 Hz.
        assert!(svg.contains("release, spread 54 % (paper: 20 %)"));
        assert!(svg.contains("release: 1.5 times from 5 to 100 psi (paper: about 4.5 times)"));
        assert!(svg.contains("highest at 10 psi") && svg.contains("two thirds of its maximum by 30 psi"));
        // One dot and its rim a run and curve, a ring for each mode: nothing of the paper's.
        assert_eq!(svg.matches("<circle").count(), 5 * rows.len());
    }

    #[test]
    fn runs_without_an_answer_leave_gaps_and_none_at_all_words() {
        let nothing = PressureRow {
            natural_frequency: None,
            mode_frequency: None,
            damping_ratio: None,
            ..row(5.0, 1.0)
        };
        let Drawing { svg, .. } = pressures("one row", "simulated", &[nothing, row(10.0, 1.2)]);
        assert_eq!(svg.matches("<circle").count(), 5);
        assert!(pressures("no rows", "simulated", &[nothing]).svg.contains("no run has it"));
    }
}
