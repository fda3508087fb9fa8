//! Pictures of runs, as SVG: readable without colour, and distinguishable for those who see few colours.

mod against_markers;
mod analysed;
mod calibrated;
pub mod chart;
mod compact;
mod diagnosed;
mod diagnosed_residual;
mod drawing;
mod driven;
mod fitted;
mod grid;
mod linear;
mod lines;
mod matrix;
mod measured;
mod panel;
mod paper;
mod pixels;
mod predicted;
mod pressures;
mod recording;
mod released;
mod rods;
mod spectrum;
mod swept;
mod text;
mod tips;

use efam_core::rest::Rest;
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::analysis::coordinate::Coordinate;
use efam_experiments::summary::{OfCoordinate, Summary, Swings};
use models::model::Model;
use models::snapshot::Energy;
use models::system::System;
use plotters::prelude::RGBColor;

use crate::report::significant;

use drawing::{Sheet as Area, drawn};
use panel::{Axis, Drawn, Key, Panel, Stroke, equal_scale, heading, padded, plot_size, px};
use text::tick;

pub use against_markers::against_markers;
pub use analysed::{analysed, recordings};
pub use calibrated::{calibrated, over_pressure};
pub use compact::dotted;
pub use diagnosed::diagnosed;
pub use drawing::Drawing;
pub use fitted::fitted;
pub use grid::grid_pictures;
pub use linear::linear_pictures;
pub use lines::Named;
pub use measured::measured;
pub use paper::{are_recorded, every_other, example, in_psi, model as model_name, models, paper};
pub use predicted::predicted;
pub use pressures::{PASCAL_PER_PSI, PressureRow, pressures};
pub use recording::recording;
pub use released::{in_motion, released};
pub use rods::{Rod, Rods, of_calibration, of_diagnosis, of_family, rod_of_case, rod_of_run};
pub use swept::swept_pictures;
pub use tips::{Tip, over_pressure_and_amplitude, over_pressures, tips, tips_of_runs};

const BLACK: RGBColor = RGBColor(0, 0, 0);
const GREY: RGBColor = RGBColor(110, 110, 110);
// Source: Okabe and Ito (2008), Color universal design.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Of what is drawn only while a reader chooses it. Source: Tol (2021), muted scheme.
const CHOSEN: RGBColor = RGBColor(136, 34, 85);

const MILLI: f64 = 1e3;
/// Folder of the pictures that a page shows.
pub const PICTURES: &str = "pictures";
/// Postures drawn in the first swing.
const SHAPES: usize = 24;
/// Swings over which the energies are drawn.
const ENERGY_SWINGS: f64 = 6.0;
/// Time over which the height is drawn, in times of settling to 2 %.
const SETTLED_TIMES: f64 = 1.5;

/// A picture with what it shows in words.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of its file, without the ending.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// As drawn, and its charts.
    pub drawing: Drawing,
}

impl Picture {
    /// As SVG.
    pub fn svg(&self) -> &str {
        &self.drawing.svg
    }

    /// Its place among the pictures of a folder.
    pub fn file(&self) -> String {
        format!("{PICTURES}/{}.svg", self.name)
    }
}

/// What the picture of a run shows.
#[derive(Clone, Copy)]
pub struct ReleasePicture<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its run.
    pub trajectory: &'a Trajectory,
    /// Whether the run followed its energy.
    pub energy_followed: bool,
    /// Where it comes to rest, if that is known.
    pub rest: Option<&'a Rest>,
    /// Its numbers.
    pub summary: &'a Summary,
    /// Its spectra and decays.
    pub swings: &'a Swings,
}

/// Four panels of one run: shapes, height of the tip, energies, spectrum.
pub fn release(of: &ReleasePicture) -> Drawing {
    drawn((1200, 820), |page| {
        heading(page, &title(of.summary))?;
        let panels = page.below(px(34.0)).split_evenly((2, 2));
        shapes(of, &panels[0])?;
        let along = of.swings.coordinate.as_ref();
        swing(of, along, &panels[1])?;
        energies(of, &panels[2])?;
        spectrum(of, along, &panels[3])
    })
}

