//! What was cut and masked in a recording: the tip over time, its path in the plane, its way out of it.

use efam_experiments::cleaning::{CleanRecording, CleanRelease};

use crate::picture::panel::{Axis, Key, Panel, Stroke, equal_scale, heading, padded, plot_size, px};
use crate::picture::{Area, BLACK, BLUE, Drawing, Drawn, GREEN, GREY, MILLI, VERMILION, drawn};

/// Points that a line has at most.
const MOST_POINTS: usize = 4000;

/// Range of an axis below which its numbers would be rounded to one, mm.
const LEAST_RANGE: f64 = 1e-3;

/// Three panels of one recording and its releases; as SVG.
pub fn recording(of: &CleanRecording, releases: &[&CleanRelease]) -> Drawing {
    drawn((1200, 820), |page| {
        let masked = of.masked.iter().filter(|masked| **masked).count();
        let lost = of.tip.iter().filter(|at| at.is_none()).count();
        let count = releases.len();
        heading(
            page,
            &format!(
                "{}: {count} release{}, {lost} samples of the tip lost, {masked} masked",
                of.name,
                if count == 1 { "" } else { "s" }
            ),
        )?;
        let rows = page.below(px(34.0)).split_evenly((2, 1));
        let below = rows[1].split_evenly((1, 2));
        height(of, releases, &rows[0])?;
        plane(of, releases, &below[0])?;
        across(of, releases, &below[1])
    })
}

/// Time and place in W, mm, of the samples that are used, in unbroken pieces.
fn pieces(of: &CleanRecording) -> Vec<Vec<(f64, [f64; 3])>> {
    let every = of.tip.len().div_ceil(MOST_POINTS).max(1);
    let mut pieces = vec![Vec::new()];
    for (i, time) in of.recording.time.iter().enumerate() {
        match of.tip[i].filter(|_| !of.masked[i]) {
            None if pieces.last().is_some_and(|piece| !piece.is_empty()) => pieces.push(Vec::new()),
            None => {}
            Some(at) if i % every == 0 => {
                let place = of.frame.place(at).map(|x| MILLI * x);
                pieces.last_mut().expect("there is always one").push((*time, place));
            }
            Some(_) => {}
        }
    }
    pieces
}

fn used(of: &CleanRecording) -> impl Iterator<Item = [f64; 3]> {
    let all = of.tip.iter().zip(&of.masked).filter(|(_, masked)| !**masked);
    all.filter_map(|(at, _)| at.map(|at| of.frame.place(at).map(|x| MILLI * x)))
}

fn masked(of: &CleanRecording) -> Vec<(f64, [f64; 3])> {
    let all = of.recording.time.iter().zip(&of.tip).zip(&of.masked).filter(|(_, masked)| **masked);
    all.filter_map(|((time, at), _)| Some((*time, of.frame.place((*at)?).map(|x| MILLI * x)))).collect()
}

