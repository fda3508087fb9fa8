//! Tips of several runs in one picture: paths, heights over time, cycles over the amplitude. Lines differ in
//! dash and in brightness, so that they are told apart without colour, and paths carry their name.

use super::panel::{Axis, Key, Panel, Stroke, equal_scale, padded, plot_size};
use super::released::{SIZE, stride};
use super::{Area, BLACK, BLUE, Drawn, GREEN, GREY, MILLI, ORANGE, Picture, VERMILION, drawn, in_milli};
use crate::results::summary::Cycle;

/// The tip of a run.
#[derive(Clone, Debug)]
pub struct Tip<'a> {
    /// What stands for the run.
    pub name: String,
    /// Times of its samples, s.
    pub times: &'a [f64],
    /// Positions, m.
    pub path: &'a [[f64; 2]],
    /// Where it comes to rest, m, if that is known.
    pub rest: Option<[f64; 2]>,
}

/// Lines of a picture, at most: more cannot be told apart.
const MOST_LINES: usize = 6;

/// Looks of lines that are told apart by dash alone.
pub(super) fn looks() -> [Stroke; MOST_LINES] {
    [
        Stroke::new(BLUE, 1.6),
        Stroke::dashed(VERMILION, 1.8, 9.0, 4.0),
        Stroke::dashed(GREEN, 2.0, 2.5, 3.0),
        Stroke::new(BLACK, 2.8),
        Stroke::dashed(ORANGE, 2.4, 14.0, 3.0),
        Stroke::dashed(GREY, 2.0, 5.0, 2.5),
    ]
}

/// So many of them, evenly spread, with the first and the last.
fn spread<T: Copy>(all: &[T], most: usize) -> Vec<T> {
    let count = all.len().min(most);
    (0..count).map(|k| all[if count > 1 { k * (all.len() - 1) / (count - 1) } else { 0 }]).collect()
}

/// Paths of all tips, and heights of some.
pub fn tips(all: &[Tip]) -> Vec<Picture> {
    let all: Vec<&Tip> = all.iter().filter(|tip| tip.times.len() > 1).collect();
    if all.is_empty() {
        return Vec::new();
    }
    // Every other one of many, as in the paper's Figure 4.
    let paths: Vec<&Tip> = all.iter().copied().step_by(if all.len() > 10 { 2 } else { 1 }).collect();
    vec![
        Picture {
            name: "trajectories".to_owned(),
            title: "Paths of the tip".to_owned(),
            caption: "The tip in the plane of the swing, and where it comes to rest.".to_owned(),
            svg: drawn((760, 640), |page| trajectories(page, "Paths of the tip and its rest", &paths)),
        },
        Picture {
            name: "heights".to_owned(),
            title: "Heights of the tip".to_owned(),
            caption: "z(t) of the runs that are named; the others lie between them.".to_owned(),
            svg: drawn(SIZE, |page| heights(page, &spread(&all, 4))),
        },
    ]
}

