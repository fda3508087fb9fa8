//! Predictions over pressures and payloads: maps where both vary, curves with intervals where one does.

use std::ops::Range;

use efam_inference::predict::grid::{Cell, Grid, PastStraightDown};
use models::digits::significant;
use plotters::prelude::RGBColor;

use crate::picture::chart::Cases;
use crate::picture::panel::{Axis, Drawn, Key, Panel, Stroke, heading, padded, plot_size, px};
use crate::picture::{Area, BLACK, BLUE, Drawing, GREEN, GREY, MILLI, ORANGE, Picture, VERMILION, drawn};

/// Numbers that are drawn: name, title, label of its axis, factor to its unit.
const NUMBERS: [Number; 6] = [
    ("frequency_hz", "Frequency as released", "damped frequency, Hz", 1.0),
    ("damping_ratio", "Damping ratio as released", "damping ratio", 1.0),
    ("rest_z_m", "Height of the tip at rest", "height over the clamp, mm", MILLI),
    ("settling_5_percent_s", "Settled to 5 % after", "time, s", 1.0),
    ("small_frequency_hz", "Frequency of small swings", "natural frequency, Hz", 1.0),
    ("root_moment_n_m", "Largest bending moment at the root", "moment, N m", 1.0),
];
/// Pressures or payloads of a map up to which its cells hold their numbers.
const LEGIBLE: usize = 12;
/// Share of the range from which on a cell is so dark that white is read better on it.
const DARK: f64 = 0.68;
/// Width of a digit in a cell, pixels.
const DIGIT: f64 = 7.5;
/// Steps of the colour bar.
const SHADES: usize = 5;
/// Lines in one panel at most.
const LINES: usize = 5;

/// All pictures of a grid.
pub fn grid_pictures(grid: &Grid) -> Vec<Picture> {
    let (pressures, payloads) = (grid.pressures_pa.len(), grid.payloads_kg.len());
    let mut pictures = Vec::new();
    if pressures > 1 && payloads > 1 {
        pictures.push(Picture {
            name: "maps".to_owned(),
            title: "Over pressure and payload".to_owned(),
            caption: "Darker is more; the numbers stand in the cells where there is room.".to_owned(),
            drawing: six_panels(grid, &|area, number| map(area, grid, number)),
        });
    }
    if pressures > 1 {
        let along = |cell: &Cell| 1e-3 * cell.pressure_pa.unwrap_or(0.0);
        pictures.push(curves(
            grid,
            "over-pressure",
            "pressure, kPa",
            &along,
            &|cell| MILLI * cell.payload_kg,
            "g",
        ));
    }
    if payloads > 1 {
        let of = |cell: &Cell| 1e-3 * cell.pressure_pa.unwrap_or(0.0);
        pictures.push(curves(
            grid,
            "over-payload",
            "payload, g",
            &|cell| MILLI * cell.payload_kg,
            &of,
            "kPa",
        ));
    }
    let answered: Vec<&PastStraightDown> =
        grid.past_straight_down.iter().filter(|past| past.payload_kg.is_some()).collect();
    if answered.len() > 1 {
        pictures.push(Picture {
            name: "past-straight-down".to_owned(),
            title: "Payload that takes the tip past straight down".to_owned(),
            caption: "In a release; bars hold 95 % of what the errors of the calibration admit.".to_owned(),
            drawing: drawn((760, 420), |page| past_straight_down(page, &answered)),
        });
    }
    pictures
}

