//! A request: a rod, a pressure, a payload, an angle; and the scenario that says so.

use std::path::{Path, PathBuf};

use efam_experiments::experiment::{Experiment, ExperimentError};
use efam_experiments::scenario::{Case, ReleaseOptions, Scenario, ScenarioError};
use models::muscle::{BUILT_IN, Known};
use toml::{Table, Value};

/// The requested rod, and all but its pressure and its payload's mass; SI.
#[derive(Clone, Debug, Default)]
pub struct CaseRequest {
    /// File that the scenario's text comes from, or would.
    path: PathBuf,
    text: String,
    /// The release, where the scenario says otherwise.
    pub release: ReleaseOptions,
    /// What is set over all that, each as `path=value`.
    pub set: Vec<String>,
}

impl CaseRequest {
    /// About a muscle: the name of a built-in one, or a file.
    pub fn muscle(muscle: &str) -> Self {
        let quoted = |text: &str| Value::from(text).to_string();
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
        self.text.parse::<Table>().is_ok_and(|table| table.contains_key("muscle"))
    }

    /// An experiment with this rod in place of its own, what a calibration says of the rod's numbers, and warnings of effects in
    /// the experiment that this rod lacks. The experiment's statements of a recording, such as its pressure and
    /// payload, remain, and so does its clamp.
    /// # Errors
    /// [`ExperimentError`] for what the experiment or the rod refuses.
    pub fn in_experiment(
        &self,
        experiment: &Experiment,
    ) -> Result<(Experiment, Option<Known>, Vec<String>), ExperimentError> {
        // Both were read before, with messages at their places.
        let mut tables: Table = experiment.text().parse().unwrap_or_default();
        let mut own: Table = self.text.parse().unwrap_or_default();
        let own_known = if own.contains_key("calibration") {
            Scenario::parse(&self.path, &self.text, &[])?.known().cloned()
        } else {
            None
        };
        if let Some(muscle) = own.get_mut("muscle").and_then(Value::as_table_mut) {
            muscle.remove("pressure");
            if let Some(file) = muscle.get("file").and_then(Value::as_str) {
                let file = self.path.parent().unwrap_or(Path::new("")).join(file);
                let file = std::path::absolute(&file).unwrap_or(file).to_string_lossy().into_owned();
                muscle.insert("file".to_owned(), file.into());
            }
        }
        let lacks = |name: &&String| own.contains_key("effects") && effects(&own).all(|known| known != *name);
        let warning = |name: &String| {
            format!(
                "{}: [effects.{name}] is not in {} and is left out of these predictions; state a weight as payload in [[recording]], and other effects in the experiment of the calibration",
                experiment.path.display(),
                self.path.display()
            )
        };
        let left_out: Vec<String> = effects(&tables).filter(lacks).map(warning).collect();
        let clamp = tables.get("rod").and_then(|rod| rod.get("base_angle")).cloned();
        let kept: Vec<&str> = ["rod", "effects"].into_iter().filter(|key| !own.contains_key(*key)).collect();
        let replaced = ["muscle", "rod", "effects", "laws", "integrator"].map(|key| own.remove_entry(key));
        tables.extend(replaced.into_iter().flatten());
        if let (Some(rod), Some(clamp)) = (tables.get_mut("rod").and_then(Value::as_table_mut), clamp) {
            rod.insert("base_angle".to_owned(), clamp);
        }
        let mut set = self.set.clone();
        let parse =
            |tables: &Table, set: &[String]| Experiment::parse(&experiment.path, &tables.to_string(), set);
        let held = experiment.held().to_vec();
        let known = match own_known {
            None => parse(&tables, &set)?.known().cloned(),
            known => known,
        };
        // Where a calibration knows a number, the experiment has only the start of a search for it.
        let paths = known.iter().flat_map(Known::paths);
        for path in paths.filter(|path| kept.iter().any(|key| path.starts_with(&format!("{key}.")))) {
            remove(&mut tables, path);
        }
        // Numbers that belong to a mesh are taken with it.
        if let Some(nodes) = known.as_ref().and_then(|known| known.nodes) {
            set.insert(0, format!("rod.nodes={nodes}"));
        }
        Ok((parse(&tables, &set)?.holding(held), known, left_out))
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
        let scenario = Scenario::parse(&self.path, &self.text, &set)?;
        let mut cases = scenario.cases()?;
        let case = cases.swap_remove(0).begun();
        Ok((case, scenario.known().cloned()))
    }
}

/// The names of the effects in a file.
fn effects(tables: &Table) -> impl Iterator<Item = &String> {
    tables.get("effects").and_then(Value::as_table).into_iter().flat_map(Table::keys)
}

/// Takes the key at a path such as `effects.rayleigh_mass.alpha` out of its table.
fn remove(tables: &mut Table, path: &str) {
    match path.split_once('.') {
        None => drop(tables.remove(path)),
        Some((table, below)) => {
            if let Some(table) = tables.get_mut(table).and_then(Value::as_table_mut) {
                remove(table, below);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A weight that an experiment has as an effect, and the calibrated rod has not.
    #[test]
    fn effects_that_the_rod_lacks_are_named() {
        const ROD: &str = "[rod]\nlength = \"0.3 m\"\nmass = \"96 g\"\nbending_stiffness = \"0.1 N m^2\"\n";
        let rod = format!("{ROD}[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n");
        let request = CaseRequest::scenario(Path::new("rod.toml"), rod);
        let left_out = |effect: &str| {
            let text =
                format!("{ROD}[effects.{effect}]\n[[recording]]\nfile = \"loaded.csv\"\ntip = \"Tip\"\n");
            let experiment = Experiment::parse(Path::new("loaded.toml"), &text, &[]).expect("an experiment");
            request.in_experiment(&experiment).expect("it is one with this rod").2
        };
        let [warning] = &left_out("tip_mass")[..] else { panic!("one effect is absent") };
        assert!(warning.starts_with("loaded.toml: [effects.tip_mass] is not in rod.toml"), "{warning}");
        assert_eq!(left_out("rayleigh_mass"), Vec::<String>::new());
    }
}
