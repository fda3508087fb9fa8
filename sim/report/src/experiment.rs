//! What the cleaning and the analysis of an experiment leave on disk.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html         the page for people, with the pictures that lie in pictures/
//!   experiment.toml     the experiment as it was read
//!   summary.json        recordings, releases with their numbers, decisions; the analysis, if it was requested
//!   <recording>.svg     what was cut and masked
//!   <release>.csv       the cleaned release: t_s, <marker>_x_m, <marker>_z_m in the frame at the clamp
//!   <release>.svg       its swing, spectrum and damping, if it was analysed
//! ```

mod page;
mod text;

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::path::Path;
use std::time::SystemTime;

use efam_experiments::analyse::Analysed;
use efam_experiments::cleaning::{CleanRelease, Cleaned, Statistics};
use efam_experiments::experiment::{Entry, Experiment};
use efam_experiments::out_of_plane::over_pressures;
use efam_experiments::release::Release;
use efam_store::StoreError;
use efam_store::escape::cell;
use efam_store::folder::Folder;
use efam_store::input;
use efam_store::names::plain_name;
use efam_store::sha::sha256;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use crate::calibrated::EXPERIMENT;
use crate::page::REPORT;
use crate::{Request, picture, write_mark};

pub use text::{analysed_table, decisions, table};

/// SHA-256 of an experiment and of its recordings, by file.
pub fn input_hashes(experiment: &Experiment) -> BTreeMap<String, String> {
    let hash = |file: &Path, hash: String| (file.display().to_string(), hash);
    let own = hash(&experiment.path, sha256(experiment.text().as_bytes()));
    let read = |entry: &Entry| Some(hash(&entry.file, input::sha256(&entry.file).ok()?));
    experiment.recordings.iter().filter_map(read).chain([own]).collect()
}

/// Writes recordings, releases, decisions and, if it was requested, the analysis into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write(
    folder: &Folder,
    request: &Request,
    experiment: &Experiment,
    cleaned: &Cleaned,
    analysed: Option<&[Analysed]>,
) -> Result<(), StoreError> {
    let mut pictures = picture::recordings(cleaned);
    pictures.extend(analysed.map(picture::analysed).unwrap_or_default());
    let mut names = HashMap::new();
    for (k, recording) in cleaned.recordings.iter().enumerate() {
        let releases: Vec<_> = cleaned.releases.iter().filter(|release| release.recording == k).collect();
        let name = unique(&plain_name(&recording.name), &mut names);
        folder.write(&format!("{name}.svg"), pictures[k].svg().as_bytes())?;
        for release in releases {
            let text = csv(&release.release);
            folder.write(&format!("{name}-{}.csv", release.number), text.as_bytes())?;
        }
        for one in analysed.into_iter().flatten().filter(|one| one.of.recording == k) {
            if let Ok(measured) = &one.measured {
                let picture = picture::measured(&one.of.release.name, measured);
                folder.write(&format!("{name}-{}.svg", one.of.number), picture.svg.as_bytes())?;
            }
        }
    }
    let written = SystemTime::now();
    for picture in &pictures[cleaned.recordings.len()..] {
        folder.write(&picture.file(), picture.svg().as_bytes())?;
    }
    let html = page::page(request, experiment, cleaned, analysed, &pictures, written);
    folder.write(REPORT, html.as_bytes())?;
    folder.write(EXPERIMENT, request.resolved_scenario.as_bytes())?;
    let mut summary = json!({
        "experiment": experiment.path.display().to_string(),
        "recordings": cleaned.recordings.iter().map(|recording| json!({
            "name": recording.name,
            "samples": recording.recording.time.len(),
            "rate_hz": recording.recording.rate_hz,
            "origin_m": recording.frame.origin,
            "axes": recording.frame.axes,
            "base_moved_m": recording.base.as_ref().map(|base| base.moved),
            "base_turned_rad": recording.base.as_ref().map(|base| base.turned),
            "base_deviation_m": recording.base.as_ref().map(|base| base.deviation),
            "base_turn_deviation_rad": recording.base.as_ref().map(|base| base.turn_deviation),
        })).collect::<Vec<_>>(),
        "releases": cleaned.releases.iter().map(Row::of).collect::<Vec<_>>(),
        "out_of_plane": over_pressures(cleaned.used().map(|used| &used.release)),
        "decisions": cleaned.decisions,
        "efam": env!("CARGO_PKG_VERSION"),
    });
    if let Some(analysed) = analysed {
        summary["analysis"] = json!(analysed.iter().map(Analysed::said).collect::<Vec<_>>());
    }
    let kind = if analysed.is_some() { "analysis" } else { "check" };
    write_mark(folder, request, kind, written, summary)
}

/// A cleaned release, as it is written; SI.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Row<'a> {
    /// Its name: that of the recording, and its number in it.
    pub name: &'a str,
    /// Pressure above ambient.
    pub pressure_pa: Option<f64>,
    /// Mass at the tip.
    pub payload_kg: f64,
    /// When it is let go, on the recording's clock.
    pub instant_s: f64,
    /// Standard error of that.
    pub instant_error_s: f64,
    /// Angle of the straight rod while it is held, if it is given.
    pub angle_rad: Option<f64>,
    /// Whether it is held out.
    pub held_out: bool,
    /// Why it is not used, if it is not.
    pub dropped: Option<&'a str>,
    /// Whether it represents the releases of the same pressure and payload.
    pub representative: bool,
    /// Its numbers.
    pub statistics: &'a Statistics,
}

impl<'a> Row<'a> {
    /// What is written of a release.
    pub fn of(release: &'a CleanRelease) -> Self {
        Self {
            name: &release.release.name,
            pressure_pa: release.release.pressure,
            payload_kg: release.release.payload,
            instant_s: release.instant,
            instant_error_s: release.release.release_uncertainty,
            angle_rad: release.angle,
            held_out: release.release.held_out,
            dropped: release.dropped.as_deref(),
            representative: release.representative,
            statistics: &release.statistics,
        }
    }
}

/// Numbers read back to the same bits; an empty cell is a sample that was lost or masked.
fn csv(release: &Release) -> String {
    let mut text = String::from("t_s");
    for track in &release.tracks {
        let name = track.marker.replace([',', '"'], "_");
        let name = cell(&name);
        let _ = write!(text, ",{name}_x_m,{name}_z_m");
    }
    text.push('\n');
    for (i, time) in release.time.iter().enumerate() {
        let _ = write!(text, "{time:?}");
        for track in &release.tracks {
            match track.position[i] {
                Some([x, z]) => {
                    let _ = write!(text, ",{x:?},{z:?}");
                }
                None => text.push_str(",,"),
            }
        }
        text.push('\n');
    }
    text
}

/// A name for each of several recordings that have one; none ends as the number of a release does.
fn unique(name: &str, taken: &mut HashMap<String, usize>) -> String {
    let mut unique = name.to_owned();
    // Some file systems do not distinguish `Tip` from `tip`. The search goes on where it ended the last time.
    let mut number = taken.get(&name.to_lowercase()).map_or(1, |last| *last);
    while taken.contains_key(&unique.to_lowercase()) {
        number += 1;
        unique = format!("{name}_{number}");
    }
    taken.insert(name.to_lowercase(), number);
    taken.entry(unique.to_lowercase()).or_insert(1);
    unique
}
