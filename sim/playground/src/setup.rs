//! What is let go, as data: the state that a page keeps, shares in a link and saves as a scenario.

use std::collections::BTreeMap;

use efam_core::initial::Initial;
use efam_core::models::effects::{CATALOGUE, Rod};
use efam_core::models::model::{Model, ModelSpec};
use efam_core::models::muscle::{AtPressure, Extrapolation, Muscle};
use efam_core::models::statics::{Hold, held};
use efam_core::run::{Run, uniform};
use serde::{Deserialize, Serialize};

use crate::error::PlaygroundError;

/// A rod, its effects and its release, SI.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Setup {
    /// A built-in muscle; none for a plain rod.
    pub muscle: Option<String>,
    /// Pressure above ambient, Pa.
    pub pressure: f64,
    /// What of the rod differs from the muscle, or all of a plain rod: by the keys of a scenario's `[rod]`.
    pub rod: BTreeMap<String, f64>,
    /// Number of nodes.
    pub nodes: usize,
    /// Error admitted in a step, see [`Run::tolerance`].
    pub tolerance: f64,
    /// Angle of the clamp above the horizontal, rad.
    pub base_angle: f64,
    /// Angle above the horizontal at which it is let go, rad; none for that of the clamp. At another angle a string
    /// holds the tip.
    pub angle: Option<f64>,
    /// Length of a run, s.
    pub duration: f64,
    /// Samples a second.
    pub rate: f64,
    /// Parameters by effect.
    pub effects: BTreeMap<String, BTreeMap<String, f64>>,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            muscle: None,
            pressure: 0.0,
            rod: BTreeMap::new(),
            nodes: 32,
            tolerance: TOLERANCE,
            base_angle: 0.0,
            angle: None,
            duration: 10.0,
            rate: 100.0,
            effects: BTreeMap::new(),
        }
    }
}

/// Finer than the program's: a browser's sines round otherwise in the last digit. That moves the ends of steps, and with
/// them the path within its tolerance: by up to 2e-7 m at 1e-7, and less than 1e-11 m at this.
const TOLERANCE: f64 = 1e-8;
/// The estimate of bending stiffness that the program takes of a table by default.
const STIFFNESS: &str = "pder_32";
/// Keys of a rod, in the order of [`Rod`]; pressure has a place of its own.
pub(crate) const ROD: [(&str, &str); 5] = [
    ("length", "m"),
    ("mass", "kg"),
    ("bending_stiffness", "N m^2"),
    ("axial_stiffness", "N"),
    ("diameter", "m"),
];
/// Angles that differ by less are one, rad, as in a scenario.
const KINK: f64 = 1e-9;
/// Longest run, s, and fastest sampling, Hz: what a page can show.
const MOST: [f64; 2] = [600.0, 10_000.0];

impl Setup {
    /// The muscle, if it is one.
    pub(crate) fn muscle(&self) -> Result<Option<Muscle>, PlaygroundError> {
        Ok(self.muscle.as_deref().map(Muscle::built_in).transpose()?)
    }

    /// Angle at which it is let go, rad.
    pub fn release_angle(&self) -> f64 {
        self.angle.unwrap_or(self.base_angle)
    }

    /// The model at the setup's pressure.
    pub fn model(&self) -> Result<Model, PlaygroundError> {
        self.check()?;
        let base = match self.muscle()? {
            Some(muscle) => of_muscle(&muscle, &at(&muscle, self.pressure)?),
            None => ModelSpec::of(self.plain()?),
        };
        let mut effects = base.effects.clone();
        for (name, values) in &self.effects {
            effects.push((name.clone(), values.iter().map(|(key, value)| (key.clone(), *value)).collect()));
        }
        let has = |name: &str| effects.iter().any(|(known, _)| known == name);
        if self.is_held() && !has("tip_load") {
            // The load that holds the rod, which is gone once it is let go.
            effects.push(("tip_load".to_owned(), Vec::new()));
        }
        // The order of parameters is that of the catalogue, as in the program: sums round alike.
        effects.sort_by_key(|(name, _)| CATALOGUE.iter().position(|effect| effect.about().name == name));
        let rod = self.overridden(base.rod);
        let (base_angle, release_angle) = (self.base_angle, self.release_angle());
        Ok(Model::new(&ModelSpec { nodes: self.nodes, rod, base_angle, release_angle, effects, ..base })?)
    }

