//! Units of the keys of a scenario, for those who give numbers in SI.

use models::effects::by_name;

use super::plan::ROD;

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

/// The SI unit of a key, such as `kg` of `effects.payload.mass`; none for a key that takes words, counts or bare numbers.
pub fn unit_of(path: &str) -> Option<&'static str> {
    if let Some((_, unit)) = KEYS.iter().find(|(key, _)| *key == path) {
        return Some(unit);
    }
    let path = path.strip_prefix("release.hold.").unwrap_or(path);
    let unit = match path.strip_prefix("rod.") {
        Some(own) => ROD.iter().find(|(key, _)| *key == own)?.1,
        None => {
            let (effect, parameter) = path.strip_prefix("effects.")?.split_once('.')?;
            by_name(effect)?.about().parameters.iter().find(|own| own.name == parameter)?.unit
        }
    };
    (!unit.is_empty()).then_some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_units_that_their_reader_asks_for() {
        let units =
            ["effects.payload.mass", "release.hold.rod.length", "run.rate", "rod.nodes", "effects.no.mass"]
                .map(unit_of);
        assert_eq!(units, [Some("kg"), Some("m"), Some("Hz"), None, None]);
    }
}
