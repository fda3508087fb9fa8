//! Tips of several runs in one picture: paths, heights over time, cycles over the amplitude. Lines differ in
//! dash and in brightness, so that they differ without colour, and paths carry their name.

use std::ops::Range;

use efam_experiments::summary::Cycle;

use crate::picture::chart::{Cases, Point};
use crate::picture::compact::kept;
use crate::picture::lines::{Lines, MOST_LINES, Named, looks, spread};
use crate::picture::panel::{Axis, Key, Panel, Stroke, equal_scale, padded, plot_size};
use crate::picture::pixels::SCALE;
use crate::picture::released::{SIZE, stride};
use crate::picture::{Area, BLACK, BLUE, CHOSEN, Drawn, GREEN, MILLI, Picture, VERMILION, drawn, in_milli};

/// The tip of a run.
#[derive(Clone, Debug)]
pub struct Tip<'a> {
    /// The run's name in the picture.
    pub name: String,
    /// Times of its samples, s.
    pub times: &'a [f64],
    /// Positions, m.
    pub path: &'a [[f64; 2]],
    /// Where it comes to rest, m, if that is known.
    pub rest: Option<[f64; 2]>,
    /// Which case of the page's family it is.
    pub case: Option<usize>,
}

/// Time over which heights are drawn, s.
const MOST_TIME: f64 = 8.0;

/// Paths of all tips of a set, and heights of some.
pub fn tips(all: &[Tip]) -> Vec<Picture> {
    let all: Vec<&Tip> = all.iter().filter(|tip| tip.times.len() > 1).collect();
    if all.is_empty() {
        return Vec::new();
    }
    // Every other one of many, as in the paper's Figure 4.
    let paths: Vec<&Tip> = all.iter().copied().step_by(if all.len() > 10 { 2 } else { 1 }).collect();
    let some = spread(&all, 4);
    vec![
        Picture {
            name: "trajectories".to_owned(),
            title: "Paths of the tip".to_owned(),
            caption: "The tip in the plane of the swing, and where it comes to rest; of many runs every other one. Each path begins at its name or between those of its neighbours.".to_owned(),
            drawing: drawn((760, 680), |page| trajectories(page, "Paths of the tip and its rest", &paths, &others(&all, &paths))),
        },
        Picture {
            name: "heights".to_owned(),
            title: "Heights of the tip".to_owned(),
            caption: "z(t) of the runs that are named; the others lie between them.".to_owned(),
            drawing: drawn(SIZE, |page| heights(page, &some, &others(&all, &some))),
        },
    ]
}

/// Heights and paths of the tips of runs that are compared, each by its name.
pub fn tips_of_runs(all: &[Tip]) -> Vec<Picture> {
    let all: Vec<&Tip> = all.iter().filter(|tip| tip.times.len() > 1).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let caption = if all.len() > MOST_LINES {
        format!("Of {} runs, {MOST_LINES} are drawn: more lines cannot be told apart.", all.len())
    } else {
        "Each run by its letter and name.".to_owned()
    };
    let some = spread(&all, MOST_LINES);
    vec![
        Picture {
            name: "heights".to_owned(),
            title: "Heights of the tip".to_owned(),
            caption: caption.clone(),
            drawing: drawn(SIZE, |page| heights(page, &some, &[])),
        },
        Picture {
            name: "paths".to_owned(),
            title: "Paths of the tip".to_owned(),
            caption,
            drawing: drawn((760, 680), |page| paths(page, &some)),
        },
    ]
}

/// Cases of a family that are not among those that are drawn.
fn others<'a, 'b>(all: &[&'b Tip<'a>], drawn: &[&'b Tip<'a>]) -> Vec<&'b Tip<'a>> {
    let is_other = |tip: &&Tip| tip.case.is_some() && drawn.iter().all(|own| own.case != tip.case);
    all.iter().copied().filter(is_other).collect()
}

/// Something of sets over pressure, kPa; `label` says what, with its unit.
pub fn over_pressures(label: &str, lines: &[Named]) -> Picture {
    let word = label.split(',').next().unwrap_or(label);
    let title = format!("{}{} over pressure", word[..1].to_uppercase(), &word[1..]);
    let of = Lines {
        title: &title,
        x: "pressure, kPa",
        y: label,
        marks: true,
        from_zero: false,
        why: "no run of the sets has it",
    };
    Picture {
        name: format!("{}-over-pressure", word.replace(' ', "-")),
        title: title.clone(),
        caption: "By the paper's method from each swing.".to_owned(),
        drawing: drawn(SIZE, |page| of.draw(page, lines)),
    }
}

