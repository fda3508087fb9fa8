//! The pictures of a run's page, one quantity each: what `release.svg` shows, and the tip's path, its phase
//! portrait, damping and frequency over the amplitude.

use efam_experiments::summary::Cycle;
use models::digits::significant;

use crate::picture::driven::driven;
use crate::picture::panel::{Axis, Key, Panel, Stroke, equal_scale, padded, plot_size};
use crate::picture::rods::{Rod, Rods, frames_until};
use crate::picture::{
    Area, BLACK, BLUE, Drawn, GREEN, MILLI, Picture, ReleasePicture, VERMILION, base_angle, clamp, drawn,
    in_milli,
};

/// Width and height, pixels.
pub(super) const SIZE: (u32, u32) = (760, 540);
/// Points that a line has at most.
const MOST_POINTS: usize = 4000;

/// All pictures of a run's page, in the order in which one would look at them.
pub fn released(of: &ReleasePicture) -> Vec<Picture> {
    let picture = |name: &str, title: &str, caption: &str, draw: &dyn Fn(&Area) -> Drawn| Picture {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        drawing: drawn(SIZE, draw),
    };
    let along = of.swings.coordinate.as_ref();
    let mut pictures = vec![
        picture(
            "swing",
            "Swing of the tip",
            "The distance of the tip from the clamp in the direction of the first mode, s(t), with its upper peaks, and eq. 6 fitted to them.",
            &|page| crate::picture::swing(of, along, page),
        ),
        picture(
            "spectrum",
            "Spectrum",
            "Amplitude spectrum of s(t) until the swing is over; its peak at the first mode is the damped frequency.",
            &|page| crate::picture::spectrum(of, along, page),
        ),
        picture(
            "trajectory",
            "Path of the tip",
            "The tip in the plane of the swing, at one scale.",
            &|page| path(of, page),
        ),
        picture(
            "postures",
            "Postures",
            "The rod in the first swing, down and back, and at rest; later postures are darker.",
            &|page| crate::picture::shapes(of, page),
        ),
        picture(
            "phase",
            "Phase portrait",
            "Rate of the height over the height: a spiral into the rest.",
            &|page| phase(of, page),
        ),
        picture(
            "energy",
            "Energy budget",
            "Where the energy is; its total is constant but for the error of integration.",
            &|page| crate::picture::energies(of, page),
        ),
    ];
    pictures.extend(driven(of));
    let cycles = of.summary.cycles.as_deref().unwrap_or_default();
    let mode = of.summary.modes.as_ref().and_then(|modes| modes.first());
    let eq_6 = Stroke::dashed(GREEN, 2.0, 12.0, 4.0);
    let small = Stroke::dashed(BLACK, 1.4, 3.0, 3.0);
    let level = |stroke: Stroke, name: &str, value: Option<f64>| {
        value.map(|value| (stroke, format!("{name}, {}", significant(value, 3)), value))
    };
    let damping = Levels {
        title: "Damping ratio over amplitude, cycle by cycle",
        label: "damping ratio, dimensionless",
        levels: [
            level(eq_6, "eq. 6, all peaks", of.summary.damping_ratio),
            level(small, "first mode", mode.map(|mode| mode.damping_ratio)),
        ],
    };
    let frequency = Levels {
        title: "Damped frequency over amplitude, cycle by cycle",
        label: "damped frequency, Hz",
        levels: [
            level(eq_6, "spectrum", of.summary.damped_frequency_hz),
            level(
                small,
                "first mode",
                mode.map(|mode| {
                    mode.natural_frequency_hz * (1.0 - mode.damping_ratio.powi(2)).max(0.0).sqrt()
                }),
            ),
        ],
    };
    pictures.push(picture(
        "damping-over-amplitude",
        "Damping over amplitude",
        "From each upper peak to the next. A linear loss would be level.",
        &|page| damping.draw(page, cycles, |cycle| cycle.damping_ratio),
    ));
    pictures.push(picture(
        "frequency-over-amplitude",
        "Frequency over amplitude",
        "From each upper peak to the next. Large swings have another frequency than small ones.",
        &|page| frequency.draw(page, cycles, |cycle| cycle.damped_frequency_hz),
    ));
    pictures
}

/// One sample in so many, so that a line keeps to [`MOST_POINTS`].
pub(super) fn stride(samples: usize) -> usize {
    samples.div_ceil(MOST_POINTS).max(1)
}

/// The rod in motion until it settles; nothing of a run without samples.
pub fn in_motion(of: &ReleasePicture) -> Option<Rods> {
    let trajectory = of.trajectory;
    let frames = frames_until(of.model, trajectory, crate::picture::settled(of.summary));
    let rest = of.rest.map(|rest| [&rest.nodes[..], &[rest.tip]].concat());
    let rod = Rod::new("simulated", Stroke::new(BLUE, 2.2), frames)?;
    Some(Rods {
        title: "The rod in motion".to_owned(),
        caption: "Play it, or move its time; the charts below show the same instant.".to_owned(),
        clock: "time, s",
        angle: base_angle(of.model),
        rest,
        rods: vec![rod],
        markers: Vec::new(),
    })
}

