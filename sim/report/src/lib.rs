//! What a run leaves on disk, for people and for programs.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   scenario.resolved.toml   what was run, with every default written out
//!   summary.json             what it comes to: rest, peaks, frequencies, damping, energy, effort
//!   trajectory.parquet       every sample (trajectory.csv on request)
//!   release.svg              the picture
//!   report.html              the page for people, with the pictures that lie in pictures/
//!   efam-files.json          which files efam wrote; see [`manifest`]
//! ```
//!
//! [`write()`] makes the folder: complete, or not at all. Many runs go into one by [`begin`] and
//! [`write_run`]. [`report`](report::report) says the same in a dozen lines.

pub mod aligned;
mod assumed;
pub mod beside_the_paper;
pub mod calibrated;
pub mod checked;
pub mod compared;
pub mod diagnosed;
pub mod experiment;
pub mod export;
pub mod figures;
pub mod grid;
pub mod interval;
pub mod linear;
pub mod page;
pub mod paper;
pub mod picture;
pub mod predicted;
pub mod quantities;
pub mod report;
pub mod reread;
pub mod simulated;
pub mod swept;
pub mod told;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::SystemTime;

use efam_core::accuracy::Errors;
use efam_core::forward::{Cancel, Run};
use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::summary::Summary;
use efam_experiments::table::Table;
use efam_store::folder::{self, open};
use efam_store::manifest;
use efam_store::names::plain_name;
use efam_store::{Folder, MARK, StoreError};
use models::model::Model;
use serde_json::{Value, json};

use told::{Told, told};

/// File names of a run folder.
pub const SCENARIO: &str = "scenario.resolved.toml";
/// The trajectory.
pub const PARQUET: &str = "trajectory.parquet";
/// The trajectory, if requested.
pub const CSV: &str = "trajectory.csv";
/// The picture.
pub const PICTURE: &str = "release.svg";

/// What is to be written beside the trajectory.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Name of the run; becomes part of the folder's, without what leads elsewhere.
    pub name: String,
    /// The folder, or else a new one under `outputs/`.
    pub out: Option<PathBuf>,
    /// Whether `out` may replace a run that is there.
    pub overwrite: bool,
    /// Whether to write the trajectory as CSV too.
    pub csv: bool,
    /// The scenario with every default written out.
    pub resolved_scenario: String,
    /// Further files, by name, such as the muscle's.
    pub extra_files: Vec<(String, Vec<u8>)>,
    /// What the user should know before trusting the run.
    pub warnings: Vec<String>,
    /// SHA-256 of what was read, hexadecimal, by name; that of the resolved scenario is added.
    pub input_hashes: BTreeMap<String, String>,
    /// The command.
    pub argv: Vec<String>,
    /// Wall-clock time of the simulation, s.
    pub wall_time_s: f64,
    /// How wrong it may be, if that was estimated.
    pub errors: Option<Errors>,
    /// Leaves out pictures and pages once it is requested. Numbers and tables are written.
    pub cancel: Cancel,
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The run folder.
    pub folder: PathBuf,
    /// The content of its `summary.json`.
    pub summary: Summary,
}

/// Writes the folder of a run, also of one that was cut short or failed.
/// # Errors
/// [`StoreError`]; nothing half-written stays.
pub fn write(
    request: &Request,
    model: &Model,
    run: &Run,
    trajectory: &Trajectory,
) -> Result<Written, StoreError> {
    let folder = begin(request)?;
    let summary = write_run(&folder, None, request, model, run, trajectory)?;
    Ok(Written { folder: folder.finish()?, summary })
}

/// Opens the folder of a request, to be finished after its runs: before a long simulation, so that
/// obstacles are reported first, and recordings find their place; or for many runs.
/// # Errors
/// [`StoreError`].
pub fn begin(request: &Request) -> Result<Folder, StoreError> {
    open(request.out.as_deref(), request.overwrite, &request.name, &request.resolved_scenario)
}

