//! The paper's Figures 4 to 9, drawn from runs of our own or from recordings.

use efam_experiments::analysis::static_stiffness::NODES;

use crate::paper::{Origin, Pressure, Shape};
use crate::picture::lines::{Lines, Named, looks};
use crate::picture::panel::{Axis, Key, Panel, Stroke, equal_scale, plot_size};
use crate::picture::tips::trajectories;
use crate::picture::{
    Area, BLACK, Drawing, Drawn, MILLI, PASCAL_PER_PSI, Picture, PressureRow, ReleasePicture, Tip, drawn,
    pressures,
};
use crate::simulated::psi;

/// By how much the shapes of one pressure are beside those of the one before, and of one model below those
/// of the one above, mm: the paper's own distance.
const APART: f64 = 350.0;
/// Models whose shapes the paper's Figure 7 shows.
const SHAPES: [Option<usize>; 5] = [None, Some(4), Some(8), Some(16), Some(32)];
/// Pressures up to which all paths are drawn, and all shapes beside one another.
const MOST_PATHS: usize = 10;
/// The pressure of the paper's Figure 8, psi.
pub const EXAMPLE_PSI: f64 = 15.0;

/// A pressure in psi.
pub fn in_psi(of: &Pressure) -> f64 {
    (1e3 * of.pressure / PASCAL_PER_PSI).round() / 1e3
}

/// Every other pressure from the lowest on, as the paper's Figure 4 has them; of few all.
pub fn every_other(all: &[Pressure]) -> Vec<&Pressure> {
    all.iter().step_by(if all.len() > MOST_PATHS { 2 } else { 1 }).collect()
}

/// The pressure that Figure 8 shows: the one nearest to the paper's.
pub fn example(all: &[Pressure]) -> Option<&Pressure> {
    let off = |of: &&Pressure| (in_psi(of) - EXAMPLE_PSI).abs();
    all.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Whether the figures show recordings.
pub fn are_recorded(all: &[Pressure]) -> bool {
    all.iter().any(Pressure::is_recorded)
}

/// Figures 4 to 9, in their order.
pub fn paper(all: &[Pressure]) -> Vec<Picture> {
    vec![figure_4(all), figure_5(all), figure_6(all), figure_7(all), figure_8(all), figure_9(all)]
}

fn picture(number: usize, title: &str, caption: &str, drawing: Drawing) -> Picture {
    Picture {
        name: format!("figure-{number}"),
        title: format!("Figure {number}. {title}"),
        caption: caption.to_owned(),
        drawing,
    }
}

fn tip(of: &Pressure) -> Tip<'_> {
    Tip { name: psi(of.pressure), times: &of.times, path: &of.path, rest: of.tip_at_rest, case: None }
}

/// Two texts, one for figures of recordings and one for figures of simulations.
fn either(all: &[Pressure], recorded: &'static str, simulated: &'static str) -> &'static str {
    if are_recorded(all) { recorded } else { simulated }
}

fn figure_4(all: &[Pressure]) -> Picture {
    let tips: Vec<Tip> = every_other(all).into_iter().map(tip).collect();
    let title = either(all, "Paths of the tip, recorded", "Paths of the tip, simulated");
    let drawing = drawn((900, 760), |page| trajectories(page, title, &tips.iter().collect::<Vec<_>>(), &[]));
    let caption = either(
        all,
        "Recorded paths of the tip and its rests. Paths begin where they are named; masked samples are left out.",
        "Simulated paths of the tip and its rests, in steps of 10 psi from 5 psi on. Paths begin where they are named.",
    );
    picture(4, "Paths of the tip and its rest", caption, drawing)
}

/// Something of each pressure over psi.
fn over_psi(all: &[Pressure], of: impl Fn(&Pressure) -> Option<f64>) -> Vec<(f64, f64)> {
    all.iter().filter_map(|own| Some((in_psi(own), of(own)?))).collect()
}

/// Name of a fitted model.
pub fn model(nodes: Option<usize>) -> String {
    nodes.map_or("Euler-Bernoulli".to_owned(), |nodes| format!("PDER, {nodes} nodes"))
}

/// The beam and the rods.
pub fn models() -> impl Iterator<Item = Option<usize>> {
    std::iter::once(None).chain(NODES.into_iter().map(Some))
}