/// Paths from each tip's release, with rings at the rests and the name of each run beside its rest.
pub(super) fn trajectories(area: &Area, title: &str, tips: &[&Tip]) -> Drawn {
    let (base, at_rest) = (Stroke::new(GREEN, 1.0), Stroke::new(BLACK, 1.8));
    let strokes = [Stroke::new(BLUE, 1.1), Stroke::dashed(VERMILION, 1.2, 6.0, 3.0)];
    let keys = [
        Key::line(strokes[0], "path of the tip"),
        Key::line(strokes[1], "the next one"),
        Key::ring(at_rest, "rest"),
        Key::dot(base, "base"),
    ];
    let all = || tips.iter().flat_map(|tip| tip.path.iter().chain(&tip.rest)).chain([&[0.0, 0.0]]);
    let range = |k: usize| padded(all().map(|point| MILLI * point[k]), 0.06);
    let (x, z) = equal_scale(range(0), range(1), plot_size(area, &keys));
    let mut panel = Panel::new(area, title, &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    for (k, tip) in tips.iter().enumerate() {
        let every = stride(tip.path.len());
        panel.line(tip.path.iter().step_by(every).map(in_milli), &strokes[k % 2])?;
    }
    for tip in tips {
        panel.rings(tip.rest.as_ref().map(in_milli), &at_rest, 4.5)?;
    }
    let starts: Vec<(f64, f64)> = tips.iter().filter_map(|tip| tip.path.first()).map(in_milli).collect();
    panel.dots([(0.0, 0.0)], &base, 5.0)?;
    // Names stand where the tips are let go, if they are not on top of one another there.
    let far = starts.windows(2).all(|pair| (pair[0].0 - pair[1].0).abs() > 25.0);
    let named = tips.iter().zip(&starts).enumerate();
    for (_, (tip, at)) in named.filter(|(k, _)| far || *k == 0 || *k + 1 == tips.len()) {
        panel.text((at.0, at.1 + 12.0), &tip.name)?;
    }
    Ok(())
}

/// Heights over time, each with a look of its own.
pub(super) fn heights(area: &Area, tips: &[&Tip]) -> Drawn {
    let looks = looks();
    let keys: Vec<Key> =
        tips.iter().zip(looks).map(|(tip, look)| Key::line(look, tip.name.clone())).collect();
    let end = tips.iter().filter_map(|tip| tip.times.last()).copied().fold(0.0, f64::max).min(8.0);
    let points = |tip: &Tip| {
        let all = tip.times.iter().zip(tip.path).map(|(time, at)| (*time, MILLI * at[1]));
        all.take_while(|point| point.0 <= end).collect::<Vec<_>>()
    };
    let lines: Vec<Vec<(f64, f64)>> = tips.iter().map(|tip| points(tip)).collect();
    let y = padded(lines.iter().flatten().map(|point| point.1), 0.05);
    let (x, y) = (Axis(0.0..end, "time since release, s"), Axis(y, "z, mm"));
    let mut panel = Panel::new(area, "Height of the tip", &x, &y, &keys)?;
    for (line, look) in lines.into_iter().zip(looks) {
        panel.line(line.into_iter(), &look)?;
    }
    Ok(())
}

/// Damping and frequency of each cycle over its amplitude, of some of the runs; nothing without cycles.
pub fn over_pressure_and_amplitude(all: &[(String, &[Cycle])]) -> Vec<Picture> {
    let some: Vec<&(String, &[Cycle])> = all.iter().filter(|(_, cycles)| !cycles.is_empty()).collect();
    if some.is_empty() {
        return Vec::new();
    }
    let some: Vec<&(String, &[Cycle])> = spread(&some, 5);
    let picture = |name: &str, title: &str, label: &str, of: fn(&Cycle) -> f64| Picture {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: "From each upper peak to the next, of the runs that are named.".to_owned(),
        svg: drawn(SIZE, |page| cycles(page, title, label, &some, of)),
    };
    vec![
        picture(
            "damping-over-amplitude",
            "Damping over amplitude",
            "damping ratio, dimensionless",
            |cycle| cycle.damping_ratio,
        ),
        picture("frequency-over-amplitude", "Frequency over amplitude", "damped frequency, Hz", |cycle| {
            cycle.damped_frequency_hz
        }),
    ]
}

fn cycles(
    area: &Area,
    title: &str,
    label: &str,
    runs: &[&(String, &[Cycle])],
    of: fn(&Cycle) -> f64,
) -> Drawn {
    let looks = looks();
    let keys: Vec<Key> = runs.iter().zip(looks).map(|(run, look)| Key::line(look, run.0.clone())).collect();
    let points = |run: &(String, &[Cycle])| -> Vec<(f64, f64)> {
        run.1.iter().map(|cycle| (MILLI * cycle.amplitude_m, of(cycle))).collect()
    };
    let lines: Vec<Vec<(f64, f64)>> = runs.iter().map(|run| points(run)).collect();
    let end = 1.05 * lines.iter().flatten().map(|point| point.0).fold(f64::MIN_POSITIVE, f64::max);
    let y = Axis(padded(lines.iter().flatten().map(|point| point.1), 0.1), label);
    let mut panel = Panel::new(area, title, &Axis(0.0..end, "amplitude, mm"), &y, &keys)?;
    for (line, look) in lines.into_iter().zip(looks) {
        panel.dots(line.iter().copied(), &look, 2.2)?;
        panel.line(line.into_iter(), &look)?;
    }
    Ok(())
}
