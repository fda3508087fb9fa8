//! An ensemble of rods: the prediction of one case with what the errors of its calibration admit, or of several cases,
//! all let go at one instant.

use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::{
    LineStrips2D, Radius, RecordingStream, RecordingStreamResult, Scalars, SeriesLines, Transform3D,
};
use efam_inference::predict::ensemble::Member;
use rayon::prelude::*;

use super::blueprint::Bounds;
use super::compared::{Postures, postures};
use super::entities::TIMELINE;
use super::scenery::{BLUE, GREY, clamp, single};
use super::tree::{self, ContainerKind, Property, path, under};

const WORLD: &str = "ensemble";
const HEIGHT: &str = "height";
const DRAWS: &str = "(draws)";

/// Sends name and layout, and draws all.
pub(super) fn draw(
    recording: &RecordingStream,
    name: &str,
    live: bool,
    members: &[Member],
) -> RecordingStreamResult<()> {
    recording.send_recording_name(name)?;
    let rods: Vec<Postures> = members.par_iter().map(|member| postures(&member.model, &member.run)).collect();
    let reach = members.iter().map(|member| 1.15 * (member.model.rod().length + member.model.tip_distance));
    let reach = reach.fold(0.0, f64::max);
    let mut bounds = Bounds::hanging(reach);
    recording.log_static(WORLD, &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
    recording.log_static(path(&[WORLD, "clamp"]), &clamp(0.25 * reach))?;
    let named = members.iter().filter(|member| !member.is_draw).count();
    let mut number = 0;
    for (member, rods) in members.iter().zip(&rods) {
        // Draws are grey behind the case itself; cases go from dark to light.
        let (color, width) = match member.is_draw {
            true => (GREY, 0.7),
            false if named == 1 => (BLUE, 2.2),
            false => (shade(number, named), 1.6),
        };
        number += usize::from(!member.is_draw);
        // The viewer draws lines in the order of their names: those of the draws come first.
        let parts: &[&str] = if member.is_draw { &[DRAWS, &member.name] } else { &[&member.name] };
        let [rod, height] = [WORLD, HEIGHT].map(|root| path(&[&[root], parts].concat()));
        let style = LineStrips2D::update_fields()
            .with_colors([color])
            .with_radii([Radius::new_ui_points(width)])
            .with_draw_order(if member.is_draw { 10.0 } else { 20.0 });
        recording.log_static(rod.as_str(), &style)?;
        let line =
            SeriesLines::new().with_names([member.name.as_str()]).with_colors([color]).with_widths([width]);
        recording.log_static(height.as_str(), &line)?;
        for (time, nodes) in rods {
            recording.set_duration_secs(TIMELINE, *time);
            nodes.iter().for_each(|point| {
                bounds.widen(*point);
            });
            let tip = nodes.last().map_or(0.0, |tip| tip[1]);
            recording.log(
                rod.as_str(),
                &LineStrips2D::new([nodes.iter().copied().map(single).collect::<Vec<_>>()]),
            )?;
            recording.log(height.as_str(), &Scalars::single(1e3 * tip))?;
        }
    }
    let title = if members.iter().any(|member| member.is_draw) {
        "Predicted rod (blue), draws from the calibration's errors (grey); x right, z up (mm)"
    } else {
        "Predicted rods, darker for the first cases; x right, z up (mm)"
    };
    tree::send(recording, 5, TIMELINE, live, |tree| {
        let bounds = bounds.view();
        let rod: &[Property] = &[("VisualBounds2D", &bounds)];
        let legend = bp::PlotLegend::new().with_corner(bc::Corner2D::RightTop).with_visible(named > 1);
        let plot: &[Property] = &[("PlotLegend", &legend)];
        let left = tree.view("2D", title, &[under(WORLD)], rod)?;
        let right = tree.view("TimeSeries", "Height of the tip (mm)", &[under(HEIGHT)], plot)?;
        tree.container(ContainerKind::Horizontal, &[(left, 1.0), (right, 1.2)])?;
        Ok(())
    })
}

/// From blue to nearly white, RGBA: seen on black as well as on white.
fn shade(number: usize, count: usize) -> u32 {
    let share = number as f64 / (count.max(2) - 1) as f64;
    let mix = |dark: f64, light: f64| (dark + share * (light - dark)).round() as u32;
    (mix(50.0, 225.0) << 24) | (mix(110.0, 238.0) << 16) | (mix(205.0, 255.0) << 8) | 0xff
}
