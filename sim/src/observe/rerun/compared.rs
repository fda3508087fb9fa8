//! Releases as they were measured, and as they are simulated: before something was added and after, or as fitted.
//!
//! One colour is before, vermilion, another after, blue, as in the report; what was measured is grey.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::{
    AsComponents, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult, Scalars,
    SeriesLines, SeriesPoints, Transform3D,
};
use efam_core::forward::{Run, forward, uniform};
use efam_core::quantile::quantile;
use efam_inference::calibrate::{Problem, Trial};
use efam_inference::diagnose::curve::{BEFORE_AND_AFTER, Predicted, Sample};
use efam_inference::diagnose::{Curve, DiagnosisOutcome};
use models::model::Model;
use rayon::prelude::*;

use super::blueprint::Bounds;
use super::entities::TIMELINE;
use super::scenery::{BLUE, GREY, VERMILION, clamp, milli, single};
use super::tree::{self, ContainerKind, Property, Tree};

/// Postures a second.
const POSTURES: f64 = 50.0;
/// Share of the residuals that the axis over the phase has room for.
const MOST: f64 = 0.995;

/// A simulation that is shown: its name and colour, the place of its prediction in a sample, the width of its rod.
pub(super) struct Shown {
    pub name: &'static str,
    /// The viewer draws curves in the order of their paths.
    pub path: &'static str,
    pub color: u32,
    pub of: Predicted,
    pub width: f32,
}

/// Without what was added, and with it; what comes after is drawn on top.
const BEFORE: Shown =
    Shown { name: "before", path: "1_before", color: VERMILION, of: BEFORE_AND_AFTER[0], width: 3.5 };
const AFTER: Shown =
    Shown { name: "after", path: "2_after", color: BLUE, of: BEFORE_AND_AFTER[1], width: 1.5 };
/// What a calibration has found.
const FITTED: Shown =
    Shown { name: "fitted", path: "2_fitted", color: BLUE, of: BEFORE_AND_AFTER[1], width: 2.0 };

/// A release that was drawn.
pub(super) struct Compared {
    name: String,
    is_held_out: bool,
    bounds: Bounds,
    /// Whether its residual is shown over the phase of the swing, too.
    has_phases: bool,
    /// Title of the view of the rods.
    title: &'static str,
}

/// Draws all releases of a diagnosis.
pub(super) fn draw(
    recording: &RecordingStream,
    outcome: &DiagnosisOutcome,
) -> RecordingStreamResult<Vec<Compared>> {
    let title = "Rod before (vermilion), after (blue), measured (grey)";
    let simulated = [(BEFORE, &outcome.baseline), (AFTER, &outcome.repaired)];
    draw_all(recording, &simulated, &outcome.curves, (true, title))
}

/// Draws all releases of a calibration, whose problem has what was found.
pub(super) fn draw_fitted(
    recording: &RecordingStream,
    fitted: &Problem,
    curves: &[Curve],
) -> RecordingStreamResult<Vec<Compared>> {
    let title = "Rod as fitted (blue), measured (grey)";
    draw_all(recording, &[(FITTED, fitted)], curves, (false, title))
}

fn draw_all(
    recording: &RecordingStream,
    simulated: &[(Shown, &Problem)],
    curves: &[Curve],
    (has_phases, title): (bool, &'static str),
) -> RecordingStreamResult<Vec<Compared>> {
    let rods: Vec<_> = simulated.iter().map(|(_, problem)| postures_of(problem)).collect();
    let shown: Vec<&Shown> = simulated.iter().map(|(shown, _)| shown).collect();
    let Some((_, last)) = simulated.last() else { return Ok(Vec::new()) };
    let drawn = last.trials.iter().enumerate().map(|(t, trial)| {
        let own = Own { recording, name: &trial.release.name, shown: &shown };
        let curves: Vec<&Curve> = curves.iter().filter(|curve| curve.release == trial.release.name).collect();
        let reach = 1.15 * (trial.model.rod().length + trial.model.tip_distance);
        let mut compared = Compared {
            name: trial.release.name.clone(),
            is_held_out: trial.release.held_out,
            bounds: Bounds::hanging(reach),
            has_phases,
            title,
        };
        own.draw_surroundings(reach)?;
        for (shown, rods) in shown.iter().zip(&rods) {
            own.draw_rod(shown, &rods[t], &mut compared.bounds)?;
        }
        own.draw_markers(&curves)?;
        for curve in curves.iter().filter(|curve| curve.is_leading) {
            own.plot(curve)?;
            if has_phases {
                own.draw_phases(curve)?;
            }
        }
        Ok(compared)
    });
    drawn.collect()
}

/// A rod at instants after its release, s, m.
pub(super) type Postures = Vec<(f64, Vec<[f64; 2]>)>;

fn postures_of(problem: &Problem) -> Vec<Postures> {
    let of_trial = |trial: &Arc<Trial>| {
        let duration = trial.release.time.last().copied().unwrap_or(0.0);
        postures(&trial.model, &Run { duration, ..trial.run.clone() })
    };
    problem.trials.par_iter().map(of_trial).collect()
}

/// The rod of a run, with the observed point behind its last node, as far as it can be run.
pub(super) fn postures(model: &Model, run: &Run) -> Postures {
    let run = Run { samples: uniform(run.duration, POSTURES), ..run.clone() };
    let mut all = Vec::new();
    // Where it ends is seen.
    let _ = forward(model, &run, &mut |sample| {
        let snapshot = sample.snapshot();
        let mut rod = snapshot.nodes;
        rod.push(snapshot.tip);
        all.push((snapshot.time, rod));
        ControlFlow::Continue(())
    });
    all
}

/// What belongs to one release.
struct Own<'a> {
    recording: &'a RecordingStream,
    name: &'a str,
    shown: &'a [&'a Shown],
}

