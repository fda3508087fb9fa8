//! Prediction of a case: height of the tip with its interval, damping and frequency over the amplitude, the
//! rod.

use efam_inference::predict::{Band, Cycle, PredictionOutcome};

use crate::picture::panel::{Axis, Key, Panel, Stroke, equal_scale, heading, padded, plot_size, px};
use crate::picture::{Area, BLACK, BLUE, Drawn, GREY, MILLI, ORANGE, Picture, VERMILION, drawn};

/// Four panels.
pub fn predicted(outcome: &PredictionOutcome) -> Picture {
    let prediction = &outcome.prediction;
    let drawing = drawn((1200, 840), |page| {
        heading(page, &format!("Prediction: {}", prediction.name))?;
        let panels = page.below(px(34.0)).split_evenly((2, 2));
        height(&panels[0], &outcome.band)?;
        rod(&panels[1], outcome)?;
        let cycles = &prediction.cycles;
        let damping = |cycle: &Cycle| (cycle.damping_ratio, cycle.damping_ratio_95);
        over_amplitude(&panels[2], "Damping over amplitude", "damping ratio", cycles, damping)?;
        let frequency = |cycle: &Cycle| (cycle.frequency_hz, cycle.frequency_hz_95);
        over_amplitude(&panels[3], "Frequency over amplitude", "damped frequency, Hz", cycles, frequency)
    });
    Picture {
        name: "prediction".to_owned(),
        title: "Predicted release".to_owned(),
        caption: "The band and bars hold 95 % of what the errors of the calibration admit.".to_owned(),
        drawing,
    }
}

fn height(area: &Area, band: &Band) -> Drawn {
    let (line, interval) = (Stroke::new(BLUE, 1.8), Stroke { alpha: 0.4, ..Stroke::new(ORANGE, 1.0) });
    let mut keys = vec![Key::line(line, "tip")];
    if !band.interval_95.is_empty() {
        keys.push(Key::band(interval, "95 % interval at each time"));
    }
    let last = band.time.last().copied().unwrap_or(1.0);
    let ends_of = |side: usize| band.interval_95.iter().map(move |interval| interval[side]);
    let all = band.height.iter().copied().chain(ends_of(0)).chain(ends_of(1)).map(|z| MILLI * z);
    let y = Axis(padded(all, 0.05), "height of the tip, mm");
    let mut panel =
        Panel::new(area, "Height of the tip", &Axis(0.0..last, "time since release, s"), &y, &keys)?;
    let ends = band.interval_95.iter().map(|ends| ends.map(|z| MILLI * z));
    panel.band(band.time.iter().copied().zip(ends), &interval)?;
    panel.line(band.time.iter().copied().zip(band.height.iter().map(|z| MILLI * z)), &line)
}

fn rod(area: &Area, outcome: &PredictionOutcome) -> Drawn {
    let strokes = [Stroke::new(BLUE, 2.2), Stroke::dashed(VERMILION, 1.6, 6.0, 4.0)];
    let keys: Vec<Key> =
        outcome.postures.iter().zip(strokes).map(|((name, _), stroke)| Key::line(stroke, *name)).collect();
    let all = || outcome.postures.iter().flat_map(|(_, rod)| rod).chain([&[0.0, 0.0]]);
    let range = |axis: usize| padded(all().map(|place| MILLI * place[axis]), 0.06);
    let (x, z) = equal_scale(range(0), range(1), plot_size(area, &keys));
    let mut panel = Panel::new(area, "Rod", &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    for ((_, rod), stroke) in outcome.postures.iter().zip(strokes) {
        panel.line(rod.iter().map(|[x, z]| (MILLI * x, MILLI * z)), &stroke)?;
    }
    panel.dots([(0.0, 0.0)], &Stroke::new(BLACK, 1.0), 4.0)
}

/// A number of each cycle with its interval.
fn over_amplitude(
    area: &Area,
    title: &str,
    label: &str,
    cycles: &[Cycle],
    of: impl Fn(&Cycle) -> (f64, Option<[f64; 2]>),
) -> Drawn {
    if cycles.is_empty() {
        return Panel::without_data(area, title, "it does not swing twice");
    }
    let (dot, bar) = (Stroke::new(BLUE, 1.6), Stroke::new(GREY, 1.6));
    let mut keys = vec![Key::dot(dot, "each cycle")];
    if cycles.iter().any(|cycle| of(cycle).1.is_some()) {
        keys.push(Key::line(bar, "95 % interval"));
    }
    let values = cycles.iter().flat_map(|cycle| {
        let (value, interval) = of(cycle);
        [Some(value), interval.map(|ends| ends[0]), interval.map(|ends| ends[1])]
    });
    let y = Axis(padded(values.flatten(), 0.08), label);
    let most = cycles.iter().map(|cycle| MILLI * cycle.amplitude_m).fold(0.0, f64::max);
    let x = Axis(0.0..1.06 * most, "amplitude, mm");
    let mut panel = Panel::new(area, title, &x, &y, &keys)?;
    for cycle in cycles {
        if let Some([low, high]) = of(cycle).1 {
            let x = MILLI * cycle.amplitude_m;
            panel.line([(x, low), (x, high)].into_iter(), &bar)?;
        }
    }
    panel.dots(cycles.iter().map(|cycle| (MILLI * cycle.amplitude_m, of(cycle).0)), &dot, 3.5)
}