pub(super) type Number = (&'static str, &'static str, &'static str, f64);

fn six_panels(grid: &Grid, panel: &dyn Fn(&Area, &Number) -> Drawn) -> Drawing {
    panels_of_numbers(&format!("Prediction: {}", grid.name), panel)
}

/// A panel for each of [`NUMBERS`].
pub(super) fn panels_of_numbers(title: &str, panel: &dyn Fn(&Area, &Number) -> Drawn) -> Drawing {
    drawn((1200, 1230), |page| {
        heading(page, title)?;
        let panels = page.below(px(34.0)).split_evenly((3, 2));
        panels.iter().zip(&NUMBERS).try_for_each(|(area, number)| panel(area, number))
    })
}

fn value(cell: &Cell, (name, .., factor): &Number) -> Option<f64> {
    cell.quantity(name)?.value.map(|value| factor * value)
}

/// Cells over pressure and payload, darker where there is more.
fn map(area: &Area, grid: &Grid, number: &Number) -> Drawn {
    let x = (edges(&grid.pressures_pa, 1e-3), "pressure, kPa");
    let y = (edges(&grid.payloads_kg, MILLI), "payload, g");
    let place = |i: usize, j: usize| i * grid.payloads_kg.len() + j;
    painted(area, number, x, y, &|i, j| value(&grid.cells[place(i, j)], number), &|i, j| Some(place(i, j)))
}

/// Cells between edges, darker where there is more of a number; each is a case of the page's family.
pub(super) fn painted(
    area: &Area,
    number: &Number,
    (x, x_label): (Vec<f64>, &str),
    (y, y_label): (Vec<f64>, &str),
    value: &dyn Fn(usize, usize) -> Option<f64>,
    case: &dyn Fn(usize, usize) -> Option<usize>,
) -> Drawn {
    let title = format!("{}, {}", number.1, number.2.rsplit(", ").next().unwrap_or_default());
    let title = if number.2.contains(", ") { title } else { number.1.to_owned() };
    let (columns, rows) = (x.len() - 1, y.len() - 1);
    let all = || (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    let values: Vec<f64> = all().filter_map(|(i, j)| value(i, j)).collect();
    if values.is_empty() {
        return Panel::without_data(area, &title, "no case has it");
    }
    let range = padded(values.into_iter(), 0.0);
    let whole = |edges: &[f64]| edges[0]..edges[edges.len() - 1];
    // The colour bar, in steps.
    let step = |k: usize| {
        let share = k as f64 / (SHADES - 1) as f64;
        let value = range.start + share * (range.end - range.start);
        Key::band(Stroke::new(shade(share), 1.0), significant(value, 3).replace('-', "\u{2212}"))
    };
    let keys: Vec<Key> = (0..SHADES).map(step).collect();
    let (x_axis, y_axis) = (Axis(whole(&x), x_label), Axis(whole(&y), y_label));
    let mut panel = Panel::new(area, &title, &x_axis, &y_axis, &keys)?;
    let per_unit = plot_size(area, &keys).0 / (x[columns] - x[0]);
    let is_legible = columns <= LEGIBLE && rows <= LEGIBLE;
    for (i, j) in all() {
        let Some(value) = value(i, j) else { continue };
        let share = (value - range.start) / (range.end - range.start);
        panel.of_cases(case(i, j).map(Cases::One)).cell(
            x[i]..x[i + 1],
            y[j]..y[j + 1],
            shade(share),
            value,
        )?;
        panel.of_cases(None);
        if is_legible {
            let middle = (0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1]));
            let ink = if share > DARK { RGBColor(255, 255, 255) } else { BLACK };
            let text = significant(value, 3).replace('-', "\u{2212}");
            let room = (x[i + 1] - x[i]) * per_unit;
            if DIGIT * text.chars().count() as f64 <= room {
                panel.number(middle, &text, &ink)?;
            }
        }
    }
    Ok(())
}

/// From nearly white to dark blue, its lightness falling evenly, so that it can be read without colour.
fn shade(share: f64) -> RGBColor {
    let mix = |light: f64, dark: f64| (light + share.clamp(0.0, 1.0) * (dark - light)).round() as u8;
    RGBColor(mix(240.0, 8.0), mix(246.0, 48.0), mix(252.0, 107.0))
}

/// Half way between values, and as far beyond the first and last.
pub(super) fn edges(values: &[f64], factor: f64) -> Vec<f64> {
    let middles = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let (first, last) = (values[0], values[values.len() - 1]);
    let [below, above] = [values[1] - first, last - values[values.len() - 2]].map(|step| 0.5 * step);
    let all = [first - below].into_iter().chain(middles).chain([last + above]);
    all.map(|value| factor * value).collect()
}

