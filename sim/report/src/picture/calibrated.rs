//! A calibrated release: fit over measurement, residuals, decay and damping; and parameters over
//! pressure.

use efam_experiments::analysis::measured::Measured;
use efam_inference::calibrate::calibration::{Calibrated, Calibration};
use efam_inference::calibrate::misfit::swing_of;
use efam_inference::calibrate::{Curve, Scale};

use crate::picture::panel::{Axis, Key, Panel, Stroke, heading, padded, px};
use crate::picture::{Area, BLACK, BLUE, Drawing, Drawn, GREEN, GREY, MILLI, VERMILION, drawn};

/// Decades of amplitude that the decay is drawn over.
const DECADES: f64 = 2.5;

/// Four panels of one track; as SVG.
pub fn calibrated(curve: &Curve) -> Drawing {
    drawn((1200, 820), |page| {
        heading(page, &format!("{}, {}: fit and measurement", curve.release, curve.marker))?;
        let panels = page.below(px(34.0)).split_evenly((2, 2));
        overlay(curve, &panels[0])?;
        residuals(curve, &panels[1])?;
        let both = [swing_of(curve, &curve.measured), swing_of(curve, &curve.predicted)];
        decay(&both, &panels[2])?;
        damping(&both, &panels[3])
    })
}

fn strokes() -> (Stroke, Stroke) {
    (Stroke::new(GREY, 3.2), Stroke::dashed(BLACK, 1.4, 7.0, 3.0))
}

pub(super) fn overlay(curve: &Curve, area: &Area) -> Drawn {
    let title = "Height of the marker";
    if curve.time.len() < 2 {
        return Panel::without_data(area, title, "no samples");
    }
    let (seen, fitted) = strokes();
    let keys = [Key::line(seen, "measured"), Key::line(fitted, "fitted")];
    let z = |path: &[[f64; 2]]| path.iter().map(|x| MILLI * x[1]).collect::<Vec<_>>();
    let (measured, predicted) = (z(&curve.measured), z(&curve.predicted));
    // What lies far from the fit must not set the scale.
    let y = padded(predicted.iter().copied(), 0.08);
    let inside = |value: &f64| value.clamp(y.start, y.end);
    let x = Axis(0.0..curve.time[curve.time.len() - 1], "time since release, s");
    let mut panel = Panel::new(area, title, &x, &Axis(y.clone(), "z, mm"), &keys)?;
    panel.line(curve.time.iter().copied().zip(measured.iter().map(inside)), &seen)?;
    panel.line(curve.time.iter().copied().zip(predicted), &fitted)
}

pub(super) fn residuals(curve: &Curve, area: &Area) -> Drawn {
    let title = "Measurement minus fit";
    if curve.time.len() < 2 {
        return Panel::without_data(area, title, "no samples");
    }
    let of = |axis: usize| -> Vec<f64> {
        let pairs = curve.measured.iter().zip(&curve.predicted);
        pairs.map(|(seen, fitted)| MILLI * (seen[axis] - fitted[axis])).collect()
    };
    let (x, z) = (of(0), of(1));
    let mut sizes: Vec<f64> = x.iter().chain(&z).map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = (1.6 * sizes[(0.99 * (sizes.len() - 1) as f64) as usize]).max(1e-6);
    let (first, second) = (Stroke::new(BLUE, 1.0), Stroke::new(VERMILION, 1.0));
    let beyond = sizes.iter().filter(|size| **size > most).count();
    let mut keys = vec![Key::dot(first, "in x"), Key::line(second, "in z")];
    if beyond > 0 {
        keys.push(Key::line(Stroke::new(BLACK, 0.0), format!("{beyond} lie beyond the axis")));
    }
    let inside = |value: f64| value.clamp(-most, most);
    let time = Axis(0.0..curve.time[curve.time.len() - 1], "time since release, s");
    let mut panel = Panel::new(area, title, &time, &Axis(-most..most, "residual, mm"), &keys)?;
    panel.line(curve.time.iter().copied().zip(z.into_iter().map(inside)), &second)?;
    panel.dots(curve.time.iter().copied().zip(x.into_iter().map(inside)), &first, 1.2)
}

pub(super) fn decay(both: &[Option<Measured>; 2], area: &Area) -> Drawn {
    let title = "Decay: upper peaks above rest";
    let points = |of: &Option<Measured>| -> Vec<(f64, f64)> {
        let peaks = of.iter().flat_map(|of| &of.peaks).filter(|peak| peak.height > 0.0);
        peaks.map(|peak| (peak.time, (MILLI * peak.height).log10())).collect()
    };
    let (seen, fitted) = (points(&both[0]), points(&both[1]));
    let Some(top) = seen.iter().chain(&fitted).map(|p| p.1).max_by(f64::total_cmp) else {
        return Panel::without_data(area, title, "no upper peaks");
    };
    let low = top - DECADES;
    let shown = |points: Vec<(f64, f64)>| points.into_iter().filter(move |p| p.1 >= low).collect::<Vec<_>>();
    let (seen, fitted) = (shown(seen), shown(fitted));
    let (mark, line) = (Stroke::new(BLUE, 1.0), Stroke::dashed(BLACK, 1.4, 7.0, 3.0));
    let curve = Stroke::dashed(GREEN, 1.6, 2.5, 4.0);
    let keys = [Key::dot(mark, "measured"), Key::line(line, "fitted"), Key::line(curve, "eq. 6, measured")];
    let end = seen.iter().chain(&fitted).map(|p| p.0).fold(0.0, f64::max);
    let x = Axis(0.0..1.05 * end, "time since release, s");
    let y = padded(seen.iter().chain(&fitted).map(|p| p.1), 0.08);
    let mut panel = Panel::new(area, title, &x, &Axis(y.clone(), "log10 of height, mm"), &keys)?;
    panel.line(fitted.iter().copied(), &line)?;
    if let Some(Ok(decay)) = both[0].as_ref().map(|of| &of.decay) {
        let times = (0..=100).map(|k| k as f64 / 100.0 * end);
        let envelope = times.map(|t| (t, (MILLI * decay.envelope(t)).max(1e-9).log10()));
        panel.line(envelope.filter(|p| y.contains(&p.1)), &curve)?;
    }
    panel.dots(seen, &mark, 3.5)
}

