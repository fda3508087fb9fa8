//! Keys of a scenario that a sweep may vary, and what their values are.

use std::path::Path;

use efam_experiments::scenario::units::ROD;
use efam_experiments::scenario::{ScenarioError, effects_of};
use models::effects::Catalogue;

/// What the values of a key are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// Quantities in this SI unit, empty if dimensionless.
    Quantity(&'static str),
    /// Whole numbers.
    Count,
    /// Words.
    Word,
}

/// Keys beside those of a rod and of effects.
const OTHERS: [(&str, ValueKind); 20] = [
    ("muscle.name", ValueKind::Word),
    ("muscle.pressure", ValueKind::Quantity("Pa")),
    ("muscle.stiffness", ValueKind::Word),
    ("muscle.mass", ValueKind::Word),
    ("rod.nodes", ValueKind::Count),
    ("rod.scheme", ValueKind::Word),
    ("rod.base_angle", ValueKind::Quantity("rad")),
    ("rod.tip", ValueKind::Quantity("m")),
    ("release.from", ValueKind::Word),
    ("release.angle", ValueKind::Quantity("rad")),
    ("release.angular_velocity", ValueKind::Quantity("rad/s")),
    ("release.hold.pressure", ValueKind::Quantity("Pa")),
    ("release.history.hung", ValueKind::Quantity("s")),
    ("release.history.raised", ValueKind::Quantity("s")),
    ("release.history.held", ValueKind::Quantity("s")),
    ("run.duration", ValueKind::Quantity("s")),
    ("run.rate", ValueKind::Quantity("Hz")),
    ("integrator.method", ValueKind::Word),
    ("integrator.tolerance", ValueKind::Quantity("")),
    ("integrator.fixed_step", ValueKind::Quantity("s")),
];

/// Before a key of the rod or of an effect: what it has while it is held.
const HOLD: &str = "release.hold.";

/// Keys that may vary: those of every scenario, and parameters of the laws as text of one.
#[derive(Clone, Debug, Default)]
pub struct Varying(Catalogue);

impl Varying {
    /// Those of a scenario.
    /// # Errors
    /// [`ScenarioError`] for a text that is none, or a law that cannot be.
    pub fn of(scenario: &Path, text: &str) -> Result<Varying, ScenarioError> {
        effects_of(scenario, text, &[]).map(Varying)
    }

    /// Those of a scenario, which is read only where one of these keys is not of every scenario.
    /// # Errors
    /// As [`Varying::of`].
    pub fn with(scenario: &Path, text: &str, keys: &[String]) -> Result<Varying, ScenarioError> {
        let usual = Varying::default();
        if keys.iter().all(|key| usual.kind(key).is_some()) { Ok(usual) } else { Varying::of(scenario, text) }
    }

    /// What the values of a key are; none of one that does not vary.
    pub fn kind(&self, path: &str) -> Option<ValueKind> {
        if let Some((_, kind)) = OTHERS.iter().find(|(key, _)| *key == path) {
            return Some(*kind);
        }
        let path = path.strip_prefix(HOLD).unwrap_or(path);
        let of_rod = |own: &str| ROD.iter().find(|(key, _)| *key == own).map(|(_, unit)| *unit);
        let unit = match path.strip_prefix("rod.") {
            Some(own) => of_rod(own),
            None => self.0.parameter(path).map(|own| own.unit),
        };
        unit.map(ValueKind::Quantity)
    }

    /// Every key that may vary.
    pub fn all(&self) -> impl Iterator<Item = String> {
        let others = OTHERS.iter().map(|(key, _)| (*key).to_owned());
        let of_rod = || ROD.iter().map(|(key, _)| format!("rod.{key}")).chain(self.0.paths());
        let held = of_rod().map(|key| format!("{HOLD}{key}"));
        others.chain(of_rod()).chain(held)
    }
}

/// A key as the name of a column, with its unit: `muscle.pressure` in Pa is `muscle_pressure_pa`.
pub fn column(path: &str, unit: &str) -> String {
    let text = if unit.is_empty() { path.to_owned() } else { format!("{path} {unit}") };
    let text = text.replace('^', "").to_lowercase();
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn keys_have_kinds_and_columns_of_their_own() {
        let keys = Varying::default();
        assert_eq!(keys.kind("effects.payload.mass"), Some(ValueKind::Quantity("kg")));
        assert_eq!(keys.kind("release.hold.rod.bending_stiffness"), Some(ValueKind::Quantity("N m^2")));
        assert_eq!((keys.kind("rod.nodes"), keys.kind("muscle.file")), (Some(ValueKind::Count), None));
        let others =
            ["release.hold.run.rate", "release.hold.rod.nodes", "effects.no.mass", "effects.payload"];
        assert_eq!(others.map(|key| keys.kind(key)), [None; 4]);
        assert_eq!(column("rod.bending_stiffness", "N m^2"), "rod_bending_stiffness_n_m2");
        assert_eq!(column("effects.rayleigh_mass.alpha", "1/s"), "effects_rayleigh_mass_alpha_1_s");
        let unit = |key: &str| match keys.kind(key) {
            Some(ValueKind::Quantity(unit)) => unit,
            kind => kind.map(|_| "").expect("it varies"),
        };
        let names: Vec<String> = keys.all().map(|key| column(&key, unit(&key))).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "no two have one column");
    }

    #[test]
    fn a_law_as_text_has_keys_with_its_units() {
        let law = "[laws.my_drag]\nplace = \"flow\"\nforce = \"-c * v_n * abs(v_n) * diameter\"\n\
            parameters.c = { unit = \"kg/m^3\", default = 0.6, range = [0, 10] }\n";
        let keys = Varying::of(Path::new("s.toml"), law).unwrap();
        let path = "effects.my_drag.c";
        assert_eq!(keys.kind(path), Some(ValueKind::Quantity("kg/m^3")));
        assert_eq!(keys.kind("release.hold.effects.my_drag.c"), Some(ValueKind::Quantity("kg/m^3")));
        assert!(keys.all().any(|key| key == path));
        assert_eq!(Varying::default().kind(path), None);
    }
}