/// A line for each of some values of the other variable, with its intervals.
fn curves(
    grid: &Grid,
    name: &str,
    label: &str,
    along: &dyn Fn(&Cell) -> f64,
    of: &dyn Fn(&Cell) -> f64,
    unit: &str,
) -> Picture {
    let mut all: Vec<f64> = grid.cells.iter().map(of).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    let spread = |k: usize| all[k * (all.len() - 1) / (LINES.min(all.len()) - 1).max(1)];
    let mut lines: Vec<f64> = (0..LINES.min(all.len())).map(spread).collect();
    lines.dedup();
    let strokes = [
        Stroke::new(BLUE, 2.0),
        Stroke::dashed(VERMILION, 2.0, 8.0, 4.0),
        Stroke::dashed(GREEN, 2.0, 3.0, 3.0),
        Stroke::new(ORANGE, 2.0),
        Stroke::dashed(BLACK, 1.6, 12.0, 4.0),
    ];
    let has_pressure = !grid.pressures_pa.is_empty();
    let keys = || -> Vec<Key> {
        let name = |line: &f64| format!("{} {unit}", significant(*line, 3));
        if has_pressure || unit == "g" {
            lines.iter().zip(strokes).map(|(line, stroke)| Key::line(stroke, name(line))).collect()
        } else {
            Vec::new()
        }
    };
    let panel = |area: &Area, number: &Number| -> Drawn {
        let factor = number.3;
        let point = |cell: &Cell| Some((along(cell), value(cell, number)?));
        let ends = |cell: &Cell| {
            let ends = cell.quantity(number.0)?.interval_95?;
            Some((along(cell), ends.map(|end| factor * end)))
        };
        let shown = || grid.cells.iter().filter(|cell| lines.contains(&of(cell)));
        if shown().filter_map(point).count() == 0 {
            return Panel::without_data(area, number.1, "no case has it");
        }
        let heights = shown().flat_map(|cell| {
            let ends = ends(cell).map(|(_, ends)| ends);
            [point(cell).map(|point| point.1), ends.map(|ends| ends[0]), ends.map(|ends| ends[1])]
        });
        let x: Range<f64> = padded(shown().map(along), 0.03);
        let y = Axis(padded(heights.flatten(), 0.06), number.2);
        let mut panel = Panel::new(area, number.1, &Axis(x, label), &y, &keys())?;
        for (line, stroke) in lines.iter().zip(strokes) {
            let own = || grid.cells.iter().filter(|cell| of(cell) == *line);
            for (x, [low, high]) in own().filter_map(ends) {
                panel.line(
                    [(x, low), (x, high)].into_iter(),
                    &Stroke { alpha: 0.6, ..Stroke::new(stroke.color, 1.4) },
                )?;
            }
            panel.line(own().filter_map(point), &stroke)?;
            let cases =
                grid.cells.iter().enumerate().filter(|(_, cell)| of(cell) == *line && point(cell).is_some());
            let cases = Some(Cases::Each(cases.map(|(k, _)| k).collect()));
            panel.of_cases(cases).dots(own().filter_map(point), &stroke, 2.6)?;
            panel.of_cases(None);
        }
        Ok(())
    };
    Picture {
        name: name.to_owned(),
        title: format!("Over {}", label.split(',').next().unwrap_or(label)),
        caption: "Bars hold 95 % of what the errors of the calibration admit.".to_owned(),
        drawing: six_panels(grid, &panel),
    }
}

fn past_straight_down(area: &Area, answered: &[&PastStraightDown]) -> Drawn {
    let point = |past: &PastStraightDown| Some((1e-3 * past.pressure_pa?, MILLI * past.payload_kg?));
    let points: Vec<(f64, f64)> = answered.iter().filter_map(|past| point(past)).collect();
    let ends = answered.iter().flat_map(|past| past.interval_95.into_iter().flatten().map(|end| MILLI * end));
    let x = Axis(padded(points.iter().map(|point| point.0), 0.05), "pressure, kPa");
    let y = Axis(padded(points.iter().map(|point| point.1).chain(ends), 0.08), "payload, g");
    let line = Stroke::new(BLUE, 1.8);
    let mut panel = Panel::new(area, "Payload that takes the tip past straight down", &x, &y, &[])?;
    for past in answered {
        if let (Some((x, _)), Some([low, high])) = (point(past), past.interval_95) {
            panel.line([(x, MILLI * low), (x, MILLI * high)].into_iter(), &Stroke::new(GREY, 1.6))?;
        }
    }
    panel.line(points.iter().copied(), &line)?;
    panel.dots(points, &line, 3.5)
}
