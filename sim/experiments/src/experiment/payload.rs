//! What hung on the tip of a recorded rod.

use models::effects::{Parameter, by_name};

use crate::scenario::ScenarioError;
use crate::scenario::document::Keys;
use crate::scenario::tables::EffectPlan;

/// A body at the tip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Payload {
    /// Mass, kg.
    pub mass: f64,
    /// From the end of the active length to its centre of mass, m.
    pub center_of_mass: f64,
    /// Its centre of mass beside the axis of the end fitting, m, positive to the left looking outwards.
    pub offset: f64,
    /// About its centre of mass, kg m².
    pub rotary_inertia: f64,
    /// Whether the recording says anything of it.
    pub is_given: bool,
}

impl Payload {
    /// As the effect of the model.
    pub(super) fn effect(&self) -> EffectPlan {
        let values = [
            ("mass", self.mass),
            ("center_of_mass", self.center_of_mass),
            ("offset", self.offset),
            ("rotary_inertia", self.rotary_inertia),
        ];
        let parameters: &'static [Parameter] =
            by_name("payload").map_or(&[], |effect| effect.about().parameters);
        let found = |(name, value)| Some((parameters.iter().find(|p| p.name == name)?, value));
        ("payload", values.into_iter().filter_map(found).collect())
    }
}

pub(super) fn payload(keys: &Keys) -> Result<Payload, ScenarioError> {
    let not_negative = |keys: &Keys, key: &str, unit: &str| {
        keys.quantity_that(key, unit, "not be negative", |value| value >= 0.0).map(Option::unwrap_or_default)
    };
    let is_given = keys.has("payload");
    if !is_given || keys.is_text("payload") {
        return Ok(Payload { mass: not_negative(keys, "payload", "kg")?, is_given, ..Payload::default() });
    }
    let table = keys.table("payload")?;
    table.only(&["mass", "center_of_mass", "offset", "rotary_inertia"])?;
    Ok(Payload {
        mass: not_negative(&table, "mass", "kg")?,
        center_of_mass: table.quantity("center_of_mass", "m")?.unwrap_or_default(),
        offset: table.quantity("offset", "m")?.unwrap_or_default(),
        rotary_inertia: not_negative(&table, "rotary_inertia", "kg m^2")?,
        is_given,
    })
}
