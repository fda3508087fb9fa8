//! A fitted rod over the first swing of each release, against the markers that were seen then.

use std::ops::ControlFlow;

use efam_core::forward::{Run, forward};
use efam_core::quantile::usual_step;
use efam_core::rest::rest;
use efam_inference::calibrate::unknowns::RELEASE_INSTANT;
use efam_inference::calibrate::{CalibrationOutcome, Curve, Problem, Trial};

use crate::picture::panel::{Axis, Drawn, Key, Panel, Stroke, equal_scale, padded, plot_size};
use crate::picture::{Area, BLACK, BLUE, MILLI, Picture, VERMILION, drawn};

/// Shapes in the first swing.
const SHAPES: usize = 9;

/// A picture for each release that was measured.
pub fn against_markers(problem: &Problem, outcome: &CalibrationOutcome) -> Vec<Picture> {
    let held = outcome.calibration.as_held(problem);
    let picture = |(k, trial): (usize, &Trial)| {
        let curves = || outcome.curves.iter().filter(|curve| curve.release == trial.release.name);
        let late = outcome.calibration.nuisance(&trial.release.name, RELEASE_INSTANT);
        let rods = rods(trial, curves().next()?, late);
        if rods.is_empty() {
            return None;
        }
        let markers: Vec<[f64; 2]> =
            rods.iter().flat_map(|(time, _)| curves().filter_map(|curve| seen(curve, *time))).collect();
        Some(Picture {
            name: format!("shapes-{:02}", k + 1),
            title: format!("Shapes against markers: {}", trial.release.name),
            caption: format!(
                "The fitted rod at {} instants of its first swing, and the markers then.",
                rods.len()
            ),
            drawing: drawn((760, 640), |page| draw(page, &rods, &markers)),
        })
    };
    held.trials().enumerate().filter_map(picture).collect()
}

/// The rod, m, at instants of the first swing at which a marker was seen, s, on the clock of the recording; the
/// rod was let go so late on that.
fn rods(trial: &Trial, curve: &Curve, late: f64) -> Vec<(f64, Vec<[f64; 2]>)> {
    let last = trial.release.time.last().copied().unwrap_or(0.0);
    let modes = rest(&trial.model, last, 1).and_then(|rest| rest.modes);
    let period = modes.ok().and_then(|modes| Some(1.0 / modes.first()?.0)).unwrap_or(last);
    let end = period.min(last);
    let instants = (0..SHAPES).map(|k| end * k as f64 / (SHAPES - 1) as f64);
    let mut samples: Vec<f64> =
        instants.filter_map(|instant| curve.time.get(nearest(curve, instant)?).copied()).collect();
    samples.dedup();
    samples.iter_mut().for_each(|time| *time -= late);
    samples.retain(|time| (0.0..=last).contains(time));
    let Some(end) = samples.last().copied() else { return Vec::new() };
    let mut rods = Vec::new();
    // As far as it can be run.
    let _ = forward(&trial.model, &Run { samples, duration: end, ..trial.run.clone() }, &mut |sample| {
        let snapshot = sample.snapshot();
        rods.push((snapshot.time + late, [snapshot.nodes, vec![snapshot.tip]].concat()));
        ControlFlow::Continue(())
    });
    rods
}

/// Where a marker was seen at a time, to half of what its samples are from one another.
fn seen(curve: &Curve, time: f64) -> Option<[f64; 2]> {
    let nearest = nearest(curve, time)?;
    let step = usual_step(&curve.time)?;
    ((curve.time[nearest] - time).abs() <= 0.5 * step).then(|| curve.measured[nearest])
}

fn nearest(curve: &Curve, time: f64) -> Option<usize> {
    let off = |k: &usize| (curve.time[*k] - time).abs();
    (0..curve.time.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
}

fn draw(area: &Area, rods: &[(f64, Vec<[f64; 2]>)], markers: &[[f64; 2]]) -> Drawn {
    let (line, dot) = (Stroke::new(BLUE, 1.8), Stroke::new(VERMILION, 1.6));
    let keys = [Key::line(line, "fitted rod, later ones lighter"), Key::ring(dot, "marker")];
    let all = || rods.iter().flat_map(|(_, rod)| rod).chain(markers);
    let range = |axis: usize| padded(all().map(|place| MILLI * place[axis]), 0.06);
    let (x, z) = equal_scale(range(0), range(1), plot_size(area, &keys));
    let mut panel = Panel::new(area, "Shapes against markers", &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    for (k, (_, rod)) in rods.iter().enumerate() {
        let stroke = Stroke { alpha: 1.0 - 0.6 * k as f64 / rods.len() as f64, ..line };
        panel.line(rod.iter().map(|[x, z]| (MILLI * x, MILLI * z)), &stroke)?;
    }
    panel.rings(markers.iter().map(|[x, z]| (MILLI * x, MILLI * z)), &dot, 4.5)?;
    panel.dots([(0.0, 0.0)], &Stroke::new(BLACK, 1.0), 4.0)
}
