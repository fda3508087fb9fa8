//! An experiment: recordings, what was measured in each, and the releases that are cut out of them.
//!
//! ```toml
//! name = "beam"
//! [rod]                          # the model: [muscle] without its pressure, [rod], [effects.*] and
//! length = "100 mm"              # [integrator] as in a scenario; without them only what needs no
//! …                              # model is done
//!
//! [[recording]]
//! file = "15psi.csv"             # relative to this file
//! pressure = "15 psi"            # needed with a [muscle]
//!                                # or { file = "p.csv", column = "p", unit = "bar", delay = "0 s" }: over time
//! payload = "80 g"               # or { mass = "80 g", center_of_mass = "1 in", offset = …, rotary_inertia = … }
//! tip = ["Tip - 1", "Tip - 2"]   # one marker, or several whose centroid it is
//! body = [{ marker = "M3", at = "120 mm" }]   # from the clamp, or a share of the active length
//! base = ["Base - 1", "Base - 2", "Base - 3"] # or one rigid body
//! unit = "mm"                    # what the file's numbers are in, where it is silent or wrong
//! rate = "100 Hz"                # likewise
//! up = "+x"                      # against gravity, in the file's frame: an axis or [x, y, z]
//! along = "+z"                   # from the clamp along the rod, likewise
//! clamp = ["0 mm", "0 mm", "0 mm"]            # where the rod leaves the clamp, in the file's frame
//! base_angle = "25 deg"          # of the clamp above the level, where it is not rod.base_angle
//! angle = "0 deg"                # of the straight rod while it is held; then offset = "hold"
//! start = "held"                 # without an angle: bent by a hand at its end, as the markers show; or "straight";
//!                                # or "in motion": the recording begins in mid-swing
//! offset = "hold"                # of the tip marker from the rod's end, taken off: "hold", "none",
//!                                # or ["0 mm", "22 mm"], along and across the rod at the hold
//! instants = ["0.71 s"]          # of release, on the recording's clock, instead of those found
//! instant_error = "1 ms"         # their standard error, where half a sampling step is not it
//! keep = [1, 3]                  # releases that are used; or drop = [2]
//! held_out = true                # no part of any fit; or [3]
//! noise = "0.1 mm"               # of each coordinate, instead of what is found
//! spurious = "mask"              # or "keep"
//! mask = [["1.2 s", "1.3 s"]]    # on the recording's clock: not to be used
//! [[recording.release]]          # one of them otherwise
//! number = 2
//! angle = "10 deg"
//! instant = "25.31 s"
//!
//! [calibrate]                    # read by the calibration
//! ```

mod direction;
mod entry;
mod payload;
mod pressure;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use efam_recordings::{ReadOptions, Recording, read};
use models::effects::Catalogue;
use models::muscle::Known;

use crate::scenario::document::{Document, Keys};
use crate::scenario::plan::{self, Plan, Pressure};
use crate::scenario::start::From;
use crate::scenario::units::EXPERIMENT;
use crate::scenario::{Case, LAWS, ScenarioProblem, case, read_laws};

pub use crate::error::ExperimentError;
pub use direction::Direction;
pub use entry::{At, BodyMarker, Entry, HeldOut, Offset, Override, Start};
pub use payload::Payload;
pub use pressure::Pressures;

/// An experiment, read and checked; its recordings are not read yet.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Name: as given, or that of the file.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The recordings, in the order of the file.
    pub recordings: Vec<Entry>,
    document: Document,
    /// Its text, with laws from files of their own behind it.
    text: String,
    plan: Option<Plan>,
    /// Recordings that are in memory, by the end of the path that the experiment has for them.
    held: Vec<(PathBuf, Arc<Recording>)>,
}

/// Which of the pressures of a recording that changes; of another one they are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Under {
    /// Their mean over the recording.
    Mean,
    /// That at an instant of the recording's clock, s.
    At(f64),
    /// All from an instant on, s, as they change.
    Since(f64),
}

