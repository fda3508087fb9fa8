//! What may be missing: effects of the catalogue and statements that may be wrong, as hypotheses that extend another one.

use std::f64::consts::LN_2;

use models::effects::Parameter;
use models::error::ModelError;

use super::DiagnosisSettings;
use super::candidate::{Candidate, candidates, has_several_pressures};
use super::hypothesis::Hypothesis;
use super::setup::{FREED, by_pressure, freed, labelled};
use super::unknown::{Act, Role, Scaled, Unknown};
use crate::calibrate::Scope;

/// Standard deviations of a prior in a range that the catalogue takes for plausible, to each side.
const DEVIATIONS: f64 = 2.0;
/// Deviation of a strength of which the catalogue has no range, over its typical size.
const TYPICAL: f64 = 3.0;
/// Shapes that may be zero are at least this share of their range: a time of zero would be another law.
const LEAST_SHAPE: f64 = 1e-3;

/// One way to extend a hypothesis.
#[derive(Clone)]
pub struct Extension {
    /// Name of the effect, or of the statement.
    pub name: String,
    pub hypothesis: Hypothesis,
    /// Places of the strengths among the unknowns; none of a freed statement.
    pub strengths: Vec<usize>,
    /// By how much priors of a freed statement are wider.
    pub wider: f64,
    /// Logarithm of its prior odds beside the effects of the catalogue.
    pub odds: f64,
}

impl Extension {
    /// Name of the effect, however its strengths are shared.
    pub fn effect(&self) -> &str {
        self.name.strip_suffix(OF_EACH).unwrap_or(&self.name)
    }
}

/// Prior odds of a statement that is wrong against a missing effect, a logarithm: whoever states a value has measured it.
const STATEMENT_ODDS: f64 = -3.0;

/// What the name of an effect of the rod's material is followed by where it has a strength for each pressure.
const OF_EACH: &str = ", by pressure";

/// Extensions that are one model at equal strengths.
pub struct Group {
    /// The effect, at one of its tries; none of a statement.
    pub candidate: Option<Candidate>,
    pub extensions: Vec<Extension>,
}

/// All effects that a hypothesis has not, each with each of its tries. One of the rod's material is there twice, the second time with
/// a strength for each pressure, which changes the material.
pub fn effects(of: &Hypothesis, settings: &DiagnosisSettings) -> Vec<Group> {
    let is_varied = has_several_pressures(&of.trials);
    let both = |candidate: &Candidate| {
        let shared = extension(of, candidate).ok()?;
        let of_each = candidate.of_each_pressure().filter(|_| is_varied);
        let Some(of_each) = of_each.and_then(|own| extension(of, &own).ok()) else {
            return Some(vec![shared]);
        };
        // Both have a half of an effect's prior odds.
        let of_each = Extension { name: format!("{}{OF_EACH}", of_each.name), odds: -LN_2, ..of_each };
        Some(vec![Extension { odds: -LN_2, ..shared }, of_each])
    };
    let group = |candidate| Some(Group { extensions: both(&candidate)?, candidate: Some(candidate) });
    candidates(&of.trials, settings).into_iter().filter_map(group).collect()
}

/// All statements that may be freed.
pub fn statements(of: &Hypothesis) -> Vec<Group> {
    let extension = |(name, factor): (&'static str, f64)| {
        let extension = Extension {
            name: name.to_owned(),
            hypothesis: freed(of, name, factor)?,
            strengths: Vec::new(),
            wider: factor,
            odds: STATEMENT_ODDS,
        };
        Some(Group { candidate: None, extensions: vec![extension] })
    };
    FREED.into_iter().filter_map(extension).collect()
}