/// The path of something of a release.
fn path(name: &str, parts: &[&str]) -> String {
    tree::path(&[&["releases", name], parts].concat())
}

impl Own<'_> {
    fn log(&self, parts: &[&str], what: &impl AsComponents) -> RecordingStreamResult<()> {
        self.recording.log(path(self.name, parts), what)
    }

    fn log_static(&self, parts: &[&str], what: &impl AsComponents) -> RecordingStreamResult<()> {
        self.recording.log_static(path(self.name, parts), what)
    }

    fn draw_surroundings(&self, reach: f64) -> RecordingStreamResult<()> {
        self.log_static(&["world"], &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
        self.log_static(&["world", "clamp"], &clamp(0.25 * reach))?;
        for Shown { name, path, color, .. } in self.shown {
            let line = SeriesLines::new().with_names([*name]).with_colors([*color]).with_widths([1.5]);
            self.log_static(&["height", path], &line)?;
            self.log_static(&["residual", path], &line)?;
        }
        let dots = SeriesPoints::new().with_names(["measured"]).with_colors([GREY]).with_marker_sizes([1.5]);
        self.log_static(&["height", "measured"], &dots)
    }

    fn draw_rod(
        &self,
        Shown { name, color, width, .. }: &Shown,
        postures: &Postures,
        bounds: &mut Bounds,
    ) -> RecordingStreamResult<()> {
        let style = LineStrips2D::update_fields()
            .with_colors([*color])
            .with_radii([Radius::new_ui_points(*width)])
            .with_draw_order(20.0 - *width);
        self.log_static(&["world", name], &style)?;
        for (time, rod) in postures {
            self.recording.set_duration_secs(TIMELINE, *time);
            rod.iter().for_each(|point| {
                bounds.widen(*point);
            });
            let rod: Vec<[f32; 2]> = rod.iter().copied().map(single).collect();
            self.log(&["world", name], &LineStrips2D::new([rod]))?;
        }
        Ok(())
    }

    /// All markers at once, at the times of the first.
    fn draw_markers(&self, curves: &[&Curve]) -> RecordingStreamResult<()> {
        let style = Points2D::update_fields()
            .with_colors([GREY])
            .with_radii([Radius::new_ui_points(4.0)])
            .with_draw_order(40.0);
        self.log_static(&["world", "measured"], &style)?;
        let count = curves.iter().map(|curve| curve.samples.len()).max().unwrap_or(0);
        for k in 0..count {
            let seen: Vec<&Sample> =
                curves.iter().filter_map(|curve| curve.samples.get(k)?.as_ref()).collect();
            let Some(first) = seen.first() else { continue };
            self.recording.set_duration_secs(TIMELINE, first.time);
            let places = seen.iter().map(|sample| single(sample.measured));
            self.log(&["world", "measured"], &Points2D::new(places))?;
        }
        Ok(())
    }

    fn plot(&self, curve: &Curve) -> RecordingStreamResult<()> {
        for sample in curve.seen() {
            self.recording.set_duration_secs(TIMELINE, sample.time);
            self.log(&["height", "measured"], &Scalars::single(1e3 * sample.measured[1]))?;
            for Shown { path, of, .. } in self.shown {
                self.log(&["height", path], &Scalars::single(1e3 * of(sample)[1]))?;
                self.log(&["residual", path], &Scalars::single(1e3 * sample.across(of(sample))))?;
            }
        }
        Ok(())
    }

    /// The residual over the phase of the swing, which goes from 0 to 2, as a share of the largest, 1.
    fn draw_phases(&self, curve: &Curve) -> RecordingStreamResult<()> {
        let sizes = curve.seen().map(|sample| sample.across(sample.before).abs()).collect();
        let most = quantile(sizes, MOST).unwrap_or(0.0).max(2.0 * curve.noise);
        self.log_static(&["phase"], &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
        for Shown { path, color, of, .. } in self.shown {
            let point = |sample: &Sample| {
                let turn = sample.phase.rem_euclid(TAU) / TAU;
                single([2.0 * turn, (sample.across(of(sample)) / most).clamp(-1.0, 1.0)])
            };
            let points = Points2D::new(curve.seen().map(point))
                .with_colors([*color])
                .with_radii([Radius::new_ui_points(1.5)]);
            self.log_static(&["phase", path], &points)?;
        }
        let level = |y: f32| vec![[0.0, y], [2.0, y]];
        let upright = |x: f32| vec![[x, -1.0], [x, 1.0]];
        let noise = (curve.noise / most) as f32;
        let frame = [level(-1.0), level(0.0), level(1.0), upright(0.0), upright(1.0), upright(2.0)];
        let frame = LineStrips2D::new(frame.into_iter().chain([level(2.0 * noise), level(-2.0 * noise)]))
            .with_colors([0x8080_8080_u32])
            .with_radii([Radius::new_ui_points(0.5)]);
        self.log_static(&["phase", "frame"], &frame)?;
        let labels = [
            ([0.0, -1.1], "upper turn".to_owned()),
            ([1.0, -1.1], "lower turn".to_owned()),
            ([2.0, -1.1], "upper turn".to_owned()),
            ([-0.1, 1.0], format!("{} mm", short(most))),
            ([-0.1, 0.0], "0".to_owned()),
        ];
        let (places, labels): (Vec<[f32; 2]>, Vec<String>) = labels.into_iter().unzip();
        let labels = Points2D::new(places)
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([GREY])
            .with_radii([Radius::new_ui_points(0.5)]);
        self.log_static(&["phase", "labels"], &labels)
    }
}

/// Each release on a tab of its own, the first in front, with words at the side.
pub(super) fn lay_out(
    tree: &mut Tree,
    compared: &[Compared],
    words: impl FnOnce(&mut Tree) -> RecordingStreamResult<String>,
) -> RecordingStreamResult<()> {
    let tabs: Vec<_> = compared
        .iter()
        .map(|release| Ok((release.lay_out(tree)?, 1.0)))
        .collect::<RecordingStreamResult<_>>()?;
    let mut columns = vec![];
    if !tabs.is_empty() {
        columns.push((tree.container(ContainerKind::Tabs, &tabs)?, 2.2));
    }
    columns.push((words(tree)?, 1.0));
    tree.container(ContainerKind::Horizontal, &columns)?;
    Ok(())
}

/// A length in mm to hundredths.
fn short(length: f64) -> String {
    milli((1e5 * length).round() / 1e5)
}

impl Compared {
    /// Its tab: the rod, and beside it what goes over time and over the phase.
    pub(super) fn lay_out(&self, tree: &mut Tree) -> RecordingStreamResult<String> {
        let below = |part: &str| [format!("+ {}/**", path(&self.name, &[part]))];
        let bounds = self.bounds.view();
        let rod: &[Property] = &[("VisualBounds2D", &bounds)];
        let legend = bp::PlotLegend::new().with_corner(bc::Corner2D::RightTop);
        let plot: &[Property] = &[("PlotLegend", &legend)];
        let phases = Bounds { x: [-0.25, 2.15], z: [-1.25, 1.1] }.view();
        let phases: &[Property] = &[("VisualBounds2D", &phases)];
        let left = tree.view("2D", self.title, &below("world"), rod)?;
        let mut rows = vec![
            (tree.view("TimeSeries", "Height of the tip (mm)", &below("height"), plot)?, 1.0),
            (
                tree.view("TimeSeries", "Measured minus predicted, across (mm)", &below("residual"), plot)?,
                1.0,
            ),
        ];
        if self.has_phases {
            rows.push((tree.view("2D", "The same over the swing's phase", &below("phase"), phases)?, 1.4));
        }
        let right = tree.container(ContainerKind::Vertical, &rows)?;
        let title = format!("{}{}", self.name, if self.is_held_out { " (held out)" } else { "" });
        tree.titled(ContainerKind::Horizontal, Some(&title), &[(left, 1.0), (right, 1.2)])
    }
}