fn title(summary: &Summary) -> String {
    let status = match &summary.status {
        Status::Complete => String::new(),
        Status::CutShort { time } => format!(", cut short at {time:.2} s"),
        Status::Failed { time, .. } => format!(", failed at {time:.4} s"),
    };
    let swing = match (summary.natural_frequency_hz, summary.damping_ratio) {
        (Some(hz), Some(ratio)) => {
            format!(": natural frequency {hz:.3} Hz, damping ratio {}", significant(ratio, 3))
        }
        _ => String::new(),
    };
    format!("{}{status}{swing}", summary.name)
}

fn shapes(of: &ReleasePicture, area: &Area) -> Drawn {
    let trajectory = of.trajectory;
    let title = "Shape in the first swing";
    if trajectory.times.len() < 2 {
        return Panel::without_data(area, title, "no samples");
    }
    let end =
        of.summary.peaks.as_ref().and_then(|peaks| peaks.first()).map_or(f64::INFINITY, |peak| peak.time_s);
    let count = trajectory.times.iter().take_while(|time| **time <= end).count();
    let every = count.div_ceil(SHAPES).max(1);
    let mut system = System::new(of.model);
    let mut posture = |sample: usize| -> Vec<[f64; 2]> {
        let state = trajectory.state(sample);
        let mut nodes = system.assembly.posture(&state.q, &state.v).nodes;
        nodes.push(trajectory.tip[sample]);
        nodes
    };
    let least_angle = |&a: &usize, &b: &usize| {
        let angle = |sample: usize| trajectory.state(sample).q[2 * of.model.edges];
        angle(a).total_cmp(&angle(b))
    };
    let turn = (0..count).min_by(least_angle).unwrap_or(0);
    let drawn: Vec<usize> = (0..count).step_by(every).collect();
    let postures: Vec<(usize, Vec<[f64; 2]>)> = drawn.iter().map(|&k| (k, posture(k))).collect();

    let spacing = MILLI * every as f64 * (trajectory.times[1] - trajectory.times[0]);
    let down = |alpha| Stroke { alpha, ..Stroke::new(BLUE, 1.6) };
    let up = |alpha| Stroke { alpha, ..Stroke::dashed(VERMILION, 1.6, 7.0, 4.0) };
    let (rest_stroke, trail) = (Stroke::new(BLACK, 3.5), Stroke::dashed(GREY, 1.4, 1.5, 3.5));
    let keys = [
        Key::line(down(1.0), format!("down, every {} ms", tick(spacing))),
        Key::line(up(1.0), "and back"),
        Key::line(rest_stroke, "rest"),
        Key::line(trail, "tip"),
    ];
    let length = of.model.rod().length;
    let every_point = || {
        let rest = of.rest.iter().flat_map(|rest| rest.nodes.iter().chain([&rest.tip]));
        postures.iter().flat_map(|(_, nodes)| nodes).chain(&trajectory.tip[..count]).chain(rest)
    };
    let corners = [[-0.12 * length; 2], [0.12 * length; 2]];
    let range = |k: usize| padded(every_point().chain(&corners).map(|point| MILLI * point[k]), 0.03);
    let (x, z) = equal_scale(range(0), range(1), plot_size(area, &keys));
    let mut panel = Panel::new(area, title, &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;

    clamp(&mut panel, of.model, length)?;
    panel.line(trajectory.tip[..count].iter().map(in_milli), &trail)?;
    for (sample, nodes) in &postures {
        let (stroke, from, to) =
            if *sample <= turn { (down as fn(f64) -> Stroke, 0, turn) } else { (up as _, turn, count) };
        let share = (*sample - from) as f64 / (to - from).max(1) as f64;
        panel.line(nodes.iter().map(in_milli), &stroke(0.3 + 0.7 * share))?;
        panel.dots(nodes.last().map(in_milli), &stroke(0.3 + 0.7 * share), 2.5)?;
    }
    if let Some(rest) = of.rest {
        panel.line(rest.nodes.iter().map(in_milli), &rest_stroke)?;
        let fitting = [rest.nodes[rest.nodes.len() - 1], rest.tip];
        panel.line(fitting.iter().map(in_milli), &Stroke::new(BLACK, 7.0))?;
    }
    Ok(())
}

fn in_milli(point: &[f64; 2]) -> (f64, f64) {
    (MILLI * point[0], MILLI * point[1])
}

/// Direction of the clamp, rad.
fn base_angle(model: &Model) -> f64 {
    model.parameters.iter().position(|p| p.path == "rod.base_angle").map_or(0.0, |k| model.theta[k])
}

/// A hatched wall behind the root, normal to the direction of the clamp.
fn clamp(panel: &mut Panel, model: &Model, length: f64) -> Drawn {
    let (sin, cos) = base_angle(model).sin_cos();
    let at = |along: f64, across: f64| {
        (MILLI * length * (along * cos - across * sin), MILLI * length * (along * sin + across * cos))
    };
    panel.line([at(0.0, -0.1), at(0.0, 0.1)].into_iter(), &Stroke::new(BLACK, 3.0))?;
    for k in -4..=4 {
        let across = 0.022 * f64::from(k);
        panel
            .line([at(-0.04, across - 0.02), at(0.0, across + 0.01)].into_iter(), &Stroke::new(BLACK, 1.0))?;
    }
    Ok(())
}

/// Time up to which a run is drawn, s: until it has settled after its event, and half of that more.
fn settled(summary: &Summary) -> f64 {
    let event = summary.event_s.unwrap_or(0.0);
    summary.settling_2_percent_s.map_or(f64::INFINITY, |time| event + SETTLED_TIMES * time)
}

/// The tip along a coordinate until it settles, with its upper peaks and eq. 6; its height where there is no coordinate.
fn swing(of: &ReleasePicture, along: Option<&OfCoordinate>, area: &Area) -> Drawn {
    let trajectory = of.trajectory;
    let end = of.summary.simulated_s.min(settled(of.summary));
    let coordinate = along.map_or(Coordinate::HEIGHT, |along| along.coordinate);
    let title = if end < of.summary.simulated_s { "The tip until it settles, " } else { "The tip, " };
    let title = format!("{title}{}", coordinate.title());
    if trajectory.times.len() < 2 {
        return Panel::without_data(area, &title, "no samples");
    }
    let letter = coordinate.letter();
    let begin = along.map_or(0.0, |along| along.begin);
    let rest = along.map(|along| along.rest).or(of.rest.map(|rest| coordinate.of(rest.tip)));
    let envelope: Vec<(f64, f64)> = match (along.map(|along| &along.swing.decay), rest) {
        (Some(Ok(decay)), Some(rest)) => (0..=200)
            .map(|k| k as f64 / 200.0 * end)
            .map(|time| begin + time)
            .filter(|time| *time <= end)
            .map(|time| (time, MILLI * (rest + decay.envelope(time - begin))))
            .collect(),
        _ => Vec::new(),
    };
    let peaks: Vec<(f64, f64)> = match (along.map(|along| &along.swing.peaks), rest) {
        (Some(Ok(peaks)), Some(rest)) => peaks
            .iter()
            .map(|peak| (begin + peak.time, MILLI * (rest + peak.height)))
            .filter(|peak| peak.0 <= end)
            .collect(),
        _ => Vec::new(),
    };
    let tip = || {
        let all = trajectory.times.iter().zip(&trajectory.tip);
        all.map(|(time, tip)| (*time, MILLI * coordinate.of(*tip))).take_while(|point| point.0 <= end)
    };
    let (line, rest_stroke) = (Stroke::new(BLUE, 1.4), Stroke::dashed(BLACK, 1.4, 9.0, 5.0));
    let (top, curve) = (Stroke::new(VERMILION, 1.0), Stroke::dashed(GREEN, 2.0, 12.0, 4.0));
    let mut keys = vec![Key::line(line, format!("{letter}(t)"))];
    if rest.is_some() {
        keys.push(Key::line(rest_stroke, "rest"));
    }
    if !peaks.is_empty() {
        keys.push(Key::dot(top, "upper peaks"));
    }
    if !envelope.is_empty() {
        keys.push(Key::line(curve, "eq. 6 fitted to them"));
    }
    let all = tip().chain(envelope.iter().copied()).map(|point| point.1).chain(rest.map(|rest| MILLI * rest));
    let y = Axis(padded(all, 0.05), &format!("{letter}, mm"));
    let mut panel = Panel::new(area, &title, &Axis(0.0..end, "time, s"), &y, &keys)?;
    panel.line(envelope.iter().copied(), &curve)?;
    panel.line(tip(), &line)?;
    panel.line(rest.into_iter().flat_map(|rest| [(0.0, MILLI * rest), (end, MILLI * rest)]), &rest_stroke)?;
    panel.dots(peaks, &top, 3.5)
}

fn energies(of: &ReleasePicture, area: &Area) -> Drawn {
    let trajectory = of.trajectory;
    let period = of.summary.damped_frequency_hz.map_or(f64::INFINITY, f64::recip);
    let end = of.summary.simulated_s.min(of.summary.event_s.unwrap_or(0.0) + ENERGY_SWINGS * period);
    let title = if end < of.summary.simulated_s {
        "Energy in the first swings, potential since release"
    } else {
        "Energy, potential since release"
    };
    if trajectory.times.len() < 2 || !of.energy_followed {
        let why = if of.energy_followed { "no samples" } else { "the run did not follow its energy" };
        return Panel::without_data(area, title, why);
    }
    let first = trajectory.energy[0];
    let supplied = trajectory.energy.iter().any(|energy| energy.supplied != 0.0);
    type Part<'a> = (Stroke, &'a str, Box<dyn Fn(&Energy) -> f64 + 'a>);
    let mut parts: Vec<Part> = vec![
        (Stroke::new(BLACK, 3.0), "total", Box::new(|energy| energy.total() - first.potential)),
        (Stroke::new(BLUE, 1.6), "kinetic", Box::new(|energy| energy.kinetic)),
        (Stroke::dashed(VERMILION, 1.8, 9.0, 3.0), "elastic", Box::new(|energy| energy.elastic)),
        (
            Stroke::dashed(GREEN, 1.8, 5.0, 3.0),
            "potential",
            Box::new(|energy| energy.potential - first.potential),
        ),
        (Stroke::dashed(ORANGE, 2.4, 2.5, 3.0), "dissipated", Box::new(|energy| energy.dissipated)),
    ];
    if supplied {
        parts.push((Stroke::dashed(GREY, 2.0, 12.0, 6.0), "supplied", Box::new(|energy| energy.supplied)));
    }
    let keys: Vec<Key> = parts.iter().map(|(stroke, name, _)| Key::line(*stroke, *name)).collect();
    let count = trajectory.times.iter().take_while(|time| **time <= end).count();
    let all = parts
        .iter()
        .flat_map(|(_, _, of)| trajectory.energy[..count].iter().map(move |energy| MILLI * of(energy)));
    let y = padded(all, 0.05);
    let mut panel = Panel::new(area, title, &Axis(0.0..end, "time, s"), &Axis(y, "energy, mJ"), &keys)?;
    for (stroke, _, of) in &parts {
        let line = trajectory.times.iter().zip(&trajectory.energy).take(count);
        panel.line(line.map(|(time, energy)| (*time, MILLI * of(energy))), stroke)?;
    }
    Ok(())
}

fn spectrum(of: &ReleasePicture, along: Option<&OfCoordinate>, area: &Area) -> Drawn {
    let title = format!("Amplitude spectrum of {}(t)", along.map_or("z", |along| along.coordinate.letter()));
    let missing = || of.summary.missing.get("damped_frequency_hz").map_or("no spectrum", String::as_str);
    let Some(along) = along else { return Panel::without_data(area, &title, missing()) };
    let damped = match &along.swing.damped_frequency {
        Ok(omega) => omega / std::f64::consts::TAU,
        Err(why) => return Panel::without_data(area, &title, why),
    };
    let modes = of.summary.modes.as_deref().unwrap_or_default();
    let natural: Vec<f64> = modes.iter().map(|mode| mode.natural_frequency_hz).collect();
    spectrum::spectrum(area, &title, &along.swing.spectrum, damped, &natural)
}

#[cfg(test)]
pub(crate) mod tests {
    use efam_core::example::{muscle_at_15_psi, released};
    use efam_core::rest::rest;
    use efam_experiments::summary::{MODES, summarise};

    use super::*;

    /// A chart whose words are all that text.
    pub fn chart(text: &str) -> Drawing {
        let (line, dot) = (Stroke::dashed(BLUE, 1.0, 3.0, 2.0), Stroke::new(VERMILION, 1.0));
        drawn((400, 300), |page| {
            let keys = [Key::line(line, text), Key::dot(dot, text)];
            let axes = (Axis(0.0..2.0, text), Axis(-1.0..1.0, text));
            let mut panel = Panel::new(page, text, &axes.0, &axes.1, &keys)?;
            panel.line([(0.0, -0.5), (0.7, 0.25), (2.0, 1.0)].into_iter(), &line)?;
            panel.dots([(0.1, 0.9)], &dot, 2.0)?;
            panel.text((1.0, 0.5), text)
        })
    }

    fn picture(duration: f64) -> Drawing {
        let model = muscle_at_15_psi();
        let (run, trajectory) = released(&model, duration);
        let rest = rest(&model, duration, MODES);
        let (mut summary, swings) = summarise(&model, &run, &trajectory, &rest);
        summary.name = "15 psi <release>".to_owned();
        release(&ReleasePicture {
            model: &model,
            trajectory: &trajectory,
            energy_followed: true,
            rest: rest.as_ref().ok(),
            summary: &summary,
            swings: &swings,
        })
    }

    /// How a picture looks no test sees; what it must say, this one does.
    #[test]
    fn the_picture_names_its_quantities_with_units_and_has_no_negative_zero() {
        let Drawing { svg, .. } = picture(20.0);
        if let Ok(folder) = std::env::var("EFAM_LOOK") {
            std::fs::write(format!("{folder}/release.svg"), &svg).unwrap();
        }
        assert!(
            svg.starts_with("<svg width=\"1200\" height=\"820\" viewBox=\"0 0 4800 3280\""),
            "{}",
            &svg[..90]
        );
        for text in [
            "x, mm",
            "z, mm",
            "time, s",
            "energy, mJ",
            "frequency, Hz",
            "amplitude, mm",
            "rest",
            "upper peaks",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("15 psi &lt;release&gt;: natural frequency"));
        let labels =
            svg.lines().filter(|line| matches!(*line, "-0" | "−0" | "-0.0" | "−0.0" | "NaN" | "inf"));
        assert_eq!(labels.count(), 0);
    }

    #[test]
    fn a_short_run_says_what_it_cannot_draw() {
        for duration in [0.0, 0.01, 0.3] {
            let Drawing { svg, .. } = picture(duration);
            if let Ok(folder) = std::env::var("EFAM_LOOK") {
                std::fs::write(format!("{folder}/short-{duration}.svg"), &svg).unwrap();
            }
            assert!(
                ["try a longer run", " samples", "more than two periods"].iter().any(|own| svg.contains(own)),
                "{duration}"
            );
            assert!(!svg.contains("NaN"), "{duration}");
        }
    }
}