fn figure_5(all: &[Pressure]) -> Picture {
    let axial = either(all, "axial test, of the muscle's file", "axial test, Table 2 by eq. 8");
    let mut lines: Vec<Named> = vec![(axial.to_owned(), over_psi(all, |of| of.published[0]))];
    lines.retain(|line| !line.1.is_empty());
    lines.extend(models().map(|nodes| {
        let ei = |of: &Pressure| of.fit(nodes).map(|fit| fit.bending_stiffness);
        (model(nodes), over_psi(all, ei))
    }));
    let of = Lines {
        title: "Bending stiffness over pressure, by method",
        x: "pressure, psi",
        y: "EI, N m²",
        marks: true,
        from_zero: true,
        why: "no tip at rest",
    };
    let caption = either(
        all,
        "Fitted to the recorded tips at rest; a release with an inclined base has no Euler-Bernoulli beam.",
        "The axial column is Table 2's. All others are fitted here to the tip at rest of our own runs, which have the EI of Table 2's rod of 32 nodes.",
    );
    picture(5, "Bending stiffness by method", caption, drawn((900, 640), |page| of.draw(page, &lines)))
}

fn figure_6(all: &[Pressure]) -> Picture {
    let error = |nodes: Option<usize>| move |of: &Pressure| of.tip_error(nodes).map(|error| MILLI * error);
    // In a simulation 32 nodes have made the tip: their error is none by construction.
    let recorded = are_recorded(all);
    let of_models = || models().filter(|nodes| recorded || *nodes != Some(32));
    let over: Vec<Named> = of_models().map(|nodes| (model(nodes), over_psi(all, error(nodes)))).collect();
    let some: Vec<&Pressure> = all.iter().step_by((all.len() / 5).max(1)).collect();
    let by_nodes: Vec<Named> = some
        .iter()
        .map(|of| {
            let rods = of_models().flatten();
            (psi(of.pressure), rods.filter_map(|n| Some((n as f64, error(Some(n))(of)?))).collect())
        })
        .collect();
    let first = Lines {
        title: "A: over pressure",
        x: "pressure, psi",
        y: "tip error, mm",
        marks: true,
        from_zero: true,
        why: "no tip at rest",
    };
    let second = Lines { title: "B: over the number of nodes", x: "nodes of the discrete rod", ..first };
    let drawing = drawn((1200, 560), |page| {
        let panels = page.split_evenly((1, 2));
        first.draw(&panels[0], &over)?;
        second.draw(&panels[1], &by_nodes)
    });
    let caption = either(
        all,
        "Distance of each model's tip from the recorded one at rest, with the EI that comes nearest.",
        "Distance of each model's tip from the simulated one, with the EI that comes nearest. The rod of 32 nodes made the tip and is left out.",
    );
    picture(6, "Tip error over pressure and nodes", caption, drawing)
}

fn figure_7(all: &[Pressure]) -> Picture {
    let rows = if all.len() > MOST_PATHS { 2 } else { 1 };
    let half = all.len().div_ceil(rows).max(1);
    let drawing = drawn((1200, 620 * rows as u32), |page| {
        let panels = page.split_evenly((rows, 1));
        for ((own, name), area) in all.chunks(half).zip(["A", "B"]).zip(&panels) {
            shapes(area, name, own)?;
        }
        Ok(())
    });
    let caption = either(
        all,
        "Shapes at rest, models below one another, pressures beside one another. Rings: the markers of the recordings.",
        "Shapes at rest, models below one another, pressures beside one another. Rings: our simulated rod, in place of the paper's markers, whose positions are not published.",
    );
    picture(7, "Shapes at rest", caption, drawing)
}

