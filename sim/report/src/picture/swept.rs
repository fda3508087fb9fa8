//! Sweeps: numbers over each parameter, and maps where two make a grid.

use efam_sweeps::merge::{Kept, Merged, Spread};

use crate::picture::chart::Cases;
use crate::picture::grid::{Number, edges, painted, panels_of_numbers};
use crate::picture::panel::{Axis, Drawn, Panel, Stroke, padded};
use crate::picture::{Area, BLUE, Picture};
use crate::report::readable;

/// Parameters that are drawn, at most.
const MOST: usize = 8;
/// Points from which on their dots are small.
const MANY: usize = 500;

/// All pictures of a sweep.
pub fn swept_pictures(merged: &Merged, kept: &Kept, is_grid: bool) -> Vec<Picture> {
    let varied: Vec<&Spread> = merged.parameters.iter().filter(|own| own.least < own.greatest).collect();
    let mut pictures = Vec::new();
    if let ([x, y], true) = (&varied[..], is_grid && kept.cells[0].len() == merged.points) {
        pictures.extend(maps(merged, kept, x, y));
    }
    for parameter in varied.iter().take(MOST) {
        let (Some(along), label) = (kept.numbers(&parameter.column), label(parameter)) else { continue };
        let factor = readable(&parameter.unit).0;
        let along: Vec<f64> = along.iter().map(|value| factor * value).collect();
        pictures.push(Picture {
            name: format!("over-{}", parameter.column),
            title: format!("Over {}", parameter.name),
            caption: "A dot each point; those that could not be simulated are left out.".to_owned(),
            drawing: panels_of_numbers(&format!("Sweep: {}", merged.name), &|area, number| {
                dots(area, kept, &along, &label, number)
            }),
        });
    }
    pictures
}

fn label(parameter: &Spread) -> String {
    match readable(&parameter.unit).1 {
        "" => parameter.name.clone(),
        unit => format!("{}, {unit}", parameter.name),
    }
}

fn dots(area: &Area, kept: &Kept, along: &[f64], label: &str, number: &Number) -> Drawn {
    let (name, title, y_label, factor) = number;
    let values = kept.numbers(name).unwrap_or_default();
    let points = along.iter().zip(values).map(|(x, y)| (*x, factor * y)).enumerate();
    let (cases, points): (Vec<usize>, Vec<(f64, f64)>) = points.filter(|(_, (_, y))| y.is_finite()).unzip();
    if points.is_empty() {
        return Panel::without_data(area, title, "no point has it");
    }
    let x = Axis(padded(points.iter().map(|point| point.0), 0.04), label);
    let y = Axis(padded(points.iter().map(|point| point.1), 0.06), y_label);
    let size = if points.len() > MANY { 1.4 } else { 2.4 };
    let mut panel = Panel::new(area, title, &x, &y, &[])?;
    panel.of_cases(Some(Cases::Each(cases))).dots(points, &Stroke::new(BLUE, 1.0), size)
}

/// Six maps, where each pair of values is one point.
fn maps(merged: &Merged, kept: &Kept, x: &Spread, y: &Spread) -> Option<Picture> {
    let own = |of: &Spread| -> Option<(Vec<f64>, Vec<f64>)> {
        let all = kept.numbers(&of.column)?;
        let mut distinct = all.clone();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        Some((all, distinct))
    };
    let ((all_x, xs), (all_y, ys)) = (own(x)?, own(y)?);
    let mut points = vec![None; xs.len() * ys.len()];
    for (k, pair) in all_x.iter().zip(&all_y).enumerate() {
        let i = xs.binary_search_by(|own| own.total_cmp(pair.0)).ok()?;
        let j = ys.binary_search_by(|own| own.total_cmp(pair.1)).ok()?;
        points[i * ys.len() + j] = Some(k);
    }
    let (x_label, y_label) = (label(x), label(y));
    let drawing = panels_of_numbers(&format!("Sweep: {}", merged.name), &|area, number| {
        let values = kept.numbers(number.0).unwrap_or_default();
        let value = |i: usize, j: usize| {
            let value = number.3 * values.get(points[i * ys.len() + j]?)?;
            value.is_finite().then_some(value)
        };
        let case = |i: usize, j: usize| points[i * ys.len() + j];
        let x = (edges(&xs, readable(&x.unit).0), x_label.as_str());
        painted(area, number, x, (edges(&ys, readable(&y.unit).0), y_label.as_str()), &value, &case)
    });
    Some(Picture {
        name: "maps".to_owned(),
        title: format!("Over {} and {}", x.name, y.name),
        caption: "Darker is more; the numbers stand in the cells where there is room.".to_owned(),
        drawing,
    })
}