/// Writes the mark of a folder: by which command it was made, from what, with `own` beside that.
fn write_mark(
    folder: &Folder,
    request: &Request,
    kind: &str,
    written: SystemTime,
    own: Value,
) -> Result<(), StoreError> {
    folder.write(MARK, mark(request, kind, written, own).as_bytes())
}

/// The mark of a folder.
fn mark(request: &Request, kind: &str, written: SystemTime, own: Value) -> String {
    let mut mark = json!({
        "kind": kind,
        "name": request.name,
        "warnings": request.warnings,
        "inputs_sha256": request.input_hashes,
        "argv": request.argv,
        "wall_time_s": request.wall_time_s,
        "written_utc": folder::utc(written),
    });
    if let (Value::Object(mark), Value::Object(own)) = (&mut mark, own) {
        mark.extend(own);
    }
    format!("{mark:#}\n")
}

/// Marks the folder of a run of which only a recording for the viewer is kept.
/// # Errors
/// [`StoreError::Write`].
pub fn write_watched(folder: &Folder, request: &Request, status: &Status) -> Result<(), StoreError> {
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "watched", SystemTime::now(), json!({ "status": status }))
}

/// Writes the files of a run into an open folder, or into a folder `within` it: one of many runs. The
/// folder of many has a [`MARK`] of its own to be written, by which it can be replaced.
/// # Errors
/// [`StoreError::FileName`], [`StoreError::Write`].
pub fn write_run(
    folder: &Folder,
    within: Option<&str>,
    request: &Request,
    model: &Model,
    run: &Run,
    trajectory: &Trajectory,
) -> Result<Summary, StoreError> {
    let within = within.map_or(String::new(), |name| plain_name(name) + "/");
    let place = |file: &str| format!("{within}{file}");
    for (name, bytes) in &request.extra_files {
        let is_ours = [SCENARIO, PARQUET, CSV, PICTURE, MARK, page::REPORT, manifest::MANIFEST]
            .contains(&name.as_str());
        if is_ours || plain_name(name) != *name {
            return Err(StoreError::FileName { name: name.clone() });
        }
        folder.write(&place(name), bytes)?;
    }

    let told = told(request, model, run, trajectory);
    let Told { summary, .. } = &told;

    folder.write(&place(SCENARIO), request.resolved_scenario.as_bytes())?;
    let table = Table::new(model, trajectory, run.energy);
    let about = [
        ("run", request.name.clone()),
        ("status", status_word(&trajectory.status).to_owned()),
        ("scenario_sha256", summary.inputs_sha256[SCENARIO].clone()),
        ("efam", summary.versions.efam.clone()),
    ];
    folder.write_with(&place(PARQUET), |file| table.write_parquet(file, &about))?;
    if request.csv {
        folder.write_with(&place(CSV), |file| table.write_csv(file))?;
    }
    let json = serde_json::to_string_pretty(summary).expect("a summary has nothing that JSON has not");
    folder.write(&place(MARK), json.as_bytes())?;
    let is_wanted = || !request.cancel.is_requested();
    if !is_wanted() {
        return Ok(told.summary);
    }
    let shown = told.shown(model, run, trajectory);
    folder.write(&place(PICTURE), picture::release(&shown).svg.as_bytes())?;
    // Many runs have one page, which is that of the folder.
    if within.is_empty() && is_wanted() {
        let pictures = picture::released(&shown);
        for picture in &pictures {
            folder.write(&picture.file(), picture.svg().as_bytes())?;
        }
        let html =
            simulated::page(request, summary, &pictures, picture::in_motion(&shown), SystemTime::now());
        folder.write(page::REPORT, html.as_bytes())?;
    }
    Ok(told.summary)
}