impl Experiment {
    /// Reads an experiment and sets `overrides` over it, each as `path=value`.
    /// # Errors
    /// [`ExperimentError::Document`], with file, line and column where there is one.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Experiment, ExperimentError> {
        Experiment::of(path, Document::load(path, overrides)?)
    }

    /// The same with the laws as text of other files.
    /// # Errors
    /// As [`Experiment::load`], for those files as well.
    pub fn load_with(
        path: &Path,
        overrides: &[String],
        laws: &[PathBuf],
    ) -> Result<Experiment, ExperimentError> {
        let mut document = Document::load(path, overrides)?;
        for file in laws {
            document.include(file, LAWS)?;
        }
        let mut experiment = Experiment::of(path, document)?;
        for definition in laws.iter().map(|file| read_laws(file)).collect::<Result<Vec<_>, _>>()?.concat() {
            experiment.text += "\n";
            experiment.text += &definition.text();
        }
        Ok(experiment)
    }

    /// The experiment that a text describes; files in it are relative to `path`.
    /// # Errors
    /// As [`Experiment::load`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Experiment, ExperimentError> {
        Experiment::of(path, Document::parse(path, text, overrides)?)
    }

    fn of(path: &Path, document: Document) -> Result<Experiment, ExperimentError> {
        let keys = document.keys();
        keys.only(&EXPERIMENT)?;
        let plan = Plan::of_experiment(&document)?;
        let tables = keys.tables("recording")?;
        if tables.is_empty() {
            let example = "[[recording]] with file = \"15psi.csv\" and tip = \"Tip\" under it";
            return Err(keys.missing("recording", example).into());
        }
        let recordings = tables
            .iter()
            .map(|table| Entry::read(&document, table, plan.as_ref()))
            .collect::<Result<Vec<_>, _>>()?;
        let name = plan::name(&document, path, "experiment")?;
        let text = document.text().to_owned();
        Ok(Experiment { name, path: path.to_owned(), recordings, document, text, plan, held: Vec::new() })
    }

    /// The same with recordings that are in memory: each replaces the files whose paths end with its own.
    pub fn holding(mut self, held: Vec<(PathBuf, Arc<Recording>)>) -> Experiment {
        self.held = held;
        self
    }

    /// The recordings that are in memory.
    pub fn held(&self) -> &[(PathBuf, Arc<Recording>)] {
        &self.held
    }

    /// The text of its file, with laws of other files, without what is set over it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The effects that its model may have.
    pub fn catalogue(&self) -> Catalogue {
        self.plan.as_ref().map(|plan| plan.catalogue.clone()).unwrap_or_default()
    }

    /// Whether it says what was recorded, so that a model can be compared with it.
    pub fn has_model(&self) -> bool {
        self.plan.is_some()
    }

    /// Angle of the clamp above the level, rad, where the model says that it is not level.
    pub(crate) fn base_angle(&self) -> Option<f64> {
        Some(self.plan.as_ref()?.base_angle).filter(|angle| *angle != 0.0)
    }

    /// The muscle of the model, if it is one.
    pub fn muscle(&self) -> Option<&models::muscle::Muscle> {
        self.plan.as_ref()?.muscle.as_ref().map(|muscle| &muscle.muscle)
    }

    /// The estimate of bending stiffness that the model starts from, if it is a muscle.
    pub fn stiffness(&self) -> Option<&str> {
        self.plan.as_ref()?.muscle.as_ref().map(|muscle| muscle.stiffness.as_str())
    }

    /// What a calibration says of the muscle's numbers.
    pub fn known(&self) -> Option<&Known> {
        self.plan.as_ref()?.known.as_ref()
    }

    /// The text of the muscle's file, wherever it comes from.
    pub fn muscle_text(&self) -> Option<&str> {
        self.plan.as_ref()?.muscle.as_ref().map(|muscle| muscle.text.as_str())
    }

    /// The model of a recording, counted from 0, with the recording's pressure, payload and `angle` (rad)
    /// at release, that of the clamp where it is not known; nothing without [`Self::has_model`].
    /// # Errors
    /// [`ExperimentError::Document`] for what the muscle or the model refuses.
    pub fn case(&self, recording: usize, angle: Option<f64>) -> Result<Option<Case>, ExperimentError> {
        self.case_at(recording, angle, None, Under::Mean)
    }

    /// The same with another number of nodes, under one of the pressures that the recording has over time.
    /// # Errors
    /// As [`Self::case`].
    pub fn case_at(
        &self,
        recording: usize,
        angle: Option<f64>,
        nodes: Option<usize>,
        under: Under,
    ) -> Result<Option<Case>, ExperimentError> {
        let Some(plan) = &self.plan else { return Ok(None) };
        let entry = &self.recordings[recording];
        let mut plan = plan.clone();
        plan.nodes = nodes.or(plan.nodes);
        plan.base_angle = entry.base_angle.unwrap_or(plan.base_angle);
        plan.angle = angle.or(entry.angle).unwrap_or(plan.base_angle);
        // A load that holds the rod would belong to the stiffness of the start, and not to the one that is found.
        if let From::HeldBy(_) = plan.from {
            plan.from = From::Straight;
        }
        let payload = entry.payload.effect();
        match plan.effects.iter_mut().find(|(name, _)| *name == payload.0) {
            Some(given) if entry.payload.is_given => *given = payload,
            Some(_) => {}
            None => plan.effects.push(payload),
        }
        let key = format!("{}.pressure", entry.key);
        let mut pressure = entry.pressure;
        match (under, &entry.pressures, &mut plan.muscle) {
            (Under::Since(instant), Some(all), Some(muscle)) => {
                muscle.pressure = Pressure::Schedule(all.since(instant));
            }
            (Under::At(instant), Some(all), _) => pressure = Some(all.at(instant)),
            _ => {}
        }
        let pressure = pressure.filter(|_| plan.muscle.is_some());
        let case = case::at_pressure(&self.document, &Arc::new(plan), entry.name.clone(), pressure, &key)?;
        Ok(Some(case))
    }

    /// A recording, counted from 0: from memory, or else from its file.
    /// # Errors
    /// [`ExperimentError::Recording`], [`ExperimentError::Document`] for a file that is not there.
    pub fn read(&self, recording: usize) -> Result<Recording, ExperimentError> {
        let entry = &self.recordings[recording];
        if let Some((_, held)) = self.held.iter().find(|(end, _)| entry.file.ends_with(end)) {
            let given = entry.unit.map(|_| "unit").or(entry.rate.map(|_| "rate"));
            let given = given.or(entry.columns.as_ref().map(|_| "columns"));
            return match given {
                None => Ok(Recording::clone(held)),
                Some(key) => {
                    let message = format!("{key} is of a file, and this recording is in memory: make it so");
                    Err(self.wrong(&format!("{}.{key}", entry.key), ScenarioProblem::Other { message }))
                }
            };
        }
        if let Err(error) = fs::metadata(&entry.file) {
            let file = entry.file.display().to_string();
            let problem = ScenarioProblem::Unreadable { file, reason: error.to_string() };
            return Err(self.document.error_of(&format!("{}.file", entry.key), problem).into());
        }
        let options = ReadOptions { unit: entry.unit, rate_hz: entry.rate, columns: entry.columns.clone() };
        Ok(read(&entry.file, &options)?)
    }

    /// A table of the file that others read, such as `calibrate`, with its places for messages.
    /// # Errors
    /// [`ExperimentError::Document`] if the key is there and no table.
    pub fn section(&self, key: &str) -> Result<Keys<'_>, ExperimentError> {
        Ok(self.document.keys().table(key)?)
    }

    /// The error that the value of a key, such as `recording[1].tip`, is wrong.
    pub(crate) fn wrong(&self, key: &str, problem: ScenarioProblem) -> ExperimentError {
        self.document.error_of(key, problem).into()
    }
}

#[cfg(test)]
mod tests;