fn shapes(area: &Area, name: &str, all: &[Pressure]) -> Drawn {
    let at = |(x, z): (usize, usize), point: &[f64; 2]| {
        (APART * x as f64 + MILLI * point[0], MILLI * point[1] - APART * z as f64)
    };
    let (line, ring) = (looks()[0], Stroke::new(BLACK, 1.2));
    let keys = [
        Key::line(Stroke { width: 1.8, ..line }, "model with its fitted EI, end fitting included"),
        Key::ring(ring, either(all, "recorded markers and tip", "simulated rod and tip")),
    ];
    let title = match (all.first(), all.last()) {
        (Some(first), Some(last)) => format!("{name}: {} to {}", psi(first.pressure), psi(last.pressure)),
        _ => name.to_owned(),
    };
    let x = -1.1 * APART..APART * all.len() as f64 + 60.0;
    let z = -APART * SHAPES.len() as f64 + 20.0..0.45 * APART;
    let (x, z) = equal_scale(x, z, plot_size(area, &keys));
    let labels = ["x, mm, each pressure 350 mm farther right", "z, mm, each model 350 mm lower"];
    let mut panel = Panel::new(area, &title, &Axis(x, labels[0]), &Axis(z, labels[1]), &keys)?;
    for (row, nodes) in SHAPES.iter().enumerate() {
        let height = -APART * row as f64;
        panel.text((-1.05 * APART, height - 60.0), &model(*nodes).replace("Euler-Bernoulli", "Euler-B."))?;
    }
    for (column, of) in all.iter().enumerate() {
        panel.text((APART * column as f64 - 20.0, 0.25 * APART), &psi(of.pressure))?;
        for (row, nodes) in SHAPES.iter().enumerate() {
            let Some(shape) = of.shapes.iter().find(|shape| shape.nodes == *nodes) else { continue };
            one_shape(&mut panel, of, shape, &line, &ring, |point| at((column, row), point))?;
        }
    }
    Ok(())
}

fn one_shape(
    panel: &mut Panel,
    of: &Pressure,
    shape: &Shape,
    line: &Stroke,
    ring: &Stroke,
    at: impl Fn(&[f64; 2]) -> (f64, f64),
) -> Drawn {
    panel.line(shape.points.iter().map(&at), &Stroke { width: 1.8, ..*line })?;
    panel.dots(shape.points.last().map(&at), line, 2.0)?;
    // Of a simulated rod some points represent markers.
    let every = if of.is_recorded() { 1 } else { (of.body_at_rest.len() / 6).max(1) };
    let body = of.body_at_rest.iter().map(|(_, at)| at).step_by(every).skip(1);
    panel.rings(body.chain(&of.tip_at_rest).map(at), ring, 2.6)
}

fn figure_8(all: &[Pressure]) -> Picture {
    let drawing = drawn((1200, 520), |page| {
        let panels = page.split_evenly((1, 2));
        let Some(of) = example(all) else {
            return Panel::without_data(page, "One release", "there is none");
        };
        match &of.origin {
            Origin::Simulated(own) => {
                let release = ReleasePicture {
                    model: &own.model,
                    trajectory: &own.trajectory,
                    energy_followed: false,
                    rest: own.rest.as_ref(),
                    summary: &own.summary,
                    swings: &own.swings,
                };
                crate::picture::swing(&release, own.shown(), &panels[0])?;
                crate::picture::spectrum(&release, own.shown(), &panels[1])
            }
            Origin::Recorded(None) => Panel::without_data(page, "One release", "too few samples"),
            Origin::Recorded(Some(own)) => {
                crate::picture::measured::swing(own, &panels[0])?;
                crate::picture::measured::frequencies(own, &panels[1])
            }
        }
    });
    let (pressure, name, letter) = example(all).map_or_else(Default::default, |of| {
        let letter = of.coordinate().letter();
        (psi(of.pressure), of.name.clone(), letter)
    });
    let caption = if are_recorded(all) {
        format!("{name}: {letter}(t) with eq. 6 fitted to its upper peaks, and its amplitude spectrum.")
    } else {
        format!(
            "The simulated release at {pressure}: {letter}(t) with eq. 6 fitted to its upper peaks, and its amplitude spectrum."
        )
    };
    picture(8, &format!("Decay and spectrum at {pressure}"), &caption, drawing)
}

fn figure_9(all: &[Pressure]) -> Picture {
    let row = |of: &Pressure| PressureRow {
        pressure: of.pressure,
        natural_frequency: of.numbers.natural_frequency_hz,
        mode_frequency: of.numbers.first_mode_hz,
        damping_ratio: of.numbers.damping_ratio,
    };
    let rows: Vec<PressureRow> = all.iter().map(row).collect();
    let origin = either(all, "recorded", "simulated");
    let caption = either(
        all,
        "Recorded, by the paper's method; the first mode is that of the rod of 32 nodes with the EI of the tip at rest. Words and the shaded strip: what the paper's text says of its own curves.",
        "Simulated, by the paper's method. Words and the shaded strip: what the paper's text says of its own curves; no point of them is published.",
    );
    let drawing = pressures("Figure 9", origin, &rows);
    picture(9, "Natural frequency and damping ratio over pressure", caption, drawing)
}