fn status_word(status: &Status) -> &'static str {
    match status {
        Status::Complete => "complete",
        Status::CutShort { .. } => "cut_short",
        Status::Failed { .. } => "failed",
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use efam_core::example::{muscle_at_15_psi, released};

    use super::*;

    #[test]
    fn a_run_folder_has_all_its_files_and_they_agree() {
        let model = muscle_at_15_psi();
        let (run, trajectory) = released(&model, 20.0);
        let out = std::env::temp_dir().join(format!("efam-results-{}", std::process::id()));
        let _ = fs::remove_dir_all(&out);
        let request = Request {
            name: "15 psi release".to_owned(),
            out: Some(out.clone()),
            csv: true,
            resolved_scenario: "abc".to_owned(),
            extra_files: vec![("muscle.toml".to_owned(), b"name = \"m\"".to_vec())],
            wall_time_s: 0.1,
            ..Request::default()
        };
        let written = write(&request, &model, &run, &trajectory).unwrap();
        assert_eq!(written.folder.file_name(), out.file_name());
        let mut files: Vec<_> = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(
            files,
            [
                manifest::MANIFEST,
                "muscle.toml",
                picture::PICTURES,
                PICTURE,
                page::REPORT,
                SCENARIO,
                MARK,
                CSV,
                PARQUET
            ]
        );
        let json: serde_json::Value = serde_json::from_slice(&fs::read(out.join(MARK)).unwrap()).unwrap();
        assert_eq!(json["real_time_factor"], 20.0 / 0.1);
        // FIPS 180-2, appendix B.1.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(json["inputs_sha256"][SCENARIO], abc);
        assert!(matches!(write(&request, &model, &run, &trajectory), Err(StoreError::Exists { .. })));
        for name in ["summary.json", "../muscle.toml", ""] {
            let extra_files = vec![(name.to_owned(), Vec::new())];
            let bad = Request { extra_files, overwrite: true, ..request.clone() };
            let error = write(&bad, &model, &run, &trajectory).unwrap_err();
            assert!(matches!(error, StoreError::FileName { .. }), "{error}");
        }
        assert!(out.join(PARQUET).is_file(), "a failed replacement keeps the old run");
        fs::remove_dir_all(&out).unwrap();
    }

    #[test]
    fn many_runs_share_a_folder_that_can_be_replaced_as_one() {
        let model = muscle_at_15_psi();
        let (run, trajectory) = released(&model, 0.1);
        let out = std::env::temp_dir().join(format!("efam-results-many-{}", std::process::id()));
        let _ = fs::remove_dir_all(&out);
        let request = Request { out: Some(out.clone()), overwrite: true, ..Request::default() };
        for names in [["5 psi", "10 psi"], ["5 psi", "../15 psi"]] {
            let folder = begin(&request).unwrap();
            for name in names {
                write_run(&folder, Some(name), &request, &model, &run, &trajectory).unwrap();
            }
            folder.write(MARK, b"[]").unwrap();
            folder.finish().unwrap();
        }
        assert!(out.join("5-psi").join(PARQUET).is_file() && out.join("15-psi").join(MARK).is_file());
        assert!(!out.join("10-psi").exists());
        fs::remove_dir_all(&out).unwrap();
    }

    #[test]
    fn a_run_that_failed_at_once_still_leaves_a_folder() {
        let model = muscle_at_15_psi();
        let (run, _) = released(&model, 0.0);
        let out = std::env::temp_dir().join(format!("efam-results-failed-{}", std::process::id()));
        let _ = fs::remove_dir_all(&out);
        let status = Status::Failed { time: 0.0, reason: "it broke".to_owned() };
        let mut nothing = Trajectory::default();
        nothing.status = status;
        let request = Request { name: "broken".to_owned(), out: Some(out.clone()), ..Request::default() };
        let written = write(&request, &model, &run, &nothing).unwrap();
        assert!(report::report(&written.summary).contains("broken, failed at 0.0000 s: it broke"));
        assert!(fs::read_to_string(out.join(PICTURE)).unwrap().contains("</svg>"));
        fs::remove_dir_all(&out).unwrap();
    }
}
