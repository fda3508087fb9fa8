//! What may be missing: the effects of the catalogue, each as a way to move the prediction.

use models::effects::{About, Effect, Kind, Parameter as EffectParameter, Place, Reach, Rod};
use models::error::ModelError;
use models::muscle::Known;

use super::DiagnosisSettings;
use super::verdict::ParameterValue;
use crate::calibrate::joint::Estimate;
use crate::calibrate::unknowns::FARTHEST;
use crate::calibrate::{CalibrateError, FittedParameter, Prior, Problem, Scale, Scope, Trial};

/// An effect with what it depends on nonlinearly held at one value.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub effect: &'static dyn Effect,
    /// The parameter that switches it off.
    pub strength: &'static EffectParameter,
    /// Where that vanishes.
    pub null_value: f64,
    /// Parameters of which several values are tried, at one of them.
    /// Those of which a diagnosis knows what to believe are fitted in the end, the others stay there.
    pub tried: Vec<(&'static EffectParameter, f64)>,
    /// What shares one strength.
    pub scope: Scope,
    /// The rod that it acts on, by which its believed values are measured.
    pub rod: Rod<f64>,
    /// Ranges of its parameters that the experiment states.
    pub stated: Vec<(&'static str, (f64, f64))>,
}

impl Candidate {
    /// The same with a strength for each pressure, if it is an effect of the rod's material, which pressure
    /// changes.
    pub fn of_each_pressure(&self) -> Option<Self> {
        let is_material = self.effect.about().places.contains(&Place::Bend);
        (self.scope == Scope::Shared && is_material)
            .then(|| Self { scope: Scope::PerPressure, ..self.clone() })
    }

    /// Whether it has a strength for each pressure though one for all would be natural.
    pub fn is_widened(&self) -> bool {
        self.scope == Scope::PerPressure && self.effect.about().reach == Reach::Muscle
    }

    pub fn name(&self) -> &'static str {
        self.effect.about().name
    }

    /// Whether one of its parameters is where it is not believed to be; the strength apart, which says how much there is.
    pub fn is_beyond_belief(&self, values: &[ParameterValue]) -> bool {
        self.tried.iter().filter(|(own, _)| own.plausible.is_some()).any(|(own, _)| {
            let (low, high) = self.range(own);
            values.iter().any(|value| value.name == own.name && !(low..=high).contains(&value.value))
        })
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

    /// What is believed of the strength of a release, where each has its own.
    pub fn belief(&self) -> Option<Prior> {
        let (low, high) = self.believed();
        let widest = (high - self.null_value).max(self.null_value - low);
        let is_own = self.scope == Scope::PerRelease && widest.is_finite();
        is_own.then_some(Prior { mean: self.null_value, deviation: 0.5 * widest })
    }

    /// Widens the believed range of each of its parameters that a fit ended at, tenfold and up to what is admissible;
    /// whether there was one. Where the effect is off it is at no bound.
    fn widen(&self, problem: &mut Problem, known: &[Estimate]) -> bool {
        let mut is_wider = false;
        for of in self.effect.about().parameters {
            let path = format!("effects.{}.{}", self.name(), of.name);
            let Some(own) = problem.parameters.iter_mut().find(|own| own.path == path) else { continue };
            let Some((low, high)) = own.bounds else { continue };
            for known in
                known.iter().filter(|known| known.unknown.name == path && known.unknown.is_at_bound(known.x))
            {
                let value = known.value();
                if Some(value) == of.null_value {
                    continue;
                }
                let wider = self.wider(of, (low, high), value);
                is_wider |= wider != (low, high);
                own.bounds = Some(wider);
            }
        }
        is_wider
    }

    /// A range of a parameter that is wider towards a value, tenfold and up to what is admissible.
    fn wider(&self, of: &EffectParameter, (low, high): (f64, f64), value: f64) -> (f64, f64) {
        let wider = match value - low < high - value {
            true if low < 0.0 => (10.0 * low, high),
            true => (0.1 * low, high),
            false => (low, 10.0 * high),
        };
        let (least, most) = self.farthest(of);
        (wider.0.max(least), wider.1.min(most))
    }

    /// Bounds and start of the strength in a fit. If the score's estimate is outside the believed range, the bounds are wider. A strength
    /// of each release starts where the effect is off.
    fn begin(&self, estimate: f64) -> ((f64, f64), f64) {
        let believed @ (low, high) = self.believed();
        if self.scope == Scope::PerRelease {
            return (believed, self.null_value);
        }
        let is_believed = (low..=high).contains(&estimate);
        let bounds = if is_believed { believed } else { self.wider(self.strength, believed, estimate) };
        (bounds, estimate.clamp(bounds.0, bounds.1))
    }

    /// The same trial with the effect at the strength where a fit starts.
    pub fn begun(&self, trial: &Trial, estimate: f64) -> Result<Trial, ModelError> {
        self.on(trial, self.begin(estimate).1)
    }

    /// The widest range of a parameter. A stated range stays. A parameter of the setup may be [`FARTHEST`] deviations off; its believed
    /// range holds two to each side.
    fn farthest(&self, of: &EffectParameter) -> (f64, f64) {
        if let Some(stated) = self.stated_range(of) {
            return stated;
        }
        let (low, high) = of.range;
        if of.plausible.is_none() || !self.is_of_setup(of) {
            return (low, high);
        }
        let (least, most) = believed(of, &self.rod);
        let (middle, half) = (0.5 * (least + most), 0.25 * FARTHEST * (most - least));
        ((middle - half).max(low), (middle + half).min(high))
    }

    /// Whether a parameter is part of the setup: those of a measurement, and the time in which a hand lets go. With a longer time the
    /// force of the hand resembles a slow loss.
    fn is_of_setup(&self, of: &EffectParameter) -> bool {
        let about = self.effect.about();
        about.kind == Kind::Measurement || about.reach == Reach::Release && of.null_value.is_none()
    }

    /// What a fit finds, made anew with wider ranges while it ends at one; none where it cannot be made.
    pub fn within_ranges<T>(
        &self,
        mut problem: Problem,
        mut fit: impl FnMut(&Problem) -> Result<Option<(T, Vec<Estimate>)>, CalibrateError>,
    ) -> Result<Option<T>, CalibrateError> {
        loop {
            let Some((found, known)) = fit(&problem)? else { return Ok(None) };
            if !self.widen(&mut problem, &known) {
                return Ok(Some(found));
            }
        }
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

    /// The problem with the effect in it and its parameters among the unknowns; one that is in it gets the
    /// scope of this. `estimate` is where the strength begins.
    pub fn added_to(&self, problem: &Problem, estimate: f64) -> Result<Problem, ModelError> {
        let scope = self.scope;
        let (bounds, start) = self.begin(estimate);
        let mut problem = problem.clone();
        let path = self.path();
        if let Some(own) = problem.parameters.iter_mut().find(|parameter| parameter.path == path) {
            own.scope = scope;
            return Ok(problem);
        }
        for trial in problem.trials_mut() {
            *trial = self.on(trial, self.null_value)?;
        }
        problem.parameters.push(FittedParameter {
            start: Some(start),
            bounds: Some(bounds),
            prior: self.belief(),
            scale: Some(Scale::Linear),
            ..FittedParameter::new(&path, scope)
        });
        for (parameter, value) in self.tried.iter().filter(|(parameter, _)| parameter.plausible.is_some()) {
            let (low, high) = self.range(parameter);
            problem.parameters.push(FittedParameter {
                start: Some(value.clamp(low, high)),
                bounds: Some((low, high)),
                // A size that may as well be zero is believed to be small: half a normal distribution, of which the range
                // holds two deviations. Without it a place and a mass that change the frequency alike end anywhere.
                prior: (low == 0.0).then_some(Prior { mean: 0.0, deviation: 0.5 * high }),
                scale: Some(if low > 0.0 { Scale::Logarithmic } else { Scale::Linear }),
                ..FittedParameter::new(&format!("effects.{}.{}", self.name(), parameter.name), Scope::Shared)
            });
        }
        Ok(problem)
    }
}

/// Whether releases at several pressures are fitted.
pub(crate) fn has_several_pressures(problem: &Problem) -> bool {
    let fitted = problem.trials.iter().filter(|trial| !trial.release.held_out);
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

/// The candidates for a problem: every cause in the catalogue of its models, laws as text included, that they do not have
/// already, but for those that the settings exclude.
pub(crate) fn candidates(problem: &Problem, settings: &DiagnosisSettings) -> Vec<Candidate> {
    let mut all = Vec::new();
    let Some(model) = problem.trials.first().map(|trial| &trial.model) else { return all };
    let rod = model.rod();
    let is_pressure_varied = has_several_pressures(problem);
    for effect in model.catalogue.iter() {
        let about = effect.about();
        let is_excluded = settings.excluded.iter().any(|name| name == about.name);
        if problem.has(about.name) || is_excluded || about.kind == Kind::Description {
            continue;
        }
        let mut tried: Vec<Vec<(&'static EffectParameter, f64)>> = vec![Vec::new()];
        let is_tried = |parameter: &&EffectParameter| {
            !parameter.tries.is_empty() && parameter.tries_beside.is_none_or(|beside| problem.has(beside))
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
