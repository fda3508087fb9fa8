//! What drives a run, and the tip's answer: pressure and forces over time, x(t) and z(t).

use models::line::RodPressure;

use crate::picture::panel::{Axis, Drawn, Key, Panel, Stroke, padded};
use crate::picture::released::{SIZE, stride};
use crate::picture::{Area, BLACK, BLUE, GREEN, MILLI, ORANGE, Picture, ReleasePicture, VERMILION, drawn};

/// The pictures of a run that something drives: none of a release.
pub(super) fn driven(of: &ReleasePicture) -> Vec<Picture> {
    let drive = &of.swings.drive;
    if drive.is_still() || of.trajectory.times.len() < 2 {
        return Vec::new();
    }
    let picture = |name: &str, title: &str, caption: &str, draw: &dyn Fn(&Area) -> Drawn| Picture {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        drawing: drawn(SIZE, draw),
    };
    let mut all = Vec::new();
    if !drive.pressure_changes.is_empty() {
        let caption = "Pressure above ambient.";
        all.push(picture("drive-pressure", "Pressure over time", caption, &|area| over_time(of, area)));
    }
    if !drive.forces.is_empty() {
        let caption = "Resultant of each load that depends on time, on the rod as it starts.";
        all.push(picture("drive-force", "Forces over time", caption, &|area| forces(of, area)));
    }
    let caption = "The place of the tip; dashed lines mark the events.";
    all.push(picture("response", "Response of the tip", caption, &|area| response(of, area)));
    all
}

fn over_time(of: &ReleasePicture, area: &Area) -> Drawn {
    let times = &of.trajectory.times;
    let every = stride(times.len());
    let pressure = RodPressure::of(of.model);
    let over = |at: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        times.iter().step_by(every).map(|time| (*time, 1e-3 * at(*time))).collect()
    };
    let mut lines = vec![("pressure", Stroke::new(BLUE, 1.6), over(&|time| pressure.at(time)))];
    if pressure.is_behind() {
        let look = Stroke::dashed(VERMILION, 1.4, 6.0, 4.0);
        lines.push(("command", look, over(&|time| pressure.command(time))));
    }
    let y = padded(lines.iter().flat_map(|line| &line.2).map(|point| point.1), 0.1);
    let (x, y) = (Axis(0.0..of.summary.simulated_s, "time, s"), Axis(y, "pressure, kPa"));
    let keys: Vec<Key> = lines.iter().map(|(name, look, _)| Key::line(*look, *name)).collect();
    let mut panel = Panel::new(area, "Pressure over time", &x, &y, &keys)?;
    lines.into_iter().try_for_each(|(_, look, points)| panel.line(points.into_iter(), &look))
}

fn forces(of: &ReleasePicture, area: &Area) -> Drawn {
    const COLOURS: [plotters::prelude::RGBColor; 4] = [BLUE, VERMILION, GREEN, ORANGE];
    let mut lines = Vec::new();
    for force in &of.swings.drive.forces {
        for (k, letter) in [(0, "x"), (1, "z")] {
            let every = stride(force.times.len());
            let points: Vec<(f64, f64)> = force
                .times
                .iter()
                .zip(&force.values)
                .step_by(every)
                .map(|(time, at)| (*time, at[k]))
                .collect();
            if points.iter().any(|point| point.1 != 0.0) {
                let stroke = Stroke::new(COLOURS[lines.len() % COLOURS.len()], 1.6);
                lines.push((stroke, format!("{}, {letter}", force.effect), points));
            }
        }
    }
    let keys: Vec<Key> = lines.iter().map(|(stroke, name, _)| Key::line(*stroke, name.clone())).collect();
    let y = padded(lines.iter().flat_map(|(.., points)| points).map(|point| point.1), 0.1);
    let (x, y) = (Axis(0.0..of.summary.simulated_s, "time, s"), Axis(y, "force, N"));
    let mut panel = Panel::new(area, "Forces over time", &x, &y, &keys)?;
    lines.into_iter().try_for_each(|(stroke, _, points)| panel.line(points.into_iter(), &stroke))
}

fn response(of: &ReleasePicture, area: &Area) -> Drawn {
    let trajectory = of.trajectory;
    let every = stride(trajectory.times.len());
    let along = |k: usize| {
        let all = trajectory.times.iter().zip(&trajectory.tip).step_by(every);
        all.map(move |(time, tip)| (*time, MILLI * tip[k]))
    };
    let (x, z) = (Stroke::dashed(VERMILION, 1.6, 9.0, 3.0), Stroke::new(BLUE, 1.4));
    let mark = Stroke::dashed(BLACK, 1.0, 3.0, 4.0);
    let keys = [Key::line(x, "x(t)"), Key::line(z, "z(t)"), Key::line(mark, "event")];
    let range = padded(along(0).chain(along(1)).map(|point| point.1), 0.05);
    let (low, high) = (range.start, range.end);
    let axes = (Axis(0.0..of.summary.simulated_s, "time, s"), Axis(range, "place of the tip, mm"));
    let mut panel = Panel::new(area, "Response of the tip", &axes.0, &axes.1, &keys)?;
    for event in &of.summary.events {
        panel.line([(event.time_s, low), (event.time_s, high)].into_iter(), &mark)?;
    }
    panel.line(along(0), &x)?;
    panel.line(along(1), &z)
}
