//! Keys of a scenario, and their units for those who give numbers in SI.

use models::effects::Catalogue;

/// Keys and units of what a rod itself has.
pub const ROD: [(&str, &str); 6] = [
    ("length", "m"),
    ("mass", "kg"),
    ("bending_stiffness", "N m^2"),
    ("axial_stiffness", "N"),
    ("diameter", "m"),
    ("pressure", "Pa"),
];

/// Sections of a scenario.
pub const SCENARIO: [&str; 9] =
    ["name", "muscle", "rod", "release", "run", "integrator", "effects", "laws", "calibration"];
/// Sections of an experiment.
pub const EXPERIMENT: [&str; 9] =
    ["name", "muscle", "rod", "effects", "laws", "integrator", "recording", "calibrate", "diagnose"];

/// Keys of a muscle.
pub(crate) const OF_MUSCLE: [&str; 7] =
    ["name", "file", "text", "pressure", "stiffness", "extrapolation", "mass"];
/// Keys of a rod, beside [`ROD`].
pub(crate) const OF_ROD: [&str; 5] = ["nodes", "scheme", "root", "base_angle", "tip"];
/// Keys of a release.
pub(crate) const OF_RELEASE: [&str; 8] =
    ["angle", "angular_velocity", "from", "by", "posture", "nodes", "hold", "history"];
/// Keys of a run.
pub(crate) const OF_RUN: [&str; 3] = ["duration", "rate", "accuracy"];
/// Keys of an integrator.
pub(crate) const OF_INTEGRATOR: [&str; 4] = ["method", "tolerance", "most_steps", "fixed_step"];

/// Keys with a unit that no table of the model has.
const KEYS: [(&str, &str); 10] = [
    ("muscle.pressure", "Pa"),
    ("rod.base_angle", "rad"),
    ("rod.tip", "m"),
    ("release.angle", "rad"),
    ("release.angular_velocity", "rad/s"),
    ("release.hold.pressure", "Pa"),
    ("run.duration", "s"),
    ("run.rate", "Hz"),
    ("run.accuracy", "m"),
    ("integrator.fixed_step", "s"),
];

/// The same of a recording of an experiment.
const RECORDING: [(&str, &str); 14] = [
    ("pressure", "Pa"),
    ("payload", "kg"),
    ("payload.mass", "kg"),
    ("payload.center_of_mass", "m"),
    ("payload.offset", "m"),
    ("payload.rotary_inertia", "kg m^2"),
    ("rate", "Hz"),
    ("clamp", "m"),
    ("base_angle", "rad"),
    ("angle", "rad"),
    ("offset", "m"),
    ("instants", "s"),
    ("instant_error", "s"),
    ("mask", "s"),
];
/// Of one of its releases, and of what is left.
const RELEASE: [(&str, &str); 3] = [("release.angle", "rad"), ("release.instant", "s"), ("noise", "m")];

/// The SI unit of a key, such as `kg` of `effects.payload.mass`; none for a key that takes words, counts or bare numbers.
/// The catalogue has the laws as text, too, if there are any.
pub fn unit_of(path: &str, catalogue: &Catalogue) -> Option<&'static str> {
    if let Some((_, unit)) = KEYS.iter().find(|(key, _)| *key == path) {
        return Some(unit);
    }
    if let Some(own) = path.strip_prefix("recording") {
        // One of them, as recording[1].pressure, or any.
        let (_, own) = own.split_once('.')?;
        let own = own
            .split_once("].")
            .filter(|_| own.starts_with("release["))
            .map_or(own.to_owned(), |(_, key)| format!("release.{key}"));
        return RECORDING.iter().chain(&RELEASE).find(|(key, _)| *key == own).map(|(_, unit)| *unit);
    }
    let path = path.strip_prefix("release.hold.").unwrap_or(path);
    let unit = match path.strip_prefix("rod.") {
        Some(own) => ROD.iter().find(|(key, _)| *key == own)?.1,
        None => catalogue.parameter(path)?.unit,
    };
    (!unit.is_empty()).then_some(unit)
}

/// All keys of a scenario by their paths, each with its unit if it is a quantity.
pub fn keys() -> Vec<(String, Option<&'static str>)> {
    let sections: [(&str, &[&str]); 5] = [
        ("muscle", &OF_MUSCLE),
        ("rod", &OF_ROD),
        ("release", &OF_RELEASE),
        ("run", &OF_RUN),
        ("integrator", &OF_INTEGRATOR),
    ];
    let of_sections =
        sections.into_iter().flat_map(|(section, own)| own.iter().map(move |key| (section, *key)));
    let of_rods = ROD.iter().map(|(key, _)| ("rod", *key));
    let catalogue = Catalogue::default();
    let unit =
        |path: &str| catalogue.parameter(path).map(|own| own.unit).or_else(|| unit_of(path, &catalogue));
    let paths = of_sections.chain(of_rods).map(|(section, key)| format!("{section}.{key}"));
    paths.chain(catalogue.paths()).map(|path| (path.clone(), unit(&path))).collect()
}

/// The key that a path without its first tables means, such as `effects.payload.mass` of `payload.mass`; none if no
/// key or more than one ends so.
pub(crate) fn whole_key(path: &str) -> Option<String> {
    let (end, catalogue) = (format!(".{path}"), Catalogue::default());
    let keys = KEYS.iter().map(|(key, _)| (*key).to_owned());
    let of_rods = ROD.iter().map(|(key, _)| format!("rod.{key}"));
    let mut ending = keys.chain(of_rods).chain(catalogue.paths()).filter(|key| key.ends_with(&end));
    ending.next().filter(|_| ending.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_key_means_it_where_only_one_ends_so() {
        let meant = ["payload.mass", "mass", "duration", "pressure", "nothing"].map(whole_key);
        let due = [Some("effects.payload.mass"), None, Some("run.duration"), None, None];
        assert_eq!(meant.map(|key| key.unwrap_or_default()), due.map(|key| key.unwrap_or_default()));
    }

    #[test]
    fn keys_have_the_units_that_their_reader_asks_for() {
        let unit = |path| unit_of(path, &Catalogue::default());
        let units =
            ["effects.payload.mass", "release.hold.rod.length", "run.rate", "rod.nodes", "effects.no.mass"]
                .map(unit);
        assert_eq!(units, [Some("kg"), Some("m"), Some("Hz"), None, None]);
        let of_recordings = [
            "recording[2].pressure",
            "recording.payload.mass",
            "recording[1].release[1].angle",
            "recording.release.instant",
            "recording[1].keep",
            "recording",
        ]
        .map(unit);
        assert_eq!(of_recordings, [Some("Pa"), Some("kg"), Some("rad"), Some("s"), None, None]);
    }
}