/// Paths, each with a look of its own.
fn paths(area: &Area, tips: &[&Tip]) -> Drawn {
    let all = looks();
    let at_rest = Stroke::new(BLACK, 1.8);
    let mut keys: Vec<Key> =
        tips.iter().zip(all).map(|(tip, look)| Key::line(look, tip.name.clone())).collect();
    keys.push(Key::ring(at_rest, "rest"));
    let (x, z) = ranges(area, tips, &keys);
    let mut panel = Panel::new(area, "Path of the tip", &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    for (tip, look) in tips.iter().zip(all) {
        panel.line(tip.path.iter().step_by(stride(tip.path.len())).map(in_milli), &look)?;
        panel.rings(tip.rest.as_ref().map(in_milli), &at_rest, 5.0)?;
    }
    Ok(())
}

/// What holds all paths, rests and the base, at one scale.
fn ranges(area: &Area, tips: &[&Tip], keys: &[Key]) -> (Range<f64>, Range<f64>) {
    let all = || tips.iter().flat_map(|tip| tip.path.iter().chain(&tip.rest)).chain([&[0.0, 0.0]]);
    let range = |k: usize| padded(all().map(|point| MILLI * point[k]), 0.07);
    equal_scale(range(0), range(1), plot_size(area, keys))
}

/// Paths from each tip's release, with rings at the rests, and names where the paths begin.
pub(super) fn trajectories(area: &Area, title: &str, tips: &[&Tip], others: &[&Tip]) -> Drawn {
    let (base, at_rest) = (Stroke::new(GREEN, 1.0), Stroke::new(BLACK, 1.8));
    let strokes = [Stroke::new(BLUE, 1.1), Stroke::dashed(VERMILION, 1.2, 6.0, 3.0)];
    let keys = [
        Key::line(strokes[0], "path of the tip"),
        Key::line(strokes[1], "the next one"),
        Key::ring(at_rest, "rest"),
        Key::dot(base, "base"),
    ];
    let (x, z) = ranges(area, tips, &keys);
    let per_pixel = (x.end - x.start) / plot_size(area, &keys).0;
    let mut panel = Panel::new(area, title, &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    let path = |tip: &Tip| -> Vec<Point> {
        let all: Vec<Point> = tip.path.iter().step_by(stride(tip.path.len())).map(in_milli).collect();
        let fine = |at: f64| (f64::from(SCALE) * at / per_pixel) as i32;
        let in_pixels: Vec<_> = all.iter().map(|(x, z)| (fine(*x), fine(*z))).collect();
        all.into_iter().zip(kept(&in_pixels)).filter(|(_, is_kept)| *is_kept).map(|(at, _)| at).collect()
    };
    for (k, tip) in tips.iter().enumerate() {
        panel.of_cases(tip.case.map(Cases::One)).line(path(tip).into_iter(), &strokes[k % 2])?;
    }
    for tip in others {
        panel.of_cases(tip.case.map(Cases::Chosen)).line(path(tip).into_iter(), &Stroke::new(CHOSEN, 1.6))?;
        panel.rings(tip.rest.as_ref().map(in_milli), &at_rest, 4.5)?;
    }
    for tip in tips {
        panel.of_cases(tip.case.map(Cases::One)).rings(tip.rest.as_ref().map(in_milli), &at_rest, 4.5)?;
    }
    panel.of_cases(None).dots([(0.0, 0.0)], &base, 5.0)?;
    // A name where there is room for it, from the last one inwards.
    let mut free = f64::INFINITY;
    for tip in tips.iter().rev() {
        let Some([x, z]) = tip.path.first() else { continue };
        let (x, width) = (MILLI * x, 8.0 * per_pixel * tip.name.chars().count() as f64);
        if x + 0.5 * width < free {
            panel.text((x - 0.5 * width, MILLI * z + 14.0 * per_pixel), &tip.name)?;
            free = x - 0.5 * width;
        }
    }
    Ok(())
}

/// Heights over time, each with a look of its own, in the first swings.
pub(super) fn heights(area: &Area, tips: &[&Tip], others: &[&Tip]) -> Drawn {
    let points = |tip: &Tip| -> Named {
        let all = tip.times.iter().zip(tip.path).map(|(time, at)| (*time, MILLI * at[1]));
        (tip.name.clone(), all.take_while(|point| point.0 <= MOST_TIME).collect())
    };
    let lines: Vec<_> = tips.iter().map(|tip| (tip.case, points(tip))).collect();
    let others: Vec<_> = others.iter().filter_map(|tip| Some((tip.case?, points(tip)))).collect();
    let of = Lines {
        title: "Height of the tip",
        x: "time since release, s",
        y: "z, mm",
        marks: false,
        from_zero: false,
        why: "no samples",
    };
    of.draw_cases(area, &lines, &others)
}

/// Damping and frequency of each cycle over its amplitude, of some of the runs; nothing without cycles.
pub fn over_pressure_and_amplitude(all: &[(String, &[Cycle])]) -> Vec<Picture> {
    let all: Vec<Cycles> = all.iter().enumerate().filter(|(_, (_, cycles))| !cycles.is_empty()).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let some = spread(&all, 5);
    let is_other = |own: &Cycles| some.iter().all(|(case, _)| *case != own.0);
    let others: Vec<Cycles> = all.iter().copied().filter(is_other).collect();
    let picture = |name: &str, title: &str, label: &str, of: fn(&Cycle) -> f64| Picture {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: "From each upper peak to the next, of the runs that are named.".to_owned(),
        drawing: drawn(SIZE, |page| cycles(page, (title, label), [&some, &others], of)),
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

/// The place of a run in its set, its name, and its cycles.
type Cycles<'a> = (usize, &'a (String, &'a [Cycle]));

fn cycles(
    area: &Area,
    (title, label): (&str, &str),
    [runs, others]: [&[Cycles]; 2],
    of: fn(&Cycle) -> f64,
) -> Drawn {
    let points = |(name, cycles): &(String, &[Cycle])| -> Named {
        (name.clone(), cycles.iter().map(|cycle| (MILLI * cycle.amplitude_m, of(cycle))).collect())
    };
    let lines: Vec<_> = runs.iter().map(|(case, run)| (Some(*case), points(run))).collect();
    let others: Vec<_> = others.iter().map(|(case, run)| (*case, points(run))).collect();
    let panel =
        Lines { title, x: "amplitude, mm", y: label, marks: true, from_zero: false, why: "no cycles" };
    panel.draw_cases(area, &lines, &others)
}