fn height(of: &CleanRecording, releases: &[&CleanRelease], area: &Area) -> Drawn {
    let time = &of.recording.time;
    let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(1.0));
    let z = padded(used(of).map(|at| at[2]), 0.12);
    let (low, high) = (z.start, z.end);
    let (line, bad) = (Stroke::new(BLUE, 1.3), Stroke::new(VERMILION, 1.0));
    let (instant, rest) = (Stroke::dashed(BLACK, 1.4, 6.0, 4.0), Stroke::dashed(GREEN, 1.8, 9.0, 4.0));
    let keys = [
        Key::line(line, "tip, used"),
        Key::dot(bad, "masked (beyond the axes: at their edge)"),
        Key::line(instant, "release"),
        Key::line(rest, "rest"),
        Key::line(Stroke { alpha: 0.35, ..Stroke::new(GREY, 8.0) }, "release with its hold, as cut"),
    ];
    let title = "Height of the tip above the clamp";
    let mut panel = Panel::new(area, title, &Axis(first..last, "time, s"), &Axis(z, "z, mm"), &keys)?;
    for release in releases {
        let times = &release.release.time;
        let (Some(from), Some(to)) = (times.first(), times.last()) else { continue };
        panel.strip(release.instant + from..release.instant + to, low..high)?;
        panel.line([(release.instant, low), (release.instant, high)].into_iter(), &instant)?;
        let level = MILLI * (release.statistics.rest[1] + release.statistics.offset[1]);
        panel.line([(release.instant, level), (release.instant + to, level)].into_iter(), &rest)?;
        let kind = match (&release.dropped, release.release.held_out) {
            (Some(_), _) => " dropped",
            (None, true) => " held out",
            (None, false) if release.representative && releases.len() > 1 => " *",
            (None, false) => "",
        };
        let text = format!("#{}{kind}", release.number);
        panel.text((release.instant + 0.004 * (last - first), high - 0.05 * (high - low)), &text)?;
    }
    for piece in pieces(of) {
        panel.line(piece.into_iter().map(|(time, at)| (time, at[2])), &line)?;
    }
    panel.dots(masked(of).into_iter().map(|(time, at)| (time, at[2].clamp(low, high))), &bad, 2.5)
}

fn plane(of: &CleanRecording, releases: &[&CleanRelease], area: &Area) -> Drawn {
    let line = Stroke { alpha: 0.7, ..Stroke::new(BLUE, 1.2) };
    let (hold, rest) = (Stroke::new(BLACK, 1.0), Stroke::new(GREEN, 1.0));
    let keys = [Key::line(line, "tip"), Key::dot(hold, "held"), Key::dot(rest, "rest")];
    let range = |k: usize| padded(used(of).map(|at| at[k]).chain([0.0]), 0.06);
    let (x, z) = equal_scale(range(0), range(2), plot_size(area, &keys));
    let mut panel =
        Panel::new(area, "In the plane of the swing", &Axis(x, "x, mm"), &Axis(z, "z, mm"), &keys)?;
    for piece in pieces(of) {
        panel.line(piece.into_iter().map(|(_, at)| (at[0], at[2])), &line)?;
    }
    panel.line([(0.0, -8.0), (0.0, 8.0)].into_iter(), &Stroke::new(BLACK, 3.0))?;
    let place = |at: [f64; 2], off: [f64; 2]| (MILLI * (at[0] + off[0]), MILLI * (at[1] + off[1]));
    let all = || releases.iter().map(|release| &release.statistics);
    panel.dots(all().map(|s| place(s.hold, s.offset)), &hold, 4.0)?;
    panel.dots(all().map(|s| place(s.rest, s.offset)), &rest, 4.0)
}

fn across(of: &CleanRecording, releases: &[&CleanRelease], area: &Area) -> Drawn {
    let time = &of.recording.time;
    let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(1.0));
    let line = Stroke::new(BLUE, 1.3);
    let most = releases.iter().map(|release| &release.statistics);
    let most = most.max_by(|a, b| a.out_of_plane.total_cmp(&b.out_of_plane));
    let title = match most {
        None => "Out of the plane".to_owned(),
        Some(s) => format!(
            "From the vertical plane through the clamp: {:.2} mm at most, {:.1} %",
            MILLI * s.out_of_plane,
            1e2 * s.out_of_plane_share
        ),
    };
    let y = padded(used(of).map(|at| at[1]), 0.1);
    // A path that never leaves the plane still needs an axis to be read by.
    let y = if y.end - y.start < LEAST_RANGE { -1.0..1.0 } else { y };
    let keys = [Key::line(line, "tip, used")];
    let mut panel = Panel::new(area, &title, &Axis(first..last, "time, s"), &Axis(y, "y, mm"), &keys)?;
    for piece in pieces(of) {
        panel.line(piece.into_iter().map(|(time, at)| (time, at[1])), &line)?;
    }
    Ok(())
}
