//! A calibration while it works: how far the residuals have come down, and then each release as fitted.

use std::collections::BTreeMap;
use std::fmt::Write;

use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines, SeriesPoints};
use efam_inference::calibrate::{self, Calibration, CalibrationOutcome, Problem, Progress};
use efam_inference::diagnose::Curve;
use efam_inference::diagnose::curve::Sample;
use models::digits::significant;

use super::compared::{draw_fitted, lay_out};
use super::entities::TIMELINE;
use super::search::{STEP, Steps, cell, markdown};
use super::tree::{self, ContainerKind, Property, Tree, under};

const LOG: &str = "fit/log";
const RESIDUALS: &str = "fit/residuals";
const PARAMETERS: &str = "fit/parameters";

/// Each parameter: what it is, its value, its SI unit.
type Parameters = Vec<(String, f64, &'static str)>;

/// What of a calibration was shown.
pub struct Fit {
    steps: Steps,
    /// What was found so far, by what was fitted together.
    parts: BTreeMap<String, Parameters>,
}

impl Fit {
    /// Sends name and layout.
    pub(super) fn begin(recording: &RecordingStream, name: &str, live: bool) -> RecordingStreamResult<Self> {
        let steps = Steps::begin(recording, (name, live), 3, |tree| {
            let pieces = working(tree)?;
            tree.container(ContainerKind::Horizontal, &pieces)?;
            Ok(())
        })?;
        Ok(Self { steps, parts: BTreeMap::new() })
    }

    pub(super) fn doing(&mut self, recording: &RecordingStream, what: &str) -> RecordingStreamResult<()> {
        self.steps.doing(recording, LOG, what)
    }

    /// A stretch was fitted.
    pub(super) fn fitted(
        &mut self,
        recording: &RecordingStream,
        progress: &Progress,
    ) -> RecordingStreamResult<()> {
        self.steps.next(recording);
        let path = tree::path(&["fit", "residuals", &progress.part]);
        if !self.parts.contains_key(&progress.part) {
            let name = progress.part.as_str();
            recording.log_static(path.as_str(), &SeriesLines::new().with_names([name]).with_widths([1.5]))?;
            recording.log_static(path.as_str(), &SeriesPoints::new().with_marker_sizes([3.0]))?;
        }
        recording.log(path.as_str(), &Scalars::single(progress.spread))?;
        self.parts.insert(progress.part.clone(), progress.parameters.clone());
        recording.log(PARAMETERS, &markdown(&so_far(&self.parts)))
    }

    /// The answer, and each release as fitted.
    pub(super) fn found(
        &mut self,
        recording: &RecordingStream,
        problem: &Problem,
        outcome: &CalibrationOutcome,
    ) -> RecordingStreamResult<()> {
        self.steps.next(recording);
        recording.set_duration_secs(TIMELINE, 0.0);
        recording.log(PARAMETERS, &markdown(&answer(&outcome.calibration)))?;
        recording.disable_timeline(STEP);
        let curves: Vec<Curve> = outcome
            .curves
            .iter()
            .enumerate()
            .map(|(k, own)| {
                let is_leading = k == 0 || outcome.curves[k - 1].release != own.release;
                curve(own, is_leading)
            })
            .collect();
        let compared = draw_fitted(recording, &outcome.calibration.as_held(problem), &curves)?;
        tree::send(recording, 4, TIMELINE, self.steps.live, |tree| {
            lay_out(tree, &compared, |tree| {
                tree.view("TextDocument", "Parameters", &[under(PARAMETERS)], &[])
            })
        })
    }
}

/// The views of a search that goes on.
fn working(tree: &mut Tree) -> RecordingStreamResult<Vec<tree::Piece>> {
    let legend = bp::PlotLegend::new().with_corner(bc::Corner2D::RightTop);
    let plot: &[Property] = &[("PlotLegend", &legend)];
    let residuals =
        tree.view("TimeSeries", "Residuals over the noise, stage by stage", &[under(RESIDUALS)], plot)?;
    let log = tree.view("TextLog", "What is being done", &[under(LOG)], &[])?;
    let left = tree.container(ContainerKind::Vertical, &[(residuals, 2.0), (log, 1.0)])?;
    let parameters = tree.view("TextDocument", "Parameters", &[under(PARAMETERS)], &[])?;
    Ok(vec![(left, 1.4), (parameters, 1.0)])
}

/// A track of a calibration as one that was seen by one model only.
fn curve(own: &calibrate::Curve, is_leading: bool) -> Curve {
    let samples = own.time.iter().zip(&own.measured).zip(&own.predicted);
    let sample = |((time, measured), predicted): ((&f64, &[f64; 2]), &[f64; 2])| {
        let (time, measured, predicted) = (*time, *measured, *predicted);
        Some(Sample { time, measured, before: predicted, after: predicted, ..Sample::default() })
    };
    let (release, marker) = (own.release.clone(), own.marker.clone());
    Curve { release, marker, is_leading, samples: samples.map(sample).collect(), ..Curve::default() }
}

fn so_far(parts: &BTreeMap<String, Parameters>) -> String {
    let mut text = "| so far | value | |\n|---|---:|---|\n".to_owned();
    for (label, value, unit) in parts.values().flatten() {
        let _ = writeln!(text, "| {} | {} | {unit} |", cell(label), significant(*value, 5));
    }
    text
}

/// Parameters with their intervals, the fit of each release, warnings.
fn answer(calibration: &Calibration) -> String {
    let mut text = "| parameter | value | 95 % interval | |\n|---|---:|---:|---|\n".to_owned();
    for found in &calibration.parameters {
        let interval = found.interval_95.map_or("not determined".to_owned(), |[low, high]| {
            format!("{} to {}", significant(low, 4), significant(high, 4))
        });
        let value = significant(found.value, 5);
        let _ = writeln!(text, "| {} | {value} | {interval} | {} |", cell(&found.label()), found.unit);
    }
    text += "\n| release | rms, mm | noise, mm |\n|---|---:|---:|\n";
    for release in &calibration.releases {
        for track in &release.tracks {
            let [rms, noise] = [track.rms_mm, track.stated_noise_mm].map(|value| significant(value, 3));
            let _ = writeln!(text, "| {}, {} | {rms} | {noise} |", cell(&release.name), cell(&track.marker));
        }
    }
    for warning in &calibration.warnings {
        let _ = write!(text, "\n- {}", cell(warning));
    }
    text
}
