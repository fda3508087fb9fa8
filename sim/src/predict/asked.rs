//! What is asked: a rod, a pressure, a payload, an angle; and the scenario that says so.

use std::path::{Path, PathBuf};

use models::muscle::{BUILT_IN, Known};

use crate::experiment::{Experiment, ExperimentError};
use crate::scenario::{Case, ReleaseOptions, Scenario, ScenarioError};

/// The rod that is asked about, and all but its pressure and its payload's mass; SI.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// File that the scenario's text comes from, or would.
    path: PathBuf,
    text: String,
    /// The release, where the scenario says otherwise.
    pub release: ReleaseOptions,
    /// What is set over all that, each as `path=value`.
    pub set: Vec<String>,
}

impl Asked {
    /// About a muscle: the name of a built-in one, or a file.
    pub fn muscle(muscle: &str) -> Self {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let key = if BUILT_IN.iter().any(|(name, _)| *name == muscle) { "name" } else { "file" };
        let text = format!("[muscle]\n{key} = {}\n", quoted(muscle));
        Self { path: PathBuf::from("prediction.toml"), text, ..Self::default() }
    }

    /// About the rod of a scenario, whose text is given.
    pub fn scenario(path: &Path, text: String) -> Self {
        Self { path: path.to_owned(), text, ..Self::default() }
    }

    /// Whether its rod is a muscle, whose pressure may be another.
    pub fn has_muscle(&self) -> bool {
        self.text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("muscle"))
    }

    /// An experiment with this rod in place of its own, and what a calibration says of the rod's numbers. What the
    /// experiment says of a recording, such as its pressure and payload, stands.
    /// # Errors
    /// [`ExperimentError`] for what the experiment or the rod refuses.
    pub fn in_experiment(
        &self,
        experiment: &Experiment,
    ) -> Result<(Experiment, Option<Known>), ExperimentError> {
        // Both were read before, with messages at their places.
        let mut tables: toml::Table = experiment.text().parse().unwrap_or_default();
        let mut own: toml::Table = self.text.parse().unwrap_or_default();
        let mut known = match own.contains_key("calibration") {
            true => Scenario::parse(&self.path, &self.text, &self.set)?.known().cloned(),
            false => None,
        };
        if let Some(muscle) = own.get_mut("muscle").and_then(toml::Value::as_table_mut) {
            muscle.remove("pressure");
            if let Some(file) = muscle.get("file").and_then(toml::Value::as_str) {
                let file = self.path.parent().unwrap_or(Path::new("")).join(file);
                let file = std::path::absolute(&file).unwrap_or(file).to_string_lossy().into_owned();
                muscle.insert("file".to_owned(), file.into());
            }
        }
        let given = |key: &str| own.contains_key(key);
        // What the experiment says where a rod's own file says nothing; its calibrated numbers are in that file.
        let kept: Vec<&str> = ["rod", "effects"].into_iter().filter(|key| !given(key)).collect();
        for key in ["muscle", "rod", "effects", "integrator"] {
            let Some(mut value) = own.remove(key) else { continue };
            // The clamp is the experiment's.
            let angle = tables.get("rod").and_then(|rod| rod.get("base_angle")).cloned();
            if let (Some(rod), Some(angle), "rod") = (value.as_table_mut(), angle, key) {
                rod.insert("base_angle".to_owned(), angle);
            }
            tables.insert(key.to_owned(), value);
        }
        let parse =
            |tables: &toml::Table| Experiment::parse(&experiment.path, &tables.to_string(), &self.set);
        known = match known {
            Some(known) => Some(known),
            None => parse(&tables)?.known().cloned(),
        };
        for path in known.iter().flat_map(Known::paths) {
            if let Some((table, key)) = path.rsplit_once('.')
                && kept.contains(&table.split('.').next().unwrap_or(table))
            {
                let mut at = Some(&mut tables);
                for name in table.split('.') {
                    at = at.and_then(|at| at.get_mut(name)?.as_table_mut());
                }
                at.map(|at| at.remove(key));
            }
        }
        // Numbers that belong to a mesh are taken with it.
        if let Some(nodes) = known.as_ref().and_then(|known| known.nodes) {
            let rod = tables.entry("rod").or_insert_with(|| toml::Table::new().into());
            rod.as_table_mut().map(|rod| rod.insert("nodes".to_owned(), (nodes as i64).into()));
        }
        let with_rod = parse(&tables)?;
        Ok((with_rod, known))
    }

    /// The case at a pressure, Pa, and with a payload, kg, where they are not the scenario's own, and what a
    /// calibration says of its numbers.
    /// # Errors
    /// [`ScenarioError`] for what the scenario or the model refuses.
    pub fn case(
        &self,
        pressure: Option<f64>,
        payload: Option<f64>,
    ) -> Result<(Case, Option<Known>), ScenarioError> {
        let pressure = pressure.map(|pressure| format!("muscle.pressure=\"{pressure:?} Pa\""));
        let release = ReleaseOptions { payload: payload.or(self.release.payload), ..self.release.clone() };
        let mut set: Vec<String> = pressure.into_iter().chain(release.overrides()).collect();
        set.extend(self.set.iter().cloned());
        let mut scenario = Scenario::parse(&self.path, &self.text, &set)?;
        // Numbers that belong to a mesh are taken with it.
        if let Some(nodes) = scenario.known().and_then(|known| known.nodes) {
            set.insert(0, format!("rod.nodes={nodes}"));
            scenario = Scenario::parse(&self.path, &self.text, &set)?;
        }
        let mut cases = scenario.cases()?;
        let case = cases.swap_remove(0).begun();
        Ok((case, scenario.known().cloned()))
    }
}
