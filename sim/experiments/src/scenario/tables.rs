//! Tables that occur in several places of a scenario: those of a rod and of its effects, and files that keys name.

use efam_store::input;
use models::effects::{Catalogue, Parameter};

use super::document::{Document, Keys};
use super::error::{ScenarioError, ScenarioProblem};
use super::units::ROD;

/// An effect and the parameters that are given.
pub(crate) type EffectPlan = (&'static str, Vec<(&'static Parameter, f64)>);

/// Values of [`ROD`], SI.
pub(super) fn read_rod(rod: &Keys) -> Result<[Option<f64>; 6], ScenarioError> {
    let mut values = [None; 6];
    for (value, (key, unit)) in values.iter_mut().zip(ROD) {
        *value = rod.quantity(key, unit)?;
    }
    Ok(values)
}

/// Effects in the order of the catalogue, whatever that of the file.
pub(super) fn read_effects(keys: &Keys, catalogue: &Catalogue) -> Result<Vec<EffectPlan>, ScenarioError> {
    keys.only(&catalogue.iter().map(|effect| effect.about().name).collect::<Vec<_>>())?;
    let mut plans = Vec::new();
    for about in catalogue.iter().map(|effect| effect.about()).filter(|about| keys.has(about.name)) {
        let effect = keys.table(about.name)?;
        effect.only(&about.parameters.iter().map(|p| p.name).collect::<Vec<_>>())?;
        let mut values = Vec::new();
        for parameter in about.parameters {
            if let Some(value) = effect.quantity(parameter.name, parameter.unit)? {
                values.push((parameter, value));
            }
        }
        plans.push((about.name, values));
    }
    Ok(plans)
}

/// Name and text of a file that a key names.
pub(super) fn read_file(
    document: &Document,
    keys: &Keys,
    key: &str,
) -> Result<(String, String), ScenarioError> {
    let Some((name, place)) = keys.text(key)? else { return Ok(Default::default()) };
    match input::text(&document.file(place, name)) {
        Ok(text) => Ok((name.to_owned(), text)),
        Err(error) => {
            let problem = ScenarioProblem::Unreadable { file: name.to_owned(), reason: error.to_string() };
            Err(keys.wrong(key, problem))
        }
    }
}
