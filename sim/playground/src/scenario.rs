//! A setup as a scenario for `efam simulate`, which gives the same numbers.

use efam_core::models::effects::by_name;
use efam_core::models::error::ModelError;
use efam_core::models::quantity::Quantity;

use crate::error::PlaygroundError;
use crate::setup::{ROD, Setup};

/// Relative distance within which a pressure is a whole multiple of a thousandth of 1 psi: half a bit or so.
const SAME: f64 = 1e-14;

/// The text of a scenario. Numbers have all their digits: the program reads the very same.
pub fn toml(setup: &Setup) -> Result<String, PlaygroundError> {
    // It says what the setup lacks.
    setup.model()?;
    let mut lines = vec![
        "# Purpose: a release from the playground.".to_owned(),
        "# Expected: the swing that was seen there.".to_owned(),
    ];
    if let Some(muscle) = &setup.muscle {
        lines.extend(["[muscle]".to_owned(), format!("name = {muscle:?}")]);
        lines.extend([format!("pressure = \"{}\"", pressure(setup.pressure)), String::new()]);
    }
    lines.extend(["[rod]".to_owned(), format!("nodes = {}", setup.nodes)]);
    lines.push(line("base_angle", setup.base_angle, "rad"));
    lines.extend(rod(setup));
    lines.extend([String::new(), "[release]".to_owned(), line("angle", setup.release_angle(), "rad")]);
    lines.extend([String::new(), "[run]".to_owned()]);
    lines.extend([line("duration", setup.duration, "s"), line("rate", setup.rate, "Hz")]);
    lines.extend([String::new(), "[integrator]".to_owned(), line("tolerance", setup.tolerance, "")]);
    lines.extend(effects(setup)?);
    Ok(lines.join("\n") + "\n")
}

/// What of the rod the setup gives.
pub(crate) fn rod(setup: &Setup) -> Vec<String> {
    ROD.iter().filter_map(|(key, unit)| Some(line(key, *setup.rod.get(*key)?, unit))).collect()
}

/// A section for each effect.
pub(crate) fn effects(setup: &Setup) -> Result<Vec<String>, PlaygroundError> {
    let mut lines = Vec::new();
    for (name, values) in &setup.effects {
        let effect = by_name(name).ok_or_else(|| ModelError::UnknownEffect { name: name.clone() })?;
        lines.extend([String::new(), format!("[effects.{name}]")]);
        let given = effect.about().parameters.iter().filter_map(|p| Some((p, values.get(p.name)?)));
        lines.extend(given.map(|(p, value)| line(p.name, *value, p.unit)));
    }
    Ok(lines)
}

pub(crate) fn line(key: &str, value: f64, unit: &str) -> String {
    if unit.is_empty() { format!("{key} = {value:?}") } else { format!("{key} = \"{value:?} {unit}\"") }
}

/// In psi where it was meant so, as the paper's tables are.
pub(crate) fn pressure(pascal: f64) -> String {
    let psi = Quantity::parse("1 psi").map_or(f64::NAN, |psi| psi.si());
    let rounded = (1e3 * pascal / psi).round() / 1e3;
    if (rounded * psi - pascal).abs() <= SAME * pascal.abs() {
        return format!("{rounded} psi");
    }
    format!("{pascal:?} Pa")
}
