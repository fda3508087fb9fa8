//! A measured release: its swing with peaks and envelope, its spectrum, its damping over amplitude.

use std::f64::consts::TAU;

use efam_experiments::analysis::measured::Measured;

use crate::picture::panel::{Axis, Key, Panel, Stroke, heading, padded, px};
use crate::picture::spectrum::spectrum;
use crate::picture::{Area, BLACK, BLUE, Drawing, Drawn, GREEN, MILLI, VERMILION, drawn};

/// Three panels of one measured release; as SVG.
pub fn measured(name: &str, of: &Measured) -> Drawing {
    drawn((1200, 820), |page| {
        heading(page, &title(name, of))?;
        let rows = page.below(px(34.0)).split_evenly((2, 1));
        let below = rows[1].split_evenly((1, 2));
        swing(of, &rows[0])?;
        frequencies(of, &below[0])?;
        damping(of, &below[1])
    })
}

fn title(name: &str, of: &Measured) -> String {
    match &of.decay {
        Ok(decay) => format!(
            "{name}: natural frequency {:.3} Hz, damping ratio {:.4}",
            decay.natural_frequency / TAU,
            decay.damping_ratio
        ),
        Err(why) => format!("{name}: {why}"),
    }
}

pub(super) fn swing(of: &Measured, area: &Area) -> Drawn {
    let step = of.bridged.step;
    let end = step * of.bridged.values.len() as f64;
    let rest = of.rest;
    let (line, top) = (Stroke::new(BLUE, 1.3), Stroke::new(VERMILION, 1.0));
    let (curve, level) = (Stroke::dashed(GREEN, 2.0, 12.0, 4.0), Stroke::dashed(BLACK, 1.2, 9.0, 5.0));
    let letter = of.coordinate.letter();
    let keys = [
        Key::line(line, format!("{letter}(t), short gaps bridged for the spectrum")),
        Key::line(level, "rest"),
        Key::dot(top, "upper peaks"),
        Key::line(curve, "eq. 6 fitted to them"),
    ];
    let values = of.bridged.values.iter().map(|value| MILLI * value);
    let title = format!("The swing, {}", of.coordinate.title());
    let y = Axis(padded(values.clone().chain([MILLI * rest]), 0.06), &format!("{letter}, mm"));
    let mut panel = Panel::new(area, &title, &Axis(0.0..end, "time since release, s"), &y, &keys)?;
    panel.line([(0.0, MILLI * rest), (end, MILLI * rest)].into_iter(), &level)?;
    panel.line(values.enumerate().map(|(k, value)| (step * k as f64, value)), &line)?;
    if let Ok(decay) = &of.decay {
        let times = (0..=200).map(|k| k as f64 / 200.0 * end);
        panel.line(times.map(|time| (time, MILLI * (rest + decay.envelope(time)))), &curve)?;
    }
    panel.dots(of.peaks.iter().map(|peak| (peak.time, MILLI * (rest + peak.height))), &top, 3.5)
}

pub(super) fn frequencies(of: &Measured, area: &Area) -> Drawn {
    let title = "Amplitude spectrum";
    match &of.damped_frequency {
        Ok(damped) => spectrum(area, title, &of.spectrum, damped / TAU, &[]),
        Err(why) => Panel::without_data(area, title, why),
    }
}

pub(super) fn damping(of: &Measured, area: &Area) -> Drawn {
    let title = "Damping ratio over amplitude, cycle by cycle";
    let cycles = match &of.cycles {
        Ok(cycles) => cycles,
        Err(why) => return Panel::without_data(area, title, why),
    };
    let (each, fitted) = (Stroke::new(BLUE, 1.4), Stroke::dashed(GREEN, 2.0, 12.0, 4.0));
    let of_fit = of.decay.as_ref().ok().map(|decay| decay.damping_ratio);
    let mut keys = vec![Key::dot(each, "from each peak to the next")];
    keys.extend(of_fit.map(|ratio| Key::line(fitted, format!("eq. 6, {ratio:.4}"))));
    let points: Vec<(f64, f64)> =
        cycles.iter().map(|cycle| (MILLI * cycle.amplitude, cycle.damping_ratio)).collect();
    let x = 0.0..1.08 * points.iter().map(|point| point.0).fold(f64::MIN_POSITIVE, f64::max);
    let y = padded(points.iter().map(|point| point.1).chain(of_fit).chain([0.0]), 0.08);
    let end = x.end;
    let axes = (Axis(x, "amplitude, mm"), Axis(y, "damping ratio, dimensionless"));
    let mut panel = Panel::new(area, title, &axes.0, &axes.1, &keys)?;
    panel.line(of_fit.into_iter().flat_map(|ratio| [(0.0, ratio), (end, ratio)]), &fitted)?;
    panel.line(points.iter().copied(), &each)?;
    panel.dots(points, &each, 3.0)
}
