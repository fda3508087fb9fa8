//! What may be missing: the effects of the catalogue, each as a way to move the prediction.

use models::effects::{About, Effect, Kind, Parameter as EffectParameter, Place, Reach, Rod};
use models::error::ModelError;
use models::muscle::Known;

use super::DiagnosisSettings;
use crate::calibrate::{Scope, Trial};

/// An effect with what it depends on nonlinearly held at one value.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub effect: &'static dyn Effect,
    /// The parameter that switches it off.
    pub strength: &'static EffectParameter,
    /// Where that vanishes.
    pub null_value: f64,
    /// Parameters of which several values are tried, at one of them.
    /// Those with a plausible range are fitted in the end, the others stay there.
    pub tried: Vec<(&'static EffectParameter, f64)>,
    /// What shares one strength.
    pub scope: Scope,
    /// The rod that it acts on, which scales its plausible values.
    pub rod: Rod<f64>,
    /// Ranges of its parameters that the experiment states.
    pub stated: Vec<(&'static str, (f64, f64))>,
}

impl Candidate {
    /// The same with a strength for each pressure, if it is an effect of the rod's material, which pressure changes. A law that
    /// says itself how pressure changes it has one already.
    pub fn of_each_pressure(&self) -> Option<Self> {
        let about = self.effect.about();
        let says_how = about.parameters.iter().any(|own| own.unit == "Pa");
        let is_material = about.places.contains(&Place::Bend) && !says_how;
        (self.scope == Scope::Shared && is_material)
            .then(|| Self { scope: Scope::PerPressure, ..self.clone() })
    }

    pub fn name(&self) -> &'static str {
        self.effect.about().name
    }

    /// Believable values of the strength.
    pub fn believed(&self) -> (f64, f64) {
        self.range(self.strength)
    }

    /// Believable values of one of its parameters.
    pub fn range(&self, of: &EffectParameter) -> (f64, f64) {
        self.stated_range(of).unwrap_or_else(|| believed(of, &self.rod))
    }

    fn stated_range(&self, of: &EffectParameter) -> Option<(f64, f64)> {
        self.stated.iter().find(|(name, _)| *name == of.name).map(|(_, range)| *range)
    }

    /// The path of the strength.
    pub fn path(&self) -> String {
        format!("effects.{}.{}", self.name(), self.strength.name)
    }

    /// The same trial with the effect at a strength.
    pub fn on(&self, trial: &Trial, strength: f64) -> Result<Trial, ModelError> {
        let mut values = vec![(self.strength.name, strength)];
        values.extend(self.tried.iter().map(|(parameter, value)| (parameter.name, *value)));
        trial.with_effect(self.name(), &values)
    }
}

/// Whether releases at several pressures are fitted.
pub(super) fn has_several_pressures(trials: &[Trial]) -> bool {
    let fitted = trials.iter().filter(|trial| !trial.release.held_out);
    let [lowest, highest] = Known::span(fitted.filter_map(|trial| trial.release.pressure));
    lowest < highest
}

fn believed(parameter: &EffectParameter, rod: &Rod<f64>) -> (f64, f64) {
    let (low, high) = parameter.range;
    let unit = parameter.per.of(rod);
    parameter
        .plausible
        .map_or((low, high), |(least, most)| ((least * unit).max(low), (most * unit).min(high)))
}

/// What switches an effect off, with the value that does: the first such parameter, or each of those that are
/// parts of it, beside which the others are fitted. A part that grows with the pressure shows itself at several.
fn strengths(about: &About, is_pressure_varied: bool) -> Vec<(&'static EffectParameter, f64)> {
    let switches = about.parameters.iter().filter_map(|parameter| Some((parameter, parameter.null_value?)));
    let is_shown = |part: &EffectParameter| is_pressure_varied || !part.unit.contains("Pa");
    let is_believed =
        |(part, _): &(&EffectParameter, f64)| part.is_part && part.plausible.is_some() && is_shown(part);
    let parts: Vec<_> = switches.clone().filter(is_believed).collect();
    if parts.is_empty() { switches.take(1).collect() } else { parts }
}

/// The candidates beside models: every cause in their catalogue, laws as text included, that they do not have
/// already, but for those that the settings exclude.
pub(crate) fn candidates(trials: &[Trial], settings: &DiagnosisSettings) -> Vec<Candidate> {
    let mut all = Vec::new();
    let Some(model) = trials.first().map(|trial| &trial.model) else { return all };
    let rod = model.rod();
    let has = |effect: &str| trials.iter().any(|trial| trial.model.effect(effect).is_some());
    let is_pressure_varied = has_several_pressures(trials);
    for effect in model.catalogue.iter() {
        let about = effect.about();
        let is_excluded = settings.excluded.iter().any(|name| name == about.name);
        if has(about.name) || is_excluded || about.kind == Kind::Description {
            continue;
        }
        let mut tried: Vec<Vec<(&'static EffectParameter, f64)>> = vec![Vec::new()];
        let is_tried = |parameter: &&EffectParameter| {
            !parameter.tries.is_empty() && parameter.tries_beside.is_none_or(has)
        };
        for parameter in about.parameters.iter().filter(is_tried) {
            tried = tried
                .iter()
                .flat_map(|before| {
                    parameter.tries.iter().map(move |value| {
                        let mut values = before.clone();
                        values.push((parameter, value * parameter.per.of(&rod)));
                        values
                    })
                })
                .collect();
        }
        let strengths = strengths(about, is_pressure_varied);
        let stated = |own: &EffectParameter| {
            let path = format!("effects.{}.{}", about.name, own.name);
            settings.ranges.iter().find(|(stated, _)| *stated == path).map(|(_, range)| (own.name, *range))
        };
        let stated: Vec<(&'static str, (f64, f64))> = about.parameters.iter().filter_map(stated).collect();
        for (strength, null_value) in strengths.clone() {
            let parts = strengths.iter().copied().filter(|(part, _)| part.name != strength.name);
            let with_parts = |tried: &Vec<_>| tried.iter().copied().chain(parts.clone()).collect();
            let tried = tried.iter().map(with_parts);
            let scope = match about.reach {
                Reach::Muscle => Scope::Shared,
                Reach::Pressure => Scope::PerPressure,
                Reach::Release => Scope::PerRelease,
            };
            all.extend(tried.map(|tried| Candidate {
                effect,
                strength,
                null_value,
                tried,
                scope,
                rod,
                stated: stated.clone(),
            }));
        }
    }
    all
}
