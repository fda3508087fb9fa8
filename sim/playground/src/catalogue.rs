//! What a page can set: muscles, the rod's own numbers, and every effect of the catalogue with its page.

use efam_core::models::effects::{CATALOGUE, Parameter, Rod};
use efam_core::models::model::{BASELINE, Model, ModelParameter};
use efam_core::models::muscle::{BUILT_IN, Muscle};
use efam_core::models::quantity::Quantity;
use serde::Serialize;

use crate::error::PlaygroundError;
use crate::setup::{ROD, Setup};

/// All that a page can set.
#[derive(Clone, Debug, Serialize)]
pub struct Catalogue {
    /// 1 psi, Pa.
    pub psi: f64,
    /// The built-in muscles.
    pub muscles: Vec<MuscleEntry>,
    /// The rod's own numbers.
    pub rod: Vec<ParameterEntry>,
    /// The effects.
    pub effects: Vec<EffectEntry>,
}

/// A muscle.
#[derive(Clone, Debug, Serialize)]
pub struct MuscleEntry {
    /// Its name in scenarios.
    pub name: String,
    /// Where its data come from.
    pub source: String,
    /// Pressures of its table, Pa.
    pub pressures: Vec<f64>,
    /// Length, mass, EI, EA and diameter at each of them, SI.
    pub rows: Vec<Vec<f64>>,
}

/// An effect.
#[derive(Clone, Debug, Serialize)]
pub struct EffectEntry {
    /// Its name in scenarios.
    pub name: &'static str,
    /// Its name for people: the head of its page.
    pub title: String,
    /// One sentence.
    pub meaning: &'static str,
    /// elastic, dissipative, inertial, load, measurement or description.
    pub kind: String,
    /// Whether every model has it.
    pub is_baseline: bool,
    /// What it looks like in a recording.
    pub signature: &'static str,
    /// Its page.
    pub page: String,
    /// Its parameters.
    pub parameters: Vec<ParameterEntry>,
}

/// A parameter.
#[derive(Clone, Debug, Serialize)]
pub struct ParameterEntry {
    /// Its key in scenarios.
    pub name: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// SI unit; empty if dimensionless.
    pub unit: &'static str,
    /// Value when its effect is switched on.
    pub default: f64,
    /// Value at which its effect vanishes.
    pub null_value: Option<f64>,
    /// Admissible values.
    pub range: (f64, f64),
    /// Values that a slider offers.
    pub slider: (f64, f64),
}

/// Sizes and defaults that a slider reaches where nobody says what is plausible.
const REACH: [f64; 2] = [5.0, 3.0];

/// The catalogue; sliders fit the paper's muscle in the middle of its table.
pub fn catalogue() -> Result<Catalogue, PlaygroundError> {
    let muscles: Result<Vec<_>, _> = BUILT_IN.iter().map(|(name, _)| Muscle::built_in(name)).collect();
    let muscles: Result<Vec<_>, _> = muscles?.iter().map(muscle).collect();
    let muscles = muscles?;
    let first = &muscles[0];
    let middle = first.pressures[first.pressures.len() / 2];
    let model = Setup { muscle: Some(first.name.clone()), pressure: middle, ..Setup::default() }.model()?;
    let effect = |effect: &&dyn efam_core::models::effects::Effect| {
        let (about, page) = (effect.about(), effect.page());
        let title = page.split([':', '\n']).next().unwrap_or(about.name).to_owned();
        EffectEntry {
            name: about.name,
            title,
            meaning: about.meaning,
            kind: format!("{:?}", about.kind).to_lowercase(),
            is_baseline: BASELINE.contains(&about.name),
            signature: about.signature,
            page,
            parameters: about.parameters.iter().map(|p| of_effect(p, &model.rod())).collect(),
        }
    };
    Ok(Catalogue {
        psi: Quantity::parse("1 psi").map_or(f64::NAN, |psi| psi.si()),
        rod: ROD.iter().filter_map(|(key, _)| of_rod(key, &model)).collect(),
        muscles,
        effects: CATALOGUE.iter().map(effect).collect(),
    })
}

fn muscle(muscle: &Muscle) -> Result<MuscleEntry, PlaygroundError> {
    let row = |pressure: &f64| {
        let setup = Setup { muscle: Some(muscle.name.clone()), pressure: *pressure, ..Setup::default() };
        let Rod { length, mass, bending_stiffness, axial_stiffness, diameter, .. } = setup.model()?.rod();
        Ok(vec![length, mass, bending_stiffness, axial_stiffness, diameter])
    };
    let rows: Result<_, PlaygroundError> = muscle.pressures().iter().map(row).collect();
    Ok(MuscleEntry {
        name: muscle.name.clone(),
        source: muscle.source.clone(),
        pressures: muscle.pressures().to_vec(),
        rows: rows?,
    })
}

fn of_rod(key: &'static str, model: &Model) -> Option<ParameterEntry> {
    let k = model.index(&format!("rod.{key}")).ok()?;
    let ModelParameter { meaning, unit, range, .. } = model.parameters[k];
    let default = model.theta[k];
    Some(ParameterEntry {
        name: key,
        meaning,
        unit,
        default,
        null_value: None,
        range,
        slider: (0.1 * default, REACH[1] * default),
    })
}

fn of_effect(p: &Parameter, rod: &Rod<f64>) -> ParameterEntry {
    let per = p.per.of(rod);
    let most = f64::max(REACH[0] * p.scale, REACH[1] * p.default.abs());
    let (low, high) = match p.plausible {
        Some((low, high)) => (low * per, high * per),
        None if p.range.0 >= 0.0 => (p.range.0, most),
        None => (-most, most),
    };
    // Where it starts and where it vanishes are always in reach.
    let within = |value: f64| value.clamp(p.range.0, p.range.1);
    let all = [low, high, p.default, p.null_value.unwrap_or(p.default)].map(within);
    let slider =
        (all.into_iter().fold(f64::INFINITY, f64::min), all.into_iter().fold(f64::NEG_INFINITY, f64::max));
    ParameterEntry {
        name: p.name,
        meaning: p.meaning,
        unit: p.unit,
        default: p.default,
        null_value: p.null_value,
        range: p.range,
        slider,
    }
}
