//! The paper's Figures 4 to 9, drawn from runs of our own.

use super::lines::{Lines, Named, looks};
use super::panel::{Axis, Key, Panel, Stroke, equal_scale, plot_size};
use super::tips::trajectories;
use super::{
    Area, BLACK, Drawn, MILLI, PASCAL_PER_PSI, Picture, PressureRow, Release, Tip, drawn, pressures,
};
use crate::analysis::static_stiffness::NODES;
use crate::figures::{Pressure, Shape};
use crate::results::simulated::psi;

/// By how much the shapes of one pressure stand beside those of the one before, and of one model below those
/// of the one above, mm: the paper's own distance.
const APART: f64 = 350.0;
/// Models whose shapes the paper's Figure 7 shows.
const SHAPES: [Option<usize>; 5] = [None, Some(4), Some(8), Some(16), Some(32)];
/// The pressure of the paper's Figure 8, psi.
pub const EXAMPLE_PSI: f64 = 15.0;

/// A pressure in psi.
pub fn in_psi(of: &Pressure) -> f64 {
    (1e3 * of.pressure / PASCAL_PER_PSI).round() / 1e3
}

/// Every other pressure from the lowest on, as the paper's Figure 4 has them.
pub fn every_other(all: &[Pressure]) -> Vec<&Pressure> {
    all.iter().step_by(2).collect()
}

/// The run that Figure 8 shows.
pub fn example(all: &[Pressure]) -> Option<&Pressure> {
    all.iter().find(|of| (in_psi(of) - EXAMPLE_PSI).abs() < 0.01)
}

/// Figures 4 to 9, in their order.
pub fn paper(all: &[Pressure]) -> Vec<Picture> {
    vec![figure_4(all), figure_5(all), figure_6(all), figure_7(all), figure_8(all), figure_9(all)]
}

fn picture(number: usize, title: &str, caption: &str, svg: String) -> Picture {
    Picture {
        name: format!("figure-{number}"),
        title: format!("Figure {number}. {title}"),
        caption: caption.to_owned(),
        svg,
    }
}

fn tip(of: &Pressure) -> Tip<'_> {
    Tip {
        name: psi(of.pressure),
        times: &of.trajectory.times,
        path: &of.trajectory.tip,
        rest: of.rest.as_ref().ok().map(|rest| rest.tip),
    }
}

fn figure_4(all: &[Pressure]) -> Picture {
    let tips: Vec<Tip> = every_other(all).into_iter().map(tip).collect();
    let svg = drawn((900, 760), |page| {
        trajectories(page, "Paths of the tip, simulated", &tips.iter().collect::<Vec<_>>())
    });
    let caption = "Simulated paths of the tip and its rests, in steps of 10 psi from 5 psi on. Paths begin where they are named.";
    picture(4, "Paths of the tip and its rest", caption, svg)
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
    let mut lines: Vec<Named> =
        vec![("axial test, Table 2 by eq. 8".to_owned(), over_psi(all, |of| Some(of.published[0])))];
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
        why: "no run came to rest",
    };
    let caption = "The axial column is Table 2's. All others are fitted here to the tip at rest of our own runs, which have the EI of Table 2's rod of 32 nodes.";
    picture(5, "Bending stiffness by method", caption, drawn((900, 640), |page| of.draw(page, &lines)))
}

fn figure_6(all: &[Pressure]) -> Picture {
    let error = |nodes: Option<usize>| move |of: &Pressure| of.tip_error(nodes).map(|error| MILLI * error);
    // 32 nodes have made the tip: their error is none by construction.
    let of_models = || models().filter(|nodes| *nodes != Some(32));
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
        why: "no run came to rest",
    };
    let second = Lines { title: "B: over the number of nodes", x: "nodes of the discrete rod", ..first };
    let svg = drawn((1200, 560), |page| {
        let panels = page.split_evenly((1, 2));
        first.draw(&panels[0], &over)?;
        second.draw(&panels[1], &by_nodes)
    });
    let caption = "Distance of each model's tip from the simulated one, with the EI that comes nearest. The rod of 32 nodes made the tip and is left out.";
    picture(6, "Tip error over pressure and nodes", caption, svg)
}

fn figure_7(all: &[Pressure]) -> Picture {
    let half = all.len().div_ceil(2).max(1);
    let svg = drawn((1200, 1240), |page| {
        let panels = page.split_evenly((2, 1));
        for ((own, name), area) in all.chunks(half).zip(["A", "B"]).zip(&panels) {
            shapes(area, name, own)?;
        }
        Ok(())
    });
    let caption = "Shapes at rest, models below one another, pressures beside one another. Rings: our simulated rod, in place of the paper's markers, whose positions are not published.";
    picture(7, "Shapes at rest", caption, svg)
}

fn shapes(area: &Area, name: &str, all: &[Pressure]) -> Drawn {
    let at = |(x, z): (usize, usize), point: &[f64; 2]| {
        (APART * x as f64 + MILLI * point[0], MILLI * point[1] - APART * z as f64)
    };
    let (line, ring) = (looks()[0], Stroke::new(BLACK, 1.2));
    let keys = [
        Key::line(Stroke { width: 1.8, ..line }, "model with its fitted EI, end fitting included"),
        Key::ring(ring, "simulated rod and tip"),
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
    if let Ok(rest) = &of.rest {
        let every = (rest.nodes.len() / 6).max(1);
        let markers = rest.nodes.iter().step_by(every).skip(1).chain([&rest.tip]);
        panel.rings(markers.map(at), ring, 2.6)?;
    }
    Ok(())
}

fn figure_8(all: &[Pressure]) -> Picture {
    let svg = drawn((1200, 520), |page| {
        let panels = page.split_evenly((1, 2));
        let Some(of) = example(all) else {
            return Panel::without_data(page, "One release", "no run at 15 psi");
        };
        let release = Release {
            model: &of.model,
            trajectory: &of.trajectory,
            energy_followed: false,
            rest: of.rest.as_ref().ok(),
            summary: &of.summary,
            swing: &of.swing,
        };
        super::height(&release, &panels[0])?;
        super::spectrum(&release, &panels[1])
    });
    let caption = "The simulated release at 15 psi: z(t) with eq. 6 fitted to its upper peaks, and its amplitude spectrum.";
    picture(8, "Decay and spectrum at 15 psi", caption, svg)
}

fn figure_9(all: &[Pressure]) -> Picture {
    let rows: Vec<PressureRow> = all.iter().map(|of| PressureRow::new(of.pressure, &of.summary)).collect();
    let caption = "Simulated, by the paper's method. Words and the shaded strip: what the paper's text says of its own curves; no point of them is published.";
    picture(9, "Natural frequency and damping ratio over pressure", caption, pressures("Figure 9", &rows))
}
