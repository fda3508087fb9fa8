//! Unknowns of a hypothesis: each is one standard normal number with a proper prior.
//!
//! `z` is how many prior standard deviations an unknown is off its prior mean. Strengths of one sign have half a normal prior.

use models::quantity::format_si;

use crate::calibrate::Trial;

/// What an unknown is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// Part of what the experiment states, or of its setup; the word names the statement that may be freed.
    Setup(&'static str),
    /// Strength of an effect of the catalogue; zero of it is none.
    Strength,
    /// Another parameter of such an effect.
    Shape,
}

/// How `z` becomes a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scaled {
    /// The model's own value, shifted by so much for one standard deviation.
    Shift(f64),
    /// The model's own value, times `exp(deviation z)`.
    Factor(f64),
    /// A normal distribution of mean and deviation.
    Normal(f64, f64),
    /// A log-normal distribution of median and deviation of the logarithm.
    LogNormal(f64, f64),
}

impl Scaled {
    /// The value, where the model alone would have `own`.
    pub fn value(self, own: f64, z: f64) -> f64 {
        match self {
            Self::Shift(deviation) => own + deviation * z,
            Self::Factor(deviation) => own * (deviation * z).exp(),
            Self::Normal(mean, deviation) => mean + deviation * z,
            Self::LogNormal(median, deviation) => median * (deviation * z).exp(),
        }
    }

    /// Derivative of the value by `z`.
    pub fn slope(self, own: f64, z: f64) -> f64 {
        match self {
            Self::Shift(deviation) | Self::Normal(_, deviation) => deviation,
            Self::Factor(deviation) | Self::LogNormal(_, deviation) => deviation * self.value(own, z),
        }
    }

    /// Where a value is; zero for one that the distribution cannot have.
    pub fn place(self, own: f64, value: f64) -> f64 {
        let place = match self {
            Self::Shift(deviation) => (value - own) / deviation,
            Self::Factor(deviation) => (value / own).ln() / deviation,
            Self::Normal(mean, deviation) => (value - mean) / deviation,
            Self::LogNormal(median, deviation) => (value / median).ln() / deviation,
        };
        if place.is_finite() { place } else { 0.0 }
    }

    /// The same distribution with a wider prior.
    fn wider(self, factor: f64) -> Self {
        match self {
            Self::Shift(deviation) => Self::Shift(factor * deviation),
            Self::Factor(deviation) => Self::Factor(factor * deviation),
            Self::Normal(mean, deviation) => Self::Normal(mean, factor * deviation),
            Self::LogNormal(median, deviation) => Self::LogNormal(median, factor * deviation),
        }
    }
}

/// How an unknown acts on one release.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// On parameters of its model.
    Theta(Vec<usize>),
    /// On the instant of release, s: the recording's zero is so much before it.
    Instant,
    /// On all its tracks, along an axis of W, m.
    Offset(usize),
    /// On the place of one track along the rod, a share of its length; the track by its place in the plan.
    Place(usize),
}

/// One unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    pub label: String,
    pub unit: &'static str,
    pub role: Role,
    pub scaled: Scaled,
    /// Whether its prior is half a normal distribution, `z ≥ 0`.
    pub is_half: bool,
    /// Values that are admitted.
    pub limits: (f64, f64),
    /// The releases on which it acts.
    pub acts: Vec<(usize, Act)>,
    /// The pressure that it belongs to, Pa, where each has its own.
    pub pressure: Option<f64>,
    /// Whether it belongs to one release alone.
    pub is_own: bool,
    /// Where a search begins.
    pub start: f64,
}

impl Unknown {
    /// A normal unknown of the setup that acts on nothing yet.
    pub fn setup(statement: &'static str, label: &str, unit: &'static str, scaled: Scaled) -> Self {
        Self {
            label: label.to_owned(),
            unit,
            role: Role::Setup(statement),
            scaled,
            is_half: false,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            acts: Vec::new(),
            pressure: None,
            is_own: false,
            start: 0.0,
        }
    }

    /// The value in a release whose model has `own`, within what is admitted.
    pub fn value(&self, own: f64, z: f64) -> f64 {
        let (low, high) = self.limits;
        self.scaled.value(own, z).max(low).min(high)
    }

    /// Derivative of the value by `z`; zero beyond what is admitted.
    pub fn slope(&self, own: f64, z: f64) -> f64 {
        let (low, high) = self.limits;
        let value = self.scaled.value(own, z);
        if (low..=high).contains(&value) { self.scaled.slope(own, z) } else { 0.0 }
    }

    /// The same with a wider prior, and where it begins so that its value stays.
    pub fn freed(&self, factor: f64) -> Self {
        Self { scaled: self.scaled.wider(factor), start: self.start / factor, ..self.clone() }
    }

    /// Whether it acts on any of the first releases, which are those that are fitted.
    pub fn is_of_any(&self, fitted: usize) -> bool {
        self.acts.iter().any(|(r, _)| *r < fitted)
    }

    /// Path of the parameter on which it acts; none of what is no parameter of a model.
    pub fn path<'a>(&self, trials: &'a [Trial]) -> Option<&'a str> {
        let (r, Act::Theta(places)) = self.acts.first()? else { return None };
        Some(&trials.get(*r)?.model.parameters.get(*places.first()?)?.path)
    }

    /// The release or pressure that it belongs to, where each has its own.
    pub fn of(&self, trials: &[Trial]) -> Option<String> {
        match (&self.acts[..], self.pressure) {
            (_, Some(pressure)) => Some(format_si(pressure, "Pa")),
            ([(r, _)], None) if self.is_own && trials.len() > 1 => Some(trials[*r].release.name.clone()),
            _ => None,
        }
    }

    /// Own value of the model of the first release on which it acts.
    pub fn own(&self, trials: &[Trial]) -> f64 {
        match self.acts.first() {
            Some((r, Act::Theta(places))) => {
                places.first().and_then(|k| trials.get(*r)?.model.theta.get(*k)).copied().unwrap_or(0.0)
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slope is that of the value, and the place its inverse, for each distribution.
    #[test]
    fn slopes_and_places_belong_to_values() {
        let all =
            [Scaled::Shift(0.3), Scaled::Factor(0.3), Scaled::Normal(2.0, 0.3), Scaled::LogNormal(2.0, 0.3)];
        for scaled in all {
            let (own, z) = (1.5, 0.7);
            let slope = (scaled.value(own, z + 1e-6) - scaled.value(own, z - 1e-6)) / 2e-6;
            assert!((scaled.slope(own, z) - slope).abs() < 1e-8, "{scaled:?}");
            assert!((scaled.place(own, scaled.value(own, z)) - z).abs() < 1e-12, "{scaled:?}");
            let wider = scaled.wider(10.0);
            assert!((wider.value(own, z / 10.0) - scaled.value(own, z)).abs() < 1e-12, "{scaled:?}");
        }
        assert_eq!(Scaled::Factor(0.1).place(0.0, 1.0), 0.0);
    }
}