fn path(of: &ReleasePicture, area: &Area) -> Drawn {
    let (trajectory, title) = (of.trajectory, "Path of the tip");
    if trajectory.times.len() < 2 {
        return Panel::without_data(area, title, "no samples");
    }
    let (line, start) = (Stroke::new(BLUE, 1.2), Stroke::new(BLACK, 1.0));
    let at_rest = Stroke::new(VERMILION, 2.2);
    let mut keys = vec![Key::line(line, "tip"), Key::dot(start, "let go")];
    keys.extend(of.rest.map(|_| Key::ring(at_rest, "rest")));
    let length = of.model.rod().length;
    let corners = [[-0.05 * length, -0.12 * length], [0.05 * length, 0.12 * length]];
    let all = || trajectory.tip.iter().chain(&corners).chain(of.rest.iter().map(|rest| &rest.tip));
    let range = |k: usize| padded(all().map(|point| MILLI * point[k]), 0.05);
    let (x, z) = equal_scale(range(0), range(1), plot_size(area, &keys));
    let mut panel = Panel::new(area, title, &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    clamp(&mut panel, of.model, length)?;
    let every = stride(trajectory.tip.len());
    let tip = trajectory.times.iter().copied().zip(trajectory.tip.iter().map(in_milli));
    panel.path(tip.step_by(every), &line)?;
    panel.dots([in_milli(&trajectory.tip[0])], &start, 4.0)?;
    panel.rings(of.rest.map(|rest| in_milli(&rest.tip)), &at_rest, 6.0)
}

fn phase(of: &ReleasePicture, area: &Area) -> Drawn {
    let (trajectory, title) = (of.trajectory, "Phase portrait");
    if trajectory.times.len() < 2 {
        return Panel::without_data(area, title, "no samples");
    }
    let (line, start) = (Stroke::new(BLUE, 1.0), Stroke::new(BLACK, 1.0));
    let at_rest = Stroke::new(VERMILION, 2.2);
    let mut keys = vec![Key::line(line, "tip"), Key::dot(start, "let go")];
    keys.extend(of.rest.map(|_| Key::ring(at_rest, "rest")));
    let samples = || trajectory.tip.iter().zip(&trajectory.tip_velocity);
    let all = || samples().map(|(tip, velocity)| (MILLI * tip[1], velocity[1]));
    let rest = of.rest.map(|rest| (MILLI * rest.tip[1], 0.0));
    let x = padded(all().chain(rest).map(|point| point.0), 0.05);
    let y = padded(all().chain(rest).map(|point| point.1), 0.05);
    let mut panel = Panel::new(area, title, &Axis(x, "z, mm"), &Axis(y, "dz/dt, m/s"), &keys)?;
    let every = stride(trajectory.tip.len());
    panel.path(trajectory.times.iter().copied().zip(all()).step_by(every), &line)?;
    panel.dots(all().take(1), &start, 4.0)?;
    panel.rings(rest, &at_rest, 6.0)
}

/// A picture of something of each cycle over its amplitude, beside levels that represent all of them.
struct Levels<'a> {
    title: &'a str,
    label: &'a str,
    levels: [Option<(Stroke, String, f64)>; 2],
}

impl Levels<'_> {
    fn draw(&self, area: &Area, cycles: &[Cycle], of: fn(&Cycle) -> f64) -> Drawn {
        if cycles.is_empty() {
            return Panel::without_data(area, self.title, "no two upper peaks: there is no cycle");
        }
        let each = Stroke::new(BLUE, 1.2);
        let levels = || self.levels.iter().flatten();
        let mut keys = vec![Key::dot(each, "each cycle")];
        keys.extend(levels().map(|(stroke, name, _)| Key::line(*stroke, name.clone())));
        let points: Vec<(f64, f64)> =
            cycles.iter().map(|cycle| (MILLI * cycle.amplitude_m, of(cycle))).collect();
        let end = 1.06 * points.iter().map(|point| point.0).fold(f64::MIN_POSITIVE, f64::max);
        let y = padded(points.iter().map(|point| point.1).chain(levels().map(|level| level.2)), 0.12);
        let x = Axis(0.0..end, "amplitude, mm");
        let mut panel = Panel::new(area, self.title, &x, &Axis(y, self.label), &keys)?;
        for (stroke, _, value) in levels() {
            panel.line([(0.0, *value), (end, *value)].into_iter(), stroke)?;
        }
        panel.line(points.iter().copied(), &each)?;
        panel.dots(points, &each, 3.5)
    }
}