pub(super) fn damping(both: &[Option<Measured>; 2], area: &Area) -> Drawn {
    let title = "Damping ratio over amplitude, cycle by cycle";
    let points = |of: &Option<Measured>| -> Vec<(f64, f64)> {
        let cycles = of.iter().filter_map(|of| of.cycles.as_ref().ok()).flatten();
        cycles.map(|cycle| (MILLI * cycle.amplitude, cycle.damping_ratio)).collect()
    };
    let (seen, fitted) = (points(&both[0]), points(&both[1]));
    if seen.is_empty() && fitted.is_empty() {
        return Panel::without_data(area, title, "too few cycles");
    }
    let (mark, line) = (Stroke::new(BLUE, 1.0), Stroke::dashed(BLACK, 1.4, 7.0, 3.0));
    let keys = [Key::dot(mark, "measured"), Key::line(line, "fitted")];
    let of_fit = if fitted.is_empty() { &seen } else { &fitted };
    let range = padded(of_fit.iter().map(|p| p.1), 0.4);
    let y = range.start.min(0.0)..1.6 * range.end;
    let end = seen.iter().chain(&fitted).map(|p| p.0).fold(0.0, f64::max);
    let mut panel = Panel::new(
        area,
        title,
        &Axis(0.0..1.05 * end, "amplitude, mm"),
        &Axis(y.clone(), "damping ratio, dimensionless"),
        &keys,
    )?;
    panel.line(fitted.into_iter(), &line)?;
    panel.dots(seen.into_iter().filter(|p| y.contains(&p.1)), &mark, 3.5)
}

const PASCAL_PER_KILO: f64 = 1e3;
/// Panels of one page.
const MOST_PANELS: usize = 4;

/// Paths of the parameters that have a value for each pressure.
pub(super) fn paths_over_pressure(calibration: &Calibration) -> Vec<String> {
    let mut paths: Vec<String> = Vec::new();
    for found in calibration.parameters.iter().filter(|found| found.pressure_pa.is_some()) {
        if !paths.contains(&found.name) {
            paths.push(found.name.clone());
        }
    }
    paths
}

/// Parameters over pressure with their intervals; as SVG. Nothing where none is one for each pressure.
pub fn over_pressure(name: &str, calibration: &Calibration) -> Option<Drawing> {
    let mut paths = paths_over_pressure(calibration);
    paths.truncate(MOST_PANELS);
    let columns = if paths.len() > 2 { 2 } else { paths.len() };
    if columns == 0 {
        return None;
    }
    let rows = paths.len().div_ceil(columns);
    Some(drawn((600 * columns as u32, 60 + 390 * rows as u32), |page| {
        heading(page, &format!("{name}: calibrated parameters over pressure"))?;
        let panels = page.below(px(34.0)).split_evenly((rows, columns));
        for (path, area) in paths.iter().zip(&panels) {
            one_parameter(path, &calibration.of(path), area)?;
        }
        Ok(())
    }))
}

pub(super) fn one_parameter(path: &str, found: &[&Calibrated], area: &Area) -> Drawn {
    let at = |one: &Calibrated| one.pressure_pa.unwrap_or(0.0) / PASCAL_PER_KILO;
    let bounds = |one: &Calibrated| one.interval_95.unwrap_or([one.value; 2]);
    // Powers of a thousand keep the numbers of the axis short.
    let most = found.iter().map(|one| one.value.abs()).fold(0.0, f64::max);
    let (factor, prefix) = match most {
        most if most > 0.0 && most < 0.1 => (1e3, "1e-3 "),
        _ => (1.0, ""),
    };
    let (mark, bar) = (Stroke::new(BLUE, 1.0), Stroke::new(BLACK, 1.6));
    let keys = [Key::dot(mark, "calibrated"), Key::line(bar, "95 % interval")];
    let log = found.iter().all(|one| one.scale == Scale::Logarithmic);
    let values = found.iter().flat_map(|one| bounds(one).into_iter().chain([one.value])).map(|v| factor * v);
    let y = padded(values, 0.1);
    let y = if log && y.start < 0.0 { 0.0..y.end } else { y };
    let x = padded(found.iter().map(|one| at(one)), 0.08);
    let unit = found.first().map_or("", |one| one.unit.as_str());
    let unit = if unit.is_empty() { "dimensionless" } else { unit };
    let label = format!("{}, {prefix}{unit}", path.rsplit('.').next().unwrap_or(path));
    let mut panel = Panel::new(area, path, &Axis(x, "pressure, kPa"), &Axis(y, &label), &keys)?;
    for one in found {
        panel.line(bounds(one).into_iter().map(|value| (at(one), factor * value)), &bar)?;
    }
    panel
        .line(found.iter().map(|one| (at(one), factor * one.value)), &Stroke::dashed(GREY, 1.0, 3.0, 3.0))?;
    panel.dots(found.iter().map(|one| (at(one), factor * one.value)), &mark, 4.0)
}
