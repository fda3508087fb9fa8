//! Keys of a scenario that a sweep may vary, and what their values are.

use efam_experiments::scenario::plan::ROD;
use models::effects::CATALOGUE;

/// What the values of a key are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Quantities in this SI unit, empty if dimensionless.
    Quantity(&'static str),
    /// Whole numbers.
    Count,
    /// Words.
    Word,
}

/// Keys beside those of a rod and of effects.
const OTHERS: [(&str, Kind); 20] = [
    ("muscle.name", Kind::Word),
    ("muscle.pressure", Kind::Quantity("Pa")),
    ("muscle.stiffness", Kind::Word),
    ("muscle.mass", Kind::Word),
    ("rod.nodes", Kind::Count),
    ("rod.scheme", Kind::Word),
    ("rod.base_angle", Kind::Quantity("rad")),
    ("rod.tip", Kind::Quantity("m")),
    ("release.from", Kind::Word),
    ("release.angle", Kind::Quantity("rad")),
    ("release.angular_velocity", Kind::Quantity("rad/s")),
    ("release.hold.pressure", Kind::Quantity("Pa")),
    ("release.history.hung", Kind::Quantity("s")),
    ("release.history.raised", Kind::Quantity("s")),
    ("release.history.held", Kind::Quantity("s")),
    ("run.duration", Kind::Quantity("s")),
    ("run.rate", Kind::Quantity("Hz")),
    ("integrator.method", Kind::Word),
    ("integrator.tolerance", Kind::Quantity("")),
    ("integrator.fixed_step", Kind::Quantity("s")),
];

/// What the values of a key are; none of one that does not vary.
pub fn kind(path: &str) -> Option<Kind> {
    all().find(|(key, _)| key == path).map(|(_, kind)| kind)
}

/// Every key that may vary.
pub fn all() -> impl Iterator<Item = (String, Kind)> {
    let others = OTHERS.iter().map(|(key, kind)| ((*key).to_owned(), *kind));
    others.chain(["", "release.hold."].into_iter().flat_map(of_the_rod))
}

/// Keys of a rod and of effects, those of a hold behind its prefix.
fn of_the_rod(prefix: &'static str) -> impl Iterator<Item = (String, Kind)> {
    let rod = ROD.iter().map(move |(key, unit)| (format!("{prefix}rod.{key}"), Kind::Quantity(unit)));
    let effects = CATALOGUE.iter().map(|effect| effect.about()).flat_map(move |about| {
        let key = move |name: &str| format!("{prefix}effects.{}.{name}", about.name);
        about.parameters.iter().map(move |own| (key(own.name), Kind::Quantity(own.unit)))
    });
    rod.chain(effects)
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
        assert_eq!(kind("effects.payload.mass"), Some(Kind::Quantity("kg")));
        assert_eq!(kind("release.hold.rod.bending_stiffness"), Some(Kind::Quantity("N m^2")));
        assert_eq!((kind("rod.nodes"), kind("muscle.file")), (Some(Kind::Count), None));
        assert_eq!(column("rod.bending_stiffness", "N m^2"), "rod_bending_stiffness_n_m2");
        assert_eq!(column("effects.rayleigh_mass.alpha", "1/s"), "effects_rayleigh_mass_alpha_1_s");
        let unit = |kind| if let Kind::Quantity(unit) = kind { unit } else { "" };
        let names: Vec<String> = all().map(|(key, kind)| column(&key, unit(kind))).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "no two have one column");
    }
}