/// A hypothesis with a candidate beside.
pub fn extension(of: &Hypothesis, candidate: &Candidate) -> Result<Extension, ModelError> {
    let (name, off) = (candidate.name(), candidate.null_value);
    let mut hypothesis = of.clone();
    for trial in &mut hypothesis.trials {
        *trial = candidate.on(trial, off)?;
    }
    let releases: Vec<usize> = (0..of.trials.len()).collect();
    let owners = match candidate.scope {
        Scope::Shared => vec![(None, releases.clone())],
        Scope::PerPressure => by_pressure(&of.trials),
        Scope::PerRelease => releases.iter().map(|r| (None, vec![*r])).collect(),
    };
    let (low, high) = candidate.believed();
    let first = hypothesis.unknowns.len();
    for (pressure, owner) in &owners {
        let (deviation, is_half) = strength(candidate.strength, off, (low, high));
        let unknown = Unknown {
            label: labelled(candidate.strength.name, *pressure),
            unit: candidate.strength.unit,
            role: Role::Strength,
            scaled: Scaled::Normal(off, deviation),
            is_half,
            limits: candidate.strength.range,
            acts: Vec::new(),
            pressure: *pressure,
            is_own: candidate.scope == Scope::PerRelease,
            start: 0.0,
        };
        add(&mut hypothesis, unknown, &candidate.path(), owner)?;
    }
    let strengths = (first..hypothesis.unknowns.len()).collect();
    for (parameter, value) in candidate.tried.iter().filter(|(parameter, _)| parameter.plausible.is_some()) {
        let path = format!("effects.{name}.{}", parameter.name);
        let range = candidate.range(parameter);
        add(&mut hypothesis, shape(parameter, *value, range), &path, &releases)?;
    }
    Ok(Extension { name: name.to_owned(), hypothesis, strengths, wider: 1.0, odds: 0.0 })
}

/// A hypothesis with many effects beside, all of them off: each has one strength for all releases, in the order of the groups.
pub fn all_off(of: &Hypothesis, groups: &[&Group]) -> Result<Hypothesis, ModelError> {
    let mut all = of.clone();
    let releases: Vec<usize> = (0..of.trials.len()).collect();
    for group in groups {
        let (Some(candidate), Some(own)) = (&group.candidate, group.extensions.first()) else { continue };
        for trial in &mut all.trials {
            *trial = candidate.on(trial, candidate.null_value)?;
        }
        let strength = own.hypothesis.unknowns[own.strengths[0]].clone();
        add(&mut all, Unknown { acts: Vec::new(), ..strength }, &candidate.path(), &releases)?;
    }
    Ok(all)
}

/// Deviation of a strength's prior, with its sign, and whether it has one side only.
fn strength(of: &Parameter, off: f64, (low, high): (f64, f64)) -> (f64, bool) {
    if of.plausible.is_none() {
        return (TYPICAL * of.scale, of.range.0 >= off);
    }
    let (up, down) = (high - off, off - low);
    let widest = up.max(down) / DEVIATIONS;
    if low >= off {
        (widest, true)
    } else if high <= off {
        (-widest, true)
    } else {
        (widest, false)
    }
}

/// Another parameter of an effect: log-normal over a range of positive values, half-normal from zero, else normal. A range that
/// begins where the law does begins at zero.
fn shape(of: &Parameter, value: f64, (low, high): (f64, f64)) -> Unknown {
    let low = if of.range.0 >= 0.0 && low <= of.range.0 { 0.0 } else { low };
    let (scaled, is_half) = if low > 0.0 {
        (Scaled::LogNormal((low * high).sqrt(), (high / low).ln() / (2.0 * DEVIATIONS)), false)
    } else if low == 0.0 {
        (Scaled::Normal(0.0, high / DEVIATIONS), true)
    } else {
        (Scaled::Normal(0.5 * (low + high), (high - low) / (2.0 * DEVIATIONS)), false)
    };
    let least = if low == 0.0 { LEAST_SHAPE * high } else { of.range.0 };
    Unknown {
        label: of.name.to_owned(),
        unit: of.unit,
        role: Role::Shape,
        scaled,
        is_half,
        limits: (least.max(of.range.0), of.range.1),
        acts: Vec::new(),
        pressure: None,
        is_own: false,
        start: scaled.place(0.0, value),
    }
}

fn add(to: &mut Hypothesis, mut unknown: Unknown, path: &str, releases: &[usize]) -> Result<(), ModelError> {
    for r in releases {
        unknown.acts.push((*r, Act::Theta(vec![to.trials[*r].model.index(path)?])));
    }
    to.unknowns.push(unknown);
    Ok(())
}
