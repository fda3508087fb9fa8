//! A loss at another frequency than it was calibrated at.
//!
//! A release swings at one frequency and determines the loss there. Rayleigh's law makes more of it than is known: the
//! damping ratio of stiffness damping goes with the frequency, that of mass damping against it. What solids lose in a
//! cycle hardly depends on the frequency (Kimball and Lovell 1927, Physical Review 30, 948-959, for eighteen of them),
//! and in elastomers above their glass transition the loss factor goes with a power of it of 0.1 to 0.3 (Ferry 1980,
//! Viscoelastic Properties of Polymers, ch. 2). So where a calibration has fitted one of Rayleigh's two numbers, and the
//! rod swings at another frequency, its damping ratio is taken to go with the frequency to the power p, normal about zero
//!
//! ```text
//! beta = beta_0 (ω_0/ω)^(1 − p),   alpha = alpha_0 (ω_0/ω)^(−1 − p)
//! ```
//!
//! p has the deviation of [`POWER`]. Where both numbers were fitted, their errors say what is known of the power. Every
//! command that takes a calibrated rod takes its loss so, with p = 0; a prediction draws p as well.

use std::f64::consts::TAU;

use models::model::Model;
use models::muscle::Known;
use models::quantity::format_si;
use models::statics::{equilibrium, modes};

use super::Case;
use super::plan::Plan;

/// Standard deviation of the power with which a damping ratio goes with the frequency: the laws above lie within two,
/// those of Rayleigh four away.
pub const POWER: f64 = 0.25;

/// Rayleigh's laws: the effect, its number, and the power with which its damping ratio goes with the frequency.
const LAWS: [(&str, &str, f64); 2] = [
    ("rayleigh_mass", "effects.rayleigh_mass.alpha", -1.0),
    ("rayleigh_stiffness", "effects.rayleigh_stiffness.beta", 1.0),
];

/// One of Rayleigh's numbers at the frequency of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// Path of the number.
    pub path: &'static str,
    /// Its value here over the one that was calibrated, at p = 0.
    pub factor: f64,
    /// Standard deviation of the logarithm of that.
    pub deviation: f64,
    /// Frequency at which it was calibrated, and that of the model, Hz.
    pub frequency_hz: [f64; 2],
}

impl Loss {
    /// Of a model; none where both or none of the numbers were fitted, or at frequencies that were calibrated.
    pub fn of(known: &Known, model: &Model) -> Option<Self> {
        let is_fitted = |path: &str| known.parameter.iter().any(|own| own.path == path && own.value > 0.0);
        let fitted: Vec<_> = LAWS.iter().filter(|(_, path, _)| is_fitted(path)).collect();
        let [(_, path, power)] = fitted[..] else { return None };
        let [low, high] = known.misfit?.frequency_hz?;
        let rest = equilibrium(model, None).ok()?;
        let here = modes(model, &rest, 1).ok()?.first()?.angular_frequency / TAU;
        let calibrated = here.clamp(low, high);
        let away = (calibrated / here).ln();
        (away != 0.0).then(|| Self {
            path,
            factor: (power * away).exp(),
            deviation: POWER * away.abs(),
            frequency_hz: [calibrated, here],
        })
    }

    /// What should be known of it, in words; `value` is the calibrated number. None where no digit of it changes.
    pub fn words(&self, value: f64, unit: &str) -> Option<String> {
        let [calibrated, here] = self.frequency_hz;
        let [taken, given] = [self.factor * value, value].map(|value| format_si(value, unit));
        let words = format!(
            "calibrated at {calibrated:.3} Hz and used at {here:.3} Hz: {} is taken as {taken} instead of {given}, so that as much is lost in a cycle as there",
            self.path,
        );
        (taken != given).then_some(words)
    }
}

impl Case {
    /// The case of a calibrated rod with its loss at its own frequency, and that said. A number that is not the calibration's
    /// stays.
    pub(super) fn with_loss(mut self, plan: &Plan) -> Self {
        let loss = plan.known.as_ref().and_then(|known| Some((known, Loss::of(known, &self.model)?)));
        let Some((known, loss)) = loss else { return self };
        let Ok(k) = self.model.index(loss.path) else { return self };
        let value = self.model.theta[k];
        let is_calibrated = if plan.muscle.is_some() {
            let is_own = |(_, path, _): &&(&str, &str, f64)| *path == loss.path;
            let effect = LAWS.iter().find(is_own).map_or("", |(effect, ..)| effect);
            plan.effects.iter().all(|(name, _)| *name != effect)
        } else {
            known.parameter.iter().any(|own| own.path == loss.path && own.value == value)
        };
        if is_calibrated {
            self.model.theta[k] = loss.factor * value;
            self.warnings.extend(loss.words(value, self.model.parameters[k].unit));
            self.loss = Some(loss);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use models::muscle::{CalibratedParameter, Misfit};

    use super::*;

    fn known(paths: &[&str], frequency_hz: [f64; 2]) -> Known {
        let parameter = |path: &&str| CalibratedParameter {
            path: (*path).to_owned(),
            value: 0.01,
            ..CalibratedParameter::default()
        };
        Known {
            misfit: Some(Misfit { frequency_hz: Some(frequency_hz), ..Misfit::default() }),
            parameter: paths.iter().map(parameter).collect(),
            ..Known::default()
        }
    }

    /// The ratio of a mode is `alpha/(2ω) + beta ω/2` (any textbook): with the factor it is as at the other frequency.
    #[test]
    fn a_cycle_loses_as_much_at_another_frequency() {
        let model = muscle_at_15_psi();
        for (_, path, power) in LAWS {
            let there = Loss::of(&known(&[path], [20.0, 30.0]), &model).unwrap();
            let [calibrated, here] = there.frequency_hz;
            assert_eq!(calibrated, 20.0);
            assert!(there.words(0.01, "s").is_some_and(|words| words.contains("instead of")));
            // A factor that no digit shows is no news.
            assert_eq!(Loss { factor: 1.0 + 1e-6, ..there.clone() }.words(0.01, "s"), None);
            assert!((there.factor * (here / calibrated).powf(power) - 1.0).abs() < 1e-12);
            assert!((there.deviation - POWER * (20.0 / here).ln()).abs() < 1e-12);
        }
    }

    #[test]
    fn what_was_calibrated_stays() {
        let model = muscle_at_15_psi();
        let [mass, stiffness] = LAWS.map(|(_, path, _)| path);
        assert_eq!(Loss::of(&known(&[stiffness], [0.1, 100.0]), &model), None);
        assert_eq!(Loss::of(&known(&[mass, stiffness], [20.0, 30.0]), &model), None);
        assert_eq!(Loss::of(&known(&["rod.bending_stiffness"], [20.0, 30.0]), &model), None);
    }
}