    /// Where a model of this setup starts.
    pub fn initial(&self, model: &Model) -> Result<Initial, PlaygroundError> {
        if !self.is_held() {
            return Ok(Initial::Straight);
        }
        let (hold, own) = held(model, &Hold { direction: self.release_angle(), end_angle: None })?;
        Ok(Initial::Equilibrium { hold: Box::new(hold), own })
    }

    /// The run of a model of this setup.
    pub fn run(&self, model: &Model) -> Result<Run, PlaygroundError> {
        Ok(Run {
            initial: self.initial(model)?,
            samples: uniform(self.duration, self.rate),
            tolerance: self.tolerance,
            energy: true,
            ..Run::release(self.duration, self.rate)
        })
    }

    /// Whether a string holds the tip before the release: a straight rod would have a kink at its clamp, unless the
    /// clamp gives way.
    pub(crate) fn is_held(&self) -> bool {
        let is_clamped = !self.effects.contains_key("clamp_compliance");
        is_clamped && (self.release_angle() - self.base_angle).abs() > KINK
    }

    /// What a pressure makes of the parameters of a muscle's model, by their paths.
    pub(crate) fn at_pressure(
        &self,
        muscle: &Muscle,
        pressure: f64,
    ) -> Result<Vec<(String, f64)>, PlaygroundError> {
        let spec = of_muscle(muscle, &at(muscle, pressure)?);
        let rod = self.overridden(spec.rod);
        let mut values: Vec<_> = (ROD.iter().zip(parts(&rod)))
            .map(|((key, _), value)| (format!("rod.{key}"), value))
            .chain([("rod.pressure".to_owned(), pressure)])
            .collect();
        for (name, own) in spec.effects {
            let set = self.effects.get(&name);
            let left = own.into_iter().filter(|(key, _)| !set.is_some_and(|set| set.contains_key(key)));
            values.extend(left.map(|(key, value)| (format!("effects.{name}.{key}"), value)));
        }
        Ok(values)
    }

    fn plain(&self) -> Result<Rod<f64>, PlaygroundError> {
        let of = |key: &'static str| self.rod.get(key).copied().ok_or(PlaygroundError::Missing { key });
        let plain = Rod::plain(of("length")?, of("mass")?, of("bending_stiffness")?);
        Ok(Rod { pressure: self.pressure, ..plain })
    }

    fn overridden(&self, rod: Rod<f64>) -> Rod<f64> {
        let mut values = parts(&rod);
        for (value, (key, _)) in values.iter_mut().zip(ROD) {
            *value = self.rod.get(key).copied().unwrap_or(*value);
        }
        let [length, mass, bending_stiffness, axial_stiffness, diameter] = values;
        Rod { length, mass, bending_stiffness, axial_stiffness, diameter, pressure: rod.pressure }
    }

    fn check(&self) -> Result<(), PlaygroundError> {
        if let Some(key) = self.rod.keys().find(|key| ROD.iter().all(|(known, _)| known != key)) {
            let known: Vec<_> = ROD.iter().map(|(key, _)| *key).collect();
            return Err(PlaygroundError::UnknownKey { key: key.clone(), known: known.join(", ") });
        }
        let limited =
            [("run.duration", self.duration, 1e-3, MOST[0]), ("run.rate", self.rate, 1e-3, MOST[1])];
        for (name, value, low, high) in limited {
            if !(low..=high).contains(&value) {
                return Err(PlaygroundError::OutOfRange { name, value, low, high });
            }
        }
        Ok(())
    }
}

/// A muscle with the air in it, as a scenario makes it.
fn of_muscle(muscle: &Muscle, at: &AtPressure) -> ModelSpec {
    muscle.spec(at).with(&[("enclosed_air.inner_diameter", at.inner_diameter)])
}

fn at(muscle: &Muscle, pressure: f64) -> Result<AtPressure, PlaygroundError> {
    Ok(muscle.at(pressure, STIFFNESS, Extrapolation::Refused)?)
}

/// In the order of [`ROD`].
fn parts(rod: &Rod<f64>) -> [f64; 5] {
    [rod.length, rod.mass, rod.bending_stiffness, rod.axial_stiffness, rod.diameter]
}
