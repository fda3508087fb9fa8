//! What is asked: a rod, a pressure, a payload, an angle; and the scenario that says so.

use std::path::{Path, PathBuf};

use models::muscle::{BUILT_IN, Known};

use crate::scenario::{Case, Scenario, ScenarioError};

/// Of a blunt body. Source: Hoerner (1965), Fluid-Dynamic Drag, chapter 3: a cube, face on, 1.05.
const DRAG_COEFFICIENT: f64 = 1.05;

/// The rod that is asked about, and all but its pressure and its payload's mass; SI.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// File that the scenario's text comes from, or would.
    path: PathBuf,
    text: String,
    /// Centre of mass of the payload beyond the active length, m.
    pub payload_center: Option<f64>,
    /// Rotary inertia of the payload, kg m².
    pub payload_inertia: Option<f64>,
    /// Area that the payload turns to the air, m².
    pub frontal_area: Option<f64>,
    /// Angle above the horizontal from which it is let go, rad; where the scenario says otherwise.
    pub angle: Option<f64>,
    /// How long to simulate, s; where the scenario says otherwise.
    pub duration: Option<f64>,
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

    /// The case at a pressure, Pa, and with a payload, kg, where they are not the scenario's own, and what a
    /// calibration says of its numbers.
    /// # Errors
    /// [`ScenarioError`] for what the scenario or the model refuses.
    pub fn case(
        &self,
        pressure: Option<f64>,
        payload: Option<f64>,
    ) -> Result<(Case, Option<Known>), ScenarioError> {
        let mut set = Vec::new();
        let mut put = |path: &str, value: Option<f64>, unit: &str| {
            set.extend(value.map(|value| format!("{path}=\"{value:?} {unit}\"")));
        };
        put("muscle.pressure", pressure, "Pa");
        put("release.angle", self.angle, "rad");
        put("run.duration", self.duration, "s");
        put("effects.payload.mass", payload, "kg");
        put("effects.payload.center_of_mass", self.payload_center, "m");
        put("effects.payload.rotary_inertia", self.payload_inertia, "kg m^2");
        put("effects.tip_drag.drag_area", self.frontal_area.map(|area| DRAG_COEFFICIENT * area), "m^2");
        set.extend(self.set.iter().cloned());
        let mut scenario = Scenario::parse(&self.path, &self.text, &set)?;
        // Numbers that belong to a mesh are taken with it.
        if let Some(nodes) = scenario.known().and_then(|known| known.nodes) {
            set.insert(0, format!("rod.nodes={nodes}"));
            scenario = Scenario::parse(&self.path, &self.text, &set)?;
        }
        let mut cases = scenario.cases()?;
        let case = cases.swap_remove(0);
        Ok((case, scenario.known().cloned()))
    }
}
